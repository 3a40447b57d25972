//! `phex check`: judges any polygon mesh.

use super::criteria::Criteria;
use super::tell;
use crate::args::CheckCommand;
use crate::bundle;
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::output::{self, check_writable};
use crate::progress::Reporter;
use crate::summary::{self, SummaryTable};
use crate::verdict::written;
use anyhow::Context;
use phex::curvature::{CurvatureOptions, curvature};
use phex::curvature::{free_panels, indicatrix_distances};
use phex::layout::CELL;
use phex::quality::Verdict;
use phex::report::RunReport;
use phex_job::{Content, MeshFile};
use phex_mesh::measure::Metric;
use phex_mesh::{FaceId, HexMesh, TriangleSurface};
use serde::Serialize;
use serde_json::json;
use std::path::PathBuf;

/// Runs the command.
///
/// # Errors
/// If an input can't be used or an output can't be written.
pub fn run(command: &CheckCommand) -> Result<Exit, Failure> {
    let inputs = command.judged_by.inputs([command.input.as_path()]);
    command.judged_by.check()?;
    let bundle = command.bundle.as_deref().map(|p| (p, Content::Other));
    let outputs: Vec<_> = command.extras.outputs().chain(bundle).collect();
    check_writable(&outputs, &inputs)?;
    let file = MeshFile::read(&command.input)?;
    let (mesh, dropped) = file.polygon_mesh()?;
    let criteria = Criteria::read(&command.judged_by, &mesh)?;
    let assessment = criteria.judge(&mesh);
    let limits = &criteria.limits;
    let mut table = summary::of_assessment(&assessment, limits, command.talk.verbose);
    let facets = criteria.facets.as_ref();
    let indicatrix = facets.map(|surface| indicatrix(&mesh, surface));
    if let Some(metric) = indicatrix.as_ref().filter(|m| m.all.count > 0) {
        table += &inscribed(metric);
    }
    let mut report = criteria.report(assessment, "check");
    let reporter = Reporter::new(&command.talk);
    report.notes.iter().for_each(|note| reporter.note(note));
    table += &summary::of_features(&mut report, &mesh, facets);
    table += &summary::of_verdict(report.assessment.verdict);
    tell(command.talk.quiet || command.json, &table)?;
    report.statistics = json!({ "indicatrix": indicatrix });
    let doubt = limits.unit.doubted(mesh.diagonal());
    for note in without_face(dropped).into_iter().chain(doubt) {
        Reporter::new(&command.talk).note(&note);
        report.notes.push(note);
    }
    report.inputs = std::iter::once(file.record)
        .chain(criteria.records.iter().cloned())
        .collect();
    let shown = Shown {
        surface: facets,
        ..Shown::of(&mesh)
    };
    command.extras.write(&shown, &mut report)?;
    if let Some(path) = &command.bundle {
        report.outputs.push(written("bundle", path));
        bundle::write(path, &read(command, &report), &report)?;
    }
    if command.json {
        output::print(&report.to_json().context("the report")?)?;
    }
    Ok(Exit::of_check(report.assessment.verdict == Verdict::Pass))
}

/// What is said of vertices that belong to no face.
fn without_face(dropped: usize) -> Option<String> {
    let belong = match dropped {
        0 => return None,
        1 => "1 vertex belongs".to_owned(),
        n => format!("{n} vertices belong"),
    };
    Some(format!("{belong} to no face; vertex ids count the others"))
}

/// The files that a check read.
fn read(command: &CheckCommand, report: &RunReport) -> Vec<PathBuf> {
    let inputs = report.inputs.iter().map(|i| PathBuf::from(&i.path));
    let others = [&command.judged_by.report_of, &command.judged_by.limits];
    inputs
        .chain(others.into_iter().flatten().cloned())
        .collect()
}

/// How far the corners of inner panels are from a homothetic copy of Dupin's indicatrix, over the
/// panel's radius: root mean square over the corners of each.
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
    let mut table = SummaryTable::default();
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    let free = match found.free.count {
        0 => "each of them is held open by something".to_owned(),
        count => format!(
            "{} in the mean of the {count} that nothing holds open",
            percent(found.free.mean)
        ),
    };
    table.row(
        "indicatrix",
        format!(
            "corners off it by {} of a panel's radius (root mean square of its corners) in the median panel, {} in the mean, {} in the worst ({} inner panels); {free}",
            percent(found.median),
            percent(found.all.mean),
            percent(found.all.max),
            found.all.count
        ),
    );
    table.into_text()
}
