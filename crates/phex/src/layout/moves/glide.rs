//! Short sequences of turned edges that make panels more regular though their first steps do not.
//!
//! A pentagon and a heptagon side by side are a dislocation; turning an edge beside it lets it
//! glide by one panel at no cost. Gliding into a cone or into its opposite it vanishes. The search
//! is exhaustive up to a few steps round each irregular panel, on the dual triangulation, where a
//! turn is an edge flip. In a symmetric mesh an edge turns together with all its images.

use phex_mesh::{FaceId, PerFace, Topology};
use std::collections::{BTreeMap, BTreeSet};

/// Most steps of a sequence.
const STEPS: usize = 4;
/// Rings of panels round an irregular one that a sequence may change.
const REACH: usize = 4;
/// Least and largest number of corners on the way.
const CORNERS: [usize; 2] = [4, 8];

/// Most steps of a sequence that follows two panels' becoming one.
const STEPS_AFTER_JOIN: usize = 3;

/// Panels on the sides of an edge that turns.
pub(crate) type Sides = [FaceId; 2];

/// The image of each panel under each element of a group but the identity: none for a mesh that
/// need not be symmetric.
pub(crate) type PanelImages = [PerFace<FaceId>];

/// Turns after which the panels inside are more regular than before, if first the second of `sides`
/// becomes part of the first, with the panels that all that changes; `None` if there are none
/// beside the panels in `taken`.
pub(crate) fn turns_after_join(
    topology: &Topology,
    sides: Sides,
    taken: &BTreeSet<FaceId>,
) -> Option<(Vec<Sides>, BTreeSet<FaceId>)> {
    let mut patch = DualPatch::around(topology, sides[0], taken, &[]);
    let [Some(a), Some(b)] = sides.map(|f| patch.number(f)) else {
        return None;
    };
    let gain = patch.join([a, b])?;
    if gain + patch.most_gain() <= 0 {
        return None;
    }
    let mut path = Vec::new();
    let mut found = |steps| patch.search(steps, gain, gain.min(0), &mut path);
    if !(0..=STEPS_AFTER_JOIN).any(&mut found) {
        return None;
    }
    let mut changed = patch.changed(topology, &path);
    for f in sides {
        changed.insert(f);
        changed.extend(topology.adjacent_faces(f));
    }
    Some((path, changed))
}

/// Sequences of turns, each of which makes the panels inside more regular; no two of them change
/// the same panel.
pub(crate) fn sequences(topology: &Topology) -> Vec<Vec<Sides>> {
    sequences_beside(topology, BTreeSet::new(), &[])
}

/// The same where some panels must stay as they are, and where edges turn with all their images:
/// of a sequence and its images one is given.
pub(crate) fn sequences_beside(
    topology: &Topology,
    mut taken: BTreeSet<FaceId>,
    images: &PanelImages,
) -> Vec<Vec<Sides>> {
    let first = |f: &FaceId| images.iter().all(|of| *f <= of[*f]);
    let irregular = |f: &FaceId| !topology.is_boundary_face(*f) && topology.valence(*f) != 6;
    let mut found = Vec::new();
    for f in topology.faces().filter(irregular).filter(first) {
        let mut patch = DualPatch::around(topology, f, &taken, images);
        let most = if patch.most_gain() > 0 { STEPS } else { 0 };
        for steps in 1..=most {
            let mut path = Vec::new();
            if patch.search(steps, 0, 0, &mut path) {
                for path in with_images(&path, images) {
                    taken.extend(patch.changed(topology, &path));
                }
                found.push(path);
                break;
            }
        }
    }
    found
}

/// A sequence and all its images.
pub(super) fn with_images<'a>(
    path: &'a [Sides],
    images: &'a PanelImages,
) -> impl Iterator<Item = Vec<Sides>> + 'a {
    let image = |of: &PerFace<FaceId>| path.iter().map(|s| s.map(|f| of[f])).collect();
    std::iter::once(path.to_vec()).chain(images.iter().map(image))
}

/// A piece of the dual triangulation, its panels numbered in their order.
struct DualPatch {
    names: Vec<FaceId>,
    /// The neighbours of each panel in the order of its outline; none of those that stay as they
    /// are.
    ring: Vec<Vec<usize>>,
    /// The image of each panel under each element of a group but the identity.
    images: Vec<Vec<usize>>,
}

/// Numbers of panels on the sides of an edge, or at its ends.
type DualEdge = [usize; 2];

/// The panels on the sides of an edge that turns, and those at its ends.
type DualTurn = [DualEdge; 2];

impl DualPatch {
    /// The panels inside within reach of `centre`, or of one of its images, without those in
    /// `taken`.
    fn around(
        topology: &Topology,
        centre: FaceId,
        taken: &BTreeSet<FaceId>,
        images: &PanelImages,
    ) -> Self {
        let mut around: BTreeMap<FaceId, Vec<FaceId>> = BTreeMap::new();
        let mut front: Vec<FaceId> = images.iter().map(|of| of[centre]).chain([centre]).collect();
        for _ in 0..=REACH {
            let mut next = Vec::new();
            for f in front {
                let free = !topology.is_boundary_face(f) && !taken.contains(&f);
                if !free || around.contains_key(&f) {
                    continue;
                }
                let ring: Vec<FaceId> = topology.adjacent_faces(f).collect();
                next.extend(&ring);
                around.insert(f, ring);
            }
            front = next;
        }
        let seen = around.iter().flat_map(|(f, ring)| ring.iter().chain([f]));
        let names: BTreeSet<FaceId> = seen.copied().collect();
        let names: Vec<FaceId> = names.into_iter().collect();
        let number = |f: &FaceId| names.binary_search(f).expect("a panel that was seen");
        let ring = |f: &FaceId| around.get(f).into_iter().flatten().map(number).collect();
        let numbers = |of: &PerFace<FaceId>| names.iter().map(|f| number(&of[*f])).collect();
        Self {
            ring: names.iter().map(ring).collect(),
            images: images.iter().map(numbers).collect(),
            names,
        }
    }

    fn number(&self, f: FaceId) -> Option<usize> {
        self.names.binary_search(&f).ok()
    }

    fn name(&self, pair: DualEdge) -> Sides {
        pair.map(|f| self.names[f])
    }

    fn corners(&self, f: usize) -> usize {
        self.ring[f].len()
    }

    fn is_known(&self, f: usize) -> bool {
        !self.ring[f].is_empty()
    }

    fn irregular(&self) -> impl Iterator<Item = usize> {
        (0..self.ring.len()).filter(|f| self.is_known(*f) && self.corners(*f) != 6)
    }

    /// What any turns may gain at the most: they leave the sum of the panels' corners as it is,
    /// and it is least irregular with as many pentagons, or heptagons, as the sum asks for.
    fn most_gain(&self) -> i32 {
        let known = (0..self.ring.len()).filter(|f| self.is_known(*f));
        let odd = known.map(|f| self.corners(f) as i32 - 6);
        let (now, sum) = odd.fold((0, 0), |(now, sum), x| (now + x * x, sum + x));
        now - i32::abs(sum)
    }

    /// Looks for a sequence of at most `steps` turns more whose gain, with the `gain` so far, is
    /// positive, and never less than `floor` on the way.
    fn search(&mut self, steps: usize, gain: i32, floor: i32, path: &mut Vec<Sides>) -> bool {
        if gain > 0 {
            return true;
        }
        if steps == 0 {
            return false;
        }
        for sides in self.candidates() {
            let Some((turns, change)) = self.turn_all(sides, floor - gain) else {
                continue;
            };
            path.push(self.name(sides));
            if self.search(steps - 1, gain + change, floor, path) {
                return true;
            }
            path.pop();
            self.turn_back(&turns);
        }
        false
    }

    /// Turns an edge and all its images, and tells what that gains; `None`, and nothing has
    /// changed, if one of them can't turn or it gains less than `least`.
    fn turn_all(&mut self, sides: DualEdge, least: i32) -> Option<(Vec<DualTurn>, i32)> {
        let (_, first) = self.turn_at(sides)?;
        if self.images.is_empty() && first < least {
            return None;
        }
        let all = self.with_images(sides)?;
        let (mut turns, mut gain) = (Vec::new(), 0);
        for sides in all {
            let Some((ends, change)) = self.turn_at(sides) else {
                self.turn_back(&turns);
                return None;
            };
            self.turn(sides, ends);
            turns.push([sides, ends]);
            gain += change;
        }
        if gain < least {
            self.turn_back(&turns);
            return None;
        }
        Some((turns, gain))
    }

    fn turn_back(&mut self, turns: &[DualTurn]) {
        for [sides, ends] in turns.iter().rev() {
            self.turn(*ends, [sides[1], sides[0]]);
        }
    }

    /// An edge and its images; `None` if two of them have a corner in common, so that the order in
    /// which they turn would matter.
    fn with_images(&self, sides: DualEdge) -> Option<Vec<DualEdge>> {
        let mut all = vec![sides];
        for of in &self.images {
            let image = sides.map(|f| of[f]);
            if all.iter().any(|other| self.meet(*other, image)) {
                return None;
            }
            if !all.iter().any(|other| is_same(*other, image)) {
                all.push(image);
            }
        }
        Some(all)
    }

    /// Whether two edges have a corner in common.
    fn meet(&self, one: DualEdge, other: DualEdge) -> bool {
        let beyond = |[a, b]: DualEdge, f: usize| if a == f { b } else { a };
        let shared = one.into_iter().find(|f| other.contains(f));
        shared.filter(|_| !is_same(one, other)).is_some_and(|f| {
            let (ring, n) = (&self.ring[f], self.ring[f].len());
            let place = |g: usize| ring.iter().position(|x| *x == g);
            match (place(beyond(one, f)), place(beyond(other, f))) {
                (Some(i), Some(k)) => (i + 1) % n == k || (k + 1) % n == i,
                _ => false,
            }
        })
    }

    /// Edges whose turn takes a corner from a panel with many or gives one to a panel with few.
    fn candidates(&self) -> Vec<DualEdge> {
        let mut list = Vec::new();
        let first = |f: &usize| self.images.iter().all(|of| *f <= of[*f]);
        for f in self.irregular().filter(first) {
            let ring = &self.ring[f];
            for (i, &g) in ring.iter().enumerate() {
                let next = ring[(i + 1) % ring.len()];
                list.push(if ring.len() > 6 { [f, g] } else { [g, next] });
            }
        }
        list
    }

    /// The panels at the ends of the edge between two panels, and what its turn gains; `None` if it
    /// can't turn.
    fn turn_at(&self, [a, b]: DualEdge) -> Option<(DualEdge, i32)> {
        let at = |f: usize, g: usize| self.ring[f].iter().position(|x| *x == g);
        let (i, _) = (at(a, b)?, at(b, a)?);
        let ring = &self.ring[a];
        let n = ring.len();
        let ends = [ring[(i + n - 1) % n], ring[(i + 1) % n]];
        let [c, d] = ends;
        let known = ends.iter().all(|f| self.is_known(*f));
        if !known || c == d || at(c, d).is_some() {
            return None;
        }
        // Panels that touch twice are left alone.
        let pairs = [(a, b), (a, c), (a, d), (b, c), (b, d)];
        let once = |f: usize, g: usize| self.ring[f].iter().filter(|x| **x == g).count() == 1;
        if !pairs.iter().all(|&(f, g)| once(f, g) && once(g, f)) {
            return None;
        }
        let mut gain = 0;
        for (f, change) in [(a, -1), (b, -1), (ends[0], 1), (ends[1], 1)] {
            let before = self.corners(f) as i32;
            let after = before + change;
            let is_allowed = (CORNERS[0] as i32..=CORNERS[1] as i32).contains(&after);
            if !is_allowed && (after - 6).abs() > (before - 6).abs() {
                return None;
            }
            gain += (before - 6).pow(2) - (after - 6).pow(2);
        }
        Some((ends, gain))
    }

    /// Makes `b` part of `a`; what that gains, or `None` if a panel would have too many corners or
    /// too few.
    fn join(&mut self, [a, b]: DualEdge) -> Option<i32> {
        let ([c, d], _) = self.turn_at([a, b])?;
        let behind = |ring: &[usize], f: usize| -> Vec<usize> {
            let at = ring.iter().position(|x| *x == f).expect("a neighbour");
            (1..ring.len())
                .map(|k| ring[(at + k) % ring.len()])
                .collect()
        };
        let mut ring = behind(&self.ring[a], b);
        let others = behind(&self.ring[b], a);
        let inner = &others[1..others.len() - 1];
        ring.extend(inner);
        let irregular = |n: usize| (n as i32 - 6).pow(2);
        let sum = |patch: &Self, faces: &[usize]| -> i32 {
            faces.iter().map(|f| irregular(patch.corners(*f))).sum()
        };
        let before = sum(self, &[a, b, c, d]);
        for f in inner {
            if !self.is_known(*f) {
                return None;
            }
            self.ring[*f]
                .iter_mut()
                .filter(|x| **x == b)
                .for_each(|x| *x = a);
        }
        for f in [c, d] {
            self.ring[f].retain(|x| *x != b);
        }
        self.ring[a] = ring;
        self.ring[b].clear();
        let allowed = [a, c, d]
            .iter()
            .all(|f| (CORNERS[0]..=CORNERS[1]).contains(&self.corners(*f)));
        allowed.then(|| before - sum(self, &[a, c, d]))
    }

    /// Parts `a` and `b` and joins the panels at the ends, of which the first precedes `b` round
    /// `a`.
    fn turn(&mut self, [a, b]: DualEdge, [c, d]: DualEdge) {
        self.ring[a].retain(|x| *x != b);
        self.ring[b].retain(|x| *x != a);
        insert_after(&mut self.ring[c], b, d, a);
        insert_after(&mut self.ring[d], a, c, b);
    }

    /// Panels whose corners or neighbours a sequence changes.
    fn changed(&self, topology: &Topology, path: &[Sides]) -> BTreeSet<FaceId> {
        let sides = path.iter().flatten().copied();
        let now = |f: FaceId| self.number(f).into_iter().flat_map(|k| &self.ring[k]);
        sides
            .flat_map(|f| {
                let now = now(f).map(|g| self.names[*g]);
                topology
                    .adjacent_faces(f)
                    .chain([f])
                    .chain(now)
                    .collect::<Vec<_>>()
            })
            .collect()
    }
}

/// Whether two edges are the same, whichever of their sides is named first.
fn is_same([a, b]: DualEdge, other: DualEdge) -> bool {
    other == [a, b] || other == [b, a]
}

/// Puts `new` between `first` and `second`, which follow each other in one order or the other.
fn insert_after(ring: &mut Vec<usize>, first: usize, new: usize, second: usize) {
    let n = ring.len();
    let i = ring.iter().position(|x| *x == first).expect("a neighbour");
    let at = if ring[(i + 1) % n] == second {
        i + 1
    } else {
        i
    };
    ring.insert(at, new);
}
