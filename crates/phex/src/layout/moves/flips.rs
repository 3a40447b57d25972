//! Irregular panels that need not be: edges turn until no turn makes the panels more regular.
//!
//! Where the lattice is sheared the nearest seeds are not its neighbours, and cells come out as
//! pairs of pentagons and heptagons round one edge; turning that edge (a T1 step, as in foams)
//! gives four hexagons. At the boundary the step opens the edge between two panels of the rim, so
//! that a pentagon behind them reaches the boundary and is whole again. Turns change no charge: the
//! sum of `6 - n` over all panels stays, so what topology demands stays too.

use super::{LEAST_CORNERS, OPENING, glide};
use crate::layout::{Layout, VertexKind};
use crate::progress::Progress;
use phex_mesh::polygon::point_segment_distance;
use phex_mesh::{
    EdgeId, FaceId, HalfEdgeId, HexMesh, PerVertex, Topology, Vec3, VertexId, insert_before,
    turn_edge,
};
use std::cmp::Reverse;
use std::collections::{BTreeSet, HashSet};

/// Rounds of turns at the most; each round makes the panels more regular, so this is only a guard.
const ROUNDS: usize = 30;
/// Corners that a panel must keep, and that a panel of the rim may come to have.
const LEAST: i32 = LEAST_CORNERS as i32;
const MOST_AT_RIM: i32 = 7;
/// Distance of the boundary from a new edge along it, bounding-box diagonals, from which on that
/// edge gets a vertex on it.
const BEND: f64 = 2e-4;

/// Turns edges while that makes the panels inside more regular: the sum of `(n - 6)^2` falls with
/// each turn, or with each short sequence of them.
pub(crate) fn turn_edges(mut layout: Layout, progress: &dyn Progress) -> Layout {
    for _ in 0..ROUNDS {
        if progress.is_cancelled() {
            break;
        }
        let turns = independent_turns(layout.mesh.topology());
        let next = if turns.is_empty() {
            glided(&layout)
        } else {
            turned(&layout, &turns)
        };
        match next {
            Some(next) => layout = next,
            None => break,
        }
    }
    layout
}

/// The layout after sequences of turns; `None` if there are none.
fn glided(layout: &Layout) -> Option<Layout> {
    let sequences = glide::sequences(layout.mesh.topology());
    (!sequences.is_empty()).then(|| turned_between(layout.clone(), &sequences))?
}

/// Turns edges inside together with all their images while that makes the panels of a symmetric
/// layout more regular; `None` if none can.
pub(crate) fn turn_with_images(layout: &Layout, images: &glide::PanelImages) -> Option<Layout> {
    let next = |layout: &Layout| {
        let sequences = glide::sequences_beside(layout.mesh.topology(), BTreeSet::new(), images);
        let all: Vec<_> = (sequences.iter())
            .flat_map(|path| glide::with_images(path, images))
            .collect();
        (!all.is_empty()).then(|| turned_between(layout.clone(), &all))?
    };
    let rounds = std::iter::successors(next(layout), next);
    rounds.take(ROUNDS).last()
}

/// The layout after sequences of turns of the edges between panels, side by side: no two of them
/// may turn edges with a corner in common at the same step, and an edge that two of them turn turns
/// once. `None` if a turn can't be.
pub(super) fn turned_between(layout: Layout, sequences: &[Vec<glide::Sides>]) -> Option<Layout> {
    let longest = sequences.iter().map(Vec::len).max().unwrap_or(0);
    (0..longest).try_fold(layout, |layout, step| {
        let topology = layout.mesh.topology();
        let sides = sequences.iter().filter_map(|s| s.get(step));
        let ordered = |&[a, b]: &glide::Sides| [a.min(b), a.max(b)];
        let mut seen = BTreeSet::new();
        let once = sides.filter(|s| seen.insert(ordered(s)));
        let turns: Option<Vec<EdgeTurn>> = once.map(|s| turn_between(topology, *s)).collect();
        turned(&layout, &turns?)
    })
}

fn turn_between(topology: &Topology, [a, b]: [FaceId; 2]) -> Option<EdgeTurn> {
    let mut around = topology.face_half_edges(a);
    let h = around.find(|h| topology.across(*h) == Some(b))?;
    inner_turn(topology, h, topology.twin(h)?)
}

/// An edge from `u` to `v`, the panels on its sides (left and right) and at its ends.
struct EdgeTurn {
    half_edge: HalfEdgeId,
    left: FaceId,
    right: FaceId,
    at_origin: FaceId,
    /// The panel at the target; none where the target lies on the boundary.
    at_target: Option<FaceId>,
    gain: i32,
}

impl EdgeTurn {
    fn panels(&self) -> impl Iterator<Item = FaceId> {
        let sides = [self.left, self.right, self.at_origin];
        sides.into_iter().chain(self.at_target)
    }
}

/// Turns that gain, the best first, no two of which share a panel.
fn independent_turns(topology: &Topology) -> Vec<EdgeTurn> {
    let mut turns: Vec<EdgeTurn> = topology
        .edges()
        .filter_map(|e| turn_of(topology, e))
        .filter(|t| t.gain > 0)
        .collect();
    turns.sort_by_key(|t| (Reverse(t.gain), t.half_edge));
    let mut taken = HashSet::new();
    turns.retain(|t| {
        let free = t.panels().all(|f| !taken.contains(&f));
        if free {
            taken.extend(t.panels());
        }
        free
    });
    turns
}

fn turn_of(topology: &Topology, e: EdgeId) -> Option<EdgeTurn> {
    let h = topology.edge_half_edge(e);
    let back = topology.twin(h)?;
    let inside = |h| !topology.is_boundary_vertex(topology.origin(h));
    match (inside(h), inside(back)) {
        (true, true) => inner_turn(topology, h, back),
        (true, false) => rim_turn(topology, h, back),
        (false, true) => rim_turn(topology, back, h),
        (false, false) => None,
    }
}

/// How irregular a panel with `n` corners is; panels of the rim may have any number.
fn irregularity(topology: &Topology, f: FaceId, n: i32) -> i32 {
    if topology.is_boundary_face(f) {
        0
    } else {
        (n - 6).pow(2)
    }
}

fn corners(topology: &Topology, f: FaceId) -> i32 {
    topology.valence(f) as i32
}

fn are_neighbours(topology: &Topology, a: FaceId, b: FaceId) -> bool {
    topology.adjacent_faces(a).any(|f| f == b)
}

fn inner_turn(topology: &Topology, h: HalfEdgeId, back: HalfEdgeId) -> Option<EdgeTurn> {
    let at_origin = topology.across(topology.prev(h))?;
    let at_target = topology.across(topology.next(h))?;
    let (left, right) = (topology.face(h), topology.face(back));
    let changes = [(left, -1), (right, -1), (at_origin, 1), (at_target, 1)];
    let mut gain = 0;
    for (f, change) in changes {
        let n = corners(topology, f);
        let rim = topology.is_boundary_face(f);
        if n + change < LEAST || (rim && change > 0 && n + change > MOST_AT_RIM) {
            return None;
        }
        gain += irregularity(topology, f, n) - irregularity(topology, f, n + change);
    }
    let distinct: HashSet<FaceId> = changes.iter().map(|c| c.0).collect();
    let possible = distinct.len() == 4 && !are_neighbours(topology, at_origin, at_target);
    possible.then_some(EdgeTurn {
        half_edge: h,
        left,
        right,
        at_origin,
        at_target: Some(at_target),
        gain,
    })
}

/// The edge `h` runs from a vertex inside to the boundary.
fn rim_turn(topology: &Topology, h: HalfEdgeId, back: HalfEdgeId) -> Option<EdgeTurn> {
    let at_origin = topology.across(topology.prev(h))?;
    let (left, right) = (topology.face(h), topology.face(back));
    let shrinking = [left, right];
    let b = topology.target(h);
    let possible = left != right
        && topology.face_degree(b) == 2
        && !topology.is_boundary_face(at_origin)
        && shrinking.iter().all(|f| corners(topology, *f) > LEAST);
    let n = corners(topology, at_origin);
    possible.then_some(EdgeTurn {
        half_edge: h,
        left,
        right,
        at_origin,
        at_target: None,
        gain: if n < 6 {
            irregularity(topology, at_origin, n)
        } else {
            0
        },
    })
}

/// The layout with all these edges turned; `None` if that is no mesh.
fn turned(layout: &Layout, turns: &[EdgeTurn]) -> Option<Layout> {
    let topology = layout.mesh.topology();
    let mut faces = topology.face_lists();
    let mut positions = layout.mesh.positions.as_slice().to_vec();
    let mut next = layout.clone();
    let mut kinds = layout.vertex_kind.as_slice().to_vec();
    for turn in turns {
        let ends = [
            topology.origin(turn.half_edge),
            topology.target(turn.half_edge),
        ];
        let at_ends = [
            Some(turn.at_origin.index()),
            turn.at_target.map(|f| f.index()),
        ];
        let sides = [turn.left, turn.right].map(|f| f.index());
        turn_edge(&mut faces, ends.map(|v| v.index() as u32), sides, at_ends);
        let places = match turn.at_target {
            Some(_) => opened(layout, turn, ends),
            None => opened_at_rim(layout, turn),
        };
        for (v, p) in ends.into_iter().zip(places) {
            positions[v.index()] = p;
        }
        if turn.at_target.is_none() {
            kinds[ends[0].index()] = VertexKind::Boundary;
            let b = layout.mesh.position(ends[1]);
            if point_segment_distance(b, places[0], places[1]) > BEND {
                let between = positions.len() as u32;
                positions.push(b);
                kinds.push(VertexKind::Boundary);
                let panel = &mut faces[turn.at_origin.index()];
                insert_before(panel, ends[0].index() as u32, between);
            }
        }
    }
    next.vertex_kind = PerVertex::from_vec(kinds);
    next.mesh = HexMesh::new(positions, &faces).ok()?;
    Some(next)
}

/// The ends on either side of the edge's middle.
fn opened(layout: &Layout, turn: &EdgeTurn, [u, v]: [VertexId; 2]) -> [Vec3; 2] {
    let middle = (layout.mesh.position(u) + layout.mesh.position(v)) * 0.5;
    [turn.left, turn.right].map(|f| middle + (layout.mesh.centre(f) - middle) * OPENING)
}

/// The ends along the boundary on either side of the edge's boundary vertex.
fn opened_at_rim(layout: &Layout, turn: &EdgeTurn) -> [Vec3; 2] {
    let topology = layout.mesh.topology();
    let before = topology.twin(turn.half_edge).map(|t| topology.prev(t));
    let b = layout.mesh.position(topology.target(turn.half_edge));
    let left = topology.target(topology.next(turn.half_edge));
    let right = before.map_or(left, |h| topology.origin(h));
    [left, right].map(|w| b + (layout.mesh.position(w) - b) * OPENING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::lattice_patch;
    use crate::progress::Silent;
    use phex_mesh::PerFace;

    fn valences(layout: &Layout) -> Vec<usize> {
        let topology = layout.mesh.topology();
        let inside = topology.inner_faces();
        inside.map(|f| topology.valence(f)).collect()
    }

    /// The edge whose two ends lie inside, of the panel in the middle.
    fn inner_turns(layout: &Layout) -> Vec<EdgeTurn> {
        let topology = layout.mesh.topology();
        let turns = topology.edges().filter_map(|e| turn_of(topology, e));
        turns.filter(|t| t.at_target.is_some()).collect()
    }

    #[test]
    fn a_lattice_is_left_alone() {
        let layout = lattice_patch(5);
        let after = turn_edges(layout.clone(), &Silent);
        assert_eq!(
            after.mesh.topology().face_lists(),
            layout.mesh.topology().face_lists()
        );
    }

    /// Every edge inside, turned once, gives pentagons and heptagons; calming finds the hexagons
    /// again.
    #[test]
    fn one_turned_edge_is_turned_back() {
        let layout = lattice_patch(5);
        for turn in inner_turns(&layout) {
            let spoilt = turned(&layout, &[turn]).unwrap();
            let after = turn_edges(spoilt, &Silent);
            assert!(valences(&after).iter().all(|n| *n == 6));
            assert!(after.mesh.topology().face_lists().len() == layout.mesh.topology().n_faces());
        }
    }

    /// A dislocation pulled apart by gliding comes together again.
    #[test]
    fn dislocations_glide_together() {
        let mut layout = lattice_patch(7);
        let first = inner_turns(&layout).swap_remove(60);
        layout = turned(&layout, &[first]).unwrap();
        let neutral = inner_turns(&layout)
            .into_iter()
            .find(|t| t.gain == 0)
            .unwrap();
        layout = turned(&layout, &[neutral]).unwrap();
        assert!(valences(&layout).iter().any(|n| *n != 6));
        assert!(
            valences(&turn_edges(layout, &Silent))
                .iter()
                .all(|n| *n == 6)
        );
    }

    /// The image of each panel in the mirror plane through the origin that swaps the two directions
    /// of a lattice patch, a sixth of a turn apart.
    fn mirrored(mesh: &HexMesh) -> PerFace<FaceId> {
        let (s, c) = std::f64::consts::FRAC_PI_3.sin_cos();
        let image = |p: Vec3| Vec3::new(c * p.x + s * p.y, s * p.x - c * p.y, p.z);
        let faces = || mesh.topology().faces();
        let at = |p: Vec3| faces().find(|g| (mesh.centre(*g) - p).norm() < 1e-9);
        PerFace::from_vec(
            faces()
                .map(|f| at(image(mesh.centre(f))).unwrap())
                .collect(),
        )
    }

    /// Wherever an edge has turned with its image, both turn back, and the panels stay symmetric.
    #[test]
    fn edges_turn_together_with_their_images() {
        let mut layout = lattice_patch(7);
        let middle =
            layout.mesh.positions.iter().sum::<Vec3>() / layout.mesh.positions.len() as f64;
        layout.mesh = layout.mesh.mapped(|p| p - middle);
        let images = [mirrored(&layout.mesh)];
        let (mut alone, mut pairs) = (0, 0);
        let topology = layout.mesh.topology();
        let is_inside = |t: &EdgeTurn| t.panels().all(|f| !topology.is_boundary_face(f));
        for turn in inner_turns(&layout).into_iter().filter(is_inside) {
            let path = [[turn.left, turn.right]];
            let both: Vec<_> = glide::with_images(&path, &images).collect();
            let Some(image) = turn_between(topology, both[1][0]) else {
                continue;
            };
            let ends = |t: &EdgeTurn| [topology.origin(t.half_edge), topology.target(t.half_edge)];
            let shared = ends(&turn)
                .iter()
                .filter(|v| ends(&image).contains(v))
                .count();
            // Edges with one corner in common do not turn together.
            if shared == 1 {
                continue;
            }
            let Some(spoilt) = turned_between(layout.clone(), &both) else {
                continue;
            };
            *(if shared == 2 { &mut alone } else { &mut pairs }) += 1;
            assert!(valences(&spoilt).iter().any(|n| *n != 6));
            let after = turn_with_images(&spoilt, &images).unwrap();
            assert!(valences(&after).iter().all(|n| *n == 6));
            assert_eq!(mirrored(&after.mesh).as_slice(), images[0].as_slice());
        }
        assert!(alone > 3 && pairs > 20, "{alone} {pairs}");
        assert!(turn_with_images(&layout, &images).is_none());
    }

    /// A pentagon behind the rim reaches the boundary: the panels inside that are left are
    /// hexagons, and vertices keep three panels inside and two on the boundary.
    #[test]
    fn a_pentagon_behind_the_rim_is_opened_to_the_boundary() {
        let layout = lattice_patch(5);
        let topology = layout.mesh.topology();
        // Turning an edge between two panels behind the rim makes them pentagons.
        let behind = |f: &FaceId| {
            !topology.is_boundary_face(*f)
                && topology.face_half_edges(*f).any(|h| {
                    topology
                        .across(h)
                        .is_some_and(|g| topology.is_boundary_face(g))
                })
        };
        let turn = inner_turns(&layout).into_iter().find(|t| {
            let ends = [Some(t.at_origin), t.at_target];
            let outside = ends
                .iter()
                .flatten()
                .filter(|f| topology.is_boundary_face(**f))
                .count();
            outside == 1 && [t.left, t.right].iter().all(behind)
        });
        let spoilt = turned(&layout, &[turn.unwrap()]).unwrap();
        let after = turn_edges(spoilt, &Silent);
        assert!(
            valences(&after).iter().all(|n| *n == 6),
            "{:?}",
            valences(&after)
        );
        let topology = after.mesh.topology();
        for v in topology.vertices() {
            let expected = if topology.is_boundary_vertex(v) {
                1..=2
            } else {
                3..=3
            };
            assert!(expected.contains(&topology.face_degree(v)));
            let kind = after.vertex_kind[v];
            assert_eq!(topology.is_boundary_vertex(v), kind != VertexKind::Interior);
        }
    }
}
