//! Is a panel simple, and how far can its corners move before it no longer is?

use super::panels::{Corner, FaceShapes, Panels};
use phex_mesh::Vec2;

/// Twice the signed area of a triangle.
fn orient(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    (b - a).perp(&(c - a))
}

/// Signed area of a face in its own plane.
pub(super) fn area(corners: &[Corner]) -> f64 {
    let k = corners.len();
    let twice = |i: usize| corners[i].flat.perp(&corners[(i + 1) % k].flat);
    0.5 * (0..k).map(twice).sum::<f64>()
}

/// Areas of all faces in their own planes, whichever way they run.
pub(super) fn areas(panels: &Panels, shape: &FaceShapes) -> Vec<f64> {
    let area = |f| area(shape.face(panels, f)).abs();
    (0..panels.n_faces()).map(area).collect()
}

/// Faces that are not simple.
pub(super) fn crossed(panels: &Panels, shape: &FaceShapes) -> Vec<usize> {
    let is_crossed = |f: &usize| !is_simple(shape.face(panels, *f));
    (0..panels.n_faces()).filter(is_crossed).collect()
}

/// Whether a face, seen in its own plane, is a simple polygon of positive area.
pub(super) fn is_simple(corners: &[Corner]) -> bool {
    let k = corners.len();
    let at = |i: usize| corners[i % k].flat;
    let crosses = |i: usize, j: usize| {
        let (a, b, c, d) = (at(i), at(i + 1), at(j), at(j + 1));
        (orient(a, b, c) >= 0.0) != (orient(a, b, d) >= 0.0)
            && (orient(c, d, a) >= 0.0) != (orient(c, d, b) >= 0.0)
    };
    let neighbours = |i: usize, j: usize| j == i + 1 || (i == 0 && j == k - 1);
    let crossing = (0..k).any(|i| (i + 1..k).any(|j| !neighbours(i, j) && crosses(i, j)));
    area(corners) > 0.0 && !crossing
}

/// Largest `t <= limit` so that no vertex of a face meets an edge of it while corners move by `t *
/// motion` in its plane.
pub(super) fn collision(corners: &[Corner], motion: &[Vec2], limit: f64) -> f64 {
    let k = corners.len();
    let mut best = limit;
    for edge in 0..k {
        let end = (edge + 1) % k;
        let along = corners[end].flat - corners[edge].flat;
        let along_motion = motion[end] - motion[edge];
        for vertex in (0..k).filter(|&v| v != edge && v != end) {
            let from = corners[vertex].flat - corners[edge].flat;
            let from_motion = motion[vertex] - motion[edge];
            // The vertex is in line with the edge where this quadratic vanishes.
            let quadratic = [
                along.perp(&from),
                along_motion.perp(&from) + along.perp(&from_motion),
                along_motion.perp(&from_motion),
            ];
            for t in roots(quadratic) {
                if t > 0.0 && t < best {
                    let (e, g) = (along + along_motion * t, from + from_motion * t);
                    let foot = e.dot(&g) / e.norm_squared();
                    // A little beyond the ends counts, or the vertex could slip past a moving end;
                    // so does an edge of length zero.
                    if foot.is_nan() || (-1e-3..=1.0 + 1e-3).contains(&foot) {
                        best = t;
                    }
                }
            }
        }
    }
    best
}

/// Real roots of `c + b t + a t^2`, without cancellation; `NaN` for those that do not exist.
fn roots([c, b, a]: [f64; 3]) -> [f64; 2] {
    if a.abs() < 1e-300 {
        return [-c / b, f64::NAN];
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 {
        return [f64::NAN; 2];
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    [q / a, c / q]
}
