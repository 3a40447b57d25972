//! What a result keeps for pictures and pages that are made later.

use phex::report::RunReport;
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface};
use pyo3::prelude::*;
use std::sync::Arc;

/// A mesh with its report and what it was made from.
#[pyclass(frozen, module = "phex._phex")]
#[derive(Clone)]
pub struct Kept {
    /// All of it.
    pub result: Arc<KeptResult>,
}

/// See [`Kept`]; lengths in model units.
pub struct KeptResult {
    /// The panels.
    pub mesh: HexMesh,
    /// Figures and checks.
    pub report: RunReport,
    /// The surface that they were fitted to.
    pub smooth: Option<TriangleSurface>,
    /// The surface that was given.
    pub facets: Option<TriangleSurface>,
    /// The panels before the last step.
    pub start: Option<PolygonSoup>,
}

impl Kept {
    /// Keeps a result.
    pub fn new(result: KeptResult) -> Self {
        let result = Arc::new(result);
        Self { result }
    }
}
