//! What a panelling is kept close to: a surface, or the start itself.

use super::panels::{FaceShapes, Panels, point};
use super::{CurvePoint, Target, TargetPoint};
use phex_mesh::Vec3;

/// What a panelling is kept close to.
pub(super) enum Reference<'a> {
    /// A surface; foot points are sought.
    Surface(&'a dyn Target),
    /// The start itself: a plane for each vertex and for each face centre.
    Start { planes: Vec<TargetPoint> },
}

impl<'a> Reference<'a> {
    /// Tangent planes of a mesh at its own vertices and face centres.
    pub fn start(panels: &Panels, x: &[f64]) -> Self {
        let shape = FaceShapes::at(panels, x);
        let vertex = |v: usize| {
            let normals = panels.corners_at(v).iter();
            let sum: Vec3 = normals.map(|&c| shape.normal(panels.face_of(c))).sum();
            TargetPoint {
                position: point(x, v),
                normal: sum.try_normalize(0.0).unwrap_or_else(Vec3::z),
            }
        };
        let centre = |f: usize| TargetPoint {
            position: shape.frames[f].plane.centre,
            normal: shape.normal(f),
        };
        let vertices = (0..panels.n_vertices()).map(vertex);
        let planes = vertices.chain((0..panels.n_faces()).map(centre)).collect();
        Self::Start { planes }
    }

    /// What some of the `n` vertices and some faces are kept close to.
    pub fn part(&self, n: usize, vertices: &[u32], faces: &[u32]) -> Reference<'a> {
        match self {
            Self::Surface(target) => Reference::Surface(*target),
            Self::Start { planes } => {
                let vertices = vertices.iter().map(|&v| planes[v as usize]);
                let centres = faces.iter().map(|&f| planes[n + f as usize]);
                let planes = vertices.chain(centres).collect();
                Reference::Start { planes }
            }
        }
    }

    /// Foot points of vertices and then of face centres.
    pub fn feet(&self, points: &[Vec3], last: &[TargetPoint]) -> Vec<TargetPoint> {
        match self {
            Self::Surface(target) => target.closest_points(points, last),
            Self::Start { planes } => {
                let foot = |(plane, p): (&TargetPoint, &Vec3)| TargetPoint {
                    position: p - plane.normal * plane.normal.dot(&(p - plane.position)),
                    normal: plane.normal,
                };
                planes.iter().zip(points).map(foot).collect()
            }
        }
    }

    pub fn on_boundary(&self, points: &[Vec3]) -> Option<Vec<CurvePoint>> {
        match self {
            Self::Surface(target) if !points.is_empty() => target.closest_on_boundary(points),
            _ => None,
        }
    }
}
