//! A free-form roof: two halls, a saddle between them and raised ends, over a rounded plan.
//!
//! `z = height f(x / half_length, y / half_width)` with `f` a sum of two Gaussian bumps and a shallow trough along the length.

use super::graph::{HeightField, HeightJet};

/// A bump `weight exp(-((x - centre_x) / spread_x)^2 - ((y - centre_y) / spread_y)^2)` in plan coordinates of -1 to 1.
struct Bump {
    weight: f64,
    centre: [f64; 2],
    spread: [f64; 2],
}

const BUMPS: [Bump; 2] = [
    Bump {
        weight: 1.0,
        centre: [-0.38, 0.06],
        spread: [0.55, 0.95],
    },
    Bump {
        weight: 0.62,
        centre: [0.56, -0.10],
        spread: [0.45, 0.80],
    },
];
/// Rise of the ends: the coefficient of `x^2`.
const END_RISE: f64 = 0.10;

pub(super) struct Roof {
    pub half_length: f64,
    pub half_width: f64,
    pub height: f64,
}

impl HeightField for Roof {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let (p, q) = (x / self.half_length, y / self.half_width);
        let mut sum = HeightJet {
            z: END_RISE * p * p,
            x: 2.0 * END_RISE * p,
            xx: 2.0 * END_RISE,
            ..HeightJet::default()
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
