//! The barrier with distances in space instead of in the plane of the face. On planar panels both
//! are the same; here the Hessian is exact: with `r = C y` the vector of length `d` from the foot
//! on the edge `e` to the vertex, `u = r / d`,
//!
//! ```text
//! grad d = C^T u,   Hess d = C^T (I - u u^T) C / d - g g^T d / |e|^2,   g = (0, u, -u) - C^T e / d
//! ```
//!
//! the second term only where the foot lies within the edge (`d = min_s |r(s)|`, so `Hess d =
//! f_yy - f_ys f_ss^-1 f_sy`).

use super::barrier::Barrier;
use crate::optimise::panels::{Corner, add_block};
use nalgebra::Matrix3;
use phex_mesh::Vec3;

/// A vertex near an edge of its face, in space.
pub(super) struct SpatialApproach {
    /// Local corners: the vertex and the two ends of the edge.
    pub corners: [usize; 3],
    /// Their weights in `vertex - foot`.
    pub coefficients: [f64; 3],
    pub offset: Vec3,
    pub distance: f64,
    along: Vec3,
    /// Whether the foot lies within the edge.
    within: bool,
}

/// Calls `visit` for every vertex and edge of a face that are nearer than `reach` and not incident.
pub(super) fn for_each_approach(
    corners: &[Corner],
    reach: f64,
    mut visit: impl FnMut(&SpatialApproach),
) {
    let k = corners.len();
    for edge in 0..k {
        let end = (edge + 1) % k;
        let (a, b) = (corners[edge].position, corners[end].position);
        let along = b - a;
        for vertex in (0..k).filter(|&v| v != edge && v != end) {
            let from = corners[vertex].position - a;
            let s = from.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE);
            let within = s > 0.0 && s < 1.0;
            let s = s.clamp(0.0, 1.0);
            let offset = from - along * s;
            let distance = offset.norm();
            if distance < reach {
                visit(&SpatialApproach {
                    corners: [vertex, edge, end],
                    coefficients: [1.0, s - 1.0, -s],
                    offset,
                    distance: distance.max(f64::MIN_POSITIVE),
                    along,
                    within,
                });
            }
        }
    }
}

/// Energy of a face.
pub(in crate::optimise) fn energy(corners: &[Corner], barrier: &Barrier) -> f64 {
    let mut sum = 0.0;
    for_each_approach(corners, barrier.reach, |a| sum += barrier.value(a.distance));
    sum
}

/// Adds gradient and Hessian block of a face, both exact.
pub(in crate::optimise) fn add(
    corners: &[Corner],
    barrier: &Barrier,
    gradient: &mut [Vec3],
    block: &mut [f64],
) {
    for_each_approach(corners, barrier.reach, |a| {
        let (first, second) = barrier.derivatives(a.distance);
        let unit = a.offset / a.distance;
        let outer = unit * unit.transpose();
        let same = outer * second + (Matrix3::identity() - outer) * (first / a.distance);
        let slide = a.slide(unit);
        let softening = -first * a.distance / a.along.norm_squared();
        for p in 0..3 {
            let (i, c) = (a.corners[p], a.coefficients[p]);
            gradient[i] += unit * (first * c);
            for q in 0..3 {
                if i >= a.corners[q] {
                    let mut value = same * (c * a.coefficients[q]);
                    if a.within {
                        value += slide[p] * slide[q].transpose() * softening;
                    }
                    add_block(block, i, a.corners[q], &value);
                }
            }
        }
    });
}

impl SpatialApproach {
    /// `g`: how the slope of the distance along the edge changes with each of the three points.
    fn slide(&self, unit: Vec3) -> [Vec3; 3] {
        let along = self.along / self.distance;
        let [p, a, b] = self.coefficients;
        [-along * p, unit - along * a, -unit - along * b]
    }
}
