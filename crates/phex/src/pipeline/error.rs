//! Why nothing was made.

use crate::directions::cones::ConeError;
use crate::koebe::KoebeError;
use crate::layout::LayoutError;
use crate::offset::fit::FitError;
use crate::optimise::OptimiseError;
use crate::ranges::BadOption;
use crate::symmetry::Symmetry;
use crate::trim::TrimError;
use phex_numeric::NumericError;
use thiserror::Error;

/// Why nothing was made.
#[derive(Clone, Debug, Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The size of the panels makes no sense for the surface.
    #[error("{0}")]
    Size(String),
    /// An option is outside its range.
    #[error(transparent)]
    Option(#[from] BadOption),
    /// The surface has several components; the flow takes one at a time.
    #[error("the surface has {0} components, one at a time can be meshed")]
    Components(usize),
    /// A linear system could not be solved.
    #[error("the equations of the direction field could not be solved: {0}")]
    Numeric(#[from] NumericError),
    /// The prescribed cones can't be.
    #[error(transparent)]
    Cones(#[from] ConeError),
    /// No panelling exists.
    #[error(transparent)]
    Layout(LayoutError),
    /// The optimiser refused its input.
    #[error(transparent)]
    Optimise(#[from] OptimiseError),
    /// Vertices can't be moved to the boundary.
    #[error(
        "{method} can't move vertices to the boundary, which would turn edges: the boundary can be `whole` or `clip`"
    )]
    Snap {
        /// The method.
        method: &'static str,
    },
    /// The panels' graph has no Koebe mesh.
    #[error(transparent)]
    Koebe(#[from] KoebeError),
    /// No parallel mesh fits.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Nothing is left within the boundary.
    #[error(transparent)]
    Trim(#[from] TrimError),
    /// Only lattices and brick walls are laid out before they become planar.
    #[error("only `lattice` and `brick-wall` lay panels out before these become planar")]
    NoPreview,
    /// The symmetry that is asked for can't be had.
    #[error("symmetry `{asked}`: {reason}")]
    Symmetry {
        /// What is asked for.
        asked: Symmetry,
        /// What is in the way.
        reason: String,
    },
    /// The caller cancelled before there was a mesh.
    #[error("cancelled")]
    Cancelled,
}

impl From<LayoutError> for PipelineError {
    fn from(error: LayoutError) -> Self {
        match error {
            LayoutError::Cancelled => Self::Cancelled,
            other => Self::Layout(other),
        }
    }
}
