//! The ellipsoid `(x/a)^2 + (y/b)^2 + (z/c)^2 = 1`, the sphere included.
//!
//! `u` is the longitude and `v` the parametric latitude. Normal and curvature come from the
//! implicit equation, so they hold at the poles too.

use super::domain::{Interval, ParameterDomain, Region};
use super::parametric::{ParametricSurface, PrincipalCurvatures, SurfaceJet};
use crate::Vec3;
use std::f64::consts::FRAC_PI_2;

pub(super) struct EllipsoidSurface {
    pub semi_axes: Vec3,
}

impl EllipsoidSurface {
    /// Gradient of half the implicit function.
    fn gradient(&self, point: Vec3) -> Vec3 {
        point
            .component_div(&self.semi_axes)
            .component_div(&self.semi_axes)
    }

    /// Longitude and parametric latitude of a point of the surface.
    fn parameters(&self, point: Vec3) -> [f64; 2] {
        let unit = point.component_div(&self.semi_axes);
        [unit.y.atan2(unit.x), unit.z.atan2(unit.x.hypot(unit.y))]
    }
}

impl ParametricSurface for EllipsoidSurface {
    fn domain(&self) -> ParameterDomain {
        ParameterDomain {
            u: Interval::turn(),
            v: Interval::symmetric(FRAC_PI_2),
            region: Region::PoleToPole,
        }
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let ((su, cu), (sv, cv)) = (u.sin_cos(), v.sin_cos());
        let scaled = |x: f64, y: f64, z: f64| Vec3::new(x, y, z).component_mul(&self.semi_axes);
        SurfaceJet {
            point: scaled(cv * cu, cv * su, sv),
            du: scaled(-cv * su, cv * cu, 0.0),
            dv: scaled(-sv * cu, -sv * su, cv),
            duu: scaled(-cv * cu, -cv * su, 0.0),
            duv: scaled(sv * su, -sv * cu, 0.0),
            dvv: scaled(-cv * cu, -cv * su, -sv),
        }
    }

    fn normal(&self, u: f64, v: f64) -> Vec3 {
        self.gradient(self.point(u, v)).normalize()
    }

    fn principal_curvatures(&self, u: f64, v: f64) -> PrincipalCurvatures {
        let gradient = self.gradient(self.point(u, v));
        let frame = tangent_frame(gradient.normalize());
        let second = |s: Vec3, t: Vec3| -s.dot(&self.gradient(t)) / gradient.norm();
        let [s, t] = frame;
        PrincipalCurvatures::in_frame(frame, [second(s, s), second(s, t), second(t, t)])
    }

    /// Along the ray: of all simple maps from the sphere this keeps triangles closest to
    /// equilateral.
    fn parameters_toward(&self, direction: Vec3) -> [f64; 2] {
        self.parameters(direction)
    }
}

/// Two unit vectors that make a right-handed frame with a unit normal behind them.
pub(super) fn tangent_frame(normal: Vec3) -> [Vec3; 2] {
    let mut axis = Vec3::zeros();
    axis[normal.iamin()] = 1.0;
    let first = axis.cross(&normal).normalize();
    [first, normal.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [f64; 3] = [1.5, 1.0, 0.7];

    fn ellipsoid() -> EllipsoidSurface {
        EllipsoidSurface {
            semi_axes: Vec3::from(AXES),
        }
    }

    #[test]
    fn curvature_at_the_pole_is_that_of_the_two_section_ellipses() {
        let k = ellipsoid().principal_curvatures(0.3, FRAC_PI_2);
        assert!((k.max + 0.7 / 2.25).abs() < 1e-12 && (k.min + 0.7).abs() < 1e-12);
        assert!(k.max_direction.x.abs() > 1.0 - 1e-12 && k.min_direction.y.abs() > 1.0 - 1e-12);
    }
}
