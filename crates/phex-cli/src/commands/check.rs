//! `phex check`: judges any polygon mesh.

use super::tell;
use crate::args::CheckCommand;
use crate::exit::{Exit, Failure};
use crate::input::{MeshFile, whole};
use crate::output::{self, check_writable};
use crate::progress::Reporter;
use crate::summary;
use crate::verdict::TypedLimits;
use anyhow::Context;
use phex::report::{References, RunReport, Verdict};
use phex_mesh::{HexMesh, TriangleSurface};
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// If an input can't be used or an output can't be written.
pub fn run(command: &CheckCommand) -> Result<Exit, Failure> {
    let inputs: Vec<_> = [Some(&command.input), command.surface.as_ref()]
        .into_iter()
        .flatten()
        .collect();
    let outputs: Vec<_> = command.extras.outputs().collect();
    check_writable(
        &outputs,
        &inputs.iter().map(|p| p.as_path()).collect::<Vec<_>>(),
    )?;
    let file = MeshFile::read(&command.input)?;
    let surface = command.surface.as_deref().map(MeshFile::read).transpose()?;
    let (mesh, dropped) = file.polygon_mesh()?;
    let facets = surface
        .as_ref()
        .map(|s| whole(&s.surfaces()?.components))
        .transpose()?;
    let mut report = judged(command, &mesh, facets.as_ref())?;
    if dropped > 0 {
        let note = format!("{dropped} vertices belong to no face; vertex ids count the others");
        Reporter::new(&command.talk).note(&note);
        report.notes.push(note);
    }
    report.inputs = std::iter::once(file.record)
        .chain(surface.map(|s| s.record))
        .collect();
    command.extras.write_picture(&mesh, &mut report.outputs)?;
    command.extras.write_report(&report)?;
    if command.json {
        output::print(&report.to_json().context("the report")?)?;
    }
    Ok(if report.verdict == Verdict::Pass {
        Exit::Success
    } else {
        Exit::OutsideTolerance
    })
}

/// The report of the mesh, whose table is also printed.
fn judged(
    command: &CheckCommand,
    mesh: &HexMesh,
    facets: Option<&TriangleSurface>,
) -> Result<RunReport, Failure> {
    let limits = TypedLimits::from(&command.limits);
    let assessment = limits.judge(
        mesh,
        References {
            smooth: None,
            facets,
        },
    );
    let table = summary::of_assessment(&assessment, limits.unit, command.talk.verbose);
    tell(command.talk.quiet || command.json, &table)?;
    let mut report = RunReport::new("check", assessment);
    report.unit = limits.unit.to_string();
    report.settings = json!({
        "planarity": limits.planarity,
        "max-deviation": limits.max_deviation,
        "unit": limits.unit,
    });
    Ok(report)
}
