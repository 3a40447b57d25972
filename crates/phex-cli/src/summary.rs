//! The short table on standard output.

use crate::html;
use crate::units::Unit;
use phex::report::maps::FeatureSizes;
use phex::report::{Assessment, Check, ElementKind, RunReport, Verdict};
use phex_mesh::ElementId;
use phex_mesh::measure::{BoundaryFit, Deviation, LEAST_RIM_AREA, MeshMeasures};
use phex_mesh::{HexMesh, TriangleSurface};
use std::fmt::Write;

/// How many offenders of a check are listed; the report holds all of them.
const LISTED: usize = 10;

/// Lines of a label and a text each.
#[derive(Clone, Debug, Default)]
pub struct Table {
    text: String,
}

impl Table {
    /// Adds a line.
    pub fn row(&mut self, label: &str, text: impl std::fmt::Display) {
        // Writing to a string does not fail.
        let _ = writeln!(self.text, "{label:<12} {text}");
    }

    /// The table.
    pub fn into_text(self) -> String {
        self.text
    }
}

/// Figures, deviation and verdict of a mesh; with `every_check` also the checks that pass.
pub fn of_assessment(assessment: &Assessment, unit: Unit, every_check: bool) -> String {
    let mut table = Table::default();
    let measures = &assessment.measures;
    table.row("panels", panels(measures));
    table.row("planarity", planarity(measures, unit));
    table.row("", planarity_by_diagonals(measures));
    table.row("simple", simple(assessment));
    table.row("sound", sound(assessment));
    table.row("clearance", clearance(measures));
    table.row("edges", edges(measures, unit));
    if let Some(deviation) = &assessment.deviation_smooth {
        table.row(
            "deviation",
            format!("{} from the smooth surface", distance(deviation, unit)),
        );
    }
    if let Some(deviation) = &assessment.deviation_facets {
        table.row(
            "deviation",
            format!("{} from the given facets", distance(deviation, unit)),
        );
    }
    if let Some(fit) = &assessment.boundary {
        table.row("boundary", boundary(fit));
        table.row("", rim(fit));
    }
    for check in assessment.checks.iter().filter(|c| every_check || !c.pass) {
        table.row(if check.pass { "ok" } else { "FAILED" }, said(check));
    }
    table.row("verdict", verdict(assessment.verdict));
    table.into_text()
}

/// Panels that are too large for the surface's features, if there are any; kept in the report too.
pub fn of_features(
    report: &mut RunReport,
    mesh: &HexMesh,
    surface: Option<&TriangleSurface>,
) -> String {
    let sizes = surface.map(|surface| FeatureSizes::new(mesh, surface));
    let mut table = Table::default();
    if let Some(warning) = sizes.as_ref().and_then(FeatureSizes::warning) {
        table.row("WARNING", &warning);
        report.notes.push(warning);
    }
    report.feature_sizes = sizes;
    table.into_text()
}

/// What came of wishes, by what each is about; kept in the report too.
pub fn of_wishes(report: &mut RunReport, told: Vec<(&'static str, String)>) -> String {
    let mut table = Table::default();
    for (what, sentence) in told {
        table.row(what, &sentence);
        report.notes.push(format!("{what}: {sentence}"));
    }
    table.into_text()
}

/// The files that were written, or why the mesh was not.
pub fn of_outputs(report: &RunReport) -> String {
    let mut table = Table::default();
    if !report.outputs.iter().any(|output| output.content == "mesh") {
        table.row(
            "NOT WRITTEN",
            "the mesh, since it is not valid (--keep-invalid writes it)",
        );
    }
    of_files(report) + &table.into_text()
}

/// The files that were written.
pub fn of_files(report: &RunReport) -> String {
    let mut table = Table::default();
    for output in &report.outputs {
        table.row("written", &output.path);
        if let Some(note) = html::without_view().filter(|_| output.content == "report") {
            table.row("", note);
        }
    }
    table.into_text()
}

fn panels(measures: &MeshMeasures) -> String {
    let name = |corners: usize| match corners {
        3 => "triangles".to_owned(),
        4 => "quads".to_owned(),
        5 => "pentagons".to_owned(),
        6 => "hexagons".to_owned(),
        7 => "heptagons".to_owned(),
        8 => "octagons".to_owned(),
        n => format!("{n}-gons"),
    };
    let mut sizes: Vec<_> = measures.face_sizes.iter().collect();
    sizes.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let list: Vec<String> = sizes
        .iter()
        .map(|&(&corners, count)| format!("{count} {}", name(corners)))
        .collect();
    format!(
        "{} ({}; {} concave)",
        measures.faces,
        list.join(", "),
        measures.faces_concave
    )
}

fn planarity(measures: &MeshMeasures, unit: Unit) -> String {
    let (relative, length) = (&measures.planarity, &measures.planarity_length);
    format!(
        "max {:.1e}, mean {:.1e} mean edges; max {:.1e} {unit}{}",
        relative.max,
        relative.mean,
        length.max,
        worst("face", &relative.worst)
    )
}

/// The measure of PH-CPF and others.
fn planarity_by_diagonals(measures: &MeshMeasures) -> String {
    let by = &measures.planarity_diagonals;
    format!(
        "max {:.1e}, mean {:.1e} mean diagonals, by their distance{}",
        by.max,
        by.mean,
        worst("face", &by.worst)
    )
}

/// The worst element of a figure.
fn worst<I: ElementId>(kind: &str, worst: &[I]) -> String {
    let named = worst.first().map(|id| format!(" ({kind} {})", id.index()));
    named.unwrap_or_default()
}

fn clearance(measures: &MeshMeasures) -> String {
    let (room, angle) = (&measures.clearance, &measures.angle);
    format!(
        "least {:.3} mean edges{}; least angle {:.1} degrees{}",
        room.min,
        worst("face", &room.worst),
        angle.min,
        worst("face", &angle.worst)
    )
}

/// What concerns several faces: each kind with its number, or that there is none.
fn sound(assessment: &Assessment) -> String {
    const KINDS: [(&str, &str); 5] = [
        ("flipped_faces", "flipped faces"),
        ("wrong_fans", "vertex fans that do not go round once"),
        ("wrong_degree", "inner vertices without three faces"),
        ("crossings", "edges that cross faces"),
        ("folds", "folded edges"),
    ];
    let count = |(name, text): &(&str, &str)| {
        let check = assessment.checks.iter().find(|c| c.name == *name)?;
        let first = check.ids.first()?;
        Some(format!("{} {text} (first {first})", check.ids.len()))
    };
    let found: Vec<String> = KINDS.iter().filter_map(count).collect();
    if found.is_empty() {
        "no flips, folds or crossings between faces; every fan goes round once".to_owned()
    } else {
        found.join(", ")
    }
}

fn simple(assessment: &Assessment) -> String {
    let mut checks = assessment.checks.iter();
    let crossed = checks.find(|c| c.name == "faces_not_simple");
    match crossed.map_or(&[][..], |c| &c.ids) {
        [] => "every face, by exact predicates".to_owned(),
        ids => format!("{} faces are NOT simple (first {})", ids.len(), ids[0]),
    }
}

fn edges(measures: &MeshMeasures, unit: Unit) -> String {
    let MeshMeasures {
        edge_length,
        mean_edge,
        ..
    } = measures;
    format!(
        "mean {mean_edge:.4} {unit}, from {:.2}{} to {:.2} of it",
        edge_length.min,
        worst("edge", &edge_length.worst),
        edge_length.max
    )
}

fn distance(deviation: &Deviation, unit: Unit) -> String {
    let length = deviation.deviation_max * deviation.diagonal;
    format!(
        "max {}, rms {} of the diagonal, back {}; max {length:.4} {unit}{}",
        percent(deviation.deviation_max),
        percent(deviation.deviation_rms),
        percent(deviation.coverage_max),
        farthest(deviation)
    )
}

/// The vertex or face centre that is farthest from the surface.
fn farthest(deviation: &Deviation) -> String {
    let (vertices, centres) = (&deviation.vertices, &deviation.face_centres);
    if vertices.max >= centres.max {
        worst("vertex", &vertices.worst)
    } else {
        worst("face", &centres.worst)
    }
}

/// How the mesh ends where the surface ends.
fn boundary(fit: &BoundaryFit) -> String {
    let mut text = format!(
        "{} of the area covered, {} of the panels' area beyond; distance {}, back {} of the diagonal",
        percent(fit.covered_area),
        percent(fit.overhang_area),
        percent(fit.to_curve_max),
        percent(fit.from_curve_max)
    );
    if fit.corners > 0 {
        let _ = write!(
            text,
            "; {} corners within {}",
            fit.corners,
            percent(fit.corner_max)
        );
    }
    text
}

/// The smallest panels at the boundary.
fn rim(fit: &BoundaryFit) -> String {
    let area = &fit.rim_area;
    let mut text = format!(
        "{} panels at the boundary, the smallest has {:.2} of the mean area{}",
        area.count,
        area.min,
        worst("face", &area.worst)
    );
    if let Some(first) = fit.small.first() {
        let _ = write!(
            text,
            "; {} have less than {LEAST_RIM_AREA} (first face {})",
            fit.small.len(),
            first.index()
        );
    }
    text
}

fn percent(fraction: f64) -> String {
    format!("{:.3} %", 100.0 * fraction)
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "PASS",
        Verdict::OutsideTolerance => "OUTSIDE TOLERANCE",
        Verdict::Invalid => "INVALID",
    }
}

/// One check: name, figure, limit, first offenders.
fn said(check: &Check) -> String {
    let mut text = format!(
        "{}: {}, limit {}",
        check.name,
        figure(check.value),
        figure(check.limit)
    );
    if check.ids.is_empty() {
        return text;
    }
    let kind = match check.element {
        ElementKind::Vertex => "vertices",
        ElementKind::Edge => "edges",
        ElementKind::Face => "faces",
        ElementKind::Mesh => "elements",
    };
    let first: Vec<String> = check
        .ids
        .iter()
        .take(LISTED)
        .map(ToString::to_string)
        .collect();
    let _ = write!(text, "; {kind} {}", first.join(" "));
    if check.ids.len() > LISTED {
        let _ = write!(text, " and {} more", check.ids.len() - LISTED);
    }
    text
}

fn figure(value: f64) -> String {
    let plain = value == 0.0 || (1e-3..1e6).contains(&value.abs());
    if plain && value.fract() == 0.0 {
        format!("{value:.0}")
    } else if plain {
        format!("{value:.4}")
    } else {
        format!("{value:.1e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_short_at_every_size() {
        let cases = [
            (0.0, "0"),
            (3.0, "3"),
            (0.05, "0.0500"),
            (4.2e-15, "4.2e-15"),
            (f64::NAN, "NaN"),
        ];
        for (value, text) in cases {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn long_lists_of_offenders_are_cut() {
        let check = Check {
            name: "faces_not_simple",
            limit: 0.0,
            value: 12.0,
            pass: false,
            decisive: true,
            element: ElementKind::Face,
            ids: (0..12).collect(),
        };
        assert_eq!(
            said(&check),
            "faces_not_simple: 12, limit 0; faces 0 1 2 3 4 5 6 7 8 9 and 2 more"
        );
    }
}
