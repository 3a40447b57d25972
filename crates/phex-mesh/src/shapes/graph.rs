//! Graphs `z = f(x, y)`: plane, paraboloids, monkey saddle, wave, Scherk's surface. `u = x`, `v =
//! y`; normals point up.

use super::domain::ParameterDomain;
use super::parametric::{ParametricSurface, SurfaceJet};
use crate::Vec3;

/// A height and its partial derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct HeightJet {
    pub z: f64,
    pub x: f64,
    pub y: f64,
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
}

/// A function of the plane.
pub(super) trait HeightField: Send + Sync {
    fn height(&self, x: f64, y: f64) -> HeightJet;
}

/// The graph of a height field over a domain.
pub(super) struct Graph<H> {
    pub height: H,
    pub domain: ParameterDomain,
}

impl<H: HeightField> ParametricSurface for Graph<H> {
    fn domain(&self) -> ParameterDomain {
        self.domain
    }

    fn jet(&self, u: f64, v: f64) -> SurfaceJet {
        let h = self.height.height(u, v);
        SurfaceJet {
            point: Vec3::new(u, v, h.z),
            du: Vec3::new(1.0, 0.0, h.x),
            dv: Vec3::new(0.0, 1.0, h.y),
            duu: Vec3::new(0.0, 0.0, h.xx),
            duv: Vec3::new(0.0, 0.0, h.xy),
            dvv: Vec3::new(0.0, 0.0, h.yy),
        }
    }
}

/// `z = (curvature_x x^2 + curvature_y y^2) / 2`: plane, elliptic and hyperbolic paraboloid.
pub(super) struct Paraboloid {
    pub curvature_x: f64,
    pub curvature_y: f64,
}

impl HeightField for Paraboloid {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let (dx, dy) = (self.curvature_x * x, self.curvature_y * y);
        HeightJet {
            z: 0.5 * (dx * x + dy * y),
            x: dx,
            y: dy,
            xx: self.curvature_x,
            xy: 0.0,
            yy: self.curvature_y,
        }
    }
}

/// `z = scale (x^3 - 3 x y^2)`.
pub(super) struct MonkeySaddle {
    pub scale: f64,
}

impl HeightField for MonkeySaddle {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let c = self.scale;
        HeightJet {
            z: c * x * (x * x - 3.0 * y * y),
            x: 3.0 * c * (x * x - y * y),
            y: -6.0 * c * x * y,
            xx: 6.0 * c * x,
            xy: -6.0 * c * y,
            yy: -6.0 * c * x,
        }
    }
}

/// `z = amplitude_x sin x + amplitude_y sin y`.
pub(super) struct Wave {
    pub amplitude_x: f64,
    pub amplitude_y: f64,
}

impl HeightField for Wave {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let (a, b) = (self.amplitude_x, self.amplitude_y);
        HeightJet {
            z: a * x.sin() + b * y.sin(),
            x: a * x.cos(),
            y: b * y.cos(),
            xx: -a * x.sin(),
            xy: 0.0,
            yy: -b * y.sin(),
        }
    }
}

/// `z = scale log(cos(y / scale) / cos(x / scale))`.
pub(super) struct Scherk {
    pub scale: f64,
}

impl HeightField for Scherk {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let (x, y) = (x / self.scale, y / self.scale);
        HeightJet {
            z: self.scale * (y.cos() / x.cos()).ln(),
            x: x.tan(),
            y: -y.tan(),
            xx: 1.0 / (self.scale * x.cos().powi(2)),
            xy: 0.0,
            yy: -1.0 / (self.scale * y.cos().powi(2)),
        }
    }
}
