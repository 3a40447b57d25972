//! Surfaces of revolution round the z axis: cylinder, cone, torus, catenoid, one-sheet hyperboloid.
//!
//! `x(u, v) = (rho(v) cos u, rho(v) sin u, z(v))`; the normal points away from the axis where `z`
//! rises with `v`.

use super::domain::{Interval, ParameterDomain};
use super::parametric::{ParametricSurface, SurfaceJet};
use crate::{Vec2, Vec3};

/// The curve `(rho, z)` that is turned.
pub(super) enum Profile {
    /// A straight line: cone frustum, or cylinder where both radii agree. `v = z`, round 0.
    Line { lower: f64, upper: f64, height: f64 },
    /// A circle of radius `minor` whose centre is `major` away from the axis; `v` is its angle.
    Circle { major: f64, minor: f64 },
    /// `rho = waist cosh v`, `z = waist v` for `|v| <= reach`.
    Catenary { waist: f64, reach: f64 },
    /// `rho = waist cosh v`, `z = slope sinh v` for `|v| <= reach`.
    Hyperbola { waist: f64, slope: f64, reach: f64 },
}

impl Profile {
    fn interval(&self) -> Interval {
        match *self {
            Self::Line { height, .. } => Interval::symmetric(0.5 * height),
            Self::Circle { .. } => Interval::turn(),
            Self::Catenary { reach, .. } | Self::Hyperbola { reach, .. } => {
                Interval::symmetric(reach)
            }
        }
    }

    /// `(rho, z)` and its first and second derivatives.
    fn jet(&self, v: f64) -> [Vec2; 3] {
        match *self {
            Self::Line {
                lower,
                upper,
                height,
            } => {
                let taper = (upper - lower) / height;
                let rho = 0.5 * (lower + upper) + taper * v;
                [Vec2::new(rho, v), Vec2::new(taper, 1.0), Vec2::zeros()]
            }
            Self::Circle { major, minor } => {
                let arm = Vec2::new(v.cos(), v.sin()) * minor;
                [arm + Vec2::new(major, 0.0), Vec2::new(-arm.y, arm.x), -arm]
            }
            Self::Catenary { waist, .. } => {
                let (sinh, cosh) = (waist * v.sinh(), waist * v.cosh());
                [
                    Vec2::new(cosh, waist * v),
                    Vec2::new(sinh, waist),
                    Vec2::new(cosh, 0.0),
                ]
            }
            Self::Hyperbola { waist, slope, .. } => {
                let (sinh, cosh) = (v.sinh(), v.cosh());
                let point = Vec2::new(waist * cosh, slope * sinh);
                [point, Vec2::new(waist * sinh, slope * cosh), point]
            }
        }
    }
}

pub(super) struct Revolution(pub Profile);

impl ParametricSurface for Revolution {
    fn domain(&self) -> ParameterDomain {
        ParameterDomain::rectangle(Interval::turn(), self.0.interval())
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let (sin, cos) = u.sin_cos();
        let outward = |q: Vec2| Vec3::new(q.x * cos, q.x * sin, q.y);
        let around = |q: Vec2| Vec3::new(-q.x * sin, q.x * cos, 0.0);
        let [profile, slope, bend] = self.0.jet(v);
        SurfaceJet {
            point: outward(profile),
            du: around(profile),
            dv: outward(slope),
            duu: outward(Vec2::new(-profile.x, 0.0)),
            duv: around(slope),
            dvv: outward(bend),
        }
    }
}
