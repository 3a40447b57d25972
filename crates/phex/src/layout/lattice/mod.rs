//! The lattice on the surface: which point of it every vertex is at, from waves in the charts of
//! the direction field to offsets without needless dislocations. `gauss_lattice` is one by itself,
//! for the Gauss sphere.

pub(super) mod boundary;
mod chart_graph;
pub(super) mod charted;
pub(super) mod dislocations;
pub(crate) mod eisenstein;
mod fronts;
pub(crate) mod gauss_lattice;
pub(super) mod polish;
pub(super) mod seamless;
pub(super) mod strain;
mod wave_operator;
pub(super) mod waves;
