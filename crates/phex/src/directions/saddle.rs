//! Rows of a lattice on a saddle-shaped surface, for panels that lie in tangent planes.
//!
//! Where `K < 0`, a panel in a lattice of touching points is simple if and only if `q = II(e, e)`
//! does not have the same sign for all three edges `e` of the lattice's triangles. In a lattice
//! that is regular in a metric `G`, with `t = (m+ + m-) / (m+ - m-)` of the eigenvalues `m+ > 0 >
//! m-` of `II` with respect to `G`, the three values are, over half the difference of the
//! eigenvalues,
//!
//! `t + 1, t - 1/2, t - 1/2` with an edge along the direction of `m+`, `t - 1, t + 1/2, t + 1/2`
//! with one along that of `m-`:
//!
//! the rule holds with the *margin* `min(1 + t, 1/2 - t)` or `min(1 - t, 1/2 + t)`, the best of all
//! rotations; half-way between, where an edge is an asymptotic direction, it holds by nothing and
//! panels have edges without length. Both directions are conjugate, and orthogonal in `G`. All rows
//! follow one of the two families, so that the lattice need not turn, but where its margin is lost.

use super::intrinsic::IntrinsicMesh;
use crate::curvature::{Curvature, Principal, tangent_frame};
use nalgebra::{Matrix2, Matrix3, SymmetricEigen};
use phex_mesh::{PerVertex, TriangleSurface, Vec3};

/// Margin that is worth a turn of the rows.
const LEAST_MARGIN: f64 = 0.12;
/// Margin beyond which more of it is worth nothing.
const ENOUGH: f64 = 0.3;

/// What rows are wished to do: to run along [`Principal::small_direction`], each with a weight from
/// 0 to `weight`.
pub(crate) fn wishes(
    surface: &TriangleSurface,
    curvature: &Curvature,
    metric: &PerVertex<Matrix3<f64>>,
    weight: f64,
) -> (PerVertex<Principal>, PerVertex<f64>) {
    let axes = PerVertex::from_fn(metric.len(), |v| {
        Axes::of(curvature.normal[v], &curvature.tensor[v], &metric[v])
    });
    let gain = |a: &Axes| {
        let [up, down] = a.margins();
        up.min(ENOUGH) - down.min(ENOUGH)
    };
    let area = IntrinsicMesh::new(surface, metric).mass;
    let votes: f64 = axes.iter().zip(&area).map(|(a, area)| gain(a) * area).sum();
    // On minimal surfaces neither family is better, and rounding must not choose.
    let family = usize::from(votes < -1e-6 * area.iter().sum::<f64>());
    let wish = |a: &Axes| {
        let strength = a.margins()[family] - LEAST_MARGIN;
        let rows = if strength > 0.0 { family } else { 1 - family };
        (a.principal(rows), weight * strength.abs().min(1.0))
    };
    let wishes: Vec<(Principal, f64)> = axes.iter().map(wish).collect();
    (
        PerVertex::from_vec(wishes.iter().map(|w| w.0).collect()),
        PerVertex::from_vec(wishes.iter().map(|w| w.1).collect()),
    )
}

/// Eigenvalues and directions of `II` with respect to a metric: the larger first.
struct Axes {
    value: [f64; 2],
    direction: [Vec3; 2],
}

impl Axes {
    fn of(normal: Vec3, second: &Matrix3<f64>, metric: &Matrix3<f64>) -> Self {
        let frame = tangent_frame(normal);
        let form = |m: &Matrix3<f64>| Matrix2::from_fn(|i, j| frame[i].dot(&(m * frame[j])));
        // In coordinates y = R x with G = R^T R the metric is Euclidean.
        let root = form(metric).cholesky().map(|c| c.l().transpose());
        let back = root.and_then(|r| r.try_inverse());
        let back = back.unwrap_or_else(Matrix2::identity);
        let eigen = SymmetricEigen::new(back.transpose() * form(second) * back);
        let order = if eigen.eigenvalues[0] >= eigen.eigenvalues[1] {
            [0, 1]
        } else {
            [1, 0]
        };
        let direction = order.map(|k| {
            let x = back * eigen.eigenvectors.column(k);
            (frame[0] * x[0] + frame[1] * x[1]).normalize()
        });
        Self {
            value: order.map(|k| eigen.eigenvalues[k]),
            direction,
        }
    }

    /// By how much the sign rule holds with rows along the first and along the second direction,
    /// over half the difference of the eigenvalues.
    fn margins(&self) -> [f64; 2] {
        let [up, down] = self.value;
        let half = 0.5 * (up - down);
        if half <= f64::MIN_POSITIVE {
            return [0.0; 2];
        }
        let t = 0.5 * (up + down) / half;
        [(1.0 + t).min(0.5 - t), (1.0 - t).min(0.5 + t)].map(|m| m.max(-1.0))
    }

    fn principal(&self, rows: usize) -> Principal {
        let across = 1 - rows;
        Principal {
            small: self.value[rows],
            large: self.value[across],
            small_direction: self.direction[rows],
            large_direction: self.direction[across],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::{CurvatureOptions, curvature};
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
    use proptest::prelude::*;

    proptest! {
        /// Rows along either direction keep the sign rule by the margin, and no rotation of the
        /// lattice keeps it by more than the better of them.
        #[test]
        fn margins_are_those_of_a_lattice(up in 0.05..3.0f64, down in -3.0..-0.05f64, turn in 0.0..3.0f64, stretch in 0.3..3.0f64) {
            let turned = nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), turn);
            let tangential = |a: f64, b: f64| turned.matrix() * Matrix3::from_diagonal(&Vec3::new(a, b, 0.0)) * turned.matrix().transpose();
            // II and G with the same axes: eigenvalues up and down.
            let (second, metric) = (tangential(up * stretch, down), tangential(stretch, 1.0));
            let axes = Axes::of(Vec3::z(), &second, &metric);
            let half = 0.5 * (up - down);
            // Smallest of the values that has the sign of the fewer, over half the difference:
            // negative where all have one sign.
            let rule = |first: Vec3| {
                let across = axes.direction.map(|d| d / d.dot(&(metric * d)).sqrt());
                let local = [across[0].dot(&(metric * first)), across[1].dot(&(metric * first))];
                let q = [0.0f64, 60.0, 120.0].map(|degrees| {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    let (x, y) = (cos * local[0] - sin * local[1], sin * local[0] + cos * local[1]);
                    (up * x * x + down * y * y) / half
                });
                let (low, high) = q.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
                let least = q.iter().fold(f64::MAX, |l, x| l.min(x.abs()));
                if low < 0.0 && high > 0.0 { least } else { -1.0 }
            };
            for (direction, margin) in axes.direction.iter().zip(axes.margins()) {
                let unit = direction / direction.dot(&(metric * direction)).sqrt();
                let kept = rule(unit);
                prop_assert!((kept - margin).abs() < 1e-9 || (kept < 0.0 && margin <= 1e-9), "{kept} {margin}");
            }
        }
    }

    #[test]
    fn rows_keep_to_one_family_on_a_minimal_surface() {
        let options = TriangulationOptions {
            triangles: 2000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name("catenoid", &[]).unwrap(), &options).unwrap();
        let curvature = curvature(&surface, 0.3, &CurvatureOptions::default());
        let metric = PerVertex::filled(surface.positions().len(), Matrix3::identity());
        let (rows, weight) = wishes(&surface, &curvature, &metric, 1.0);
        let round = |p: &Vec3| Vec3::new(-p.y, p.x, 0.0).normalize();
        let topology = surface.topology();
        let inside = topology.inner_vertices();
        let along: Vec<f64> = inside
            .map(|v| {
                rows[v]
                    .small_direction
                    .dot(&round(&surface.positions()[v]))
                    .abs()
            })
            .collect();
        // All meridians or all parallels, and wished for everywhere.
        let meridians = along.iter().all(|x| *x < 0.2);
        let parallels = along.iter().all(|x| *x > 0.98);
        assert!(meridians || parallels, "{along:?}");
        assert!(weight.iter().all(|w| *w > 0.2));
    }
}
