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
    let outside = figures.iter().copied().filter(|f| f.excess() > 0.0);
    let outside: Vec<&LimitedFigure> = outside.collect();
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
        advice: advice(&outside, panels),
        ..check
    }
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

/// What would help where figures of a kind are beyond their limit, the worst first.
fn advice(outside: &[&LimitedFigure], panels: usize) -> Option<String> {
    let kind = outside.first()?.kind;
    let factor = |f: &LimitedFigure| match kind {
        // Joints turn by panel length times curvature.
        PanelLimit::MinDihedral => (180.0 - f.value) / (180.0 - f.limit).max(1.0),
        _ => badness(f),
    };
    // Numbers of panels by the mean of the factors and by the worst, if all sizes change alike.
    let counts = |power: i32| {
        let all: Vec<f64> = (outside.iter())
            .map(|f| panels as f64 * factor(f).powi(power))
            .collect();
        [all.iter().sum::<f64>() / all.len() as f64, all[0]]
    };
    let shrunk = |power: i32| match counts(power).map(f64::ceil) {
        [enough, _] if enough > MAX_PANELS as f64 => {
            format!(
                "a wider limit: {MAX_PANELS} panels, the most that are made, would not be enough"
            )
        }
        counts => format!("about {}, if all shrink alike", by_mean_and_worst(counts)),
    };
    Some(match kind {
        PanelLimit::MaxPanel | PanelLimit::MaxEdge | PanelLimit::MinDihedral => shrunk(2),
        PanelLimit::MaxArea => shrunk(1),
        PanelLimit::MaxDihedral => {
            "fewer panels: joints turn by panel length times curvature; where the surface is flat none do".to_owned()
        }
        PanelLimit::MinEdge => format!(
            "about {}, if all grow alike; at the boundary another --boundary",
            by_mean_and_worst(counts(-2).map(|n| n.floor().max(1.0)))
        ),
        PanelLimit::MinAngle | PanelLimit::MaxAspect => {
            "another --rotate, --boundary or number of panels; where the surface bends one way only panels are long".to_owned()
        }
    })
}

/// Numbers of panels that would do by the mean of those beyond a limit, and by the worst of them.
fn by_mean_and_worst([mean, worst]: [f64; 2]) -> String {
    if mean == worst {
        return format!("{mean} panels");
    }
    format!("{mean} panels by the mean of those beyond it, {worst} by the worst")
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn the_panels_that_help_are_between_those_of_the_mean_and_of_the_worst() {
        let figure = |value: f64| LimitedFigure {
            kind: PanelLimit::MaxEdge,
            limit: 1.0,
            value,
            element: 0,
            faces: [None; 2],
            place: Vec3::zeros(),
        };
        let told = |values: &[f64]| {
            let figures: Vec<LimitedFigure> = values.iter().copied().map(figure).collect();
            let of: Vec<&LimitedFigure> = figures.iter().collect();
            advice(&of, 100)
        };
        assert_eq!(told(&[]), None);
        assert_eq!(
            told(&[2.0]).unwrap(),
            "about 400 panels, if all shrink alike"
        );
        assert_eq!(
            told(&[3.0, 1.0]).unwrap(),
            "about 500 panels by the mean of those beyond it, 900 by the worst, if all shrink alike"
        );
    }
}
