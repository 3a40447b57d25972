//! What would help where a check of the mesh in itself fails.

use super::References;
use super::check::{Check, SMALLER};
use super::limits::Limits;
use phex_mesh::{HexMesh, TriangleSurface, Vec3, Violation};
use std::collections::BTreeSet;

/// Turn of the surface between two panels, degrees, from which on a fold is its own: a right angle,
/// less what facets are off.
const OWN_FOLD: f64 = 89.0;

/// What would help where panels are left whole at the boundary and run into each other.
const OVERLAPS: &str = "panels that end at the boundary (--boundary snap or clip), where those of two sides of a slit overlap, or smaller ones";

/// Mean edges within which a crossing of panels is one of the surface: those of panels that meet
/// there.
const OWN_CROSSING: f64 = 2.0;

/// The checks with what would help where they fail. Crossings alone that the surface has, too, do
/// not decide that a mesh is none.
pub(super) fn with_advice(
    checks: Vec<Check>,
    mesh: &HexMesh,
    references: &References<'_>,
    limits: &Limits,
    violations: &[Violation],
) -> Vec<Check> {
    let folds = (references.judge()).and_then(|s| fold_advice(mesh, s, violations));
    let [own, crossings] = count_crossings(mesh, references, violations);
    let passes = (own > 0).then(|| {
        format!(
            "at {own} of {crossings} the surface passes through itself: take away what lies inside, or leave them"
        )
    });
    let overlaps = limits.leaves_boundary().then(|| OVERLAPS.to_owned());
    let advised = |check: Check| {
        let advice = match check.name {
            "folds" => &folds,
            "crossings" if own > 0 => &passes,
            "crossings" | "faces_not_simple" => &overlaps,
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

/// How many edges cross panels where the surface does, too, and how many do in all.
fn count_crossings(
    mesh: &HexMesh,
    references: &References<'_>,
    violations: &[Violation],
) -> [usize; 2] {
    let facets = references.facets.or(references.smooth);
    let (mut all, mut others) = (BTreeSet::new(), BTreeSet::new());
    for violation in violations {
        if let Violation::Crossing { edge, .. } = violation {
            all.insert(*edge);
            if !facets.is_some_and(|s| is_of_surface(violation, mesh, s)) {
                others.insert(*edge);
            }
        }
    }
    [all.len() - others.len(), all.len()]
}

/// Whether panels cross because the surface passes through itself there: no others would do without
/// it.
pub(super) fn is_of_surface(
    violation: &Violation,
    mesh: &HexMesh,
    facets: &TriangleSurface,
) -> bool {
    let Violation::Crossing { .. } = violation else {
        return false;
    };
    let place = violation
        .place(mesh)
        .filter(|p| p.iter().all(|x| x.is_finite()));
    let reach = OWN_CROSSING * mesh.mean_edge();
    place.is_some_and(|place| {
        let own = facets.self_crossings().iter();
        own.into_iter().any(|p| (p - place).norm() < reach)
    })
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
    let turn = |centres: [Vec3; 2]| {
        let normal = |p| surface.area_vector(surface.closest_point(p).triangle);
        let [a, b] = centres.map(normal);
        a.angle(&b).to_degrees()
    };
    let turns: Vec<f64> = folds.map(turn).collect();
    let own: Vec<f64> = turns.iter().copied().filter(|t| *t > OWN_FOLD).collect();
    let most = own.iter().copied().fold(0.0, f64::max);
    match (turns.len(), own.len()) {
        (0, _) => None,
        (_, 0) => Some(SMALLER.to_owned()),
        (all, own) => Some(format!(
            "at {own} of {all} the surface itself turns between two panels, by up to {most:.0} degrees: round its edges off there, or leave them"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quality::{Assessment, Verdict};
    use crate::trim::Boundary;
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

    /// Two squares that pass through each other, or that stand `apart`.
    fn squares(apart: f64) -> (HexMesh, TriangleSurface) {
        let flat = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let lying = flat.map(|[x, y]| Vec3::new(x, y, 0.0));
        let upright = flat.map(|[x, z]| Vec3::new(x, 0.1, z + apart) * 0.7);
        let places = [lying, upright].concat();
        let triangles = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]];
        (
            HexMesh::new(places.clone(), &[[0, 1, 2, 3], [4, 5, 6, 7]]).unwrap(),
            TriangleSurface::new(places, &triangles).unwrap(),
        )
    }

    /// The verdict, and what is said of crossings, where panels cross.
    fn judged(surface: &TriangleSurface, limits: &Limits) -> (Verdict, Option<String>) {
        let references = References {
            facets: Some(surface),
            ..Default::default()
        };
        let found = Assessment::new(&squares(0.0).0, references, limits);
        let check = found.failures().find(|c| c.name == "crossings").unwrap();
        (found.verdict, check.advice.clone())
    }

    #[test]
    fn crossings_of_the_surface_are_told_from_those_of_panels() {
        let (verdict, advice) = judged(&squares(0.0).1, &Limits::default());
        let advice = advice.unwrap();
        assert_eq!(verdict, Verdict::OutsideTolerance);
        assert!(
            advice.contains("at 2 of 2 the surface passes through itself"),
            "{advice}"
        );
        let (verdict, advice) = judged(&squares(2.0).1, &Limits::default());
        assert_eq!((verdict, advice), (Verdict::Invalid, None));
    }

    #[test]
    fn panels_that_are_left_whole_and_overlap_are_told_to_end_at_the_boundary() {
        let advice = |boundary| {
            let limits = Limits::new(Some(0.5), Some(boundary));
            judged(&squares(2.0).1, &limits).1
        };
        assert_eq!(advice(Boundary::Whole).as_deref(), Some(OVERLAPS));
        assert_eq!(advice(Boundary::Snap), None);
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
}
