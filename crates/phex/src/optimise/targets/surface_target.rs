//! A triangle surface as a target.

use crate::optimise::{Target, TargetPoint};
use phex_mesh::{BoundaryCurve, BoundaryPoint, TriangleSurface, Vec3};
use rayon::prelude::*;

/// A triangle surface and its boundary curves. With normals of a fitted jet it acts as a smooth
/// surface.
pub struct SurfaceTarget<'a> {
    surface: &'a TriangleSurface,
    boundary: Option<BoundaryCurve>,
}

impl<'a> SurfaceTarget<'a> {
    /// The surface as a target.
    pub fn new(surface: &'a TriangleSurface) -> Self {
        Self {
            surface,
            boundary: BoundaryCurve::of(surface),
        }
    }
}

impl Target for SurfaceTarget<'_> {
    fn closest_points(&self, points: &[Vec3], near: &[TargetPoint]) -> Vec<TargetPoint> {
        let foot = |(k, p): (usize, &Vec3)| {
            let foot = match near.get(k) {
                Some(last) => self.surface.closest_point_near(*p, last.position),
                None => self.surface.closest_point(*p),
            };
            TargetPoint {
                position: foot.position,
                normal: foot.normal,
            }
        };
        let points = points.par_iter().with_min_len(64);
        points.enumerate().map(foot).collect()
    }

    fn closest_on_boundary(&self, points: &[Vec3]) -> Option<Vec<BoundaryPoint>> {
        let curve = self.boundary.as_ref()?;
        Some(points.iter().map(|p| curve.closest_point(*p)).collect())
    }
}
