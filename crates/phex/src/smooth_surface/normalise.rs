//! The surface as all later stages see it: the same for the same shape, whatever its unit.
//!
//! A millimetre is a thousandth of a metre, but their doubles round differently, and a lattice on a
//! hard surface turns a last bit into another layout. So normalised coordinates are rounded to a
//! grid. How the file numbers its vertices still matters: sums run in their order, and where two
//! layouts are equally good it decides between them.

use super::Affinity;
use phex_mesh::{TriangleSurface, Vec3};

/// Steps of the grid in a diagonal. Rounding errors of coordinates are 1e-16 of the diagonal, a
/// millionth of a step: a vertex so near to the middle between two steps that they decide is rare.
/// A step is 7 nanometres on a surface of 30 metres.
const STEPS: f64 = (1_u64 << 32) as f64;

/// A surface in normalised coordinates.
#[derive(Clone)]
pub struct Normalised {
    /// The surface as it was given.
    pub given: TriangleSurface,
    /// The surface, with the numbers that it has in the input.
    pub surface: TriangleSurface,
    /// What brings the given surface there, up to the grid.
    pub affinity: Affinity,
}

impl Normalised {
    /// Brings a surface to diagonal 1, its box centre to the origin, and its vertices to the grid.
    pub fn of(surface: &TriangleSurface) -> Self {
        let affinity = Affinity::normalising(surface);
        Self {
            given: surface.clone(),
            surface: surface.mapped(|p| on_grid(affinity.normalise(*p))),
            affinity,
        }
    }

    /// The same, with heights raised where the surface is shallow ([`Affinity`]).
    pub fn raised(surface: &TriangleSurface) -> Self {
        let plain = Self::of(surface);
        let affinity = plain.affinity.raising(&plain.surface);
        match affinity == plain.affinity {
            true => plain,
            false => Self {
                surface: (plain.surface).mapped(|p| on_grid(affinity.raised(*p))),
                affinity,
                ..plain
            },
        }
    }

    /// A surface in model coordinates; the given one as it was given.
    pub fn restored(&self, surface: &TriangleSurface) -> TriangleSurface {
        let restore = |p: &Vec3| self.affinity.restore(*p);
        match surface.is_clone_of(&self.surface) {
            true => self.given.clone(),
            // Normals stay where no height changes.
            false if self.affinity.factor == 1.0 => surface.moved(restore),
            false => surface.mapped(restore),
        }
    }

    /// A place of the model in normalised coordinates, on the grid.
    pub fn place(&self, p: Vec3) -> Vec3 {
        on_grid(self.affinity.normalise(p))
    }
}

fn on_grid(p: Vec3) -> Vec3 {
    p.map(|x| (x * STEPS).round() / STEPS)
}
