//! Meshes, files and measures, in one binary: linking one for each file takes minutes.

mod common;
mod measure;
mod mesh_files;
mod shapes;
mod surface_from_soup;
mod theory;
mod validate;
