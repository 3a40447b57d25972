//! The whole flow, and its one loop.
//!
//! surface -> target -> curvature -> directions -> layout -> optimise -> trim; panels that stay invalid go back to the
//! layout as seeds to drop, and layout and optimiser run again.

mod brick_wall;
mod classical;
mod subdivide;

pub use brick_wall::{NetworkCurves, network_curves};
pub use classical::ClassicalStatistics;
pub use subdivide::{Level, subdivide};

use crate::curvature::{self, Curvature, CurvatureOptions};
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::size::{self, SizeOptions};
use crate::directions::{self, DirectionOptions, Directions};
use crate::ground::Ground;
use crate::layout::brick_wall::{BrickWallOptions, BrickWallStatistics};
use crate::layout::duality::DualOptions;
use crate::layout::lattice::CELL;
use crate::layout::seeds::Seed;
use crate::layout::{self, CellSurface, Layout, LayoutError, LayoutOptions, LayoutStatistics};
use crate::optimise::{
    self, Fault, Offender, OptimiseError, OptimiseOptions, Optimised, RunSummary, SurfaceTarget,
};
use crate::parallel_mesh::fit::FitError;
use crate::progress::{Event, Progress};
use crate::target::{Similarity, SmoothTarget, TargetOptions};
use crate::trim::{self, Boundary, TrimError, Trimmed};
use nalgebra::Matrix3;
use phex_mesh::{
    FaceId, FlatFace, HexMesh, PerVertex, PolygonSoup, TriangleSurface, ValidateOptions, VertexId,
    Violation,
};
use phex_numeric::{NumericError, Outcome};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashSet};
use std::time::Instant;
use thiserror::Error;

/// How large panels are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PanelSize {
    /// Number of panels, at least 1.
    Panels(usize),
    /// Mean edge length, model units; met by a second run where the first is off.
    EdgeLength(f64),
}

/// How panels are laid out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// A hexagonal lattice in the metric of the second fundamental form, on any surface.
    #[default]
    Lattice,
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
#[serde(default)]
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
    /// Anisotropies that are tried where the one of `directions` gives no good result; the best is kept.
    pub portfolio: Vec<f64>,
    /// Layout by a lattice.
    pub layout: LayoutOptions,
    /// Layout as a brick wall.
    pub brick_wall: BrickWallOptions,
    /// The methods that work by planes and their poles.
    pub dual: DualOptions,
    /// Optimiser.
    pub optimise: OptimiseOptions,
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
            portfolio: vec![1.5, 1.0],
            layout: LayoutOptions::default(),
            brick_wall: BrickWallOptions::default(),
            dual: DualOptions::default(),
            optimise: OptimiseOptions::default(),
            field_density: 8.0,
            cell_density: 25.0,
            max_repairs: 6,
            good_clearance: 0.15,
        }
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
    /// The surface has several components; the flow takes one at a time.
    #[error("the surface has {0} components, one at a time can be meshed")]
    Components(usize),
    /// A linear system could not be solved.
    #[error("the equations of the direction field could not be solved: {0}")]
    Numeric(#[from] NumericError),
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
    /// Panels that were invalid, or if there were none, tight, and lost their seeds.
    pub dropped: usize,
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
    /// The anisotropies that were tried, the first first; the best was kept.
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
    let panels = panel_count(surface, options.size)?;
    let first = mesh_with_panels(surface, panels, options, progress)?;
    let PanelSize::EdgeLength(wanted) = options.size else {
        return Ok(first);
    };
    // Panels that are long or re-entrant have longer edges than regular ones of their area: how much is known afterwards.
    let error = |run: &MeshRun| (run.mesh.mean_edge() / wanted).ln();
    let count = (panels as f64 * (2.0 * error(&first)).exp()).round();
    if error(&first).abs() < EDGE_TOLERANCE || !(1.0..=MAX_PANELS as f64).contains(&count) {
        return Ok(first);
    }
    match mesh_with_panels(surface, count as usize, options, progress) {
        Ok(second) if error(&second).abs() < error(&first).abs() => Ok(second),
        _ => Ok(first),
    }
}

/// Relative error of the mean edge that is corrected by another run.
const EDGE_TOLERANCE: f64 = 0.08;

fn mesh_with_panels(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    match options.method {
        Method::Lattice => {}
        Method::BrickWall => {
            return brick_wall::mesh_with_panels(surface, panels, options, progress);
        }
        _ => return classical::mesh_with_panels(surface, panels, options, progress),
    }
    let mut clock = Clock::new(progress);
    let similarity = Similarity::normalising(surface);
    let normalised = moved(surface, |p| similarity.normalise(p));
    let ground = clock.stage("target", || Ground::new(&normalised, panels, options))?;
    let mut tried = Vec::new();
    let mut best: Option<Attempt> = None;
    for anisotropy in portfolio(&ground.options) {
        let attempt = match attempt(&ground, anisotropy, &mut clock) {
            Ok(attempt) => attempt,
            // Another anisotropy may do better than the one without a panelling, but not than a mesh.
            Err(PipelineError::Layout(_)) if best.is_some() => continue,
            Err(PipelineError::Cancelled) if best.is_some() => break,
            Err(error) => return Err(error),
        };
        tried.push(attempt.summary.clone());
        let good = attempt.is_good(&ground.options);
        if best.as_ref().is_none_or(|b| attempt.cost() < b.cost()) {
            best = Some(attempt);
        }
        if good || progress.is_cancelled() {
            break;
        }
    }
    let best = best.expect("the first anisotropy gives a mesh or an error");
    let levels = ground.smooth.levels.iter();
    let statistics = Statistics {
        panels_asked: panels,
        target_vertices: levels.map(|l| l.positions().len()).collect(),
        interpolation_error: ground.smooth.interpolation_error,
        layout: best.layout,
        brick_wall: None,
        classical: None,
        runs: best.result.runs.clone(),
        factorisations: best.factorisations,
        repairs: best.repairs,
        tried,
    };
    let mesh = best.left.trimmed.mesh;
    let positions = mesh.positions.map(|p| similarity.restore(*p));
    Ok(MeshRun {
        start: Some(restored(best.left.start, &similarity)),
        mesh: mesh.with_positions(positions),
        target: moved(&best.reported, |p| similarity.restore(p)),
        outcome: best.result.outcome,
        offenders: best.left.offenders,
        violations: best.left.violations,
        statistics,
        stages: clock.stages,
    })
}

/// Anisotropies in the order in which they are tried.
fn portfolio(options: &MeshOptions) -> Vec<f64> {
    let mut list = vec![options.directions.anisotropy];
    for &other in &options.portfolio {
        if !list.contains(&other) {
            list.push(other);
        }
    }
    list
}

/// One member of the portfolio, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttemptSummary {
    /// Largest ratio of panel lengths along the principal directions.
    pub anisotropy: f64,
    /// Panels that are not as they should be.
    pub invalid: usize,
    /// Share of hexagons among the panels inside.
    pub hex: f64,
    /// Largest distance between panels and surface either way, away from the boundary, over the diagonal.
    pub deviation: f64,
    /// Least clearance, mean edges.
    pub clearance: f64,
}

/// A panelling for one anisotropy.
struct Attempt {
    summary: AttemptSummary,
    planar: bool,
    layout: LayoutStatistics,
    result: Optimised,
    left: Left,
    reported: TriangleSurface,
    factorisations: usize,
    repairs: Vec<RepairRound>,
}

impl Attempt {
    /// Whether nothing else needs to be tried.
    fn is_good(&self, options: &MeshOptions) -> bool {
        let s = &self.summary;
        s.invalid == 0 && s.deviation <= GOOD_DEVIATION && s.clearance >= options.good_clearance
    }

    /// What attempts are compared by, smaller is better: valid first, then close, clear and regular.
    fn cost(&self) -> f64 {
        let s = &self.summary;
        let invalid = if self.planar { 0.0 } else { 1e6 } + 100.0 * s.invalid as f64;
        let far = 10.0 * (s.deviation / GOOD_DEVIATION - 1.0).max(0.0);
        let tight = (0.15 / s.clearance.max(1e-3) - 1.0).max(0.0);
        invalid + far + tight + (1.0 - s.hex) + s.deviation / GOOD_DEVIATION * 0.1
    }
}

/// Deviation, over the diagonal, with which no other anisotropy is tried: a little below the usual tolerance of 0.5 %.
const GOOD_DEVIATION: f64 = 4.5e-3;

/// What rounds of the repair loop are compared by, the first difference counts.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Badness {
    not_planar: bool,
    invalid: usize,
    tight: usize,
}

/// Rounds of the repair loop at the most that only give tight panels more room.
const MAX_POLISHES: usize = 2;

/// Layout, optimiser and the repair loop for one anisotropy.
fn attempt(
    ground: &Ground,
    anisotropy: f64,
    clock: &mut Clock<'_>,
) -> Result<Attempt, PipelineError> {
    let (options, progress) = (&ground.options, clock.progress);
    let settings = direction_options(options, anisotropy);
    let field = Field::new(&ground.smooth, ground.panels, options, &settings, clock)?;
    let fine = FineSurface::new(ground, &field);
    let mut seeds = field.seeds.clone();
    let mut layout = clock.stage("layout", || layout::panelling(&fine.cells(), &seeds))??;
    let target = SurfaceTarget::new(ground.close_to(&fine.surface));
    let reported = ground.reported(&fine.surface);
    let mut repairs = Vec::new();
    let mut factorisations = 0;
    let mut best: Option<(Badness, Optimised, Left)> = None;
    let mut polished = 0;
    loop {
        let result = clock.timed("optimise", || {
            optimise::optimise(&layout, &target, &options.optimise, progress)
        })?;
        factorisations += result.runs.iter().map(|r| r.factorisations).sum::<usize>();
        let trimmed = clock.timed("trim", || ground.trimmed(&result.mesh, &fine.surface))?;
        let violations = clock.timed("validate", || between_panels(&trimmed.mesh, reported));
        let offenders = offenders_left(&result.offenders, &trimmed);
        let invalid = invalid_panels(&offenders, &trimmed, &violations, options.boundary);
        let tight = tight_panels(&trimmed, options);
        let badness = Badness {
            not_planar: !is_planar(&offenders),
            invalid: invalid.len(),
            tight: tight.len(),
        };
        if best.as_ref().is_none_or(|b| badness < b.0) {
            let left = Left {
                start: laid_out(&layout, &trimmed),
                trimmed,
                offenders,
                violations,
            };
            best = Some((badness, result, left));
        }
        let dropped = if invalid.is_empty() { tight } else { invalid };
        polished += usize::from(badness.invalid == 0);
        let over = polished > MAX_POLISHES || repairs.len() >= options.max_repairs;
        if dropped.is_empty() || over || progress.is_cancelled() {
            break;
        }
        let before = seeds.len();
        drop_seeds(&mut seeds, &layout, &dropped);
        repairs.push(RepairRound {
            panels: layout.mesh.topology().n_faces(),
            dropped: before - seeds.len(),
        });
        match clock.timed("layout", || layout::panelling(&fine.cells(), &seeds)) {
            Ok(next) => layout = next,
            Err(_) => break,
        }
    }
    let (badness, result, left) = best.expect("the loop runs at least once");
    let summary = clock.timed("validate", || {
        summarise(&left.trimmed.mesh, reported, anisotropy, badness.invalid)
    });
    Ok(Attempt {
        summary,
        planar: !badness.not_planar,
        layout: field.statistics,
        result,
        left,
        reported: reported.clone(),
        factorisations,
        repairs,
    })
}

fn summarise(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    anisotropy: f64,
    invalid: usize,
) -> AttemptSummary {
    let measures = phex_mesh::measure(mesh);
    let deviation = phex_mesh::deviation(mesh, surface);
    AttemptSummary {
        anisotropy,
        invalid,
        hex: measures.hex.unwrap_or(1.0),
        deviation: deviation.deviation_max.max(deviation.coverage_inner_max),
        clearance: measures.clearance.min,
    }
}

/// What a round of the repair loop leaves.
struct Left {
    start: PolygonSoup,
    trimmed: Trimmed,
    offenders: Vec<Offender>,
    violations: Vec<Violation>,
}

/// The panels of a layout of which something is left.
fn laid_out(layout: &Layout, trimmed: &Trimmed) -> PolygonSoup {
    let kept: BTreeSet<FaceId> = trimmed.parent.iter().copied().collect();
    let mut soup = layout.mesh.to_soup();
    let mut numbers = layout.mesh.topology().faces();
    soup.faces
        .retain(|_| numbers.next().is_some_and(|f| kept.contains(&f)));
    soup
}

/// The same polygons in model coordinates.
fn restored(mut soup: PolygonSoup, similarity: &Similarity) -> PolygonSoup {
    for p in &mut soup.positions {
        *p = similarity.restore(*p);
    }
    soup
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

fn moved(
    surface: &TriangleSurface,
    f: impl Fn(phex_mesh::Vec3) -> phex_mesh::Vec3,
) -> TriangleSurface {
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
        match self.stages.iter_mut().find(|s| s.stage == stage) {
            Some(s) => s.seconds += seconds,
            None => self.stages.push(StageSeconds { stage, seconds }),
        }
        result
    }
}

/// Curvature, metric and seeds on the level where the lattice is computed.
struct Field {
    level: usize,
    curvature: Curvature,
    directions: Directions,
    seeds: Vec<Seed>,
    statistics: LayoutStatistics,
}

/// Deviation from the number of panels asked for that is corrected by another lattice.
const COUNT_TOLERANCE: f64 = 0.06;
/// Lattices tried for that at the most.
const COUNT_TRIES: usize = 3;
/// Panels that a boundary adds, per panel length of it: cells that it cuts are kept when half is left, more or less.
const RIM_PANELS: f64 = 0.12;

impl Field {
    fn new(
        smooth: &SmoothTarget,
        panels: usize,
        options: &MeshOptions,
        settings: &DirectionOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let level = smooth.level_with(options.field_density * panels as f64);
        let surface = &smooth.levels[level];
        let length = panel_length(surface, panels);
        let curvature = clock.stage("curvature", || {
            curvature::curvature(surface, length, &options.curvature)
        })?;
        let mut length = panel_lengths(smooth, level, &curvature, length, panels, options)?;
        let mut best: Option<(f64, Self)> = None;
        for _ in 0..COUNT_TRIES {
            let directions = clock.stage("directions", || {
                directions::directions_sized(surface, &curvature, &length, settings)
            })??;
            let (seeds, statistics) = clock.stage("layout", || {
                layout::place_seeds(surface.topology(), &directions, &options.layout)
            })??;
            let ratio = seeds.len().max(1) as f64 / panels as f64;
            let error = ratio.ln().abs();
            if best.as_ref().is_none_or(|b| error < b.0) {
                best = Some((
                    error,
                    Self {
                        level,
                        curvature: curvature.clone(),
                        directions,
                        seeds,
                        statistics,
                    },
                ));
            }
            if error < COUNT_TOLERANCE {
                break;
            }
            length.iter_mut().for_each(|l| *l *= ratio.sqrt());
        }
        Ok(best.expect("at least one lattice is tried").1)
    }
}

/// Screening that keeps varying sizes against the conformal factor, which would even them out.
const SIZED_SCREENING: f64 = 0.5;

fn direction_options(options: &MeshOptions, anisotropy: f64) -> DirectionOptions {
    let mut settings = options.directions.clone();
    settings.anisotropy = anisotropy;
    if options.sizes.adaptive.is_some() || options.size_field.is_some() {
        settings.conformal_screening = settings.conformal_screening.max(SIZED_SCREENING);
    }
    settings
}

/// Panel length at each vertex of a level.
fn panel_lengths(
    smooth: &SmoothTarget,
    level: usize,
    curvature: &Curvature,
    uniform: f64,
    panels: usize,
    options: &MeshOptions,
) -> Result<PerVertex<f64>, PipelineError> {
    let surface = &smooth.levels[level];
    let field = match &options.size_field {
        Some(values) => Some(refined_sizes(smooth, level, values)?),
        None => None,
    };
    let principal = curvature.principal();
    let mut base = uniform;
    // The largest length depends on how much of the surface is finer, and that on the largest length.
    for _ in 0..8 {
        let sizes = size::relative_sizes(surface, &principal, field.as_ref(), base, &options.sizes);
        let Some(relative) = sizes else { break };
        let next = size::base_length(surface, &relative, CELL, panels);
        if (next / base).ln().abs() < 1e-3 {
            return Ok(relative.map(|r| r * next));
        }
        base = next;
    }
    let sizes = size::relative_sizes(surface, &principal, field.as_ref(), base, &options.sizes);
    Ok(sizes.map_or_else(
        || PerVertex::filled(surface.positions().len(), uniform),
        |r| r.map(|r| r * base),
    ))
}

fn refined_sizes(
    smooth: &SmoothTarget,
    level: usize,
    values: &[f64],
) -> Result<PerVertex<f64>, PipelineError> {
    let expected = smooth.levels[0].positions().len();
    if values.len() != expected {
        let message = format!(
            "the size field has {} values, the surface {expected} vertices",
            values.len()
        );
        return Err(PipelineError::Size(message));
    }
    if let Some(i) = values.iter().position(|v| !(*v > 0.0 && v.is_finite())) {
        let message = format!(
            "the size at vertex {i} is {}, it must be positive and finite",
            values[i]
        );
        return Err(PipelineError::Size(message));
    }
    let start = PerVertex::from_vec(values.iter().map(|v| v.ln()).collect());
    let steps = smooth.refinements[..level].iter();
    Ok(steps
        .fold(start, |field, step| step.apply(&field))
        .map(|l| l.exp()))
}

/// Distance of neighbouring panel centres for a number of panels.
fn panel_length(surface: &TriangleSurface, panels: usize) -> f64 {
    let topology = surface.topology();
    let rim: f64 = topology
        .edges()
        .filter(|&e| topology.is_boundary_edge(e))
        .map(|e| topology.edge_vertices(e))
        .map(|[a, b]| (surface.positions()[a] - surface.positions()[b]).norm())
        .sum();
    // area / (CELL L^2) + RIM_PANELS rim / L = panels
    let (a, b, n) = (surface.area() / CELL, RIM_PANELS * rim, panels as f64);
    (b + (b * b + 4.0 * n * a).sqrt()) / (2.0 * n)
}

/// The finest level with everything that cells need.
struct FineSurface {
    surface: TriangleSurface,
    metric: PerVertex<Matrix3<f64>>,
    mesh: IntrinsicMesh,
    corners: HashSet<VertexId>,
}

impl FineSurface {
    fn new(ground: &Ground, field: &Field) -> Self {
        let smooth = &ground.smooth;
        let mut curvature = field.curvature.clone();
        let mut metric = field.directions.metric.clone();
        for step in &smooth.refinements[field.level..] {
            curvature = curvature.refined(step);
            metric = step.apply(&metric);
        }
        let surface = smooth.finest().clone().with_normals(curvature.normal);
        let mesh = IntrinsicMesh::new(&surface, &metric);
        let corners = spaced_corners(smooth, field);
        Self {
            surface,
            metric,
            mesh,
            corners,
        }
    }

    fn cells(&self) -> CellSurface<'_> {
        CellSurface {
            surface: &self.surface,
            metric: &self.metric,
            mesh: &self.mesh,
            corners: &self.corners,
        }
    }
}

/// Sharp boundary corners at least half a panel apart, the sharpest first.
fn spaced_corners(smooth: &SmoothTarget, field: &Field) -> HashSet<VertexId> {
    let positions = smooth.finest().positions();
    let mut kept: Vec<VertexId> = Vec::new();
    for &corner in &smooth.corners {
        let d = |other: &VertexId| {
            let d = positions[corner] - positions[*other];
            d.dot(&(field.directions.metric[corner] * d)).sqrt()
        };
        if kept.iter().all(|other| d(other) > 0.5) {
            kept.push(corner);
        }
    }
    kept.into_iter().collect()
}

/// Violations that concern several panels: the optimiser's own list has the others.
fn between_panels(mesh: &HexMesh, surface: &TriangleSurface) -> Vec<Violation> {
    phex_mesh::violations(mesh, Some(surface), &ValidateOptions::default())
}

/// Panels whose seeds the next round drops: those with a wrong shape; if there are none, those farthest from planar,
/// because one blocked panel keeps all others from their planes.
fn invalid_panels(
    offenders: &[Offender],
    trimmed: &Trimmed,
    violations: &[Violation],
    boundary: Boundary,
) -> BTreeSet<FaceId> {
    let topology = trimmed.mesh.topology();
    let crooked = |o: &&Offender| !matches!(o.fault, Fault::NotPlanar { .. });
    let shape = |v: &&Violation| !matches!(v, Violation::NotPlanar { .. });
    let located = violations.iter().filter(shape);
    let mut invalid: BTreeSet<FaceId> = offenders.iter().filter(crooked).map(|o| o.face).collect();
    invalid.extend(located.flat_map(|v| v.faces(topology)));
    if boundary != Boundary::Whole {
        invalid.extend(trim::small_rim_panels(&trimmed.mesh));
    }
    if invalid.is_empty() {
        invalid.extend(farthest_from_planar(offenders));
    }
    invalid.iter().map(|f| trimmed.parent[*f]).collect()
}

/// Panels with less than a good clearance: mostly one that is much smaller than its neighbours.
fn tight_panels(trimmed: &Trimmed, options: &MeshOptions) -> BTreeSet<FaceId> {
    let mesh = &trimmed.mesh;
    let limit = options.good_clearance * mesh.mean_edge();
    let faces = FlatFace::all(mesh);
    let tight = faces.enumerate().filter(|(f, face)| {
        // A cut says nothing of the panel.
        let cut = options.boundary != Boundary::Whole && mesh.topology().is_boundary_face(*f);
        !cut && face.clearance().distance < limit
    });
    tight.map(|(f, _)| trimmed.parent[f]).collect()
}

fn farthest_from_planar(offenders: &[Offender]) -> impl Iterator<Item = FaceId> {
    let distance = |o: &Offender| match o.fault {
        Fault::NotPlanar { distance } => distance,
        _ => 0.0,
    };
    let worst = offenders.iter().map(distance).fold(0.0, f64::max);
    let far = offenders.iter().filter(move |o| distance(o) > 0.3 * worst);
    far.map(|o| o.face)
}

/// Offenders of which something is left, with the numbers of their parts.
fn offenders_left(offenders: &[Offender], trimmed: &Trimmed) -> Vec<Offender> {
    let parts = |o: &Offender| {
        let (face, fault) = (o.face, o.fault);
        let own = trimmed.parent.enumerate().filter(move |(_, p)| **p == face);
        own.map(move |(face, _)| Offender { face, fault })
    };
    offenders.iter().flat_map(parts).collect()
}

fn is_planar(offenders: &[Offender]) -> bool {
    let planar = |o: &Offender| !matches!(o.fault, Fault::NotPlanar { .. });
    offenders.iter().all(planar)
}

/// Drops the seeds of invalid panels, never those of two neighbours in one round: one of them grows into the gap.
fn drop_seeds(seeds: &mut Vec<Seed>, layout: &Layout, invalid: &BTreeSet<FaceId>) {
    let topology = layout.mesh.topology();
    let mut chosen: BTreeSet<FaceId> = BTreeSet::new();
    for &f in invalid {
        let twins = topology.face_half_edges(f).filter_map(|h| topology.twin(h));
        if !twins.map(|t| topology.face(t)).any(|g| chosen.contains(&g)) {
            chosen.insert(f);
        }
    }
    let dropped: HashSet<VertexId> = chosen.iter().map(|f| layout.face_seed[*f]).collect();
    seeds.retain(|s| !dropped.contains(&s.vertex));
}
