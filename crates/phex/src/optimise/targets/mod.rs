//! What a panelling is kept close to: a triangle surface as a target, and the reference that is one
//! or the start itself.

pub(super) mod reference;
pub(super) mod surface_target;
