//! Planarity as constraints: what they are (and the penalty in their place), their Jacobian, the
//! projection onto them of minimum norm, and steps of it that the guard admits.

pub(super) mod guarded;
pub(super) mod jacobian;
pub(super) mod minimum_norm;
pub(super) mod planarity;
