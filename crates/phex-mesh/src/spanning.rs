//! Spanning forests of the vertices and of the faces that share no edge.
//!
//! The edges of neither forest are one for each generator of the homology (tree-cotree
//! decomposition, D. Eppstein, "Dynamic generators of topologically embedded graphs", 2003).

use crate::ids::{EdgeId, FaceId, VertexId};
use crate::per_element::{PerEdge, PerFace, PerVertex};
use crate::topology::Topology;
use std::collections::VecDeque;

/// The edge by which a spanning forest reaches a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForestStep {
    /// The vertex nearer to the root.
    pub from: VertexId,
    /// The vertex that is reached.
    pub to: VertexId,
    /// The edge between them.
    pub edge: EdgeId,
}

/// Spanning forest of the vertices over some edges, breadth first from each of `roots` that those
/// before it do not reach. Every other vertex comes once, after the one that it is reached from.
pub fn spanning_forest(
    topology: &Topology,
    roots: impl IntoIterator<Item = VertexId>,
    is_usable: impl Fn(EdgeId) -> bool,
) -> Vec<ForestStep> {
    let mut seen = PerVertex::filled(topology.n_vertices(), false);
    let (mut steps, mut queue) = (Vec::new(), VecDeque::new());
    for root in roots {
        if !std::mem::replace(&mut seen[root], true) {
            queue.push_back(root);
        }
        while let Some(from) = queue.pop_front() {
            for (edge, to) in topology.spokes(from) {
                if is_usable(edge) && !std::mem::replace(&mut seen[to], true) {
                    steps.push(ForestStep { from, to, edge });
                    queue.push_back(to);
                }
            }
        }
    }
    steps
}

/// Spanning forest of the faces and of the outside of the boundary, which is one node.
#[derive(Clone, Debug)]
pub struct Cotree {
    /// Faces, breadth first, and the edges that lead from them towards the root; `None` for roots
    /// and for the faces that were given.
    pub faces: Vec<(FaceId, Option<EdgeId>)>,
    /// Edges that are neither crossed nor were in use, in order.
    pub generators: Vec<EdgeId>,
}

impl Cotree {
    /// Crosses edges that are not in use, those of a forest of the vertices say, first from the
    /// outside. Some faces may be given as beside the outside already.
    pub fn new(
        topology: &Topology,
        mut is_used: PerEdge<bool>,
        at_outside: impl IntoIterator<Item = FaceId>,
    ) -> Self {
        let mut seen = PerFace::filled(topology.n_faces(), false);
        let mut faces: Vec<(FaceId, Option<EdgeId>)> = Vec::with_capacity(topology.n_faces());
        for f in at_outside {
            seen[f] = true;
            faces.push((f, None));
        }
        for e in topology.boundary_edges() {
            let f = topology.face(topology.edge_half_edge(e));
            if !is_used[e] && !std::mem::replace(&mut seen[f], true) {
                is_used[e] = true;
                faces.push((f, Some(e)));
            }
        }
        let (mut roots, mut next) = (topology.faces(), 0);
        loop {
            while let Some(&(f, _)) = faces.get(next) {
                for h in topology.face_half_edges(f) {
                    let (e, across) = (topology.edge(h), topology.across(h));
                    let Some(g) = across.filter(|g| !is_used[e] && !seen[*g]) else {
                        continue;
                    };
                    (is_used[e], seen[g]) = (true, true);
                    faces.push((g, Some(e)));
                }
                next += 1;
            }
            let Some(root) = roots.find(|f| !seen[*f]) else {
                break;
            };
            seen[root] = true;
            faces.push((root, None));
        }
        let generators = topology.edges().filter(|e| !is_used[*e]).collect();
        Self { faces, generators }
    }
}
