//! Judging a mesh: limits as they were typed to tolerances, verdicts to exit codes, reports and
//! pictures to files.

use crate::exit::{Exit, Failure};
use crate::html::{self, Shown};
use crate::output::{self, Content};
use crate::settings::MeshSettings;
use crate::shared_arguments::{Extras, ToleranceArguments};
use crate::units::{Quantity, Unit};
use anyhow::Context;
use phex::Boundary;
use phex::optimise::OptimiseOptions;
use phex::quality::{Assessment, Check, Reading, References, Scale, Verdict};
use phex::report::{OutputFile, RunReport};
use phex_mesh::{HexMesh, TriangleSurface};
use phex_picture::{PictureOptions, draw};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::path::Path;

/// Planarity that the optimiser reaches in double precision, in diagonals over mean edges. What is
/// asked for below is judged as it is, but nothing else is given up for it.
const REACHED: f64 = 16.0 * f64::EPSILON;

/// Limits as they were typed: what every command judges a mesh by, and what its report says of
/// that.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct TypedLimits {
    /// Of planarity.
    pub planarity: Option<Quantity>,
    /// Of the distance to the surface.
    pub max_deviation: Quantity,
    /// The model's unit.
    pub unit: Unit,
    /// What panels were to do at the boundary, where neither curve nor ground plane leads it
    /// elsewhere.
    pub boundary: Option<Boundary>,
}

impl From<&ToleranceArguments> for TypedLimits {
    fn from(limits: &ToleranceArguments) -> Self {
        let settings = MeshSettings {
            max_deviation: limits.max_deviation,
            ..Default::default()
        };
        Self {
            planarity: limits.planarity,
            max_deviation: settings.max_deviation(),
            unit: limits.unit,
            boundary: None,
        }
    }
}

impl From<&MeshSettings> for TypedLimits {
    fn from(settings: &MeshSettings) -> Self {
        let stages = &settings.stages;
        Self {
            planarity: settings.planarity,
            max_deviation: settings.max_deviation(),
            unit: settings.unit.unwrap_or_default(),
            boundary: Some(stages.boundary),
        }
    }
}

impl TypedLimits {
    /// What is typed, and where nothing is what an earlier run promised; the unit is that run's.
    pub fn or_promised(
        limits: &ToleranceArguments,
        boundary: Option<Boundary>,
        promised: Option<Self>,
    ) -> Self {
        let typed = Self {
            boundary,
            ..Self::from(limits)
        };
        let Some(promised) = promised else {
            return typed;
        };
        Self {
            planarity: limits.planarity.or(promised.planarity),
            max_deviation: limits.max_deviation.unwrap_or(promised.max_deviation),
            unit: promised.unit,
            boundary: boundary.or(promised.boundary),
        }
    }

    /// Tells the optimiser what is demanded of a mesh with edges of length `edge` and diagonal
    /// `extent`, model units; percentages of the deviation refer to the diagonal `whole`.
    pub fn demand(&self, options: &mut OptimiseOptions, edge: f64, extent: f64, whole: f64) {
        if let Some(planarity) = self.planarity {
            let rounding = REACHED * extent / edge;
            options.planarity_tolerance = planarity.fraction(self.unit, edge).max(rounding);
        }
        let most = self.max_deviation.length(self.unit, whole) / extent;
        options.max_deviation = (most > 0.0).then_some(most);
    }

    fn limits(&self, mesh: &HexMesh, surface: Option<&TriangleSurface>) -> phex::quality::Limits {
        let planarity = self.planarity;
        let relative = |surface: &TriangleSurface| {
            let diagonal = surface.diagonal();
            self.max_deviation.length(self.unit, diagonal) / diagonal
        };
        let mut limits = phex::quality::Limits::new(surface.map(relative), self.boundary);
        limits.validity.planarity = planarity.map(|q| q.fraction(self.unit, mesh.mean_edge()));
        limits
    }

    /// Judges a mesh by these limits.
    pub fn judge(&self, mesh: &HexMesh, references: References<'_>) -> Assessment {
        let limits = self.limits(mesh, references.smooth.or(references.facets));
        let mut assessment = Assessment::new(mesh, references, &limits);
        let edge = assessment.measures.mean_edge;
        let diagonal = assessment.judged_deviation().map(|d| d.diagonal);
        for check in &mut assessment.checks {
            check.reading = self.reading(check, edge, diagonal);
        }
        assessment
    }

    /// A check's figures in the unit in which its limit was typed.
    fn reading(&self, check: &Check, edge: f64, diagonal: Option<f64>) -> Option<Reading> {
        let planarity = self.planarity.filter(|q| !q.is_plain());
        let (typed, whole) = match (check.name, check.scale) {
            ("planarity", _) => (planarity?, edge),
            (_, Scale::Diagonals) => (self.max_deviation, diagonal?),
            _ => return None,
        };
        let (unit, length) = typed.unit(self.unit, whole);
        Some(Reading {
            unit: unit.to_owned(),
            limit: typed.value(),
            value: check.value_length? / length,
        })
    }

    /// The unit in which distances are told: that of the limit, where it was typed with one.
    pub fn shown(&self) -> (&'static str, f64) {
        match self.max_deviation.unit(self.unit, 1.0) {
            ("%", _) => (self.unit.name(), 1.0),
            unit => unit,
        }
    }

    /// A report of a command around what came of judging by these limits.
    pub fn report(&self, command: &'static str, assessment: Assessment) -> RunReport {
        RunReport {
            unit: self.unit.to_string(),
            // Text and numbers always become JSON.
            limits: serde_json::to_value(self).unwrap_or(Value::Null),
            ..RunReport::new(command, assessment)
        }
    }
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
        [&self.report, &self.png, &self.html]
            .into_iter()
            .flatten()
            .map(|path| (path.as_path(), Content::Other))
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
    }
}
