//! Panels of a patch while they are joined anew: edges are turned (a T1 step, as in foams), two
//! panels are merged by taking the edge between them away, and one is split by a new edge. Interior
//! vertices keep three panels throughout.

use crate::layout::moves::{LEAST_CORNERS, OPENING, glide};
use phex_mesh::polygon::sides;
use phex_mesh::{Topology, Vec3, numbered, turn_edge};

/// Corners that a panel may come to have.
const MOST: usize = 9;
/// Turns of edges after a change at the most, and sequences of them.
const TURNS: usize = 24;
const GLIDES: usize = 6;

/// Panels as lists of corners.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    /// Corners of each panel, counter-clockwise; empty where it was merged with another.
    pub faces: Vec<Vec<u32>>,
    pub places: Vec<Vec3>,
    /// Whether the corners of each panel may change.
    pub open: Vec<bool>,
    /// Whether each corner lies on the boundary of the surface.
    pub on_boundary: Vec<bool>,
    /// The panel that each was made from, for those that are new its own number.
    pub origin: Vec<usize>,
}

/// An edge as its corners in the order of the panel on its left.
pub(super) type DirectedEdge = [u32; 2];

impl Draft {
    /// Panels by their corners.
    pub(super) fn incidence(&self) -> Incidence {
        let mut at = vec![Vec::new(); self.places.len()];
        for (f, face) in self.faces.iter().enumerate() {
            for [v, next] in sides(face) {
                at[v as usize].push((f, next));
            }
        }
        Incidence(at)
    }

    /// The sides of a panel and the panels across them.
    pub fn neighbours(&self, f: usize) -> Vec<(DirectedEdge, usize)> {
        let incidence = self.incidence();
        let across = |[a, b]: DirectedEdge| incidence.owner([b, a]).map(|g| ([a, b], g));
        sides(&self.faces[f]).filter_map(across).collect()
    }

    /// How irregular a panel with `n` corners is; panels at the boundary may have any number.
    fn irregularity(&self, f: usize, n: usize) -> i64 {
        let at_rim = self.faces[f].iter().any(|v| self.on_boundary[*v as usize]);
        match at_rim {
            true if (LEAST_CORNERS..=7).contains(&n) => 0,
            true => 1,
            false => (n as i64 - 6).pow(2),
        }
    }

    /// Turns an edge; `None` if one of the four panels can't take part, or would have too few or
    /// too many corners.
    pub fn turned(&self, [u, v]: DirectedEdge) -> Option<Self> {
        let turn = self.turn(&self.incidence(), [u, v])?;
        let mut next = self.clone();
        let at_ends = [Some(turn.at_u), Some(turn.at_v)];
        turn_edge(&mut next.faces, [u, v], [turn.left, turn.right], at_ends);
        let centre = |f: usize| self.centre(f);
        let middle = (self.places[u as usize] + self.places[v as usize]) * 0.5;
        let open = |f: usize| (centre(f) - middle) * OPENING;
        next.places[u as usize] = middle + open(turn.left);
        next.places[v as usize] = middle + open(turn.right);
        Some(next)
    }

    /// What a turn does to the sum of irregularities.
    fn gain(&self, incidence: &Incidence, side: DirectedEdge) -> Option<i64> {
        let turn = self.turn(incidence, side)?;
        let change = |f: usize, by: i64| {
            let n = self.faces[f].len();
            self.irregularity(f, n) - self.irregularity(f, (n as i64 + by) as usize)
        };
        Some(
            change(turn.left, -1)
                + change(turn.right, -1)
                + change(turn.at_u, 1)
                + change(turn.at_v, 1),
        )
    }

    fn turn(&self, incidence: &Incidence, [u, v]: DirectedEdge) -> Option<Turn> {
        if self.on_boundary[u as usize] || self.on_boundary[v as usize] {
            return None;
        }
        let (left, right) = (incidence.owner([u, v])?, incidence.owner([v, u])?);
        let other = |x: u32| {
            let mut rest = incidence.faces_at(x).filter(|f| *f != left && *f != right);
            rest.next().filter(|_| incidence.faces_at(x).count() == 3)
        };
        let (at_u, at_v) = (other(u)?, other(v)?);
        let open = [left, right, at_u, at_v].iter().all(|f| self.open[*f]);
        let apart = at_u != at_v && !self.share_a_corner(at_u, at_v);
        let enough =
            self.faces[left].len() > LEAST_CORNERS && self.faces[right].len() > LEAST_CORNERS;
        let few = self.faces[at_u].len() < MOST && self.faces[at_v].len() < MOST;
        (open && apart && enough && few).then_some(Turn {
            left,
            right,
            at_u,
            at_v,
        })
    }

    fn share_a_corner(&self, f: usize, g: usize) -> bool {
        self.faces[f].iter().any(|x| self.faces[g].contains(x))
    }

    /// Takes the edge between two panels away.
    pub(crate) fn merged(&self, [u, v]: DirectedEdge) -> Option<Self> {
        let incidence = self.incidence();
        let (f, g) = (incidence.owner([u, v])?, incidence.owner([v, u])?);
        let shared = self.faces[f].iter().filter(|x| self.faces[g].contains(x));
        let inside =
            |x: &u32| incidence.faces_at(*x).count() == 3 && !self.on_boundary[*x as usize];
        if f == g || shared.count() != 2 || !self.open[f] || !self.open[g] {
            return None;
        }
        let mut next = self.clone();
        let mut ring = from(&self.faces[f], v);
        let other = from(&self.faces[g], u);
        ring.extend(&other[1..other.len() - 1]);
        next.faces[f] = ring;
        next.faces[g].clear();
        for x in [u, v].into_iter().filter(inside) {
            for h in incidence.faces_at(x) {
                if h != f && h != g && (!self.open[h] || self.faces[h].len() <= LEAST_CORNERS) {
                    return None;
                }
            }
            next.faces
                .iter_mut()
                .for_each(|face| face.retain(|y| *y != x));
        }
        (next.faces[f].len() >= LEAST_CORNERS).then_some(next)
    }

    /// Splits a panel by an edge between the middles of its sides number `i` and `j`.
    pub fn split(&self, f: usize, i: usize, j: usize) -> Option<Self> {
        let incidence = self.incidence();
        let face = &self.faces[f];
        let n = face.len();
        let side = |k: usize| [face[k % n], face[(k + 1) % n]];
        let mut next = self.clone();
        let mut cuts = Vec::new();
        for [a, b] in [side(i), side(j)] {
            let x = next.places.len() as u32;
            let across = incidence.owner([b, a]);
            if across.is_some_and(|g| !self.open[g] || self.faces[g].len() >= MOST) {
                return None;
            }
            let middle = (self.places[a as usize] + self.places[b as usize]) * 0.5;
            next.places.push(middle);
            next.on_boundary.push(across.is_none());
            if let Some(g) = across {
                insert_between(&mut next.faces[g], b, a, x);
            }
            cuts.push(x);
        }
        let part = |from: usize, to: usize, first: u32, last: u32| {
            let count = (to + n - from) % n;
            let corners = (1..=count).map(|k| face[(from + k) % n]);
            let ring = std::iter::once(first).chain(corners).chain([last]);
            ring.collect::<Vec<u32>>()
        };
        let (one, two) = (part(i, j, cuts[0], cuts[1]), part(j, i, cuts[1], cuts[0]));
        if !self.open[f] || one.len() < LEAST_CORNERS || two.len() < LEAST_CORNERS {
            return None;
        }
        next.faces[f] = one;
        next.faces.push(two);
        next.open.push(true);
        next.origin.push(f);
        Some(next)
    }

    /// Splits of a panel into halves, the one across its longest extent first.
    pub fn halves(&self, f: usize) -> Vec<Self> {
        let face = &self.faces[f];
        let n = face.len();
        let middle = |k: usize| {
            (self.places[face[k % n] as usize] + self.places[face[(k + 1) % n] as usize]) * 0.5
        };
        let mut cuts: Vec<(f64, usize)> = (0..n.div_ceil(2))
            .map(|i| ((middle(i) - middle(i + n / 2)).norm(), i))
            .collect();
        cuts.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let split = |(_, i): &(f64, usize)| self.split(f, *i, (i + n / 2) % n);
        cuts.iter().filter_map(split).collect()
    }

    /// Turns edges, alone and in short sequences, while that makes panels more regular.
    pub(crate) fn calmed(self) -> Self {
        let mut calm = self.turned_greedily();
        for _ in 0..GLIDES {
            let Some(next) = calm.glided() else { break };
            calm = next.turned_greedily();
        }
        calm
    }

    /// The panels after sequences of turns that make them more regular, though their first steps do
    /// not.
    fn glided(&self) -> Option<Self> {
        let (topology, numbers) = self.topology()?;
        let closed = topology.faces().filter(|f| !self.open[numbers[f.index()]]);
        let sequences = glide::sequences_beside(&topology, closed.collect(), &[]);
        let mut next = self.clone();
        for sides in sequences.iter().flatten() {
            let [f, g] = sides.map(|f| numbers[f.index()]);
            let side = next.neighbours(f).into_iter().find(|(_, h)| *h == g)?.0;
            next = next.turned(side)?;
        }
        (next.irregularities() < self.irregularities()).then_some(next)
    }

    /// How irregular the panels are in all.
    pub fn irregularities(&self) -> i64 {
        let irregularity = |f| self.irregularity(f, self.faces[f].len());
        self.kept().into_iter().map(irregularity).sum()
    }

    /// The panels that were not merged with others.
    pub fn kept(&self) -> Vec<usize> {
        let faces = 0..self.faces.len();
        faces.filter(|f| !self.faces[*f].is_empty()).collect()
    }

    /// The connectivity, and the number of each of its panels.
    fn topology(&self) -> Option<(Topology, Vec<usize>)> {
        let numbers = self.kept();
        let (corners, faces) = numbered(numbers.iter().map(|f| self.faces[*f].iter()));
        let topology = Topology::from_faces(corners.len(), &faces).ok()?;
        Some((topology, numbers))
    }

    fn turned_greedily(mut self) -> Self {
        for _ in 0..TURNS {
            let incidence = self.incidence();
            let sides = incidence.sides().filter(|[a, b]| a < b);
            let gains = sides.filter_map(|s| Some((self.gain(&incidence, s)?, s)));
            let best = gains.max_by(|a, b| a.0.cmp(&b.0).then(b.1.cmp(&a.1)));
            let Some((_, side)) = best.filter(|b| b.0 > 0) else {
                break;
            };
            let Some(next) = self.turned(side) else { break };
            self = next;
        }
        self
    }

    pub fn centre(&self, f: usize) -> Vec3 {
        let corners = self.faces[f].iter().map(|v| self.places[*v as usize]);
        corners.sum::<Vec3>() / self.faces[f].len().max(1) as f64
    }
}

/// The panels at each corner, each with the corner that comes next in it.
pub(super) struct Incidence(Vec<Vec<(usize, u32)>>);

impl Incidence {
    /// The panel on the left of a side.
    fn owner(&self, [a, b]: DirectedEdge) -> Option<usize> {
        let found = self.0[a as usize].iter().rfind(|(_, next)| *next == b);
        found.map(|(f, _)| *f)
    }

    /// The panels on the left and right of a side.
    pub fn beside(&self, [a, b]: DirectedEdge) -> Option<[usize; 2]> {
        Some([self.owner([a, b])?, self.owner([b, a])?])
    }

    pub fn faces_at(&self, v: u32) -> impl Iterator<Item = usize> {
        self.0[v as usize].iter().map(|(f, _)| *f)
    }

    pub fn sides(&self) -> impl Iterator<Item = DirectedEdge> {
        let at = self.0.iter().enumerate();
        at.flat_map(|(a, faces)| faces.iter().map(move |(_, b)| [a as u32, *b]))
    }
}

/// The panels that take part in a turn of the edge from `u` to `v`.
struct Turn {
    left: usize,
    right: usize,
    at_u: usize,
    at_v: usize,
}

/// The corners from one of them on.
fn from(face: &[u32], x: u32) -> Vec<u32> {
    let k = face
        .iter()
        .position(|y| *y == x)
        .expect("a corner of the panel");
    face[k..].iter().chain(&face[..k]).copied().collect()
}

fn insert_between(face: &mut Vec<u32>, a: u32, b: u32, new: u32) {
    let k = face
        .iter()
        .position(|y| *y == a)
        .expect("a corner of the panel");
    debug_assert_eq!(face[(k + 1) % face.len()], b);
    face.insert(k + 1, new);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::{BTreeMap, BTreeSet};

    /// A piece of a honeycomb, all panels open but those at its rim.
    fn honeycomb(n: i32) -> Draft {
        let mut corner: BTreeMap<(i32, i32), u32> = BTreeMap::new();
        let (mut places, mut faces, mut open) = (Vec::new(), Vec::new(), Vec::new());
        let root = 3.0_f64.sqrt();
        for j in -n..=n {
            for i in -n..=n {
                let centre = [
                    root * (f64::from(i) + 0.5 * f64::from(j)),
                    1.5 * f64::from(j),
                ];
                let ring = (0..6).map(|k| {
                    let angle = std::f64::consts::FRAC_PI_3 * (f64::from(k) + 0.5);
                    let (x, y) = (centre[0] + angle.cos(), centre[1] + angle.sin());
                    let key = ((x * 100.0).round() as i32, (y * 100.0).round() as i32);
                    let next = places.len() as u32;
                    *corner.entry(key).or_insert_with(|| {
                        places.push(Vec3::new(x, y, 0.0));
                        next
                    })
                });
                faces.push(ring.collect());
                open.push(i.abs() < n && j.abs() < n);
            }
        }
        Draft {
            on_boundary: vec![false; places.len()],
            origin: (0..faces.len()).collect(),
            faces,
            places,
            open,
        }
    }

    fn middle(draft: &Draft) -> usize {
        draft.faces.len() / 2
    }

    /// Panels as sets of corners, whatever their order.
    fn panels(draft: &Draft) -> BTreeSet<BTreeSet<u32>> {
        let faces = draft.faces.iter().filter(|f| !f.is_empty());
        faces.map(|f| f.iter().copied().collect()).collect()
    }

    fn lengths(draft: &Draft) -> Vec<usize> {
        let mut lengths: Vec<usize> = draft
            .faces
            .iter()
            .map(Vec::len)
            .filter(|n| *n != 6)
            .collect();
        lengths.sort_unstable();
        lengths
    }

    #[test]
    fn a_turned_edge_makes_two_pentagons_and_two_heptagons_and_turns_back() {
        let draft = honeycomb(3);
        let (side, _) = draft.neighbours(middle(&draft))[0];
        let turned = draft.turned(side).unwrap();
        assert_eq!(lengths(&turned), [5, 5, 7, 7]);
        assert!(turned.topology().is_some(), "still an oriented manifold");
        assert!(lengths(&turned.calmed()).is_empty());
    }

    #[test]
    fn a_merge_takes_two_corners_and_a_split_brings_two() {
        let draft = honeycomb(3);
        let f = middle(&draft);
        let (side, g) = draft.neighbours(f)[0];
        let merged = draft.merged(side).unwrap();
        assert_eq!((merged.faces[f].len(), merged.faces[g].len()), (8, 0));
        assert!(merged.topology().is_some());
        let split = draft.split(f, 0, 3).unwrap();
        assert_eq!(split.places.len(), draft.places.len() + 2);
        assert_eq!(lengths(&split), [5, 5, 7, 7]);
        assert!(split.topology().is_some());
        let [a, b] = [split.faces.len() - 1, f];
        let cut = split
            .neighbours(a)
            .into_iter()
            .find(|(_, h)| *h == b)
            .unwrap()
            .0;
        assert_eq!(panels(&split.merged(cut).unwrap()), panels(&draft));
    }

    #[test]
    fn what_is_closed_keeps_its_corners() {
        let draft = honeycomb(2);
        let closed = |f: &usize| !draft.open[*f];
        for f in 0..draft.faces.len() {
            for (side, _) in draft.neighbours(f) {
                for next in [draft.turned(side), draft.merged(side)]
                    .into_iter()
                    .flatten()
                {
                    let faces = (0..draft.faces.len()).filter(closed);
                    faces.for_each(|g| assert_eq!(next.faces[g], draft.faces[g]));
                }
            }
        }
    }
}
