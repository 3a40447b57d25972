//! Writing a mesh that was made without settings of its own: table, files, exit code.

use super::tell;
use crate::args::{Extras, Talk};
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::output::{Content, write_mesh};
use crate::summary::{self, Table};
use crate::verdict::{TypedLimits, written};
use phex::report::{InputFile, References, Verdict};
use phex_mesh::{HexMesh, TriangleSurface};
use serde_json::Value;
use std::path::Path;

/// A mesh on its way to the user.
pub struct Delivery<'a> {
    /// The command.
    pub command: &'static str,
    /// The mesh.
    pub mesh: &'a HexMesh,
    /// Where it goes.
    pub output: &'a Path,
    /// Report and picture.
    pub extras: &'a Extras,
    /// How to talk.
    pub talk: &'a Talk,
    /// What it is judged by.
    pub limits: TypedLimits,
    /// The surface that it stands for.
    pub surface: Option<&'a TriangleSurface>,
    /// Whether the checks of panels apply; a dual is no panelling.
    pub panels: bool,
    /// Lines that the command adds to the table.
    pub table: Table,
    /// Settings for the report.
    pub settings: Value,
    /// Statistics for the report.
    pub statistics: Value,
    /// What was read.
    pub inputs: Vec<InputFile>,
}

impl Delivery<'_> {
    /// Writes everything and prints the table.
    ///
    /// # Errors
    /// If something can't be written.
    pub fn send(self) -> Result<Exit, Failure> {
        let references = References {
            facets: self.surface,
            ..Default::default()
        };
        let assessment = self.limits.judge(self.mesh, references);
        let figures = summary::of_assessment(&assessment, &self.limits, self.talk.verbose);
        let mut report = self.limits.report(self.command, assessment);
        report.settings = self.settings;
        report.statistics = self.statistics;
        report.inputs = self.inputs;
        write_mesh(self.output, &self.mesh.to_soup())?;
        report.outputs.push(written("mesh", self.output));
        let shown = Shown {
            surface: self.surface,
            ..Shown::of(self.mesh)
        };
        self.extras.write(&shown, &mut report)?;
        let figures = if self.panels { figures } else { String::new() };
        let text = figures + &self.table.into_text() + &summary::of_outputs(&report);
        tell(self.talk.quiet, &text)?;
        Ok(if self.panels && report.verdict != Verdict::Pass {
            Exit::OutsideTolerance
        } else {
            Exit::Success
        })
    }
}

/// The files that a command writes.
pub fn outputs<'a>(output: &'a Path, extras: &'a Extras) -> Vec<(&'a Path, Content)> {
    std::iter::once((output, Content::Mesh))
        .chain(extras.outputs())
        .collect()
}
