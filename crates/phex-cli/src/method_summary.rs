//! What the portfolio tried, and what the methods by planes and poles met with, as lines of the
//! table.

use crate::summary::SummaryTable;
use phex::classical::CurvatureSign;
use phex::classical::DualDefects;
use phex::pipeline::{AttemptSummary, ClassicalStatistics};
use phex_job::members;

/// The lines of a portfolio.
pub fn of_portfolio(tried: &[AttemptSummary]) -> String {
    let mut table = SummaryTable::default();
    let lines = members(tried);
    lines.iter().for_each(|line| table.row("portfolio", line));
    if !lines.is_empty() {
        table.row("", "(`phex help terms` says what the words mean)");
    }
    table.into_text()
}

/// The lines of a run; none for other methods.
pub fn of_method(classical: Option<&ClassicalStatistics>) -> String {
    let mut table = SummaryTable::default();
    let Some(told) = classical else {
        return table.into_text();
    };
    if let Some(sentence) = &told.outside_domain {
        table.row("domain", format!("outside: {sentence}"));
    }
    if let Some((m, n)) = told.goldberg {
        table.row("goldberg", format!("class ({m}, {n})"));
    }
    if let Some([x, y, z]) = told.centre {
        table.row("centre", format!("({x:.4}, {y:.4}, {z:.4})"));
    }
    if let Some(defects) = &told.defects {
        table.row("dual", dual(defects));
    }
    if let Some(flips) = told.flips {
        let why = match told.curvature {
            CurvatureSign::Elliptic => "to make the dual convex",
            _ => "by the sign rule",
        };
        let taken_out = match told.taken_out {
            0 => String::new(),
            n => format!(", {n} panels taken out whose planes cut nothing off"),
        };
        table.row("flips", format!("{flips} edges flipped {why}{taken_out}"));
    }
    if let Some(panels) = told.forecast {
        let doubt = told.in_doubt.unwrap_or(0);
        table.row("forecast", forecast(panels, doubt, told));
    }
    if let Some(edges) = told.reversed_edges {
        let image = match edges {
            0 => "edges run as those of the Koebe mesh do".to_owned(),
            n => format!("{n} edges run against those of the Koebe mesh"),
        };
        table.row("signs", image);
    }
    if let Some([mean, rms]) = told.mean_curvature_rel {
        let told = format!("mean {mean:.4}, rms {rms:.1e}, times the diagonal (a sphere: 3.46)");
        table.row("curvature", told);
    }
    if let Some(edges) = told.edges_at_bound.filter(|n| *n > 0) {
        table.row("bound", format!("{edges} edges as short as is allowed"));
    }
    table.into_text()
}

/// What the sign rule foresaw, and what became of it.
fn forecast(panels: usize, doubt: usize, told: &ClassicalStatistics) -> String {
    let became = match (told.forecast_taken_out, told.forecast_came_true) {
        (Some(taken_out), Some(crossed)) if panels > 0 => {
            format!(
                "; {taken_out} of the {panels} were taken out, {crossed} of them are in the mesh and do cross themselves"
            )
        }
        _ => String::new(),
    };
    format!(
        "{panels} panels cross themselves by the sign rule, {doubt} more may (third order), the rim apart{became}"
    )
}

/// Singular and duplicated points of the dual surface.
fn dual(defects: &DualDefects) -> String {
    if *defects == DualDefects::default() {
        return "no singular or duplicated points".to_owned();
    }
    format!(
        "cusps across {} edges of the surface, {} pairs of points with one tangent plane, {} edges through infinity",
        defects.singular_edges, defects.duplicate_pairs, defects.edges_through_infinity
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defects_are_counted_or_denied() {
        let some = DualDefects {
            singular_edges: 3,
            ..DualDefects::default()
        };
        assert!(dual(&some).starts_with("cusps across 3 edges"));
        assert!(dual(&DualDefects::default()).starts_with("no singular"));
        assert_eq!(of_method(None), "");
    }
}
