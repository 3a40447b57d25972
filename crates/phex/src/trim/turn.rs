//! Panels turned in place: their vertices move along the third edges, so that all panels stay
//! planar.

use phex_mesh::{FaceId, FlatFace, HexMesh, Vec3, VertexId};
use std::collections::BTreeSet;

/// The mesh with two neighbours turned towards each other by these angles (radians), each round its
/// centre; `None` where an edge lies in the new plane.
pub(super) fn turned(mesh: &HexMesh, faces: [FaceId; 2], angles: [f64; 2]) -> Option<HexMesh> {
    let normals = faces.map(|f| FlatFace::of(mesh, f).normal());
    let axis = normals[0].cross(&normals[1]).try_normalize(0.0)?;
    let first = with_normal(mesh, faces[0], &rotated(normals[0], axis, angles[0]))?;
    with_normal(&first, faces[1], &rotated(normals[1], axis, -angles[1]))
}

/// A vector that is perpendicular to `axis`, turned about it.
fn rotated(v: Vec3, axis: Vec3, angle: f64) -> Vec3 {
    v * angle.cos() + axis.cross(&v) * angle.sin()
}

/// The mesh with a face in the plane with another normal through its centre. Each of its vertices
/// moves along the edge that leaves the face there, in which the planes of the other two faces
/// meet; one that no other face has moves along the normal.
fn with_normal(mesh: &HexMesh, face: FaceId, normal: &Vec3) -> Option<HexMesh> {
    let topology = mesh.topology();
    let own: BTreeSet<VertexId> = topology.face_vertices(face).iter().copied().collect();
    let centre = mesh.centre(face);
    let mut positions = mesh.positions.clone();
    for &v in topology.face_vertices(face) {
        let leaving: Vec<VertexId> = (topology.neighbours(v).into_iter())
            .filter(|w| !own.contains(w))
            .collect();
        let direction = match leaving[..] {
            [] if topology.face_degree(v) == 1 => *normal,
            [w] => mesh.position(w) - mesh.position(v),
            // Both other faces go on along the face's own edges, or there are more of them: no way
            // to move.
            _ => return None,
        };
        let slope = normal.dot(&direction);
        let t = normal.dot(&(centre - mesh.position(v))) / slope;
        if !t.is_finite() {
            return None;
        }
        positions[v] += direction * t;
    }
    Some(mesh.with_positions(positions))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turned_panels_meet_at_the_angle_asked_for_and_all_stay_planar() {
        // A box: all vertices have three faces.
        let corner = |k: usize| {
            let bit = |b: usize| f64::from(u8::from(k & b != 0));
            Vec3::new(bit(1), 1.3 * bit(2), 0.8 * bit(4))
        };
        let faces: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let mesh = HexMesh::new((0..8).map(corner).collect(), &faces).unwrap();
        let (top, side) = (FaceId::new(1), FaceId::new(5));
        let moved = turned(&mesh, [top, side], [0.1, 0.25]).unwrap();
        let [a, b] = [top, side].map(|f| FlatFace::of(&moved, f).normal());
        let angle = a.cross(&b).norm().atan2(a.dot(&b));
        assert!((angle - (std::f64::consts::FRAC_PI_2 - 0.35)).abs() < 1e-12);
        for f in moved.topology().faces() {
            assert!(FlatFace::of(&moved, f).planarity_length < 1e-14);
            let is_turned = f == top || f == side;
            let turn = FlatFace::of(&mesh, f)
                .normal()
                .dot(&FlatFace::of(&moved, f).normal());
            assert!(is_turned || turn > 1.0 - 1e-12);
        }
    }
}
