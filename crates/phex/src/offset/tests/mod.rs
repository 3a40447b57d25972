//! Tests of offsets on polyhedra, on exactly planar patches and on optimised ones.

mod edge;
mod face;
mod fixtures;
mod inheritance;
mod signs;
mod solid;
mod vertex;
