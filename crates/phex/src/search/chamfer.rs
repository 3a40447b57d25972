//! Chamfers: a crease over which panels fold by more than a right angle is cut off, so that they
//! turn in two steps.
//!
//! Where a body is thinner than its panels, or has an edge like the sides of a blade, the edges of
//! a mesh over which panels fold lie one behind the other, as *runs*. A strip as steep to the one
//! side as to the other takes the place of a run: its two sides lie in the panels beside the run,
//! which stay as planar as before, and edges across divide it into a row of panels of its own, of
//! six corners each but for the last. Interior vertices still have three faces. The optimiser then
//! makes them planar.

use super::draft::{DirectedEdge, Draft, Incidence};
use phex_mesh::{FlatFace, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::FRAC_PI_2;

/// Width of a strip on either side of a run, as a share of the lower panel's height above it.
const WIDTH: f64 = 0.3;
/// Share of an edge that meets a run, after which a strip ends at the farthest.
const REACH: f64 = 0.45;
/// Runs that are cut off in one patch at the most.
const RUNS: usize = 64;
/// Vertices of a run that one panel of its strip has.
const PER_PANEL: usize = 2;

/// The panels with all folds cut off that panels of `core` have, or any panel of the patch if it is
/// `None`, by strips whose depth is at most `deepest`; the sharpest first. `None` where there is
/// none.
pub(super) fn chamfered(draft: &Draft, core: Option<&[usize]>, deepest: f64) -> Option<Draft> {
    let mut now = draft.clone();
    let mut tried: BTreeSet<DirectedEdge> = BTreeSet::new();
    let old = draft.faces.len();
    let counts = |f: usize| core.is_none_or(|core| core.contains(&f));
    for _ in 0..RUNS {
        let mut folds = now.folds();
        folds.retain(|fold| {
            fold.faces.iter().all(|f| *f < old)
                && fold.faces.iter().any(|f| counts(*f))
                && !tried.contains(&fold.side)
        });
        let sharpest =
            (folds.iter()).max_by(|a, b| a.angle.total_cmp(&b.angle).then(b.side.cmp(&a.side)));
        let Some(fold) = sharpest else { break };
        let run = FoldRun::through(&now, fold.side, &folds);
        tried.extend(run.edges().map(|[a, b]| [a.min(b), a.max(b)]));
        if let Some(next) = now.cut_off(run, deepest) {
            now = next;
        }
    }
    (now.faces.len() > old).then_some(now)
}

/// Two panels that turn by more than a right angle over an edge.
struct BladeEdge {
    side: DirectedEdge,
    faces: [usize; 2],
    angle: f64,
}

/// Edges one behind the other over which panels fold.
struct FoldRun {
    vertices: Vec<u32>,
    /// Whether the last vertex comes before the first one.
    is_closed: bool,
}

impl FoldRun {
    /// The longest run through a fold: it ends where more than two folds meet, or one does.
    fn through(draft: &Draft, side: DirectedEdge, folds: &[BladeEdge]) -> Self {
        let mut beside: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for [a, b] in folds.iter().map(|fold| fold.side) {
            beside.entry(a).or_default().push(b);
            beside.entry(b).or_default().push(a);
        }
        let incidence = draft.incidence();
        let inside = |v: u32| !draft.on_boundary[v as usize] && incidence.faces_at(v).count() == 3;
        let after = |from: u32, v: u32| match beside[&v][..] {
            [a, b] if inside(v) => Some(if a == from { b } else { a }),
            _ => None,
        };
        let mut vertices = side.to_vec();
        for _ in 0..2 {
            while let Some(next) = after(vertices[vertices.len() - 2], vertices[vertices.len() - 1])
            {
                if next == vertices[0] {
                    return Self {
                        vertices,
                        is_closed: true,
                    };
                }
                vertices.push(next);
            }
            vertices.reverse();
        }
        Self {
            vertices,
            is_closed: false,
        }
    }

    fn edges(&self) -> impl Iterator<Item = DirectedEdge> {
        let n = self.vertices.len();
        let count = if self.is_closed { n } else { n - 1 };
        (0..count).map(move |k| [self.vertices[k], self.vertices[(k + 1) % n]])
    }
}

/// One edge of a run: the panels on its left and right, the ways into them, at right angles to the
/// edge, and the width of the strip there.
struct CreaseEdge {
    faces: [usize; 2],
    inwards: [Vec3; 2],
    width: f64,
    middle: Vec3,
}

/// What takes the place of a vertex of a run, or of the middle of one of its edges, on the left and
/// on the right of it.
type SidePair = [Option<u32>; 2];

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
            let open = faces.iter().all(|f| self.open[*f]);
            (open && angle > FRAC_PI_2).then_some(BladeEdge { side, faces, angle })
        };
        sides.filter_map(fold).collect()
    }

    fn flat(&self, face: &[u32]) -> FlatFace {
        let corners: Vec<Vec3> = face.iter().map(|v| self.places[*v as usize]).collect();
        FlatFace::new(&corners)
    }

    fn place(&self, v: u32) -> Vec3 {
        self.places[v as usize]
    }

    /// The panels with a run cut off, or what of it can be; `None` if that is nothing.
    fn cut_off(&self, mut run: FoldRun, deepest: f64) -> Option<Self> {
        let incidence = self.incidence();
        if !run.is_closed {
            while !self.can_end(&incidence, [run.vertices[0], run.vertices[1]]) {
                run.vertices.remove(0);
                (run.vertices.len() > 1).then_some(())?;
            }
            while let [.., before, last] = run.vertices[..]
                && !self.can_end(&incidence, [last, before])
            {
                run.vertices.pop();
            }
            (run.vertices.len() > 1).then_some(())?;
        }
        let edges: Vec<CreaseEdge> = (run.edges())
            .map(|side| self.run_edge(&incidence, side, deepest))
            .collect::<Option<_>>()?;
        ChamferStrip::new(self, run, edges)?.laid()
    }

    /// Whether a strip can end at the first vertex of a side: in one panel that may change, or at
    /// the boundary.
    fn can_end(&self, incidence: &Incidence, side: DirectedEdge) -> bool {
        let Some(faces) = incidence.beside(side) else {
            return false;
        };
        let others = || incidence.faces_at(side[0]).filter(|f| !faces.contains(f));
        others().count() < 2 && others().all(|f| self.open[f])
    }

    fn run_edge(
        &self,
        incidence: &Incidence,
        side: DirectedEdge,
        deepest: f64,
    ) -> Option<CreaseEdge> {
        let faces = incidence.beside(side)?;
        let [a, b] = side.map(|v| self.place(v));
        let along = (b - a).try_normalize(0.0)?;
        let normals = faces.map(|f| self.flat(&self.faces[f]).normal());
        let inwards = [normals[0].cross(&along), along.cross(&normals[1])];
        let height = |k: usize| {
            let corners = self.faces[faces[k]].iter();
            let heights = corners.map(|v| (self.place(*v) - a).dot(&inwards[k]));
            heights.fold(0.0, f64::max)
        };
        let half_turn = 0.5 * normals[0].angle(&normals[1]);
        let width = (WIDTH * height(0).min(height(1))).min(deepest / half_turn.sin());
        (width > 0.0).then_some(CreaseEdge {
            faces,
            inwards,
            width,
            middle: (a + b) * 0.5,
        })
    }
}

/// A strip while it is laid along a run.
struct ChamferStrip<'a> {
    old: &'a Draft,
    next: Draft,
    run: FoldRun,
    edges: Vec<CreaseEdge>,
    /// By vertex of the run.
    at: Vec<SidePair>,
    /// By edge of the run.
    across: Vec<SidePair>,
}

impl<'a> ChamferStrip<'a> {
    /// The new vertices; `None` where a vertex of the run does not have three panels.
    fn new(old: &'a Draft, run: FoldRun, edges: Vec<CreaseEdge>) -> Option<Self> {
        let (n, m) = (run.vertices.len(), edges.len());
        let mut strip = Self {
            old,
            next: old.clone(),
            at: vec![SidePair::default(); n],
            across: vec![SidePair::default(); m],
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
        let crossed = strip.crossed();
        (!strip.run.is_closed || crossed.len() > 1).then_some(())?;
        for e in crossed {
            for side in 0..2 {
                let edge = &strip.edges[e];
                let place = edge.middle + edge.inwards[side] * edge.width;
                strip.across[e][side] = Some(strip.added(place, false));
            }
        }
        Some(strip)
    }

    /// The edges of the run that have a panel of the strip on either side of their middle: between
    /// them it has two vertices each.
    fn crossed(&self) -> Vec<usize> {
        let n = self.run.vertices.len();
        match self.run.is_closed {
            true => (0..n - 1).step_by(PER_PANEL).collect(),
            false => (PER_PANEL..n - 2).step_by(PER_PANEL).collect(),
        }
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
        let share = if height > 0.0 {
            (edge.width / height).min(REACH)
        } else {
            REACH
        };
        let place = self.old.place(v) + way * share;
        Some(self.added(place, self.old.on_boundary[v as usize]))
    }

    /// The panels with the strip.
    fn laid(mut self) -> Option<Draft> {
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
                corners.extend(self.across[*e][0]);
            }
            if let Some(e) = edges.get(&[after, v]) {
                corners.extend(self.across[*e][1]);
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
            if let Some(across) = self.across.get(k) {
                cuts.push((*across, k));
            }
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
            let (mesh, folds, wrong) = built(&chamfered(&whole, None, f64::INFINITY).unwrap());
            assert_eq!((folds, wrong), (0, 0), "{half}");
            let topology = mesh.topology();
            assert_eq!(topology.euler_characteristic(), 2);
            assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
            let heights = phex_mesh::measure(&mesh).planarity.max;
            assert!(heights < 1e-14, "{heights}");
        }
    }

    /// Two rows of bricks that meet in a ridge, over which they turn by two right angles less that
    /// of which `half` is the tangent of the half; each of them is two long, but the first and the
    /// last one of the other side.
    fn ridge(half: f64) -> Draft {
        let (mut places, mut faces, mut on_boundary) = (Vec::new(), Vec::new(), Vec::new());
        let mut number = BTreeMap::new();
        let mut corner = |x: i32, y: i32| {
            *number.entry((x, y)).or_insert_with(|| {
                let (along, out) = (f64::from(x), f64::from(y));
                places.push(Vec3::new(along, 2.0 * half * out, -2.0 * out.abs()));
                on_boundary.push(y != 0 || !(2..=7).contains(&x));
                places.len() as u32 - 1
            })
        };
        for (side, first) in [(1, 0), (-1, 1)] {
            for x in (first..first + 8).step_by(2) {
                let ring = [(x, 0), (x + 1, 0), (x + 2, 0), (x + 2, side), (x, side)];
                let square = ring.map(|(x, y)| (x.clamp(1, 8), y));
                let mut face: Vec<u32> = square.iter().map(|&(x, y)| corner(x, y)).collect();
                face.dedup();
                if side < 0 {
                    face.reverse();
                }
                faces.push(face);
            }
        }
        Draft {
            open: vec![true; faces.len()],
            origin: (0..faces.len()).collect(),
            faces,
            places,
            on_boundary,
        }
    }

    #[test]
    fn a_run_of_folds_becomes_one_row_of_hexagons() {
        let whole = ridge(0.4);
        assert_eq!(built(&whole).1, 7);
        let cut = chamfered(&whole, None, f64::INFINITY).unwrap();
        let (mesh, folds, wrong) = built(&cut);
        assert_eq!((folds, wrong, mesh.topology().n_faces()), (0, 0, 11));
        assert!(phex_mesh::measure(&mesh).planarity.max < 1e-14);
        assert!(cut.faces[8..].iter().all(|face| face.len() == 6));
        let depth = |deepest: f64| {
            let cut = chamfered(&whole, None, deepest).unwrap();
            let new = cut.places[whole.places.len()..].iter();
            new.map(|p| -p.z).fold(0.0, f64::max)
        };
        assert!((depth(0.1) - 0.1).abs() < 1e-12, "{}", depth(0.1));
    }

    #[test]
    fn a_run_ends_before_what_may_not_change() {
        let mut part = ridge(0.4);
        part.open[7] = false;
        let cut = chamfered(&part, None, f64::INFINITY).unwrap();
        assert_eq!(cut.faces[7], part.faces[7]);
        let (mesh, folds, _) = built(&cut);
        assert!((1..=3).contains(&folds), "{folds}");
        assert_eq!(mesh.topology().boundary_loops().len(), 1);
    }

    #[test]
    fn a_closed_run_becomes_a_closed_row() {
        // Two pyramids over a polygon, whose panels are as wide as two of its sides, on one
        // pyramid one side on from those on the other.
        let n = 12_u32;
        let ring = |k: u32| {
            let turn = std::f64::consts::TAU * f64::from(k) / f64::from(n);
            Vec3::new(turn.cos(), turn.sin(), 0.0)
        };
        let mut places: Vec<Vec3> = (0..n).map(ring).collect();
        let mut faces: Vec<Vec<u32>> = Vec::new();
        for (first, up) in [(0, 1.0), (1, -1.0)] {
            let top = places.len() as u32;
            let crown =
                (0..n / 2).map(|k| ring(2 * k + first) * 0.5 + Vec3::new(0.0, 0.0, 0.2 * up));
            places.extend(crown);
            let around = |k: u32| (2 * k + first) % n;
            let oriented = |mut face: Vec<u32>| {
                if up < 0.0 {
                    face.reverse();
                }
                face
            };
            for k in 0..n / 2 {
                let next = (k + 1) % (n / 2);
                let [a, b, c] = [around(k), (around(k) + 1) % n, around(next)];
                faces.push(oriented(vec![a, b, c, top + next, top + k]));
            }
            faces.push(oriented((top..top + n / 2).collect()));
        }
        let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
        let whole = draft(places, &faces, false);
        assert_eq!(built(&whole).1, n as usize);
        let cut = chamfered(&whole, None, f64::INFINITY).unwrap();
        let mesh = built(&cut).0;
        let topology = mesh.topology();
        assert_eq!(topology.euler_characteristic(), 2);
        assert!(topology.vertices().all(|v| topology.face_degree(v) == 3));
        let row = &cut.faces[faces.len()..];
        assert!(row.len() == 6 && row.iter().all(|face| face.len() == 6));
        assert_eq!(built(&cut).1, 0);
    }

    #[test]
    fn a_blade_at_the_boundary_is_cut_to_it() {
        let cut = chamfered(&knife(), None, f64::INFINITY).unwrap();
        let (mesh, folds, wrong) = built(&cut);
        assert_eq!((folds, wrong, mesh.topology().n_faces()), (0, 0, 3));
        assert_eq!(mesh.topology().boundary_loops().len(), 1);
        assert!(cut.on_boundary[6..].iter().all(|at| *at));
    }

    #[test]
    fn what_is_closed_or_not_meant_stays() {
        let mut whole = wedge(0.5);
        let back = chamfered(&whole, Some(&[3]), f64::INFINITY).unwrap();
        assert!(built(&back).1 < 3, "the edges of the back, not the blade");
        whole.open = vec![false; 5];
        assert!(chamfered(&whole, None, f64::INFINITY).is_none());
        assert!(
            chamfered(&wedge(1.5), Some(&[0]), f64::INFINITY).is_none(),
            "no fold"
        );
    }
}
