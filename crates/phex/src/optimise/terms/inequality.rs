//! Inequalities `c >= 0` with slack: the elastic barrier of an interior-point method.
//!
//! `min_s rho s - mu ln(c + s) - mu ln s` over the slack `s > 0` has the closed form
//!
//! ```text
//! s = mu/rho (1 - a + sqrt(1 + a^2)),  c + s = mu/rho (1 + a + sqrt(1 + a^2)),  a = rho c / (2 mu)
//! ```
//!
//! and is a convex, smooth function of `c`, finite everywhere: beyond the limit it pays `rho` for
//! each unit, and within it is a log barrier. Where `c` can be kept against a force of less than
//! `rho / 2`, its minimum lies within the limit by `mu` over that force: the penalty is exact, and
//! leaves no rest as a square does. What lies within by 1 or more costs nothing.
//!
//! Source: the elastic problem of sequential quadratic and interior-point methods (Gill, Murray and
//! Saunders, "SNOPT" 2005, section 1.1; Nocedal and Wright, "Numerical optimization" 2006, section
//! 19.6), with the slack eliminated.

use phex_mesh::Vec3;

/// `mu / rho`: share of a limit within which an inequality is felt.
const SHARPNESS: f64 = 2e-3;

/// The cost of an inequality.
#[derive(Clone, Copy, Debug)]
pub(in crate::optimise) struct Elastic {
    /// `rho`: what a unit beyond the limit costs.
    pub weight: f64,
}

impl Elastic {
    /// `a` and `sqrt(1 + a^2)`.
    fn scaled(c: f64) -> (f64, f64) {
        let a = 0.5 * c / SHARPNESS;
        (a, a.hypot(1.0))
    }

    /// Slack and distance to the barrier, `s` and `c + s`.
    fn gaps(c: f64) -> [f64; 2] {
        let (a, root) = Self::scaled(c);
        // The smaller of root + a and root - a without cancellation.
        let (plus, minus) = match a >= 0.0 {
            true => (root + a, 1.0 / (root + a)),
            false => (1.0 / (root - a), root - a),
        };
        [SHARPNESS * (1.0 + minus), SHARPNESS * (1.0 + plus)]
    }

    fn cost(c: f64) -> f64 {
        let [slack, gap] = Self::gaps(c);
        slack - SHARPNESS * (gap.ln() + slack.ln())
    }

    fn slope(c: f64) -> f64 {
        -SHARPNESS / Self::gaps(c)[1]
    }

    /// What it costs; 0 from 1 on.
    pub fn value(&self, c: f64) -> f64 {
        match c < 1.0 {
            true => self.weight * (Self::cost(c) - Self::cost(1.0) - Self::slope(1.0) * (c - 1.0)),
            false => 0.0,
        }
    }

    /// First and second derivative.
    pub fn derivatives(&self, c: f64) -> [f64; 2] {
        if c >= 1.0 {
            return [0.0; 2];
        }
        let (a, root) = Self::scaled(c);
        let gap = Self::gaps(c)[1];
        let share = match a >= 0.0 {
            true => 0.5 * (root + a) / root,
            false => 0.5 / (root * (root - a)),
        };
        let slope = -SHARPNESS / gap - Self::slope(1.0);
        [
            self.weight * slope,
            self.weight * SHARPNESS * share / (gap * gap),
        ]
    }
}

/// An inequality of some corners of a face: `c`, and its derivatives by them.
pub(super) struct Inequality {
    pub c: f64,
    pub rows: Vec<(usize, Vec3)>,
}

impl Inequality {
    /// A figure that is to be at least `limit`, with its derivatives by all corners.
    pub fn at_least(value: f64, limit: f64, rows: &[Vec3]) -> Self {
        let rows = rows.iter().map(|row| row / limit).enumerate();
        Self {
            c: value / limit - 1.0,
            rows: rows.collect(),
        }
    }

    /// The same with less weight: what an excess costs is a share of what it would cost.
    pub fn weighted(self, share: f64) -> Self {
        let rows = self.rows.into_iter().map(|(i, row)| (i, row * share));
        Self {
            c: share * self.c,
            rows: rows.collect(),
        }
    }

    /// The same for one that is to be at most `limit`.
    pub fn at_most(value: f64, limit: f64, rows: &[Vec3]) -> Self {
        let rows = rows.iter().map(|row| row / -limit).enumerate();
        Self {
            c: 1.0 - value / limit,
            rows: rows.collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_convex_and_smooth_and_its_derivatives_are_those_of_differences() {
        let elastic = Elastic { weight: 3.0 };
        let mut last = f64::NEG_INFINITY;
        for k in -40..60 {
            let c = 0.02 * f64::from(k) + 1e-3;
            let [first, second] = elastic.derivatives(c);
            let h = 1e-6;
            let by = |g: &dyn Fn(f64) -> f64| (g(c + h) - g(c - h)) / (2.0 * h);
            let slope = by(&|c| elastic.value(c));
            let curve = by(&|c| elastic.derivatives(c)[0]);
            assert!((slope - first).abs() < 1e-6 * (1.0 + first.abs()), "{c}");
            assert!((curve - second).abs() < 1e-4 * (1.0 + second), "{c}");
            assert!(first >= last && second >= 0.0, "{c}");
            last = first;
        }
        assert_eq!(elastic.value(1.0), 0.0);
        assert_eq!(elastic.value(f64::INFINITY), 0.0);
    }

    /// `min (c + 1)^2 k / 2 + elastic(c)`: drawn to -1 with a force of `k` at the limit.
    #[test]
    fn limits_hold_against_forces_below_half_the_weight() {
        for (force, holds) in [(0.01, true), (0.1, true), (0.4, true), (3.0, false)] {
            let elastic = Elastic { weight: 1.0 };
            let slope = |c: f64| force * (c + 1.0) + elastic.derivatives(c)[0];
            let (mut low, mut high) = (-1.0, 1.0);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                *(if slope(middle) < 0.0 {
                    &mut low
                } else {
                    &mut high
                }) = middle;
            }
            assert_eq!(low > 0.0, holds, "{force}: {low}");
            assert!(low < 0.3, "{force}: {low}");
        }
    }
}
