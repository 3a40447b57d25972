//! Dislocations of a lattice, and the ways along which they vanish.
//!
//! Round a triangle the jumps add up to a translation, its Burgers vector; a triangle without turn
//! but with one is a dislocation (a 5|7 pair). Changing the jumps along a dual path moves a Burgers
//! vector to the path's end, where it meets its opposite, or a cone or the boundary that absorbs
//! it: `1 - w` is a unit of `Z[w]`, so a cone of one sixth absorbs *any* translation, and no
//! integer programming is needed.

use super::lattice::{Charts, Eisenstein};
use crate::directions::intrinsic::{Distance, IntrinsicMesh};
use phex_mesh::{EdgeId, FaceId, PerEdge, PerFace, Topology};
use serde::Serialize;
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// The way of a Burgers vector: triangles, and the edge by which it leaves each.
pub(crate) type Slip = Vec<(FaceId, EdgeId)>;

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
enum LatticeDefect {
    None,
    Dislocation,
    Cone,
}

/// Turn and translation round a triangle, and for each of its edges the unit by which its jump
/// enters the translation.
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

/// Moves the Burgers vector of `f` across its edge `e`; returns the change of the edge's jump.
fn push_across(
    topology: &Topology,
    charts: &Charts,
    jump: &mut PerEdge<Eisenstein>,
    f: FaceId,
    e: EdgeId,
) -> Eisenstein {
    let before = jump[e];
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
    jump[e] - before
}

fn defect(c: &Circuit) -> LatticeDefect {
    match (c.turn, c.burgers) {
        (0, Eisenstein::ZERO) => LatticeDefect::None,
        (0, _) => LatticeDefect::Dislocation,
        _ => LatticeDefect::Cone,
    }
}

/// Moves every Burgers vector into the nearest opposite, cone or boundary, the closest pairs first,
/// and returns the ways that they took. Paths longer than `max_length` lattice spacings are not
/// taken.
pub(crate) fn annihilate(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    jump: &mut PerEdge<Eisenstein>,
    max_length: f64,
) -> (Annihilation, Vec<Slip>) {
    let mut slips = Vec::new();
    let mut state = PerFace::from_fn(topology.n_faces(), |f| {
        defect(&circuit(topology, charts, jump, f))
    });
    let all = state
        .enumerate()
        .filter(|(_, d)| **d != LatticeDefect::None);
    let mut defects: BTreeSet<FaceId> = all.map(|(f, _)| f).collect();
    let count = |state: &PerFace<LatticeDefect>, defects: &BTreeSet<FaceId>| {
        let moving = defects
            .iter()
            .filter(|f| state[**f] == LatticeDefect::Dislocation);
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
                    LatticeDefect::None => defects.remove(&g),
                    _ => defects.insert(g),
                };
            }
        }
        moved += 1;
        slips.push(path);
    }
    let done = Annihilation {
        dislocations,
        moved,
        kept: count(&state, &defects),
    };
    (done, slips)
}

const NOBODY: u32 = u32::MAX;

/// Fronts that grow over the triangles from all defects at once; what they reached is kept, so that
/// the next search clears only that.
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

    /// The shortest dual path from a dislocation to another one, a cone, or out of the boundary:
    /// fronts grow until two meet. Pairs (face, edge to leave it by), in the order of the move.
    fn shortest_path(
        &mut self,
        topology: &Topology,
        mesh: &IntrinsicMesh,
        state: &PerFace<LatticeDefect>,
        defects: &BTreeSet<FaceId>,
        max_length: f64,
    ) -> Option<Slip> {
        let size = |f: FaceId| mesh.half_crossing(f);
        self.clear();
        for &f in defects {
            self.reach(f, f.index() as u32, 0.0, None);
        }
        let moves = |s: u32| state.as_slice()[s as usize] == LatticeDefect::Dislocation;
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
) -> Slip {
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

/// Moves the Burgers vectors that lie at the beginnings of ways along those that are `taken`, one
/// way after the other; returns the changes of the jumps along each.
pub(super) fn slip(
    topology: &Topology,
    charts: &Charts,
    jump: &mut PerEdge<Eisenstein>,
    slips: &[Slip],
    taken: &[bool],
) -> Vec<Vec<(EdgeId, Eisenstein)>> {
    let mut along = |path: &Slip| {
        let step = |&(f, e): &(FaceId, EdgeId)| (e, push_across(topology, charts, jump, f, e));
        path.iter().map(step).collect()
    };
    let changes = slips.iter().zip(taken).map(|(path, taken)| match taken {
        true => along(path),
        false => Vec::new(),
    });
    changes.collect()
}

/// Number of triangles with a dislocation.
pub(super) fn count(topology: &Topology, charts: &Charts, jump: &PerEdge<Eisenstein>) -> usize {
    let at =
        |f: &FaceId| defect(&circuit(topology, charts, jump, *f)) == LatticeDefect::Dislocation;
    topology.faces().filter(at).count()
}
