//! `phex report`: the report of a mesh as one HTML file.

use super::criteria::Criteria;
use super::tell;
use crate::exit::{Exit, Failure};
use crate::html::{self, Shown};
use crate::output::{check_writable, given};
use crate::picture_arguments::ReportCommand;
use crate::progress::Reporter;
use crate::summary;
use crate::verdict::written;
use phex::quality::Verdict;
use phex_job::{Content, MeshFile};

/// Runs the command.
///
/// # Errors
/// If an input can't be used or the report can't be written.
pub fn run(command: &ReportCommand) -> Result<Exit, Failure> {
    let inputs = command
        .judged_by
        .inputs(given([Some(&command.input), command.before.as_ref()]));
    command.judged_by.check()?;
    check_writable(&[(&command.html, Content::Page)], &inputs)?;
    let file = MeshFile::read(&command.input)?;
    let before = command.before.as_deref().map(MeshFile::read).transpose()?;
    if let Some(before) = &before {
        before.polygon_mesh()?;
    }
    let (mesh, _) = file.polygon_mesh()?;
    let criteria = Criteria::read(&command.judged_by, &mesh)?;
    let facets = criteria.facets.as_ref();
    let assessment = criteria.judge(&mesh);
    let mut report = criteria.report(assessment.clone(), "report");
    let reporter = Reporter::new(&command.talk);
    report.notes.iter().for_each(|note| reporter.note(note));
    let start = before.as_ref().map(|file| file.soup.clone());
    let surfaces = criteria.records.iter().cloned();
    let before = before.map(|file| file.record);
    report.inputs = std::iter::once(file.record)
        .chain(surfaces)
        .chain(before)
        .collect();
    report.outputs.push(written("report", &command.html));
    let shown = Shown {
        surface: facets,
        start: start.as_ref(),
        ..Shown::of(&mesh)
    };
    let features = summary::of_features(&mut report, &mesh, facets);
    html::write(&command.html, &shown, &report)?;
    let table = summary::of_assessment(&assessment, &criteria.limits, command.talk.verbose);
    let end = summary::of_files(&report) + &summary::of_verdict(report.assessment.verdict);
    tell(command.talk.quiet, &(table + &features + &end))?;
    Ok(Exit::of_check(report.assessment.verdict == Verdict::Pass))
}
