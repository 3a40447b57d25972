//! `phex check`: judges any polygon mesh.

use super::tell;
use crate::args::{CheckCommand, Limits};
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::input::{MeshFile, whole};
use crate::output::{self, check_writable};
use crate::progress::Reporter;
use crate::summary;
use crate::verdict::TypedLimits;
use anyhow::Context;
use phex::report::{Assessment, References, RunReport, Verdict};
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
    let assessed = judged(&command.limits, &mesh, facets.as_ref(), "check");
    let table = summary::of_assessment(&assessed.0, command.limits.unit, command.talk.verbose);
    tell(command.talk.quiet || command.json, &table)?;
    let mut report = assessed.1;
    if dropped > 0 {
        let note = format!("{dropped} vertices belong to no face; vertex ids count the others");
        Reporter::new(&command.talk).note(&note);
        report.notes.push(note);
    }
    report.inputs = std::iter::once(file.record)
        .chain(surface.map(|s| s.record))
        .collect();
    let shown = Shown {
        surface: facets.as_ref(),
        ..Shown::of(&mesh)
    };
    command.extras.write(&shown, &mut report)?;
    if command.json {
        output::print(&report.to_json().context("the report")?)?;
    }
    Ok(if report.verdict == Verdict::Pass {
        Exit::Success
    } else {
        Exit::OutsideTolerance
    })
}

/// The assessment of a mesh, and a report around it.
pub(super) fn judged(
    limits: &Limits,
    mesh: &HexMesh,
    facets: Option<&TriangleSurface>,
    command: &'static str,
) -> (Assessment, RunReport) {
    let limits = TypedLimits::from(limits);
    let references = References {
        smooth: None,
        facets,
    };
    let assessment = limits.judge(mesh, references);
    let mut report = RunReport::new(command, assessment.clone());
    report.unit = limits.unit.to_string();
    report.settings = json!({
        "planarity": limits.planarity,
        "max-deviation": limits.max_deviation,
        "unit": limits.unit,
    });
    (assessment, report)
}
