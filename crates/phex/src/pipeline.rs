//! The whole flow: surface -> smooth_surface -> curvature -> directions -> layout -> optimise ->
//! trim -> quality -> search.

mod brick_wall;
mod check;
mod classical;
mod domain;
mod field;
mod finish;
mod lattice;
mod normalise;
mod options;
mod portfolio;
mod restarts;
mod rim;
mod steered;
mod subdivide;

pub use brick_wall::{NetworkCurves, network_curves};
pub use classical::ClassicalStatistics;
pub use domain::{Beyond, continued};
pub use options::{Candidate, MeshOptions, Method, PanelSize};
pub use portfolio::AttemptSummary;
pub use steered::refit_surface;
pub use subdivide::{Level, subdivide};

use crate::directions::cones::ConeError;
use crate::directions::guides::Cone;
use crate::layout::brick_wall::BrickWallStatistics;
use crate::layout::lattice::CELL;
use crate::layout::{LayoutError, LayoutStatistics};
use crate::offset::fit::FitError;
use crate::optimise::{OptimiseError, RunSummary};
use crate::progress::{Event, Progress};
use crate::ranges::BadOption;
use crate::search::SearchSummary;
use crate::smooth_surface::{Normalised, Similarity, SmoothTarget};
use crate::trim::TrimError;
use field::panel_length;
use phex_mesh::validate::ValidateOptions;
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface, Vec3, Violation};
use phex_numeric::{NumericError, Outcome};
use serde::Serialize;
use std::time::Instant;
use thiserror::Error;

/// Most panels that one run is asked for: the refined surface has 25 vertices and more for each,
/// and memory ends.
pub const MAX_PANELS: usize = 200_000;

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
    Layout(#[from] LayoutError),
    /// The optimiser refused its input.
    #[error(transparent)]
    Optimise(#[from] OptimiseError),
    /// No parallel mesh fits.
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Nothing is left within the boundary.
    #[error(transparent)]
    Trim(#[from] TrimError),
    /// The caller cancelled before there was a mesh.
    #[error("cancelled")]
    Cancelled,
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

/// Seconds that a stage took.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageSeconds {
    /// Name of the stage.
    pub stage: &'static str,
    /// Wall time, seconds, summed over repeats.
    pub seconds: f64,
}

/// What the stages did, for the report.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    /// Panels asked for.
    pub panels_asked: usize,
    /// Vertices of each level of the smooth target.
    pub target_vertices: Vec<usize>,
    /// Distance of the input's vertices to the target, over the diagonal.
    pub interpolation_error: f64,
    /// The lattice.
    pub layout: LayoutStatistics,
    /// The cones of the lattice's direction field, model units.
    pub cones: Vec<Cone>,
    /// The brick wall, if that was the method.
    pub brick_wall: Option<BrickWallStatistics>,
    /// The method by planes and poles, if that was one.
    pub classical: Option<ClassicalStatistics>,
    /// The optimiser's runs.
    pub runs: Vec<RunSummary>,
    /// Factorisations of these.
    pub factorisations: usize,
    /// The search for local changes, if there was one.
    pub search: Option<SearchSummary>,
    /// The ways of the portfolio that were tried, the first first; the best was kept.
    pub tried: Vec<AttemptSummary>,
}

impl Statistics {
    /// Those of a target alone.
    fn of(smooth: &SmoothTarget, panels: usize) -> Self {
        Self {
            panels_asked: panels,
            target_vertices: smooth.levels.iter().map(|l| l.positions().len()).collect(),
            interpolation_error: smooth.interpolation_error,
            layout: LayoutStatistics::default(),
            cones: Vec::new(),
            brick_wall: None,
            classical: None,
            runs: Vec::new(),
            factorisations: 0,
            search: None,
            tried: Vec::new(),
        }
    }
}

/// What [`mesh_surface`] made.
#[derive(Clone)]
pub struct MeshRun {
    /// The panelling in model coordinates.
    pub mesh: HexMesh,
    /// The panels as they were laid out, before the optimiser, in model coordinates; those that
    /// trimming removed are left out.
    pub start: Option<PolygonSoup>,
    /// The surface that the panels were kept close to, in model coordinates.
    pub target: TriangleSurface,
    /// That surface continued beyond its boundary, in model coordinates, if panels were kept whole
    /// and may stick out.
    pub beyond: Option<Beyond>,
    /// How the optimiser ended.
    pub outcome: Outcome,
    /// Everything that is wrong with the mesh; empty if it is sound.
    pub violations: Vec<Violation>,
    /// What the stages did.
    pub statistics: Statistics,
    /// Where the time went.
    pub stages: Vec<StageSeconds>,
}

impl MeshRun {
    /// The same in model coordinates.
    fn restored(mut self, similarity: &Similarity) -> Self {
        let restore = |p: Vec3| similarity.restore(p);
        let positions = self.mesh.positions.map(|p| restore(*p));
        self.mesh = self.mesh.with_positions(positions);
        for p in self.start.iter_mut().flat_map(|s| &mut s.positions) {
            *p = restore(*p);
        }
        self.target = moved(&self.target, restore);
        self.beyond = self.beyond.map(|b| b.moved(restore));
        for cone in &mut self.statistics.cones {
            cone.position = restore(cone.position.into()).into();
        }
        if let Some(centre) = (self.statistics.classical.as_mut()).and_then(|c| c.centre.as_mut()) {
            *centre = restore((*centre).into()).into();
        }
        self
    }

    /// Whether every panel is planar and simple, and no two of them meet where they should not.
    pub fn is_sound(&self) -> bool {
        self.violations.is_empty()
    }
}

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
    steered::steered(mesh_of_size(surface, options, progress)?, options, progress)
}

fn mesh_of_size(
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    let panels = panel_count(surface, options.size)?;
    let panels = match options.size {
        PanelSize::Panels(_) => panels,
        PanelSize::EdgeLength(wanted) => {
            corrected_count(surface, (panels, wanted), options, progress)?
        }
    };
    mesh_with_panels(surface, panels, options, progress)
}

/// The number of panels with which their mean edge is nearest to what is wanted, of a few. Panels
/// that are long or re-entrant have longer edges than regular ones of their area: how much is known
/// when they are there. What is searched afterwards hardly changes it.
fn corrected_count(
    surface: &TriangleSurface,
    (mut panels, wanted): (usize, f64),
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<usize, PipelineError> {
    let options = &MeshOptions {
        search: false,
        ..options.clone()
    };
    let mut best: Option<(f64, usize)> = None;
    for _ in 0..=EDGE_CORRECTIONS {
        let run = mesh_with_panels(surface, panels, options, progress);
        let run = match (run, best) {
            (Err(error), None) => return Err(error),
            (Err(_), Some(_)) => break,
            (Ok(run), _) => run,
        };
        let error = (run.mesh.mean_edge() / wanted).ln();
        if best.is_none_or(|b| error.abs() < b.0) {
            best = Some((error.abs(), panels));
        }
        let count = (panels as f64 * (2.0 * error).exp()).round();
        let possible = (1.0..=MAX_PANELS as f64).contains(&count) && count != panels as f64;
        if error.abs() < EDGE_TOLERANCE || !possible || progress.is_cancelled() {
            break;
        }
        panels = count as usize;
    }
    Ok(best.map_or(panels, |b| b.1))
}

/// Relative error of the mean edge that is corrected by another run, and such runs at the most: a
/// lattice has the number of panels that is asked for up to a few per cent, so that one may miss.
const EDGE_TOLERANCE: f64 = 0.025;
const EDGE_CORRECTIONS: usize = 4;

/// Goes to normalised coordinates, which all methods work in, and back.
fn mesh_with_panels(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    let model = Normalised::of(surface);
    let options = normalise::normalised(options, &model)?;
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

/// Panels that a size means for a surface.
fn panel_count(surface: &TriangleSurface, size: PanelSize) -> Result<usize, PipelineError> {
    let (_, components) = surface.topology().components();
    if components != 1 {
        return Err(PipelineError::Components(components));
    }
    let count = match size {
        PanelSize::Panels(n) => n as f64,
        // A regular hexagon of edge e has area 3 sqrt(3) / 2 e^2.
        PanelSize::EdgeLength(e) if e > 0.0 && e.is_finite() => {
            surface.area() / (3.0 * CELL * e * e)
        }
        PanelSize::EdgeLength(e) => {
            return Err(PipelineError::Size(format!(
                "the edge length must be positive and finite, not {e}"
            )));
        }
    };
    if count < 1.0 || count.is_nan() {
        return Err(PipelineError::Size(format!(
            "{count:.3} panels were asked for, at least 1 is needed"
        )));
    }
    if count > MAX_PANELS as f64 {
        return Err(PipelineError::Size(format!(
            "{count:.0} panels were asked for, more than {MAX_PANELS}"
        )));
    }
    Ok(count.round() as usize)
}

/// What is wrong with a mesh in itself, and with the sides that its panels show.
fn between_panels(mesh: &HexMesh, surface: &TriangleSurface) -> Vec<Violation> {
    phex_mesh::violations(mesh, Some(surface), &ValidateOptions::default())
}

pub(crate) fn moved(surface: &TriangleSurface, f: impl Fn(Vec3) -> Vec3) -> TriangleSurface {
    let positions = surface.positions().map(|p| f(*p)).into_vec();
    let triangles: Vec<[u32; 3]> = surface
        .topology()
        .face_lists()
        .into_iter()
        .map(|f| [f[0], f[1], f[2]])
        .collect();
    TriangleSurface::new(positions, &triangles)
        .expect("a similarity keeps a manifold a manifold")
        .with_normals(surface.normals().clone())
}

/// Names stages to the progress and sums their times.
struct Clock<'a> {
    progress: &'a dyn Progress,
    stages: Vec<StageSeconds>,
}

impl<'a> Clock<'a> {
    fn new(progress: &'a dyn Progress) -> Self {
        Self {
            progress,
            stages: Vec::new(),
        }
    }

    /// Adds what another clock measured.
    fn add(&mut self, stages: &[StageSeconds]) {
        for StageSeconds { stage, seconds } in stages {
            match self.stages.iter_mut().find(|s| s.stage == *stage) {
                Some(s) => s.seconds += seconds,
                None => self.stages.push(StageSeconds {
                    stage,
                    seconds: *seconds,
                }),
            }
        }
    }

    /// A stage before there is a mesh: a cancelled run ends here.
    fn stage<T>(
        &mut self,
        stage: &'static str,
        work: impl FnOnce() -> T,
    ) -> Result<T, PipelineError> {
        if self.progress.is_cancelled() {
            return Err(PipelineError::Cancelled);
        }
        Ok(self.timed(stage, work))
    }

    /// A stage that a cancelled run still makes, because what was reached is returned.
    fn timed<T>(&mut self, stage: &'static str, work: impl FnOnce() -> T) -> T {
        self.progress.report(&Event::StageStarted { stage });
        let start = Instant::now();
        let result = work();
        let seconds = start.elapsed().as_secs_f64();
        self.progress.report(&Event::StageFinished { stage });
        self.add(&[StageSeconds { stage, seconds }]);
        result
    }
}
