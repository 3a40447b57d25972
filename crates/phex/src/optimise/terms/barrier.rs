//! The barrier that keeps every panel simple: it grows without bound as a vertex nears an edge of
//! its own face.
//!
//! `b(d) = -w (z - 1)^2 ln z`, `z = d / d_hat < 1`, of every in-plane distance `d` between a vertex
//! and an edge of its face that does not hold it; 0 beyond `d_hat`. Source: the log barrier of
//! incremental potential contact (Li et al. 2020), here in the plane of each face.
//!
//! The distances are measured in the best plane, which turns as the corners move. Its turning is
//! part of the gradient: `dn = sum_k t_k (t_k . dC n) / (l_0 - l_k)`, `C` the second moments,
//! `l_0 = sum h^2`. The Hessian is the Gauss-Newton part `b'' grad d grad d^T` in the fixed plane.

use crate::optimise::options::OptimiseOptions;
use crate::optimise::panels::{Corner, FaceFrame, FaceShapes, Panels, add_block};
use crate::optimise::simple::areas;
use phex_mesh::polygon::HEXAGON;
use phex_mesh::{Vec2, Vec3};

/// Barrier of one face.
#[derive(Clone, Copy, Debug)]
pub(in crate::optimise) struct Barrier {
    /// `w`, an energy (length squared).
    pub weight: f64,
    /// `d_hat`, a length.
    pub reach: f64,
}

impl Barrier {
    pub fn value(&self, d: f64) -> f64 {
        let z = d / self.reach;
        -self.weight * (z - 1.0).powi(2) * z.ln()
    }

    /// First and second derivative.
    pub fn derivatives(&self, d: f64) -> (f64, f64) {
        let z = d / self.reach;
        let (u, log) = (z - 1.0, z.ln());
        let first = -self.weight * (2.0 * u * log + u * u / z) / self.reach;
        let second = -self.weight * (2.0 * log + 4.0 * u / z - (u / z).powi(2));
        (first, second / (self.reach * self.reach))
    }
}

/// Barriers in proportion to each panel's own area, so that graded meshes are treated alike
/// everywhere.
pub(in crate::optimise) fn barriers(
    panels: &Panels,
    start: &[f64],
    options: &OptimiseOptions,
) -> Vec<Barrier> {
    let shape = FaceShapes::at(panels, start);
    let areas = areas(panels, &shape);
    let mean = areas.iter().sum::<f64>() / areas.len() as f64;
    let barrier = |&area: &f64| {
        let area = area.max(0.05 * mean);
        Barrier {
            weight: options.barrier * options.vertex_closeness * area / HEXAGON,
            reach: options.barrier_reach * area.sqrt(),
        }
    };
    areas.iter().map(barrier).collect()
}

/// A vertex near an edge of its face.
struct Approach {
    /// Local corners: the vertex and the two ends of the edge.
    corners: [usize; 3],
    /// Their weights in `vertex - foot`.
    coefficients: [f64; 3],
    /// In-plane vector from the foot to the vertex.
    offset: Vec2,
    distance: f64,
}

/// Calls `visit` for every vertex and edge of a face that are nearer than `reach` and not incident.
fn for_each_approach(corners: &[Corner], reach: f64, mut visit: impl FnMut(&Approach)) {
    let k = corners.len();
    for edge in 0..k {
        let end = if edge + 1 == k { 0 } else { edge + 1 };
        let (a, b) = (corners[edge].flat, corners[end].flat);
        let along = b - a;
        let length2 = along.norm_squared();
        for vertex in (0..k).filter(|&v| v != edge && v != end) {
            let from = corners[vertex].flat - a;
            let s = if length2 > 0.0 {
                (from.dot(&along) / length2).clamp(0.0, 1.0)
            } else {
                0.0
            };
            let offset = from - along * s;
            let distance = offset.norm();
            if distance < reach {
                visit(&Approach {
                    corners: [vertex, edge, end],
                    coefficients: [1.0, s - 1.0, -s],
                    offset,
                    distance,
                });
            }
        }
    }
}

/// Least distance between a vertex and an edge of the same face that does not hold it.
pub(in crate::optimise) fn clearance(corners: &[Corner]) -> f64 {
    let mut least = f64::INFINITY;
    for_each_approach(corners, f64::INFINITY, |a| least = least.min(a.distance));
    least
}

/// Energy of a face.
pub(in crate::optimise) fn energy(corners: &[Corner], barrier: &Barrier) -> f64 {
    let mut sum = 0.0;
    for_each_approach(corners, barrier.reach, |a| sum += barrier.value(a.distance));
    sum
}

/// Adds gradient and Hessian block of a face.
pub(in crate::optimise) fn add(
    frame: &FaceFrame,
    corners: &[Corner],
    barrier: &Barrier,
    gradient: &mut [Vec3],
    block: &mut [f64],
) {
    let axes = frame.plane.axes;
    let mut turning = Vec2::zeros();
    for_each_approach(corners, barrier.reach, |a| {
        let distance = a.distance.max(f64::MIN_POSITIVE);
        let (first, second) = barrier.derivatives(distance);
        let unit = a.offset / distance;
        let direction = axes[0] * unit.x + axes[1] * unit.y;
        let outer = direction * direction.transpose() * second;
        let mut rise = 0.0;
        for p in 0..3 {
            let (i, c) = (a.corners[p], a.coefficients[p]);
            gradient[i] += direction * (first * c);
            rise += c * corners[i].height;
            for q in 0..3 {
                if i >= a.corners[q] {
                    let value = outer * (c * a.coefficients[q]);
                    add_block(block, i, a.corners[q], &value);
                }
            }
        }
        turning -= unit * (first * rise);
    });
    add_turning(frame, corners, turning, gradient);
}

/// Adds `turning . dn`, the part of a gradient that comes from the plane's normal.
pub(in crate::optimise) fn add_turning(
    frame: &FaceFrame,
    corners: &[Corner],
    turning: Vec2,
    gradient: &mut [Vec3],
) {
    let plane = &frame.plane;
    for k in 0..2 {
        let gap = frame.moments[2] - frame.moments[k];
        // Where the corners determine no plane the derivative does not exist.
        if turning[k] == 0.0 || -gap <= 1e-9 * frame.moments[k] {
            continue;
        }
        let factor = turning[k] / gap;
        for (g, corner) in gradient.iter_mut().zip(corners) {
            *g += (plane.axes[k] * corner.height + plane.normal * corner.flat[k]) * factor;
        }
    }
}
