//! An analytic shape as a target.

use crate::optimise::{CurvePoint, Target, TargetPoint};
use phex_mesh::Vec3;
use phex_mesh::shapes::{ParametricSurface, Shape, ShapeError, ShapeProjector};
use rayon::prelude::*;

/// A parametric surface: foot points by Newton's method, exact to rounding, and its own normals.
pub struct ShapeTarget<S = Shape> {
    projector: ShapeProjector<S>,
}

impl<S: ParametricSurface> ShapeTarget<S> {
    /// The surface as a target.
    ///
    /// # Errors
    /// If the surface cannot be triangulated.
    pub fn new(surface: S) -> Result<Self, ShapeError> {
        let projector = ShapeProjector::new(surface)?;
        Ok(Self { projector })
    }
}

impl<S: ParametricSurface> Target for ShapeTarget<S> {
    fn closest_points(&self, points: &[Vec3], _near: &[TargetPoint]) -> Vec<TargetPoint> {
        let feet = self.projector.closest_points(points).into_iter();
        let foot = |foot: phex_mesh::shapes::ShapePoint| TargetPoint {
            position: foot.position,
            normal: foot.normal,
        };
        feet.map(foot).collect()
    }

    fn closest_on_boundary(&self, points: &[Vec3]) -> Option<Vec<CurvePoint>> {
        let foot = |p: &Vec3| {
            let foot = self.projector.closest_on_boundary(*p)?;
            Some(CurvePoint {
                position: foot.position,
                tangent: foot.tangent,
            })
        };
        points.par_iter().with_min_len(16).map(foot).collect()
    }
}
