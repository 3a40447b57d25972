//! Tests of the optimiser on analytic surfaces.

mod derivatives;
pub(crate) mod fixtures;
mod steering;
mod whole;
