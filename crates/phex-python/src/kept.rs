//! What a result keeps for pictures and pages that are made later.

use crate::arrays::{self, Arrays, GivenArrays};
use crate::errors::raised;
use phex::Session;
use phex::report::RunReport;
use phex_job::sessions;
use phex_mesh::{HexMesh, PolygonSoup, SurfaceParts, TriangleSurface};
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

#[pymethods]
impl Kept {
    /// The surface that was given and the panels before the last step, as arrays: what a copy of
    /// the result needs beside its own.
    fn arrays<'py>(&self, py: Python<'py>) -> PyResult<[Option<Arrays<'py>>; 2]> {
        let facets = self.result.facets.as_ref().map(TriangleSurface::to_soup);
        let made = |soup: Option<&PolygonSoup>| soup.map(|s| arrays::arrays(py, s)).transpose();
        Ok([made(facets.as_ref())?, made(self.result.start.as_ref())?])
    }
}

impl Kept {
    /// Keeps a result.
    pub fn new(result: KeptResult) -> Self {
        let result = Arc::new(result);
        Self { result }
    }
}

/// A surface with what earlier computations on it have left.
#[pyclass(frozen, module = "phex._phex")]
#[derive(Clone)]
pub struct KeptSurface {
    /// Its connected parts.
    pub parts: SurfaceParts,
    /// What was computed.
    pub sessions: Arc<Vec<Session>>,
}

#[pymethods]
impl KeptSurface {
    /// Keeps a surface; nothing is computed yet.
    #[new]
    fn new(mesh: GivenArrays<'_>) -> PyResult<Self> {
        let parts = arrays::mesh_file(&mesh).and_then(|file| file.surfaces());
        let parts = parts.map_err(raised)?;
        Ok(Self {
            sessions: sessions(&parts),
            parts,
        })
    }
}
