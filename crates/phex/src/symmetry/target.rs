//! A fundamental domain with its images as a target.

use super::group::folded;
use crate::optimise::{SurfaceTarget, Target, TargetPoint};
use crate::smooth_surface::IN_PLANE;
use nalgebra::Matrix3;
use phex_mesh::{BoundaryCurve, BoundaryPoint, TriangleSurface, Vec3};

/// A domain between mirror planes through the origin, and all its images: points are brought into
/// the domain, and what is closest to them back.
pub(crate) struct FoldedTarget<'a> {
    domain: SurfaceTarget<'a>,
    walls: Vec<Vec3>,
    /// The boundary without what lies in mirror planes.
    boundary: Option<BoundaryCurve>,
}

impl<'a> FoldedTarget<'a> {
    /// The domain as a target.
    pub fn new(domain: &'a TriangleSurface, walls: Vec<Vec3>) -> Self {
        Self {
            boundary: open_boundary(domain, &walls),
            domain: SurfaceTarget::new(domain),
            walls,
        }
    }

    /// The boundary without what lies in mirror planes.
    pub(crate) fn boundary(&self) -> Option<&BoundaryCurve> {
        self.boundary.as_ref()
    }

    fn all_folded(&self, points: &[Vec3]) -> (Vec<Vec3>, Vec<Matrix3<f64>>) {
        points.iter().map(|p| folded(&self.walls, *p)).unzip()
    }
}

impl Target for FoldedTarget<'_> {
    fn closest_points(&self, points: &[Vec3], near: &[TargetPoint]) -> Vec<TargetPoint> {
        let (inside, back) = self.all_folded(points);
        let known = near.iter().zip(&back).map(|(near, back)| TargetPoint {
            position: back.transpose() * near.position,
            normal: near.normal,
        });
        let feet = self
            .domain
            .closest_points(&inside, &known.collect::<Vec<_>>());
        let mapped = |(foot, back): (TargetPoint, &Matrix3<f64>)| TargetPoint {
            position: back * foot.position,
            normal: back * foot.normal,
        };
        feet.into_iter().zip(&back).map(mapped).collect()
    }

    fn closest_on_boundary(&self, points: &[Vec3]) -> Option<Vec<BoundaryPoint>> {
        let curve = self.boundary.as_ref()?;
        let foot = |p: &Vec3| {
            let (inside, back) = folded(&self.walls, *p);
            let foot = curve.closest_point(inside);
            BoundaryPoint {
                position: back * foot.position,
                tangent: back * foot.tangent,
            }
        };
        Some(points.iter().map(foot).collect())
    }
}

/// The boundary of a domain that lies in no mirror plane; `None` if all of it does.
pub(crate) fn open_boundary(domain: &TriangleSurface, walls: &[Vec3]) -> Option<BoundaryCurve> {
    let near = IN_PLANE * domain.diagonal();
    let mut lines: Vec<Vec<Vec3>> = Vec::new();
    for boundary in domain.boundary_loops() {
        let n = boundary.len();
        let at = |i: usize| domain.positions()[boundary[i % n]];
        let in_wall = |i: usize| {
            let both = |w: &Vec3| w.dot(&at(i)).abs() < near && w.dot(&at(i + 1)).abs() < near;
            walls.iter().any(both)
        };
        let Some(first) = (0..n).find(|i| in_wall(*i)) else {
            lines.push((0..=n).map(at).collect());
            continue;
        };
        let mut line: Vec<Vec3> = Vec::new();
        for i in first + 1..=first + n {
            if in_wall(i) {
                lines.extend((line.len() > 1).then(|| std::mem::take(&mut line)));
                line.clear();
            } else {
                if line.is_empty() {
                    line.push(at(i));
                }
                line.push(at(i + 1));
            }
        }
    }
    BoundaryCurve::of_polylines(&lines)
}
