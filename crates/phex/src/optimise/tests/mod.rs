//! Tests of the optimiser on analytic surfaces.

mod derivatives;
mod fixtures;
mod whole;
