//! Face-distance offset: every face moves along its normal, every vertex to where its moved faces
//! meet.

use super::gauss_image::{GaussImage, OffsetKind};
use super::vertex_normal::{Displacement, TrivalentVertex, minimum_norm, three_face_displacement};
use super::{OffsetError, OffsetOptions};
use phex_mesh::{
    FlatFace, HalfEdgeId, HexMesh, PerFace, PerVertex, ValidateOptions, Vec3, VertexId,
};

/// Residual, over the largest distance, above which no point is called common to the moved planes.
const COMMON_POINT: f64 = 1e-9;

/// The displacement of every vertex for given distances of the faces.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceOffset {
    /// Displacements with their error estimates.
    pub vertices: PerVertex<Displacement>,
    /// Unit normals of the faces, by their winding.
    pub normals: PerFace<Vec3>,
}

impl FaceOffset {
    /// The mesh with every vertex displaced; that it is valid is not implied.
    ///
    /// # Panics
    /// If `mesh` has another number of vertices.
    pub fn apply(&self, mesh: &HexMesh) -> HexMesh {
        let moved = |(x, d): (&Vec3, &Displacement)| x + d.vector;
        let positions = mesh.positions.iter().zip(&self.vertices).map(moved);
        mesh.with_positions(PerVertex::from_vec(positions.collect()))
    }

    /// The vertex with the largest error estimate, and that estimate (relative to its
    /// displacement).
    pub fn worst(&self) -> (VertexId, f64) {
        let worse = |a: (VertexId, f64), b: (VertexId, f64)| if b.1 > a.1 { b } else { a };
        let errors = self.vertices.enumerate().map(|(v, d)| (v, d.error));
        errors.reduce(worse).unwrap_or((VertexId::new(0), 0.0))
    }

    /// The displacements as a Gauss image; meant for distances that are all 1.
    pub fn into_image(self) -> GaussImage {
        GaussImage {
            kind: OffsetKind::Face,
            positions: self.vertices.map(|d| d.vector),
        }
    }
}

/// The Gauss image whose faces touch the unit sphere.
///
/// # Errors
/// See [`face_offset`].
pub fn face_gauss_image(
    mesh: &HexMesh,
    options: &OffsetOptions,
) -> Result<GaussImage, OffsetError> {
    let ones = PerFace::filled(mesh.topology().n_faces(), 1.0);
    Ok(face_offset(mesh, &ones, options)?.into_image())
}

/// Displacements that move every face by its own distance along its normal. On the boundary, where
/// fewer than three faces meet, vertices move by the shortest such vector; edges of the boundary
/// may turn by that in the planes of their faces ([`GaussImage::turned_edges`]).
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetOptions, face_offset};
/// use phex_mesh::{PerFace, VertexId};
///
/// // The last face alone moves outwards.
/// let mut distances = PerFace::filled(6, 0.0);
/// distances[phex_mesh::FaceId::new(5)] = 0.25;
/// let moved = face_offset(&cube, &distances, &OffsetOptions::default())?.apply(&cube);
/// let corner = moved.position(VertexId::new(7));
/// assert!((corner - Vec3::new(1.25, 1.0, 1.0)).norm() < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If a face is not planar or a vertex has not three faces (at most three on the boundary), or
/// faces that lie in one plane are asked to part.
pub fn face_offset(
    mesh: &HexMesh,
    distances: &PerFace<f64>,
    options: &OffsetOptions,
) -> Result<FaceOffset, OffsetError> {
    check_planar_mesh(mesh, &options.validity, MOST_AT_BOUNDARY)?;
    check_distances(mesh, distances)?;
    let normals = face_normals(mesh)?;
    let largest = distances.iter().fold(0.0f64, |m, d| m.max(d.abs()));
    let at = |v| displacement(mesh, &normals, distances, v);
    let vertices: Vec<Displacement> = mesh.topology().vertices().map(at).collect();
    let met = |d: &Displacement| d.residual <= COMMON_POINT * largest;
    if let Some(index) = vertices.iter().position(|d| !met(d)) {
        return Err(OffsetError::Incompatible {
            vertex: VertexId::new(index as u32),
            residual: vertices[index].residual,
        });
    }
    Ok(FaceOffset {
        vertices: PerVertex::from_vec(vertices),
        normals,
    })
}

fn displacement(
    mesh: &HexMesh,
    normals: &PerFace<Vec3>,
    distances: &PerFace<f64>,
    vertex: VertexId,
) -> Displacement {
    let topology = mesh.topology();
    let corners: Vec<HalfEdgeId> = topology.outgoing(vertex).collect();
    let faces = corners.iter().map(|&h| topology.face(h));
    let (n, d): (Vec<Vec3>, Vec<f64>) = faces.map(|f| (normals[f], distances[f])).unzip();
    if topology.is_boundary_vertex(vertex) || n.len() != 3 {
        return minimum_norm(&n, &d);
    }
    let at = mesh.position(vertex);
    let vertex = TrivalentVertex {
        normals: [n[0], n[1], n[2]],
        edges: std::array::from_fn(|k| mesh.position(topology.target(corners[k])) - at),
    };
    three_face_displacement(&vertex, &[d[0], d[1], d[2]])
}

/// Unit normals by Newell's sum, which keeps the relative accuracy of every component in flat and
/// in squashed meshes.
///
/// # Errors
/// If a face has no area.
pub fn face_normals(mesh: &HexMesh) -> Result<PerFace<Vec3>, OffsetError> {
    let topology = mesh.topology();
    let normal = |face| {
        mesh.area_vector(face)
            .try_normalize(0.0)
            .filter(|n| n.iter().all(|x| x.is_finite()))
            .ok_or(OffsetError::NoArea { face })
    };
    let normals: Result<Vec<Vec3>, OffsetError> = topology.faces().map(normal).collect();
    normals.map(PerFace::from_vec)
}

/// Most faces at a vertex of the boundary where all of them say how it moves.
pub(super) const MOST_AT_BOUNDARY: usize = 3;

/// Checks coordinates, vertex degrees and planarity.
pub(super) fn check_planar_mesh(
    mesh: &HexMesh,
    limits: &ValidateOptions,
    most_at_boundary: usize,
) -> Result<(), OffsetError> {
    let broken = |p: &Vec3| !p.iter().all(|x| x.is_finite());
    if let Some((vertex, _)) = mesh.positions.enumerate().find(|(_, p)| broken(p)) {
        return Err(OffsetError::NotFinite { vertex });
    }
    let topology = mesh.topology();
    for vertex in topology.vertices() {
        let degree = topology.face_degree(vertex);
        let held = match topology.is_boundary_vertex(vertex) {
            true => degree <= most_at_boundary,
            false => degree == 3,
        };
        if !held {
            return Err(OffsetError::WrongDegree { vertex, degree });
        }
    }
    let (unit, limit) = (mesh.mean_edge(), limits.planarity_limit(mesh));
    let faces = FlatFace::all(mesh);
    let planar = |f: &FlatFace| f.planarity_length <= limit * unit;
    match faces.enumerate().find(|(_, f)| !planar(f)) {
        Some((face, flat)) => Err(OffsetError::NotPlanar {
            face,
            planarity: flat.planarity_length / unit,
            limit,
        }),
        None => Ok(()),
    }
}

fn check_distances(mesh: &HexMesh, distances: &PerFace<f64>) -> Result<(), OffsetError> {
    let (found, expected) = (distances.len(), mesh.topology().n_faces());
    if found != expected {
        return Err(OffsetError::DistanceCount { found, expected });
    }
    match distances.iter().find(|d| !d.is_finite()) {
        Some(&distance) => Err(OffsetError::Distance { distance }),
        None => Ok(()),
    }
}
