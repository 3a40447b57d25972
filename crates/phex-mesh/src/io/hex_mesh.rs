//! Polygon meshes from and to files.

use super::{ReadError, WriteError, read_soup, write_soup};
use crate::extent;
use crate::{HexMesh, PolygonSoup, TopologyError, VertexId};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a polygon soup is no [`HexMesh`].
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HexMeshError {
    /// A coordinate is not finite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    NonFinite {
        /// The vertex.
        vertex: VertexId,
    },
    /// The mesh has no extent, or one beyond what can be computed with.
    #[error("the mesh's extent {extent:e} is outside 1e-50 to 1e50")]
    Extent {
        /// Longest side of the bounding box, or largest coordinate.
        extent: f64,
    },
    /// The faces are no oriented manifold.
    #[error(transparent)]
    Topology(#[from] TopologyError),
}

/// Why no [`HexMesh`] comes out of a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum HexMeshReadError {
    /// The file can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file's mesh is no oriented manifold.
    #[error("{}: {cause}", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// What is wrong with its mesh; elements are counted from 0.
        cause: HexMeshError,
    },
}

impl HexMesh {
    /// The mesh of a soup, as it stands: nothing is welded, turned round or dropped.
    ///
    /// # Errors
    /// If a coordinate is not finite, the extent is outside 1e-50 to 1e50, or the faces are no
    /// oriented manifold that uses every vertex.
    pub fn from_soup(soup: &PolygonSoup) -> Result<Self, HexMeshError> {
        let finite = |p: &crate::Vec3| p.iter().all(|x| x.is_finite());
        if let Some(i) = soup.positions.iter().position(|p| !finite(p)) {
            let vertex = VertexId::new(u32::try_from(i).unwrap_or(u32::MAX));
            return Err(HexMeshError::NonFinite { vertex });
        }
        let mesh = Self::new(soup.positions.clone(), &soup.faces)?;
        extent::largest_coordinate(mesh.positions.iter())
            .map_err(|extent| HexMeshError::Extent { extent })?;
        Ok(mesh)
    }

    /// Reads a mesh file (OBJ, PLY, OFF, or STL with its corners welded).
    ///
    /// # Errors
    /// If the file can't be read, or its mesh is no oriented manifold.
    pub fn read(path: &Path) -> Result<Self, HexMeshReadError> {
        Self::from_soup(&read_soup(path)?).map_err(|cause| HexMeshReadError::Mesh {
            path: path.to_path_buf(),
            cause,
        })
    }

    /// Writes a mesh file whole or not at all: OBJ, PLY and OFF with the faces as they are, STL
    /// with their triangles.
    ///
    /// # Errors
    /// As [`write_soup`].
    pub fn write(&self, path: &Path) -> Result<(), WriteError> {
        write_soup(path, &self.to_soup())
    }
}
