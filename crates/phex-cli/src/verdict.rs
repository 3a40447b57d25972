//! Judging a mesh: limits of the command line to tolerances, verdicts to exit codes, reports and
//! pictures to files.

use crate::exit::{Exit, Failure};
use crate::html::{self, Shown};
use crate::output;
use crate::shared_arguments::{Extras, ToleranceArguments};
use anyhow::Context;
use phex::Boundary;
use phex::quality::Verdict;
use phex::report::{OutputFile, RunReport};
use phex_job::{Content, TypedLimits};
use phex_picture::{PictureOptions, draw};
use std::path::Path;

impl From<&ToleranceArguments> for TypedLimits {
    fn from(limits: &ToleranceArguments) -> Self {
        or_promised(limits, None, None)
    }
}

/// What is typed, and where nothing is what an earlier run promised.
pub fn or_promised(
    limits: &ToleranceArguments,
    boundary: Option<Boundary>,
    promised: Option<TypedLimits>,
) -> TypedLimits {
    let typed = (limits.planarity, limits.max_deviation);
    (promised.unwrap_or_default()).under(typed, limits.unit, boundary)
}

/// The exit code of a run that made a mesh.
pub fn exit_of(verdict: Verdict) -> Exit {
    match verdict {
        Verdict::Pass => Exit::Success,
        Verdict::OutsideTolerance => Exit::OutsideTolerance,
        Verdict::Invalid => Exit::NoValidResult,
    }
}

impl Extras {
    /// The files that these options ask for.
    pub fn outputs(&self) -> impl Iterator<Item = (&Path, Content)> {
        let all = [
            (&self.report, Content::Other),
            (&self.png, Content::Picture),
            (&self.html, Content::Page),
        ];
        all.into_iter()
            .filter_map(|(path, content)| Some((path.as_deref()?, content)))
    }

    /// Writes the picture and the reports that are wanted.
    ///
    /// # Errors
    /// If one can't be written.
    pub fn write(&self, shown: &Shown<'_>, report: &mut RunReport) -> Result<(), Failure> {
        if let Some(path) = &self.png {
            output::write_picture(path, &draw(shown.mesh, &PictureOptions::default()))?;
            report.outputs.push(written("picture", path));
        }
        if let Some(path) = &self.report {
            report.outputs.push(written("json_report", path));
        }
        if let Some(path) = &self.html {
            report.outputs.push(written("report", path));
            html::write(path, shown, report)?;
        }
        self.write_json(report)
    }

    fn write_json(&self, report: &RunReport) -> Result<(), Failure> {
        let Some(path) = &self.report else {
            return Ok(());
        };
        let json = report.to_json().context("the run report")?;
        output::write_text(path, &json)
    }
}

/// An entry of the report's list of outputs.
pub fn written(content: &'static str, path: &Path) -> OutputFile {
    OutputFile {
        content,
        path: path.display().to_string(),
        sha256: None,
    }
}
