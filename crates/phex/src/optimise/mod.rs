//! Optimise: planar, simple panels close to the surface.

use phex_mesh::Vec3;

/// Foot point on a target surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Closest point.
    pub position: Vec3,
    /// Unit normal there.
    pub normal: Vec3,
}

/// Foot point on a boundary curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Closest point.
    pub position: Vec3,
    /// Unit tangent there.
    pub tangent: Vec3,
}

/// The surface that panels are kept close to: a smooth triangulation, the original facets, or an analytic shape.
pub trait Target: Sync {
    /// Closest points, in the order of `points`.
    fn closest_points(&self, points: &[Vec3]) -> Vec<TargetPoint>;
    /// Closest points on the boundary curves, or `None` for a closed surface.
    fn closest_on_boundary(&self, points: &[Vec3]) -> Option<Vec<CurvePoint>>;
}
