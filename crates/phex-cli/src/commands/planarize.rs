//! `phex planarize`: makes the faces of a polygon mesh planar.

use super::deliver::{Delivery, outputs};
use super::use_threads;
use crate::args::PlanarizeCommand;
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::output::check_writable;
use crate::progress::{Reporter, check_interruption};
use phex::quality::{Assessment, References};
use phex::report::{InputFile, RunReport};
use phex_job::MeshFile;
use phex_job::MeshSettings;
use phex_job::TypedLimits;
use phex_job::{Computed, Planarization};
use phex_mesh::TriangleSurface;
use serde_json::json;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, there is no result, or the output can't be written.
pub fn run(command: &PlanarizeCommand) -> Result<Exit, Failure> {
    let settings = settings(command)?;
    check_writable(
        &outputs(&command.output, &command.extras),
        &inputs(command, &settings),
    )?;
    let threads = use_threads(command.threads)?;
    let reporter = Reporter::new(&command.talk);
    let files = PlanarizeInput::read(command)?;
    let (start, notes) = files.mesh.sewn_polygon_mesh()?;
    let surface = files.surface()?;
    let limits = TypedLimits {
        unit: command.limits.unit.unwrap_or(settings.unit()),
        ..TypedLimits::from(&command.limits)
    };
    let given = settings.steering.read()?;
    let mut how = Planarization::new(settings, given, &limits, (&start, surface.as_ref()));
    how.refit |= command.refit;
    let facets = surface.or_else(|| files.own_surface());
    let reached = phex_job::planarize(&start, facets.as_ref(), &how, &reporter)?;
    reporter.finish();
    check_interruption()?;
    let references = References::of_facets(facets.as_ref());
    let assessment = limits.judge(&reached.mesh, references);
    let mut report = report(assessment, &limits, &how, &reached);
    report.threads = threads;
    report.inputs = files.records();
    notes.iter().for_each(|note| reporter.note(note));
    report.notes.extend(notes);
    let shown = Shown {
        surface: facets.as_ref(),
        start: reached.start.as_ref(),
        ..Shown::of(&reached.mesh)
    };
    Delivery {
        output: Some(&command.output),
        keep_invalid: command.keep_invalid,
        ..Delivery::new(shown, report, limits, &command.extras, &command.talk)
    }
    .send()
}

/// What is typed and in the job file.
fn settings(command: &PlanarizeCommand) -> Result<MeshSettings, Failure> {
    let file = command.config.as_deref().map(MeshSettings::from_file);
    let settings = MeshSettings {
        steering: command.steering.clone(),
        ..MeshSettings::default()
    };
    let settings = settings.over(file.transpose()?.unwrap_or_default());
    settings.check()?;
    settings.steering.check_effects()?;
    Ok(settings)
}

/// The files that are read.
struct PlanarizeInput {
    mesh: MeshFile,
    surface: Option<MeshFile>,
}

impl PlanarizeInput {
    fn read(command: &PlanarizeCommand) -> Result<Self, Failure> {
        let mesh = MeshFile::read(&command.input)?;
        let surface = command.surface.as_deref().map(MeshFile::read).transpose()?;
        Ok(Self { mesh, surface })
    }

    /// The surface to stay close to, where one is given.
    fn surface(&self) -> Result<Option<TriangleSurface>, Failure> {
        let surface = self.surface.as_ref().map(|file| file.surface());
        Ok(surface.transpose()?)
    }

    /// The faces as they are, to measure how far they move; nothing if they are too bad to be a
    /// surface.
    fn own_surface(&self) -> Option<TriangleSurface> {
        Some(self.mesh.surfaces().ok()?.whole())
    }

    fn records(self) -> Vec<InputFile> {
        let surface = self.surface.map(|file| file.record);
        std::iter::once(self.mesh.record).chain(surface).collect()
    }
}

fn report(
    assessment: Assessment,
    limits: &TypedLimits,
    how: &Planarization,
    reached: &Computed,
) -> RunReport {
    let mut report = limits.report("planarize", assessment);
    report.settings = json!({
        "planarity": limits.planarity,
        "max-deviation": limits.max_deviation,
        "unit": limits.unit,
        "optimise": how.options,
        "steering": how.steering,
        "refit": how.refit,
    });
    reached.describe(&mut report);
    report
}

fn inputs<'a>(command: &'a PlanarizeCommand, settings: &'a MeshSettings) -> Vec<&'a Path> {
    std::iter::once(command.input.as_path())
        .chain(command.surface.as_deref())
        .chain(command.config.as_deref())
        .chain(settings.steering.inputs())
        .collect()
}
