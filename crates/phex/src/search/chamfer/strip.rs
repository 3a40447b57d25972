//! Strips in the place of runs.

use super::super::draft::{DirectedEdge, Draft};
use super::{FoldRun, REACH};
use phex_mesh::Vec3;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Share of an edge that meets the end of a run, after which a strip ends at the farthest: another
/// strip may end on the same edge.
const REACH_OF_END: f64 = 1.0 / 3.0;
/// Share of an edge of a run that must lie between vertices beside it for an edge across the strip,
/// and share of that place that is kept free on either side.
const LEAST_ROOM: f64 = 0.1;
const MARGIN: f64 = 0.2;
/// Distance of a run's vertices to the chord of a panel of the strip, in widths, above which the
/// panel has fewer of them.
const BEND: f64 = 0.5;
/// Share of a strip's width that is left for the chord of its panel across a bend of the run.
const CHORD: f64 = 0.3;
/// Vertices of a run that one panel of its strip has.
const PER_PANEL: usize = 2;

/// One edge of a run: the panels on its left and right, the ways into them, at right angles to the
/// edge, and the width of the strip there.
pub(super) struct CreaseEdge {
    pub faces: [usize; 2],
    pub inwards: [Vec3; 2],
    pub width: f64,
}

/// An edge across a strip: where on an edge of the run, as a share of it, and half of its length.
struct StripEdge {
    edge: usize,
    share: f64,
    width: f64,
}

/// What takes the place of a vertex of a run, or of the middle of one of its edges, on the left and
/// on the right of it.
type SidePair = [Option<u32>; 2];

/// A strip while it is laid along a run.
pub(super) struct ChamferStrip<'a> {
    old: &'a Draft,
    next: Draft,
    run: FoldRun,
    edges: Vec<CreaseEdge>,
    /// By vertex of the run.
    at: Vec<SidePair>,
    /// Edges across the strip, by edge of the run, from its first vertex on.
    across: Vec<Vec<SidePair>>,
}

impl<'a> ChamferStrip<'a> {
    /// The new vertices; `None` where a vertex of the run does not have three panels.
    pub fn new(old: &'a Draft, run: FoldRun, edges: Vec<CreaseEdge>) -> Option<Self> {
        let (n, m) = (run.vertices.len(), edges.len());
        let mut strip = Self {
            old,
            next: old.clone(),
            at: vec![SidePair::default(); n],
            across: vec![Vec::new(); m],
            run,
            edges,
        };
        for k in 0..n {
            let ends = !strip.run.is_closed && (k == 0 || k + 1 == n);
            let (before, after) = ((k + m - 1) % m, k % m);
            for side in 0..2 {
                let [f, g] = [before, after].map(|e| strip.edges[e].faces[side]);
                if ends || f != g {
                    let edge = if ends && k > 0 { before } else { after };
                    strip.at[k][side] = Some(strip.beside(k, edge, side)?);
                }
            }
            let sides = strip.at[k].iter().flatten().count();
            (sides == if ends { 2 } else { 1 }).then_some(())?;
        }
        let crossings = strip.crossings();
        (!strip.run.is_closed || crossings.len() > 1).then_some(())?;
        for crossing in crossings {
            let on_edge = strip.on_edge(crossing.edge, crossing.share);
            let inwards = strip.edges[crossing.edge].inwards;
            let places = inwards.map(|inwards| on_edge + inwards * crossing.width);
            let pair = places.map(|place| Some(strip.added(place, false)));
            strip.across[crossing.edge].push(pair);
        }
        Some(strip)
    }

    /// A point of an edge of the run.
    fn on_edge(&self, e: usize, share: f64) -> Vec3 {
        let n = self.run.vertices.len();
        let [a, b] = [e, (e + 1) % n].map(|k| self.old.place(self.run.vertices[k]));
        a + (b - a) * share
    }

    /// Where edges go across the strip, such that panels have two vertices of the run each, but one
    /// where it bends so much that the chord would cut it short.
    fn crossings(&self) -> Vec<StripEdge> {
        let m = self.edges.len();
        let ways: Vec<Vec3> = (0..m)
            .map(|e| self.on_edge(e, 1.0) - self.on_edge(e, 0.0))
            .collect();
        let bends = self.bends(&ways);
        let bent = (0..m).find(|e| self.run.is_closed && bends[*e][0].is_some());
        let first = bent.unwrap_or(0);
        let mut found = Vec::new();
        // The last edge across, or the end of the strip, and the vertices of the run since then.
        let mut last = (!self.run.is_closed).then(|| self.on_edge(0, 0.0));
        let mut since: Vec<Vec3> = Vec::new();
        for step in 0..m {
            let edge = (first + step) % m;
            if step > 0 {
                since.push(self.on_edge(edge, 0.0));
            }
            let [low, high] = self.room(edge, &ways);
            let chord = last.map(|last| self.on_edge((edge + 1) % m, 0.5) - last);
            let bends_on = last.zip(chord).is_some_and(|(last, chord)| {
                let way = chord.try_normalize(0.0).unwrap_or_default();
                let reached = since.iter().copied().chain([self.on_edge(edge, 1.0)]);
                let off = reached.map(|p| (p - last).cross(&way).norm());
                off.fold(0.0, f64::max) > BEND * self.edges[edge].width
            });
            let starts = last.is_none();
            let is_due = (starts || since.len() >= PER_PANEL || bends_on) && step + 1 < m;
            let middle = [0.5 * (low + high), self.edges[edge].width];
            let here: Vec<[f64; 2]> = match bends[edge] {
                _ if high - low < LEAST_ROOM => Vec::new(),
                [None, None] if is_due => vec![middle],
                [Some(a), Some(b)] if a[0] >= b[0] => vec![[middle[0], a[1].min(b[1])]],
                bends => bends.into_iter().flatten().collect(),
            };
            let margin = MARGIN * (high - low).min(self.edges[edge].width / ways[edge].norm());
            for [share, width] in here {
                let share = share.clamp(low + margin, high - margin);
                last = Some(self.on_edge(edge, share));
                since.clear();
                found.push(StripEdge { edge, share, width });
            }
        }
        found.sort_by_key(|crossing| crossing.edge);
        found
    }

    /// For each edge of a run, shares and widths of crossings after a bend at its start and before
    /// one at its end.
    fn bends(&self, ways: &[Vec3]) -> Vec<[Option<[f64; 2]>; 2]> {
        let (n, m) = (self.run.vertices.len(), self.edges.len());
        let inner = if self.run.is_closed { 0..n } else { 1..n - 1 };
        let mut bends = vec![[None; 2]; m];
        for k in inner {
            let [before, after] = [(k + m - 1) % m, k];
            let lengths = [before, after].map(|e| ways[e].norm());
            let width = self.edges[before].width.min(self.edges[after].width);
            let half = FRAC_PI_2 - 0.5 * ways[before].angle(&ways[after]);
            // The chord from the middle of one edge to that of the other lies so far from the
            // vertex; offsets of the edges by a width meet at the width over the sine.
            if 0.5 * lengths[0].min(lengths[1]) * half.cos() > width {
                let inner = (1.0 - CHORD) * width;
                let narrow = inner * half.sin();
                let distance = inner * half.cos() + CHORD * width / half.cos();
                bends[before][1] = Some([1.0 - distance / lengths[0], narrow]);
                bends[after][0] = Some([distance / lengths[1], narrow]);
            }
        }
        bends
    }

    /// Between which shares of an edge of the run an edge across the strip lies beside no vertex on
    /// either side: edges that meet the run aslant leave the strip before or after their vertex.
    fn room(&self, edge: usize, ways: &[Vec3]) -> [f64; 2] {
        let (n, m) = (self.run.vertices.len(), ways.len());
        let along = ways[edge].normalize();
        let mut room = [f64::NEG_INFINITY, f64::INFINITY];
        for side in 0..2 {
            let mut before = (0..m).map(|i| (edge + n - i) % n);
            let mut after = (0..m).map(|i| (edge + 1 + i) % n);
            let place = |k: usize| self.at[k][side].map(|v| self.next.place(v));
            let from = self.on_edge(edge, 0.0);
            let share = |p: Vec3| (p - from).dot(&along) / ways[edge].norm();
            room[0] = before
                .find_map(place)
                .map_or(room[0], |p| room[0].max(share(p)));
            room[1] = after
                .find_map(place)
                .map_or(room[1], |p| room[1].min(share(p)));
        }
        room
    }

    fn added(&mut self, place: Vec3, on_boundary: bool) -> u32 {
        self.next.places.push(place);
        self.next.on_boundary.push(on_boundary);
        self.next.places.len() as u32 - 1
    }

    /// A vertex on the edge that meets the run at its vertex `k`, on a side of its edge `e`.
    fn beside(&mut self, k: usize, e: usize, side: usize) -> Option<u32> {
        let v = self.run.vertices[k];
        let edge = &self.edges[e];
        let face = &self.old.faces[edge.faces[side]];
        let at = face.iter().position(|x| *x == v)?;
        // The edge of the run goes from `v` on, in the panel on its left, if it comes after it.
        let comes_after = e == k;
        let step = if comes_after == (side == 0) {
            face.len() - 1
        } else {
            1
        };
        let way = self.old.place(face[(at + step) % face.len()]) - self.old.place(v);
        let height = way.dot(&edge.inwards[side]);
        let n = self.run.vertices.len();
        let ends = !self.run.is_closed && (k == 0 || k + 1 == n);
        let reach = if ends { REACH_OF_END } else { REACH };
        let share = match height > 0.0 {
            true => (edge.width / height).min(reach),
            false => reach,
        };
        let place = self.old.place(v) + way * share;
        Some(self.added(place, self.old.on_boundary[v as usize]))
    }

    /// The panels with the strip.
    pub fn laid(mut self) -> Option<Draft> {
        let vertices = self.run.vertices.iter().enumerate();
        let number: BTreeMap<u32, usize> = vertices.map(|(k, v)| (*v, k)).collect();
        let edges: BTreeMap<DirectedEdge, usize> = self
            .run
            .edges()
            .enumerate()
            .map(|(e, side)| (side, e))
            .collect();
        for f in 0..self.old.faces.len() {
            let face = &self.old.faces[f];
            if face.iter().any(|v| number.contains_key(v)) {
                self.next.faces[f] = self.replaced(face, &number, &edges)?;
            }
        }
        self.add_panels();
        Some(self.next)
    }

    /// Corners of a panel beside the run or at one of its ends.
    fn replaced(
        &self,
        face: &[u32],
        number: &BTreeMap<u32, usize>,
        edges: &BTreeMap<DirectedEdge, usize>,
    ) -> Option<Vec<u32>> {
        let n = face.len();
        let mut corners = Vec::with_capacity(n + 2);
        for (i, &v) in face.iter().enumerate() {
            let [before, after] = [face[(i + n - 1) % n], face[(i + 1) % n]];
            let Some(&k) = number.get(&v) else {
                corners.push(v);
                continue;
            };
            let is_run = |side: DirectedEdge| edges.contains_key(&side);
            let left = is_run([before, v]) || is_run([v, after]);
            let right = is_run([v, before]) || is_run([after, v]);
            let cut = self.at[k];
            match (left, right) {
                (true, true) => return None,
                (true, false) => corners.extend(cut[0]),
                (false, true) => corners.extend(cut[1]),
                // A panel in which the strip ends goes from its right to its left at the first
                // vertex, and the other way at the last.
                (false, false) if k == 0 => corners.extend([cut[1]?, cut[0]?]),
                (false, false) => corners.extend([cut[0]?, cut[1]?]),
            }
            if let Some(e) = edges.get(&[v, after]) {
                corners.extend(self.across[*e].iter().filter_map(|pair| pair[0]));
            }
            if let Some(e) = edges.get(&[after, v]) {
                corners.extend(self.across[*e].iter().rev().filter_map(|pair| pair[1]));
            }
        }
        (corners.len() > 2).then_some(corners)
    }

    /// The panels of the strip itself, from one edge across it to the next.
    fn add_panels(&mut self) {
        let n = self.run.vertices.len();
        let mut cuts: Vec<(SidePair, usize)> = Vec::new();
        for k in 0..n {
            cuts.push((self.at[k], k.min(self.edges.len() - 1)));
            let across = self.across.get(k).into_iter().flatten();
            cuts.extend(across.map(|pair| (*pair, k)));
        }
        if self.run.is_closed {
            // From the first edge across round to it again.
            let first = cuts.iter().position(is_whole).unwrap_or(0);
            cuts.rotate_left(first);
            cuts.push(cuts[0]);
        }
        let extend = |lines: &mut [Vec<u32>; 2], (cut, _): &(SidePair, usize)| {
            let both = lines.iter_mut().zip(cut);
            both.for_each(|(line, v)| line.extend(v));
        };
        let mut lines: [Vec<u32>; 2] = Default::default();
        for (i, cut) in cuts.iter().enumerate() {
            extend(&mut lines, cut);
            if i > 0 && is_whole(cut) {
                let [mut corners, right] = std::mem::take(&mut lines);
                corners.reverse();
                corners.extend(right);
                self.next.faces.push(corners);
                self.next.open.push(true);
                let beside = self.edges[cut.1].faces[0];
                self.next.origin.push(self.old.origin[beside]);
                extend(&mut lines, cut);
            }
        }
    }
}

/// Whether something lies on both sides: an edge across the strip, or an end of it.
fn is_whole(cut: &(SidePair, usize)) -> bool {
    cut.0.iter().all(Option::is_some)
}
