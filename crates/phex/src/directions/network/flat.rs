//! A flat connection: the parallel transport closest to the surface's own that turns nothing round
//! any triangle (K. Crane, M. Desbrun, P. Schroeder, "Trivial connections on discrete surfaces",
//! 2010).
//!
//! Each edge turns by `eta = (beta_left - beta_right) / w` more, where `beta` solves the Laplace
//! equation on the dual graph with the curvature of the triangles as its source and `beta = 0`
//! outside the boundary; this `eta` has the least `sum w eta^2`.

use super::super::intrinsic::{IntrinsicMesh, row};
use phex_mesh::{EdgeId, FaceId, PerEdge, Topology};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};
use std::f64::consts::PI;

/// Rotation that transport along each edge, from the origin to the target of its half-edge, adds to
/// a polar angle.
///
/// # Errors
/// If the linear system can't be solved.
pub(crate) fn flat_transport(
    topology: &Topology,
    mesh: &IntrinsicMesh,
) -> Result<PerEdge<f64>, NumericError> {
    let beta = dual_potential(topology, mesh)?;
    Ok(PerEdge::from_fn(topology.n_edges(), |e| {
        let (left, right) = sides(topology, e);
        let outside = right.map_or(0.0, |f| beta[f.index()]);
        mesh.transport(e) + (beta[left.index()] - outside) / mesh.weight[e]
    }))
}

/// The faces to the left and to the right of an edge's half-edge.
fn sides(topology: &Topology, e: EdgeId) -> (FaceId, Option<FaceId>) {
    let h = topology.edge_half_edge(e);
    (topology.face(h), topology.across(h))
}

fn dual_potential(topology: &Topology, mesh: &IntrinsicMesh) -> Result<Vec<f64>, NumericError> {
    let n = topology.n_faces();
    let mut own = vec![0.0; n];
    let mut entries = Vec::with_capacity(topology.n_edges() + n);
    for e in topology.edges() {
        let (left, right) = sides(topology, e);
        let weight = 1.0 / mesh.weight[e];
        own[left.index()] += weight;
        if let Some(right) = right {
            own[right.index()] += weight;
            entries.push((row(left.max(right)), row(left.min(right)), -weight));
        }
    }
    if topology.is_closed() {
        // A closed surface: potentials count up to a constant.
        own[0] *= 2.0;
    }
    entries.extend(
        own.iter()
            .enumerate()
            .map(|(i, d)| (i as u32, i as u32, *d)),
    );
    let mut beta: Vec<f64> = topology
        .faces()
        .map(|f| -curvature(topology, mesh, f))
        .collect();
    Cholesky::new(&SymmetricMatrix::from_triplets(n, entries.into_iter())?)?.solve(&mut beta);
    Ok(beta)
}

/// Angle by which transport round a triangle turns.
fn curvature(topology: &Topology, mesh: &IntrinsicMesh, f: FaceId) -> f64 {
    let turn: f64 = topology
        .face_half_edges(f)
        .map(|h| topology.along(h, mesh.transport(topology.edge(h))))
        .sum();
    (turn + PI).rem_euclid(2.0 * PI) - PI
}
