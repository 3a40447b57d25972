//! Meshes parallel to a mesh: offsets, Gauss images, Koebe polyhedra.

pub mod koebe;
