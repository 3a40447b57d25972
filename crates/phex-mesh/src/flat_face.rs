//! A face seen in its own plane: what every measure and check of a face starts from.

use crate::polygon::{self, Clearance};
use crate::{FaceId, FacePlane, HexMesh, PerFace, Vec2, Vec3};
use rayon::prelude::*;

/// A face projected on its least-squares plane.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatFace {
    /// The least-squares plane.
    pub plane: FacePlane,
    /// The corners in the plane's axes, counter-clockwise where the face is simple, in the order of
    /// [`Topology::face_vertices`](crate::Topology::face_vertices).
    pub polygon: Vec<Vec2>,
    /// Largest distance of a corner to the plane, in model units.
    pub planarity_length: f64,
}

impl FlatFace {
    /// Projects a polygon of at least three corners.
    pub fn new(corners: &[Vec3]) -> Self {
        let plane = FacePlane::fit(corners);
        Self {
            plane,
            polygon: corners.iter().map(|&p| plane.project(p)).collect(),
            planarity_length: corners
                .iter()
                .map(|&p| plane.height(p).abs())
                .fold(0.0, f64::max),
        }
    }

    /// Projects one face of a mesh.
    pub fn of(mesh: &HexMesh, face: FaceId) -> Self {
        Self::new(&mesh.corners(face).collect::<Vec<_>>())
    }

    /// Projects every face of a mesh.
    pub fn all(mesh: &HexMesh) -> PerFace<Self> {
        let count = mesh.topology().n_faces() as u32;
        let faces = (0..count)
            .into_par_iter()
            .map(|f| Self::of(mesh, FaceId::new(f)));
        PerFace::from_vec(faces.collect())
    }

    /// Unit normal by the winding of the corners.
    pub fn normal(&self) -> Vec3 {
        self.plane.normal
    }

    /// Area in squared model units; at least zero.
    pub fn area(&self) -> f64 {
        polygon::signed_area(&self.polygon).abs()
    }

    /// The closest pair of a corner and an edge that does not hold it.
    pub fn clearance(&self) -> Clearance {
        let none = Clearance {
            corner: 0,
            edge: 0,
            distance: f64::INFINITY,
        };
        polygon::closest_corner_and_edge(&self.polygon).unwrap_or(none)
    }

    /// Whether some corner turns to the right by more than rounding: `ab x bc < -1e-9 unit^2` for a
    /// length `unit`, by convention the mesh's mean edge.
    pub fn is_concave(&self, unit: f64) -> bool {
        let limit = -1e-9 * unit * unit;
        polygon::corner_triples(&self.polygon).any(|[a, b, c]| (b - a).perp(&(c - b)) < limit)
    }
}
