//! Triangle surfaces from files.

use super::{ReadError, read_soup};
use crate::{SurfaceError, SurfaceParts, TriangleSurface};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why no surface comes out of a file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SurfaceReadError {
    /// The file can't be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The file's faces are no surface.
    #[error("{}: {cause}", path.display())]
    Surface {
        /// The file.
        path: PathBuf,
        /// What is wrong with its faces; elements are counted from 0.
        cause: SurfaceError,
    },
    /// One connected surface is wanted, and the file has more.
    #[error("{}: it holds {count} surfaces that are not connected, one is wanted", path.display())]
    Parts {
        /// The file.
        path: PathBuf,
        /// Number of its connected surfaces.
        count: usize,
    },
}

impl SurfaceParts {
    /// Reads the connected surfaces of a file, as [`TriangleSurface::from_soup`] makes them.
    ///
    /// # Errors
    /// If the file can't be read, or its faces are no surface.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SurfaceReadError> {
        let path = path.as_ref();
        let wrong = |cause| SurfaceReadError::Surface {
            path: path.to_path_buf(),
            cause,
        };
        TriangleSurface::from_soup(&read_soup(path)?).map_err(wrong)
    }
}

impl TriangleSurface {
    /// Reads a file with one connected surface (OBJ, PLY, OFF or STL): polygons are cut into
    /// triangles and turned to one side, vertices without faces are left out.
    /// [`SurfaceParts::read`] takes files with more surfaces, and tells what was changed.
    ///
    /// # Errors
    /// If the file can't be read, its faces are no surface, or it holds several that are not
    /// connected. The message names the file and the element.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SurfaceReadError> {
        let path = path.as_ref();
        let mut components = SurfaceParts::read(path)?.components;
        match components.len() {
            1 => Ok(components.swap_remove(0).surface),
            count => Err(SurfaceReadError::Parts {
                path: path.to_path_buf(),
                count,
            }),
        }
    }
}
