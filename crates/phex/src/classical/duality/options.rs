//! Options of the classical methods.

use serde::{Deserialize, Serialize};

/// Options of the methods that work by planes and their poles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DualOptions {
    /// Go on where the surface is outside the method's domain, to see what becomes of it; what
    /// fails is told by the statistics.
    pub any_domain: bool,
    /// Where `K > 0`, join panels as the poles of their planes are in their convex hull: then all
    /// of them are convex. Where `K < 0`, flip edges whose triangles break the sign rule. Without
    /// it the classical methods keep the regular triangulation, whose panels may cross themselves.
    pub hull: bool,
    /// Quadric of `projective-dual`: the upper triangle of its symmetric matrix `Q`, row by row,
    /// model coordinates. Without one, the unit sphere about a centre away from all tangent planes.
    pub quadric: Option<[f64; 10]>,
    /// `lambda` of `tangent-planes`, a pure number >= 0: 0 lets the planes meet exactly; from 0.05
    /// to 0.5 vertices are held back where planes meet badly, and the optimiser makes the panels
    /// planar.
    pub regularisation: f64,
    /// Rule of `dual-subdivision`.
    pub rule: SubdivisionRule,
    /// Whether all panels of `koebe` are to have the mean curvature 0, as those of a minimal
    /// surface.
    pub minimal: bool,
    /// Levels of `dual-subdivision`, from 1 to 5: the coarse mesh has a quarter of the panels for
    /// each.
    pub levels: usize,
}

impl Default for DualOptions {
    fn default() -> Self {
        Self {
            any_domain: false,
            hull: true,
            quadric: None,
            regularisation: 0.0,
            // Loop's rule pulls the dual in, and so the panels off the surface.
            rule: SubdivisionRule::Butterfly,
            minimal: false,
            levels: 1,
        }
    }
}

/// Rule of a triangle mesh that a dual is refined by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SubdivisionRule {
    /// Approximating: smooth, and pulls in.
    #[default]
    Loop,
    /// Interpolating: the planes of old faces stay.
    Butterfly,
}
