//! What a panelling is kept close to: triangle surfaces and analytic shapes as targets, and the
//! reference that is one of them or the start itself.

pub(super) mod reference;
pub(super) mod shape_target;
pub(super) mod surface_target;
