//! Two minimal surfaces: the helicoid and Enneper's surface.

use super::domain::{Interval, ParameterDomain};
use super::parametric::{ParametricSurface, SurfaceJet};
use crate::Vec3;

/// `x(u, v) = (v cos u, v sin u, rise u)`: `u` the angle, `v` the signed distance from the axis.
pub(super) struct Helicoid {
    pub radius: f64,
    /// Height gained per radian.
    pub rise: f64,
    pub half_angle: f64,
}

impl ParametricSurface for Helicoid {
    fn domain(&self) -> ParameterDomain {
        ParameterDomain::rectangle(
            Interval::symmetric(self.half_angle),
            Interval::symmetric(self.radius),
        )
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let (sin, cos) = u.sin_cos();
        let (ray, turned) = (Vec3::new(cos, sin, 0.0), Vec3::new(-sin, cos, 0.0));
        SurfaceJet {
            point: ray * v + Vec3::z() * (self.rise * u),
            du: turned * v + Vec3::z() * self.rise,
            dv: ray,
            duu: -ray * v,
            duv: turned,
            dvv: Vec3::zeros(),
        }
    }
}

/// `x(u, v) = scale (u - u^3/3 + u v^2, v - v^3/3 + v u^2, u^2 - v^2)` over the disc `u^2 + v^2 <=
/// radius^2`.
pub(super) struct Enneper {
    pub radius: f64,
    pub scale: f64,
}

impl ParametricSurface for Enneper {
    fn domain(&self) -> ParameterDomain {
        ParameterDomain::superellipse(self.radius, self.radius, 2.0)
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let (uu, vv) = (u * u, v * v);
        let scaled = |x: f64, y: f64, z: f64| Vec3::new(x, y, z) * self.scale;
        SurfaceJet {
            point: scaled(
                u * (1.0 - uu / 3.0 + vv),
                v * (1.0 - vv / 3.0 + uu),
                uu - vv,
            ),
            du: scaled(1.0 - uu + vv, 2.0 * u * v, 2.0 * u),
            dv: scaled(2.0 * u * v, 1.0 - vv + uu, -2.0 * v),
            duu: scaled(-2.0 * u, 2.0 * v, 2.0),
            duv: scaled(2.0 * v, 2.0 * u, 0.0),
            dvv: scaled(2.0 * u, -2.0 * v, -2.0),
        }
    }
}
