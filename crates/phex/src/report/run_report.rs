//! The JSON report of a run.

use super::FeatureSizes;
use crate::quality::{Assessment, Check, Omitted, Verdict, contradiction};
use crate::repetition::Repetition;
use phex_mesh::measure::{BoundaryFit, Deviation, MeshMeasures};
use phex_mesh::validate::Violation;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Version of the report's layout; it changes when a field changes its meaning or goes away.
pub const SCHEMA_VERSION: u32 = 1;

/// The program that wrote a report.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Tool {
    /// Name of the program.
    pub name: &'static str,
    /// Its version.
    pub version: &'static str,
}

impl Default for Tool {
    fn default() -> Self {
        Self {
            name: "phex",
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Path as it was given.
    pub path: String,
    /// SHA-256 of its bytes, hexadecimal.
    pub sha256: String,
    /// Number of vertices in it.
    pub vertices: usize,
    /// Number of faces in it.
    pub faces: usize,
}

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct OutputFile {
    /// What it holds (`mesh`, `smooth_target`, `picture`).
    pub content: &'static str,
    /// Path as it was given.
    pub path: String,
}

/// How long a stage took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: String,
    /// Wall time in seconds, summed over its calls.
    pub seconds: f64,
}

/// Everything that is to be known about a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunReport {
    /// Version of this layout.
    pub schema_version: u32,
    /// The program.
    pub tool: Tool,
    /// The command (`mesh`, `planarize`, `check`).
    pub command: &'static str,
    /// What was read.
    pub inputs: Vec<InputFile>,
    /// Unit of the model's coordinates.
    pub unit: String,
    /// All settings, defaults included.
    pub settings: Value,
    /// Seed of every random choice.
    pub seed: u64,
    /// Number of threads; results do not depend on it.
    pub threads: usize,
    /// Time of each stage.
    pub stages: Vec<StageTime>,
    /// Iterations, residuals and counts that the stages kept.
    pub statistics: Value,
    /// How the computation ended.
    pub outcome: Value,
    /// What the checks amount to.
    pub verdict: Verdict,
    /// Every check that was made.
    pub checks: Vec<Check>,
    /// Every check that was not.
    pub not_checked: Vec<Omitted>,
    /// What the mesh was judged by, as it was typed: `planarity`, `max_deviation`, `boundary`,
    /// `unit`; `phex check --report-of` reads it.
    pub limits: Value,
    /// Figures of the mesh.
    pub measures: MeshMeasures,
    /// Distance to the smooth target.
    pub deviation_smooth: Option<Deviation>,
    /// Distance to the original facets.
    pub deviation_facets: Option<Deviation>,
    /// How the mesh ends where the surface ends; `null` without a surface, or if one of the two is
    /// closed.
    pub boundary: Option<BoundaryFit>,
    /// How large panels are for the surface's curvature; `null` without a surface.
    pub feature_sizes: Option<FeatureSizes>,
    /// How many parts are alike, before edges were made equal and now; `null` where that was not
    /// asked for.
    pub repetition: Option<Repetition>,
    /// Everything that is wrong, located.
    pub violations: Vec<Violation>,
    /// What was noticed on the way.
    pub notes: Vec<String>,
    /// What was written.
    pub outputs: Vec<OutputFile>,
}

impl RunReport {
    /// A report of `command` around an assessment; the rest is empty and is filled in by field.
    ///
    /// ```
    /// # use phex_mesh::{HexMesh, Vec3};
    /// # let corners = [Vec3::x(), Vec3::y(), Vec3::z()].to_vec();
    /// # let mesh = HexMesh::new(corners, &[[0, 1, 2]])?;
    /// use phex::quality::{Assessment, Limits, References};
    /// use phex::report::RunReport;
    ///
    /// let assessment = Assessment::new(&mesh, References::default(), &Limits::default());
    /// let json = RunReport::new("check", assessment).to_json()?;
    /// assert!(json.contains("\"verdict\": \"pass\""));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(command: &'static str, assessment: Assessment) -> Self {
        let told = [assessment.calm_line(), contradiction(&assessment.checks)];
        let notes = told.into_iter().flatten().collect();
        Self {
            schema_version: SCHEMA_VERSION,
            tool: Tool::default(),
            command,
            inputs: Vec::new(),
            unit: "m".to_owned(),
            settings: Value::Null,
            seed: 0,
            threads: 1,
            stages: Vec::new(),
            statistics: Value::Null,
            outcome: Value::Null,
            verdict: assessment.verdict,
            checks: assessment.checks,
            not_checked: assessment.not_checked,
            limits: Value::Null,
            measures: assessment.measures,
            deviation_smooth: assessment.deviation_smooth,
            deviation_facets: assessment.deviation_facets,
            boundary: assessment.boundary,
            feature_sizes: None,
            repetition: None,
            violations: assessment.violations,
            notes,
            outputs: Vec::new(),
        }
    }

    /// The deviation that the tolerance refers to, where there is a surface.
    pub fn judged_deviation(&self) -> Option<&Deviation> {
        (self.deviation_smooth.as_ref()).or(self.deviation_facets.as_ref())
    }

    /// The assessment that the report was made around.
    pub fn assessment(&self) -> Assessment {
        Assessment {
            verdict: self.verdict,
            checks: self.checks.clone(),
            not_checked: self.not_checked.clone(),
            measures: self.measures.clone(),
            deviation_smooth: self.deviation_smooth.clone(),
            deviation_facets: self.deviation_facets.clone(),
            boundary: self.boundary.clone(),
            calmed: None,
            violations: self.violations.clone(),
        }
    }

    /// The report as indented JSON with a final line break. Figures that do not exist (of no
    /// element) are `null`.
    ///
    /// # Errors
    /// Never for reports made by this crate; `settings`, `statistics` or `outcome` from elsewhere
    /// may fail.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string_pretty(self).map(|json| json + "\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::{Limits, References};
    use phex_mesh::{HexMesh, Vec3};

    #[test]
    fn json_holds_what_a_script_needs() {
        let corners = [
            (0.0, 0.0, 0.0),
            (1.0, 0.0, 0.0),
            (1.0, 1.0, 0.3),
            (0.0, 1.0, 0.0),
        ];
        let positions = corners
            .iter()
            .map(|&(x, y, z)| Vec3::new(x, y, z))
            .collect();
        let mesh = HexMesh::new(positions, &[[0, 1, 2, 3]]).unwrap();
        let assessment = Assessment::new(&mesh, References::default(), &Limits::default());
        let json = RunReport::new("check", assessment).to_json().unwrap();
        let report: Value = serde_json::from_str(&json).unwrap();
        assert_eq!(report["schema_version"], 1);
        assert_eq!(report["verdict"], "outside_tolerance");
        assert_eq!(report["measures"]["planarity"]["worst"][0], 0);
        assert!(
            report["measures"]["dihedral"]["max"].is_null(),
            "no interior edge, no dihedral angle"
        );
        let checks = report["checks"].as_array().unwrap();
        let planarity = checks.iter().find(|c| c["name"] == "planarity").unwrap();
        assert_eq!(
            (&planarity["pass"], &planarity["ids"][0]),
            (&Value::Bool(false), &Value::from(0))
        );
        assert!(planarity["limit"].as_f64() < planarity["value"].as_f64());
    }
}
