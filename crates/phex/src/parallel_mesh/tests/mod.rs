//! Tests of offsets on polyhedra, on exactly planar patches and on optimised ones.

mod face;
mod fixtures;
mod solid;
mod vertex;
