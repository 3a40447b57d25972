//! `phex parallel`: the mesh parallel to a given one that is closest to a surface.

use super::tell;
use crate::args::{ParallelCommand, ParallelStart};
use crate::exit::{Exit, Failure, OrExit};
use crate::input::{MeshFile, whole};
use crate::output::{Content, check_writable, write_mesh};
use crate::progress::{Reporter, is_interrupted};
use crate::summary::{self, Table};
use crate::verdict::{TypedLimits, written};
use anyhow::Context;
use phex::parallel_mesh::edge_offset::{edge_distances, edge_offset};
use phex::parallel_mesh::fit::{FitOptions, FitStart, Fitted, fit_parallel};
use phex::parallel_mesh::koebe::touching_points;
use phex::report::{References, RunReport, Verdict};
use phex_mesh::HexMesh;
use serde_json::json;
use std::path::Path;

/// Distance of an edge's line from the unit sphere up to which a mesh counts as a Koebe mesh.
const KOEBE_TOLERANCE: f64 = 1e-9;

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
    if command.edge_offset.is_some() {
        check_koebe(&mesh)
            .with_context(|| command.input.display().to_string())
            .or_exit(Exit::InputUnusable)?;
    }
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
    let offset = write(command, &mesh, &fitted.mesh, &mut report)?;
    let text = summary + &table(&fitted, offset) + &summary::of_outputs(&report);
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
    let meshes = std::iter::once(&command.output).chain(&command.write_offset);
    meshes
        .map(|path| (path.as_path(), Content::Mesh))
        .chain(command.extras.outputs())
        .collect()
}

/// Refuses a mesh whose edges do not touch the unit sphere.
fn check_koebe(mesh: &HexMesh) -> anyhow::Result<()> {
    for (e, point) in touching_points(mesh).enumerate() {
        let distance = (point.norm() - 1.0).abs();
        let [a, b] = mesh.topology().edge_vertices(e);
        anyhow::ensure!(
            distance <= KOEBE_TOLERANCE,
            "no offset at constant edge distance: the edge between vertices {a} and {b} misses the unit sphere by {distance:.1e} \
             (`phex koebe` makes meshes whose edges touch it)"
        );
    }
    Ok(())
}

/// Writes the files; the largest error of the edge distances if there is an offset.
fn write(
    command: &ParallelCommand,
    gauss_image: &HexMesh,
    mesh: &HexMesh,
    report: &mut RunReport,
) -> Result<Option<f64>, Failure> {
    write_mesh(&command.output, &mesh.to_soup())?;
    report.outputs.push(written("mesh", &command.output));
    let mut error = None;
    if let (Some(distance), Some(path)) = (command.edge_offset, &command.write_offset) {
        let offset = edge_offset(mesh, gauss_image, distance);
        let distances = edge_distances(mesh, &offset);
        error = Some(
            distances
                .iter()
                .map(|d| (d - distance.abs()).abs())
                .fold(0.0, f64::max),
        );
        write_mesh(path, &offset.to_soup())?;
        report.outputs.push(written("offset", path));
    }
    command.extras.write_picture(mesh, &mut report.outputs)?;
    command.extras.write_report(report)?;
    Ok(error)
}

fn table(fitted: &Fitted, offset_error: Option<f64>) -> String {
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
    if let Some(error) = offset_error {
        table.row("offset", format!("edge distances constant to {error:.1e}"));
    }
    table.into_text()
}
