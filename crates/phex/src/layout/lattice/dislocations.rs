//! Dislocations of a lattice, and the ways along which they vanish.
//!
//! Round a triangle the jumps add up to a translation, its Burgers vector; a triangle without turn
//! but with one is a dislocation (a 5|7 pair). Changing the jumps along a dual path moves a Burgers
//! vector to the path's end, where it meets its opposite, or a cone or the boundary that absorbs
//! it: `1 - w` is a unit of `Z[w]`, so a cone of one sixth absorbs *any* translation, and no
//! integer programming is needed.

use super::charted::ChartedSurface;
use super::eisenstein::Eisenstein;
use super::fronts::{Fronts, LatticeDefect, Slip};
use phex_mesh::{EdgeId, FaceId, PerEdge, PerFace, Topology};
use serde::Serialize;

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

/// Turn and translation round a triangle, and for each of its edges the unit by which its jump
/// enters the translation.
struct Circuit {
    turn: u8,
    burgers: Eisenstein,
    /// Per edge: (edge, rotation, negative).
    entry: [(EdgeId, u8, bool); 3],
}

fn circuit(charted: &ChartedSurface<'_>, jump: &PerEdge<Eisenstein>, f: FaceId) -> Circuit {
    let (topology, charts) = (charted.topology, charted.charts);
    let (mut turn, mut burgers) = (0u8, Eisenstein::ZERO);
    let mut entry = [(EdgeId::new(0), 0, false); 3];
    for (k, h) in topology.face_half_edges(f).enumerate() {
        let e = topology.edge(h);
        let step = charts.edge(e).turn;
        if topology.runs_along(h) {
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
    charted: &ChartedSurface<'_>,
    jump: &mut PerEdge<Eisenstein>,
    f: FaceId,
    e: EdgeId,
) -> Eisenstein {
    let before = jump[e];
    let circuit = circuit(charted, jump, f);
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

/// Moves every Burgers vector into the nearest opposite, cone or boundary, and returns the ways
/// that they took. Paths longer than `max_length` lattice spacings are not taken.
///
/// In a round all those move that are each other's nearest: their ways run through triangles that
/// are nearest to them, so that the closest pair of all would be the next anyway, one after the
/// other.
pub(crate) fn annihilate(
    charted: &ChartedSurface<'_>,
    jump: &mut PerEdge<Eisenstein>,
    max_length: f64,
) -> (Annihilation, Vec<Slip>) {
    let topology = charted.topology;
    let mut slips = Vec::new();
    let mut state = PerFace::from_fn(topology.n_faces(), |f| defect(&circuit(charted, jump, f)));
    let count = |state: &PerFace<LatticeDefect>| {
        let moving = |d: &&LatticeDefect| **d == LatticeDefect::Dislocation;
        state.iter().filter(moving).count()
    };
    let dislocations = count(&state);
    let mut fronts = Fronts::new(topology, charted.mesh);
    // Each round ends at least one dislocation or merges two, so this is only a guard.
    for _ in 0..2 * dislocations + 2 {
        fronts.grow(&state);
        let meetings = fronts.nearest(&state, max_length);
        if meetings.is_empty() {
            break;
        }
        let ways: Vec<Slip> = meetings.iter().map(|m| fronts.path(&state, m)).collect();
        for &(f, e) in ways.iter().flatten() {
            push_across(charted, jump, f, e);
        }
        for g in ways.iter().flatten().flat_map(|way| beside(topology, *way)) {
            state[g] = defect(&circuit(charted, jump, g));
        }
        slips.extend(ways);
    }
    let done = Annihilation {
        dislocations,
        moved: slips.len(),
        kept: count(&state),
    };
    (done, slips)
}

/// A triangle, and the one across the edge by which a way leaves it.
fn beside(topology: &Topology, (f, e): (FaceId, EdgeId)) -> impl Iterator<Item = FaceId> {
    topology.edge_faces(e).chain([f])
}

/// Moves the Burgers vectors that lie at the beginnings of ways along those that are `taken`, one
/// way after the other; returns the changes of the jumps along each.
pub(super) fn slip(
    charted: &ChartedSurface<'_>,
    jump: &mut PerEdge<Eisenstein>,
    slips: &[Slip],
    taken: &[bool],
) -> Vec<Vec<(EdgeId, Eisenstein)>> {
    let mut along = |path: &Slip| {
        let step = |&(f, e): &(FaceId, EdgeId)| (e, push_across(charted, jump, f, e));
        path.iter().map(step).collect()
    };
    let changes = slips.iter().zip(taken).map(|(path, taken)| match taken {
        true => along(path),
        false => Vec::new(),
    });
    changes.collect()
}

/// Number of triangles with a dislocation.
pub(super) fn count(charted: &ChartedSurface<'_>, jump: &PerEdge<Eisenstein>) -> usize {
    let at = |f: &FaceId| defect(&circuit(charted, jump, *f)) == LatticeDefect::Dislocation;
    charted.topology.faces().filter(at).count()
}
