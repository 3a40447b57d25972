//! The mesh with its faces ear-clipped, under a bounding volume hierarchy.

use crate::ear_clip::ear_clip_or_fan;
use crate::{FaceId, FlatFace, HexMesh, PerFace, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQuery, PointQueryWithLocation};
use parry3d_f64::shape::TriMesh;

/// Triangles of all faces.
pub(crate) struct ClippedMesh {
    /// The triangles; their vertex numbers are those of the mesh.
    pub hierarchy: TriMesh,
    /// The face that each triangle is part of.
    pub owner: Vec<FaceId>,
    /// Whether the side from corner `k` to corner `k + 1` of each triangle is a diagonal of its
    /// face.
    pub diagonal: Vec<[bool; 3]>,
}

impl ClippedMesh {
    pub fn new(mesh: &HexMesh, faces: &PerFace<FlatFace>) -> Self {
        let (mut triangles, mut owner, mut diagonal) = (Vec::new(), Vec::new(), Vec::new());
        for (f, face) in faces.enumerate() {
            let vertices = mesh.topology().face_vertices(f);
            for corners in ear_clip_or_fan(&face.polygon) {
                triangles.push(corners.map(|k| vertices[k].index() as u32));
                diagonal.push(diagonals(corners, vertices.len()));
                owner.push(f);
            }
        }
        let points = mesh.positions.iter().map(|&p| to_parry(p)).collect();
        let hierarchy = TriMesh::new(points, triangles).expect("a mesh has at least one face");
        Self {
            hierarchy,
            owner,
            diagonal,
        }
    }

    /// The face closest to a point, and its distance in model units.
    pub fn closest(&self, p: Vec3) -> (FaceId, f64) {
        let (found, (triangle, _)) =
            (self.hierarchy).project_local_point_and_get_location(to_parry(p), false);
        let closest = found.point;
        let distance = (Vec3::new(closest.x, closest.y, closest.z) - p).norm();
        (self.owner[triangle as usize], distance)
    }

    /// Distance of a point to the closest triangle, in model units.
    pub fn distance(&self, p: Vec3) -> f64 {
        let closest = self.hierarchy.project_local_point(to_parry(p), false).point;
        (Vec3::new(closest.x, closest.y, closest.z) - p).norm()
    }
}

fn diagonals(corners: [usize; 3], valence: usize) -> [bool; 3] {
    std::array::from_fn(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        (a + 1) % valence != b && (b + 1) % valence != a
    })
}

pub(crate) fn to_parry(p: Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}
