//! From a surface to a planar hexagonal mesh.
//!
//! Data flows `smooth_surface -> curvature -> directions -> layout -> optimise -> trim -> koebe ->
//! offset -> report`; a stage uses earlier stages only.
//!
//! | stage | what it computes |
//! |---|---|
//! | [`smooth_surface`] | the smooth surface that the input's facets sample, normalised |
//! | [`curvature`] | shape operator at the scale of a panel |
//! | [`directions`] | the metric in which panels are regular, and their lattice directions |
//! | [`layout`] | the panelling's connectivity and first positions |
//! | [`optimise`] | planar, simple panels close to the surface |
//! | [`trim`] | panels of an extended surface brought back to its boundary |
//! | [`koebe`] | polyhedra and patches whose edges touch the unit sphere |
//! | [`offset`] | parallel meshes: offsets, Gauss images, layers and solid panels |
//! | [`report`] | what was reached: figures, checks, verdict |

pub mod curvature;
pub mod directions;
pub mod koebe;
pub mod layout;
pub mod offset;
pub mod optimise;
pub mod pipeline;
pub mod progress;
pub mod quality;
pub mod ranges;
pub mod report;
pub mod search;
pub mod smooth_surface;
#[cfg(test)]
mod test_meshes;
pub mod trim;

pub use pipeline::{
    Beyond, MeshOptions, MeshRun, PanelSize, PipelineError, continued, mesh_surface,
};
pub use progress::{Event, Progress, Silent};
pub use ranges::BadOption;
pub use trim::Boundary;
