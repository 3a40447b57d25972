//! The boundary of a triangle surface as curves, with closest points.

use crate::surface::TriangleSurface;
use crate::{Vec3, VertexId};
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::Polyline;
use std::sync::Arc;

/// All boundary loops of a surface, or other polylines. Clones share them.
#[derive(Clone)]
pub struct BoundaryCurve {
    ends: Arc<[[Vec3; 2]]>,
    hierarchy: Arc<Polyline>,
}

/// A point on a [`BoundaryCurve`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryPoint {
    /// The point.
    pub position: Vec3,
    /// Unit tangent of the segment; the surface lies to its left.
    pub tangent: Vec3,
}

impl BoundaryCurve {
    /// The boundary of `surface`, or `None` where it is closed.
    pub fn of(surface: &TriangleSurface) -> Option<Self> {
        let place = |v: &VertexId| surface.positions()[*v];
        let closed = |boundary: &Vec<VertexId>| {
            let first = boundary.iter().take(1);
            boundary.iter().chain(first).map(place).collect()
        };
        let loops: Vec<Vec<Vec3>> = surface
            .topology()
            .boundary_loops()
            .iter()
            .map(closed)
            .collect();
        Self::of_polylines(&loops)
    }

    /// Any polylines; one whose first point is its last is closed. `None` without a segment.
    pub fn of_polylines(polylines: &[Vec<Vec3>]) -> Option<Self> {
        let (mut ends, mut points, mut segments) = (Vec::new(), Vec::new(), Vec::new());
        for pair in polylines.iter().flat_map(|line| line.windows(2)) {
            let first = points.len() as u32;
            points.extend(
                pair.iter()
                    .map(|p| parry3d_f64::math::Vector::new(p.x, p.y, p.z)),
            );
            segments.push([first, first + 1]);
            ends.push([pair[0], pair[1]]);
        }
        (!ends.is_empty()).then(|| Self {
            ends: ends.into(),
            hierarchy: Arc::new(Polyline::new(points, Some(segments))),
        })
    }

    /// Whether a point is nearer than a distance; it takes less time than to find where.
    pub fn is_within(&self, p: Vec3, distance: f64) -> bool {
        let query = parry3d_f64::math::Vector::new(p.x, p.y, p.z);
        let found = self
            .hierarchy
            .project_local_point_and_get_location_with_max_dist(query, false, distance);
        found.is_some()
    }

    /// The point of the boundary that is closest to `p`.
    pub fn closest_point(&self, p: Vec3) -> BoundaryPoint {
        let query = parry3d_f64::math::Vector::new(p.x, p.y, p.z);
        let (_, (segment, location)) = self
            .hierarchy
            .project_local_point_and_get_location(query, false);
        let [a, b] = self.ends[segment as usize];
        let [u, v] = location.barycentric_coordinates();
        let tangent = (b - a).try_normalize(0.0).unwrap_or_else(Vec3::x);
        BoundaryPoint {
            position: a * u + b * v,
            tangent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_side_of_a_square_and_none_of_a_tetrahedron() {
        let square =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|p| Vec3::new(p[0], p[1], 0.0));
        let surface = TriangleSurface::new(square.to_vec(), &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let curve = BoundaryCurve::of(&surface).unwrap();
        let foot = curve.closest_point(Vec3::new(1.9, 0.7, 3.0));
        assert!((foot.position - Vec3::new(2.0, 0.7, 0.0)).norm() < 1e-15);
        assert!((foot.tangent - Vec3::y()).norm() < 1e-15);
        let distances = [0.2, 0.3, 0.4];
        let within = distances.map(|d| curve.is_within(Vec3::new(0.5, 0.3, 0.0), d));
        assert_eq!(within, [false, false, true]);
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let closed = TriangleSurface::new(corners.to_vec(), &faces).unwrap();
        assert!(BoundaryCurve::of(&closed).is_none());
    }
}
