//! `phex report`: the report of a mesh as one HTML file.

use super::check::report_of;
use super::tell;
use crate::exit::{Exit, Failure};
use crate::html::{self, Shown};
use crate::output::{check_writable, given};
use crate::picture_arguments::ReportCommand;
use crate::summary;
use crate::verdict::written;
use phex::quality::{References, Verdict};
use phex_job::TypedLimits;
use phex_job::{Content, MeshFile};

/// Runs the command.
///
/// # Errors
/// If an input can't be used or the report can't be written.
pub fn run(command: &ReportCommand) -> Result<Exit, Failure> {
    let inputs = given([
        Some(&command.input),
        command.surface.as_ref(),
        command.before.as_ref(),
    ]);
    command.limits.check(command.surface.is_some())?;
    check_writable(&[(&command.html, Content::Other)], &inputs)?;
    let file = MeshFile::read(&command.input)?;
    let surface = command.surface.as_deref().map(MeshFile::read).transpose()?;
    let before = command.before.as_deref().map(MeshFile::read).transpose()?;
    if let Some(before) = &before {
        before.polygon_mesh()?;
    }
    let (mesh, _) = file.polygon_mesh()?;
    let facets = surface.as_ref().map(|s| s.surface()).transpose()?;
    let limits = TypedLimits::from(&command.limits);
    let references = References::of_facets(facets.as_ref());
    let assessment = limits.judge(&mesh, references);
    let mut report = report_of(&limits, assessment.clone(), "report");
    let start = before.as_ref().map(|file| file.soup.clone());
    let files = std::iter::once(file).chain(surface).chain(before);
    report.inputs = files.map(|file| file.record).collect();
    report.outputs.push(written("report", &command.html));
    let shown = Shown {
        surface: facets.as_ref(),
        start: start.as_ref(),
        ..Shown::of(&mesh)
    };
    let features = summary::of_features(&mut report, &mesh, facets.as_ref());
    html::write(&command.html, &shown, &report)?;
    let table = summary::of_assessment(&assessment, &limits, command.talk.verbose);
    let end = summary::of_files(&report) + &summary::of_verdict(report.verdict);
    tell(command.talk.quiet, &(table + &features + &end))?;
    Ok(Exit::of_check(report.verdict == Verdict::Pass))
}
