//! The ways that a job has tried, to choose from by looking.

use crate::portfolio::{state, way};
use crate::run::JobResult;
use phex::pipeline::AttemptSummary;
use phex::quality::Merit;
use phex_mesh::{HexMesh, MeshMeasures};

/// A mesh to choose from, and what is told of it.
pub struct WayShown<'a> {
    /// The panels, model units.
    pub mesh: &'a HexMesh,
    /// How they were made.
    pub title: String,
    /// Verdict, figures, and why it was not chosen.
    pub lines: Vec<String>,
}

/// The result of a job and all ways that were tried for it, side by side; and a sentence on how
/// many these were.
pub fn ways(made: &JobResult) -> (String, Vec<WayShown<'_>>) {
    let several = made.tried.len() > 1;
    let mut shown = vec![result(made)];
    for (part, tried) in made.tried.iter().enumerate() {
        let kept = tried.iter().find(|summary| summary.kept);
        shown.extend(tried.iter().map(|summary| {
            let place = if several {
                format!("part {}: ", part + 1)
            } else {
                String::new()
            };
            WayShown {
                mesh: &summary.mesh,
                title: place + &way(summary),
                lines: attempt(summary, kept),
            }
        }));
    }
    (heading(made), shown)
}

fn heading(made: &JobResult) -> String {
    let most = made.tried.iter().map(Vec::len).max().unwrap_or(0);
    match most {
        0 => "This method knows one way alone: there was nothing to choose from.".to_owned(),
        1 => "One way was tried, and there was nothing to choose from: with --effort best all ways of the portfolio are."
            .to_owned(),
        n => format!(
            "{n} ways were tried and compared before any search. The first picture is the result: the way that was kept, searched."
        ),
    }
}

fn result(made: &JobResult) -> WayShown<'_> {
    let MeshMeasures {
        faces,
        hex,
        clearance,
        angle,
        evenness,
        ..
    } = &made.report.assessment.measures;
    let deviation = made.report.assessment.judged_deviation();
    let figures = WayFigures {
        panels: *faces,
        hex: hex.unwrap_or(1.0),
        clearance: clearance.min,
        angle: angle.min,
        distance_rel: deviation.map(|d| d.deviation_max.max(d.coverage_max)),
        area_spread: evenness.as_ref().map(|e| e.area_spread),
    };
    WayShown {
        mesh: &made.mesh,
        title: "Result".to_owned(),
        lines: std::iter::once(made.report.assessment.verdict.to_string())
            .chain(figures.lines())
            .collect(),
    }
}

fn attempt(summary: &AttemptSummary, kept: Option<&AttemptSummary>) -> Vec<String> {
    let figures = WayFigures {
        panels: summary.panels,
        hex: summary.hex,
        clearance: summary.clearance,
        angle: summary.least_angle,
        distance_rel: Some(summary.distance_rel),
        area_spread: summary.area_spread,
    };
    let chosen = match kept {
        Some(kept) if !summary.kept => why_not(&summary.merit, &kept.merit),
        _ => "kept".to_owned(),
    };
    std::iter::once(state(&summary.merit).to_owned())
        .chain(figures.lines())
        .chain([chosen])
        .collect()
}

/// By what a mesh lost against the one that was kept: the first difference that counts.
fn why_not(merit: &Merit, kept: &Merit) -> String {
    let parts = [
        ("more of it is not valid", merit.invalid, kept.invalid),
        ("more of it is outside limits", merit.outside, kept.outside),
        ("less regular, roomy or even", merit.cost, kept.cost),
    ];
    let worse = parts.into_iter().find(|(_, own, best)| own > best);
    match worse {
        Some((what, own, best)) => format!("not chosen: {what}, {own:.3} against {best:.3}"),
        None => "not chosen: no better by more than chance".to_owned(),
    }
}

/// The figures by which people choose.
struct WayFigures {
    panels: usize,
    hex: f64,
    clearance: f64,
    angle: f64,
    distance_rel: Option<f64>,
    area_spread: Option<f64>,
}

impl WayFigures {
    fn lines(&self) -> Vec<String> {
        let percent = |share: f64| format!("{:.2} %", 100.0 * share);
        let deviation = self
            .distance_rel
            .map_or_else(|| "not known".to_owned(), percent);
        let spread = self.area_spread.map(|s| format!("areas p95/p5 {s:.2}"));
        vec![
            format!(
                "{} panels, {:.1} % hexagons inside",
                self.panels,
                100.0 * self.hex
            ),
            format!(
                "clearance {:.3}, least angle {:.1} degrees",
                self.clearance, self.angle
            ),
            format!(
                "deviation {deviation}{}",
                spread.map_or_else(String::new, |s| format!(", {s}"))
            ),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_difference_tells_why() {
        let kept = Merit::default();
        let told = |merit: Merit| why_not(&merit, &kept);
        let worse = Merit {
            invalid: 1.0,
            cost: 3.0,
            ..kept
        };
        assert!(told(worse).contains("not valid, 1.000 against 0.000"));
        let outside = Merit {
            outside: 0.5,
            ..kept
        };
        assert!(told(outside).contains("outside limits"));
        assert!(told(Merit { cost: 0.1, ..kept }).contains("even, 0.100"));
        assert!(told(kept).contains("chance"));
    }
}
