//! Chamfers: an edge over which two panels fold by more than a right angle is cut off, so that they turn in two steps.
//!
//! Where a body is thinner than its panels (a fin, the edge of a wing) two of them meet like the sides of a blade. A plane parallel to
//! their edge and as steep to one as to the other cuts the edge off. It leaves a narrow quadrilateral; the planes of all other panels stay, so that
//! everything is as planar as before, and interior vertices still have three faces.
//!
//! A cut is made only where all panels that it changes stay simple and keep their clearance, and nothing else goes wrong; a blade of almost no
//! angle is cut twice.

use super::{Trimmed, compact};
use phex_mesh::{
    FaceId, FlatFace, HalfEdgeId, HexMesh, PerFace, Topology, TriangleSurface, ValidateOptions,
    Vec3, VertexId, Violation, polygon, violations,
};
use std::collections::HashSet;
use std::f64::consts::FRAC_PI_2;

/// Depths of a cut that are tried, over that of the nearest vertex below which an adjacent edge leads to.
const DEPTHS: [f64; 4] = [0.45, 0.3, 0.15, 0.07];

/// The mesh with edges over which panels fold by more than 90 degrees cut off, one after the other, the sharpest first; a cut is kept where less
/// is wrong after it on the whole mesh, crossings included. `None` if none is. Panels keep their numbers, new ones follow; their parent is
/// that of a panel beside them.
pub(crate) fn without_folds(
    trimmed: &Trimmed,
    surface: Option<&TriangleSurface>,
) -> Option<Trimmed> {
    let judge = |mesh: &HexMesh| Wrong::of(violations(mesh, surface, &ValidateOptions::default()));
    let mut wrong = judge(&trimmed.mesh);
    let mut tried = HashSet::new();
    let mut last: Option<Trimmed> = None;
    while let Some(faces) = wrong.sharpest(&tried) {
        tried.insert(faces);
        let now = last.as_ref().unwrap_or(trimmed);
        let cuts = DEPTHS
            .iter()
            .filter_map(|depth| cut_off(now, faces, *depth));
        let mut judged = cuts.map(|next| (judge(&next.mesh), next));
        if let Some((reached, next)) = judged.find(|(reached, _)| reached.is_less(&wrong)) {
            (last, wrong) = (Some(next), reached);
        }
    }
    last
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

    fn sharpest(&self, tried: &HashSet<[FaceId; 2]>) -> Option<[FaceId; 2]> {
        let open = self
            .folds
            .iter()
            .filter(|(faces, _)| !tried.contains(faces));
        let sharpest = open.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        sharpest.map(|(faces, _)| *faces)
    }

    /// A fold of 180 degrees may become two of a little over 90.
    fn is_less(&self, other: &Self) -> bool {
        let excess = |w: &Self| w.folds.iter().map(|(_, a)| a - FRAC_PI_2).sum::<f64>();
        self.others <= other.others && excess(self) < excess(other)
    }
}

/// The mesh with the edge between two panels cut off, if that leaves sound panels.
fn cut_off(trimmed: &Trimmed, [left, right]: [FaceId; 2], depth: f64) -> Option<Trimmed> {
    let mesh = &trimmed.mesh;
    let topology = mesh.topology();
    let across = |h: &HalfEdgeId| topology.twin(*h).is_some_and(|t| topology.face(t) == right);
    let blade = Blade::new(topology, topology.face_half_edges(left).find(across)?)?;
    let mut draft = Draft {
        positions: mesh.positions.as_slice().to_vec(),
        faces: topology.face_lists(),
        least: ValidateOptions::default().clearance * mesh.mean_edge(),
    };
    if !draft.cut(&blade, mesh, depth) {
        return None;
    }
    let mut parent = trimmed.parent.as_slice().to_vec();
    parent.push(trimmed.parent[left]);
    Some(Trimmed {
        mesh: compact(&draft.positions, &draft.faces).ok()?,
        parent: PerFace::from_vec(parent),
    })
}

/// An edge between two panels and what is next to it.
struct Blade {
    /// The panels on its left and right.
    sides: [FaceId; 2],
    ends: [VertexId; 2],
    /// The next vertices of the left panel, before the first end and after the second one, and those of the right panel.
    beyond: [[VertexId; 2]; 2],
    /// The third panel at each end, if there is one.
    third: [Option<FaceId>; 2],
}

impl Blade {
    fn new(topology: &Topology, h: HalfEdgeId) -> Option<Self> {
        let t = topology.twin(h)?;
        let [before, after] = [topology.prev(h), topology.next(h)];
        let [right_after, right_before] = [topology.next(t), topology.prev(t)];
        let across = |h: HalfEdgeId| topology.twin(h).map(|t| topology.face(t));
        let third = [
            [across(before), across(right_after)],
            [across(after), across(right_before)],
        ];
        // With more panels at an end there is no one panel that a cut would end in.
        let single = third.iter().all(|[a, b]| a == b);
        single.then(|| Self {
            sides: [topology.face(h), topology.face(t)],
            ends: [topology.origin(h), topology.target(h)],
            beyond: [
                [topology.origin(before), topology.target(after)],
                [topology.target(right_after), topology.origin(right_before)],
            ],
            third: third.map(|[a, _]| a),
        })
    }

    /// The direction that the edge points in, like a blade's.
    fn outwards(&self, mesh: &HexMesh) -> Option<Vec3> {
        let [from, to] = self.ends.map(|v| mesh.position(v));
        let along = (to - from).try_normalize(0.0)?;
        let [left, right] = self.sides.map(|f| FlatFace::of(mesh, f).normal());
        let into = left.cross(&along) + along.cross(&right);
        into.try_normalize(0.0).map(|d| -d)
    }
}

/// Positions and faces that are being changed.
struct Draft {
    positions: Vec<Vec3>,
    faces: Vec<Vec<u32>>,
    /// Clearance that panels are to keep.
    least: f64,
}

impl Draft {
    /// Cuts an edge off at a share of the depth of the nearest vertex; false if that leaves panels that are not sound.
    fn cut(&mut self, blade: &Blade, mesh: &HexMesh, share: f64) -> bool {
        let Some(outwards) = blade.outwards(mesh) else {
            return false;
        };
        let adjacent = |side: usize, end: usize| {
            [blade.ends[end], blade.beyond[side][end]].map(|v| mesh.position(v))
        };
        let depth = |side: usize, end: usize| {
            let [top, beyond] = adjacent(side, end);
            outwards.dot(&(top - beyond))
        };
        let depths = [[depth(0, 0), depth(0, 1)], [depth(1, 0), depth(1, 1)]];
        let downwards = depths.iter().flatten().filter(|d| **d > 0.0);
        let nearest = downwards.copied().fold(f64::INFINITY, f64::min);
        // Where a panel turns inwards at the end, its adjacent edge is lengthened.
        let place = |side: usize, end: usize| {
            let [top, beyond] = adjacent(side, end);
            top + (beyond - top) * (share * nearest / depths[side][end])
        };
        let corners = [[place(0, 0), place(0, 1)], [place(1, 0), place(1, 1)]];
        nearest.is_finite() && self.replace(blade, corners)
    }

    /// Puts a quadrilateral in place of an edge: `corners` by side and end.
    fn replace(&mut self, blade: &Blade, corners: [[Vec3; 2]; 2]) -> bool {
        let first = self.positions.len() as u32;
        let number = |side: usize, end: usize| first + (2 * side + end) as u32;
        let sides = [0, 1].map(|side| {
            let ends = [0, 1].map(|end| vec![number(side, end)]);
            (blade.sides[side], with_ends(&self.faces, blade, side, ends))
        });
        // The third panel at the first end goes from the right side to the left one, at the second end the other way.
        let thirds = [0, 1].map(|end| {
            let new = [number(1 - end, end), number(end, end)];
            let face = |f: FaceId| {
                (
                    f,
                    substituted(&self.faces[f.index()], blade.ends[end], &new),
                )
            };
            blade.third[end].map(face)
        });
        let quadrilateral = vec![number(0, 1), number(0, 0), number(1, 0), number(1, 1)];
        self.positions.extend(corners.into_iter().flatten());
        let changed: Vec<(FaceId, Vec<u32>)> = sides
            .into_iter()
            .chain(thirds.into_iter().flatten())
            .collect();
        let sound =
            changed.iter().all(|(_, face)| self.is_sound(face)) && self.is_sound(&quadrilateral);
        if sound {
            for (f, face) in changed {
                self.faces[f.index()] = face;
            }
            self.faces.push(quadrilateral);
        } else {
            self.positions.truncate(first as usize);
        }
        sound
    }

    fn flat(&self, face: &[u32]) -> FlatFace {
        let corners: Vec<Vec3> = face.iter().map(|&v| self.positions[v as usize]).collect();
        FlatFace::new(&corners)
    }

    fn is_sound(&self, face: &[u32]) -> bool {
        let flat = self.flat(face);
        polygon::is_simple(&flat.polygon) && flat.clearance().distance >= self.least
    }
}

/// The panel of a side with other ends of its edge.
fn with_ends(faces: &[Vec<u32>], blade: &Blade, side: usize, ends: [Vec<u32>; 2]) -> Vec<u32> {
    let face = &faces[blade.sides[side].index()];
    let first = substituted(face, blade.ends[0], &ends[0]);
    substituted(&first, blade.ends[1], &ends[1])
}

/// A face with new vertices in place of one.
fn substituted(face: &[u32], old: VertexId, new: &[u32]) -> Vec<u32> {
    let old = old.index() as u32;
    let put = |&v: &u32| if v == old { new.to_vec() } else { vec![v] };
    face.iter().flat_map(put).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn cut(mesh: &HexMesh) -> Option<HexMesh> {
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
        for half in [0.9, 0.5, 0.2] {
            let mesh = wedge(half);
            assert_eq!(folds(&mesh), 3, "the blade and both edges of the back");
            let cut = cut(&mesh).unwrap();
            assert!(is_valid(&cut), "{half}");
            let topology = cut.topology();
            assert_eq!(topology.euler_characteristic(), 2);
            assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
            // All is within the wedge, and its planes are still there.
            for p in &cut.positions {
                assert!(p.x < 1e-12 && p.y.abs() < -half * p.x + 1e-12);
            }
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
        let cut = cut(&mesh).unwrap();
        assert!(is_valid(&cut));
        assert_eq!(cut.topology().n_faces(), 3);
        assert_eq!(cut.topology().boundary_loops().len(), 1);
    }

    #[test]
    fn nothing_is_done_without_folds_or_room() {
        // The sides of a box do not fold; a cut of a sharp knife is too narrow for a panel.
        assert!(cut(&knife(1.5)).is_none());
        assert!(cut(&knife(0.02)).is_none());
    }
}
