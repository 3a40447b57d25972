//! The checks of a mesh against what a workshop can make.

use super::check::{Check, ElementKind, SPARE, Scale};
use crate::layout::MAX_PANELS;
use phex_mesh::{HexMesh, LimitedFigure, PanelLimit, PanelLimits};

/// One check for each limit that is set; `asked` is the number of panels that was asked for.
pub(super) fn panel_checks(mesh: &HexMesh, limits: &PanelLimits, asked: usize) -> Vec<Check> {
    let figures = limits.figures(mesh);
    let of = |(kind, limit): (PanelLimit, f64)| {
        let mut figures: Vec<&LimitedFigure> = figures.iter().filter(|f| f.kind == kind).collect();
        // The worst first; of equal ones that with the least number.
        figures.sort_by(|a, b| badness(b).total_cmp(&badness(a)));
        panel_check((mesh, asked), (kind, limit), &figures)
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
    (mesh, asked): (&HexMesh, usize),
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
    let mut of_face = vec![f64::NAN; mesh.topology().n_faces()];
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
        advice: advice(&outside, asked),
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

/// What would help where figures of a kind are beyond their limit, the worst first; `asked` is the
/// number of panels that is changed.
fn advice(outside: &[&LimitedFigure], asked: usize) -> Option<String> {
    let kind = outside.first()?.kind;
    let factor = |f: &LimitedFigure| match kind {
        // Joints turn by panel length times curvature.
        PanelLimit::MinDihedral => (180.0 - f.value) / (180.0 - f.limit).max(1.0),
        _ => badness(f),
    };
    // Numbers of panels by the mean of the factors and by the worst, if all sizes change alike.
    let counts = |power: i32| {
        let spare = (1.0 + SPARE).powi(power.signum());
        let all: Vec<f64> = (outside.iter())
            .map(|f| asked as f64 * factor(f).powi(power) * spare)
            .collect();
        [all.iter().sum::<f64>() / all.len() as f64, all[0]]
    };
    let shrunk = |power: i32| match counts(power).map(f64::ceil) {
        [enough, _] if enough > MAX_PANELS as f64 => {
            format!(
                "a wider limit: {MAX_PANELS} panels, the most that are made, would not be enough"
            )
        }
        counts => format!("{}, if all shrink alike", instead(counts, asked)),
    };
    Some(match kind {
        PanelLimit::MaxPanel | PanelLimit::MaxEdge | PanelLimit::MinDihedral => shrunk(2),
        PanelLimit::MaxArea => shrunk(1),
        PanelLimit::MaxDihedral => {
            "fewer panels: joints turn by panel length times curvature; where the surface is flat none do".to_owned()
        }
        PanelLimit::MinEdge => match counts(-2).map(f64::floor) {
            [most, _] if most < FEWEST => {
                "a shorter limit: not even a single panel would have edges as long".to_owned()
            }
            counts => format!(
                "{}, if all grow alike; at the boundary another --boundary",
                instead(counts, asked)
            ),
        },
        PanelLimit::MinAngle | PanelLimit::MaxAspect => {
            "another --rotate, --boundary or number of panels; where the surface bends one way only panels are long".to_owned()
        }
    })
}

/// Numbers of panels below which there is none beside another.
const FEWEST: f64 = 2.0;

/// Numbers of panels that would do by the mean of those beyond a limit, and by the worst of them,
/// in place of those that were asked for.
fn instead([mean, worst]: [f64; 2], asked: usize) -> String {
    let by_worst = match worst {
        worst if worst == mean => String::new(),
        worst if worst < FEWEST => " by the mean of those beyond it, none by the worst".to_owned(),
        _ => format!(" by the mean of those beyond it, {worst} by the worst"),
    };
    format!("about {mean} panels{by_worst} instead of {asked}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn the_panels_that_help_are_between_those_of_the_mean_and_of_the_worst() {
        let figure = |kind: PanelLimit, value: f64| LimitedFigure {
            kind,
            limit: 1.0,
            value,
            element: 0,
            faces: [None; 2],
            place: Vec3::zeros(),
        };
        let told = |kind: PanelLimit, values: &[f64]| {
            let figures: Vec<LimitedFigure> = values.iter().map(|v| figure(kind, *v)).collect();
            let of: Vec<&LimitedFigure> = figures.iter().collect();
            advice(&of, 100)
        };
        let longest = |values: &[f64]| told(PanelLimit::MaxEdge, values);
        assert_eq!(longest(&[]), None);
        assert_eq!(
            longest(&[2.0]).unwrap(),
            "about 441 panels instead of 100, if all shrink alike"
        );
        assert_eq!(
            longest(&[3.0, 1.0]).unwrap(),
            "about 551 panels by the mean of those beyond it, 991 by the worst instead of 100, if all shrink alike"
        );
        let shortest = |values: &[f64]| told(PanelLimit::MinEdge, values).unwrap();
        assert!(shortest(&[0.5]).starts_with("about 22 panels instead of 100, if all grow alike"));
        assert!(shortest(&[0.1, 0.5]).contains("beyond it, none by the worst instead of 100"));
        assert!(shortest(&[0.01]).starts_with("a shorter limit"));
    }
}
