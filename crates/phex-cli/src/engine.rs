//! The library's pipeline as the commands use it.

use crate::exit::{Exit, Failure};
use phex::Progress;
use phex::report::StageTime;
use phex_mesh::{HexMesh, TriangleSurface};
use serde_json::Value;

/// What a computation reached.
pub struct Reached {
    /// The mesh, in model coordinates; valid or not.
    pub mesh: HexMesh,
    /// The smooth surface that it was fitted to, in model coordinates.
    pub smooth: Option<TriangleSurface>,
    /// How the computation ended.
    pub outcome: Value,
    /// Whether the user ended it.
    pub cancelled: bool,
    /// Time of each stage.
    pub stages: Vec<StageTime>,
    /// What the stages counted.
    pub statistics: Value,
}

/// Options of the pipeline.
pub fn mesh(
    _surface: &TriangleSurface,
    _panels: u64,
    _rotate_deg: f64,
    _seed: u64,
    _progress: &dyn Progress,
) -> Result<Reached, Failure> {
    Err(Failure::new(
        Exit::Internal,
        "the pipeline is not part of this branch",
    ))
}

/// Planarizes a mesh.
pub fn planarize(
    _mesh: &HexMesh,
    _surface: &TriangleSurface,
    _progress: &dyn Progress,
) -> Result<Reached, Failure> {
    Err(Failure::new(
        Exit::Internal,
        "the pipeline is not part of this branch",
    ))
}
