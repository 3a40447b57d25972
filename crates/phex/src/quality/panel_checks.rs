//! The checks of a mesh against what a workshop can make.

use super::check::{Check, ElementKind, Scale};
use crate::layout::MAX_PANELS;
use phex_mesh::{HexMesh, LimitedFigure, PanelLimit, PanelLimits};

/// One check for each limit that is set.
pub(super) fn panel_checks(mesh: &HexMesh, limits: &PanelLimits) -> Vec<Check> {
    let figures = limits.figures(mesh);
    let of = |(kind, limit): (PanelLimit, f64)| {
        let mut figures: Vec<&LimitedFigure> = figures.iter().filter(|f| f.kind == kind).collect();
        // The worst first; of equal ones that with the least number.
        figures.sort_by(|a, b| badness(b).total_cmp(&badness(a)));
        panel_check(mesh, (kind, limit), &figures)
    };
    limits.set().map(of).collect()
}

/// How near a figure is to its limit; above 1 beyond it.
fn badness(figure: &LimitedFigure) -> f64 {
    match figure.kind.is_least() {
        true => figure.limit / figure.value,
        false => figure.value / figure.limit,
    }
}

fn panel_check(
    mesh: &HexMesh,
    (kind, limit): (PanelLimit, f64),
    figures: &[&LimitedFigure],
) -> Check {
    let outside: Vec<&&LimitedFigure> = figures.iter().filter(|f| f.excess() > 0.0).collect();
    let worst = figures.first();
    let value = worst.map_or(limit, |f| f.value);
    let (scale, length) = scale_of(kind);
    let check = Check::new(kind.name(), [limit, value], scale, outside.is_empty());
    let check = match length {
        true => check.in_lengths(1.0),
        false => check,
    };
    let faces = outside.iter().flat_map(|f| f.faces).flatten();
    let check = check.at(faces, worst.map(|f| f.place));
    let mut named: Vec<(usize, f64)> = outside.iter().map(|f| (f.element, f.value)).collect();
    named.sort_by_key(|(element, _)| *element);
    let (ids, values) = named.into_iter().unzip();
    let panels = mesh.topology().n_faces();
    let mut of_face = vec![f64::NAN; panels];
    for figure in figures {
        for f in figure.faces.into_iter().flatten() {
            of_face[f.index()] = of_face[f.index()].max(badness(figure));
        }
    }
    Check {
        is_least: kind.is_least(),
        element: match kind.is_of_edges() {
            true => ElementKind::Edge,
            false => ElementKind::Face,
        },
        ids,
        values,
        of_face,
        ..check
    }
    .advised(&advice(
        kind,
        worst.map_or([limit; 2], |f| [f.limit, f.value]),
        panels,
    ))
}

/// What figures are given in, and whether they are lengths.
fn scale_of(kind: PanelLimit) -> (Scale, bool) {
    match kind {
        PanelLimit::MaxPanel | PanelLimit::MaxAspect => (Scale::Ratio, false),
        PanelLimit::MinEdge | PanelLimit::MaxEdge => (Scale::Length, true),
        PanelLimit::MinAngle | PanelLimit::MinDihedral | PanelLimit::MaxDihedral => {
            (Scale::Degrees, false)
        }
        PanelLimit::MaxArea => (Scale::SquareLength, false),
    }
}

/// What would help where a figure is beyond its limit.
fn advice(kind: PanelLimit, [limit, value]: [f64; 2], panels: usize) -> String {
    let factor = match kind {
        // Joints turn by panel length times curvature.
        PanelLimit::MinDihedral => (180.0 - value) / (180.0 - limit).max(1.0),
        _ if kind.is_least() => limit / value,
        _ => value / limit,
    };
    let shrunk = |power: i32| match (panels as f64 * factor.powi(power)).ceil() {
        enough if enough > MAX_PANELS as f64 => {
            format!(
                "a wider limit: {MAX_PANELS} panels, the most that are made, would not be enough"
            )
        }
        enough => format!("about {enough} panels would do, perhaps fewer, if all shrink alike"),
    };
    match kind {
        PanelLimit::MaxPanel | PanelLimit::MaxEdge | PanelLimit::MinDihedral => shrunk(2),
        PanelLimit::MaxArea => shrunk(1),
        PanelLimit::MaxDihedral => {
            "fewer panels: joints turn by panel length times curvature; where the surface is flat none do".to_owned()
        }
        PanelLimit::MinEdge => format!(
            "about {} panels, if all grow alike; at the boundary another --boundary",
            (panels as f64 / (factor * factor)).floor().max(1.0)
        ),
        PanelLimit::MinAngle | PanelLimit::MaxAspect => {
            "another --rotate, --boundary or number of panels; where the surface bends one way only panels are long".to_owned()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_panels_that_help_are_no_upper_limit() {
        let told = advice(PanelLimit::MaxEdge, [1.0, 2.0], 100);
        assert_eq!(
            told,
            "about 400 panels would do, perhaps fewer, if all shrink alike"
        );
    }
}
