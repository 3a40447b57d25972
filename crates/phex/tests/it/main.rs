//! The library from surface to panels, in one binary: linking one for each file takes minutes.

mod boundary;
mod brick_wall;
mod classical;
mod coarsened;
mod common;
mod curvature;
mod dupin;
mod koebe_method;
mod offset_pipeline;
mod pipeline;
mod repetition;
mod session;
mod symmetry;
mod target;
mod vertex_normal;
