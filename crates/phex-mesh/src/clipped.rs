//! The mesh with its faces ear-clipped, under a bounding volume hierarchy.

use crate::ear_clip::ear_clip_or_fan;
use crate::segment::{from_parry, to_parry};
use crate::surface::in_runs;
use crate::{FaceId, FlatFace, HexMesh, PerFace, Vec3};
use parry3d_f64::bounding_volume::{Aabb, BoundingVolume};
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

/// A triangle and a place on it.
type Foot = (u32, Vec3);

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

    /// Corners of a triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        let at = |v: u32| from_parry(self.hierarchy.vertices()[v as usize]);
        self.hierarchy.indices()[triangle].map(at)
    }

    /// The middle of the largest triangle of each face.
    pub fn middles(&self) -> Vec<Vec3> {
        let double_area = |[a, b, c]: &[Vec3; 3]| (b - a).cross(&(c - a)).norm();
        let mut next = 0..;
        let of_face = self.owner.chunk_by(|a, b| a == b).map(|run| {
            let own = next.by_ref().take(run.len()).map(|t| self.corners(t));
            own.max_by(|a, b| double_area(a).total_cmp(&double_area(b)))
        });
        of_face
            .map(|largest| largest.map_or(Vec3::zeros(), |c| c.iter().sum::<Vec3>() / 3.0))
            .collect()
    }

    /// A face that a point lies on, up to a distance in model units, other than its `own`.
    pub fn other_at(&self, p: Vec3, near: f64, own: FaceId) -> Option<FaceId> {
        let place = to_parry(p);
        let around = Aabb::new(place, place).loosened(near);
        let close = |t: &u32| {
            let triangle = self.hierarchy.triangle(*t);
            self.owner[*t as usize] != own && triangle.distance_to_local_point(place, true) <= near
        };
        let mut found = self.hierarchy.bvh().intersect_aabb(&around).filter(close);
        found.next().map(|t| self.owner[t as usize])
    }

    /// The face closest to a point, and its distance in model units.
    pub fn closest(&self, p: Vec3) -> (FaceId, f64) {
        self.face_at(p, self.foot(p, None))
    }

    /// The same of many points.
    pub fn closest_of(&self, points: &[Vec3]) -> Vec<(FaceId, f64)> {
        let feet = in_runs(points, |p, last| self.foot(p, last));
        let both = points.iter().zip(feet);
        both.map(|(p, foot)| self.face_at(*p, foot)).collect()
    }

    fn face_at(&self, p: Vec3, (triangle, foot): Foot) -> (FaceId, f64) {
        (self.owner[triangle as usize], (foot - p).norm())
    }

    /// The triangle closest to a point and the place there, sought no farther away than `near` is.
    fn foot(&self, p: Vec3, near: Option<&Foot>) -> Foot {
        let (query, hierarchy) = (to_parry(p), &self.hierarchy);
        // Rounding must not exclude `near` itself.
        let bound = near.map(|(_, foot)| (p - foot).norm() * (1.0 + 1e-6));
        let found = bound.and_then(|bound| {
            hierarchy.project_local_point_and_get_location_with_max_dist(query, false, bound)
        });
        let anywhere = || hierarchy.project_local_point_and_get_location(query, false);
        let (found, (triangle, _)) = found.unwrap_or_else(anywhere);
        (triangle, from_parry(found.point))
    }

    /// Distance of a point to the closest triangle, in model units.
    pub fn distance(&self, p: Vec3) -> f64 {
        let closest = self.hierarchy.project_local_point(to_parry(p), false).point;
        (from_parry(closest) - p).norm()
    }
}

fn diagonals(corners: [usize; 3], valence: usize) -> [bool; 3] {
    std::array::from_fn(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % 3]);
        (a + 1) % valence != b && (b + 1) % valence != a
    })
}
