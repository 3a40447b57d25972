//! Moves: the only steps that edit how panels are joined once they are there. Edges turn and halves
//! of panels become one where that makes panels more regular.

pub(crate) mod flips;
pub(crate) mod glide;
pub(super) mod halves;

/// Corners that a panel has at the least.
pub(crate) const LEAST_CORNERS: usize = 4;
/// How far the ends of a turned edge move from its middle towards the centres of the panels that
/// they now separate from the others.
pub(crate) const OPENING: f64 = 0.25;
