//! The JSON report of a run.

use super::FeatureSizes;
use crate::quality::{Assessment, contradiction};
use crate::repetition::Repetition;
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
    /// SHA-256 of its bytes, hexadecimal, of a file by which the mesh can be judged again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sha256: Option<String>,
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
    /// Verdict, checks, figures and violations of the mesh.
    #[serde(flatten)]
    pub assessment: Assessment,
    /// What the mesh was judged by, as it was typed: `planarity`, `max_deviation`, `boundary`,
    /// `unit`; `phex check --report-of` reads it.
    pub limits: Value,
    /// How large panels are for the surface's curvature; `null` without a surface.
    pub feature_sizes: Option<FeatureSizes>,
    /// How many parts are alike, before edges were made equal and now; `null` where that was not
    /// asked for.
    pub repetition: Option<Repetition>,
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
            assessment,
            limits: Value::Null,
            feature_sizes: None,
            repetition: None,
            notes,
            outputs: Vec::new(),
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
