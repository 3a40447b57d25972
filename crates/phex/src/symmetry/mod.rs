//! Symmetries of a surface: its mirror planes are found, the part between them is cut out, and a
//! mesh of the part is completed by its images.
//!
//! `find` finds the group, `cut` the part of the surface that generates it (a fundamental domain).
//! Its boundary in mirror planes is laid out as such ([`MirrorPlane`]). `quotient` makes the panels
//! that planes cut whole; corners beyond a plane are no unknowns but images, and the optimiser
//! takes them along. `turns` makes these panels more regular. `unfold` adds all images.
//!
//! [`MirrorPlane`]: crate::directions::MirrorPlane

mod choice;
mod cut;
mod find;
mod group;
mod quotient;
mod target;
mod turns;
mod unfold;

pub use choice::Symmetry;
pub(crate) use cut::cut;
pub(crate) use find::{Found, Symmetries, distance, find, has_turn};
pub(crate) use group::Group;
pub(crate) use quotient::{WholePanels, completed, irregular_panels, quotient_of};
pub(crate) use target::FoldedTarget;
pub(crate) use unfold::unfolded;
pub use unfold::{Isometry, Orbits};

use serde::Serialize;

/// Distance, bounding-box diagonals, within which an image of the surface lies on it.
pub const SYMMETRY_TOLERANCE: f64 = 1e-3;

/// What was found and used, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SymmetrySummary {
    /// The group, in Schoenflies' notation.
    pub group: String,
    /// Number of its elements.
    pub order: u32,
    /// Whether the surface is one of revolution.
    pub revolution: bool,
    /// Largest distance of an image of the surface to it, bounding-box diagonals.
    pub distance_rel: f64,
    /// Largest distance that was allowed.
    pub tolerance_rel: f64,
    /// Panels that differ.
    pub distinct_panels: usize,
    /// The maps `x -> M x + t`, model units.
    pub operations: Vec<Isometry>,
}

impl SymmetrySummary {
    /// What was found, in words.
    pub fn sentence(&self) -> String {
        format!(
            "symmetry {}: the surface has {} images of itself, to {:.1e} of its diagonal (at most {:.0e}); {} panels differ",
            self.group, self.order, self.distance_rel, self.tolerance_rel, self.distinct_panels
        )
    }
}
