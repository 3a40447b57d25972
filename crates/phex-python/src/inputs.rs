//! What requests come with: meshes, numbers, an earlier result.

use crate::kept::{Kept, KeptSurface};
use phex_job::{JobError, MeshFile};
use phex_mesh::{HexMesh, TriangleSurface};

/// What a request comes with.
pub struct Inputs {
    /// Meshes, in the order that the request knows.
    pub files: Vec<MeshFile>,
    /// A number for each vertex or face.
    pub sizes: Option<Vec<f64>>,
    /// An earlier result.
    pub kept: Option<Kept>,
    /// The surface of the first mesh, with what was computed on it.
    pub session: Option<KeptSurface>,
}

impl Inputs {
    /// The first mesh.
    ///
    /// # Errors
    /// If there is none.
    pub fn first(&self) -> Result<&MeshFile, JobError> {
        let none = || JobError::Input("a mesh is needed".to_owned());
        self.files.first().ok_or_else(none)
    }

    /// The first mesh as panels.
    ///
    /// # Errors
    /// If it is none, or no manifold.
    pub fn panels(&self) -> Result<HexMesh, JobError> {
        Ok(self.first()?.polygon_mesh()?.0)
    }

    /// The second mesh as a surface, where there is one.
    ///
    /// # Errors
    /// If it is no surface.
    pub fn surface(&self) -> Result<Option<TriangleSurface>, JobError> {
        self.files.get(1).map(MeshFile::surface).transpose()
    }
}
