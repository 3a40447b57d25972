//! Whether panels are small enough for the surface: the length of a panel times the largest curvature under it.

use super::values::principal_at;
use crate::curvature::{self, CurvatureOptions};
use phex_mesh::{FaceId, HexMesh, TriangleSurface, Vec3};
use serde::Serialize;

/// Largest length times curvature of a panel that resolves the surface. From 1 on the panel is longer than the radius of
/// curvature: the surface turns by more than a radian under it.
pub(super) const BOUND: f64 = 1.0;
/// Where curvature is looked at, over the side of a square of a panel's area: details half as large as a panel count.
const SCALE: f64 = 0.5;

/// `L k_max` of every panel: its diameter (largest distance of two corners) times the largest absolute principal curvature
/// of the surface at its centre and corners. No unit.
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
    /// Measures the panels of a mesh on the surface that they stand for.
    pub fn new(mesh: &HexMesh, surface: &TriangleSurface) -> Self {
        let topology = mesh.topology();
        let side = (surface.area() / topology.n_faces() as f64).sqrt();
        let curvature = curvature::curvature(surface, SCALE * side, &CurvatureOptions::default());
        let mut points = mesh.positions.as_slice().to_vec();
        points.extend(topology.faces().map(|f| mesh.centre(f)));
        let bend: Vec<f64> = surface
            .closest_points(&points)
            .iter()
            .map(|p| principal_at(surface, &curvature, p).large.abs())
            .collect();
        let largest = |f: FaceId| {
            let corners = topology.face_vertices(f).iter().map(|v| bend[v.index()]);
            corners.fold(bend[topology.n_vertices() + f.index()], f64::max)
        };
        let value = |f: FaceId| diameter(mesh, f) * largest(f);
        let per_face: Vec<f64> = topology.faces().map(value).collect();
        let is_coarse = |k: &usize| per_face[*k] > BOUND;
        Self {
            bound: BOUND,
            max: per_face.iter().copied().fold(0.0, f64::max),
            coarse: (0..per_face.len()).filter(is_coarse).collect(),
            per_face,
        }
    }

    /// What to tell the user where panels are too large.
    pub fn warning(&self) -> Option<String> {
        let count = self.coarse.len();
        (count > 0).then(|| {
            format!(
                "the surface has features below the panel size: {count} of {} panels are longer than its radius of curvature \
                 (length times curvature up to {:.2}, bound {})",
                self.per_face.len(),
                self.max,
                self.bound
            )
        })
    }
}

/// Largest distance of two corners.
fn diameter(mesh: &HexMesh, face: FaceId) -> f64 {
    let corners: Vec<Vec3> = mesh
        .topology()
        .face_vertices(face)
        .iter()
        .map(|&v| mesh.position(v))
        .collect();
    let from = |p: &Vec3| corners.iter().map(|q| (p - q).norm()).fold(0.0, f64::max);
    corners.iter().map(from).fold(0.0, f64::max)
}
