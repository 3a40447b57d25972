//! What phex is attacked with: hostile surfaces, random inputs of every reader, and a judge of
//! panels that shares no code with the project. `docs/fuzzing.md` says what is run and how.

pub mod campaign;
pub mod damage;
pub mod hostile;
pub mod inputs;
pub mod raw_mesh;
pub mod referee;
pub mod shapes;

pub use hostile::{HostileSurface, hostile_surfaces};
pub use raw_mesh::{RawMesh, RawPoint};
