//! `phex mesh`: from a surface to planar hexagonal panels.

use super::deliver::Delivery;
use super::use_threads;
use crate::args::{LastStage, MeshCommand};
use crate::engine::{self, Computed};
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::input::MeshFile;
use crate::method_summary::{members, of_method, of_portfolio};
use crate::output::{Content, check_writable, write_mesh};
use crate::panel_size::{self, edge_length, shares};
use crate::progress::{Reporter, is_interrupted, keep_best, take_interruption};
use crate::settings::{MeshSettings, TypedPanelSize};
use crate::size_field::SizeField;
use crate::summary;
use crate::verdict::{TypedLimits, written};
use crate::wishes::{Wishes, check_near};
use anyhow::Context;
use phex::MeshOptions;
use phex::directions::Cone;
use phex::optimise::led_elsewhere;
use phex::quality::References;
use phex::report::{RunReport, StageTime};
use phex_mesh::{HexMesh, PolygonSoup, SurfaceComponent, TriangleSurface};
use serde_json::Value;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, there is no result, or an output can't be written.
pub fn run(command: &MeshCommand) -> Result<Exit, Failure> {
    let settings = settings(command)?;
    check_writable(&outputs(command), &inputs(command, &settings))?;
    let threads = use_threads(settings.threads)?;
    let reporter = Reporter::new(&command.talk).within(command.time_limit);
    let file = MeshFile::read(&command.input)?;
    let parts = file.surfaces()?;
    check_components(&parts.components, &settings)?;
    let facets = parts.whole();
    let mut notes = parts.notes.sentences();
    notes.extend(without_effect(command, &settings, &facets));
    notes.iter().for_each(|note| reporter.note(note));

    let unit = settings.unit.unwrap_or_default();
    let field = settings.size_field.as_deref();
    let field = field.map(|path| SizeField::read(path, &file, &parts.components));
    let field = field.transpose()?;
    let panels = match &field {
        Some(field) if !settings.is_sized() => {
            let panels = field.panels(&parts.components).round().max(1.0);
            panel_size::checked(panels as u64, &facets)?
        }
        _ => panel_size::panels(settings.size(), &facets, unit)?,
    };
    let mut settings = settings.complete(panels);
    let stages = &mut settings.stages;
    (settings.steering).apply(&mut stages.steering, &mut stages.optimise)?;
    settings.guides.apply(&mut stages.directions.guides)?;
    check_steering(command, &settings)?;
    check_near(&settings.stages, &facets)?;
    let mut limits = TypedLimits::from(&settings);
    if command.start.is_some() {
        limits.boundary = None;
    }
    let (edge, extent) = (
        edge_length(facets.area() / panels as f64),
        facets.diagonal(),
    );
    limits.demand(&mut settings.stages.optimise, edge, extent, extent);
    let job = MeshJob {
        components: &parts.components,
        facets: &facets,
        panels,
        field: field.as_ref(),
        settings: &settings,
        reporter: &reporter,
        keeps_best: command.keep_best,
        until: command.until,
    };
    if command.keep_best {
        keep_best();
    }
    let runs = match &command.start {
        Some(path) => job.refit(path).map(|run| vec![run]),
        None => job.mesh_each(),
    };
    reporter.finish();
    let runs = runs.map_err(|failure| too_late(failure, command))?;
    if let Some(note) = stopped(command, &reporter, settings.stages.steering.is_empty()) {
        reporter.note(&note);
        notes.push(note);
    }
    let mesh = joined_mesh(&runs)?;
    if let Some(note) = missed_edge(&settings, &mesh, extent) {
        reporter.note(&note);
        notes.push(note);
    }
    let smooth = joined_target(&runs)?;
    let beyond = joined_beyond(&runs, &parts.components)?;

    let elsewhere = led_elsewhere(&settings.stages.steering, &mesh);
    let references = References {
        smooth: smooth.as_ref(),
        facets: Some(&facets),
        beyond: beyond.as_ref().map(|[smooth, facets]| [smooth, facets]),
        elsewhere: &elsewhere,
    };
    let assessment = limits.judge(&mesh, references);
    let told = |run: &Computed| of_portfolio(&run.tried) + &of_method(run.classical.as_ref());
    let methods: String = runs.iter().map(told).collect();
    if !elsewhere.is_empty() {
        // A later judge does not know where the boundary was to go.
        limits.boundary = None;
    }
    let mut report = limits.report("mesh", assessment);
    report.inputs = vec![file.record];
    report.threads = threads;
    report.notes = notes;
    report
        .notes
        .extend(runs.iter().flat_map(|run| members(&run.tried)));
    let start = joined_start(&runs);
    let cones: Vec<Cone> = runs.iter().flat_map(|run| run.cones.clone()).collect();
    describe(&mut report, &settings, runs)?;
    let shown = Shown {
        surface: smooth.as_ref().or(Some(&facets)),
        start: start.as_ref(),
        given: Some(&facets),
        mesh: &mesh,
    };
    let wishes = Wishes {
        options: &settings.stages,
        panels,
        facets: &facets,
        smooth: smooth.as_ref().unwrap_or(&facets),
        mesh: &mesh,
        cones: &cones,
    };
    let wished = match command.start {
        None => summary::of_wishes(&mut report, wishes.told()),
        Some(_) => String::new(),
    };
    let features = summary::of_features(&mut report, &mesh, shown.surface);
    if let (Some(path), Some(smooth)) = (&command.write_target, &smooth) {
        write_mesh(path, &to_soup(smooth))?;
        report.outputs.push(written("smooth_target", path));
    }
    let (panels, before) = match command.until {
        Some(LastStage::Layout) => {
            report.notes.push(LAYOUT_ALONE.to_owned());
            let count = mesh.topology().n_faces();
            (
                false,
                format!("layout     {count} panels, {LAYOUT_ALONE}\n"),
            )
        }
        None => (true, methods),
    };
    Delivery {
        shown,
        output: Some(&command.output),
        keep_invalid: command.keep_invalid,
        panels,
        extras: &command.extras,
        talk: &command.talk,
        limits,
        before,
        after: wished + &features,
        report,
    }
    .send()
}

fn settings(command: &MeshCommand) -> Result<MeshSettings, Failure> {
    let file = command
        .config
        .as_deref()
        .map(MeshSettings::from_file)
        .transpose()?;
    let settings = command.settings.clone().over(file.unwrap_or_default());
    settings.check()?;
    let typed = command.settings.idle_on_start();
    match &command.start {
        Some(_) if !typed.is_empty() => Err(Failure::input(format!(
            "`{}` has no effect with `start`, which lays nothing out: leave it out",
            typed.join("`, `")
        ))),
        Some(_) => Ok(settings),
        None => settings.check_effects().map(|()| settings),
    }
}

/// What a job file sets and a warm start does not heed, and what asks for a boundary that there is
/// not.
fn without_effect(
    command: &MeshCommand,
    settings: &MeshSettings,
    facets: &TriangleSurface,
) -> Vec<String> {
    let mut told = Vec::new();
    let idle = settings.idle_on_start();
    if command.start.is_some() && !idle.is_empty() {
        told.push(format!(
            "`{}` of the job file has no effect with --start, which lays nothing out",
            idle.join("`, `")
        ));
    }
    if settings.boundary.is_some() && facets.boundary_loops().is_empty() {
        told.push("--boundary has no effect: the surface has no boundary".to_owned());
    }
    told
}

fn inputs<'a>(command: &'a MeshCommand, settings: &'a MeshSettings) -> Vec<&'a Path> {
    std::iter::once(command.input.as_path())
        .chain(command.config.as_deref())
        .chain(command.start.as_deref())
        .chain(settings.steering.inputs())
        .chain(settings.guides.inputs())
        .chain(settings.size_field.as_deref())
        .collect()
}

fn outputs(command: &MeshCommand) -> Vec<(&Path, Content)> {
    let target = command
        .write_target
        .as_deref()
        .map(|path| (path, Content::Mesh));
    std::iter::once((command.output.as_path(), Content::Mesh))
        .chain(target)
        .chain(command.extras.outputs())
        .collect()
}

fn check_components(
    components: &[SurfaceComponent],
    settings: &MeshSettings,
) -> Result<(), Failure> {
    if components.len() == 1 || settings.all_components {
        return Ok(());
    }
    let sizes: Vec<String> = components
        .iter()
        .take(10)
        .map(|c| c.surface.topology().n_faces().to_string())
        .collect();
    let more = if components.len() > sizes.len() {
        ", ..."
    } else {
        ""
    };
    Err(Failure::input(format!(
        "the surface has {} connected parts ({}{more} triangles): mesh every one with --all-components, or remove \
         those that are not wanted",
        components.len(),
        sizes.join(", ")
    )))
}

/// Numbers of vertices refer to a mesh that is known.
fn check_steering(command: &MeshCommand, settings: &MeshSettings) -> Result<(), Failure> {
    if command.start.is_none() && !settings.stages.steering.fixed_vertices.is_empty() {
        return Err(Failure::input(
            "--fix: vertices have no numbers before there is a mesh; give points x y z, or an earlier mesh with --start",
        ));
    }
    Ok(())
}

/// What is to be covered, and how.
struct MeshJob<'a> {
    components: &'a [SurfaceComponent],
    /// All components.
    facets: &'a TriangleSurface,
    panels: u64,
    field: Option<&'a SizeField>,
    settings: &'a MeshSettings,
    reporter: &'a Reporter,
    /// Whether an interruption ends the computation alone.
    keeps_best: bool,
    /// Where it ends.
    until: Option<LastStage>,
}

impl MeshJob<'_> {
    /// An earlier mesh, brought to the surface again.
    fn refit(&self, path: &Path) -> Result<Computed, Failure> {
        let (earlier, _) = MeshFile::read(path)?.polygon_mesh()?;
        let mut options = self.settings.stages.clone();
        self.demand(&mut options, self.facets, earlier.mean_edge());
        let reached = engine::refit(&earlier, self.facets, &options, self.reporter)?;
        self.unless_interrupted(reached)
    }

    fn mesh_each(&self) -> Result<Vec<Computed>, Failure> {
        let areas: Vec<f64> = self.components.iter().map(|c| c.surface.area()).collect();
        let edge = edge_length(areas.iter().sum::<f64>() / self.panels as f64);
        let surfaces: Vec<TriangleSurface> =
            self.components.iter().map(|c| c.surface.clone()).collect();
        let steering = self.settings.stages.steering.shared(&surfaces, edge);
        let counts = shares(self.panels, &areas);
        let mesh = |(k, (part, &count)): (usize, (&SurfaceComponent, &u64))| {
            let mut options = self.settings.options(count);
            if let TypedPanelSize::EdgeLength(length) = self.settings.size() {
                let unit = self.settings.unit.unwrap_or_default();
                let length = length.length(unit, self.facets.diagonal());
                options.size = phex::PanelSize::EdgeLength(length);
            }
            options.steering = steering[k].clone();
            self.demand(&mut options, &part.surface, edge);
            if let Some(field) = self.field {
                options.size_field = Some(field.of(k).to_vec());
            }
            let made = match self.until {
                Some(LastStage::Layout) => engine::lay_out(&part.surface, &options, self.reporter),
                None => engine::mesh(&part.surface, &options, self.reporter),
            };
            self.unless_interrupted(made?)
        };
        let parts = self.components.iter().zip(&counts).enumerate();
        parts.map(mesh).collect()
    }

    /// What a run has reached, unless an interruption ends the program.
    fn unless_interrupted(&self, reached: Computed) -> Result<Computed, Failure> {
        match is_interrupted() && !self.keeps_best {
            true => Err(Failure::interrupted()),
            false => Ok(reached),
        }
    }

    /// Tells the optimiser of the limits, on a surface with panels of edge length `edge`.
    fn demand(&self, options: &mut MeshOptions, surface: &TriangleSurface, edge: f64) {
        let limits = TypedLimits::from(self.settings);
        let (extent, whole) = (surface.diagonal(), self.facets.diagonal());
        limits.demand(&mut options.optimise, edge, extent, whole);
    }
}

/// What a run that ends after the layout has made.
const LAYOUT_ALONE: &str = "as they are laid out: neither planar nor checked";

/// Relative error of the mean edge length that is told.
const TOLD_EDGE_ERROR: f64 = 0.03;

/// What is said where panels do not have the edges that were asked for.
fn missed_edge(settings: &MeshSettings, mesh: &HexMesh, extent: f64) -> Option<String> {
    let TypedPanelSize::EdgeLength(asked) = settings.size() else {
        return None;
    };
    let unit = settings.unit.unwrap_or_default();
    let ratio = mesh.mean_edge() / asked.length(unit, extent);
    let missed = (ratio - 1.0).abs() > TOLD_EDGE_ERROR;
    missed.then(|| {
        format!("--edge-length {asked}: the panels' edges are {ratio:.3} times as long on average")
    })
}

/// What is said of a run that ended early.
fn stopped(command: &MeshCommand, reporter: &Reporter, is_free: bool) -> Option<String> {
    let interrupted = command.keep_best && take_interruption();
    let why = match (interrupted, reporter.was_late()) {
        (true, _) => "interrupted",
        (false, true) => "the time limit is over",
        (false, false) => return None,
    };
    let held = match is_free {
        true => "",
        false => "; vertices may not yet be held where they were to be",
    };
    Some(format!("{why}: this is the best mesh so far{held}"))
}

/// A run that ended early without a mesh: by itself, unless the user interrupted it.
fn too_late(failure: Failure, command: &MeshCommand) -> Failure {
    match command.time_limit {
        Some(limit) if failure.exit == Exit::Interrupted && !is_interrupted() => Failure::new(
            Exit::NoValidResult,
            format!(
                "no mesh was reached within {} s; allow more time, or ask for fewer panels",
                limit.as_secs_f64()
            ),
        ),
        _ => failure,
    }
}

fn joined_mesh(runs: &[Computed]) -> Result<HexMesh, Failure> {
    let soup = joined_polygons(runs.iter().map(|run| run.mesh.to_soup()))?;
    HexMesh::new(soup.positions, &soup.faces)
        .context("joining the parts of a mesh")
        .map_err(Failure::from)
}

/// The layouts that the optimiser started from; nothing if one has none.
fn joined_start(runs: &[Computed]) -> Option<PolygonSoup> {
    let starts: Option<Vec<PolygonSoup>> = runs.iter().map(|run| run.start.clone()).collect();
    joined_polygons(starts?.into_iter()).ok()
}

fn joined_polygons(parts: impl Iterator<Item = PolygonSoup>) -> Result<PolygonSoup, Failure> {
    let mut soup = PolygonSoup::default();
    for part in parts {
        let first = u32::try_from(soup.positions.len()).context("too many vertices")?;
        soup.positions.extend(part.positions);
        soup.faces.extend(
            part.faces
                .into_iter()
                .map(|face| face.into_iter().map(|v| v + first).collect()),
        );
    }
    Ok(soup)
}

fn joined_target(runs: &[Computed]) -> Result<Option<TriangleSurface>, Failure> {
    let targets: Option<Vec<&TriangleSurface>> =
        runs.iter().map(|run| run.smooth.as_ref()).collect();
    targets.map(joined).transpose()
}

/// The smooth surfaces and the facets, continued beyond their boundaries where panels were kept
/// whole; nothing if they were nowhere.
fn joined_beyond(
    runs: &[Computed],
    components: &[SurfaceComponent],
) -> Result<Option<[TriangleSurface; 2]>, Failure> {
    if runs.iter().all(|run| run.beyond.is_none()) {
        return Ok(None);
    }
    let smooth = runs.iter().filter_map(|run| match &run.beyond {
        Some(beyond) => Some(&beyond.smooth),
        None => run.smooth.as_ref(),
    });
    let facets = runs.iter().zip(components);
    let facets = facets.map(|(run, part)| match &run.beyond {
        Some(beyond) => &beyond.facets,
        None => &part.surface,
    });
    Ok(Some([joined(smooth)?, joined(facets)?]))
}

/// Fills in how the mesh came about.
fn describe(
    report: &mut RunReport,
    settings: &MeshSettings,
    runs: Vec<Computed>,
) -> Result<(), Failure> {
    report.settings = serde_json::to_value(settings).context("the settings")?;
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

fn joined<'a>(
    parts: impl IntoIterator<Item = &'a TriangleSurface>,
) -> Result<TriangleSurface, Failure> {
    let joined = TriangleSurface::joined(parts).context("joining the parts of a surface");
    joined.map_err(Failure::from)
}

fn to_soup(surface: &TriangleSurface) -> PolygonSoup {
    PolygonSoup {
        positions: surface.positions().as_slice().to_vec(),
        faces: surface.topology().face_lists(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
