//! The triangle surface: what phex approximates.
//!
//! Positions, topology, vertex normals, and closest points with interpolated normal over a bounding volume hierarchy.

use crate::ids::FaceId;
use crate::per_element::PerVertex;
use crate::topology::{Topology, TopologyError};
use crate::Vec3;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TrianglePointLocation};
use rayon::prelude::*;

/// An oriented manifold triangle mesh with closest-point queries.
#[derive(Clone)]
pub struct TriangleSurface {
    positions: PerVertex<Vec3>,
    normals: PerVertex<Vec3>,
    topology: Topology,
    hierarchy: TriMesh,
}

/// A point on a [`TriangleSurface`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle.
    pub triangle: FaceId,
    /// Barycentric coordinates in the triangle, in the order of its vertices; they sum to 1.
    pub barycentric: [f64; 3],
    /// The point.
    pub position: Vec3,
    /// Unit normal, interpolated from the vertices.
    pub normal: Vec3,
}

impl TriangleSurface {
    /// Builds a surface from triangles that already are an oriented manifold.
    /// Vertex normals are those of Max (weights `1 / (|a|^2 |b|^2)`).
    ///
    /// # Errors
    /// If the triangles are not an oriented manifold.
    pub fn new(positions: Vec<Vec3>, triangles: &[[u32; 3]]) -> Result<Self, TopologyError> {
        let topology = Topology::from_faces(positions.len(), triangles)?;
        let points = positions.iter().map(|p| parry3d_f64::math::Vector::new(p.x, p.y, p.z)).collect();
        let hierarchy = TriMesh::new(points, triangles.to_vec()).map_err(|_| TopologyError::Empty)?;
        let positions = PerVertex::from_vec(positions);
        let normals = max_normals(&positions, &topology);
        Ok(Self { positions, normals, topology, hierarchy })
    }

    /// The same surface with other unit vertex normals (those of a fitted jet, say).
    ///
    /// # Panics
    /// If the number of normals differs.
    pub fn with_normals(mut self, normals: PerVertex<Vec3>) -> Self {
        assert_eq!(normals.len(), self.positions.len(), "one normal per vertex");
        self.normals = normals;
        self
    }

    /// Position of each vertex.
    pub fn positions(&self) -> &PerVertex<Vec3> {
        &self.positions
    }

    /// Unit normal of each vertex.
    pub fn normals(&self) -> &PerVertex<Vec3> {
        &self.normals
    }

    /// The connectivity.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// The three corners of a triangle.
    pub fn corners(&self, f: FaceId) -> [Vec3; 3] {
        let v = self.topology.face_vertices(f);
        [self.positions[v[0]], self.positions[v[1]], self.positions[v[2]]]
    }

    /// Normal of a triangle times twice its area.
    pub fn area_vector(&self, f: FaceId) -> Vec3 {
        let [a, b, c] = self.corners(f);
        (b - a).cross(&(c - a))
    }

    /// Total area.
    pub fn area(&self) -> f64 {
        self.topology.faces().map(|f| 0.5 * self.area_vector(f).norm()).sum()
    }

    /// Corner with the smallest and corner with the largest coordinates.
    pub fn bounding_box(&self) -> (Vec3, Vec3) {
        let first = self.positions.as_slice()[0];
        self.positions.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)))
    }

    /// Diagonal of the bounding box, the length that percentages refer to.
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounding_box();
        (hi - lo).norm()
    }

    /// The point of the surface that is closest to `p`.
    pub fn closest_point(&self, p: Vec3) -> SurfacePoint {
        let query = parry3d_f64::math::Vector::new(p.x, p.y, p.z);
        let (_, (triangle, location)) = self.hierarchy.project_local_point_and_get_location(query, false);
        let barycentric = barycentric(location);
        self.at(FaceId::new(triangle), barycentric)
    }

    /// Closest points of many, in their order; the same for any number of threads.
    pub fn closest_points(&self, points: &[Vec3]) -> Vec<SurfacePoint> {
        points.par_iter().map(|&p| self.closest_point(p)).collect()
    }

    /// The point with barycentric coordinates `b` in a triangle.
    pub fn at(&self, triangle: FaceId, b: [f64; 3]) -> SurfacePoint {
        let v = self.topology.face_vertices(triangle);
        let mix = |values: &PerVertex<Vec3>| values[v[0]] * b[0] + values[v[1]] * b[1] + values[v[2]] * b[2];
        let normal = mix(&self.normals);
        let normal = normal.try_normalize(1e-12).unwrap_or_else(|| self.area_vector(triangle).normalize());
        SurfacePoint { triangle, barycentric: b, position: mix(&self.positions), normal }
    }
}

fn barycentric(location: TrianglePointLocation) -> [f64; 3] {
    match location {
        TrianglePointLocation::OnVertex(i) => std::array::from_fn(|k| f64::from(u8::from(k == i as usize))),
        _ => location.barycentric_coordinates().unwrap_or([1.0 / 3.0; 3]),
    }
}

/// Vertex normals with weights `1 / (|a|^2 |b|^2)` (N. Max, "Weights for computing vertex normals", 1999).
fn max_normals(positions: &PerVertex<Vec3>, topology: &Topology) -> PerVertex<Vec3> {
    PerVertex::from_fn(positions.len(), |v| {
        let mut normal = Vec3::zeros();
        for h in topology.outgoing(v) {
            let a = positions[topology.target(h)] - positions[v];
            let b = positions[topology.origin(topology.prev(h))] - positions[v];
            let weight = a.norm_squared() * b.norm_squared();
            if weight > 0.0 {
                normal += a.cross(&b) / weight;
            }
        }
        normal.try_normalize(0.0).unwrap_or_else(Vec3::z)
    })
}
