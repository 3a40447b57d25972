//! `phex koebe`: the mesh of a given graph whose edges touch the unit sphere.

use super::tell;
use crate::args::{KoebeBoundary, KoebeCommand, Limits};
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::input::MeshFile;
use crate::output::{Content, check_writable, write_mesh};
use crate::progress::{Reporter, is_interrupted};
use crate::summary::{self, Table};
use crate::verdict::{TypedLimits, written};
use anyhow::Context;
use phex::parallel_mesh::koebe::{BoundaryCondition, Koebe, KoebeOptions, koebe};
use phex::report::{References, RunReport, Verdict};
use phex_mesh::HexMesh;
use serde_json::json;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If the graph has no Koebe mesh, there is no result, or the output can't be written.
pub fn run(command: &KoebeCommand) -> Result<Exit, Failure> {
    check_writable(&outputs(command), &[&command.input])?;
    let reporter = Reporter::new(&command.talk);
    let file = MeshFile::read(&command.input)?;
    let (mesh, _) = file.polygon_mesh()?;
    check_effects(command, &mesh)?;
    let options = options(command);
    let made = koebe(&mesh, &options, &reporter)
        .with_context(|| command.input.display().to_string())
        .or_exit(Exit::InputUnusable)?;
    reporter.finish();
    if is_interrupted() {
        return Err(Failure::interrupted());
    }
    if !made.is_converged() {
        let message = format!("the circles were not found: {:?}", made.outcome.status);
        return Err(Failure::new(Exit::NoValidResult, message));
    }
    let mut report = report(&made, &options, command);
    report.inputs = vec![file.record];
    write(command, &made.mesh, &mut report)?;
    tell(command.talk.quiet, &table(&made, &report))?;
    // A coarse polyhedron has folds that panels must not have; that is told, but no failure.
    Ok(Exit::Success)
}

fn options(command: &KoebeCommand) -> KoebeOptions {
    let default = KoebeOptions::default();
    let boundary = match command.boundary.unwrap_or_default() {
        KoebeBoundary::EqualRadii => BoundaryCondition::EqualRadii,
        KoebeBoundary::GaussImage => BoundaryCondition::GaussImage,
        KoebeBoundary::Angles => BoundaryCondition::Angles,
    };
    KoebeOptions {
        boundary,
        opening: command.opening.unwrap_or(default.opening),
        ..default
    }
}

/// Refuses options of the boundary that mean nothing.
fn check_effects(command: &KoebeCommand, mesh: &HexMesh) -> Result<(), Failure> {
    let closed = mesh.topology().boundary_loops().is_empty();
    if closed && (command.boundary.is_some() || command.opening.is_some()) {
        return Err(Failure::input(
            "--boundary and --opening have no effect: the mesh has no boundary",
        ));
    }
    if command.opening.is_some() && command.boundary == Some(KoebeBoundary::GaussImage) {
        return Err(Failure::input(
            "--opening has no effect with --boundary gauss-image, which says how far the mesh opens",
        ));
    }
    Ok(())
}

fn outputs(command: &KoebeCommand) -> Vec<(&Path, Content)> {
    std::iter::once((command.output.as_path(), Content::Mesh))
        .chain(command.extras.outputs())
        .collect()
}

fn report(made: &Koebe, options: &KoebeOptions, command: &KoebeCommand) -> RunReport {
    let limits = TypedLimits::from(&Limits::default());
    let none = References::default();
    let mut report = RunReport::new("koebe", limits.judge(&made.mesh, none));
    report.settings =
        json!({ "koebe": options, "unit": "sphere of radius 1", "verbose": command.talk.verbose });
    report.outcome = json!(made.outcome);
    report.statistics = json!({ "defects": made.defects });
    report
}

fn write(command: &KoebeCommand, mesh: &HexMesh, report: &mut RunReport) -> Result<(), Failure> {
    write_mesh(&command.output, &mesh.to_soup())?;
    report.outputs.push(written("mesh", &command.output));
    command.extras.write(&Shown::of(mesh), report)
}

fn table(made: &Koebe, report: &RunReport) -> String {
    let mut table = Table::default();
    let t = made.mesh.topology();
    let defects = &made.defects;
    table.row(
        "mesh",
        format!("{} vertices, {} faces", t.n_vertices(), t.n_faces()),
    );
    table.row(
        "tangency",
        format!("edges touch the unit sphere to {:.1e}", defects.tangency),
    );
    table.row(
        "planarity",
        format!(
            "vertices off their planes by at most {:.1e}",
            defects.planarity
        ),
    );
    table.row(
        "balance",
        format!(
            "mean of the touching points {:.1e} from the centre",
            defects.imbalance
        ),
    );
    table.row(
        "solved",
        format!("with {} factorisations", made.outcome.factorisations),
    );
    if report.verdict != Verdict::Pass {
        table.row("as panels", "some checks fail, see `phex check`");
    }
    table.into_text() + &summary::of_outputs(report)
}
