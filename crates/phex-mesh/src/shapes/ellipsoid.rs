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

    fn closest_parameters(&self, p: Vec3) -> Option<[f64; 2]> {
        Some(self.parameters(closest_on_ellipsoid(self.semi_axes, p)))
    }
}

/// Two unit vectors that make a right-handed frame with a unit normal behind them.
pub(super) fn tangent_frame(normal: Vec3) -> [Vec3; 2] {
    let mut axis = Vec3::zeros();
    axis[normal.iamin()] = 1.0;
    let first = axis.cross(&normal).normalize();
    [first, normal.cross(&first)]
}

/// The closest point solves `x_i = e_i^2 p_i / (e_i^2 + t)` with `sum (x_i / e_i)^2 = 1` for the
/// largest root `t` (Eberly, "Distance from a point to an ellipsoid"). With `s = t + e_min^2 > 0`
/// nothing cancels, and the sum is convex and falling in `s`, so Newton from below rises to the
/// root without overshooting.
fn closest_on_ellipsoid(semi_axes: Vec3, p: Vec3) -> Vec3 {
    let shortest = semi_axes.imin();
    let shift = semi_axes.map(|e| (e - semi_axes[shortest]) * (e + semi_axes[shortest]));
    let mut octant = p.abs();
    // On the plane of symmetry two points are equally close; a nudge picks one and keeps the root
    // away from a pole of the sum.
    octant[shortest] = octant[shortest].max(1e-18 * semi_axes[shortest]);
    let weight = octant.component_mul(&semi_axes);
    let mut s = weight[shortest];
    for _ in 0..200 {
        let terms = weight.zip_map(&shift, |w, d| (w / (s + d)).powi(2));
        let slope = terms.zip_map(&shift, |term, d| 2.0 * term / (s + d)).sum();
        let step = (terms.sum() - 1.0) / slope;
        s += step.max(0.0);
        if step <= 1e-16 * s {
            break;
        }
    }
    let scaled = weight.zip_map(&shift, |w, d| w / (s + d));
    scaled
        .normalize()
        .component_mul(&semi_axes)
        .zip_map(&p, f64::copysign)
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

    #[test]
    fn closest_point_of_a_point_on_the_normal_is_its_foot() {
        let surface = ellipsoid();
        for (u, v) in [
            (0.1, 0.2),
            (2.5, -1.2),
            (-3.0, 1.5),
            (0.0, 0.0),
            (1.0, FRAC_PI_2),
        ] {
            for height in [-0.2, 0.0, 0.3, 50.0] {
                let p = surface.point(u, v) + surface.normal(u, v) * height;
                let [fu, fv] = surface.closest_parameters(p).unwrap();
                let error = (surface.point(fu, fv) - surface.point(u, v)).norm();
                assert!(
                    error < 1e-13 * (1.0 + height.abs()),
                    "{u} {v} {height}: {error}"
                );
            }
        }
    }

    #[test]
    fn centre_and_symmetry_planes_are_answered() {
        let axes = Vec3::from(AXES);
        let centre = closest_on_ellipsoid(axes, Vec3::zeros());
        assert!((centre.norm() - 0.7).abs() < 1e-14);
        // Between the foci of the section z = 0 the closest point leaves the plane.
        let inside = closest_on_ellipsoid(axes, Vec3::new(0.5, 0.1, 0.0));
        assert!(inside.z.abs() > 0.1);
        let shift = Vec3::new(2.25, 1.0, 0.49);
        let residual = (Vec3::new(0.5, 0.1, 0.0) - inside).cross(&inside.component_div(&shift));
        assert!(residual.norm() < 1e-12);
        let sphere = closest_on_ellipsoid(Vec3::repeat(2.0), Vec3::zeros());
        assert!((sphere.norm() - 2.0).abs() < 1e-14);
    }
}
