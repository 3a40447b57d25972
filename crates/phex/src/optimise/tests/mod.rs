//! Tests of the optimiser on analytic surfaces.

mod derivatives;
pub(crate) mod fixtures;
mod minimum;
mod parts;
mod steering;
mod whole;
