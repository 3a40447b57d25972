//! The whole flow: surface -> smooth_surface -> curvature -> directions -> layout -> optimise ->
//! trim -> quality -> search -> repetition.

mod attempt;
mod best_field;
mod brick_wall;
mod check;
mod classical;
mod classical_statistics;
mod clock;
mod domain;
mod error;
mod field;
mod finish;
mod laid_out;
mod lattice;
mod normalise;
mod options;
mod portfolio;
mod preview;
mod repeated;
mod restarts;
mod rim;
mod run;
mod session;
mod size;
mod sized;
mod steered;
mod subdivide;
mod symmetric;
mod watched;

pub use attempt::AttemptSummary;
pub use brick_wall::{NetworkCurves, network_curves};
pub use classical_statistics::ClassicalStatistics;
pub use clock::StageSeconds;
pub use domain::{Beyond, continued};
pub use error::PipelineError;
pub use options::{Candidate, Effort, MeshOptions, Method, PanelSize};
pub use preview::LatticePreview;
pub use run::{MeshRun, Statistics};
pub use session::Session;
pub use steered::refit_surface;
pub use subdivide::{Level, subdivide};

use crate::progress::Progress;
use clock::Clock;

use phex_mesh::TriangleSurface;
use size::panel_count;
use sized::panel_length;

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
    Session::new(surface.clone()).run(options, progress)
}
