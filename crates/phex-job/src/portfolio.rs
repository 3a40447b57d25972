//! What the portfolio tried, in words.

use phex::pipeline::{AttemptSummary, Method};
use phex::quality::Merit;

/// A sentence on each member of a portfolio of which more than one was tried, as they were when
/// they were compared: the search may have cured the one that was kept.
pub fn members(tried: &[AttemptSummary]) -> Vec<String> {
    let several = tried.iter().filter(|_| tried.len() > 1);
    several
        .map(|summary| format!("tried: {}", member(summary)))
        .collect()
}

/// How the panels of a member were laid out.
pub(crate) fn way(summary: &AttemptSummary) -> String {
    let candidate = &summary.candidate;
    let kind = match candidate {
        c if c.method == Method::BrickWall => return "brick wall".to_owned(),
        c if c.seamless && c.resolving => "seamless lattice with sizes that resolve the surface",
        c if c.seamless => "seamless lattice",
        c if c.resolving => "lattice with sizes that resolve the surface",
        _ => "lattice",
    };
    let limit = match summary.usual_deviation {
        true => ", for the usual deviation",
        false => "",
    };
    format!("{kind}, anisotropy {}{limit}", candidate.anisotropy)
}

/// What a merit says of a mesh.
pub(crate) fn state(merit: &Merit) -> &'static str {
    match merit {
        merit if merit.invalid > 0.0 => "not valid",
        merit if merit.outside > 0.0 => "outside limits",
        _ => "valid",
    }
}

fn member(summary: &AttemptSummary) -> String {
    let spread = summary.area_spread;
    let spread = spread.map(|s| format!("areas p95/p5 {s:.2}, "));
    format!(
        "{}: before the search {}, {} of {} panels irregular without need, {}clearance {:.3}, angle {:.1}{}",
        way(summary),
        state(&summary.merit),
        summary.irregular,
        summary.panels,
        spread.unwrap_or_default(),
        summary.clearance,
        summary.least_angle,
        if summary.kept { " (kept)" } else { "" }
    )
}
