//! Coverage: what lies farthest from the panels is drawn near.
//!
//! Corners and centre of a panel may lie on a surface that rises between them. A point `q` of the
//! surface whose nearest point on the panel is `y` asks, with the largest distance `d`, for
//!
//! ```text
//! c = 1 - |q - y|^2 / d^2 >= 0
//! ```
//!
//! `y` is an affine combination of corners. It moves within the panel as they do, which does not
//! change the distance at first order, so the derivative by corner `i` is `2 l_i (q - y) / d^2`
//! with its weight `l_i` at rest, exactly where the panel is planar.

use super::inequality::Inequality;
use crate::optimise::panels::{Corner, FaceFrame};
use phex_mesh::{Vec2, Vec3, polygon};

/// The inequality of a point; `None` where the panel has no area.
pub(super) fn covered(
    q: Vec3,
    corners: &[Corner],
    frame: &FaceFrame,
    most: f64,
) -> Option<Inequality> {
    let weights = weights(frame.plane.project(q), corners, frame)?;
    let combined = weights.iter().map(|(i, l)| corners[*i].position * *l);
    let off = q - combined.sum::<Vec3>();
    let row = |(i, l): (usize, f64)| (i, off * (2.0 * l / (most * most)));
    Some(Inequality {
        c: 1.0 - off.norm_squared() / (most * most),
        rows: weights.into_iter().map(row).collect(),
    })
}

/// Weights of corners of the point of a panel that is nearest to a point of its plane.
fn weights(p: Vec2, corners: &[Corner], frame: &FaceFrame) -> Option<Vec<(usize, f64)>> {
    let outline: Vec<Vec2> = corners.iter().map(|c| c.flat).collect();
    let n = outline.len();
    if polygon::contains(&outline, p) {
        // The weights of a linear regression reproduce affine functions.
        let [along, across, _] = frame.moments;
        let weight = |c: &Vec2| 1.0 / n as f64 + c.x * p.x / along + c.y * p.y / across;
        let is_flat = along <= 0.0 || across <= 0.0;
        return (!is_flat).then(|| outline.iter().map(weight).enumerate().collect());
    }
    let on_side = |i: usize| {
        let (a, b) = (outline[i], outline[(i + 1) % n]);
        let side = b - a;
        let t = ((p - a).dot(&side) / side.norm_squared()).clamp(0.0, 1.0);
        (((a + side * t) - p).norm(), i, t)
    };
    let nearest = (0..n).map(on_side).min_by(|a, b| a.0.total_cmp(&b.0));
    let (distance, i, t) = nearest?;
    distance
        .is_finite()
        .then(|| vec![(i, 1.0 - t), ((i + 1) % n, t)])
}
