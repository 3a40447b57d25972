//! How the energy is minimised: the energy as one problem, starts, the feasible path and its end on
//! the constraints, shorter ways, large meshes in parts, and the formulation of the paper.

pub(super) mod emphasis;
mod endgame;
pub(super) mod energy;
mod fast;
pub(super) mod parts;
pub(super) mod path;
pub(super) mod reached;
mod shortcut;
pub(super) mod solvers;
pub(super) mod start;
mod tetrahedra;
