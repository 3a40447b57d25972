//! `phex parallel`: the mesh parallel to a given one that is closest to a surface.

use super::tell;
use crate::args::{ParallelCommand, ParallelStart};
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::input::{MeshFile, whole};
use crate::output::{Content, check_writable, write_mesh};
use crate::progress::{Reporter, is_interrupted};
use crate::summary::{self, Table};
use crate::verdict::{TypedLimits, written};
use anyhow::Context;
use phex::parallel_mesh::fit::{FitOptions, FitStart, Fitted, fit_parallel};
use phex::report::{References, RunReport, Verdict};
use phex_mesh::HexMesh;
use serde_json::json;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, or the output can't be written.
pub fn run(command: &ParallelCommand) -> Result<Exit, Failure> {
    check_writable(&outputs(command), &[&command.input, &command.surface])?;
    let reporter = Reporter::new(&command.talk);
    let (file, surface_file) = (
        MeshFile::read(&command.input)?,
        MeshFile::read(&command.surface)?,
    );
    let (mesh, _) = file.polygon_mesh()?;
    let surface = whole(&surface_file.surfaces()?.components)?;
    let options = options(command);
    let fitted = fit_parallel(&mesh, &surface, &options, &reporter)
        .with_context(|| command.input.display().to_string())
        .or_exit(Exit::InputUnusable)?;
    reporter.finish();
    if is_interrupted() {
        return Err(Failure::interrupted());
    }
    let limits = TypedLimits::from(&command.limits);
    let references = References {
        smooth: None,
        facets: Some(&surface),
    };
    let assessment = limits.judge(&fitted.mesh, references);
    let summary = summary::of_assessment(&assessment, limits.unit, command.talk.verbose);
    let mut report = RunReport::new("parallel", assessment);
    report.unit = limits.unit.to_string();
    report.settings = json!({ "parallel": options });
    report.statistics = json!({
        "status": fitted.status,
        "rounds": fitted.rounds,
        "edges_at_bound": fitted.edges_at_bound,
        "mean_curvature": fitted.mean_curvature,
        "mean_curvature_spread": fitted.mean_curvature_spread,
    });
    report.inputs = vec![file.record, surface_file.record];
    write(command, &fitted.mesh, &mut report)?;
    let text = summary + &table(&fitted) + &summary::of_outputs(&report);
    tell(command.talk.quiet, &text)?;
    // The file is written in any case: a coarse mesh may have folds that panels must not have.
    Ok(match report.verdict {
        Verdict::Pass => Exit::Success,
        Verdict::OutsideTolerance | Verdict::Invalid => Exit::OutsideTolerance,
    })
}

fn options(command: &ParallelCommand) -> FitOptions {
    FitOptions {
        start: match command.start {
            ParallelStart::Normals => FitStart::Normals,
            ParallelStart::Positions => FitStart::Positions,
        },
        least_edge: command.least_edge,
        fairness: command.fairness,
        constant_mean_curvature: command.constant_mean_curvature,
        ..FitOptions::default()
    }
}

fn outputs(command: &ParallelCommand) -> Vec<(&Path, Content)> {
    std::iter::once((command.output.as_path(), Content::Mesh))
        .chain(command.extras.outputs())
        .collect()
}

fn write(command: &ParallelCommand, mesh: &HexMesh, report: &mut RunReport) -> Result<(), Failure> {
    write_mesh(&command.output, &mesh.to_soup())?;
    report.outputs.push(written("mesh", &command.output));
    command.extras.write(&Shown::of(mesh), report)
}

fn table(fitted: &Fitted) -> String {
    let mut table = Table::default();
    table.row(
        "fit",
        format!("{:?} after {} rounds", fitted.status, fitted.rounds),
    );
    if fitted.edges_at_bound > 0 {
        table.row(
            "short edges",
            format!("{} are as short as is allowed", fitted.edges_at_bound),
        );
    }
    let spread = fitted.mean_curvature_spread;
    table.row(
        "curvature",
        format!(
            "mean {:.4}, rms spread {spread:.1e} of it",
            fitted.mean_curvature
        ),
    );
    table.into_text()
}
