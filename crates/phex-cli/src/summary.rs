//! The short table on standard output.

use crate::html;
use phex::quality::{Assessment, Check, ElementKind, Reason, Verdict, contradiction, told_place};
use phex::report::RunReport;
use phex_job::TypedLimits;
use phex_job::Unit;
use phex_job::add_features;
use phex_mesh::ElementId;
use phex_mesh::measure::{BoundaryFit, Deviation, LEAST_RIM_AREA, MeshMeasures};
use phex_mesh::{HexMesh, TriangleSurface};
use std::fmt::{Display, Write};

/// How many offenders of a check are listed; the report holds all of them.
const LISTED: usize = 10;

/// Lines of a label and a text each.
#[derive(Clone, Debug, Default)]
pub struct SummaryTable {
    text: String,
}

impl SummaryTable {
    /// Adds a line.
    pub fn row(&mut self, label: &str, text: impl Display) {
        self.text += &line(label, text);
    }

    /// The table.
    pub fn into_text(self) -> String {
        self.text
    }
}

/// One line.
fn line(label: &str, text: impl Display) -> String {
    format!("{label:<12} {text}\n")
}

/// Figures, deviation and failed checks of a mesh; with `every_check` also the checks that pass.
pub fn of_assessment(assessment: &Assessment, limits: &TypedLimits, every_check: bool) -> String {
    let unit = limits.unit;
    let mut table = SummaryTable::default();
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
            format!("{} from the smooth surface", distance(deviation, limits)),
        );
    }
    if let Some(deviation) = &assessment.deviation_facets {
        table.row(
            "deviation",
            format!("{} from the given facets", distance(deviation, limits)),
        );
    }
    if let Some(fit) = &assessment.boundary {
        table.row("boundary", boundary(fit));
    }
    if let Some(line) = assessment.calm_line() {
        table.row("note", line);
    }
    table.row("areas", areas(measures));
    for check in assessment.checks.iter().filter(|c| every_check || !c.pass) {
        table.row(if check.pass { "ok" } else { "FAILED" }, said(check));
        if let Some(advice) = &check.advice {
            table.row("", format!("what helps: {advice}"));
        }
    }
    if let Some(line) = contradiction(&assessment.checks) {
        table.row("note", line);
    }
    table.text += &not_checked(assessment);
    table.into_text()
}

/// The last line of the table.
pub fn of_verdict(verdict: Verdict) -> String {
    line("verdict", verdict)
}

/// The checks that were not made, a line for each reason; none if all were.
fn not_checked(assessment: &Assessment) -> String {
    let mut table = SummaryTable::default();
    let reasons = [
        (Reason::NoSurface, "there is no surface to compare with"),
        (
            Reason::NoLimit,
            "no limit is known (`phex check` takes --boundary snap, clip or whole, or --report-of RUN.JSON)",
        ),
        (
            Reason::NoSmoothSurface,
            "the smooth surface was not kept (`phex mesh --write-target` writes it)",
        ),
        (
            Reason::LeftWhole,
            "panels are left whole at the boundary and may stick out",
        ),
        (
            Reason::LedElsewhere,
            "the boundary of panels is led elsewhere than along the surface's own",
        ),
    ];
    for (reason, why) in reasons {
        let of_reason = assessment.not_checked.iter().filter(|o| o.reason == reason);
        let names: Vec<&str> = of_reason.map(|o| o.name).collect();
        if !names.is_empty() {
            table.row("not checked", format!("{}: {why}", names.join(", ")));
        }
    }
    table.into_text()
}

/// Panels that are too large for the surface's features, if there are any; kept in the report too.
pub fn of_features(
    report: &mut RunReport,
    mesh: &HexMesh,
    surface: Option<&TriangleSurface>,
) -> String {
    of_warnings(add_features(report, mesh, surface))
}

/// What is told though no check fails by it.
pub fn of_warnings(warnings: impl IntoIterator<Item = String>) -> String {
    warnings.into_iter().map(|w| line("WARNING", w)).collect()
}

/// How many parts are alike, before edges were made equal and now.
pub fn of_repetition(report: &RunReport) -> String {
    let mut table = SummaryTable::default();
    if let Some(told) = &report.repetition {
        let (before, after) = (&told.before, &told.after);
        let within = format!("{} {}", figure(told.tolerance), report.unit);
        table.row(
            "repetition",
            format!(
                "within {within}: {} -> {} edge lengths, {} -> {} panels ({} -> {} where mirrored ones count as equal)",
                before.edge_lengths,
                after.edge_lengths,
                before.panels,
                after.panels,
                before.panels_mirrored,
                after.panels_mirrored,
            ),
        );
        table.row(
            "",
            format!(
                "within {} degrees: {} -> {} angles at nodes",
                figure(told.angle_tolerance),
                before.node_angles,
                after.node_angles,
            ),
        );
    }
    table.into_text()
}

/// What came of wishes, by what each is about.
pub fn of_wishes(told: &[(&'static str, String)]) -> String {
    told.iter().map(|(what, s)| line(what, s)).collect()
}

/// Why the mesh was not written.
pub fn not_written() -> String {
    line(
        "NOT WRITTEN",
        "the mesh, since it is not valid (--keep-invalid writes it)",
    )
}

/// The files that were written.
pub fn of_files(report: &RunReport) -> String {
    let mut table = SummaryTable::default();
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
        3 => "triangle".to_owned(),
        4 => "quad".to_owned(),
        5 => "pentagon".to_owned(),
        6 => "hexagon".to_owned(),
        7 => "heptagon".to_owned(),
        8 => "octagon".to_owned(),
        n => format!("{n}-gon"),
    };
    let plural = |count: &usize| if *count == 1 { "" } else { "s" };
    let mut sizes: Vec<_> = measures.face_sizes.iter().collect();
    sizes.sort_by(|a, b| b.1.cmp(a.1).then(a.0.cmp(b.0)));
    let list: Vec<String> = sizes
        .iter()
        .map(|&(&corners, count)| format!("{count} {}{}", name(corners), plural(count)))
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
    const KINDS: [(&str, &str, &str); 5] = [
        ("flipped_faces", "flipped face", "flipped faces"),
        (
            "wrong_fans",
            "vertex fan that does not go round once",
            "vertex fans that do not go round once",
        ),
        (
            "wrong_degree",
            "inner vertex without three faces",
            "inner vertices without three faces",
        ),
        (
            "crossings",
            "edge that crosses faces",
            "edges that cross faces",
        ),
        ("folds", "folded edge", "folded edges"),
    ];
    let count = |(name, one, many): &(&str, &str, &str)| {
        let check = assessment.checks.iter().find(|c| c.name == *name)?;
        match check.ids[..] {
            [] => None,
            [id] => Some(format!("1 {one} ({id})")),
            [first, ..] => Some(format!("{} {many} (first {first})", check.ids.len())),
        }
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
        [face] => format!("face {face} is NOT"),
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
        "mean {} {unit}, from {:.2}{} to {:.2} of it",
        figure(*mean_edge),
        edge_length.min,
        worst("edge", &edge_length.worst),
        edge_length.max
    )
}

fn distance(deviation: &Deviation, limits: &TypedLimits) -> String {
    let (unit, of_unit) = limits.shown();
    let length = figure(deviation.deviation_max * deviation.diagonal / of_unit);
    format!(
        "max {}, rms {} of the diagonal, back {}; max {length} {unit}{}",
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

/// Area over the mean one from which on a panel is large: 1.7 times as long as others and as wide.
const LARGE_AREA: f64 = 3.0;

/// The smallest and the largest panels; small and large ones are named.
fn areas(measures: &MeshMeasures) -> String {
    let area = &measures.area_ratio;
    if area.min.is_nan() {
        return "the panels together have none: they cross themselves, or are lines".to_owned();
    }
    let mut text = format!(
        "from {:.2}{} to {:.2} of the mean",
        area.min,
        worst("face", &area.worst),
        area.max
    );
    let small = measures.small_faces.iter().map(|f| f.index()).collect();
    let areas = measures.per_element.area.enumerate();
    let largest = LARGE_AREA * measures.area / measures.faces as f64;
    let large = areas.filter(|(_, a)| **a > largest);
    let large = large.map(|(f, _)| f.index()).collect();
    let kinds: [(String, Vec<usize>); 2] = [
        (format!("below {LEAST_RIM_AREA}"), small),
        (format!("above {LARGE_AREA}"), large),
    ];
    for (kind, ids) in kinds.iter().filter(|k| !k.1.is_empty()) {
        let _ = write!(text, "; {kind}: {} ({})", ids.len(), listed("faces", ids));
    }
    text + &over_wished(measures).unwrap_or_default()
}

/// How even the areas of inner panels are, where they are to differ.
fn over_wished(measures: &MeshMeasures) -> Option<String> {
    let evenness = measures.evenness?;
    let (plain, wished) = (evenness.area_spread, evenness.over_wished?.spread);
    let [plain, wished] = [plain, wished].map(|spread| format!("{spread:.2}"));
    (plain != wished).then(|| format!("; inner p95/p5 {plain}, {wished} over the wished"))
}

fn percent(fraction: f64) -> String {
    format!("{:.3} %", 100.0 * fraction)
}

/// One check: name, figure, limit, the worst place, first offenders.
fn said(check: &Check) -> String {
    let [value, limit, unit] = figures(check);
    let mut text = format!("{}: {value}, limit {limit}{unit}", check.name);
    if let Some(place) = check.place.map(told_place) {
        let _ = write!(text, ", worst at {place}");
    }
    let kind = match check.element {
        ElementKind::Vertex => "vertices",
        ElementKind::Edge => "edges",
        ElementKind::Face => "faces",
        ElementKind::Mesh => "elements",
    };
    if !check.ids.is_empty() {
        let _ = write!(text, "; {}", listed(kind, &check.ids));
    }
    text
}

/// Figure, limit and unit of a check, as the limit was typed.
fn figures(check: &Check) -> [String; 3] {
    let shown = check.shown();
    let [value, limit] = shown.in_words(figure);
    let value = match &check.reading {
        Some(reading) => format!("{value} {}", reading.unit),
        None if shown.unit.starts_with('%') => format!("{value} %"),
        None => value,
    };
    let space = if shown.unit.is_empty() { "" } else { " " };
    [value, limit, format!("{space}{}", shown.unit)]
}

/// The first of some numbers of elements, and how many more there are.
fn listed(kind: &str, ids: &[usize]) -> String {
    let first = ids.iter().take(LISTED).map(ToString::to_string);
    let mut text = format!("{kind} {}", first.collect::<Vec<_>>().join(" "));
    if ids.len() > LISTED {
        let _ = write!(text, " and {} more", ids.len() - LISTED);
    }
    text
}

/// Digits of a figure.
const FIGURE_DIGITS: i32 = 4;

fn figure(value: f64) -> String {
    digits(value, FIGURE_DIGITS)
}

/// A number with at most so many digits that mean something; very large and small ones with two and
/// a power of ten.
fn digits(value: f64, most: i32) -> String {
    let size = value.abs();
    if value == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.1e}").replace(".0e", "e");
    }
    let decimals = (most - 1 - size.log10().floor() as i32).max(0) as usize;
    let text = format!("{value:.decimals$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex::quality::{Reading, Scale};

    #[test]
    fn figures_are_short_at_every_size() {
        let cases = [
            (0.0, "0"),
            (3.0, "3"),
            (0.05, "0.05"),
            (62.4567, "62.46"),
            (-86.134_976_790_457_93, "-86.13"),
            (1e-9, "1e-9"),
            (4.2e-15, "4.2e-15"),
            (f64::NAN, "NaN"),
        ];
        for (value, text) in cases {
            assert_eq!(figure(value), text);
        }
    }

    fn failed(name: &'static str, scale: Scale) -> Check {
        Check {
            name,
            limit: 0.0,
            is_least: false,
            value: 0.0,
            scale,
            limit_length: None,
            value_length: None,
            reading: None,
            pass: false,
            decisive: true,
            element: ElementKind::Face,
            ids: Vec::new(),
            values: Vec::new(),
            of_face: Vec::new(),
            faces: Vec::new(),
            place: None,
            advice: None,
        }
    }

    #[test]
    fn a_limit_in_millimetres_is_told_in_millimetres_with_the_place() {
        let check = Check {
            limit: 0.001,
            value: 0.003_123,
            reading: Some(Reading {
                unit: "mm".to_owned(),
                limit: 20.0,
                value: 62.456_789,
                across: None,
            }),
            place: Some([1.0, -2.000_04, 3.123_456_789]),
            ids: vec![7],
            ..failed("deviation", Scale::Diagonals)
        };
        assert_eq!(
            said(&check),
            "deviation: 62.46 mm, limit 20 mm, worst at (1, -2.00004, 3.12346); faces 7"
        );
    }

    #[test]
    fn long_lists_of_offenders_are_cut() {
        let check = Check {
            value: 12.0,
            ids: (0..12).collect(),
            ..failed("faces_not_simple", Scale::Count)
        };
        assert_eq!(
            said(&check),
            "faces_not_simple: 12, limit 0; faces 0 1 2 3 4 5 6 7 8 9 and 2 more"
        );
    }
}
