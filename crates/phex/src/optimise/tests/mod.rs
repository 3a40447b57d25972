//! Tests of the optimiser on analytic surfaces.

mod derivatives;
pub(crate) mod fixtures;
mod parts;
mod steering;
mod whole;
