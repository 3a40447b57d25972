//! The tables of the page.

use crate::Report;
use crate::escape::escaped;
use phex::quality::{Check, ElementKind, contradiction, told_place};
use phex_mesh::measure::Metric;
use serde_json::Value;

/// Most offenders that a line of the checks names.
const NAMED: usize = 12;

/// A number with few digits.
pub fn figure(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if !value.is_finite() {
        "–".to_owned()
    } else if !(1e-3..1e6).contains(&size) {
        format!("{value:.1e}").replace("e-", "e−")
    } else {
        let digits = (3 - size.log10().floor() as i64).clamp(0, 6) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    }
}

/// A table of rows of cells that are HTML already; the first row is the head.
pub fn table(class: &str, rows: &[Vec<String>]) -> String {
    let row = |tag: &str, cells: &Vec<String>| {
        let cells: String = cells
            .iter()
            .map(|c| format!("<{tag}>{c}</{tag}>"))
            .collect();
        format!("<tr>{cells}</tr>\n")
    };
    let head = rows
        .first()
        .map(|cells| row("th", cells))
        .unwrap_or_default();
    let body: String = rows.iter().skip(1).map(|cells| row("td", cells)).collect();
    format!(
        "<div class=\"scroll\"><table class=\"{class}\"><thead>{head}</thead><tbody>{body}</tbody></table></div>\n"
    )
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|n| (*n).to_owned()).collect()
}

/// What a check is called, and what it means.
const CHECKS: [(&str, &str, &str); 24] = [
    (
        "planarity",
        "Planarity",
        "largest distance of a corner to its panel’s plane",
    ),
    (
        "clearance",
        "Clearance",
        "least distance of a corner to an edge of its panel",
    ),
    ("edge_length", "Collapsed edges", "shortest edge"),
    (
        "finite",
        "Finite coordinates",
        "vertices with a coordinate that is no number",
    ),
    (
        "faces_not_simple",
        "Simple panels",
        "panels that cross or touch themselves",
    ),
    (
        "folded_corners",
        "Folded corners",
        "panels that fold back at a corner",
    ),
    (
        "flipped_faces",
        "Flipped panels",
        "panels whose normal points the wrong way",
    ),
    (
        "wrong_fans",
        "Fans",
        "vertices that panels do not go round exactly once",
    ),
    (
        "wrong_degree",
        "Three panels at a vertex",
        "inner vertices with another number",
    ),
    ("crossings", "Crossings", "edges that pass through a panel"),
    (
        "folds",
        "Folds",
        "edges where the mesh turns by more than 90°",
    ),
    (
        "same_topology",
        "Topology",
        "that of the surface (0) or not (1)",
    ),
    ("deviation", "Deviation", "largest distance to the surface"),
    (
        "coverage_inner",
        "Coverage",
        "largest distance of the surface to the panels",
    ),
    (
        "boundary",
        "Boundary",
        "largest distance between the boundaries of panels and surface",
    ),
    (
        "covered_area",
        "Covered area",
        "share of the surface’s area under panels",
    ),
    (
        "max_panel",
        "Sheet",
        "least sheet of the limit’s proportions that holds every panel",
    ),
    ("min_edge", "Shortest edge", "of all panels"),
    ("max_edge", "Longest edge", "of all panels"),
    ("min_angle", "Least angle", "sharpest corner of a panel"),
    ("max_area", "Largest area", "largest panel"),
    (
        "max_aspect",
        "Aspect",
        "largest length over width of a panel",
    ),
    (
        "min_dihedral",
        "Sharpest joint",
        "least angle between neighbouring panels; 180 is flat",
    ),
    (
        "max_dihedral",
        "Flattest joint",
        "largest angle between neighbouring panels",
    ),
];

/// What a check is called.
pub fn title(name: &'static str) -> &'static str {
    let known = CHECKS.iter().find(|c| c.0 == name);
    known.map_or(name, |c| c.1)
}

/// How many parts are alike, before edges were made equal and now; nothing where that was not
/// asked for.
pub fn repetition(report: &Report<'_>) -> String {
    let Some(told) = &report.run.repetition else {
        return String::new();
    };
    let length = format!("{} {}", figure(told.tolerance), escaped(&report.run.unit));
    let angle = format!("{}°", figure(told.angle_tolerance));
    let (before, after) = (&told.before, &told.after);
    let row = |name: &str, within: &str, counts: [usize; 2]| {
        let [before, after] = counts.map(|n| n.to_string());
        vec![name.to_owned(), within.to_owned(), before, after]
    };
    let rows = [
        head(&["Distinct", "Within", "Before", "After"]),
        row(
            "Edge lengths",
            &length,
            [before.edge_lengths, after.edge_lengths],
        ),
        row(
            "Angles at nodes",
            &angle,
            [before.node_angles, after.node_angles],
        ),
        row("Panels", &length, [before.panels, after.panels]),
        row(
            "Panels that may be turned over",
            &length,
            [before.panels_mirrored, after.panels_mirrored],
        ),
    ];
    format!(
        "<section><h2>Repetition</h2>\n{}</section>\n",
        table("repetition", &rows)
    )
}

/// The checks with figures, limits and offenders.
pub fn checks(report: &Report<'_>) -> String {
    let mut rows = vec![head(&["", "Check", "Value", "Limit", "Offenders"])];
    rows.extend(
        report
            .run
            .assessment
            .checks
            .iter()
            .map(|c| check(report, c)),
    );
    let contradiction = contradiction(&report.run.assessment.checks);
    let contradiction = contradiction.map_or_else(String::new, |told| {
        format!("<p class=\"note\">{}</p>\n", escaped(&told))
    });
    table("checks", &rows) + &contradiction
}

fn check(report: &Report<'_>, check: &Check) -> Vec<String> {
    let known = CHECKS.iter().find(|c| c.0 == check.name);
    let (title, meaning) = known.map_or((check.name, ""), |c| (c.1, c.2));
    let mark = match (check.pass, check.decisive) {
        (true, _) => "<span class=\"mark pass\">pass</span>",
        (false, true) => "<span class=\"mark invalid\">fail</span>",
        (false, false) => "<span class=\"mark outside\">fail</span>",
    };
    let sign = if check.is_least { "≥" } else { "≤" };
    let shown = check.shown();
    let [value, limit] = shown.in_words(figure);
    let unit = escaped(&shown.unit.replace("in model units", &report.run.unit));
    vec![
        mark.to_owned(),
        format!(
            "<b>{}</b> <small>{}</small>{}",
            escaped(title),
            escaped(meaning),
            helps(check)
        ),
        value,
        format!("{sign} {limit} {unit}").trim_end().to_owned(),
        named(report, check),
    ]
}

/// What would help where a check fails.
fn helps(check: &Check) -> String {
    let advice = check.advice.as_ref();
    advice.map_or_else(String::new, |advice| {
        format!(
            "<br><small class=\"helps\">What helps: {}</small>",
            escaped(advice)
        )
    })
}

fn named(report: &Report<'_>, check: &Check) -> String {
    if check.ids.is_empty() {
        return String::new();
    }
    let kind = match check.element {
        ElementKind::Vertex => "vertices",
        ElementKind::Edge => "edges",
        ElementKind::Face => "panels",
        ElementKind::Mesh => "",
    };
    let name = |&id: &usize| match check.element {
        ElementKind::Face => escaped(&report.panel(id)),
        _ => id.to_string(),
    };
    let first = check.ids.iter().take(NAMED).map(name);
    let list = first.collect::<Vec<_>>().join(", ");
    let more = match check.ids.len().saturating_sub(NAMED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    let place = check.place.map(told_place);
    let place = place.map_or_else(String::new, |place| format!(", worst at {place}"));
    format!("{kind} {list}{more}{place}")
}

/// Figures with least, mean, 95 % and largest value.
pub fn figures(report: &Report<'_>) -> String {
    let m = &report.run.assessment.measures;
    let mut rows = vec![head(&["Figure", "Least", "Mean", "95 %", "Largest"])];
    rows.push(metric("Planarity, mean edges", &m.planarity, 1.0));
    let length = format!("Planarity, {}", escaped(&report.run.unit));
    rows.push(metric(&length, &m.planarity_length, 1.0));
    rows.push(metric(
        "Planarity by diagonals, %",
        &m.planarity_diagonals,
        100.0,
    ));
    rows.push(metric("Edge length, mean edges", &m.edge_length, 1.0));
    rows.push(metric("Clearance, mean edges", &m.clearance, 1.0));
    rows.push(metric("Least angle of a panel, °", &m.angle, 1.0));
    rows.push(metric("Dihedral angle, °", &m.dihedral, 1.0));
    rows.push(metric("Panel area, % of all", &m.face_area, 100.0));
    for (name, deviation) in [
        ("smooth surface", &report.run.assessment.deviation_smooth),
        ("given facets", &report.run.assessment.deviation_facets),
    ] {
        if let Some(d) = deviation {
            let label = |what: &str| format!("{what} to the {name}, % of diagonal");
            rows.push(metric(&label("Corners"), &d.vertices, 100.0));
            rows.push(metric(&label("Panel centres"), &d.face_centres, 100.0));
        }
    }
    table("figures", &rows)
}

fn metric<I>(name: &str, metric: &Metric<I>, factor: f64) -> Vec<String> {
    let values = [metric.min, metric.mean, metric.p95, metric.max];
    std::iter::once(name.to_owned())
        .chain(values.map(|v| figure(v * factor)))
        .collect()
}

/// Settings, with nested ones under the names of all that hold them.
pub fn settings(value: &Value) -> String {
    let mut rows = vec![head(&["Setting", "Value"])];
    flatten("", value, &mut rows);
    table("settings", &rows)
}

fn flatten(path: &str, value: &Value, rows: &mut Vec<Vec<String>>) {
    match value {
        Value::Object(map) => {
            for (name, inner) in map {
                let longer = if path.is_empty() {
                    name.clone()
                } else {
                    format!("{path}.{name}")
                };
                flatten(&longer, inner, rows);
            }
        }
        Value::Null => rows.push(vec![escaped(path), "<small>default</small>".to_owned()]),
        Value::String(text) => rows.push(vec![escaped(path), escaped(text)]),
        other => rows.push(vec![escaped(path), escaped(&other.to_string())]),
    }
}

/// Files that were read and written, and times.
pub fn run(report: &Report<'_>) -> String {
    let run = report.run;
    let mut rows = vec![head(&["Run", ""])];
    let mut row = |name: &str, text: String| rows.push(vec![name.to_owned(), text]);
    row(
        "Program",
        escaped(&format!("{} {}", run.tool.name, run.tool.version)),
    );
    for input in &run.inputs {
        let text = format!(
            "{} <small>{} vertices, {} faces, sha256 {}</small>",
            escaped(&input.path),
            input.vertices,
            input.faces,
            escaped(&input.sha256)
        );
        row("Input", text);
    }
    for output in &run.outputs {
        row(
            &format!("Output, {}", output.content.replace('_', " ")),
            escaped(&output.path),
        );
    }
    row("Unit", escaped(&run.unit));
    row("Seed", run.seed.to_string());
    for note in &run.notes {
        row("Note", escaped(note));
    }
    for time in &run.stages {
        row(
            &format!("Time, {}", escaped(&time.stage)),
            format!("{:.2} s", time.seconds),
        );
    }
    table("settings", &rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn figures_are_short() {
        let cases = [
            (0.0, "0"),
            (501.0, "501"),
            (1.0688, "1.069"),
            (0.25, "0.25"),
            (3.4e-15, "3.4e−15"),
            (f64::NAN, "–"),
            (123456.0, "123456"),
        ];
        for (value, text) in cases {
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn settings_are_flat_and_escaped() {
        let html = settings(&json!({ "a": { "b<": 1, "c": null }, "d": "<x>" }));
        assert!(html.contains("<td>a.b&lt;</td><td>1</td>"));
        assert!(html.contains("<td>d</td><td>&lt;x&gt;</td>"));
        assert!(html.contains("<td>a.c</td><td><small>default</small></td>"));
    }
}
