//! What would help where a check of the mesh in itself fails.

use super::check::{Check, SMALLER};
use super::limits::Limits;
use phex_mesh::{HexMesh, TriangleSurface, Vec3, Violation};
use std::cell::LazyCell;
use std::collections::BTreeSet;

/// Turn of the surface between two panels, degrees, from which on a fold is its own: a right angle,
/// less what facets are off.
const OWN_FOLD: f64 = 89.0;

/// Steps from panel to panel in which a fold of the surface is told from a bend.
const STEPS: usize = 8;

/// What would help where panels are left whole at the boundary and run into each other.
const OVERLAPS: &str = "panels that end at the boundary (--boundary snap or clip), where those of two sides of a slit overlap, or smaller ones";

/// What would help where panels are spoilt: they are larger than what the surface does there.
const MORE: &str = "more panels, or smaller ones there (--adaptive)";

/// Checks that fail where panels are too large for the surface.
const SPOILT: [&str; 7] = [
    "clearance",
    "edge_length",
    "faces_not_simple",
    "folded_corners",
    "flipped_faces",
    "wrong_fans",
    "crossings",
];

/// Mean edges within which a crossing of panels is one of the surface: those of panels that meet
/// there.
const OWN_CROSSING: f64 = 2.0;

/// The checks with what would help where they fail, by the surface that they are judged by and its
/// facets. Crossings alone that the facets have, too, do not decide that a mesh is none.
pub(super) fn with_advice(
    checks: Vec<Check>,
    mesh: &HexMesh,
    (judge, facets): (Option<&TriangleSurface>, Option<&TriangleSurface>),
    limits: &Limits,
    violations: &[Violation],
) -> Vec<Check> {
    let folds = judge.and_then(|s| fold_advice(mesh, s, violations));
    let [own, crossings] = count_crossings(mesh, facets.or(judge), violations);
    let passes = (own > 0).then(|| {
        format!(
            "at {own} of {crossings} the surface passes through itself: take away what lies inside, or leave them"
        )
    });
    let more = judge.map(|_| MORE.to_owned());
    let overlaps = limits.leaves_boundary().then(|| OVERLAPS.to_owned());
    let advised = |check: Check| {
        let advice = match check.name {
            "folds" => &folds,
            "crossings" if own > 0 => &passes,
            "crossings" | "faces_not_simple" if overlaps.is_some() => &overlaps,
            name if SPOILT.contains(&name) => &more,
            _ => &None,
        };
        let decisive = check.decisive && (check.name != "crossings" || own < crossings);
        match advice {
            Some(advice) => Check { decisive, ..check }.advised(advice),
            None => check,
        }
    };
    checks.into_iter().map(advised).collect()
}

/// Checks that fewer panels help, and those that more of them help; each with its limit.
const FEWER: [(&str, &str); 2] = [("min_edge", "min-edge"), ("max_dihedral", "max-dihedral")];
const MORE_OF: [(&str, &str); 6] = [
    ("deviation", "max-deviation"),
    ("coverage_inner", "max-deviation"),
    ("max_panel", "max-panel"),
    ("max_edge", "max-edge"),
    ("max_area", "max-area"),
    ("min_dihedral", "min-dihedral"),
];

/// Which limits contradict each other: those that fail and ask for fewer panels, and those that ask
/// for more. `None` where all that fail ask for the same.
pub fn contradiction(checks: &[Check]) -> Option<String> {
    let fails = |name: &str| checks.iter().any(|c| !c.pass && c.name == name);
    let asks = |limits: &[(&str, &'static str)]| {
        let mut failing: Vec<&str> = (limits.iter().filter(|l| fails(l.0)))
            .map(|l| l.1)
            .collect();
        failing.dedup();
        let verb = if failing.len() == 1 { "asks" } else { "ask" };
        let told = format!("{} {verb}", failing.join(" and "));
        (!failing.is_empty()).then_some(told)
    };
    let (fewer, more) = (asks(&FEWER)?, asks(&MORE_OF)?);
    Some(format!(
        "limits contradict each other here: {fewer} for fewer panels, {more} for more; what helps the one harms the other, so one of them has to give"
    ))
}

/// How many edges cross panels where the surface does, too, and how many do in all.
fn count_crossings(
    mesh: &HexMesh,
    facets: Option<&TriangleSurface>,
    violations: &[Violation],
) -> [usize; 2] {
    let (mut all, mut others) = (BTreeSet::new(), BTreeSet::new());
    let is_own = facets.map(|s| crossings_of(s, mesh));
    for violation in violations {
        if let Violation::Crossing { edge, .. } = violation {
            all.insert(*edge);
            if !is_own.as_ref().is_some_and(|is_own| is_own(violation)) {
                others.insert(*edge);
            }
        }
    }
    [all.len() - others.len(), all.len()]
}

/// Tells whether panels cross because the surface passes through itself there: no others would do
/// without it.
pub(super) fn crossings_of<'a>(
    facets: &'a TriangleSurface,
    mesh: &'a HexMesh,
) -> impl Fn(&Violation) -> bool + 'a {
    let reach = LazyCell::new(|| OWN_CROSSING * mesh.mean_edge());
    move |violation| {
        let Violation::Crossing { .. } = violation else {
            return false;
        };
        let place = violation
            .place(mesh)
            .filter(|p| p.iter().all(|x| x.is_finite()));
        place.is_some_and(|place| {
            let mut own = facets.self_crossings().iter();
            own.any(|p| (p - place).norm() < *reach)
        })
    }
}

/// What would help where panels fold; `None` where none do. Most folds of a body with sharp edges
/// are its own, and no other panels would do without them.
fn fold_advice(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    violations: &[Violation],
) -> Option<String> {
    let folds = violations.iter().filter_map(|v| match v {
        Violation::Fold { faces, .. } => Some(faces.map(|f| mesh.centre(f))),
        _ => None,
    });
    let turns: Vec<[f64; 2]> = folds
        .map(|centres| turn_between(surface, centres))
        .collect();
    let is_edge = |[all, at_once]: &[f64; 2]| *all > OWN_FOLD && *at_once > 0.5 * all;
    let own: Vec<f64> = (turns.iter().filter(|t| is_edge(t)))
        .map(|t| t[0])
        .collect();
    let most = own.iter().copied().fold(0.0, f64::max);
    match (turns.len(), own.len()) {
        (0, _) => None,
        (_, 0) => Some(SMALLER.to_owned()),
        (all, own) => Some(format!(
            "at {own} of {all} the surface itself turns between two panels, by up to {most:.0} degrees: round its edges off there, or leave them"
        )),
    }
}

/// Angle by which a surface turns between two places, and the largest within one of [`STEPS`] on
/// the way, degrees: at an edge it turns at once.
fn turn_between(surface: &TriangleSurface, [from, to]: [Vec3; 2]) -> [f64; 2] {
    let place = |k: usize| from + (to - from) * (k as f64 / STEPS as f64);
    let normal = |p| surface.area_vector(surface.closest_point(p).triangle);
    let normals: Vec<Vec3> = (0..=STEPS).map(|k| normal(place(k))).collect();
    let steps = normals.windows(2).map(|pair| pair[0].angle(&pair[1]));
    let all = normals[0].angle(&normals[STEPS]);
    [all, steps.fold(0.0, f64::max)].map(f64::to_degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::{ValidateOptions, violations};

    /// Two rectangles that meet in a ridge and turn by `degrees` over it; as panels, and as
    /// triangles.
    fn gable(degrees: f64) -> (HexMesh, TriangleSurface) {
        let (sin, cos) = (0.5 * degrees).to_radians().sin_cos();
        let ends = |x: f64, z: f64| [Vec3::new(x, 0.0, z), Vec3::new(x, 1.0, z)];
        let places = [ends(-cos, -sin), ends(0.0, 0.0), ends(cos, -sin)].concat();
        let mesh = HexMesh::new(places.clone(), &[[0, 2, 3, 1], [2, 4, 5, 3]]).unwrap();
        let triangles = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
        (mesh, TriangleSurface::new(places, &triangles).unwrap())
    }

    #[test]
    fn limits_that_ask_for_fewer_and_for_more_panels_contradict_each_other() {
        use crate::quality::Scale;
        let told = |failing: &[&'static str]| {
            let checks = ["min_edge", "deviation", "coverage_inner", "max_panel"]
                .map(|name| Check::new(name, [1.0, 2.0], Scale::Ratio, !failing.contains(&name)));
            contradiction(&checks)
        };
        assert_eq!(told(&[]), None);
        assert_eq!(told(&["min_edge"]), None);
        assert_eq!(told(&["deviation", "max_panel"]), None);
        let both = told(&["min_edge", "deviation", "coverage_inner", "max_panel"]).unwrap();
        assert!(
            both.contains(
                "min-edge asks for fewer panels, max-deviation and max-panel ask for more"
            ),
            "{both}"
        );
    }

    #[test]
    fn folds_of_the_surface_are_told_from_those_of_panels() {
        let advice = |panels: f64, surface: f64| {
            let (mesh, surface) = (gable(panels).0, gable(surface).1);
            let found = violations(&mesh, None, &ValidateOptions::default());
            fold_advice(&mesh, &surface, &found)
        };
        assert_eq!(advice(80.0, 80.0), None);
        let own = advice(120.0, 120.0).unwrap();
        assert!(
            own.contains("at 1 of 1") && own.contains("by up to 120 degrees"),
            "{own}"
        );
        assert_eq!(advice(120.0, 60.0).as_deref(), Some(SMALLER));
    }

    /// A vault that turns by 120 degrees has no edge to be rounded off.
    #[test]
    fn folds_over_a_bend_are_those_of_panels() {
        let mesh = gable(120.0).0;
        let across = |k: u32| (f64::from(k) * 10.0 - 60.0).to_radians().sin_cos();
        let row = |k: u32| [0.0, 1.0].map(|y| Vec3::new(across(k).0, y, across(k).1 - 1.0));
        let places: Vec<Vec3> = (0..=12).flat_map(row).collect();
        let strip = |k: u32| [[2 * k, 2 * k + 2, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 1]];
        let triangles: Vec<[u32; 3]> = (0..12).flat_map(strip).collect();
        let vault = TriangleSurface::new(places, &triangles).unwrap();
        let found = violations(&mesh, None, &ValidateOptions::default());
        assert_eq!(fold_advice(&mesh, &vault, &found).as_deref(), Some(SMALLER));
    }
}
