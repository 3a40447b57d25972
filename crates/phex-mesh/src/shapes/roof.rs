//! A free-form roof: two halls, a saddle between them and raised ends, over a rounded plan.
//!
//! `z = height f(x / half_length, y / half_width)` with `f` the sum of two Gaussian bumps and a
//! shallow quadratic.

use super::graph::{HeightField, HeightJet};

/// A bump `weight exp(-((x - centre_x) / spread_x)^2 - ((y - centre_y) / spread_y)^2)` in plan
/// coordinates of -1 to 1.
struct Bump {
    weight: f64,
    centre: [f64; 2],
    spread: [f64; 2],
}

const BUMPS: [Bump; 2] = [
    Bump {
        weight: 0.92,
        centre: [-0.36, 0.08],
        spread: [0.66, 0.95],
    },
    Bump {
        weight: 0.50,
        centre: [0.60, -0.16],
        spread: [0.52, 0.85],
    },
];
/// Coefficients of `x^2`, which lifts the ends, and of `y^2`, which lowers the long sides.
const TROUGH: [f64; 2] = [0.14, -0.06];

pub(super) struct Roof {
    pub half_length: f64,
    pub half_width: f64,
    pub height: f64,
}

impl HeightField for Roof {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let (p, q) = (x / self.half_length, y / self.half_width);
        let mut sum = HeightJet {
            z: TROUGH[0] * p * p + TROUGH[1] * q * q,
            x: 2.0 * TROUGH[0] * p,
            y: 2.0 * TROUGH[1] * q,
            xx: 2.0 * TROUGH[0],
            xy: 0.0,
            yy: 2.0 * TROUGH[1],
        };
        for bump in &BUMPS {
            bump.add_to(&mut sum, p, q);
        }
        let (h, a, b) = (self.height, 1.0 / self.half_length, 1.0 / self.half_width);
        HeightJet {
            z: h * sum.z,
            x: h * a * sum.x,
            y: h * b * sum.y,
            xx: h * a * a * sum.xx,
            xy: h * a * b * sum.xy,
            yy: h * b * b * sum.yy,
        }
    }
}

impl Bump {
    fn add_to(&self, sum: &mut HeightJet, p: f64, q: f64) {
        let [sx, sy] = self.spread;
        let (x, y) = ((p - self.centre[0]) / sx, (q - self.centre[1]) / sy);
        let z = self.weight * (-x * x - y * y).exp();
        sum.z += z;
        sum.x -= 2.0 * x / sx * z;
        sum.y -= 2.0 * y / sy * z;
        sum.xx += (4.0 * x * x - 2.0) / (sx * sx) * z;
        sum.xy += 4.0 * x * y / (sx * sy) * z;
        sum.yy += (4.0 * y * y - 2.0) / (sy * sy) * z;
    }
}
