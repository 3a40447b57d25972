//! Half-edge topology of an oriented manifold polygon mesh, frozen after building.
//!
//! Each face owns one half-edge per corner, numbered consecutively and counter-clockwise; a
//! half-edge on the boundary has no twin. Faces of any valence, open or closed surfaces, any genus,
//! any number of boundary loops and components.

use crate::ids::{EdgeId, ElementId, FaceId, HalfEdgeId, VertexId};
use crate::per_element::{PerEdge, PerElement, PerFace, PerHalfEdge, PerVertex};
use std::ops::Neg;
use thiserror::Error;

const NONE: u32 = u32::MAX;

/// Why a list of faces is not an oriented manifold.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TopologyError {
    /// There is no face.
    #[error("the mesh has no faces")]
    Empty,
    /// More elements than ids can address.
    #[error("the mesh has {corners} face corners, more than can be addressed (4294967294)")]
    TooLarge {
        /// Number of face corners.
        corners: usize,
    },
    /// A face has fewer than three corners.
    #[error("face {face} has {corners} corners, at least 3 are needed")]
    TooFewCorners {
        /// The face.
        face: FaceId,
        /// Its corner count.
        corners: usize,
    },
    /// A face names a vertex that does not exist.
    #[error(
        "face {face} names vertex {vertex}, but the mesh has {vertices} vertices (numbered from 0)"
    )]
    IndexOutOfRange {
        /// The face.
        face: FaceId,
        /// The vertex number that it names.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A face holds a vertex twice.
    #[error("face {face} holds vertex {vertex} more than once")]
    RepeatedVertex {
        /// The face.
        face: FaceId,
        /// The repeated vertex.
        vertex: VertexId,
    },
    /// Two triangles have the same corners and nothing else beside them: a surface without inside.
    #[error("faces {first} and {second} have the same corners: remove one of them")]
    DoubledTriangle {
        /// The first.
        first: FaceId,
        /// The second.
        second: FaceId,
    },
    /// Three or more faces share an edge.
    #[error("the edge between vertices {from} and {to} is used by more than two faces: {}", listed(.faces))]
    NonManifoldEdge {
        /// One end.
        from: VertexId,
        /// The other end.
        to: VertexId,
        /// The faces that use it.
        faces: Vec<FaceId>,
    },
    /// Two faces run through an edge in the same direction.
    #[error(
        "faces {first} and {second} run through the edge from vertex {from} to vertex {to} in the same direction"
    )]
    InconsistentOrientation {
        /// Start of the edge.
        from: VertexId,
        /// End of the edge.
        to: VertexId,
        /// One face.
        first: FaceId,
        /// The other face.
        second: FaceId,
    },
    /// The faces at a vertex form more than one fan.
    #[error(
        "the faces at vertex {vertex} form more than one fan (a bow-tie vertex): give each of them a \
         vertex of its own, or take away all but one"
    )]
    BowTieVertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// A vertex belongs to no face.
    #[error("vertex {vertex} belongs to no face")]
    UnusedVertex {
        /// The vertex.
        vertex: VertexId,
    },
}

/// Faces in a sentence: `0, 1 and 2`.
fn listed(faces: &[FaceId]) -> String {
    let names: Vec<String> = faces.iter().map(ToString::to_string).collect();
    match names.split_last() {
        Some((last, others)) if !others.is_empty() => format!("{} and {last}", others.join(", ")),
        _ => names.concat(),
    }
}

/// Half-edges by the vertices that they leave, and among these by the vertices that they go to.
struct Leaving {
    start: Vec<u32>,
    half_edges: Vec<HalfEdgeId>,
}

impl Leaving {
    fn of(topology: &Topology) -> Self {
        let all: Vec<HalfEdgeId> = topology.half_edges().collect();
        let n = topology.n_vertices();
        let (by_target, _) = counting_sorted(&all, n, |h| topology.target(h));
        let (half_edges, start) = counting_sorted(&by_target, n, |h| topology.origin(h));
        Self { start, half_edges }
    }

    /// The first of those between two vertices.
    fn first(&self, topology: &Topology, from: VertexId, to: VertexId) -> Option<HalfEdgeId> {
        let range = self.start[from.index()] as usize..self.start[from.index() + 1] as usize;
        let leaving = &self.half_edges[range];
        let at = leaving.partition_point(|h| topology.target(*h) < to);
        let found = leaving.get(at).copied();
        found.filter(|h| topology.target(*h) == to)
    }
}

/// Half-edges in the order of their vertices, else in the order given, and where those of each of
/// `n` vertices begin.
fn counting_sorted(
    given: &[HalfEdgeId],
    n: usize,
    vertex: impl Fn(HalfEdgeId) -> VertexId,
) -> (Vec<HalfEdgeId>, Vec<u32>) {
    let mut start = vec![0u32; n + 2];
    given
        .iter()
        .for_each(|h| start[vertex(*h).index() + 2] += 1);
    (1..n + 2).for_each(|v| start[v] += start[v - 1]);
    let mut sorted = given.to_vec();
    for h in given {
        let place = &mut start[vertex(*h).index() + 1];
        sorted[*place as usize] = *h;
        *place += 1;
    }
    (sorted, start)
}

/// Connectivity of an oriented manifold polygon mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Topology {
    origin: PerHalfEdge<VertexId>,
    twin: PerHalfEdge<u32>,
    face: PerHalfEdge<FaceId>,
    edge: PerHalfEdge<EdgeId>,
    /// First half-edge of each face, and one past the last at the end.
    face_start: Vec<u32>,
    /// For an interior vertex any outgoing half-edge, for a boundary vertex the one whose twin is
    /// missing.
    outgoing: PerVertex<HalfEdgeId>,
    on_boundary: PerVertex<bool>,
    /// One half-edge of each edge, the lower of the two.
    edge_half_edge: PerEdge<HalfEdgeId>,
}

impl Topology {
    /// Builds the connectivity of `faces`, lists of vertex numbers counter-clockwise.
    ///
    /// # Errors
    /// A [`TopologyError`] that names the first element that keeps the faces from being an oriented
    /// manifold.
    pub fn from_faces<F: AsRef<[u32]>>(
        vertex_count: usize,
        faces: &[F],
    ) -> Result<Self, TopologyError> {
        if faces.is_empty() {
            return Err(TopologyError::Empty);
        }
        let corners: usize = faces.iter().map(|f| f.as_ref().len()).sum();
        if corners >= NONE as usize || vertex_count >= NONE as usize {
            return Err(TopologyError::TooLarge { corners });
        }
        check_corners(vertex_count, faces)?;
        let mut origin = Vec::with_capacity(corners);
        let mut face = Vec::with_capacity(corners);
        let mut face_start = Vec::with_capacity(faces.len() + 1);
        for (f, corner_list) in faces.iter().enumerate() {
            face_start.push(origin.len() as u32);
            for &v in corner_list.as_ref() {
                origin.push(VertexId::new(v));
                face.push(FaceId::from_index(f));
            }
        }
        face_start.push(origin.len() as u32);
        let mut topology = Self {
            origin: PerElement::from_vec(origin),
            twin: PerElement::filled(corners, NONE),
            face: PerElement::from_vec(face),
            edge: PerElement::filled(corners, EdgeId::new(0)),
            face_start,
            outgoing: PerElement::filled(vertex_count, HalfEdgeId::new(NONE)),
            on_boundary: PerElement::filled(vertex_count, false),
            edge_half_edge: PerElement::from_vec(Vec::new()),
        };
        topology.pair_half_edges()?;
        topology.anchor_vertices()?;
        Ok(topology)
    }

    fn pair_half_edges(&mut self) -> Result<(), TopologyError> {
        let leaving = Leaving::of(self);
        let mut edge_half_edge = Vec::with_capacity(self.n_half_edges() / 2 + 1);
        for h in self.half_edges() {
            let (from, to) = (self.origin(h), self.target(h));
            if let Some(other) = leaving.first(self, from, to).filter(|other| *other != h) {
                return Err(self.edge_error(from, to, other, h));
            }
            match leaving.first(self, to, from).filter(|t| *t < h) {
                Some(t) => {
                    self.twin[h] = t.index() as u32;
                    self.twin[t] = h.index() as u32;
                    self.edge[h] = self.edge[t];
                }
                None => {
                    self.edge[h] = EdgeId::from_index(edge_half_edge.len());
                    edge_half_edge.push(h);
                }
            }
        }
        self.edge_half_edge = PerElement::from_vec(edge_half_edge);
        Ok(())
    }

    fn edge_error(
        &self,
        from: VertexId,
        to: VertexId,
        first: HalfEdgeId,
        second: HalfEdgeId,
    ) -> TopologyError {
        let mut faces: Vec<FaceId> = self
            .half_edges()
            .filter(|&h| {
                let ends = (self.origin(h), self.target(h));
                ends == (from, to) || ends == (to, from)
            })
            .map(|h| self.face(h))
            .collect();
        faces.sort();
        if faces.len() > 2 {
            TopologyError::NonManifoldEdge { from, to, faces }
        } else {
            TopologyError::InconsistentOrientation {
                from,
                to,
                first: self.face(first),
                second: self.face(second),
            }
        }
    }

    fn anchor_vertices(&mut self) -> Result<(), TopologyError> {
        let mut degree = vec![0u32; self.n_vertices()];
        for h in self.half_edges() {
            let v = self.origin(h);
            degree[v.index()] += 1;
            let boundary = self.twin(h).is_none();
            if boundary && self.on_boundary[v] {
                return Err(TopologyError::BowTieVertex { vertex: v });
            }
            if boundary || self.outgoing[v].index() == NONE as usize {
                self.outgoing[v] = h;
            }
            self.on_boundary[v] |= boundary;
        }
        for v in self.vertices() {
            if degree[v.index()] == 0 {
                return Err(TopologyError::UnusedVertex { vertex: v });
            }
            if self.outgoing(v).count() != degree[v.index()] as usize {
                return Err(TopologyError::BowTieVertex { vertex: v });
            }
        }
        Ok(())
    }

    /// Number of vertices.
    #[inline]
    pub fn n_vertices(&self) -> usize {
        self.outgoing.len()
    }

    /// Number of faces.
    #[inline]
    pub fn n_faces(&self) -> usize {
        self.face_start.len() - 1
    }

    /// Number of edges.
    #[inline]
    pub fn n_edges(&self) -> usize {
        self.edge_half_edge.len()
    }

    /// Number of half-edges (face corners).
    #[inline]
    pub fn n_half_edges(&self) -> usize {
        self.origin.len()
    }

    /// All vertices.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = VertexId> + use<> {
        (0..self.n_vertices()).map(VertexId::from_index)
    }

    /// All faces.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = FaceId> + use<> {
        (0..self.n_faces()).map(FaceId::from_index)
    }

    /// All edges.
    pub fn edges(&self) -> impl ExactSizeIterator<Item = EdgeId> + use<> {
        (0..self.n_edges()).map(EdgeId::from_index)
    }

    /// All half-edges.
    pub fn half_edges(&self) -> impl ExactSizeIterator<Item = HalfEdgeId> + use<> {
        (0..self.n_half_edges()).map(HalfEdgeId::from_index)
    }

    /// The vertices on the boundary.
    pub fn boundary_vertices(&self) -> impl Iterator<Item = VertexId> {
        self.vertices().filter(|v| self.is_boundary_vertex(*v))
    }

    /// The vertices that are not on the boundary.
    pub fn inner_vertices(&self) -> impl Iterator<Item = VertexId> {
        self.vertices().filter(|v| !self.is_boundary_vertex(*v))
    }

    /// Whether there is no boundary.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges().next().is_none()
    }

    /// The edges that one face holds.
    pub fn boundary_edges(&self) -> impl Iterator<Item = EdgeId> {
        self.edges().filter(|e| self.is_boundary_edge(*e))
    }

    /// The edges that two faces hold.
    pub fn inner_edges(&self) -> impl Iterator<Item = EdgeId> {
        self.edges().filter(|e| !self.is_boundary_edge(*e))
    }

    /// The faces that have an edge on the boundary.
    pub fn boundary_faces(&self) -> impl Iterator<Item = FaceId> {
        self.faces().filter(|f| self.is_boundary_face(*f))
    }

    /// The faces that have no edge on the boundary.
    pub fn inner_faces(&self) -> impl Iterator<Item = FaceId> {
        self.faces().filter(|f| !self.is_boundary_face(*f))
    }

    /// The vertex where a half-edge starts.
    #[inline]
    pub fn origin(&self, h: HalfEdgeId) -> VertexId {
        self.origin[h]
    }

    /// The vertex where a half-edge ends.
    #[inline]
    pub fn target(&self, h: HalfEdgeId) -> VertexId {
        self.origin[self.next(h)]
    }

    /// The other side of the edge, or `None` on the boundary.
    #[inline]
    pub fn twin(&self, h: HalfEdgeId) -> Option<HalfEdgeId> {
        let t = self.twin[h];
        (t != NONE).then(|| HalfEdgeId::new(t))
    }

    /// The face to the left of a half-edge.
    #[inline]
    pub fn face(&self, h: HalfEdgeId) -> FaceId {
        self.face[h]
    }

    /// The face on the other side of the edge, or `None` on the boundary.
    #[inline]
    pub fn across(&self, h: HalfEdgeId) -> Option<FaceId> {
        self.twin(h).map(|t| self.face[t])
    }

    /// The undirected edge of a half-edge.
    #[inline]
    pub fn edge(&self, h: HalfEdgeId) -> EdgeId {
        self.edge[h]
    }

    /// The next half-edge of the same face, counter-clockwise.
    #[inline]
    pub fn next(&self, h: HalfEdgeId) -> HalfEdgeId {
        let f = self.face[h].index();
        let n = h.index() as u32 + 1;
        HalfEdgeId::new(if n == self.face_start[f + 1] {
            self.face_start[f]
        } else {
            n
        })
    }

    /// The previous half-edge of the same face.
    #[inline]
    pub fn prev(&self, h: HalfEdgeId) -> HalfEdgeId {
        let f = self.face[h].index();
        let i = h.index() as u32;
        HalfEdgeId::new(if i == self.face_start[f] {
            self.face_start[f + 1] - 1
        } else {
            i - 1
        })
    }

    /// One half-edge of an edge (the lower id; on the boundary the only one).
    #[inline]
    pub fn edge_half_edge(&self, e: EdgeId) -> HalfEdgeId {
        self.edge_half_edge[e]
    }

    /// What a half-edge has of a quantity that its edge has in the direction of
    /// [`Self::edge_half_edge`]: the same, or the opposite where it runs the other way.
    #[inline]
    pub fn along<T: Neg<Output = T>>(&self, h: HalfEdgeId, of_edge: T) -> T {
        if self.runs_along(h) {
            of_edge
        } else {
            -of_edge
        }
    }

    /// What an edge has of such a quantity in the direction that leads away from one of its ends.
    #[inline]
    pub fn away_from<T: Neg<Output = T>>(&self, v: VertexId, e: EdgeId, of_edge: T) -> T {
        if self.origin[self.edge_half_edge[e]] == v {
            of_edge
        } else {
            -of_edge
        }
    }

    /// Whether a half-edge is the one that [`Self::edge_half_edge`] gives for its edge.
    #[inline]
    pub fn runs_along(&self, h: HalfEdgeId) -> bool {
        self.edge_half_edge[self.edge[h]] == h
    }

    /// The two ends of an edge.
    #[inline]
    pub fn edge_vertices(&self, e: EdgeId) -> [VertexId; 2] {
        let h = self.edge_half_edge[e];
        [self.origin(h), self.target(h)]
    }

    /// The one or two faces of an edge, that on the left of [`Self::edge_half_edge`] first.
    pub fn edge_faces(&self, e: EdgeId) -> impl Iterator<Item = FaceId> {
        let h = self.edge_half_edge[e];
        [Some(self.face[h]), self.across(h)].into_iter().flatten()
    }

    /// The faces on the left and right of [`Self::edge_half_edge`], or `None` on the boundary.
    #[inline]
    pub fn faces_beside(&self, e: EdgeId) -> Option<[FaceId; 2]> {
        let h = self.edge_half_edge[e];
        Some([self.face[h], self.across(h)?])
    }

    /// Whether only one face holds the edge.
    #[inline]
    pub fn is_boundary_edge(&self, e: EdgeId) -> bool {
        self.twin(self.edge_half_edge[e]).is_none()
    }

    /// Whether a vertex lies on the boundary.
    #[inline]
    pub fn is_boundary_vertex(&self, v: VertexId) -> bool {
        self.on_boundary[v]
    }

    /// Whether a face has an edge on the boundary.
    pub fn is_boundary_face(&self, f: FaceId) -> bool {
        self.face_half_edges(f).any(|h| self.twin(h).is_none())
    }

    /// Number of corners of a face.
    #[inline]
    pub fn valence(&self, f: FaceId) -> usize {
        (self.face_start[f.index() + 1] - self.face_start[f.index()]) as usize
    }

    /// Half-edges of a face, counter-clockwise.
    pub fn face_half_edges(&self, f: FaceId) -> impl ExactSizeIterator<Item = HalfEdgeId> + use<> {
        let range = self.face_start[f.index()] as usize..self.face_start[f.index() + 1] as usize;
        range.map(HalfEdgeId::from_index)
    }

    /// Faces across the edges of a face, counter-clockwise.
    pub fn adjacent_faces(&self, f: FaceId) -> impl Iterator<Item = FaceId> {
        self.face_half_edges(f).filter_map(|h| self.across(h))
    }

    /// Vertices of a face, counter-clockwise.
    pub fn face_vertices(&self, f: FaceId) -> &[VertexId] {
        &self.origin.as_slice()
            [self.face_start[f.index()] as usize..self.face_start[f.index() + 1] as usize]
    }

    /// Vertices of every face, as lists of numbers.
    pub fn face_lists(&self) -> Vec<Vec<u32>> {
        self.faces()
            .map(|f| {
                self.face_vertices(f)
                    .iter()
                    .map(|v| v.index() as u32)
                    .collect()
            })
            .collect()
    }

    /// Half-edges that leave a vertex, counter-clockwise; at a boundary vertex the first one lies
    /// on the boundary.
    #[inline]
    pub fn outgoing(&self, v: VertexId) -> Outgoing<'_> {
        let start = self.outgoing[v];
        Outgoing {
            topology: self,
            start,
            next: Some(start),
        }
    }

    /// Faces at a vertex, counter-clockwise, in the order of [`Self::outgoing`].
    pub fn faces_at(&self, v: VertexId) -> impl Iterator<Item = FaceId> {
        self.outgoing(v).map(|h| self.face[h])
    }

    /// Number of faces at a vertex.
    pub fn face_degree(&self, v: VertexId) -> usize {
        self.outgoing(v).count()
    }

    /// Number of edges at a vertex.
    pub fn edge_degree(&self, v: VertexId) -> usize {
        self.face_degree(v) + usize::from(self.on_boundary[v])
    }

    /// Edges at a vertex with their other ends, counter-clockwise.
    pub fn spokes(&self, v: VertexId) -> Vec<(EdgeId, VertexId)> {
        let mut spokes = Vec::with_capacity(6);
        for h in self.outgoing(v) {
            spokes.push((self.edge(h), self.target(h)));
            let back = self.prev(h);
            if self.twin(back).is_none() {
                spokes.push((self.edge(back), self.origin(back)));
            }
        }
        spokes
    }

    /// Vertices joined to `v` by an edge, counter-clockwise.
    pub fn neighbours(&self, v: VertexId) -> Vec<VertexId> {
        self.spokes(v).into_iter().map(|(_, w)| w).collect()
    }

    /// Boundary loops, each in the direction of its half-edges (the surface lies to the left).
    pub fn boundary_loops(&self) -> Vec<Vec<VertexId>> {
        let mut seen = PerVertex::filled(self.n_vertices(), false);
        let mut loops = Vec::new();
        for start in self.vertices() {
            if !self.on_boundary[start] || seen[start] {
                continue;
            }
            let mut boundary = Vec::new();
            let mut v = start;
            while !seen[v] {
                seen[v] = true;
                boundary.push(v);
                v = self.target(self.outgoing[v]);
            }
            loops.push(boundary);
        }
        loops
    }

    /// Number of vertices minus edges plus faces.
    pub fn euler_characteristic(&self) -> i64 {
        self.n_vertices() as i64 - self.n_edges() as i64 + self.n_faces() as i64
    }

    /// Connected component of each face, and their number; components are numbered in the order of
    /// their first face.
    pub fn components(&self) -> (PerFace<u32>, usize) {
        let mut component = PerFace::filled(self.n_faces(), NONE);
        let mut count = 0;
        let mut stack = Vec::new();
        for seed in self.faces() {
            if component[seed] != NONE {
                continue;
            }
            component[seed] = count;
            stack.push(seed);
            while let Some(f) = stack.pop() {
                for g in self.adjacent_faces(f) {
                    if component[g] == NONE {
                        component[g] = count;
                        stack.push(g);
                    }
                }
            }
            count += 1;
        }
        (component, count as usize)
    }
}

/// That every face has three or more corners, all different and below `vertex_count`.
pub(crate) fn check_corners<F: AsRef<[u32]>>(
    vertex_count: usize,
    faces: &[F],
) -> Result<(), TopologyError> {
    let mut sorted = Vec::new();
    for (i, corners) in faces.iter().enumerate() {
        let (face, corners) = (FaceId::from_index(i), corners.as_ref());
        if corners.len() < 3 {
            return Err(TopologyError::TooFewCorners {
                face,
                corners: corners.len(),
            });
        }
        sorted.clear();
        sorted.extend_from_slice(corners);
        sorted.sort_unstable();
        let last = sorted[sorted.len() - 1];
        if last as usize >= vertex_count {
            return Err(TopologyError::IndexOutOfRange {
                face,
                vertex: last,
                vertices: vertex_count,
            });
        }
        if let Some(pair) = sorted.windows(2).find(|w| w[0] == w[1]) {
            return Err(TopologyError::RepeatedVertex {
                face,
                vertex: VertexId::new(pair[0]),
            });
        }
    }
    Ok(())
}

/// Iterator over the half-edges that leave a vertex; see [`Topology::outgoing`].
#[derive(Clone, Debug)]
pub struct Outgoing<'a> {
    topology: &'a Topology,
    start: HalfEdgeId,
    next: Option<HalfEdgeId>,
}

impl Iterator for Outgoing<'_> {
    type Item = HalfEdgeId;
    #[inline]
    fn next(&mut self) -> Option<HalfEdgeId> {
        let h = self.next?;
        // Counter-clockwise: across the edge that enters the vertex in this face.
        self.next = self
            .topology
            .twin(self.topology.prev(h))
            .filter(|&n| n != self.start);
        Some(h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TETRAHEDRON: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];

    #[test]
    fn tetrahedron_is_closed() {
        let t = Topology::from_faces(4, &TETRAHEDRON).unwrap();
        assert_eq!((t.n_vertices(), t.n_edges(), t.n_faces()), (4, 6, 4));
        assert_eq!(t.euler_characteristic(), 2);
        assert!(t.boundary_loops().is_empty());
        for v in t.vertices() {
            assert_eq!(t.face_degree(v), 3);
            assert!(!t.is_boundary_vertex(v));
        }
        for h in t.half_edges() {
            assert_eq!(t.twin(t.twin(h).unwrap()), Some(h));
            assert_eq!(t.prev(t.next(h)), h);
        }
    }

    #[test]
    fn hexagon_pair_has_one_boundary_loop_in_face_direction() {
        let t = Topology::from_faces(6, &[vec![0, 1, 2, 3], vec![1, 4, 5, 2]]).unwrap();
        assert_eq!(
            t.boundary_loops(),
            vec![[0, 1, 4, 5, 2, 3].map(VertexId::new).to_vec()]
        );
        assert_eq!(
            t.neighbours(VertexId::new(1)),
            [4, 2, 0].map(VertexId::new).to_vec()
        );
        assert_eq!(t.edge_degree(VertexId::new(1)), 3);
        assert_eq!(t.components().1, 1);
    }

    #[test]
    fn bad_faces_are_named() {
        let err = |n, f: &[Vec<u32>]| Topology::from_faces(n, f).unwrap_err();
        assert_eq!(err(0, &[]), TopologyError::Empty);
        assert!(matches!(
            err(3, &[vec![0, 1]]),
            TopologyError::TooFewCorners { corners: 2, .. }
        ));
        assert!(matches!(
            err(3, &[vec![0, 1, 9]]),
            TopologyError::IndexOutOfRange { vertex: 9, .. }
        ));
        assert!(matches!(
            err(3, &[vec![0, 1, 1]]),
            TopologyError::RepeatedVertex { .. }
        ));
        assert!(matches!(
            err(4, &[vec![0, 1, 2]]),
            TopologyError::UnusedVertex { .. }
        ));
        let fan = [vec![0, 1, 2], vec![1, 0, 3], vec![0, 1, 4]];
        assert!(
            matches!(err(5, &fan), TopologyError::NonManifoldEdge { ref faces, .. } if faces.len() == 3)
        );
        let same_way = [vec![0, 1, 2], vec![0, 1, 3]];
        assert!(matches!(
            err(4, &same_way),
            TopologyError::InconsistentOrientation { .. }
        ));
        let bow_tie = [vec![0, 1, 2], vec![0, 3, 4]];
        assert_eq!(
            err(5, &bow_tie),
            TopologyError::BowTieVertex {
                vertex: VertexId::new(0)
            }
        );
    }

    #[test]
    fn closed_fans_that_touch_in_a_vertex_are_a_bow_tie() {
        let mut faces: Vec<Vec<u32>> = TETRAHEDRON.iter().map(|f| f.to_vec()).collect();
        faces.extend(
            TETRAHEDRON
                .iter()
                .map(|f| f.iter().map(|&v| if v == 0 { 0 } else { v + 3 }).collect()),
        );
        assert_eq!(
            Topology::from_faces(7, &faces).unwrap_err(),
            TopologyError::BowTieVertex {
                vertex: VertexId::new(0)
            }
        );
    }
}
