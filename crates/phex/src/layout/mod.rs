//! Layout: connectivity and first positions of the panels.

pub mod record;
pub use record::{Layout, VertexKind};
