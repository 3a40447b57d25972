//! The mesh whose panels lie in given planes.

use super::{DualityError, OrientedPlane, meet};
use phex_mesh::{HexMesh, PerFace, PerVertex, VertexId};

/// Puts every vertex where the planes of its panels meet: three inside; at the boundary two or one,
/// and there the vertex moves as little as possible. Every panel is planar to rounding.
///
/// # Errors
/// If planes do not meet in one point, or a vertex has more than three panels.
pub(crate) fn envelope(
    mesh: &HexMesh,
    planes: &PerFace<OrientedPlane>,
) -> Result<HexMesh, DualityError> {
    let topology = mesh.topology();
    let place = |vertex: VertexId| {
        let near = mesh.positions[vertex];
        let around: Vec<OrientedPlane> = topology.faces_at(vertex).map(|f| planes[f]).collect();
        let found = (around.len() <= 3).then(|| meet(&around, near)).flatten();
        found.ok_or(DualityError::NoMeet { vertex, near })
    };
    let positions: Result<Vec<_>, _> = topology.vertices().map(place).collect();
    Ok(mesh.with_positions(PerVertex::from_vec(positions?)))
}
