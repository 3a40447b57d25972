//! Whether a mesh has the graph of a convex polyhedron.

use super::KoebeError;
use phex_mesh::{EdgeId, FaceId, PerFace, Topology, VertexId};

/// Whether the faces are the cells of a 3-connected graph on the sphere or, if the mesh has a
/// boundary, become one when a vertex outside is joined to every boundary vertex.
///
/// A graph drawn on the sphere is 3-connected if and only if every vertex has three neighbours and
/// two faces share nothing, a vertex, or an edge with its ends: otherwise a closed curve through
/// two faces and two vertices cuts it.
pub(super) fn check(topology: &Topology) -> Result<(), KoebeError> {
    check_surface(topology)?;
    check_degrees(topology)?;
    check_common_vertices(topology)
}

fn check_surface(t: &Topology) -> Result<(), KoebeError> {
    let components = t.components().1;
    if components > 1 {
        return Err(KoebeError::Components { components });
    }
    let boundary_loops = t.boundary_loops().len();
    if boundary_loops > 1 {
        return Err(KoebeError::BoundaryLoops { boundary_loops });
    }
    let genus = (2 - boundary_loops as i64 - t.euler_characteristic()) / 2;
    if genus != 0 {
        return Err(KoebeError::Genus { genus });
    }
    Ok(())
}

fn check_degrees(t: &Topology) -> Result<(), KoebeError> {
    for v in t.inner_vertices() {
        let degree = t.edge_degree(v);
        if degree < 3 {
            return Err(KoebeError::LowDegree { vertex: v, degree });
        }
    }
    Ok(())
}

fn check_common_vertices(t: &Topology) -> Result<(), KoebeError> {
    // Vertex at which each face was last met on the tour round another face.
    let mut met: PerFace<Option<(FaceId, VertexId)>> = PerFace::filled(t.n_faces(), None);
    for f in t.faces() {
        for &v in t.face_vertices(f) {
            for g in t.faces_at(v).filter(|&g| g > f) {
                if let Some((_, w)) = met[g].filter(|&(tour, _)| tour == f)
                    && !share_edge(t, [f, g], [v, w])
                {
                    let (vertices, faces) = ([v.min(w), v.max(w)], [f, g]);
                    return Err(KoebeError::SeparatingPair { vertices, faces });
                }
                met[g] = Some((f, v));
            }
        }
    }
    Ok(())
}

/// Whether two faces lie to the two sides of an edge between two vertices.
fn share_edge(t: &Topology, faces: [FaceId; 2], vertices: [VertexId; 2]) -> bool {
    edges_between(t, vertices).any(|e| {
        let sides: Vec<FaceId> = t.edge_faces(e).collect();
        faces.iter().all(|f| sides.contains(f))
    })
}

fn edges_between(t: &Topology, [v, w]: [VertexId; 2]) -> impl Iterator<Item = EdgeId> + '_ {
    let from = |a: VertexId, b: VertexId| {
        t.outgoing(a)
            .filter(move |&h| t.target(h) == b)
            .map(|h| t.edge(h))
    };
    from(v, w).chain(from(w, v))
}
