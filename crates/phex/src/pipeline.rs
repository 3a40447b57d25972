//! The whole flow, and its one loop.
//!
//! surface -> target -> curvature -> directions -> layout -> optimise -> trim; panels that stay invalid go back to the
//! layout as seeds to drop, and layout and optimiser run again.

mod brick_wall;
mod check;
mod classical;
mod cures;
mod draws;
mod field;
mod folds;
mod judge;
mod portfolio;
mod repair;
mod rim;
mod rounds;
mod steered;
mod subdivide;

pub use brick_wall::{NetworkCurves, network_curves};
pub use classical::ClassicalStatistics;
pub use portfolio::{AttemptSummary, Candidate};
pub use steered::refit_surface;
pub use subdivide::{Level, subdivide};

use crate::curvature::CurvatureOptions;
use crate::directions::DirectionOptions;
use crate::directions::cones::ConeError;
use crate::directions::guides::Cone;
use crate::directions::size::SizeOptions;
use crate::ground::Beyond;
use crate::layout::brick_wall::{BrickWallOptions, BrickWallStatistics};
use crate::layout::duality::DualOptions;
use crate::layout::lattice::CELL;
use crate::layout::{LayoutError, LayoutOptions, LayoutStatistics};
use crate::offset::fit::FitError;
use crate::optimise::{Offender, OptimiseError, OptimiseOptions, RunSummary, Steering};
use crate::progress::{Event, Progress};
use crate::ranges::BadOption;
use crate::target::{Normalised, Similarity, TargetOptions};
use crate::trim::{Boundary, TrimError};
use field::panel_length;
use judge::between_panels;
use phex_mesh::{HexMesh, PolygonSoup, TriangleSurface, Vec3, Violation};
use phex_numeric::{NumericError, Outcome};
use serde::{Deserialize, Serialize};
use std::time::Instant;
use thiserror::Error;

/// How large panels are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelSize {
    /// Number of panels, at least 1.
    Panels(usize),
    /// Mean edge length, model units; met by another run or two where the first is off.
    EdgeLength(f64),
}

/// How panels are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A hexagonal lattice in the metric of the second fundamental form, on any surface; others of the portfolio's lattices where
    /// that gives no good result.
    #[default]
    Lattice,
    /// All of the portfolio, side by side; the best is kept.
    Best,
    /// A brick wall on a conjugate curve network, where the surface has one.
    BrickWall,
    /// A Goldberg polyhedron on the ellipsoid that the surface is.
    PowerDiagram,
    /// A regular triangulation of the dual surface, mapped back.
    ProjectiveDual,
    /// A coarse mesh of tangent planes, refined through its dual.
    DualSubdivision,
    /// A regular triangulation of the Gauss sphere, and tangent planes with its normals.
    SupportFunction,
    /// Tangent planes of the lattice's panels, intersected.
    TangentPlanes,
    /// A mesh parallel to one that tangent planes give, fitted to the surface.
    Parallel,
}

/// Options of [`mesh_surface`]: one struct per stage, and what concerns the whole flow.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MeshOptions {
    /// Size of the panels.
    pub size: PanelSize,
    /// Where panels are smaller.
    pub sizes: SizeOptions,
    /// Relative size of panels at each vertex of the input (positive; only ratios matter).
    pub size_field: Option<Vec<f64>>,
    /// What happens at the boundary.
    pub boundary: Boundary,
    /// Smooth target.
    pub target: TargetOptions,
    /// Curvature.
    pub curvature: CurvatureOptions,
    /// Metric and direction field.
    pub directions: DirectionOptions,
    /// How panels are laid out.
    pub method: Method,
    /// What is tried where the lattice of these options gives no good result, or beside it; the best is kept.
    pub portfolio: Vec<Candidate>,
    /// Layout by a lattice.
    pub layout: LayoutOptions,
    /// Lattices tried at the most, from different random starts; the most regular is kept.
    pub draws: usize,
    /// Layout as a brick wall.
    pub brick_wall: BrickWallOptions,
    /// The methods that work by planes and their poles.
    pub dual: DualOptions,
    /// Optimiser.
    pub optimise: OptimiseOptions,
    /// Vertices that are held in the end; numbers of vertices make sense for a warm start only.
    pub steering: Steering,
    /// Vertices per panel, at least, of the mesh on which directions and lattice are computed.
    pub field_density: f64,
    /// Vertices per panel, at least, of the mesh on which cells are drawn and to which panels are kept close.
    pub cell_density: f64,
    /// Rounds of the repair loop at the most.
    pub max_repairs: usize,
    /// Clearance, in mean edges, below which a valid panel is given more room in the repair loop.
    pub good_clearance: f64,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            size: PanelSize::Panels(500),
            sizes: SizeOptions::default(),
            size_field: None,
            boundary: Boundary::default(),
            target: TargetOptions::default(),
            curvature: CurvatureOptions::default(),
            directions: DirectionOptions::default(),
            method: Method::default(),
            portfolio: Candidate::others(),
            layout: LayoutOptions::default(),
            draws: 4,
            brick_wall: BrickWallOptions::default(),
            dual: DualOptions::default(),
            optimise: OptimiseOptions::default(),
            steering: Steering::default(),
            field_density: 8.0,
            cell_density: 25.0,
            max_repairs: 12,
            good_clearance: 0.15,
        }
    }
}

/// Distance to the surface, over the diagonal, that panels are to keep to where nothing else is asked for.
const USUAL_DEVIATION: f64 = 5e-3;
/// Share of it with which nothing else is tried: what is measured on a finer surface may be a little more.
const GOOD_SHARE: f64 = 0.9;

impl MeshOptions {
    /// Distance to the surface, over the diagonal, with which nothing else is tried: a little below what is allowed.
    pub(crate) fn good_deviation(&self) -> f64 {
        GOOD_SHARE * self.optimise.max_deviation.unwrap_or(USUAL_DEVIATION)
    }

    /// The same with the usual limit where that is wider; `None` where the limit is no tighter than usual.
    fn with_usual_deviation(&self) -> Option<Self> {
        // In single precision the usual limit itself is a little less.
        let tight = |limit: &f64| *limit < (1.0 - 1e-6) * USUAL_DEVIATION;
        self.optimise.max_deviation.filter(tight)?;
        let mut options = self.clone();
        options.optimise.max_deviation = Some(USUAL_DEVIATION);
        Some(options)
    }

    /// The options for the normalised surface.
    fn normalised(&self, model: &Normalised) -> Result<Self, PipelineError> {
        let mut options = self.clone();
        let guides = self.directions.guides.moved(|p| model.place(p));
        options.directions.guides = guides.with_creases(&model.surface);
        options.dual.quadric = classical::quadric(&self.dual, &model.similarity)?;
        options.optimise.max_deviation = self.optimise.max_deviation.map(without_unit);
        if let Some(values) = &self.size_field {
            check_size_field(values, model.surface.positions().len())?;
            options.size_field = Some(relative_sizes(values));
        }
        Ok(options)
    }
}

/// Refuses sizes that are none, or not one for each vertex of the input.
fn check_size_field(values: &[f64], vertices: usize) -> Result<(), PipelineError> {
    if values.len() != vertices {
        let count = values.len();
        return Err(PipelineError::Size(format!(
            "the size field has {count} values, the surface {vertices} vertices"
        )));
    }
    let wrong = |v: &f64| !(*v > 0.0 && v.is_finite());
    match values.iter().position(wrong) {
        Some(i) => Err(PipelineError::Size(format!(
            "the size at vertex {i} is {}, it must be positive and finite",
            values[i]
        ))),
        None => Ok(()),
    }
}

/// Sizes over the largest one, without the last bits that come from a unit.
fn relative_sizes(values: &[f64]) -> Vec<f64> {
    let largest = values.iter().copied().fold(0.0, f64::max);
    values.iter().map(|v| without_unit(v / largest)).collect()
}

/// A positive ratio in single precision: in another unit it is the same.
fn without_unit(ratio: f64) -> f64 {
    match ratio > f64::from(f32::MIN_POSITIVE) {
        true => f64::from(ratio as f32),
        false => ratio,
    }
}

/// Most panels that one run is asked for: the refined surface has 25 vertices and more for each, and memory ends.
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

/// One round of the repair loop.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RepairRound {
    /// Panels before the round.
    pub panels: usize,
    /// Seeds that were dropped, or moved.
    pub dropped: usize,
    /// Seeds that were added, or moved.
    pub added: usize,
    /// Places where seeds were changed, because panels were invalid or tight or the surface stood off.
    pub places: usize,
    /// Changes that had not helped and were taken back.
    pub undone: usize,
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
    /// The optimiser's runs of the last round.
    pub runs: Vec<RunSummary>,
    /// Factorisations of the optimiser in all rounds.
    pub factorisations: usize,
    /// The repair loop.
    pub repairs: Vec<RepairRound>,
    /// The ways of the portfolio that were tried, the first first; the best was kept.
    pub tried: Vec<AttemptSummary>,
}

/// What [`mesh_surface`] made.
#[derive(Clone)]
pub struct MeshRun {
    /// The panelling in model coordinates.
    pub mesh: HexMesh,
    /// The panels as they were laid out, before the optimiser, in model coordinates; those that trimming removed are left out.
    pub start: Option<PolygonSoup>,
    /// The surface that the panels were kept close to, in model coordinates.
    pub target: TriangleSurface,
    /// That surface continued beyond its boundary, in model coordinates, if panels were kept whole and may stick out.
    pub beyond: Option<Beyond>,
    /// How the optimiser ended.
    pub outcome: Outcome,
    /// Panels that are not as they should be; empty if the mesh is sound.
    pub offenders: Vec<Offender>,
    /// Violations between panels (crossings, folds) that the optimiser does not see.
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
        self.offenders.is_empty() && self.violations.is_empty()
    }
}

/// Makes a planar hexagonal mesh of a connected surface.
///
/// # Errors
/// If the input can't be used or no panelling with its topology is found. A mesh that did not become valid is returned,
/// with its offenders, and never called valid.
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
    let mut panels = panel_count(surface, options.size)?;
    let mut best = mesh_with_panels(surface, panels, options, progress)?;
    let PanelSize::EdgeLength(wanted) = options.size else {
        return Ok(best);
    };
    // Panels that are long or re-entrant have longer edges than regular ones of their area: how much is known afterwards.
    let error = |run: &MeshRun| (run.mesh.mean_edge() / wanted).ln();
    let mut last = error(&best);
    for _ in 0..EDGE_CORRECTIONS {
        let count = (panels as f64 * (2.0 * last).exp()).round();
        let possible = (1.0..=MAX_PANELS as f64).contains(&count) && count != panels as f64;
        if error(&best).abs() < EDGE_TOLERANCE || !possible || progress.is_cancelled() {
            break;
        }
        panels = count as usize;
        let Ok(next) = mesh_with_panels(surface, panels, options, progress) else {
            break;
        };
        last = error(&next);
        if last.abs() < error(&best).abs() && next.is_sound() >= best.is_sound() {
            best = next;
        }
    }
    Ok(best)
}

/// Relative error of the mean edge that is corrected by another run, and such runs at the most: a lattice has the number of panels that is
/// asked for up to a few per cent, so that one may miss.
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
    let options = options.normalised(&model)?;
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
