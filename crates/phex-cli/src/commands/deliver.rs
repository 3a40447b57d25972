//! Delivering a mesh that was made: files, table, exit code. Every command that makes a mesh ends
//! here.

use super::tell;
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::output::write_mesh;
use crate::shared_arguments::{Extras, Talk};
use crate::summary;
use crate::verdict::{exit_of, written};
use phex::quality::{References, Verdict};
use phex::report::RunReport;
use phex_job::{Content, TypedLimits};
use std::path::Path;

/// A mesh on its way to the user.
pub struct Delivery<'a> {
    /// The mesh, and what it is shown with.
    pub shown: Shown<'a>,
    /// Where it goes; nowhere if only its figures are wanted.
    pub output: Option<&'a Path>,
    /// Whether it is written even if it is not valid.
    pub keep_invalid: bool,
    /// Whether it is judged as a panelling; a dual is none.
    pub panels: bool,
    /// Report and picture.
    pub extras: &'a Extras,
    /// How to talk.
    pub talk: &'a Talk,
    /// What it was judged by.
    pub limits: TypedLimits,
    /// Lines of the table before the mesh's figures.
    pub before: String,
    /// Lines of the table after the mesh's figures.
    pub after: String,
    /// The report, made round the mesh's assessment.
    pub report: RunReport,
}

impl<'a> Delivery<'a> {
    /// A panelling with its figures alone: no file is written, and nothing stands round the
    /// figures.
    pub fn new(
        shown: Shown<'a>,
        report: RunReport,
        limits: TypedLimits,
        extras: &'a Extras,
        talk: &'a Talk,
    ) -> Self {
        Self {
            shown,
            output: None,
            keep_invalid: false,
            panels: true,
            extras,
            talk,
            limits,
            before: String::new(),
            after: String::new(),
            report,
        }
    }

    /// Writes everything, prints the table, which ends with the verdict, and says with which code
    /// the program ends.
    ///
    /// # Errors
    /// If something can't be written.
    pub fn send(self) -> Result<Exit, Failure> {
        let (mut report, output) = (self.report, self.output);
        let verdict = report.assessment.verdict;
        let kept = !self.panels || verdict != Verdict::Invalid || self.keep_invalid;
        if let Some(path) = output.filter(|_| kept) {
            write_mesh(path, &self.shown.mesh.to_soup(), self.limits.unit)?;
            report.outputs.push(written("mesh", path));
        }
        self.extras.write(&self.shown, &mut report)?;
        let mut text = self.before;
        if self.panels {
            text += &summary::of_assessment(&report.assessment, &self.limits, self.talk.verbose);
        }
        text += &self.after;
        text += &summary::of_files(&report);
        if output.is_some() && !kept {
            text += &summary::not_written();
        }
        if self.panels {
            text += &summary::of_verdict(verdict);
        }
        tell(self.talk.quiet, &text)?;
        Ok(match self.panels {
            true => exit_of(verdict),
            false => Exit::Success,
        })
    }
}

/// The report of a mesh judged by typed limits against the surface that it is shown with.
pub fn judged(command: &'static str, shown: &Shown<'_>, limits: &TypedLimits) -> RunReport {
    let references = References::of_facets(shown.surface);
    limits.report(command, limits.judge(shown.mesh, references))
}

/// The files that a command writes.
pub fn outputs<'a>(output: &'a Path, extras: &'a Extras) -> Vec<(&'a Path, Content)> {
    std::iter::once((output, Content::Mesh))
        .chain(extras.outputs())
        .collect()
}
