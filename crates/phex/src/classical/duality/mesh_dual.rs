//! The dual of a mesh with planar faces.

use super::{DualityError, OrientedPlane, Quadric};
use phex_mesh::{FaceId, HexMesh, Topology, Vec3, VertexId};

/// The dual of a mesh, and where its elements come from.
#[derive(Clone, Debug)]
pub struct MeshDual {
    /// The dual mesh: a vertex for each face (with a vertex inside), a face for each vertex inside.
    pub mesh: HexMesh,
    /// The face of the original that each vertex of the dual is the pole of.
    pub face_of_vertex: Vec<FaceId>,
    /// The vertex of the original that each face of the dual stands for.
    pub vertex_of_face: Vec<VertexId>,
}

/// The dual of `mesh` with respect to `quadric`: poles of the faces' best planes, joined round
/// every vertex inside.
///
/// Faces run round their poles as the faces of the original run round their vertices. The dual of
/// the dual of a closed mesh is the mesh, elements in their order; of an open one the part whose
/// faces have no vertex on the boundary.
///
/// # Errors
/// If a pole is at infinity, there is no vertex inside, or the dual is no manifold (the original
/// has vertices of degree 2).
pub fn dual_mesh(mesh: &HexMesh, quadric: &Quadric) -> Result<MeshDual, DualityError> {
    let dual = DualTriangles::of(mesh.topology())?;
    let pole = |&face: &FaceId| quadric.pole_of(face, &OrientedPlane::of(mesh, face));
    let positions: Result<Vec<Vec3>, _> = dual.face_of_vertex.iter().map(pole).collect();
    Ok(MeshDual {
        mesh: HexMesh::new(positions?, &dual.triangles)?,
        face_of_vertex: dual.face_of_vertex,
        vertex_of_face: dual.vertex_of_face,
    })
}

/// How the poles are joined: round every vertex inside, in triangles where three faces meet.
pub(crate) struct DualTriangles {
    /// The face that each vertex of the dual is the pole of: those with a vertex inside.
    pub face_of_vertex: Vec<FaceId>,
    /// The vertex that each face of the dual stands for.
    pub vertex_of_face: Vec<VertexId>,
    /// The faces of the dual.
    pub triangles: Vec<Vec<u32>>,
}

impl DualTriangles {
    /// The connectivity of a mesh's dual.
    ///
    /// # Errors
    /// If there is no vertex inside.
    pub fn of(topology: &Topology) -> Result<Self, DualityError> {
        let vertex_of_face: Vec<VertexId> = topology.inner_vertices().collect();
        if vertex_of_face.is_empty() {
            return Err(DualityError::NoInterior);
        }
        let ring = |v: &VertexId| topology.faces_at(*v);
        let mut used = vec![false; topology.n_faces()];
        let around = vertex_of_face.iter().flat_map(ring);
        around.for_each(|f| used[f.index()] = true);
        let face_of_vertex: Vec<FaceId> = topology.faces().filter(|f| used[f.index()]).collect();
        let mut number = vec![0u32; topology.n_faces()];
        for (i, f) in face_of_vertex.iter().enumerate() {
            number[f.index()] = i as u32;
        }
        let triangle = |v| ring(v).map(|f| number[f.index()]).collect();
        Ok(Self {
            triangles: vertex_of_face.iter().map(triangle).collect(),
            face_of_vertex,
            vertex_of_face,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn triangles(name: &str, overrides: &[(&str, f64)]) -> HexMesh {
        let options = TriangulationOptions {
            triangles: 500,
            jitter: 0.2,
            ..Default::default()
        };
        let shape = Shape::from_name(name, overrides).unwrap();
        let surface = triangulate(&shape, &options).unwrap();
        let faces = surface.topology().face_lists();
        HexMesh::new(surface.positions().as_slice().to_vec(), &faces).unwrap()
    }

    #[test]
    fn twice_is_the_mesh_itself() {
        let mesh = triangles("ellipsoid", &[]);
        for centre in [Vec3::zeros(), Vec3::new(0.3, -0.1, 0.2)] {
            let quadric = Quadric::sphere(centre, 0.8).unwrap();
            let dual = dual_mesh(&mesh, &quadric).unwrap().mesh;
            let t = dual.topology();
            assert!(t.vertices().all(|v| t.face_degree(v) == 3));
            let flat = phex_mesh::measure(&dual).planarity.max;
            assert!(flat < 1e-12, "dual faces are planar, not {flat}");
            let back = dual_mesh(&dual, &quadric).unwrap().mesh;
            assert_eq!(back.topology().n_faces(), mesh.topology().n_faces());
            for (p, q) in back.positions.iter().zip(&mesh.positions) {
                assert!((p - q).norm() < 1e-10, "{p:?} {q:?}");
            }
            for f in mesh.topology().faces() {
                let a = mesh.topology().face_vertices(f);
                let b = back.topology().face_vertices(f);
                assert!(
                    (0..3).any(|k| (0..3).all(|i| a[i] == b[(i + k) % 3])),
                    "{a:?} {b:?}"
                );
            }
        }
    }

    #[test]
    fn twice_an_open_mesh_is_what_lies_inside() {
        let mesh = triangles("hyperbolic-paraboloid", &[]);
        let quadric = Quadric::sphere(Vec3::new(0.0, 0.0, -2.0), 1.0).unwrap();
        let once = dual_mesh(&mesh, &quadric).unwrap();
        let twice = dual_mesh(&once.mesh, &quadric).unwrap();
        for (i, v) in twice.face_of_vertex.iter().enumerate() {
            let original = once.vertex_of_face[v.index()];
            let p = twice.mesh.positions.as_slice()[i];
            assert!((p - mesh.positions[original]).norm() < 1e-10);
        }
        assert!(twice.mesh.topology().n_faces() > 100);
    }

    #[test]
    fn face_through_the_centre_is_named() {
        let mesh = triangles("sphere", &[]);
        let face = FaceId::new(7);
        let quadric = Quadric::sphere(mesh.centre(face), 1.0).unwrap();
        let error = dual_mesh(&mesh, &quadric).unwrap_err();
        assert_eq!(error, DualityError::PoleAtInfinity { face });
    }
}
