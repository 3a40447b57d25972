//! Screened conformal rescaling: absorbs intrinsic curvature that the cones of the field do not
//! explain.

use super::boundary::{self, BoundaryFrame};
use super::intrinsic::IntrinsicMesh;
use super::{DirectionOptions, mirrors};
use phex_mesh::{PerFace, PerVertex, Topology};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6, PI};

/// Logarithm of the length factor at each vertex; the area-weighted mean of its square is 1.
pub(crate) fn log_factor(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    cone: &PerFace<i32>,
    options: &DirectionOptions,
) -> Result<PerVertex<f64>, NumericError> {
    let mut rhs = PerVertex::from_fn(topology.n_vertices(), |v| mesh.angle_sum[v] - 2.0 * PI);
    for f in topology.faces() {
        for &v in topology.face_vertices(f) {
            rhs[v] += f64::from(cone[f]) * FRAC_PI_3 / 3.0;
        }
    }
    for (v, frame) in boundary::frames(topology, mesh).enumerate() {
        match (frame, mesh.multiplicity[v]) {
            (None, _) => {}
            (Some(frame), 1) => rhs[v] = boundary_turning(frame, options),
            // Half of what the vertex and its image are short of a whole turn.
            (Some(_), 2) => rhs[v] += PI,
            // A part of a cone, its lattice symmetric about both sides.
            (Some(_), count) => {
                rhs[v] = mesh.angle_sum[v] - mirrors::twelfths_between(count) * FRAC_PI_6;
            }
        }
    }
    let screening = mesh.mass.iter().map(|m| options.conformal_screening * m);
    let entries = mesh.laplacian(topology, 1.0, screening.collect(), |_, w, _| -w);
    let mut s = rhs.into_vec();
    let matrix = SymmetricMatrix::from_triplets(s.len(), entries.into_iter())?;
    Cholesky::new(&matrix)?.solve(&mut s);
    Ok(PerVertex::from_vec(limited(
        &s,
        mesh,
        options.conformal_limit,
    )))
}

/// What the factor has to take from the boundary's turning so that a lattice row can follow it; a
/// turn by a multiple of a sixth needs nothing, and between two of them nothing helps.
fn boundary_turning(frame: &BoundaryFrame, options: &DirectionOptions) -> f64 {
    if options.boundary_alignment == 0.0 {
        return 0.0;
    }
    let rest = frame.turning - FRAC_PI_3 * (frame.turning / FRAC_PI_3).round();
    -rest * (1.0 - (rest / (FRAC_PI_3 / 2.0)).powi(2)).max(0.0)
}

fn limited(s: &[f64], mesh: &IntrinsicMesh, limit: f64) -> Vec<f64> {
    let mass = mesh.mass.as_slice();
    let area: f64 = mass.iter().sum();
    let scaled: f64 = mass.iter().zip(s).map(|(m, s)| m * (2.0 * s).exp()).sum();
    let mean = 0.5 * (scaled / area).ln();
    s.iter()
        .map(|s| limit * ((s - mean) / limit).tanh())
        .collect()
}
