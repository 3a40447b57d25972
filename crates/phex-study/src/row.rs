//! What a table tells of a variant: a column for each figure.

use crate::variant::Variant;
use phex::quality::Verdict;
use phex::report::RunReport;
use phex_job::{JobError, JobResult, Unit};
use phex_mesh::HexMesh;
use phex_mesh::cluster::by_value;
use serde_json::{Map, Value, json};

/// A row: `in:` what was wanted, `out:` what came of it, `img`, `threeD` files, `key` the folder.
pub type Row = Map<String, Value>;

/// Millimetres up to which two edges have the same length.
const SAME_LENGTH: f64 = 1.0;

/// How a variant ended: a word, the program's exit code, and why.
pub(crate) struct Ending {
    pub status: &'static str,
    pub exit: u8,
    pub reason: String,
}

impl Ending {
    /// How a job without a mesh ended.
    pub fn of_error(error: &JobError) -> Self {
        let (status, exit) = match error {
            JobError::Input(_) => ("unusable-input", 4),
            JobError::NoResult(_) => ("no-result", 5),
            JobError::Cancelled => ("cancelled", 130),
            JobError::Internal(_) => ("internal-error", 1),
        };
        Self {
            status,
            exit,
            reason: error.to_string(),
        }
    }

    /// How a judged mesh is.
    pub fn of_report(report: &RunReport) -> Self {
        let (status, exit) = match report.assessment.verdict {
            Verdict::Pass => ("pass", 0),
            Verdict::OutsideTolerance => ("outside-tolerance", 3),
            Verdict::Invalid => ("invalid", 5),
        };
        let failed = report.assessment.checks.iter().filter(|c| !c.pass);
        let failed: Vec<&str> = failed.map(|c| c.name).collect();
        Self {
            status,
            exit,
            reason: failed.join(", "),
        }
    }
}

/// The row of a variant without figures.
pub(crate) fn row(variant: &Variant, key: &str, ending: &Ending) -> Row {
    let mut columns = variant.inputs();
    columns.insert("key".to_owned(), json!(key));
    columns.insert("out:status".to_owned(), json!(ending.status));
    columns.insert("out:exit".to_owned(), json!(ending.exit));
    columns.insert("out:reason".to_owned(), json!(ending.reason));
    columns
}

/// The row of a variant that was not computed to its end, for a reason outside of it.
///
/// # Errors
/// As [`Variant::key`].
pub fn lost(variant: &Variant, reason: &str) -> Result<Row, JobError> {
    let ending = Ending {
        status: "lost",
        exit: 1,
        reason: reason.to_owned(),
    };
    Ok(row(variant, &variant.key()?, &ending))
}

/// Adds the figures of a mesh: see `docs/book/src/studies.md` for what each column is.
pub(crate) fn add_figures(columns: &mut Row, made: &JobResult) {
    let (report, measures) = (&made.report, &made.report.assessment.measures);
    let deviation = report.assessment.judged_deviation();
    let evenness = measures.evenness.as_ref();
    let figures = [
        ("panels", json!(measures.faces)),
        (
            "deviation",
            json!(deviation.map(|d| 100.0 * d.deviation_max)),
        ),
        ("clearance", json!(measures.clearance.min)),
        ("planarity", json!(measures.planarity.max)),
        ("hexagons", json!(measures.hex.map(|h| 100.0 * h))),
        ("irregular", json!(measures.irregular)),
        ("concave", json!(measures.faces_concave)),
        ("least-angle", json!(measures.angle.min)),
        ("area-spread", json!(evenness.map(|e| e.area_spread))),
        ("mean-edge", json!(measures.mean_edge)),
        (
            "distinct-lengths",
            json!(distinct_lengths(&made.mesh, made.limits.unit)),
        ),
    ];
    for (name, value) in figures {
        columns.insert(format!("out:{name}"), value);
    }
}

/// The least number of lengths to which all edges can be rounded.
fn distinct_lengths(mesh: &HexMesh, unit: Unit) -> usize {
    let mm = unit.metres() / Unit::Mm.metres();
    let edges = mesh.topology().edges();
    let lengths: Vec<f64> = edges.map(|e| mm * mesh.edge_length(e)).collect();
    by_value(&lengths, SAME_LENGTH).len()
}
