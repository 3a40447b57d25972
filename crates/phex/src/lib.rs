//! From a surface to a planar hexagonal mesh.
//!
//! ```no_run
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let surface = phex::Surface::read("roof.obj")?;
//! let made = phex::Mesher::new().panels(600).boundary(phex::Boundary::Clip).run(&surface)?;
//! made.write("roof-phex.obj")?;
//! println!("valid: {}, {} panels", made.is_valid(), made.mesh().topology().n_faces());
//! # Ok(())
//! # }
//! ```
//!
//! [`Mesher`] sets the options, [`Panelling`] is what comes back: the mesh, its checks, its report
//! and its offsets. The stages can be called one by one, too: each is a function with one struct
//! of options.
//!
//! Data flows `smooth_surface -> curvature -> directions -> layout -> optimise -> trim -> koebe ->
//! offset -> report`, past `classical` for the methods of that name; a stage uses earlier stages
//! only.
//!
//! | stage | what it computes |
//! |---|---|
//! | [`smooth_surface`] | the smooth surface that the input's facets sample, normalised |
//! | [`curvature`] | shape operator at the scale of a panel |
//! | [`directions`] | the metric in which panels are regular, and their lattice directions |
//! | [`classical`] | the classical methods: panels in planes that are chosen first |
//! | [`layout`] | the panelling's connectivity and first positions |
//! | [`optimise`] | planar, simple panels close to the surface |
//! | [`trim`] | panels of an extended surface brought back to its boundary |
//! | [`repetition`] | edges of a valid mesh made equal within a tolerance |
//! | [`koebe`] | polyhedra and patches whose edges touch the unit sphere |
//! | [`offset`] | parallel meshes: offsets, Gauss images, layers and solid panels |
//! | [`report`] | what was reached: figures, checks, verdict |

// Tests inside share code with those outside, which name the crate.
#[cfg(test)]
extern crate self as phex;

pub mod classical;
#[cfg(test)]
#[path = "../tests/it/common/mod.rs"]
mod common;
pub mod curvature;
pub mod directions;
pub mod koebe;
pub mod layout;
mod mesher;
pub mod offset;
pub mod optimise;
pub mod pipeline;
mod progress;
pub mod quality;
pub mod ranges;
pub mod repetition;
pub mod report;
pub mod search;
pub mod smooth_surface;
pub mod symmetry;
#[cfg(test)]
mod test_meshes;
pub mod trim;

pub use mesher::{Mesher, Panelling};
pub use phex_mesh::TriangleSurface as Surface;
pub use pipeline::{
    Beyond, Effort, LatticePreview, MeshOptions, MeshRun, Method, PanelSize, PipelineError,
    Session, continued, mesh_surface,
};
pub use progress::{Event, Progress, Silent};
pub use ranges::BadOption;
pub use trim::Boundary;
