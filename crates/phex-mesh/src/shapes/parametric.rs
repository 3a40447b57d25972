//! Differential geometry of a parametrised surface, from its second-order jet.

use super::domain::ParameterDomain;
use crate::Vec3;

/// Position and partial derivatives up to order two at one parameter pair `(u, v)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceJet {
    /// `x`.
    pub point: Vec3,
    /// `x_u`.
    pub du: Vec3,
    /// `x_v`.
    pub dv: Vec3,
    /// `x_uu`.
    pub duu: Vec3,
    /// `x_uv`.
    pub duv: Vec3,
    /// `x_vv`.
    pub dvv: Vec3,
}

/// First fundamental form `E du^2 + 2 F du dv + G dv^2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstForm {
    /// `E = x_u . x_u`.
    pub e: f64,
    /// `F = x_u . x_v`.
    pub f: f64,
    /// `G = x_v . x_v`.
    pub g: f64,
}

impl FirstForm {
    /// `E G - F^2`, the squared area of the parallelogram of `x_u` and `x_v`.
    pub fn determinant(&self) -> f64 {
        self.e * self.g - self.f * self.f
    }
}

/// Second fundamental form `L du^2 + 2 M du dv + N dv^2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SecondForm {
    /// `L = n . x_uu`.
    pub l: f64,
    /// `M = n . x_uv`.
    pub m: f64,
    /// `N = n . x_vv`.
    pub n: f64,
}

/// Principal curvatures (1 / length) and their directions, which are unit, tangent and
/// perpendicular.
///
/// `max_direction x min_direction` is the normal. At an umbilic the directions are arbitrary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalCurvatures {
    /// The larger one, `k1`.
    pub max: f64,
    /// The smaller one, `k2`.
    pub min: f64,
    /// Direction of the larger one.
    pub max_direction: Vec3,
    /// Direction of the smaller one.
    pub min_direction: Vec3,
}

impl PrincipalCurvatures {
    /// Gauss curvature `K = k1 k2`.
    pub fn gauss(&self) -> f64 {
        self.max * self.min
    }

    /// Mean curvature `H = (k1 + k2) / 2`.
    pub fn mean(&self) -> f64 {
        0.5 * (self.max + self.min)
    }

    /// From `II(t, t)`, `II(t, s)` and `II(s, s)` in an orthonormal tangent frame with `t x s =
    /// normal`.
    pub(super) fn in_frame([t, s]: [Vec3; 2], [tt, ts, ss]: [f64; 3]) -> Self {
        let (mean, half_difference) = (0.5 * (tt + ss), 0.5 * (tt - ss));
        let radius = half_difference.hypot(ts);
        let (sin, cos) = (0.5 * ts.atan2(half_difference)).sin_cos();
        Self {
            max: mean + radius,
            min: mean - radius,
            max_direction: t * cos + s * sin,
            min_direction: s * cos - t * sin,
        }
    }
}

/// A surface with closed-form derivatives.
///
/// The unit normal is `n = x_u x x_v / |x_u x x_v|`, and curvature is positive where the surface
/// bends *towards* its normal: a sphere with outward normal has `k1 = k2 = -1 / r`. Closed shapes
/// and shapes round an axis have outward normals, graphs over the plane have upward ones. All
/// derivatives may be evaluated a little outside the domain.
pub trait ParametricSurface: Send + Sync {
    /// The parameters that the surface is made of.
    fn domain(&self) -> ParameterDomain;

    /// Position, first and second derivatives at `(u, v)`.
    fn jet(&self, u: f64, v: f64) -> SurfaceJet;

    /// Position at `(u, v)`.
    fn point(&self, u: f64, v: f64) -> Vec3 {
        self.jet(u, v).point
    }

    /// `[x_u, x_v]`.
    fn first_derivatives(&self, u: f64, v: f64) -> [Vec3; 2] {
        let jet = self.jet(u, v);
        [jet.du, jet.dv]
    }

    /// Unit normal. NaN where `x_u` and `x_v` are parallel, unless the surface knows better (as the
    /// ellipsoid does at its poles).
    fn normal(&self, u: f64, v: f64) -> Vec3 {
        let jet = self.jet(u, v);
        jet.du.cross(&jet.dv).normalize()
    }

    /// `E`, `F`, `G`.
    fn first_fundamental_form(&self, u: f64, v: f64) -> FirstForm {
        let jet = self.jet(u, v);
        FirstForm {
            e: jet.du.norm_squared(),
            f: jet.du.dot(&jet.dv),
            g: jet.dv.norm_squared(),
        }
    }

    /// `L`, `M`, `N`.
    fn second_fundamental_form(&self, u: f64, v: f64) -> SecondForm {
        let (jet, normal) = (self.jet(u, v), self.normal(u, v));
        SecondForm {
            l: normal.dot(&jet.duu),
            m: normal.dot(&jet.duv),
            n: normal.dot(&jet.dvv),
        }
    }

    /// Principal curvatures and directions.
    fn principal_curvatures(&self, u: f64, v: f64) -> PrincipalCurvatures {
        let first = self.first_fundamental_form(u, v);
        let second = self.second_fundamental_form(u, v);
        let along_u = self.jet(u, v).du.normalize();
        let frame = [along_u, self.normal(u, v).cross(&along_u)];
        let (area_squared, shear) = (first.determinant(), first.f / first.e);
        let across =
            (second.n - shear * (2.0 * second.m - shear * second.l)) * first.e / area_squared;
        let mixed = (second.m - shear * second.l) / area_squared.sqrt();
        PrincipalCurvatures::in_frame(frame, [second.l / first.e, mixed, across])
    }

    /// Gauss curvature `K`, 1 / length^2.
    fn gauss_curvature(&self, u: f64, v: f64) -> f64 {
        self.principal_curvatures(u, v).gauss()
    }

    /// Mean curvature `H`, 1 / length.
    fn mean_curvature(&self, u: f64, v: f64) -> f64 {
        self.principal_curvatures(u, v).mean()
    }

    /// Parameters of the surface point in a direction from the centre; used for surfaces with poles
    /// only. The default reads `u` as longitude and `v` as latitude, both in radians.
    fn parameters_toward(&self, direction: Vec3) -> [f64; 2] {
        let latitude = direction.z.atan2(direction.x.hypot(direction.y));
        [direction.y.atan2(direction.x), latitude]
    }
}
