//! One job: from a surface and what is wanted of it to a mesh and its report.

use crate::crumbs::{crumbs, left_out};
use crate::deadline::{TimeLimit, Timed};
use crate::engine::{self, Computed};
use crate::error::JobError;
use crate::given::Given;
use crate::hexagon::edge_length;
use crate::join::{
    joined, joined_beyond, joined_mesh, joined_start, joined_target, joined_unrepeated,
    joined_wished,
};
use crate::limits::TypedLimits;
use crate::panel_size::{self, shares};
use crate::portfolio::members;
use crate::settings::{MeshSettings, TypedPanelSize};
use crate::size_field::SizeField;
use crate::suggestion::SurfaceKind;
use crate::units::{Unit, four_digits};
use crate::wishes::{Wishes, check_near};
use phex::directions::Cone;
use phex::layout::MAX_PANELS;
use phex::optimise::led_elsewhere;
use phex::pipeline::{AttemptSummary, ClassicalStatistics};
use phex::quality::{Check, References};
use phex::repetition::Repetition;
use phex::report::{FeatureSizes, InputFile, RunReport, StageTime};
use phex::{Event, MeshOptions, Progress, Session};
use phex_mesh::{HexMesh, PolygonSoup, SurfaceComponent, SurfaceParts, TriangleSurface};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;

/// Where a job may end before there is a planar mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum LastStage {
    /// The panels of the first lattice
    Layout,
}

/// What a job that ends after the layout has made.
pub const LAYOUT_ALONE: &str = "as they are laid out: neither planar nor checked";

/// What is to be covered with panels, and how.
#[derive(Clone)]
pub struct MeshJob {
    /// The surface.
    pub parts: SurfaceParts,
    /// What is told of the surface's origin; `vertices` counts those that a field of sizes has.
    pub input: InputFile,
    /// What is wanted; the files that it names are not read.
    pub settings: MeshSettings,
    /// What those files hold, see [`Given::read`].
    pub given: Given,
    /// An earlier mesh to go on from, and what is told of its origin.
    pub start: Option<(HexMesh, InputFile)>,
    /// Whether a job that is cancelled ends with the best mesh so far.
    pub keep_best: bool,
    /// When it ends with the best mesh so far.
    pub time_limit: Option<TimeLimit>,
    /// Where it ends.
    pub until: Option<LastStage>,
    /// The parts, with what earlier jobs on them have computed: a job with those of an earlier one
    /// takes less time and gives the same bytes.
    pub kept: Arc<Vec<Session>>,
}

impl MeshJob {
    /// A job without an earlier mesh, values in memory or limit of time, to the end.
    pub fn new(parts: SurfaceParts, input: InputFile, settings: MeshSettings) -> Self {
        Self {
            kept: sessions(&parts),
            parts,
            input,
            settings,
            given: Given::default(),
            start: None,
            keep_best: false,
            time_limit: None,
            until: None,
        }
    }
}

/// Sessions of the parts of a surface, in which nothing is computed yet.
pub fn sessions(parts: &SurfaceParts) -> Arc<Vec<Session>> {
    let parts = parts.components.iter();
    Arc::new(parts.map(|c| Session::new(c.surface.clone())).collect())
}

/// What came of a job; lengths are in model units.
#[derive(Clone)]
pub struct JobResult {
    /// The panels, valid or not; the report says which.
    pub mesh: HexMesh,
    /// The panels before the optimiser, where there were any.
    pub start: Option<PolygonSoup>,
    /// The smooth surface that they were fitted to.
    pub smooth: Option<TriangleSurface>,
    /// The surface as it was given.
    pub facets: TriangleSurface,
    /// Figures, checks, settings and times.
    pub report: RunReport,
    /// What the mesh was judged by.
    pub limits: TypedLimits,
    /// What came of guides, cones and sizes, by what each sentence is about.
    pub wishes: Vec<(&'static str, String)>,
    /// What is told though no check fails by it: panels too large for the surface's features,
    /// facets too large for panels.
    pub warnings: Vec<String>,
    /// The ways of the portfolio, for each part of the surface.
    pub tried: Vec<Vec<AttemptSummary>>,
    /// What methods by planes and poles met with, for each part of the surface.
    pub classical: Vec<Option<ClassicalStatistics>>,
}

impl JobResult {
    /// Name of the surface's file without its folder.
    pub fn input_name(&self) -> String {
        let input = self.report.inputs.first();
        let name = input.and_then(|input| Path::new(&input.path).file_name());
        name.map_or_else(
            || "surface".to_owned(),
            |name| name.to_string_lossy().into_owned(),
        )
    }
}

/// Does a job, on the threads of the pool that it is called in.
///
/// # Errors
/// If something given can't be used, there is no panelling, or the caller stops it.
///
/// ```
/// use phex_job::{MeshFile, MeshJob, MeshSettings, run};
/// use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
///
/// let sphere = triangulate(&Shape::from_name("sphere", &[])?, &TriangulationOptions::default())?;
/// let file = MeshFile::in_memory("sphere", sphere.to_soup());
/// let settings = MeshSettings::from_toml("panels = 32\nmax-deviation = '5%'")?;
/// let made = run(&MeshJob::new(file.surfaces()?, file.record, settings), &phex::Silent)?;
/// assert!((28..36).contains(&made.mesh.topology().n_faces()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn run(job: &MeshJob, progress: &dyn Progress) -> Result<JobResult, JobError> {
    let timed = Timed::new(progress, job.time_limit, job.keep_best);
    let mut notes = Notes::new(progress);
    let task = MeshTask::new(job, &timed, &mut notes)?;
    let runs = match &job.start {
        Some((earlier, _)) => task.refit(earlier).map(|run| vec![run]),
        None => task.mesh_each(),
    };
    let runs = runs.map_err(|error| timed.too_late(error))?;
    let is_free = task.settings.stages.steering.is_empty();
    timed
        .stopped(is_free)
        .into_iter()
        .for_each(|n| notes.say(n));
    let mesh = joined_mesh(&runs)?;
    let missed = missed_edge(&task.settings, &mesh, task.facets.diagonal());
    missed.into_iter().for_each(|note| notes.say(note));
    let said = notes.said.into_iter().chain(timed.noted()).collect();
    task.judged(mesh, runs, said)
}

/// Lays out the panels of a job and does no more: neither planar nor judged, they are there in a
/// fraction of the time of [`run`].
///
/// # Errors
/// As [`run`], and for methods by planes.
pub fn lay_out(job: &MeshJob, progress: &dyn Progress) -> Result<HexMesh, JobError> {
    let job = MeshJob {
        until: Some(LastStage::Layout),
        ..job.clone()
    };
    let timed = Timed::new(progress, job.time_limit, job.keep_best);
    let task = MeshTask::new(&job, &timed, &mut Notes::new(progress))?;
    let runs = task.mesh_each().map_err(|error| timed.too_late(error))?;
    joined_mesh(&runs)
}

/// Notes on their way to the caller and into the report.
struct Notes<'a> {
    progress: &'a dyn Progress,
    said: Vec<String>,
}

impl<'a> Notes<'a> {
    fn new(progress: &'a dyn Progress) -> Self {
        let said = Vec::new();
        Self { progress, said }
    }

    fn say(&mut self, message: String) {
        self.said.push(message.clone());
        self.progress.report(&Event::Note { message });
    }
}

/// A job with every default filled in.
struct MeshTask<'a> {
    job: &'a MeshJob,
    progress: &'a Timed<'a>,
    /// The parts that are covered.
    parts: Vec<WantedPart<'a>>,
    /// All of them.
    facets: TriangleSurface,
    panels: u64,
    field: Option<SizeField>,
    settings: MeshSettings,
    limits: TypedLimits,
}

impl<'a> MeshTask<'a> {
    fn new(
        job: &'a MeshJob,
        progress: &'a Timed<'a>,
        notes: &mut Notes<'_>,
    ) -> Result<Self, JobError> {
        job.settings.check()?;
        if job.start.is_none() {
            job.settings.check_effects(&job.given)?;
        }
        let (parts, crumbs) = wanted_parts(job)?;
        let components: Vec<&SurfaceComponent> = parts.iter().map(|part| part.component).collect();
        let facets = joined(components.iter().map(|c| &c.surface))?;
        let mut sentences = job.parts.notes.sentences();
        sentences.extend(crumbs);
        let (unit, across) = (job.settings.unit(), facets.diagonal());
        job.settings.limits.check_edges(unit, across)?;
        sentences.extend(unit.doubted(across));
        sentences.extend(job.settings.limits.doubted(unit, across));
        sentences.extend(without_effect(job, &facets));
        sentences.into_iter().for_each(|note| notes.say(note));
        let field = size_field(job, &components)?;
        let panels = match &job.start {
            Some((earlier, _)) => earlier.topology().n_faces() as u64,
            None => panels(job, field.as_ref(), &facets, &components)?,
        };
        if job.start.is_none() && job.settings.panels.is_none() && panels >= MANY_PANELS {
            notes.say(many_panels(panels, job.settings.unit()));
        }
        let edge = edge_length(facets.area() / panels as f64);
        let unit = job.settings.unit();
        let thin = components.iter();
        let thin = thin.filter_map(|part| thinner_than(edge, &part.surface, unit));
        thin.for_each(|note| notes.say(note));
        let holes = pinholes(edge, &facets);
        holes.into_iter().for_each(|note| notes.say(note));
        let mut settings = job.settings.complete(panels);
        let (stages, given) = (&mut settings.stages, job.given.clone());
        (settings.steering).apply(given.steering, &mut stages.steering, &mut stages.optimise);
        (settings.guides).apply(given.guides, &mut stages.directions.guides);
        check_steering(job, &settings)?;
        check_near(&settings.stages, &facets)?;
        check_repeat(&settings, facets.diagonal(), &components)?;
        let mut limits = TypedLimits::from(&settings);
        if job.start.is_some() {
            limits.boundary = None;
        }
        let extent = facets.diagonal();
        limits.demand(&mut settings.stages.optimise, edge, extent, extent);
        Ok(Self {
            job,
            progress,
            parts,
            facets,
            panels,
            field,
            settings,
            limits,
        })
    }

    /// An earlier mesh, brought to the surface again.
    fn refit(&self, earlier: &HexMesh) -> Result<Computed, JobError> {
        let mut options = self.settings.stages.clone();
        self.demand(&mut options, &self.facets, earlier.mean_edge());
        let reached = engine::refit(earlier, &self.facets, &options, self.progress)?;
        self.unless_interrupted(reached)
    }

    fn mesh_each(&self) -> Result<Vec<Computed>, JobError> {
        let surfaces = self.parts.iter().map(|part| &part.component.surface);
        let areas: Vec<f64> = surfaces.clone().map(TriangleSurface::area).collect();
        let edge = edge_length(areas.iter().sum::<f64>() / self.panels as f64);
        let surfaces: Vec<TriangleSurface> = surfaces.cloned().collect();
        let steering = self.settings.stages.steering.shared(&surfaces, edge);
        let counts = shares(self.panels, &areas);
        let mesh = |(k, (part, &count)): (usize, (&WantedPart<'_>, &u64))| {
            let surface = part.kept;
            let mut options = self.settings.options(count);
            if let TypedPanelSize::EdgeLength(length) = self.settings.size() {
                let unit = self.settings.unit();
                let length = length.length(unit, self.facets.diagonal());
                options.size = phex::PanelSize::EdgeLength(length);
            }
            options.steering = steering[k].clone();
            self.demand(&mut options, &part.component.surface, edge);
            if let Some(field) = &self.field {
                options.size_field = Some(field.of(k).to_vec());
            }
            let made = match self.job.until {
                Some(LastStage::Layout) => engine::lay_out(surface, &options, self.progress),
                None => engine::mesh(surface, &options, self.progress),
            };
            self.unless_interrupted(made.map_err(|error| self.of_part(error, k, count))?)
        };
        let parts = self.parts.iter().zip(&counts).enumerate();
        parts.map(mesh).collect()
    }

    /// The error of a part, which names it where there are several.
    fn of_part(&self, error: JobError, part: usize, panels: u64) -> JobError {
        let (number, all) = (part + 1, self.parts.len());
        let across = self.parts[part].component.surface.diagonal();
        let unit = self.limits.unit;
        match all {
            1 => error,
            _ => error.of_part(&format!(
                "part {number} of {all} ({across:.4} {unit} across, {panels} of the panels)"
            )),
        }
    }

    /// What a run has reached, unless the caller wants nothing any more.
    fn unless_interrupted(&self, reached: Computed) -> Result<Computed, JobError> {
        match self.progress.was_stopped() && !self.job.keep_best {
            true => Err(JobError::Cancelled),
            false => Ok(reached),
        }
    }

    /// Tells the optimiser of the limits, on a surface with panels of edge length `edge`.
    fn demand(&self, options: &mut MeshOptions, surface: &TriangleSurface, edge: f64) {
        let limits = TypedLimits::from(&self.settings);
        let (extent, whole) = (surface.diagonal(), self.facets.diagonal());
        limits.demand(&mut options.optimise, edge, extent, whole);
        options.repeat_rel = self.tolerance().map(|length| length / extent);
    }

    /// The result, with a report on what was reached.
    fn judged(
        self,
        mesh: HexMesh,
        runs: Vec<Computed>,
        notes: Vec<String>,
    ) -> Result<JobResult, JobError> {
        let smooth = joined_target(&runs)?;
        let beyond = joined_beyond(&runs, self.parts.iter().map(|part| part.component))?;
        let elsewhere = led_elsewhere(&self.settings.stages.steering, &mesh);
        let references = References {
            smooth: smooth.as_ref(),
            facets: Some(&self.facets),
            beyond: beyond.as_ref().map(|[smooth, facets]| [smooth, facets]),
            elsewhere: &elsewhere,
            asked: Some(self.panels as usize),
        };
        let mut assessment = self.limits.judge(&mesh, references);
        assessment.measures = (assessment.measures).over_wished(&mesh, &joined_wished(&runs));
        let mut limits = self.limits;
        if !elsewhere.is_empty() {
            // A later judge does not know where the boundary was to go.
            limits.boundary = None;
        }
        let mut report = limits.report("mesh", assessment);
        let earlier = self.job.start.iter().map(|(_, input)| input);
        report.inputs = [&self.job.input]
            .into_iter()
            .chain(earlier)
            .cloned()
            .collect();
        report.threads = rayon::current_num_threads();
        let attempts = runs.iter().flat_map(|run| members(&run.tried));
        report.notes.extend(notes.into_iter().chain(attempts));
        let start = joined_start(&runs);
        report.repetition = self.repetition(&mesh, &runs)?;
        let cones: Vec<Cone> = runs.iter().flat_map(|run| run.cones.clone()).collect();
        let (tried, classical) = runs
            .iter()
            .map(|run| (run.tried.clone(), run.classical.clone()))
            .unzip();
        let bound = runs
            .iter()
            .filter_map(|run| run.classical.as_ref()?.edges_at_bound);
        advise_by_method(
            &mut report.assessment.checks,
            bound.sum(),
            mesh.topology().n_edges(),
        );
        if self.progress.stopped(true).is_some() {
            advise_more_time(&mut report.assessment.checks);
        }
        describe(&mut report, &self.settings, runs)?;
        let wishes = match &self.job.start {
            None => self.wishes(&mesh, smooth.as_ref(), &cones).told(),
            Some(_) => Vec::new(),
        };
        let told = wishes.iter().map(|(what, s)| format!("{what}: {s}"));
        report.notes.extend(told);
        if self.job.until.is_some() {
            report.notes.push(LAYOUT_ALONE.to_owned());
        }
        let features = add_features(&mut report, &mesh, smooth.as_ref().or(Some(&self.facets)));
        let coarse = add_coarse_input(&mut report);
        let warnings = features.into_iter().chain(coarse).collect();
        Ok(JobResult {
            mesh,
            start,
            smooth,
            facets: self.facets,
            report,
            limits,
            wishes,
            warnings,
            tried,
            classical,
        })
    }

    /// How many parts are alike, before edges were made equal and now.
    fn repetition(
        &self,
        mesh: &HexMesh,
        runs: &[Computed],
    ) -> Result<Option<Repetition>, JobError> {
        let before = joined_unrepeated(runs)?;
        let tolerance = self.tolerance();
        let pair = before.zip(tolerance);
        Ok(pair.map(|(before, tolerance)| Repetition::new(&before, mesh, tolerance)))
    }

    /// Difference within which edges count as equal, model units.
    fn tolerance(&self) -> Option<f64> {
        let unit = self.settings.unit();
        let whole = self.facets.diagonal();
        self.settings.repeat.map(|q| q.length(unit, whole))
    }

    fn wishes<'b>(
        &'b self,
        mesh: &'b HexMesh,
        smooth: Option<&'b TriangleSurface>,
        cones: &'b [Cone],
    ) -> Wishes<'b> {
        Wishes {
            options: &self.settings.stages,
            size_field: self.field.as_ref().map(SizeField::range),
            panels: self.panels,
            facets: &self.facets,
            smooth: smooth.unwrap_or(&self.facets),
            mesh,
            cones,
        }
    }
}

/// Adds the sizes that the surface's features allow to a report; a sentence if panels are larger.
pub fn add_features(
    report: &mut RunReport,
    mesh: &HexMesh,
    surface: Option<&TriangleSurface>,
) -> Option<String> {
    let sizes = surface.map(|surface| FeatureSizes::new(mesh, surface));
    let warning = sizes
        .as_ref()
        .and_then(|s| s.warning(&report.assessment.checks));
    report.notes.extend(warning.clone());
    report.feature_sizes = sizes;
    warning
}

/// Distance of panels from the facets, by the limit on that from the smooth surface, or by that
/// itself where it is beyond it, from which on it is told.
const FAR_FROM_FACETS: f64 = 2.0;

/// Adds a sentence to a report, and returns it, where panels are near the smooth surface and far
/// from the facets that were given.
fn add_coarse_input(report: &mut RunReport) -> Option<String> {
    let far = report.assessment.deviation_facets.as_ref()?.deviation_max;
    report.assessment.deviation_smooth.as_ref()?;
    let check = report
        .assessment
        .checks
        .iter()
        .find(|c| c.name == "deviation")?;
    let is_told = far > FAR_FROM_FACETS * check.limit.max(check.value);
    let warning = is_told.then(|| {
        format!(
            "panels are up to {:.1} % of the diagonal off the given facets: the facets are large, and the smooth surface \
             through their corners, which panels follow, bulges between them. Edges that turn by less than 35 degrees \
             count as smooth; smaller facets say what is meant, and --target facets keeps to these",
            100.0 * far
        )
    })?;
    report.notes.push(warning.clone());
    Some(warning)
}

fn size_field(
    job: &MeshJob,
    components: &[&SurfaceComponent],
) -> Result<Option<SizeField>, JobError> {
    let path = job.settings.size_field.as_deref();
    let source = path.map_or_else(|| "size-field".to_owned(), |p| p.display().to_string());
    let field = job.given.size_field.as_ref();
    let of = |sizes: &Vec<f64>| SizeField::new(sizes, &source, &job.input, components);
    field.map(of).transpose()
}

/// Panels from which on a run takes a minute and more, so that a mistyped length is told at once.
const MANY_PANELS: u64 = 20_000;

/// What is said of so many panels where their number was not typed, but lengths or areas.
fn many_panels(panels: u64, unit: Unit) -> String {
    format!(
        "the sizes that were given ask for {panels} panels, which take minutes: if they are too many, is the \
         unit right ({unit})?"
    )
}

fn panels(
    job: &MeshJob,
    field: Option<&SizeField>,
    facets: &TriangleSurface,
    components: &[&SurfaceComponent],
) -> Result<u64, JobError> {
    match field {
        Some(field) if !job.settings.is_sized() => {
            let panels = field.panels(components).round().max(1.0);
            panel_size::checked(panels as u64, facets)
        }
        _ => {
            let settings = &job.settings;
            let unit = settings.unit();
            let of_limits = settings.limits.mean_area(unit, facets.diagonal());
            match of_limits.filter(|_| !settings.is_sized()) {
                Some(limited) => panel_size::of_limit(limited, facets, unit),
                None => panel_size::panels(settings.size(), facets, unit),
            }
        }
    }
}

/// Share of the thickness of a shell that panels of both of its sides may be off them, so that they
/// keep apart.
const OF_THICKNESS: f64 = 0.25;

/// What is said of a closed surface that is thinner than the edges of its panels are long: most
/// often it is a shell with its thickness.
fn thinner_than(edge: f64, surface: &TriangleSurface, unit: Unit) -> Option<String> {
    let thickness = surface.thickness().filter(|t| *t < edge)?;
    let enough = SurfaceKind::new(surface).of_deviation(OF_THICKNESS * thickness);
    let or_more = match enough.edge_length < edge && enough.panels < MAX_PANELS as u64 {
        true => format!(
            "; the panels of both sides keep apart from about {} on",
            enough.panels
        ),
        false => String::new(),
    };
    let [thickness, edge] = [thickness, edge].map(|x| format!("{} {unit}", four_digits(x)));
    Some(format!(
        "the surface is closed and only {thickness} thick (twice its volume over its area), edges of panels are \
         {edge}: to cover a shell that has a thickness, give one of its two sides{or_more}"
    ))
}

/// What is said of holes whose rims are shorter than half of a panel's, `edge` being the length of
/// the edge of a panel: most often a triangle of the file is missing there.
fn pinholes(edge: f64, facets: &TriangleSurface) -> Option<String> {
    let mut small = facets.boundary_loops();
    small.retain(|rim| facets.length_round(rim) < 3.0 * edge);
    let first = facets.positions()[*small.first()?.first()?];
    // So many digits as tell the place.
    let [x, y, z] = <[f64; 3]>::from(first).map(|x| x as f32);
    Some(match small.len() {
        1 => format!(
            "a hole at ({x}, {y}, {z}) is smaller than half a panel: panels keep it open; close it if \
             triangles of the file are missing there"
        ),
        n => format!(
            "{n} holes are smaller than half a panel, the first at ({x}, {y}, {z}): panels keep them open; \
             close them where triangles of the file are missing"
        ),
    })
}

/// What is set and a warm start does not heed, and what asks for a boundary that there is not.
fn without_effect(job: &MeshJob, facets: &TriangleSurface) -> Vec<String> {
    let mut told = Vec::new();
    let idle = job.settings.idle_on_start(&job.given);
    if job.start.is_some() && !idle.is_empty() {
        told.push(format!(
            "`{}` of the job file has no effect with --start, which lays nothing out",
            idle.join("`, `")
        ));
    }
    if job.settings.boundary.is_some() && facets.topology().is_closed() {
        told.push("--boundary has no effect: the surface has no boundary".to_owned());
    }
    told
}

/// A part of the surface that is covered, and what earlier jobs have computed of it.
struct WantedPart<'a> {
    component: &'a SurfaceComponent,
    kept: &'a Session,
}

/// The parts that are covered, and what is said of crumbs that are not.
fn wanted_parts(job: &MeshJob) -> Result<(Vec<WantedPart<'_>>, Option<String>), JobError> {
    let parts = job.parts.components.iter().zip(job.kept.iter());
    let parts = parts.map(|(component, kept)| WantedPart { component, kept });
    let parts: Vec<WantedPart<'_>> = parts.collect();
    if job.settings.all_components {
        return Ok((parts, None));
    }
    let areas: Vec<f64> = (parts.iter().map(|part| part.component.surface.area())).collect();
    let mut is_crumb = crumbs(&areas).into_iter();
    let (crumbs, wanted): (Vec<_>, Vec<_>) =
        (parts.into_iter()).partition(|_| is_crumb.next().unwrap_or(false));
    let triangles = |part: &WantedPart<'_>| part.component.surface.topology().n_faces();
    if wanted.len() > 1 {
        let sizes: Vec<String> = wanted
            .iter()
            .take(10)
            .map(|p| triangles(p).to_string())
            .collect();
        let more = if wanted.len() > sizes.len() {
            ", ..."
        } else {
            ""
        };
        return Err(JobError::input(format!(
            "the surface has {} connected parts ({}{more} triangles): mesh every one with --all-components, or \
             remove those that are not wanted",
            wanted.len(),
            sizes.join(", ")
        )));
    }
    let said = left_out(crumbs.len(), crumbs.iter().map(triangles).sum());
    let said = said.map(|said| format!("{said}; --all-components keeps them"));
    Ok((wanted, said))
}

/// Numbers of vertices refer to a mesh that is known.
fn check_steering(job: &MeshJob, settings: &MeshSettings) -> Result<(), JobError> {
    if job.start.is_none() && !settings.stages.steering.fixed_vertices.is_empty() {
        return Err(JobError::input(
            "--fix: vertices have no numbers before there is a mesh; give points x y z, or an earlier mesh with --start",
        ));
    }
    Ok(())
}

/// Refuses to make edges equal that differ by more than a part is long; `extent` is the diagonal of
/// all parts, which percentages refer to.
fn check_repeat(
    settings: &MeshSettings,
    extent: f64,
    components: &[&SurfaceComponent],
) -> Result<(), JobError> {
    let Some(asked) = settings.repeat else {
        return Ok(());
    };
    let unit = settings.unit();
    let parts = components.iter().map(|c| c.surface.diagonal());
    let least = parts.fold(f64::INFINITY, f64::min);
    match asked.length(unit, extent) <= least {
        true => Ok(()),
        false => Err(JobError::input(format!(
            "--repeat {asked}: edges would be equal that differ by more than the diagonal of the surface, {least:.4} {unit}"
        ))),
    }
}

/// Relative error of the mean edge length that is told.
const TOLD_EDGE_ERROR: f64 = 0.03;

/// What is said where panels do not have the edges that were asked for.
fn missed_edge(settings: &MeshSettings, mesh: &HexMesh, extent: f64) -> Option<String> {
    let TypedPanelSize::EdgeLength(asked) = settings.size() else {
        return None;
    };
    let unit = settings.unit();
    let ratio = mesh.mean_inner_edge() / asked.length(unit, extent);
    let missed = (ratio - 1.0).abs() > TOLD_EDGE_ERROR;
    missed.then(|| {
        format!(
            "--edge-length {asked}: edges between panels are {ratio:.3} times as long on average"
        )
    })
}

/// Fills in how the mesh came about.
fn describe(
    report: &mut RunReport,
    settings: &MeshSettings,
    runs: Vec<Computed>,
) -> Result<(), JobError> {
    let value = serde_json::to_value(settings);
    report.settings = value.map_err(|e| JobError::internal("the settings", &e))?;
    report.seed = settings.stages.layout.seed;
    report.stages = summed(runs.iter().flat_map(|run| &run.stages));
    let (outcomes, statistics): (Vec<Value>, Vec<Value>) = runs
        .into_iter()
        .map(|run| (run.outcome, run.statistics))
        .unzip();
    report.outcome = outcomes.into();
    report.statistics = statistics.into();
    Ok(())
}

/// Times by stage, in the order of their first calls.
fn summed<'a>(times: impl Iterator<Item = &'a StageTime>) -> Vec<StageTime> {
    let mut sums: Vec<StageTime> = Vec::new();
    for time in times {
        match sums.iter_mut().find(|sum| sum.stage == time.stage) {
            Some(sum) => sum.seconds += time.seconds,
            None => sums.push(time.clone()),
        }
    }
    sums
}

/// Changes the advice for a mesh that is not finished. Where panels are not planar yet none of its
/// figures says what a whole run would need.
fn advise_more_time(checks: &mut [Check]) {
    let is_bent = checks.iter().any(|c| !c.pass && c.name == "planarity");
    for check in checks.iter_mut().filter(|c| !c.pass) {
        check.advice = match (is_bent, check.name, check.advice.take()) {
            (true, "planarity", _) => {
                Some("more time: the run ended before panels were planar".to_owned())
            }
            (true, ..) => None,
            (false, _, None) => Some("more time".to_owned()),
            (false, _, Some(other)) => Some(format!("more time, or {other}")),
        };
    }
}

/// Share of edges as short as a method allows from which on more panels come no nearer.
const BOUND: f64 = 0.1;

/// Replaces the advice of distances that do not fall with the number of panels: those of a parallel
/// mesh of which many edges, `bound` of them, are as short as is allowed.
fn advise_by_method(checks: &mut [Check], bound: usize, edges: usize) {
    if (bound as f64) < BOUND * edges as f64 {
        return;
    }
    let far = |c: &&mut Check| !c.pass && ["deviation", "coverage_inner"].contains(&c.name);
    for check in checks.iter_mut().filter(far) {
        check.advice = Some(format!(
            "another --method, or a larger deviation: {bound} of {edges} edges are as short as this method allows, and more panels come no nearer"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    #[test]
    fn a_plate_is_told_from_a_shell_and_from_a_body() {
        let corner = |k: u32| {
            let at = |bit: u32| f64::from(k >> bit & 1);
            phex_mesh::Vec3::new(10.0 * at(0), 10.0 * at(1), 0.2 * at(2))
        };
        let mut faces = vec![
            vec![0, 2, 3, 1],
            vec![4, 5, 7, 6],
            vec![0, 1, 5, 4],
            vec![2, 6, 7, 3],
            vec![0, 4, 6, 2],
            vec![1, 3, 7, 5],
        ];
        let surface = |faces: &[Vec<u32>]| {
            let soup = phex_mesh::PolygonSoup {
                positions: (0..8).map(corner).collect(),
                faces: faces.to_vec(),
            };
            TriangleSurface::from_soup(&soup).unwrap().whole()
        };
        let plate = surface(&faces);
        assert!(
            thinner_than(0.5, &plate, Unit::M)
                .is_some_and(|note| note.contains("one of its two sides"))
        );
        assert_eq!(thinner_than(0.1, &plate, Unit::M), None);
        faces.pop();
        assert_eq!(thinner_than(0.5, &surface(&faces), Unit::M), None);
    }

    #[test]
    fn a_thin_ring_is_told_how_many_panels_keep_its_sides_apart() {
        let shape = Shape::from_name("torus", &[("minor", 0.1)]).unwrap();
        let ring = triangulate(&shape, &TriangulationOptions::default()).unwrap();
        let note = thinner_than(0.2, &ring, Unit::M).unwrap();
        let (_, after) = note.split_once("keep apart from about ").expect("a number");
        let panels: f64 = after.split(' ').next().unwrap().parse().unwrap();
        // Panels of edge e and curvature 10 are 2.5 e^2 off, which is to be 0.1 / 4 at the most.
        let expected = ring.area() / (1.5 * 3.0_f64.sqrt() * 0.01);
        assert!((panels / expected - 1.0).abs() < 0.25, "{note} {expected}");
    }

    #[test]
    fn an_unfinished_mesh_asks_for_more_time_and_not_for_more_panels() {
        let square = |lift: f64| {
            let corners = [
                [0.0, 0.0, lift],
                [1.0, 0.0, 0.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 0.0],
            ];
            corners.map(phex_mesh::Vec3::from).to_vec()
        };
        let flat = TriangleSurface::new(square(0.0), &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let advice = |lift: f64, height: f64| {
            let corners = square(lift).into_iter();
            let corners = corners.map(|p| p + phex_mesh::Vec3::z() * height);
            let mesh = HexMesh::new(corners.collect(), &[[0, 1, 2, 3]]).unwrap();
            let references = References::of_facets(Some(&flat));
            let mut checks = TypedLimits::default().judge(&mesh, references).checks;
            advise_more_time(&mut checks);
            let of = |name: &str| {
                checks
                    .iter()
                    .find(|c| c.name == name)
                    .unwrap()
                    .advice
                    .clone()
            };
            [of("planarity"), of("deviation")]
        };
        let [planarity, deviation] = advice(0.4, 0.1);
        assert!(planarity.unwrap().starts_with("more time") && deviation.is_none());
        let [planarity, deviation] = advice(0.0, 0.1);
        assert!(planarity.is_none() && deviation.unwrap().starts_with("more time, or about"));
    }

    #[test]
    fn many_panels_that_nobody_typed_are_told() {
        let told = many_panels(48_060, Unit::Mm);
        assert!(
            told.contains("48060 panels") && told.contains("(mm)"),
            "{told}"
        );
    }

    #[test]
    fn a_missing_triangle_is_told() {
        let at = |i: u32, j: u32| i * 6 + j;
        let corner = |k: u32| phex_mesh::Vec3::new(f64::from(k % 6), f64::from(k / 6), 0.0);
        let squares = (0..5).flat_map(|i| (0..5).map(move |j| (i, j)));
        let halves = squares.flat_map(|(i, j)| {
            let lower = vec![at(i, j), at(i, j + 1), at(i + 1, j + 1)];
            [lower, vec![at(i, j), at(i + 1, j + 1), at(i + 1, j)]]
        });
        let mut faces: Vec<Vec<u32>> = halves.collect();
        let surface = |faces: &[Vec<u32>]| {
            let soup = phex_mesh::PolygonSoup {
                positions: (0..36).map(corner).collect(),
                faces: faces.to_vec(),
            };
            TriangleSurface::from_soup(&soup).unwrap().whole()
        };
        assert_eq!(pinholes(2.0, &surface(&faces)), None);
        faces.remove(24);
        let told = pinholes(2.0, &surface(&faces));
        assert!(
            told.is_some_and(|note| note.starts_with("a hole at") && note.contains(", 0) is "))
        );
        assert_eq!(pinholes(1.0, &surface(&faces)), None, "wider than panels");
    }

    #[test]
    fn times_are_summed_by_stage() {
        let time = |stage: &str, seconds| StageTime {
            stage: stage.to_owned(),
            seconds,
        };
        let times = [
            time("layout", 1.0),
            time("optimise", 2.0),
            time("layout", 0.5),
        ];
        assert_eq!(
            summed(times.iter()),
            [time("layout", 1.5), time("optimise", 2.0)]
        );
    }
}
