//! Screened conformal rescaling: absorbs intrinsic curvature that the cones of the field do not
//! explain.

use super::boundary;
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
            (Some(frame), 1) => rhs[v] = boundary_turning(frame.turning, options),
            // Half of what the boundary turns there and in its image.
            (Some(frame), 2) if frame.ends_mirror() => {
                rhs[v] = 0.5 * boundary_turning(2.0 * frame.turning - PI, options);
            }
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
fn boundary_turning(turning: f64, options: &DirectionOptions) -> f64 {
    if options.boundary_alignment == 0.0 {
        return 0.0;
    }
    let rest = turning - FRAC_PI_3 * (turning / FRAC_PI_3).round();
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

#[cfg(test)]
mod tests {
    use super::super::mirrors::MirrorPlane;
    use super::*;
    use nalgebra::Matrix3;
    use phex_mesh::{TriangleSurface, Vec3};

    /// A twelfth of a flat hexagon: its middle at the origin, between the planes through the middle
    /// of a side and through a corner.
    fn part_of_hexagon() -> (TriangleSurface, [MirrorPlane; 2]) {
        const STEPS: u32 = 20;
        let places = (0..=STEPS).flat_map(|i| {
            (0..=i).map(move |j| {
                let (x, y) = (f64::from(i), f64::from(j) * FRAC_PI_6.tan());
                Vec3::new(x, y, 0.0)
            })
        });
        let row = |i: u32| i * (i + 1) / 2;
        let triangles = (0..STEPS).flat_map(|i| {
            let up = (0..=i).map(move |j| [row(i) + j, row(i + 1) + j, row(i + 1) + j + 1]);
            let down = (0..i).map(move |j| [row(i) + j, row(i + 1) + j + 1, row(i) + j + 1]);
            up.chain(down)
        });
        let triangles: Vec<[u32; 3]> = triangles.collect();
        let plane = |normal: [f64; 3]| MirrorPlane {
            point: [0.0; 3],
            normal,
        };
        let slant = [FRAC_PI_6.sin(), -FRAC_PI_6.cos(), 0.0];
        (
            TriangleSurface::new(places.collect(), &triangles).unwrap(),
            [plane([0.0, 1.0, 0.0]), plane(slant)],
        )
    }

    /// Ends of mirror planes at the rim counted as cones: panels there were four times as large as
    /// those in the middle.
    #[test]
    fn a_part_of_a_flat_hexagon_keeps_its_sizes() {
        let (surface, mirrors) = part_of_hexagon();
        let topology = surface.topology();
        let metric = PerVertex::filled(topology.n_vertices(), Matrix3::identity());
        let mesh = IntrinsicMesh::new(&surface, &metric).with_mirrors(&surface, &mirrors);
        let no_cones = PerFace::filled(topology.n_faces(), 0);
        let options = DirectionOptions::default();
        let factor = log_factor(topology, &mesh, &no_cones, &options).unwrap();
        let largest = factor.iter().map(|s| s.abs()).fold(0.0, f64::max);
        assert!(largest < 1e-6, "{largest}");
    }
}
