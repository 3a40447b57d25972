//! Fronts that grow over the triangles from all defects of a lattice at once, and where they meet.
//!
//! What fronts reached stays from one round to the next: where a defect has vanished its triangles
//! are reached again from those of its neighbours.

use crate::directions::intrinsic::{Distance, IntrinsicMesh};
use phex_mesh::{EdgeId, FaceId, PerFace, Topology};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The way of a Burgers vector: triangles, and the edge by which it leaves each.
pub(crate) type Slip = Vec<(FaceId, EdgeId)>;

/// What is wrong with the lattice at a triangle.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum LatticeDefect {
    None,
    Dislocation,
    Cone,
}

const NOBODY: u32 = u32::MAX;

/// See the module.
pub(super) struct Fronts<'a> {
    topology: &'a Topology,
    mesh: &'a IntrinsicMesh,
    /// The defect that each triangle is nearest to.
    source: PerFace<u32>,
    distance: PerFace<f64>,
    from: PerFace<Option<(FaceId, EdgeId)>>,
    heap: BinaryHeap<Reverse<(Distance, FaceId)>>,
}

/// Where two fronts meet, or one the boundary.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    /// Length of the way from one defect to the other.
    length: f64,
    edge: EdgeId,
    /// The triangle on the side of the first front.
    face: FaceId,
    /// That of the second.
    beyond: Option<FaceId>,
}

impl Meeting {
    /// The shorter first; no two are equal.
    fn is_before(&self, other: &Self) -> bool {
        let order = self.length.total_cmp(&other.length);
        order.then(self.edge.cmp(&other.edge)).is_lt()
    }
}

impl<'a> Fronts<'a> {
    pub fn new(topology: &'a Topology, mesh: &'a IntrinsicMesh) -> Self {
        let faces = topology.n_faces();
        Self {
            topology,
            mesh,
            source: PerFace::filled(faces, NOBODY),
            distance: PerFace::filled(faces, f64::INFINITY),
            from: PerFace::filled(faces, None),
            heap: BinaryHeap::new(),
        }
    }

    /// Lets the fronts of all defects that there are grow until they meet.
    pub fn grow(&mut self, state: &PerFace<LatticeDefect>) {
        self.clear(state);
        for f in self.topology.faces() {
            if state[f] != LatticeDefect::None && self.distance[f] > 0.0 {
                self.reach(f, f.index() as u32, 0.0, None);
            } else if self.source[f] != NOBODY && self.is_beside_nobody(f) {
                self.heap.push(Reverse((Distance(self.distance[f]), f)));
            }
        }
        while let Some(Reverse((Distance(d), f))) = self.heap.pop() {
            if d > self.distance[f] {
                continue;
            }
            for h in self.topology.face_half_edges(f) {
                let Some(t) = self.topology.twin(h) else {
                    continue;
                };
                let g = self.topology.face(t);
                let step = d + self.mesh.half_crossing(f) + self.mesh.half_crossing(g);
                if step < self.distance[g] {
                    self.reach(g, self.source[f], step, Some((f, self.topology.edge(h))));
                }
            }
        }
    }

    /// Clears what the fronts of defects that are no more have reached.
    fn clear(&mut self, state: &PerFace<LatticeDefect>) {
        for f in self.topology.faces() {
            let source = self.source[f];
            if source != NOBODY && state.as_slice()[source as usize] == LatticeDefect::None {
                self.source[f] = NOBODY;
                self.distance[f] = f64::INFINITY;
                self.from[f] = None;
            }
        }
    }

    fn is_beside_nobody(&self, f: FaceId) -> bool {
        let mut around = self.topology.adjacent_faces(f);
        around.any(|g| self.source[g] == NOBODY)
    }

    fn reach(&mut self, f: FaceId, source: u32, distance: f64, from: Option<(FaceId, EdgeId)>) {
        self.source[f] = source;
        self.distance[f] = distance;
        self.from[f] = from;
        self.heap.push(Reverse((Distance(distance), f)));
    }

    /// Meetings no longer than `most` of which each dislocation that takes part has no shorter one.
    pub fn nearest(&self, state: &PerFace<LatticeDefect>, most: f64) -> Vec<Meeting> {
        let all = || {
            let edges = self.topology.edges();
            edges
                .filter_map(|e| self.meeting(e))
                .filter(|m| m.length < most)
        };
        let mut best: PerFace<Option<Meeting>> = PerFace::filled(self.topology.n_faces(), None);
        for meeting in all() {
            for f in self.movers(&meeting, state) {
                if best[f].is_none_or(|b| meeting.is_before(&b)) {
                    best[f] = Some(meeting);
                }
            }
        }
        let is_best = |m: &Meeting| {
            let mut movers = self.movers(m, state).peekable();
            movers.peek().is_some() && movers.all(|f| best[f] == Some(*m))
        };
        let mut found: Vec<Meeting> = all().filter(is_best).collect();
        found.sort_by(|a, b| a.length.total_cmp(&b.length).then(a.edge.cmp(&b.edge)));
        found
    }

    /// The meeting across an edge, if fronts of two defects meet there or one the boundary.
    fn meeting(&self, edge: EdgeId) -> Option<Meeting> {
        let h = self.topology.edge_half_edge(edge);
        let face = self.topology.face(h);
        let beyond = self.topology.across(h);
        let size = |f: FaceId| self.mesh.half_crossing(f);
        // Beyond a mirror plane lies its own image, which cancels nothing.
        let ends = self.topology.edge_vertices(edge);
        if beyond.is_none() && ends.iter().all(|v| self.mesh.multiplicity[*v] > 1) {
            return None;
        }
        let length = match beyond {
            None => self.distance[face] + 4.0 * size(face),
            Some(g) => self.distance[face] + size(face) + size(g) + self.distance[g],
        };
        let apart = beyond.is_none_or(|g| self.source[g] != self.source[face]);
        (apart && length.is_finite()).then_some(Meeting {
            length,
            edge,
            face,
            beyond,
        })
    }

    /// The dislocations from which the fronts of a meeting come.
    fn movers(
        &self,
        meeting: &Meeting,
        state: &PerFace<LatticeDefect>,
    ) -> impl Iterator<Item = FaceId> {
        let sides = [Some(meeting.face), meeting.beyond].into_iter().flatten();
        let sources = sides.map(|f| FaceId::new(self.source[f]));
        sources.filter(|f| state[*f] == LatticeDefect::Dislocation)
    }

    /// The way of a dislocation to its meeting and on to the other defect: triangles, and the edge
    /// by which it leaves each.
    pub fn path(&self, state: &PerFace<LatticeDefect>, meeting: &Meeting) -> Slip {
        let moves = |f: FaceId| state[FaceId::new(self.source[f])] == LatticeDefect::Dislocation;
        let backwards = meeting.beyond.filter(|g| !moves(meeting.face) && moves(*g));
        let (start, end) = match backwards {
            Some(g) => (g, Some(meeting.face)),
            None => (meeting.face, meeting.beyond),
        };
        let mut path = self.way_back(start);
        path.reverse();
        path.push((start, meeting.edge));
        // On to the other defect, against the direction in which its front grew.
        let mut at = end;
        while let Some(face) = at {
            at = self.from[face].map(|(before, edge)| {
                path.push((face, edge));
                before
            });
        }
        path
    }

    /// The triangles through which a front came, the last first, and the edges by which it left
    /// them.
    fn way_back(&self, face: FaceId) -> Slip {
        let step = |&(before, _): &(FaceId, EdgeId)| self.from[before];
        std::iter::successors(self.from[face], step).collect()
    }
}
