//! `phex koebe`: the mesh of a given graph whose edges touch the unit sphere.

use super::deliver::{Delivery, judged, outputs};
use crate::args::{KoebeBoundary, KoebeCommand};
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::output::check_writable;
use crate::progress::{Reporter, check_interruption};
use crate::summary::SummaryTable;
use anyhow::Context;
use phex::koebe::{BoundaryCondition, Koebe, KoebeOptions, koebe};
use phex_job::MeshFile;
use phex_job::TypedLimits;
use phex_mesh::HexMesh;
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// If the graph has no Koebe mesh, there is no result, or the output can't be written.
pub fn run(command: &KoebeCommand) -> Result<Exit, Failure> {
    check_writable(
        &outputs(&command.output, &command.extras),
        &[&command.input],
    )?;
    let reporter = Reporter::new(&command.talk);
    let file = MeshFile::read(&command.input)?;
    let (mesh, _) = file.polygon_mesh()?;
    check_effects(command, &mesh)?;
    let options = options(command);
    let made = koebe(&mesh, &options, &reporter)
        .with_context(|| command.input.display().to_string())
        .or_exit(Exit::InputUnusable)?;
    reporter.finish();
    check_interruption()?;
    if !made.is_converged() {
        let message = format!("the circles were not found: {:?}", made.outcome.status);
        return Err(Failure::new(Exit::NoValidResult, message));
    }
    let limits = TypedLimits::default();
    let shown = Shown::of(&made.mesh);
    let mut report = judged("koebe", &shown, &limits);
    report.settings = json!({ "koebe": options, "unit": "sphere of radius 1" });
    report.outcome = json!(made.outcome);
    report.statistics = json!({ "defects": made.defects });
    report.inputs = vec![file.record];
    Delivery {
        output: Some(&command.output),
        keep_invalid: command.keep_invalid,
        before: table(&made),
        ..Delivery::new(shown, report, limits, &command.extras, &command.talk)
    }
    .send()
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
    let closed = mesh.topology().is_closed();
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

/// What makes it a Koebe mesh.
fn table(made: &Koebe) -> String {
    let mut table = SummaryTable::default();
    let defects = &made.defects;
    table.row(
        "tangency",
        format!(
            "edges touch the unit sphere to {:.1e}, vertices are off their planes by at most {:.1e}",
            defects.tangency, defects.planarity
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
    table.into_text()
}
