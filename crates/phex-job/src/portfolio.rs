//! What the portfolio tried, in words.

use phex::pipeline::{AttemptSummary, Method};

/// A sentence on each member of a portfolio of which more than one was tried.
pub fn members(tried: &[AttemptSummary]) -> Vec<String> {
    let several = tried.iter().filter(|_| tried.len() > 1);
    several
        .map(|summary| format!("tried: {}", member(summary)))
        .collect()
}

fn member(summary: &AttemptSummary) -> String {
    let candidate = &summary.candidate;
    let way = match (candidate.method, candidate.seamless) {
        (Method::BrickWall, _) => "brick wall".to_owned(),
        (_, true) => format!("seamless lattice, anisotropy {}", candidate.anisotropy),
        (_, false) => format!("lattice, anisotropy {}", candidate.anisotropy),
    };
    let state = match &summary.merit {
        merit if merit.invalid > 0.0 => "not valid",
        merit if merit.outside > 0.0 => "outside limits",
        _ => "valid",
    };
    format!(
        "{way}: {state}, {} of {} panels irregular without need, clearance {:.3}, angle {:.1}{}",
        summary.irregular,
        summary.panels,
        summary.clearance,
        summary.least_angle,
        if summary.kept { " (kept)" } else { "" }
    )
}
