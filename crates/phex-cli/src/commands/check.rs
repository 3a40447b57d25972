//! `phex check`: judges any polygon mesh.

use super::tell;
use crate::args::{CheckCommand, Limits};
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::input::{MeshFile, whole};
use crate::output::{self, check_writable};
use crate::progress::Reporter;
use crate::summary::{self, Table};
use crate::verdict::TypedLimits;
use anyhow::Context;
use phex::curvature::dupin::{free_panels, indicatrix_distances};
use phex::curvature::{CurvatureOptions, curvature};
use phex::layout::lattice::CELL;
use phex::report::{Assessment, References, RunReport, Verdict};
use phex_mesh::measure::Metric;
use phex_mesh::{FaceId, HexMesh, TriangleSurface};
use serde::Serialize;
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
    command.limits.check(command.surface.is_some())?;
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
    let mut table = summary::of_assessment(&assessed.0, command.limits.unit, command.talk.verbose);
    let indicatrix = facets.as_ref().map(|surface| indicatrix(&mesh, surface));
    if let Some(metric) = indicatrix.as_ref().filter(|m| m.all.count > 0) {
        table += &inscribed(metric);
    }
    let mut report = assessed.1;
    table += &summary::of_features(&mut report, &mesh, facets.as_ref());
    tell(command.talk.quiet || command.json, &table)?;
    report.statistics = json!({ "indicatrix": indicatrix });
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
        facets,
        ..Default::default()
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

/// How far the corners of inner panels are from a homothetic copy of Dupin's indicatrix, over the panel's radius.
#[derive(Serialize)]
struct Inscribed {
    /// Of all panels where that is defined.
    all: Metric<FaceId>,
    /// The median of these.
    median: f64,
    /// Of those that are not held open.
    free: Metric<FaceId>,
}

fn indicatrix(mesh: &HexMesh, surface: &TriangleSurface) -> Inscribed {
    let length = (surface.area() / (CELL * mesh.topology().n_faces() as f64)).sqrt();
    let curvature = curvature(surface, length, &CurvatureOptions::default());
    let distances = indicatrix_distances(mesh, surface, &curvature);
    let known = || distances.enumerate().filter_map(|(f, d)| Some((f, (*d)?)));
    let free = free_panels(mesh);
    let mut sorted: Vec<f64> = known().map(|k| k.1).collect();
    sorted.sort_by(f64::total_cmp);
    Inscribed {
        all: Metric::large_is_bad(known()),
        median: sorted.get(sorted.len() / 2).copied().unwrap_or(0.0),
        free: Metric::large_is_bad(known().filter(|k| free[k.0])),
    }
}

fn inscribed(found: &Inscribed) -> String {
    let mut table = Table::default();
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    table.row(
        "indicatrix",
        format!(
            "corners off it by {} of a panel's radius in the median, {} in the mean, {} at most ({} inner panels); {} in the mean of the {} that \
             nothing holds open",
            percent(found.median),
            percent(found.all.mean),
            percent(found.all.max),
            found.all.count,
            percent(found.free.mean),
            found.free.count
        ),
    );
    table.into_text()
}
