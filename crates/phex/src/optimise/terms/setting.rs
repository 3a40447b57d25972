//! What does not change while one start is optimised, and measures of positions and steps in it.

use super::areas::AreaWish;
use super::closeness::Feet;
use super::guard::{Armed, Guard};
use super::shape_limits::FaceLimits;
use crate::optimise::holds::Holds;
use crate::optimise::panels::{FaceShapes, Panels, point};
use crate::optimise::simple::collision;
use crate::optimise::targets::reference::Reference;
use phex_mesh::Vec2;

/// Fraction of the way to the first collision that a step may go.
const COLLISION_FRACTION: f64 = 0.85;

/// What does not change while one start is optimised.
pub(in crate::optimise) struct Setting<'a> {
    pub panels: &'a Panels,
    pub reference: &'a Reference<'a>,
    pub guard: &'a Guard,
    /// Vertices that are drawn to the boundary curve.
    pub rim: &'a [u32],
    /// Whether a vertex is a corner of the boundary.
    pub corner: &'a [bool],
    /// Vertices that the user holds.
    pub holds: &'a Holds,
    /// Areas that faces are to have, weights relative to that of the closeness of vertices.
    pub areas: &'a [AreaWish],
    /// What faces are to have.
    pub limits: &'a FaceLimits,
    pub mean_edge: f64,
}

/// Distances of vertices, then of face centres, to the reference.
pub(in crate::optimise) fn distances(setting: &Setting<'_>, x: &[f64]) -> Vec<f64> {
    let shape = FaceShapes::at(setting.panels, x);
    let mut feet = Feet::default();
    feet.update(setting.reference, &shape, x, &[]);
    feet.distances()
}

/// Distances of vertices and face centres to the reference: largest, and root mean square.
pub(in crate::optimise) fn deviation(setting: &Setting<'_>, x: &[f64]) -> (f64, f64) {
    let distances = distances(setting, x);
    let both = |(most, sum): (f64, f64), d: &f64| (most.max(*d), sum + d * d);
    let (most, sum) = distances.iter().fold((0.0, 0.0), both);
    (most, (sum / distances.len().max(1) as f64).sqrt())
}

/// Largest displacement of a vertex.
pub(in crate::optimise) fn longest(step: &[f64]) -> f64 {
    let squares = step.chunks_exact(3).map(|d| d.iter().map(|c| c * c).sum());
    squares.fold(0.0, f64::max).sqrt()
}

/// Fraction of a step that keeps clear of collisions within every face.
pub(in crate::optimise) fn collision_bound(
    setting: &Setting<'_>,
    armed: &Armed,
    shape: &FaceShapes,
    step: &[f64],
    corner_motion: &mut [Vec2],
) -> f64 {
    let panels = setting.panels;
    let mut bound: f64 = 1.0;
    for f in (0..panels.n_faces()).filter(|&f| armed.is_simple(f) && !panels.rests(f)) {
        let motion = &mut corner_motion[panels.corners(f)];
        for (m, &v) in motion.iter_mut().zip(panels.vertices(f)) {
            *m = shape.frames[f]
                .plane
                .project_vector(point(step, v as usize));
        }
        bound = collision(shape.face(panels, f), motion, bound);
    }
    if bound < 1.0 {
        COLLISION_FRACTION * bound
    } else {
        1.0
    }
}
