//! The connectivity of dual subdivision, rim and all.

use super::DualityError;
use phex_mesh::{EdgeId, FaceId, HalfEdgeId, HexMesh, Topology, Vec3, VertexId, numbered};

/// Panels of the next level.
pub(super) struct Refined {
    /// Every old panel in its order, then one for each of [`Self::edges`]. Vertices inside are
    /// where [`super::chamfer()`] puts them, those at the boundary on it.
    pub mesh: HexMesh,
    /// The edges inside.
    pub edges: Vec<EdgeId>,
}

/// Shrinks every panel and puts one in place of every edge inside. Along the boundary, the panel of
/// an edge that ends there takes a share of both its neighbours' parts.
///
/// # Errors
/// If three panels meet in a vertex at the boundary, or the result is no manifold.
pub(super) fn refined(mesh: &HexMesh) -> Result<Refined, DualityError> {
    let topology = mesh.topology();
    let crowded = topology
        .boundary_vertices()
        .find(|v| topology.face_degree(*v) > 2);
    if let Some(vertex) = crowded {
        return Err(DualityError::Crowded { vertex });
    }
    let edges: Vec<EdgeId> = topology.inner_edges().collect();
    let old = topology.faces().map(|f| shrunk(topology, f));
    let new = edges.iter().map(|e| of_edge(topology, *e));
    let (corners, faces) = numbered(old.chain(new));
    let positions = corners.iter().map(|c| place(mesh, *c)).collect();
    Ok(Refined {
        mesh: HexMesh::new(positions, &faces)?,
        edges,
    })
}

/// A vertex of the next level.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum RefinedVertex {
    /// An old one.
    Old(VertexId),
    /// The corner that a panel has at the origin of a half-edge.
    New(HalfEdgeId),
}

/// An old panel; corners at the boundary that no other panel has stay.
fn shrunk(topology: &Topology, f: FaceId) -> Vec<RefinedVertex> {
    let corner = |h| {
        let v = topology.origin(h);
        if topology.face_degree(v) == 1 {
            RefinedVertex::Old(v)
        } else {
            RefinedVertex::New(h)
        }
    };
    topology.face_half_edges(f).map(corner).collect()
}

/// The panel of an edge inside.
fn of_edge(topology: &Topology, e: EdgeId) -> Vec<RefinedVertex> {
    let h = topology.edge_half_edge(e);
    let side = |h: HalfEdgeId| [RefinedVertex::New(topology.next(h)), RefinedVertex::New(h)];
    let twin = topology.twin(h).map(side);
    let [a, b] = [topology.origin(h), topology.target(h)].map(RefinedVertex::Old);
    let mut outline = vec![a];
    outline.extend(twin.into_iter().flatten());
    outline.push(b);
    outline.extend(side(h));
    outline
}

fn place(mesh: &HexMesh, corner: RefinedVertex) -> Vec3 {
    let topology = mesh.topology();
    let h = match corner {
        RefinedVertex::Old(v) => return mesh.positions[v],
        RefinedVertex::New(h) => h,
    };
    let here = mesh.positions[topology.origin(h)];
    let along = [
        (h, topology.target(h)),
        (topology.prev(h), topology.origin(topology.prev(h))),
    ];
    let along = along
        .into_iter()
        .find(|(side, _)| topology.twin(*side).is_none());
    let (towards, share) = match along {
        // The boundary vertex between two panels moves into one of them; what is left of a single
        // edge is shared with its other end.
        Some((_, other)) if topology.face_degree(other) == 1 => (mesh.positions[other], 0.5),
        Some((_, other)) => (mesh.positions[other], 0.25),
        None => (mesh.centre(topology.face(h)), 0.5),
    };
    here + (towards - here) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classical::dual_subdivision::chamfer;
    use crate::classical::power_diagram::goldberg;

    #[test]
    fn of_closed_meshes_is_the_chamfer() {
        let mesh = goldberg(2, 1).unwrap().mesh;
        let (made, chamfered) = (refined(&mesh).unwrap().mesh, chamfer(&mesh).unwrap());
        for f in chamfered.topology().faces() {
            let pairs = made.corners(f).zip(chamfered.corners(f));
            assert!(
                pairs.into_iter().all(|(p, q)| (p - q).norm() < 1e-14),
                "{f}"
            );
        }
        assert_eq!(made.topology().n_faces(), chamfered.topology().n_faces());
    }

    #[test]
    fn open_meshes_keep_their_boundary() {
        let at = |&(x, y): &(f64, f64)| Vec3::new(x, y, 0.0);
        let corners = [
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (0.0, 1.0),
            (0.0, -1.0),
            (2.0, -1.0),
        ];
        let mesh = HexMesh::new(
            corners.iter().map(at).collect(),
            &[[0, 1, 2, 3], [0, 4, 5, 1]],
        )
        .unwrap();
        let made = refined(&mesh).unwrap();
        let measures = phex_mesh::measure(&made.mesh);
        assert_eq!((measures.faces, measures.boundary_loops), (3, 1));
        assert_eq!(made.edges.len(), 1);
        assert!((measures.area - 4.0).abs() < 1e-12, "{}", measures.area);
    }
}
