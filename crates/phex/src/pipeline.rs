//! The whole flow: surface -> smooth_surface -> curvature -> directions -> layout -> optimise ->
//! trim -> quality -> search.

mod attempt;
mod brick_wall;
mod check;
mod classical;
mod classical_statistics;
mod clock;
mod domain;
mod error;
mod field;
mod finish;
mod lattice;
mod normalise;
mod options;
mod portfolio;
mod preview;
mod restarts;
mod rim;
mod run;
mod size;
mod steered;
mod subdivide;

pub use attempt::AttemptSummary;
pub use brick_wall::{NetworkCurves, network_curves};
pub use classical_statistics::ClassicalStatistics;
pub use clock::StageSeconds;
pub use domain::{Beyond, continued};
pub use error::PipelineError;
pub use options::{Candidate, MeshOptions, Method, PanelSize};
pub use run::{MeshRun, Statistics};
pub use size::MAX_PANELS;
pub use steered::refit_surface;
pub use subdivide::{Level, subdivide};

use crate::layout::LayoutError;
use crate::progress::Progress;
use crate::smooth_surface::Normalised;
use clock::Clock;
pub(crate) use domain::moved;
use field::panel_length;
use phex_mesh::{TriangleSurface, Vec3};
use preview::InModel;
use run::between_panels;
use size::panel_count;

/// Makes a planar hexagonal mesh of a connected surface.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &TriangulationOptions::default())?;
/// use phex::{MeshOptions, PanelSize, Silent, mesh_surface};
///
/// let options = MeshOptions { size: PanelSize::Panels(32), ..Default::default() };
/// let run = mesh_surface(&sphere, &options, &Silent)?;
/// assert!(run.is_sound());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the input can't be used or no panelling with its topology is found. A mesh that did not
/// become valid is returned, with its offenders, and never called valid.
pub fn mesh_surface(
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    options.check()?;
    let panels = size::wished_panels(surface, options, progress)?;
    let run = mesh_with_panels(surface, panels, options, progress)?;
    steered::steered(run, options, progress)
}

/// Goes to normalised coordinates, which all methods work in, and back.
fn mesh_with_panels(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    let model = Normalised::of(surface);
    let options = normalise::normalised(options, &model)?;
    let progress = &InModel {
        progress,
        similarity: &model.similarity,
    };
    let made = match options.method {
        Method::Lattice | Method::Best => {
            portfolio::mesh_with_panels(&model.surface, panels, &options, progress)
        }
        Method::BrickWall => {
            brick_wall::mesh_with_panels(&model.surface, panels, &options, progress)
        }
        _ => classical::mesh_with_panels(&model, panels, &options, progress),
    };
    match made {
        Ok(run) => Ok(run.restored(&model.similarity)),
        Err(error) => Err(error.in_model(&model)),
    }
}

impl PipelineError {
    /// The same error with its places in model coordinates.
    fn in_model(self, model: &Normalised) -> Self {
        let restore = |p: Vec3| model.similarity.restore(p);
        match self {
            Self::Layout(LayoutError::Domain(e)) => {
                LayoutError::from(e.mapped(|p| classical::place_in(model, p))).into()
            }
            Self::Layout(LayoutError::Duality(e)) => LayoutError::from(e.mapped(restore)).into(),
            Self::Layout(LayoutError::Network(e)) => LayoutError::from(e.mapped(restore)).into(),
            other => other,
        }
    }
}
