//! The page: head, view, tables, data, script.

use crate::arrays::in_text;
use crate::bundle::Viewer;
use crate::escape::{escaped, json_in_script};
use crate::pictures::data_address;
use crate::tables::{self, figure};
use crate::viewer_data::{MOST_OFFENDERS, ViewerData, centre, offenders};
use crate::{CurveFamily, Report};
use phex::curvature::Principal;
use phex::quality::Verdict;
use phex_mesh::{FaceId, Vec3};
use phex_picture::maps::{ColourMap, Map, Range, Subject, principal_at_panels};

const STYLE: &str = include_str!("report.css");
/// The style of the interactive view's parts; colours are variables, which the page sets.
pub const VIEW_STYLE: &str = include_str!("view.css");
/// What the page may load: its own scripts, styles and pictures, and nothing from anywhere else.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:";

/// The report as one HTML file; without a viewer it has pictures and tables, and says so.
///
/// # Errors
/// If the viewer's data can't be written as JSON.
pub fn page(report: &Report<'_>, viewer: Option<Viewer>) -> serde_json::Result<String> {
    let maps = maps(report);
    let mut html = String::new();
    html.push_str(&head(&escaped(report.title), "report"));
    html.push_str("<body>\n");
    html.push_str(&header(report));
    let stage = if viewer.is_some() {
        "<div id=\"phex-viewer\"></div>\n"
    } else {
        ""
    };
    html.push_str(stage);
    html.push_str("<main>\n");
    html.push_str(&pictures(report, &maps, viewer.is_some()));
    html.push_str(&sections(report));
    html.push_str("</main>\n");
    if let Some(viewer) = viewer {
        let json = in_text(&view(report, &maps, centre(report.mesh)))?;
        html.push_str(&format!(
            "<script type=\"application/json\" id=\"phex-data\">{}</script>\n<script>{}</script>\n",
            json_in_script(&String::from_utf8_lossy(&json)),
            viewer.inline_script()
        ));
    }
    html.push_str("</body>\n</html>\n");
    Ok(html)
}

/// The data of the interactive view of a report, with coordinates relative to `origin`.
pub fn viewer_data<'a>(report: &Report<'a>, origin: Vec3) -> ViewerData<'a> {
    view(report, &maps(report), origin)
}

fn view<'a>(report: &Report<'a>, maps: &[ColourMap], origin: Vec3) -> ViewerData<'a> {
    let data = ViewerData::new(report, maps, origin);
    match crosses(report) {
        Some(families) => data.with_curves(&families, origin),
        None => data,
    }
}

/// Half the length of a cross over the square root of its panel's area.
const CROSS: f64 = 0.36;

/// Where no curves are given, the principal directions, which are conjugate, as a cross on each
/// panel.
fn crosses(report: &Report<'_>) -> Option<[CurveFamily; 2]> {
    if report.curves.is_ok_and(|curves| !curves.is_empty()) {
        return None;
    }
    let principal = principal_at_panels(&subject(report))?;
    let family = |name: &str, direction: fn(&Principal) -> Vec3| {
        let faces = report.mesh.topology().faces().zip(&principal);
        let line = |(f, p): (FaceId, &Principal)| {
            let reach = CROSS * report.run.assessment.measures.per_element.area[f].sqrt();
            let (centre, along) = (report.mesh.centre(f), direction(p) * reach);
            vec![centre - along, centre + along]
        };
        CurveFamily {
            name: name.to_owned(),
            curves: faces.map(line).collect(),
        }
    };
    Some([
        family("Principal directions (conjugate): least", |p| {
            p.small_direction
        }),
        family("largest curvature", |p| p.large_direction),
    ])
}

fn subject<'a>(report: &Report<'a>) -> Subject<'a> {
    Subject {
        mesh: report.mesh,
        assessment: &report.run.assessment,
        surface: report.surface,
    }
}

fn maps(report: &Report<'_>) -> Vec<ColourMap> {
    let subject = subject(report);
    (Map::ALL.into_iter())
        .chain(Map::LIMITS)
        .filter_map(|map| ColourMap::over(map, &subject, range(map)))
        .collect()
}

/// Planarity has the same range in every report: panels before and after an optimisation are
/// compared in it, and what is planar is to look so.
fn range(map: Map) -> Range {
    match map {
        Map::Planarity => Range::Fixed,
        _ => Range::Automatic,
    }
}

/// The head of a page with an escaped title and a word on what it is.
pub(crate) fn head(title: &str, what: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <link rel=\"icon\" href=\"data:,\">\n<title>{title} – phex {what}</title>\n<style>\n{VIEW_STYLE}{STYLE}</style>\n</head>\n"
    )
}

fn header(report: &Report<'_>) -> String {
    let (class, word) = match report.run.assessment.verdict {
        Verdict::Pass => ("pass", "Pass"),
        Verdict::OutsideTolerance => ("outside", "Outside tolerance"),
        Verdict::Invalid => ("invalid", "Invalid"),
    };
    let facts: String = facts(report)
        .into_iter()
        .map(|(name, value)| format!("<div><dt>{name}</dt><dd>{value}</dd></div>"))
        .collect();
    format!(
        "<header>\n<div class=\"title\"><span class=\"brand\">phex</span><h1>{}</h1>\
         <span class=\"verdict {class}\">{word}</span></div>\n<dl class=\"facts\">{facts}</dl>\n</header>\n",
        escaped(report.title)
    )
}

/// The figures that are looked for first.
fn facts(report: &Report<'_>) -> Vec<(&'static str, String)> {
    let run = report.run;
    let m = &run.assessment.measures;
    let unit = escaped(&run.unit);
    let mut facts = vec![
        ("Panels", m.faces.to_string()),
        (
            "Hexagons inside",
            m.hex
                .map_or("–".to_owned(), |h| format!("{:.1} %", 100.0 * h)),
        ),
        ("Concave", m.faces_concave.to_string()),
        (
            "Planarity",
            format!("{} {unit}", figure(m.planarity_length.max)),
        ),
        ("Mean edge", format!("{} {unit}", figure(m.mean_edge))),
    ];
    if let Some(d) = run.assessment.judged_deviation() {
        let length = d.deviation_max * d.diagonal;
        let percent = 100.0 * d.deviation_max;
        facts.push((
            "Deviation",
            format!("{} {unit} <small>{percent:.3} %</small>", figure(length)),
        ));
    }
    let held = run.assessment.checks.iter().filter(|c| c.pass).count();
    facts.push((
        "Checks",
        format!("{held} of {}", run.assessment.checks.len()),
    ));
    facts
}

fn pictures(report: &Report<'_>, maps: &[ColourMap], interactive: bool) -> String {
    let figures: String = maps
        .iter()
        .map(|map| (map.map, data_address(report.mesh, map)))
        .map(|(map, address)| {
            let title = map.title();
            format!("<figure><img alt=\"{title} of the panels\" src=\"{address}\"><figcaption>{title}</figcaption></figure>\n")
        })
        .collect();
    let (open, said) = if interactive {
        (
            "",
            "<p class=\"note needs-3d\">This browser can’t draw in three dimensions here, so the pictures below stand for the interactive view.</p>\n\
             <noscript><p class=\"note\">The interactive view needs scripts; the pictures below stand for it.</p></noscript>\n",
        )
    } else {
        (
            " open",
            "<p class=\"note\">This report has pictures instead of the interactive view: the program was built without npm, which makes that view.</p>\n",
        )
    };
    format!(
        "{said}<details id=\"pictures\"{open}><summary>Pictures</summary>\n<div class=\"gallery\">\n{figures}</div></details>\n"
    )
}

fn sections(report: &Report<'_>) -> String {
    format!(
        "<section><h2>Checks</h2>\n{}</section>\n{}{}<section><h2>Figures</h2>\n{}</section>\n\
         <section><h2>Repeat</h2>\n<pre class=\"command\"><code>{}</code></pre>\n{}</section>\n\
         <details><summary>All settings</summary>\n{}</details>\n",
        tables::checks(report),
        offender_list(report),
        tables::repetition(report),
        tables::figures(report),
        escaped(report.command),
        tables::run(report),
        tables::settings(&report.run.settings),
    )
}

/// The offenders as text, for readers without the interactive view.
fn offender_list(report: &Report<'_>) -> String {
    let list = offenders(report);
    if list.is_empty() {
        return String::new();
    }
    let items: String = list
        .iter()
        .map(|o| {
            let class = if o.loud { "loud" } else { "warn" };
            let name = report.panel(o.faces[0]);
            format!(
                "<li class=\"{class}\">Panel {}: {}</li>\n",
                escaped(&name),
                escaped(&o.text)
            )
        })
        .collect();
    let more = if list.len() == MOST_OFFENDERS {
        "<p class=\"note\">The first ones; the JSON report lists all.</p>\n"
    } else {
        ""
    };
    format!(
        "<details class=\"offender-list\"><summary>Offenders ({})</summary>\n<ol>\n{items}</ol>\n{more}</details>\n",
        list.len()
    )
}
