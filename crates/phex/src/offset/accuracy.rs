//! How far the distances of a finished offset are from what was asked for, measured on its
//! coordinates.

use super::OffsetError;
use super::face_offset::face_normals;
use super::gauss_image::OffsetKind;
use phex_mesh::{EdgeId, HexMesh, PerFace, Vec3};

/// Largest error of the distances of faces, edges or vertices (whichever `kind` says) of `moved`
/// from those of `mesh`, in model units.
///
/// ```
/// # use phex_mesh::{EdgeId, HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetKind, OffsetOptions, distance_error, face_gauss_image};
///
/// let outer = face_gauss_image(&cube, &OffsetOptions::default())?.offset(&cube, 0.1);
/// assert!(distance_error(&cube, &outer, OffsetKind::Face, 0.1)? < 1e-15);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If a face of `mesh` has no area.
///
/// # Panics
/// If the connectivity differs.
pub fn distance_error(
    mesh: &HexMesh,
    moved: &HexMesh,
    kind: OffsetKind,
    distance: f64,
) -> Result<f64, OffsetError> {
    let wish = distance.abs();
    let topology = mesh.topology();
    Ok(match kind {
        OffsetKind::Face => {
            let distances = PerFace::filled(topology.n_faces(), distance);
            face_distance_error(mesh, moved, &distances)?
        }
        OffsetKind::Edge => edge_distance_error(mesh, moved, distance, |_| true),
        OffsetKind::Vertex => largest(
            topology
                .vertices()
                .map(|v| (moved.position(v) - mesh.position(v)).norm() - wish),
        ),
    })
}

/// Largest error of the distances of some edges, in model units.
pub(super) fn edge_distance_error(
    mesh: &HexMesh,
    moved: &HexMesh,
    distance: f64,
    counts: impl Fn(EdgeId) -> bool,
) -> f64 {
    let topology = mesh.topology();
    largest(topology.edges().filter(|e| counts(*e)).flat_map(|e| {
        let along = mesh.edge_vector(e).normalize();
        let away = |v| (moved.position(v) - mesh.position(v)).cross(&along).norm();
        (topology.edge_vertices(e)).map(|v| away(v) - distance.abs())
    }))
}

/// Largest error of the distances of the faces from those that were asked for, in model units.
///
/// # Errors
/// If a face of `mesh` has no area.
///
/// # Panics
/// If the connectivity differs.
pub fn face_distance_error(
    mesh: &HexMesh,
    moved: &HexMesh,
    distances: &PerFace<f64>,
) -> Result<f64, OffsetError> {
    let normals = face_normals(mesh)?;
    let along = |f, (p, q): (Vec3, Vec3)| (q - p).dot(&normals[f]) - distances[f];
    let corners = |f| mesh.corners(f).zip(moved.corners(f));
    let faces = mesh.topology().faces();
    Ok(largest(
        faces.flat_map(|f| corners(f).map(move |pair| along(f, pair))),
    ))
}

fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    phex_numeric::largest(errors.map(f64::abs))
}
