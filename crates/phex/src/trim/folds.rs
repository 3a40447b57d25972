//! Folds that the repair loop has left: edges over which panels turn by more than a right angle.
//!
//! Where little is missing one of the panels, or both, are turned towards each other
//! ([`turn`](super::turn)); else the edge is cut off ([`chamfer`](super::chamfer)). Both are exact:
//! all panels stay planar. A change is kept only where the fold goes or becomes less, and no more
//! is wrong on the whole mesh after it, crossings included.

use super::Trimmed;
use super::chamfer::cut_off;
use super::turn::turned;
use phex_mesh::{FaceId, TriangleSurface, ValidateOptions, Violation, violations};
use std::collections::HashSet;
use std::f64::consts::FRAC_PI_2;

/// Depths of a cut that are tried.
const DEPTHS: [f64; 4] = [0.45, 0.3, 0.15, 0.07];
/// Excess of an angle, radians, up to which panels are turned.
const LITTLE: f64 = 0.8;
/// Radians by which more is turned than has to be.
const MARGIN: f64 = 0.02;
/// Shares of the turn that the two panels take; with the last ones the fold only becomes less.
const TURNS: [[f64; 2]; 4] = [[0.5, 0.5], [1.0, 0.0], [0.0, 1.0], [0.25, 0.25]];
/// Times that all folds are looked at, while some become less.
const PASSES: usize = 3;

/// The mesh with fewer folds, the sharpest treated first; `None` if none gets less. Panels keep
/// their numbers, new ones follow.
pub(crate) fn without_folds(
    trimmed: &Trimmed,
    surface: Option<&TriangleSurface>,
) -> Option<Trimmed> {
    let judge = |next: Trimmed| {
        let violations = violations(&next.mesh, surface, &ValidateOptions::default());
        (Wrong::of(violations), next)
    };
    let (mut wrong, mut now) = judge(trimmed.clone());
    let first = wrong.excess();
    for _ in 0..PASSES {
        let before = wrong.excess();
        let mut tried = HashSet::new();
        while let Some((faces, angle)) = wrong.sharpest(&tried) {
            tried.insert(faces);
            let judged = changes(&now, faces, angle).map(judge);
            if let Some(better) = best(judged, &wrong) {
                (wrong, now) = better;
            }
        }
        if wrong.folds.is_empty() || wrong.excess() >= before {
            break;
        }
    }
    (wrong.excess() < first).then_some(now)
}

/// The first change that takes a fold away or, if there is none, one that makes it less.
fn best(judged: impl Iterator<Item = (Wrong, Trimmed)>, wrong: &Wrong) -> Option<(Wrong, Trimmed)> {
    let mut less = None;
    for (reached, next) in judged.filter(|(reached, _)| reached.is_less(wrong)) {
        if reached.folds.len() < wrong.folds.len() {
            return Some((reached, next));
        }
        less.get_or_insert((reached, next));
    }
    less
}

/// Ways to unfold two panels, mild ones first.
fn changes(now: &Trimmed, faces: [FaceId; 2], angle: f64) -> impl Iterator<Item = Trimmed> + '_ {
    let excess = angle - FRAC_PI_2;
    let turns = TURNS.iter().filter(move |_| excess < LITTLE);
    let turns = turns.filter_map(move |shares| {
        let mesh = turned(&now.mesh, faces, shares.map(|s| s * (excess + MARGIN)))?;
        let parent = now.parent.clone();
        Some(Trimmed { mesh, parent })
    });
    turns.chain(DEPTHS.iter().filter_map(move |d| cut_off(now, faces, *d)))
}

/// What is wrong with a mesh: folds, by angle, and how many other things.
struct Wrong {
    folds: Vec<([FaceId; 2], f64)>,
    others: usize,
}

impl Wrong {
    fn of(violations: Vec<Violation>) -> Self {
        let fold = |v: &Violation| match v {
            Violation::Fold { faces, angle, .. } => Some((*faces, *angle)),
            _ => None,
        };
        let folds: Vec<_> = violations.iter().filter_map(fold).collect();
        Self {
            others: violations.len() - folds.len(),
            folds,
        }
    }

    fn sharpest(&self, tried: &HashSet<[FaceId; 2]>) -> Option<([FaceId; 2], f64)> {
        let open = self
            .folds
            .iter()
            .filter(|(faces, _)| !tried.contains(faces));
        open.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))
            .copied()
    }

    /// Angle beyond 90 degrees in all: a fold of 180 degrees may become two of a little over 90.
    fn excess(&self) -> f64 {
        self.folds.iter().map(|(_, angle)| angle - FRAC_PI_2).sum()
    }

    fn is_less(&self, other: &Self) -> bool {
        self.others <= other.others && self.excess() < other.excess()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::{HexMesh, PerFace, Vec3};
    use std::f64::consts::PI;

    /// A prism over a triangle with an angle of `2 atan(half)` at its blade.
    fn wedge(half: f64) -> HexMesh {
        let triangle = [[0.0, 0.0], [-1.0, half], [-1.0, -half]];
        let ring = |z: f64| triangle.map(|[x, y]| Vec3::new(x, y, z));
        let faces: [&[u32]; 5] = [
            &[0, 2, 1],
            &[3, 4, 5],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
        ];
        HexMesh::new([ring(0.0), ring(1.5)].concat(), &faces).unwrap()
    }

    fn unfolded(mesh: &HexMesh) -> Option<HexMesh> {
        let parent = PerFace::from_vec(mesh.topology().faces().collect());
        let mesh = mesh.clone();
        let cut = without_folds(&Trimmed { mesh, parent }, None)?;
        assert_eq!(cut.parent.len(), cut.mesh.topology().n_faces());
        Some(cut.mesh)
    }

    fn folds(mesh: &HexMesh) -> usize {
        let all = violations(mesh, None, &ValidateOptions::default());
        let folds = all.iter().filter(|v| matches!(v, Violation::Fold { .. }));
        folds.count()
    }

    fn is_valid(mesh: &HexMesh) -> bool {
        violations(mesh, None, &ValidateOptions::default()).is_empty()
    }

    #[test]
    fn blades_are_cut_off() {
        for half in [0.9, 0.5, 0.2, 0.1] {
            let mesh = wedge(half);
            assert_eq!(folds(&mesh), 3, "the blade and both edges of the back");
            let cut = unfolded(&mesh).unwrap();
            assert!(is_valid(&cut), "{half}");
            let topology = cut.topology();
            assert_eq!(topology.euler_characteristic(), 2);
            assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
        }
    }

    /// Two panels like the sides of a knife, with nothing at their ends.
    fn knife(half: f64) -> HexMesh {
        let place = |x: f64, y: f64, z: f64| Vec3::new(x, y * half, z);
        let positions = vec![
            place(0.0, 0.0, 0.0),
            place(0.0, 0.0, 1.0),
            place(-1.0, 1.0, 1.2),
            place(-1.0, 1.0, -0.1),
            place(-1.2, -1.2, 0.9),
            place(-1.0, -1.0, 0.1),
        ];
        HexMesh::new(positions, &[[0u32, 3, 2, 1], [1, 4, 5, 0]]).unwrap()
    }

    #[test]
    fn a_blade_at_the_boundary_is_cut_to_it() {
        let mesh = knife(0.3);
        assert_eq!(folds(&mesh), 1);
        let cut = unfolded(&mesh).unwrap();
        assert!(is_valid(&cut));
        assert_eq!(cut.topology().n_faces(), 3);
        assert_eq!(cut.topology().boundary_loops().len(), 1);
    }

    #[test]
    fn nothing_is_done_without_folds_or_room() {
        // The sides of a box do not fold; a cut of a sharp knife is too narrow for a panel.
        assert!(unfolded(&knife(1.5)).is_none());
        assert!(unfolded(&knife(0.02)).is_none());
    }

    #[test]
    fn a_slight_fold_is_turned_away() {
        // The blade of this prism turns by 94 degrees; with its ends and back cut off nothing else
        // folds.
        let half = 0.93f64;
        let mesh = unfolded(&wedge(half)).unwrap();
        assert!(is_valid(&mesh));
        let blade = PI - 2.0 * half.atan();
        assert!(blade - FRAC_PI_2 < LITTLE && blade > FRAC_PI_2);
        // Turned, not cut: three edges fold, and only the two of the back can't be turned away.
        assert!(
            mesh.topology().n_faces() <= 7,
            "{}",
            mesh.topology().n_faces()
        );
    }
}
