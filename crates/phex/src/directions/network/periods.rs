//! Multivalued functions: one value per vertex and one period per loop that can't be contracted.
//!
//! A spanning tree of the vertices and one of the triangles (with the outside of the boundary as a
//! node) that share no edge leave `2 g + b - 1` edges on a surface of genus `g` with `b` boundaries
//! (`2 g` on a closed one). Each of them closes a loop; the closed integer cochain that belongs to
//! it is 1 on it, 0 on the others and on the tree of the vertices, and follows on all other edges
//! because it sums to 0 round each triangle (tree-cotree decomposition, D. Eppstein 2003).

use phex_mesh::{EdgeId, FaceId, PerEdge, PerFace, PerVertex, Topology, VertexId};
use std::collections::VecDeque;

/// Closed integer cochains, a basis modulo differences of vertex values: for each, its value along
/// the half-edge of every edge.
pub(crate) fn cochain_basis(topology: &Topology) -> Vec<PerEdge<i32>> {
    let mut role = PerEdge::filled(topology.n_edges(), Role::Generator);
    grow_vertex_tree(topology, &mut role);
    let order = grow_face_tree(topology, &mut role);
    topology
        .edges()
        .filter(|&e| role[e] == Role::Generator)
        .map(|e| cochain(topology, &order, e))
        .collect()
}

/// Value of a cochain along a half-edge.
pub(crate) fn along(topology: &Topology, cochain: &PerEdge<i32>, h: phex_mesh::HalfEdgeId) -> i32 {
    let e = topology.edge(h);
    if topology.edge_half_edge(e) == h {
        cochain[e]
    } else {
        -cochain[e]
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Generator,
    VertexTree,
    FaceTree,
}

fn grow_vertex_tree(topology: &Topology, role: &mut PerEdge<Role>) {
    let mut seen = PerVertex::filled(topology.n_vertices(), false);
    let first = VertexId::new(0);
    seen[first] = true;
    let mut queue = VecDeque::from([first]);
    while let Some(v) = queue.pop_front() {
        for h in topology.outgoing(v).flat_map(|h| [h, topology.prev(h)]) {
            let e = topology.edge(h);
            let [a, b] = topology.edge_vertices(e);
            let w = if a == v { b } else { a };
            if !seen[w] {
                seen[w] = true;
                role[e] = Role::VertexTree;
                queue.push_back(w);
            }
        }
    }
}

/// Faces in the order in which the tree reaches them, each with the edge that leads towards the
/// root.
fn grow_face_tree(topology: &Topology, role: &mut PerEdge<Role>) -> Vec<(FaceId, Option<EdgeId>)> {
    let mut seen = PerFace::filled(topology.n_faces(), false);
    let mut order: Vec<(FaceId, Option<EdgeId>)> = Vec::with_capacity(topology.n_faces());
    for e in topology.edges() {
        let f = topology.face(topology.edge_half_edge(e));
        if topology.is_boundary_edge(e) && role[e] == Role::Generator && !seen[f] {
            seen[f] = true;
            role[e] = Role::FaceTree;
            order.push((f, Some(e)));
        }
    }
    if order.is_empty() {
        seen[FaceId::new(0)] = true;
        order.push((FaceId::new(0), None));
    }
    let mut next = 0;
    while next < order.len() {
        for h in topology.face_half_edges(order[next].0) {
            let (e, twin) = (topology.edge(h), topology.twin(h));
            let Some(g) = twin.map(|t| topology.face(t)) else {
                continue;
            };
            if role[e] == Role::Generator && !seen[g] {
                seen[g] = true;
                role[e] = Role::FaceTree;
                order.push((g, Some(e)));
            }
        }
        next += 1;
    }
    order
}

/// From the leaves of the tree of faces to its root, every face determines the edge that leads on.
fn cochain(
    topology: &Topology,
    order: &[(FaceId, Option<EdgeId>)],
    generator: EdgeId,
) -> PerEdge<i32> {
    let mut value = PerEdge::filled(topology.n_edges(), 0);
    value[generator] = 1;
    for &(f, exit) in order.iter().rev() {
        let Some(exit) = exit else { continue };
        let sum: i32 = topology
            .face_half_edges(f)
            .map(|h| along(topology, &value, h))
            .sum();
        let sign = if topology.face(topology.edge_half_edge(exit)) == f {
            1
        } else {
            -1
        };
        value[exit] = -sign * sum;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn count(name: &str) -> usize {
        let shape = Shape::from_name(name, &[]).unwrap();
        let options = TriangulationOptions {
            triangles: 300,
            ..Default::default()
        };
        let surface = triangulate(&shape, &options).unwrap();
        let topology = surface.topology();
        let basis = cochain_basis(topology);
        for cochain in &basis {
            for f in topology.faces() {
                let turn = topology
                    .face_half_edges(f)
                    .map(|h| along(topology, cochain, h));
                assert_eq!(turn.sum::<i32>(), 0, "{name}: closed");
            }
        }
        basis.len()
    }

    #[test]
    fn basis_has_one_cochain_per_independent_loop() {
        assert_eq!(
            ["sphere", "torus", "catenoid", "wave"].map(count),
            [0, 2, 1, 0]
        );
    }
}
