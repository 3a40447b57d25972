//! The incidence of the circles: one node per vertex and per face, one kite per corner.

use phex_mesh::{ElementId, FaceId, HalfEdgeId, Topology, VertexId};

/// Number of a circle: vertices first, then faces.
pub(super) type NodeId = usize;

/// The circles of a mesh and the kites between them. The kite of half-edge `h` has the centres of
/// the circles of `origin(h)` and `face(h)` and the touching points of the edges of `h` and
/// `prev(h)` as its corners.
pub(super) struct Circles<'a> {
    pub topology: &'a Topology,
}

impl<'a> Circles<'a> {
    pub fn new(topology: &'a Topology) -> Self {
        Self { topology }
    }

    pub(crate) fn n_nodes(&self) -> usize {
        self.topology.n_vertices() + self.topology.n_faces()
    }

    pub(crate) fn n_pairs(&self) -> usize {
        self.topology.n_half_edges()
    }

    pub fn nodes(&self) -> std::ops::Range<NodeId> {
        0..self.n_nodes()
    }

    pub fn of_vertex(&self, v: VertexId) -> NodeId {
        v.index()
    }

    pub fn of_face(&self, f: FaceId) -> NodeId {
        self.topology.n_vertices() + f.index()
    }

    pub fn vertex(&self, node: NodeId) -> Option<VertexId> {
        (node < self.topology.n_vertices()).then(|| VertexId::from_index(node))
    }

    /// The two circles of a kite.
    pub fn ends(&self, h: HalfEdgeId) -> (NodeId, NodeId) {
        (
            self.of_vertex(self.topology.origin(h)),
            self.of_face(self.topology.face(h)),
        )
    }

    /// The other circle of a kite.
    pub fn other(&self, h: HalfEdgeId, node: NodeId) -> NodeId {
        let (v, f) = self.ends(h);
        if node == v { f } else { v }
    }

    /// Pairs of orthogonal circles.
    pub fn pairs(&self) -> impl Iterator<Item = (NodeId, NodeId)> + '_ {
        self.topology.half_edges().map(|h| self.ends(h))
    }

    /// Kites at a circle, counter-clockwise.
    pub(crate) fn kites(&self, node: NodeId) -> Vec<HalfEdgeId> {
        match self.vertex(node) {
            Some(v) => self.topology.outgoing(v).collect(),
            None => {
                let f = FaceId::from_index(node - self.topology.n_vertices());
                self.topology.face_half_edges(f).collect()
            }
        }
    }

    /// Number of kites at a circle.
    pub fn degree(&self, node: NodeId) -> usize {
        match self.vertex(node) {
            Some(v) => self.topology.face_degree(v),
            None => self
                .topology
                .valence(FaceId::from_index(node - self.topology.n_vertices())),
        }
    }
}
