//! Whether panels are small enough for the surface: how far the surface turns from one corner of a
//! panel to another.

use crate::curvature::{self, CurvatureOptions};
use crate::quality::Check;
use nalgebra::Matrix3;
use phex_mesh::{FaceId, HexMesh, TriangleSurface, Vec3};
use serde::Serialize;
use std::collections::BTreeSet;

/// Where curvature is looked at, over the side of a square of a panel's area: details half as large
/// as a panel count.
const SCALE: f64 = 0.5;

/// `max L(d) |k(d)|` of every panel, over the directions `d` from one of its corners to another:
/// their distance times the largest absolute normal curvature of the surface in that direction at
/// the panel's centre and corners. No unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FeatureSizes {
    /// Values above this are of panels that are too large for the surface's features.
    pub bound: f64,
    /// The largest value; 0 without panels.
    pub max: f64,
    /// By face.
    pub per_face: Vec<f64>,
    /// Faces above the bound.
    pub coarse: Vec<usize>,
}

impl FeatureSizes {
    /// Largest length times curvature of a panel that resolves the surface. From 1 on the panel is
    /// longer than the radius of curvature in some direction: the surface turns by more than a
    /// radian under it.
    pub const BOUND: f64 = 1.0;

    /// Measures the panels of a mesh on the surface that they stand for.
    pub fn new(mesh: &HexMesh, surface: &TriangleSurface) -> Self {
        let topology = mesh.topology();
        let side = (surface.area() / topology.n_faces() as f64).sqrt();
        let mut points = mesh.positions.as_slice().to_vec();
        points.extend(&mesh.centres());
        let feet = surface.closest_points(&points);
        let options = CurvatureOptions::default();
        let tensors = curvature::tensors_at_points(surface, &feet, SCALE * side, &options);
        let bend: Vec<_> = feet.iter().map(|p| p.normal).zip(tensors).collect();
        let turn = |f: FaceId| {
            let corners = topology.face_vertices(f).iter().map(|v| v.index());
            let there = corners.chain([topology.n_vertices() + f.index()]);
            let arms = arms(mesh, f);
            let largest = |k: usize| arms.iter().map(|a| turned(a, &bend[k])).fold(0.0, f64::max);
            there.map(largest).fold(0.0, f64::max)
        };
        let per_face: Vec<f64> = topology.faces().map(turn).collect();
        let is_coarse = |k: &usize| per_face[*k] > Self::BOUND;
        Self {
            bound: Self::BOUND,
            max: per_face.iter().copied().fold(0.0, f64::max),
            coarse: (0..per_face.len()).filter(is_coarse).collect(),
            per_face,
        }
    }

    /// What to tell the user where panels are too large and the surface is missed there, which the
    /// failed ones of the checks say.
    pub fn warning(&self, checks: &[Check]) -> Option<String> {
        let distances = ["deviation", "coverage_inner"];
        let failed = checks.iter().filter(|c| distances.contains(&c.name));
        let missed: BTreeSet<usize> = failed.flat_map(|c| c.faces.iter().copied()).collect();
        let coarse: Vec<usize> = self
            .coarse
            .iter()
            .copied()
            .filter(|f| missed.contains(f))
            .collect();
        let first = coarse.first()?;
        let largest = coarse.iter().map(|&f| self.per_face[f]).fold(0.0, f64::max);
        Some(format!(
            "the surface has features below the panel size: {} of {} panels miss it and are longer than its radius of curvature in that direction \
             (length times curvature up to {largest:.2}, bound {}; first face {first})",
            coarse.len(),
            self.per_face.len(),
            self.bound
        ))
    }
}

/// Vectors from each corner of a panel to the later ones.
fn arms(mesh: &HexMesh, face: FaceId) -> Vec<Vec3> {
    let corners: Vec<Vec3> = mesh.corners(face).collect();
    let later = |k: usize| corners[k + 1..].iter().map(move |q| (k, q));
    let pairs = (0..corners.len()).flat_map(later);
    pairs.map(|(k, q)| q - corners[k]).collect()
}

/// How far the surface turns along a vector, in radians: its length times the normal curvature in
/// its direction, where normal and shape operator are given.
fn turned(arm: &Vec3, (normal, tensor): &(Vec3, Matrix3<f64>)) -> f64 {
    let along = arm - normal * normal.dot(arm);
    let Some(direction) = along.try_normalize(0.0) else {
        return 0.0;
    };
    arm.norm() * direction.dot(&(tensor * direction)).abs()
}
