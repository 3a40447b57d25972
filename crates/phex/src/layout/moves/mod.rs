//! Moves: the only steps that edit how panels are joined once they are there. Edges turn and halves
//! of panels become one where that makes panels more regular.

pub(crate) mod flips;
pub(crate) mod glide;
pub(super) mod halves;
