//! The connectivity of dual subdivision, made in space.

use phex_mesh::{HalfEdgeId, HexMesh, TopologyError, Vec3};

/// Shrinks every face to half its size about the mean of its corners and puts a face in place of
/// every edge; a boundary edge gets half a face. Vertices stay, three faces at each of those
/// inside.
///
/// The first faces are the old ones, in their order; those of the edges follow. On a regular
/// hexagonal mesh this is the dual of splitting triangles in four.
///
/// # Errors
/// If the mesh is so degenerate that the result is no manifold.
pub(crate) fn chamfer(mesh: &HexMesh) -> Result<HexMesh, TopologyError> {
    let topology = mesh.topology();
    let n = topology.n_vertices() as u32;
    let inner = |h: HalfEdgeId| n + h.index() as u32;
    let half =
        |h: HalfEdgeId| (mesh.positions[topology.origin(h)] + mesh.centre(topology.face(h))) * 0.5;
    let positions: Vec<Vec3> = mesh
        .positions
        .iter()
        .copied()
        .chain(topology.half_edges().map(half))
        .collect();
    let old = topology
        .faces()
        .map(|f| topology.face_half_edges(f).map(inner).collect());
    let of_edge = |e| {
        let h = topology.edge_half_edge(e);
        let [a, b] = [topology.origin(h), topology.target(h)].map(|v| v.index() as u32);
        let mut face = vec![a];
        if let Some(twin) = topology.twin(h) {
            face.extend([inner(topology.next(twin)), inner(twin)]);
        }
        face.extend([b, inner(topology.next(h)), inner(h)]);
        face
    };
    let faces: Vec<Vec<u32>> = old.chain(topology.edges().map(of_edge)).collect();
    HexMesh::new(positions, &faces)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::classical::power_diagram::goldberg;

    #[test]
    fn a_dodecahedron_becomes_the_polyhedron_of_42_faces() {
        let mesh = chamfer(&goldberg(1, 0).unwrap().mesh).unwrap();
        let t = mesh.topology();
        assert_eq!(
            (t.n_faces(), t.n_vertices(), t.euler_characteristic()),
            (42, 80, 2)
        );
        assert!(t.vertices().all(|v| t.face_degree(v) == 3));
        // Outward orientation is kept.
        for f in t.faces() {
            let plane = phex_mesh::FacePlane::of(&mesh, f);
            assert!(plane.normal.dot(&plane.centre) > 0.0);
        }
    }

    #[test]
    fn an_open_mesh_keeps_its_boundary() {
        let corners = [
            (0.0, 0.0),
            (2.0, 0.0),
            (2.0, 1.0),
            (0.0, 1.0),
            (0.0, -1.0),
            (2.0, -1.0),
        ];
        let positions = corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect();
        let mesh = HexMesh::new(positions, &[[0, 1, 2, 3], [0, 4, 5, 1]]).unwrap();
        let fine = chamfer(&mesh).unwrap();
        let t = fine.topology();
        assert_eq!(t.n_faces(), 2 + 7);
        assert_eq!(t.boundary_loops().len(), 1);
        assert_eq!(t.boundary_loops()[0].len(), 6);
        assert_eq!(t.euler_characteristic(), 1);
    }
}
