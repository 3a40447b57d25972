//! `phex planarize`: makes the faces of a polygon mesh planar.

use super::{tell, use_threads};
use crate::args::PlanarizeCommand;
use crate::engine;
use crate::exit::{Exit, Failure};
use crate::input::{MeshFile, whole};
use crate::output::{Content, check_writable, write_mesh};
use crate::progress::{Reporter, is_interrupted};
use crate::summary;
use crate::verdict::{TypedLimits, exit_of, written};
use phex::optimise::OptimiseOptions;
use phex::report::{References, RunReport, Verdict};
use phex_mesh::HexMesh;
use serde_json::json;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, there is no result, or the output can't be written.
pub fn run(command: &PlanarizeCommand) -> Result<Exit, Failure> {
    check_writable(&outputs(command), &inputs(command))?;
    let threads = use_threads(command.threads)?;
    let reporter = Reporter::new(&command.talk);
    let file = MeshFile::read(&command.input)?;
    let (start, dropped) = file.polygon_mesh()?;
    let given = command.surface.as_deref().map(MeshFile::read).transpose()?;
    let surface = given
        .as_ref()
        .map(|file| whole(&file.surfaces()?.components))
        .transpose()?;
    // Without a surface, the distance to where the faces were is told, unless they are too bad to be a surface.
    let own = || whole(&file.surfaces().ok()?.components).ok();
    let facets = if surface.is_some() { None } else { own() };

    let options = OptimiseOptions::default();
    let reached = engine::planarize(&start, surface.as_ref(), &options, &reporter)?;
    reporter.finish();
    if is_interrupted() {
        return Err(Failure::interrupted());
    }
    let limits = TypedLimits::from(&command.limits);
    let assessment = limits.judge(
        &reached.mesh,
        References {
            smooth: None,
            facets: surface.as_ref().or(facets.as_ref()),
        },
    );
    let table = summary::of_assessment(&assessment, limits.unit, command.talk.verbose);
    let mut report = RunReport::new("planarize", assessment);
    report.inputs = std::iter::once(file.record)
        .chain(given.map(|r| r.record))
        .collect();
    report.unit = limits.unit.to_string();
    report.threads = threads;
    report.settings = json!({ "planarity": limits.planarity, "max-deviation": limits.max_deviation, "unit": limits.unit, "optimise": options });
    report.outcome = reached.outcome;
    report.statistics = reached.statistics;
    report.stages = reached.stages;
    if dropped > 0 {
        report.notes.push(format!(
            "{dropped} vertices belong to no face and were left out"
        ));
    }
    report.notes.iter().for_each(|note| reporter.note(note));
    write(command, &reached.mesh, &mut report)?;
    tell(command.talk.quiet, &table)?;
    Ok(exit_of(report.verdict))
}

fn inputs(command: &PlanarizeCommand) -> Vec<&Path> {
    std::iter::once(command.input.as_path())
        .chain(command.surface.as_deref())
        .collect()
}

fn outputs(command: &PlanarizeCommand) -> Vec<(&Path, Content)> {
    std::iter::once((command.output.as_path(), Content::Mesh))
        .chain(command.extras.outputs())
        .collect()
}

fn write(
    command: &PlanarizeCommand,
    mesh: &HexMesh,
    report: &mut RunReport,
) -> Result<(), Failure> {
    if report.verdict != Verdict::Invalid || command.keep_invalid {
        write_mesh(&command.output, &mesh.to_soup())?;
        report.outputs.push(written("mesh", &command.output));
    }
    command.extras.write_picture(mesh, &mut report.outputs)?;
    command.extras.write_report(report)
}
