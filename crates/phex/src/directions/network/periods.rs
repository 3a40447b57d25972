//! Multivalued functions: one value per vertex and one period per loop that can't be contracted.
//!
//! A spanning tree of the vertices and one of the triangles (with the outside of the boundary as a
//! node) that share no edge leave `2 g + b - 1` edges on a surface of genus `g` with `b` boundaries
//! (`2 g` on a closed one). Each of them closes a loop; the closed integer cochain that belongs to
//! it is 1 on it, 0 on the others and on the tree of the vertices, and follows on all other edges
//! because it sums to 0 round each triangle (tree-cotree decomposition, D. Eppstein 2003).

use phex_mesh::{Cotree, EdgeId, FaceId, PerEdge, Topology, spanning_forest};

/// Closed integer cochains, a basis modulo differences of vertex values: for each, its value along
/// the half-edge of every edge.
pub(crate) fn cochain_basis(topology: &Topology) -> Vec<PerEdge<i32>> {
    let mut is_used = PerEdge::filled(topology.n_edges(), false);
    for step in spanning_forest(topology, topology.vertices(), |_| true) {
        is_used[step.edge] = true;
    }
    let cotree = Cotree::new(topology, is_used, []);
    let of = |e: &EdgeId| cochain(topology, &cotree.faces, *e);
    cotree.generators.iter().map(of).collect()
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
            .map(|h| topology.along(h, value[topology.edge(h)]))
            .sum();
        let is_left = topology.face(topology.edge_half_edge(exit)) == f;
        value[exit] = if is_left { -sum } else { sum };
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
                    .map(|h| topology.along(h, cochain[topology.edge(h)]));
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
