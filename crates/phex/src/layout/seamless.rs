//! From lattice offsets to a lattice without dislocations, by moving Burgers vectors and one linear solve.
//!
//! Integer jumps `n` along edges say which lattice point of one vertex is the origin of the next. Round a triangle they
//! add up to a translation, its Burgers vector; a triangle without turn but with one is a dislocation (a 5|7 pair).
//! Changing the jumps along a dual path moves a Burgers vector to the path's end, where it meets its opposite, or a cone
//! or the boundary that absorbs it: `1 - w` is a unit of `Z[w]`, so a cone of one sixth absorbs *any* translation, and no
//! integer programming is needed. With jumps free of dislocations, `min sum w |z_i - R z_j - d + n|^2` is one linear solve.

use super::boundary::Pin;
use super::lattice::{Charts, Eisenstein, Plane, dot, rotate};
use super::waves::{self, Projector};
use crate::directions::intrinsic::{Distance, IntrinsicMesh};
use crate::directions::rosy::{push_block, solve};
use phex_mesh::{EdgeId, FaceId, PerEdge, PerFace, PerVertex, Topology};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// Lattice offsets and the integer jumps between them.
#[derive(Clone, Debug)]
pub struct Offsets {
    /// Position of the nearest lattice point in the chart of each vertex.
    pub position: PerVertex<Plane>,
    /// Jump along each edge: the target's lattice point is the origin's moved by it. Zero: both name the same point.
    pub jump: PerEdge<Eisenstein>,
}

impl Offsets {
    /// Jumps by rounding.
    pub fn rounded(topology: &Topology, charts: &Charts, position: PerVertex<Plane>) -> Self {
        let jump = PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            Eisenstein::nearest(charts.edge(e).apply(position[j]) - position[i])
        });
        Self { position, jump }
    }

    /// The same lattice, each vertex naming the point nearest to it.
    pub fn reduced(mut self, topology: &Topology, charts: &Charts) -> Self {
        let shift = self.position.map(|z| Eisenstein::nearest(*z));
        for e in topology.edges() {
            let [i, j] = topology.edge_vertices(e);
            self.jump[e] = self.jump[e] - shift[j].rotated(charts.edge(e).turn) + shift[i];
        }
        for (z, p) in self.position.iter_mut().zip(&shift) {
            *z -= p.to_plane();
        }
        self
    }

    /// Whether the ends of each edge name the same lattice point, or points nearer to each other than `distance`: the offsets
    /// about a cone do not close, so that a point beside it is seen twice.
    pub fn same_point(&self, topology: &Topology, charts: &Charts, distance: f64) -> PerEdge<bool> {
        PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            let apart = charts.edge(e).apply(self.position[j]) - self.position[i];
            self.jump[e] == Eisenstein::ZERO || apart.norm() < distance
        })
    }

    /// Largest and median distortion: what is left of the edges' offsets over their lengths, per edge.
    pub fn distortion(
        &self,
        topology: &Topology,
        mesh: &IntrinsicMesh,
        charts: &Charts,
    ) -> PerEdge<f64> {
        PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            let rest =
                charts.edge(e).apply(self.position[j]) - self.jump[e].to_plane() - self.position[i];
            rest.norm() / mesh.length[e]
        })
    }
}

/// What the seamless step did.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Annihilation {
    /// Dislocations before.
    pub dislocations: usize,
    /// Burgers vectors moved.
    pub moved: usize,
    /// Dislocations that stay, because moving them would have gone too far.
    pub kept: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Defect {
    None,
    Dislocation,
    Cone,
}

/// Turn and translation round a triangle, and for each of its edges the unit by which its jump enters the translation.
struct Circuit {
    turn: u8,
    burgers: Eisenstein,
    /// Per edge: (edge, rotation, negative).
    entry: [(EdgeId, u8, bool); 3],
}

fn circuit(topology: &Topology, charts: &Charts, jump: &PerEdge<Eisenstein>, f: FaceId) -> Circuit {
    let (mut turn, mut burgers) = (0u8, Eisenstein::ZERO);
    let mut entry = [(EdgeId::new(0), 0, false); 3];
    for (k, h) in topology.face_half_edges(f).enumerate() {
        let e = topology.edge(h);
        let step = charts.edge(e).turn;
        if topology.edge_half_edge(e) == h {
            entry[k] = (e, turn, false);
            burgers += jump[e].rotated(turn);
            turn = (turn + step) % 6;
        } else {
            turn = (turn + 6 - step) % 6;
            entry[k] = (e, turn, true);
            burgers += -jump[e].rotated(turn);
        }
    }
    Circuit {
        turn,
        burgers,
        entry,
    }
}

/// Moves the Burgers vector of `f` across its edge `e`.
fn push_across(
    topology: &Topology,
    charts: &Charts,
    jump: &mut PerEdge<Eisenstein>,
    f: FaceId,
    e: EdgeId,
) {
    let circuit = circuit(topology, charts, jump, f);
    for (edge, rotation, negative) in circuit.entry {
        if edge == e {
            let change = circuit.burgers.rotated((6 - rotation) % 6);
            jump[e] = if negative {
                jump[e] + change
            } else {
                jump[e] - change
            };
        }
    }
}

fn defect(c: &Circuit) -> Defect {
    match (c.turn, c.burgers) {
        (0, Eisenstein::ZERO) => Defect::None,
        (0, _) => Defect::Dislocation,
        _ => Defect::Cone,
    }
}

/// Moves every Burgers vector into the nearest opposite, cone or boundary, the closest pairs first. Paths longer than
/// `max_length` lattice spacings are not taken.
pub fn annihilate(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    jump: &mut PerEdge<Eisenstein>,
    max_length: f64,
) -> Annihilation {
    let mut state = PerFace::from_fn(topology.n_faces(), |f| {
        defect(&circuit(topology, charts, jump, f))
    });
    let all = state.enumerate().filter(|(_, d)| **d != Defect::None);
    let mut defects: BTreeSet<FaceId> = all.map(|(f, _)| f).collect();
    let count = |state: &PerFace<Defect>, defects: &BTreeSet<FaceId>| {
        let moving = defects.iter().filter(|f| state[**f] == Defect::Dislocation);
        moving.count()
    };
    let dislocations = count(&state, &defects);
    let mut fronts = Fronts::new(topology.n_faces());
    let mut moved = 0;
    // Each move ends at least one dislocation or merges two, so this is only a guard.
    for _ in 0..4 * dislocations + 4 {
        let Some(path) = fronts.shortest_path(topology, mesh, &state, &defects, max_length) else {
            break;
        };
        for &(f, e) in &path {
            push_across(topology, charts, jump, f, e);
        }
        for &(f, e) in &path {
            let h = topology.edge_half_edge(e);
            let sides = [
                Some(topology.face(h)),
                topology.twin(h).map(|t| topology.face(t)),
                Some(f),
            ];
            for g in sides.into_iter().flatten() {
                state[g] = defect(&circuit(topology, charts, jump, g));
                match state[g] {
                    Defect::None => defects.remove(&g),
                    _ => defects.insert(g),
                };
            }
        }
        moved += 1;
    }
    Annihilation {
        dislocations,
        moved,
        kept: count(&state, &defects),
    }
}

const NOBODY: u32 = u32::MAX;

/// Fronts that grow over the triangles from all defects at once; what they reached is kept, so that the next search clears only that.
struct Fronts {
    source: PerFace<u32>,
    distance: PerFace<f64>,
    from: PerFace<Option<(FaceId, EdgeId)>>,
    settled: PerFace<bool>,
    reached: Vec<FaceId>,
    heap: BinaryHeap<Reverse<(Distance, FaceId)>>,
}

impl Fronts {
    fn new(faces: usize) -> Self {
        Self {
            source: PerFace::filled(faces, NOBODY),
            distance: PerFace::filled(faces, f64::INFINITY),
            from: PerFace::filled(faces, None),
            settled: PerFace::filled(faces, false),
            reached: Vec::new(),
            heap: BinaryHeap::new(),
        }
    }

    fn clear(&mut self) {
        for f in self.reached.drain(..) {
            self.source[f] = NOBODY;
            self.distance[f] = f64::INFINITY;
            self.from[f] = None;
            self.settled[f] = false;
        }
        self.heap.clear();
    }

    fn reach(&mut self, f: FaceId, source: u32, distance: f64, from: Option<(FaceId, EdgeId)>) {
        if self.source[f] == NOBODY {
            self.reached.push(f);
        }
        self.source[f] = source;
        self.distance[f] = distance;
        self.from[f] = from;
        self.heap.push(Reverse((Distance(distance), f)));
    }

    /// The shortest dual path from a dislocation to another one, a cone, or out of the boundary: fronts grow until two meet. Pairs
    /// (face, edge to leave it by), in the order of the move.
    fn shortest_path(
        &mut self,
        topology: &Topology,
        mesh: &IntrinsicMesh,
        state: &PerFace<Defect>,
        defects: &BTreeSet<FaceId>,
        max_length: f64,
    ) -> Option<Vec<(FaceId, EdgeId)>> {
        let size = |f: FaceId| mesh.half_crossing(f);
        self.clear();
        for &f in defects {
            self.reach(f, f.index() as u32, 0.0, None);
        }
        let moves = |s: u32| state.as_slice()[s as usize] == Defect::Dislocation;
        let mut best: (f64, Option<(FaceId, EdgeId, Option<FaceId>)>) = (max_length, None);
        while let Some(Reverse((Distance(d), f))) = self.heap.pop() {
            if self.settled[f] {
                continue;
            }
            self.settled[f] = true;
            if 2.0 * d > best.0 {
                break;
            }
            let source = self.source[f];
            for h in topology.face_half_edges(f) {
                let e = topology.edge(h);
                let Some(t) = topology.twin(h) else {
                    let total = d + 4.0 * size(f);
                    if moves(source) && total < best.0 {
                        best = (total, Some((f, e, None)));
                    }
                    continue;
                };
                let g = topology.face(t);
                let step = d + size(f) + size(g);
                if self.settled[g] && self.source[g] != source {
                    let total = step + self.distance[g];
                    if (moves(source) || moves(self.source[g])) && total < best.0 {
                        best = (total, Some((f, e, Some(g))));
                    }
                }
                if !self.settled[g] && step < self.distance[g] {
                    self.reach(g, source, step, Some((f, e)));
                }
            }
        }
        let (f, e, g) = best.1?;
        let backwards = g.is_some_and(|g| !moves(self.source[f]) && moves(self.source[g]));
        Some(joined_path(&self.from, f, e, g, backwards))
    }
}

fn joined_path(
    from: &PerFace<Option<(FaceId, EdgeId)>>,
    f: FaceId,
    e: EdgeId,
    g: Option<FaceId>,
    backwards: bool,
) -> Vec<(FaceId, EdgeId)> {
    let (start, end) = if backwards {
        (g.expect("a far side"), Some(f))
    } else {
        (f, g)
    };
    // From the moving dislocation to the meeting edge ...
    let mut path = Vec::new();
    let mut at = start;
    while let Some((before, edge)) = from[at] {
        path.push((before, edge));
        at = before;
    }
    path.reverse();
    path.push((start, e));
    // ... and on to the other defect, against the direction in which its front grew.
    let mut at = end;
    while let Some(face) = at {
        at = from[face].map(|(before, edge)| {
            path.push((face, edge));
            before
        });
    }
    path
}

/// Weight, over the area, of the hold on the offsets before.
const ANCHOR: f64 = 1e-8;

/// Lattice offsets that fit the edges best with given jumps, and the pins; nearest to `near` where that leaves them free. `factor` is that
/// of [`factorised`] with the same charts and pins.
pub fn solve_offsets(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    jump: &PerEdge<Eisenstein>,
    pins: &PerVertex<Option<Pin>>,
    near: &PerVertex<Plane>,
    factor: &Cholesky,
) -> PerVertex<Plane> {
    let held = near.iter().zip(&mesh.mass);
    let mut rhs: Vec<Plane> = held.map(|(z, m)| z * (ANCHOR * m)).collect();
    for e in topology.edges() {
        let [i, j] = topology.edge_vertices(e).map(|v| v.index());
        let t = charts.edge(e);
        let c = (t.offset - jump[e].to_plane()) * mesh.weight[e];
        rhs[i] += c;
        rhs[j] -= rotate(c, (6 - t.turn) % 6);
    }
    for (v, pin) in pins.enumerate() {
        if let Some(pin) = pin {
            let wanted = near[v] + pin.correction(near[v]);
            rhs[v.index()] += pin.normal * (pin.weight * dot(pin.normal, wanted));
        }
    }
    let mut position = PerVertex::from_vec(solve(factor, |i| rhs[i], rhs.len()));
    if let Some(turn) = common_frame(topology, charts) {
        translate(&mut position, near, mesh, &turn);
    }
    position
}

/// The system of [`solve_offsets`], factorised; with the analysis of an earlier one, if there is any.
///
/// # Errors
/// If it is singular to rounding.
pub fn factorised(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    pins: &PerVertex<Option<Pin>>,
    earlier: Option<Cholesky>,
) -> Result<Cholesky, NumericError> {
    let n = topology.n_vertices();
    let mut own: Vec<f64> = mesh.mass.iter().map(|m| ANCHOR * m).collect();
    let mut entries = Vec::with_capacity(4 * topology.n_edges() + 2 * n);
    for e in topology.edges() {
        let ([i, j], w, t) = (
            topology.edge_vertices(e).map(|v| v.index()),
            mesh.weight[e],
            charts.edge(e),
        );
        own[i] += w;
        own[j] += w;
        push_block(
            &mut entries,
            i as u32,
            j as u32,
            -rotate(Plane::new(w, 0.0), t.turn),
        );
    }
    for (v, d) in own.iter().enumerate() {
        entries.push((2 * v as u32, 2 * v as u32, *d));
        entries.push((2 * v as u32 + 1, 2 * v as u32 + 1, *d));
    }
    for (v, pin) in pins.enumerate() {
        push_pin(&mut entries, v.index() as u32, pin.as_ref());
    }
    let matrix = SymmetricMatrix::from_triplets(2 * n, entries.into_iter())?;
    Cholesky::again(earlier, &matrix, 2)
}

/// Turns that take each chart to that of the first vertex, where no loop turns: then a common translation costs nothing.
fn common_frame(topology: &Topology, charts: &Charts) -> Option<PerVertex<u8>> {
    let mut turn: PerVertex<Option<u8>> = PerVertex::filled(topology.n_vertices(), None);
    let first = topology.vertices().next()?;
    turn[first] = Some(0);
    let mut stack = vec![first];
    while let Some(v) = stack.pop() {
        for h in topology.outgoing(v) {
            for h in [h, topology.prev(h)] {
                let seen = charts.half_edge(topology, h).turn;
                let (w, step) = if topology.origin(h) == v {
                    (topology.target(h), seen)
                } else {
                    (topology.origin(h), 6 - seen)
                };
                let there = turn[v].map(|t| (t + step) % 6);
                if turn[w].is_none() {
                    turn[w] = there;
                    stack.push(w);
                } else if turn[w] != there {
                    return None;
                }
            }
        }
    }
    turn.iter()
        .copied()
        .collect::<Option<Vec<u8>>>()
        .map(PerVertex::from_vec)
}

/// Translates a lattice to where it fits `near` best, modulo the lattice: which of several shortest paths a dislocation took
/// shifts offsets by lattice vectors and must not matter.
fn translate(
    position: &mut PerVertex<Plane>,
    near: &PerVertex<Plane>,
    mesh: &IntrinsicMesh,
    turn: &PerVertex<u8>,
) {
    let mut sum = [Plane::new(0.0, 0.0); 3];
    for (v, &t) in turn.enumerate() {
        let seen = waves::waves(rotate(near[v] - position[v], t));
        for (sum, wave) in sum.iter_mut().zip(seen) {
            *sum += wave * mesh.mass[v];
        }
    }
    let shift = Projector::new().project(&sum);
    for (v, &t) in turn.enumerate() {
        position[v] += rotate(shift, (6 - t) % 6);
    }
}

/// Adds the matrix of `w <n, z - z0>^2`, or its place.
fn push_pin(entries: &mut Vec<(u32, u32, f64)>, v: u32, pin: Option<&Pin>) {
    let (n, w) = pin.map_or((Plane::default(), 0.0), |p| (p.normal, p.weight));
    entries.push((2 * v, 2 * v, w * n.re * n.re));
    entries.push((2 * v + 1, 2 * v, w * n.re * n.im));
    entries.push((2 * v + 1, 2 * v + 1, w * n.im * n.im));
}
