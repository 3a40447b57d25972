//! Requests whose answer is a mesh that is judged.

use crate::answer::{Answer, AnswerPart, json};
use crate::inputs::Inputs;
use crate::kept::{Kept, KeptResult};
use phex::Progress;
use phex::koebe::{BoundaryCondition, KoebeOptions, koebe};
use phex::offset::{FitOptions, FitStart, ParallelSpace, fit_parallel};
use phex::quality::{Assessment, References, Verdict};
use phex::repetition::Repetition;
use phex::report::{InputFile, RunReport, StageTime};
use phex_html::{SheetKind, contact_file};
use phex_job::{
    AtBoundary, Content, Given, JobError, JobResult, LastStage, MeshFile, MeshJob, MeshSettings,
    OutputPaths, Planarization, Quantity, SteeringSettings, TimeLimit, TypedLimits, Unit, WayShown,
    chain, edges_by_vertices, time_limit, ways, without_crumbs,
};
use phex_mesh::{EdgeId, HexMesh, LARGEST_COORDINATE, TriangleSurface};
use phex_picture::ContactTile;
use serde::Deserialize;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Points, lines and cones in memory, each a list of numbers as on a line of a file.
#[derive(Deserialize, Default)]
#[serde(default, deny_unknown_fields)]
pub struct GivenValues {
    fix: Vec<Vec<f64>>,
    anchors: Vec<Vec<f64>>,
    cones: Vec<Vec<f64>>,
    curve: Vec<Vec<[f64; 3]>>,
    guide: Vec<Vec<[f64; 3]>>,
}

impl GivenValues {
    /// Adds the values to what files hold.
    fn add_to(self, given: &mut Given) -> Result<(), JobError> {
        let lists = [
            ("fix", &self.fix),
            ("anchors", &self.anchors),
            ("cones", &self.cones),
        ];
        for (name, lines) in lists {
            for (k, numbers) in lines.iter().enumerate() {
                let told = |cause: &str| JobError::Input(format!("{name}: entry {k}: {cause}"));
                if !numbers.iter().all(|x| x.abs() <= LARGEST_COORDINATE) {
                    return Err(told("a number is not finite, or too large"));
                }
                given
                    .add(name, numbers)
                    .map_err(|wanted| told(&format!("{wanted} is wanted")))?;
            }
        }
        for (name, lines) in [("curve", &self.curve), ("guide", &self.guide)] {
            let far = |line: &Vec<[f64; 3]>| {
                let mut numbers = line.iter().flatten();
                line.len() < 2 || !numbers.all(|x| x.abs() <= LARGEST_COORDINATE)
            };
            if let Some(k) = lines.iter().position(far) {
                let told =
                    "it has less than two points, or a number that is not finite or too large";
                return Err(JobError::Input(format!("{name}: line {k}: {told}")));
            }
        }
        given.steering.curves.extend(self.curve);
        given.guides.lines.extend(self.guide);
        Ok(())
    }
}

/// Files that a function is to write.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputsRequest {
    /// Each with the keyword that asks for it, and what it holds.
    outputs: Vec<(String, PathBuf, OutputKind)>,
    /// Files that are read.
    inputs: Vec<PathBuf>,
    /// Settings and a job file, which name more of them.
    #[serde(default)]
    settings: MeshSettings,
    #[serde(default)]
    config: Option<PathBuf>,
}

/// What a file holds.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum OutputKind {
    Mesh,
    Picture,
    Page,
    Other,
}

impl From<OutputKind> for Content {
    fn from(kind: OutputKind) -> Self {
        match kind {
            OutputKind::Mesh => Self::Mesh,
            OutputKind::Picture => Self::Picture,
            OutputKind::Page => Self::Page,
            OutputKind::Other => Self::Other,
        }
    }
}

/// Nothing, if the files can be written, none twice and none that is read.
///
/// # Errors
/// If not, or the job file can't be used.
pub fn check_outputs(
    request: OutputsRequest,
    _: Inputs,
    _: &dyn Progress,
) -> Result<Answer, JobError> {
    let settings = with_job_file(request.settings, request.config.clone())?;
    let read = request.inputs.iter().chain(&request.config);
    let mut paths = OutputPaths::beside(read.map(PathBuf::as_path).chain(settings.inputs()));
    for (name, path, kind) in &request.outputs {
        paths
            .add(path, (*kind).into())
            .map_err(|error| match error {
                JobError::Input(cause) => JobError::Input(format!("{name}: {cause}")),
                other => other,
            })?;
    }
    Ok(Answer::new())
}

/// Options of `phex.mesh`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshRequest {
    /// What was asked for in this call, and not for all of a session.
    asked: AskedOptions,
    settings: MeshSettings,
    config: Option<PathBuf>,
    #[serde(default)]
    given: GivenValues,
    keep_best: bool,
    time_limit: Option<String>,
    until: Option<LastStage>,
    #[serde(default)]
    contact_sheet: Option<PathBuf>,
}

/// Options that are refused where they have no effect.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AskedOptions {
    settings: MeshSettings,
    given: GivenValues,
    /// Whether there are sizes in memory.
    size_field: bool,
    keep_best: bool,
    time_limit: bool,
}

impl AskedOptions {
    /// Refuses those that mean nothing in a job that ends early, or goes on from a mesh.
    fn check(
        self,
        until: Option<LastStage>,
        whole: &MeshSettings,
        has_start: bool,
    ) -> Result<(), JobError> {
        let mut given = Given {
            size_field: self.size_field.then(Vec::new),
            ..Given::default()
        };
        self.given.add_to(&mut given)?;
        let others = [
            ("time-limit", self.time_limit),
            ("keep-best", self.keep_best),
        ];
        self.settings.check_until(until, whole, &given, &others)?;
        match has_start {
            true => self.settings.check_start(&given),
            false => Ok(()),
        }
    }
}

/// A surface covered with panels; a second mesh is an earlier one to go on from.
///
/// # Errors
/// As [`phex_job::run`].
pub fn mesh(
    request: MeshRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let file = inputs.first()?;
    let settings = with_job_file(request.settings, request.config)?;
    let has_start = inputs.files.len() > 1;
    (request.asked).check(request.until, &settings, has_start)?;
    let mut given = Given::read(&settings)?;
    request.given.add_to(&mut given)?;
    given.size_field = inputs.sizes.clone().or(given.size_field);
    let start = inputs.files.get(1);
    let start = start.map(|file| Ok((file.polygon_mesh()?.0, file.record.clone())));
    let length = request.time_limit.as_deref().map(time_limit).transpose();
    let length = length.map_err(|e| JobError::Input(format!("time_limit: {e}")))?;
    let parts = match &inputs.session {
        Some(kept) => kept.parts.clone(),
        None => file.surfaces()?,
    };
    let new = MeshJob::new(parts, file.record.clone(), settings);
    let kept = inputs.session.as_ref().map(|kept| kept.sessions.clone());
    let job = MeshJob {
        given,
        start: start.transpose()?,
        keep_best: request.keep_best,
        until: request.until,
        time_limit: length.and_then(TimeLimit::from_now),
        kept: kept.unwrap_or_else(|| new.kept.clone()),
        ..new
    };
    let made = phex_job::run(&job, progress)?;
    let sheet = contact_of(request.contact_sheet, &made);
    let mut parts = answer(KeptResult {
        mesh: made.mesh,
        report: made.report,
        smooth: made.smooth,
        facets: Some(made.facets),
        start: made.start,
    })?;
    parts.extend(sheet.map(|bytes| ("contact_sheet", AnswerPart::Bytes(bytes))));
    Ok(parts)
}

/// The contact sheet of the ways that were tried, for a file of a name.
fn contact_of(path: Option<PathBuf>, made: &JobResult) -> Option<Vec<u8>> {
    let kind = SheetKind::of(&path?)?;
    let (heading, shown) = ways(made);
    let tiles: Vec<ContactTile<'_>> = shown.iter().map(tile).collect();
    Some(contact_file(kind, &made.input_name(), &heading, &tiles))
}

fn tile<'a>(way: &'a WayShown<'_>) -> ContactTile<'a> {
    ContactTile {
        mesh: way.mesh,
        title: &way.title,
        lines: &way.lines,
    }
}

/// Settings over those of a job file.
fn with_job_file(settings: MeshSettings, file: Option<PathBuf>) -> Result<MeshSettings, JobError> {
    settings.check_job()?;
    let file = file.as_deref().map(MeshSettings::from_file).transpose();
    let file = file.map_err(|error| match error {
        JobError::Input(cause) => JobError::Input(format!("config: {cause}")),
        other => other,
    })?;
    let settings = settings.over(file.unwrap_or_default());
    settings.check().map(|()| settings)
}

/// A mesh with its report, and what is kept for later.
fn answer(result: KeptResult) -> Result<Answer, JobError> {
    let report = result.report.to_json();
    let report = report.map_err(|e| JobError::Internal(e.to_string()))?;
    let verdict = json(&result.report.assessment.verdict)?;
    let smooth = result.smooth.as_ref().map(TriangleSurface::to_soup);
    Ok(vec![
        ("mesh", AnswerPart::Mesh(Some(result.mesh.to_soup()))),
        ("target", AnswerPart::Mesh(smooth)),
        ("report", AnswerPart::Text(report)),
        ("verdict", verdict),
        ("kept", AnswerPart::Kept(Box::new(Kept::new(result)))),
    ])
}

/// Tolerances, and the unit that they refer to.
#[derive(Deserialize, Clone, Copy, Default)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct LimitsRequest {
    planarity: Option<Quantity>,
    max_deviation: Option<Quantity>,
    unit: Option<Unit>,
    boundary: Option<AtBoundary>,
}

impl LimitsRequest {
    /// Refuses a limit of the distance to a surface where there is no surface.
    fn check(self, has_surface: bool) -> Result<(), JobError> {
        match self.max_deviation.filter(|_| !has_surface) {
            None => Ok(()),
            Some(limit) => Err(JobError::Input(format!(
                "max_deviation {limit} has no effect without a surface"
            ))),
        }
    }

    /// The limits, where there is a surface or not.
    fn limits(self, has_surface: bool) -> Result<TypedLimits, JobError> {
        self.check(has_surface)?;
        Ok(self.over(TypedLimits::default()))
    }

    /// What is given, and what was promised where nothing is.
    fn over(self, promised: TypedLimits) -> TypedLimits {
        let boundary = self.boundary.map(Into::into);
        promised.under((self.planarity, self.max_deviation), self.unit, boundary)
    }
}

/// Options of `phex.planarize`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanarizeRequest {
    steering: SteeringSettings,
    config: Option<PathBuf>,
    #[serde(default)]
    given: GivenValues,
    limits: LimitsRequest,
    refit: bool,
}

/// A mesh with planar faces, close to a surface, which is the second mesh, or to where it is.
///
/// # Errors
/// If an input can't be used.
pub fn planarized(
    request: PlanarizeRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let (start, notes) = inputs.first()?.sewn_polygon_mesh()?;
    let surface = inputs.surface()?;
    let typed = MeshSettings {
        unit: request.limits.unit,
        steering: request.steering,
        ..MeshSettings::default()
    };
    let settings = with_job_file(typed, request.config)?;
    settings.steering.check_effects()?;
    let limits = TypedLimits {
        unit: settings.unit(),
        ..request.limits.limits(surface.is_some())?
    };
    let mut given = Given {
        steering: settings.steering.read()?,
        ..Given::default()
    };
    request.given.add_to(&mut given)?;
    let mut how = Planarization::new(
        settings,
        given.steering,
        &limits,
        (&start, surface.as_ref()),
    );
    how.refit |= request.refit;
    let own = || Some(inputs.first().ok()?.surfaces().ok()?.whole());
    let facets = surface.or_else(own);
    let reached = phex_job::planarize(&start, facets.as_ref(), &how, progress)?;
    let mut report = judged(
        "planarize",
        &reached.mesh,
        facets.as_ref(),
        &limits,
        &inputs,
    );
    report.settings =
        json!({ "optimise": how.options, "steering": how.steering, "refit": how.refit });
    report.notes.extend(notes);
    reached.describe(&mut report);
    answer(KeptResult {
        mesh: reached.mesh,
        report,
        smooth: None,
        facets,
        start: reached.start,
    })
}

/// The report of a mesh judged by limits against a surface.
fn judged(
    command: &'static str,
    mesh: &HexMesh,
    facets: Option<&TriangleSurface>,
    limits: &TypedLimits,
    inputs: &Inputs,
) -> RunReport {
    let references = References::of_facets(facets);
    report_of(command, limits.judge(mesh, references), limits, inputs)
}

fn report_of(
    command: &'static str,
    assessment: Assessment,
    limits: &TypedLimits,
    inputs: &Inputs,
) -> RunReport {
    let mut report = limits.report(command, assessment);
    report.inputs = inputs.files.iter().map(|f| f.record.clone()).collect();
    report.threads = rayon::current_num_threads();
    report
}

/// Options of `phex.check`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CheckRequest {
    limits: LimitsRequest,
    /// What an earlier run was judged by.
    promised: Option<TypedLimits>,
    /// A job file, whose limits come before those of the earlier run.
    job: Option<PathBuf>,
    /// The report of the mesh itself, where it is a copy of a result: it is taken up again.
    #[serde(default)]
    copied: Option<CopiedReport>,
}

/// What a report says and a judge does not.
#[derive(Deserialize)]
pub struct CopiedReport {
    verdict: Verdict,
    checks: Vec<CopiedCheck>,
    inputs: Vec<InputFile>,
    unit: String,
    settings: Value,
    seed: u64,
    stages: Vec<StageTime>,
    repetition: Option<Repetition>,
    notes: Vec<String>,
}

/// A check of a report.
#[derive(Deserialize, PartialEq)]
struct CopiedCheck {
    name: String,
    pass: bool,
}

impl CopiedReport {
    /// The number of panels that the run was asked for.
    fn asked(&self) -> Option<usize> {
        self.settings["panels"].as_u64().map(|n| n as usize)
    }

    /// The report of the same mesh judged again, with what that can't say.
    ///
    /// # Errors
    /// If the judge does not say what it said before.
    fn take_up(self, report: &mut RunReport) -> Result<(), JobError> {
        let again = report.assessment.checks.iter().map(|c| CopiedCheck {
            name: c.name.to_owned(),
            pass: c.pass,
        });
        if self.verdict != report.assessment.verdict || !again.eq(self.checks) {
            return Err(JobError::Input(
                "a copy of this result can't be judged as the result was: make the page from the result itself"
                    .to_owned(),
            ));
        }
        report.inputs = self.inputs;
        report.unit = self.unit;
        report.settings = self.settings;
        report.seed = self.seed;
        report.stages = self.stages;
        report.repetition = self.repetition;
        report.notes = self.notes;
        Ok(())
    }
}

impl CheckRequest {
    /// What is typed, and where nothing is what a job or an earlier run promised.
    fn limits(&self, has_surface: bool) -> Result<TypedLimits, JobError> {
        self.limits.check(has_surface)?;
        let job = self.job.as_deref().map(TypedLimits::of_job).transpose()?;
        Ok(self.limits.over(job.or(self.promised).unwrap_or_default()))
    }
}

/// A mesh judged; the second mesh is the surface that it stands for, the third the smooth surface
/// that it was fitted to, the fourth the panels before the last step. Any of these may be empty.
///
/// # Errors
/// If an input can't be used.
pub fn checked(
    request: CheckRequest,
    inputs: Inputs,
    _: &dyn Progress,
) -> Result<Answer, JobError> {
    let there = |k: usize| {
        inputs
            .files
            .get(k)
            .filter(|file| !file.soup.faces.is_empty())
    };
    let mesh = inputs.panels()?;
    let facets = there(1).map(MeshFile::surface).transpose()?;
    let (facets, left_out) = facets.map(|all| without_crumbs(all, &mesh)).unzip();
    let smooth = there(2).map(MeshFile::surface).transpose()?;
    let limits = request.limits(facets.is_some())?;
    let asked = request.copied.as_ref().and_then(CopiedReport::asked);
    let assessment = limits.judge_finished(&mesh, [smooth.as_ref(), facets.as_ref()], asked);
    let mut report = report_of("check", assessment, &limits, &inputs);
    report.notes.extend(left_out.flatten());
    phex_job::add_features(&mut report, &mesh, facets.as_ref());
    if let Some(copied) = request.copied {
        copied.take_up(&mut report)?;
    }
    answer(KeptResult {
        start: there(3).map(|file| file.soup.clone()),
        mesh,
        report,
        smooth,
        facets,
    })
}

/// Options of `phex.koebe`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KoebeRequest {
    boundary: Option<BoundaryCondition>,
    opening: Option<f64>,
}

/// The mesh of a graph whose edges touch the unit sphere.
///
/// # Errors
/// If there is none, or it is not found.
pub fn koebe_mesh(
    request: KoebeRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let graph = inputs.panels()?;
    let closed = graph.topology().is_closed();
    let is_given = request.boundary.is_some() || request.opening.is_some();
    if closed && is_given {
        let told = "boundary and opening have no effect: the mesh has no boundary";
        return Err(JobError::Input(told.to_owned()));
    }
    if request.opening.is_some() && request.boundary == Some(BoundaryCondition::GaussImage) {
        let told =
            "opening has no effect with boundary gauss-image, which says how far the mesh opens";
        return Err(JobError::Input(told.to_owned()));
    }
    let mut options = KoebeOptions::default();
    options.boundary = request.boundary.unwrap_or(options.boundary);
    options.opening = request.opening.unwrap_or(options.opening);
    let made = koebe(&graph, &options, progress).map_err(|e| JobError::Input(chain(&e)))?;
    stopped(progress)?;
    if !made.is_converged() {
        let told = format!("the circles were not found: {:?}", made.outcome.status);
        return Err(JobError::NoResult(told));
    }
    let limits = TypedLimits::default();
    let mut report = judged("koebe", &made.mesh, None, &limits, &inputs);
    report.settings = json!({ "koebe": options, "unit": "sphere of radius 1" });
    report.outcome = json!(made.outcome);
    report.statistics = json!({ "defects": made.defects });
    answer(KeptResult {
        mesh: made.mesh,
        report,
        smooth: None,
        facets: None,
        start: None,
    })
}

/// Ends a computation that was stopped and has no result.
///
/// # Errors
/// If it was.
pub fn stopped(progress: &dyn Progress) -> Result<(), JobError> {
    match progress.is_cancelled() {
        true => Err(JobError::Cancelled),
        false => Ok(()),
    }
}

/// Options of `phex.parallel`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParallelRequest {
    start: Option<FitStart>,
    least_edge: Option<f64>,
    fairness: Option<f64>,
    constant_mean_curvature: Option<f64>,
    /// Edges by their two vertices, and their lengths.
    lengths: Vec<(usize, usize, f64)>,
    basis: bool,
    limits: LimitsRequest,
}

/// The mesh parallel to one that is closest to a surface, the second mesh; without a surface the
/// one whose edges are closest to lengths.
///
/// # Errors
/// If an input or option can't be used.
pub fn parallel(
    request: ParallelRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let (mesh, surface) = (inputs.panels()?, inputs.surface()?);
    let basis = match request.basis {
        true => Some(basis(&space(&mesh)?)),
        false => None,
    };
    let made = match surface {
        Some(surface) => fitted(&request, &mesh, surface, &inputs, progress),
        None => request
            .check_no_fit()
            .and_then(|()| with_lengths(&request, &mesh, &inputs)),
    };
    let mut parts = made?;
    parts.extend(basis.map(|b| ("basis", AnswerPart::Numbers(b))));
    Ok(parts)
}

impl ParallelRequest {
    /// Refuses what says how a mesh is fitted to a surface.
    fn check_no_fit(&self) -> Result<(), JobError> {
        let of_a_fit = [
            ("start", self.start.is_some()),
            ("least_edge", self.least_edge.is_some()),
            ("fairness", self.fairness.is_some()),
            (
                "constant_mean_curvature",
                self.constant_mean_curvature.is_some(),
            ),
        ];
        match of_a_fit.iter().find(|(_, is_set)| *is_set) {
            Some((name, _)) => Err(JobError::Input(format!(
                "{name}: has no effect without a surface: give one, or leave it out"
            ))),
            None => Ok(()),
        }
    }
}

fn space(mesh: &HexMesh) -> Result<ParallelSpace, JobError> {
    ParallelSpace::new(mesh).map_err(|e| JobError::Input(chain(&e)))
}

/// A sparse basis: five numbers for each entry, which are the vector, the edge, its two vertices
/// and the change of its length.
fn basis(space: &ParallelSpace) -> Vec<f64> {
    let topology = space.mesh().topology();
    let entry = |k: usize, &(edge, by): &(EdgeId, f64)| {
        let [from, to] = topology.edge_vertices(edge).map(|v| v.index() as f64);
        [k as f64, edge.index() as f64, from, to, by]
    };
    let vectors = space.basis();
    let numbered = vectors.iter().enumerate();
    numbered
        .flat_map(|(k, change)| change.iter().flat_map(move |e| entry(k, e)))
        .collect()
}

/// The parallel mesh whose edges are closest to lengths, those of the mesh where none is given.
fn with_lengths(
    request: &ParallelRequest,
    mesh: &HexMesh,
    inputs: &Inputs,
) -> Result<Answer, JobError> {
    let (space, topology) = (space(mesh)?, mesh.topology());
    let mut wish = space.lengths(mesh);
    let edges = edges_by_vertices(topology);
    for (k, &(from, to, length)) in request.lengths.iter().enumerate() {
        let edge = edges.get(&(from.min(to), from.max(to)));
        let told = || JobError::Input(format!("lengths: entry {k}: no edge joins {from} and {to}"));
        wish[*edge.ok_or_else(told)?] = length;
    }
    let lengths = space.project_lengths(&wish);
    let misses = wish.iter().zip(&lengths).map(|(w, l)| (w - l).abs());
    let limits = request.limits.limits(false)?;
    let result = space.mesh_with_lengths(&lengths);
    let mut report = judged("parallel", &result, None, &limits, inputs);
    report.statistics = json!({
        "dimension": space.dimension(),
        "rank": space.rank().rank,
        "largest_miss": misses.fold(0.0, f64::max),
        "edges_turned": lengths.iter().filter(|l| **l <= 0.0).count(),
    });
    answer(KeptResult {
        mesh: result,
        report,
        smooth: None,
        facets: None,
        start: Some(mesh.to_soup()),
    })
}

fn fitted(
    request: &ParallelRequest,
    mesh: &HexMesh,
    surface: TriangleSurface,
    inputs: &Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let limits = request.limits.limits(true)?;
    let usual = FitOptions::default();
    let curvature = request.constant_mean_curvature;
    let options = FitOptions {
        start: request.start.unwrap_or(usual.start),
        least_edge: request.least_edge.unwrap_or(usual.least_edge),
        fairness: request.fairness.unwrap_or(usual.fairness),
        constant_mean_curvature: curvature.unwrap_or(usual.constant_mean_curvature),
        ..usual
    };
    let fitted = fit_parallel(mesh, &surface, &options, progress);
    let fitted = fitted.map_err(|e| JobError::Input(chain(&e)))?;
    stopped(progress)?;
    let mut report = judged("parallel", &fitted.mesh, Some(&surface), &limits, inputs);
    report.settings = json!({ "parallel": options });
    report.statistics = json!({
        "status": fitted.status,
        "rounds": fitted.rounds,
        "edges_at_bound": fitted.edges_at_bound,
        "mean_curvature": fitted.mean_curvature,
        "mean_curvature_spread": fitted.mean_curvature_spread,
    });
    answer(KeptResult {
        mesh: fitted.mesh,
        report,
        smooth: None,
        facets: Some(surface),
        start: Some(mesh.to_soup()),
    })
}
