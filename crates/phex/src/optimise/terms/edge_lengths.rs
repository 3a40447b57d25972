//! Edge lengths: what an edge pays for not being as long as it is wished to be.
//!
//! Energy `w/2 (l - L)^2` for an edge of length `l = |x_b - x_a|` that is to have `L`, gradient
//! `w (l - L) u` at `b` along the unit vector `u` of the edge, Hessian the Gauss-Newton part
//! `w u u^T`: what it leaves out is `w (l - L) / l` across the edge, less than a hundredth once
//! lengths are nearly those that are wished for.
//!
//! Both ends of an edge are corners of one face, so the term needs no blocks of its own.

use crate::optimise::panels::{Corner, Panels, add_difference};
use nalgebra::Matrix3;
use phex_mesh::{PerEdge, Topology, Vec3};

/// Lengths that edges are to have.
#[derive(Clone, Debug)]
pub(in crate::optimise) struct EdgeLengths {
    /// Over the weight of the closeness of vertices.
    pub weight: f64,
    /// At a corner the length of the edge from it to the next one, in one of the edge's faces.
    wished: Vec<Option<f64>>,
}

impl EdgeLengths {
    /// Lengths of all edges, in the unit of the mesh.
    pub fn new(topology: &Topology, lengths: &PerEdge<f64>, weight: f64) -> Self {
        let count = topology
            .edges()
            .map(|e| 2 - usize::from(topology.is_boundary_edge(e)));
        let mut wished = vec![None; count.sum()];
        for (edge, length) in lengths.enumerate() {
            // Corners are numbered as half-edges are, face by face.
            wished[topology.edge_half_edge(edge).index()] = Some(*length);
        }
        Self { weight, wished }
    }

    /// Corners of a face between which an edge is wished for, with its vector and the length that
    /// it lacks.
    fn edges<'a>(
        &'a self,
        panels: &Panels,
        face: usize,
        corners: &'a [Corner],
    ) -> impl Iterator<Item = ([usize; 2], Vec3, f64)> + 'a {
        let wished = self.wished[panels.corners(face)].iter().enumerate();
        wished.filter_map(move |(i, length)| {
            let j = (i + 1) % corners.len();
            let along = corners[j].position - corners[i].position;
            let lacking = (*length)? - along.norm();
            Some(([i, j], along, lacking))
        })
    }

    /// Energy of a face.
    pub fn energy(&self, panels: &Panels, face: usize, corners: &[Corner]) -> f64 {
        let squares = self
            .edges(panels, face, corners)
            .map(|(_, _, lacking)| lacking * lacking);
        0.5 * self.weight * squares.sum::<f64>()
    }

    /// Adds gradient and Hessian block of a face.
    pub fn add(
        &self,
        panels: &Panels,
        face: usize,
        corners: &[Corner],
        gradient: &mut [Vec3],
        block: &mut [f64],
    ) {
        for ([i, j], along, lacking) in self.edges(panels, face, corners) {
            let Some(unit) = along.try_normalize(f64::MIN_POSITIVE) else {
                continue;
            };
            let pull = unit * (self.weight * lacking);
            gradient[i] += pull;
            gradient[j] -= pull;
            let curved: Matrix3<f64> = unit * unit.transpose() * self.weight;
            add_difference(block, [i, j], &curved);
        }
    }
}
