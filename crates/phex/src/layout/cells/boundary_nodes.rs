//! Vertices that panels have along a curved boundary, so that their straight edges stay close to
//! it.

use super::complex::{CellComplex, Node};
use crate::layout::place;
use phex_mesh::polygon::{point_segment_distance, sides};
use phex_mesh::{PerVertex, Topology, TriangleSurface, Vec3, VertexId};
use std::collections::HashSet;

/// Largest distance between the boundary and the panels' edges, bounding-box diagonals.
const TOLERANCE: f64 = 0.002;

/// Adds nodes to the outlines wherever the boundary stands off from the straight edge between two
/// nodes: the farthest vertex of the boundary first, as in the line simplification of Douglas and
/// Peucker. A hole between two panels gets a node on either side, however small it is: two edges
/// between the same nodes would be one, and the hole closed.
pub(crate) fn follow_boundary(surface: &TriangleSurface, complex: &mut CellComplex) {
    let next = next_on_boundary(surface.topology());
    let tolerance = TOLERANCE * surface.diagonal();
    let outlines = complex.panels.iter();
    let all: HashSet<[Node; 2]> = outlines.flat_map(|(_, outline)| sides(outline)).collect();
    for (label, outline) in &mut complex.panels {
        let mut refined = Vec::with_capacity(outline.len());
        for [from, to] in sides(outline) {
            refined.push(from);
            let path = path(surface.topology(), &next, &complex.label, *label, from, to);
            let least = match all.contains(&[to, from]) {
                true => 0.0,
                false => tolerance,
            };
            let ends = [from, to].map(|node| place(surface, node));
            split(surface, &path, ends, [least, tolerance], &mut refined);
        }
        *outline = refined;
    }
}

/// The next vertex along the boundary.
fn next_on_boundary(topology: &Topology) -> PerVertex<Option<VertexId>> {
    PerVertex::from_fn(topology.n_vertices(), |v| {
        let along = topology.outgoing(v).next()?;
        topology
            .twin(along)
            .is_none()
            .then(|| topology.target(along))
    })
}

/// Vertices of the boundary between two nodes of a cell's outline; none if they are not joined
/// along the boundary.
fn path(
    topology: &Topology,
    next: &PerVertex<Option<VertexId>>,
    label: &PerVertex<u32>,
    cell: u32,
    from: Node,
    to: Node,
) -> Vec<VertexId> {
    let entry = |node: Node| match node {
        Node::Edge(e) if topology.is_boundary_edge(e) => Some(topology.edge_vertices(e)),
        Node::Corner(v) => Some([v, next[v]?]),
        _ => None,
    };
    let end = |node: Node| match node {
        Node::Edge(e) if topology.is_boundary_edge(e) => Some(topology.edge_vertices(e)[1]),
        Node::Corner(v) => Some(v),
        _ => None,
    };
    let (Some([_, mut at]), Some(last)) = (entry(from), end(to)) else {
        return Vec::new();
    };
    let mut path = Vec::new();
    while at != last {
        let Some(following) = next[at].filter(|_| label[at] == cell) else {
            return Vec::new();
        };
        path.push(at);
        at = following;
    }
    path
}

/// Adds the vertex of a path that is farthest from the segment between its ends, if that is at
/// `least` so far, and others that `then` are.
fn split(
    surface: &TriangleSurface,
    path: &[VertexId],
    [from, to]: [Vec3; 2],
    [least, then]: [f64; 2],
    outline: &mut Vec<Node>,
) {
    let distance = |v: &VertexId| point_segment_distance(surface.positions()[*v], from, to);
    let farthest =
        (0..path.len()).max_by(|&i, &k| distance(&path[i]).total_cmp(&distance(&path[k])));
    let Some(i) = farthest.filter(|&i| distance(&path[i]) >= least) else {
        return;
    };
    let middle = surface.positions()[path[i]];
    split(surface, &path[..i], [from, middle], [then; 2], outline);
    outline.push(Node::Rim(path[i]));
    split(surface, &path[i + 1..], [middle, to], [then; 2], outline);
}
