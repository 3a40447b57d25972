//! Meshes parallel to a mesh: their space, those close to a surface, Koebe meshes, offsets at constant edge distance.

pub mod edge_offset;
pub mod fit;
pub mod koebe;
mod null_space;
pub mod space;

pub use null_space::Rank;

#[cfg(test)]
mod test_meshes;
