//! `phex dual`: the dual of a mesh with respect to a quadric.

use super::deliver::{Delivery, judged, outputs};
use crate::dual_arguments::DualCommand;
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::output::check_writable;
use crate::summary::SummaryTable;
use anyhow::Context;
use phex::classical::clear_centre_of;
use phex::classical::{Quadric, dual_mesh};
use phex_job::MeshFile;
use phex_job::TypedLimits;
use phex_mesh::{HexMesh, Vec3, measure};
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// If the mesh has no dual, or the output can't be written.
pub fn run(command: &DualCommand) -> Result<Exit, Failure> {
    check_writable(
        &outputs(&command.output, &command.extras),
        &[&command.input],
    )?;
    let file = MeshFile::read(&command.input)?;
    let (mesh, _) = file.polygon_mesh()?;
    let name = || command.input.display().to_string();
    let mut table = SummaryTable::default();
    let quadric = quadric(command, &mesh, &mut table)
        .with_context(name)
        .or_exit(Exit::InputUnusable)?;
    let dual = dual_mesh(&mesh, &quadric)
        .with_context(name)
        .or_exit(Exit::InputUnusable)?;
    let t = dual.mesh.topology();
    table.row(
        "mesh",
        format!("{} vertices, {} faces", t.n_vertices(), t.n_faces()),
    );
    let planarity = measure(&dual.mesh).planarity.max;
    table.row("planarity", format!("max {planarity:.1e} mean edges"));
    let shown = Shown::of(&dual.mesh);
    let limits = TypedLimits::default();
    let mut report = judged("dual", &shown, &limits);
    report.settings = json!({ "quadric": quadric.matrix().as_slice() });
    report.statistics = json!({ "dropped_faces": mesh.topology().n_faces() - t.n_vertices() });
    report.inputs = vec![file.record];
    Delivery {
        output: Some(&command.output),
        panels: false,
        after: table.into_text(),
        ..Delivery::new(shown, report, limits, &command.extras, &command.talk)
    }
    .send()
}

fn quadric(
    command: &DualCommand,
    mesh: &HexMesh,
    table: &mut SummaryTable,
) -> anyhow::Result<Quadric> {
    if let Some(upper) = command.quadric {
        return Ok(Quadric::from_upper(upper)?);
    }
    let (centre, clearness) = match command.centre {
        Some(centre) => (Vec3::from(centre), None),
        None => {
            let (centre, clearness) = clear_centre_of(mesh);
            (centre, Some(clearness))
        }
    };
    table.row(
        "centre",
        format!("--centre={},{},{}", centre.x, centre.y, centre.z),
    );
    if let Some(clearness) = clearness.filter(|c| *c <= 0.0) {
        table.row(
            "infinity",
            format!("planes of faces pass on both sides of every centre tried ({clearness:.3}): the dual runs through infinity"),
        );
    }
    Ok(Quadric::sphere(centre, command.radius)?)
}
