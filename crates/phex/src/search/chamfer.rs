//! Chamfers: an edge over which two panels fold by more than a right angle is cut off, so that they
//! turn in two steps.
//!
//! Where a body is thinner than its panels (a fin, the edge of a wing) two of them meet like the
//! sides of a blade. A plane parallel to their edge and as steep to one as to the other cuts the
//! edge off. It leaves a narrow quadrilateral; the planes of all other panels stay, so that
//! everything is as planar as before, and interior vertices still have three faces. The optimiser
//! then makes a panel of it.

use super::draft::{DirectedEdge, Draft};
use phex_mesh::{FlatFace, Vec3};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_2;

/// Share of the depth of the nearest corner below an edge at which it is cut off.
const DEPTH: f64 = 0.3;
/// Edges that are cut off in one patch at the most.
const CUTS: usize = 24;

/// The panels with all folds cut off that panels of `core` have, or any panel of the patch if it is
/// `None`; the sharpest first. `None` where there is none.
pub(super) fn chamfered(draft: &Draft, core: Option<&[usize]>) -> Option<Draft> {
    let mut now = draft.clone();
    let mut tried: BTreeSet<DirectedEdge> = BTreeSet::new();
    let counts = |f: usize| core.is_none_or(|core| core.contains(&f));
    for _ in 0..CUTS {
        let folds = now.folds().into_iter();
        let sharpest = folds
            .filter(|fold| fold.faces.iter().any(|f| counts(now.origin[*f])))
            .filter(|fold| !tried.contains(&fold.side))
            .max_by(|a, b| a.angle.total_cmp(&b.angle).then(b.side.cmp(&a.side)));
        let Some(fold) = sharpest else { break };
        tried.insert(fold.side);
        if let Some(next) = now.cut_off(fold.side) {
            now = next;
        }
    }
    (now.faces.len() > draft.faces.len()).then_some(now)
}

/// Two panels that turn by more than a right angle over an edge.
struct BladeEdge {
    side: DirectedEdge,
    faces: [usize; 2],
    angle: f64,
}

impl Draft {
    fn folds(&self) -> Vec<BladeEdge> {
        let normal = |face: &Vec<u32>| match face.is_empty() {
            true => Vec3::zeros(),
            false => self.flat(face).normal(),
        };
        let normals: Vec<Vec3> = self.faces.iter().map(normal).collect();
        let incidence = self.incidence();
        let sides = incidence.sides().filter(|[a, b]| a < b);
        let fold = |side: DirectedEdge| {
            let faces = incidence.beside(side)?;
            let angle = normals[faces[0]].angle(&normals[faces[1]]);
            (angle > FRAC_PI_2).then_some(BladeEdge { side, faces, angle })
        };
        sides.filter_map(fold).collect()
    }

    fn flat(&self, face: &[u32]) -> FlatFace {
        let corners: Vec<Vec3> = face.iter().map(|v| self.places[*v as usize]).collect();
        FlatFace::new(&corners)
    }

    /// The panels with an edge cut off; `None` if a panel there can't take part.
    fn cut_off(&self, side: DirectedEdge) -> Option<Self> {
        let incidence = self.incidence();
        let sides = incidence.beside(side)?;
        let third = |x: u32| {
            let others: Vec<usize> = (incidence.faces_at(x))
                .filter(|f| !sides.contains(f))
                .collect();
            // With more panels at an end there is no one panel that a cut would end in.
            (others.len() < 2).then(|| others.first().copied())
        };
        let thirds = [third(side[0])?, third(side[1])?];
        let changed = sides.into_iter().chain(thirds.into_iter().flatten());
        if changed.clone().any(|f| !self.open[f]) {
            return None;
        }
        let first = self.places.len() as u32;
        let mut next = self.clone();
        next.places.extend(self.corners_of_cut(sides, side)?);
        for end in [0, 1, 0, 1] {
            let at_end = self.on_boundary[side[end] as usize];
            next.on_boundary.push(at_end);
        }
        let number = |of: usize, end: usize| first + (2 * of + end) as u32;
        let mut replace = |f: usize, end: usize, new: &[u32]| {
            let put = |v: u32| {
                if v == side[end] {
                    new.to_vec()
                } else {
                    vec![v]
                }
            };
            next.faces[f] = next.faces[f].iter().flat_map(|v| put(*v)).collect();
        };
        for (end, third) in thirds.into_iter().enumerate() {
            (0..2).for_each(|of| replace(sides[of], end, &[number(of, end)]));
            // The third panel at the first end goes from the right side to the left one, at the
            // second end the other way.
            if let Some(f) = third {
                replace(f, end, &[number(1 - end, end), number(end, end)]);
            }
        }
        let quadrilateral = vec![number(0, 1), number(0, 0), number(1, 0), number(1, 1)];
        next.faces.push(quadrilateral);
        next.open.push(true);
        next.origin.push(self.origin[sides[0]]);
        Some(next)
    }

    /// Where a plane cuts the sides next to an edge: those of the left panel at both ends, then
    /// those of the right one.
    fn corners_of_cut(&self, faces: [usize; 2], side: DirectedEdge) -> Option<[Vec3; 4]> {
        let place = |v: u32| self.places[v as usize];
        let along = (place(side[1]) - place(side[0])).try_normalize(0.0)?;
        let [left, right] = faces.map(|f| self.flat(&self.faces[f]).normal());
        let into = left.cross(&along) + along.cross(&right);
        let outwards = -into.try_normalize(0.0)?;
        let beyond = |of: usize, end: usize| {
            let face = &self.faces[faces[of]];
            let k = face.iter().position(|v| *v == side[end])?;
            // The left panel comes to the edge at its first end, the right one at its second.
            let step = if of == end { face.len() - 1 } else { 1 };
            Some(place(face[(k + step) % face.len()]))
        };
        let mut slopes = Vec::with_capacity(4);
        for (of, end) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            slopes.push((place(side[end]), beyond(of, end)? - place(side[end])));
        }
        let depth = |way: &Vec3| -outwards.dot(way);
        let downwards = slopes
            .iter()
            .map(|(_, way)| depth(way))
            .filter(|d| *d > 0.0);
        let nearest = downwards.fold(f64::INFINITY, f64::min);
        // Where a panel turns inwards at the end, its adjacent edge is lengthened.
        let cut = |(top, way): &(Vec3, Vec3)| top + way * (DEPTH * nearest / depth(way));
        let corners: Vec<Vec3> = slopes.iter().map(cut).collect();
        let finite = corners.iter().all(|p| p.iter().all(|x| x.is_finite()));
        corners.try_into().ok().filter(|_| finite)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::{HexMesh, ValidateOptions, Violation, violations};

    fn draft(places: Vec<Vec3>, faces: &[&[u32]], at_boundary: bool) -> Draft {
        Draft {
            on_boundary: vec![at_boundary; places.len()],
            places,
            open: vec![true; faces.len()],
            origin: (0..faces.len()).collect(),
            faces: faces.iter().map(|f| f.to_vec()).collect(),
        }
    }

    /// A prism over a triangle with an angle of `2 atan(half)` at its blade.
    fn wedge(half: f64) -> Draft {
        let triangle = [[0.0, 0.0], [-1.0, half], [-1.0, -half]];
        let ring = |z: f64| triangle.map(|[x, y]| Vec3::new(x, y, z));
        let faces: [&[u32]; 5] = [
            &[0, 2, 1],
            &[3, 4, 5],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
        ];
        draft([ring(0.0), ring(1.5)].concat(), &faces, false)
    }

    /// Two panels like the sides of a knife, with nothing at their ends.
    fn knife() -> Draft {
        let place = |x: f64, y: f64, z: f64| Vec3::new(x, 0.3 * y, z);
        let places = vec![
            place(0.0, 0.0, 0.0),
            place(0.0, 0.0, 1.0),
            place(-1.0, 1.0, 1.2),
            place(-1.0, 1.0, -0.1),
            place(-1.2, -1.2, 0.9),
            place(-1.0, -1.0, 0.1),
        ];
        draft(places, &[&[0, 3, 2, 1], &[1, 4, 5, 0]], true)
    }

    /// The panels as a mesh, how many edges of it fold, and what is wrong in all.
    fn built(draft: &Draft) -> (HexMesh, usize, usize) {
        let mesh = crate::trim::compact(&draft.places, &draft.faces).unwrap();
        let found = violations(&mesh, None, &ValidateOptions::default());
        let is_fold = |v: &&Violation| matches!(v, Violation::Fold { .. });
        (mesh, found.iter().filter(is_fold).count(), found.len())
    }

    #[test]
    fn blades_are_cut_off() {
        for half in [0.9, 0.5, 0.2] {
            let whole = wedge(half);
            assert_eq!(built(&whole).1, 3, "the blade and both edges of the back");
            let (mesh, folds, wrong) = built(&chamfered(&whole, None).unwrap());
            assert_eq!((folds, wrong), (0, 0), "{half}");
            let topology = mesh.topology();
            assert_eq!(topology.euler_characteristic(), 2);
            assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
            let heights = phex_mesh::measure(&mesh).planarity.max;
            assert!(heights < 1e-14, "{heights}");
        }
    }

    #[test]
    fn a_blade_at_the_boundary_is_cut_to_it() {
        let cut = chamfered(&knife(), None).unwrap();
        let (mesh, folds, wrong) = built(&cut);
        assert_eq!((folds, wrong, mesh.topology().n_faces()), (0, 0, 3));
        assert_eq!(mesh.topology().boundary_loops().len(), 1);
        assert!(cut.on_boundary[6..].iter().all(|at| *at));
    }

    #[test]
    fn what_is_closed_or_not_meant_stays() {
        let mut whole = wedge(0.5);
        let back = chamfered(&whole, Some(&[3])).unwrap();
        assert!(built(&back).1 < 3, "the edges of the back, not the blade");
        whole.open = vec![false; 5];
        assert!(chamfered(&whole, None).is_none());
        assert!(chamfered(&wedge(1.5), Some(&[0])).is_none(), "no fold");
    }
}
