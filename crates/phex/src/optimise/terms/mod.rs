//! Terms of the energy, a file each, and the setting in which they are evaluated. The guard is one
//! of them: where it is broken, the energy is infinite.

pub(super) mod angle_term;
pub(super) mod areas;
pub(super) mod barrier;
pub(super) mod closeness;
pub(super) mod concavity;
mod coverage;
pub(super) mod edge_lengths;
pub(super) mod fairness;
pub(super) mod folds;
pub(super) mod guard;
pub(super) mod inequality;
mod osculating;
mod point_term;
pub(super) mod setting;
pub(super) mod shape_limits;
pub(super) mod spatial_barrier;
