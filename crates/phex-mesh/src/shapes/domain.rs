//! The parameters that a surface is made of, and their boundary.

use std::f64::consts::TAU;

/// Rounding allowance for membership, relative to the length of an interval.
const SLACK_REL: f64 = 1e-12;

/// Range of one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Smallest value.
    pub start: f64,
    /// Largest value; the same place as `start` where periodic.
    pub end: f64,
    /// Whether the surface closes up along this parameter.
    pub periodic: bool,
}

impl Interval {
    /// A range with two ends.
    pub fn open(start: f64, end: f64) -> Self {
        Self {
            start,
            end,
            periodic: false,
        }
    }

    /// A range of the given half-length round 0.
    pub fn symmetric(half: f64) -> Self {
        Self::open(-half, half)
    }

    /// One full turn in radians, from `-pi` to `pi`.
    pub fn turn() -> Self {
        Self {
            start: -0.5 * TAU,
            end: 0.5 * TAU,
            periodic: true,
        }
    }

    /// `end - start`.
    pub fn length(&self) -> f64 {
        self.end - self.start
    }

    /// The value at a fraction (0 is the start, 1 the end).
    pub fn at(&self, fraction: f64) -> f64 {
        self.start + fraction * self.length()
    }

    /// The equivalent value in `[start, end)` where periodic, the value itself otherwise.
    pub fn wrap(&self, value: f64) -> f64 {
        if !self.periodic || (self.start..self.end).contains(&value) {
            return value;
        }
        let wrapped = self.start + (value - self.start).rem_euclid(self.length());
        if wrapped < self.end {
            wrapped
        } else {
            self.start
        }
    }

    /// Whether a value belongs to the range; every value does where periodic.
    pub fn contains(&self, value: f64) -> bool {
        let slack = SLACK_REL * self.length();
        self.periodic || (self.start - slack..=self.end + slack).contains(&value)
    }
}

/// Which part of the parameter rectangle the surface is made of, and what its sides are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Region {
    /// The whole rectangle; sides that are not periodic are boundary curves.
    Rectangle,
    /// The whole rectangle, `u` periodic; both ends of `v` shrink to one point (a pole), so the
    /// surface is a sphere.
    PoleToPole,
    /// The superellipse `|x|^exponent + |y|^exponent <= 1` inscribed in the rectangle, with `x`,
    /// `y` from -1 to 1 over it.
    Superellipse {
        /// 2 is an ellipse; larger ones approach the rectangle. At least 2.
        exponent: f64,
    },
}

/// The set of parameter pairs of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterDomain {
    /// Range of `u`.
    pub u: Interval,
    /// Range of `v`.
    pub v: Interval,
    /// The part of the rectangle that is used.
    pub region: Region,
}

impl ParameterDomain {
    /// All of a rectangle.
    pub fn rectangle(u: Interval, v: Interval) -> Self {
        Self {
            u,
            v,
            region: Region::Rectangle,
        }
    }

    /// The superellipse with given half-axes round the origin.
    pub fn superellipse(half_u: f64, half_v: f64, exponent: f64) -> Self {
        Self {
            u: Interval::symmetric(half_u),
            v: Interval::symmetric(half_v),
            region: Region::Superellipse { exponent },
        }
    }

    /// Periodic parameters brought back into their range.
    pub fn wrap(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        [self.u.wrap(u), self.v.wrap(v)]
    }

    /// Whether a parameter pair belongs to the surface (its boundary does).
    pub fn contains(&self, [u, v]: [f64; 2]) -> bool {
        let inside = self.u.contains(u) && self.v.contains(v);
        match self.region {
            Region::Superellipse { exponent } => {
                let x = 2.0 * (u - self.u.at(0.5)) / self.u.length();
                let y = 2.0 * (v - self.v.at(0.5)) / self.v.length();
                inside && x.abs().powf(exponent) + y.abs().powf(exponent) <= 1.0 + SLACK_REL
            }
            Region::Rectangle | Region::PoleToPole => inside,
        }
    }

    /// The smooth pieces of the boundary.
    pub fn boundary_arcs(&self) -> Vec<BoundaryArc> {
        match self.region {
            Region::PoleToPole => Vec::new(),
            Region::Superellipse { exponent } => vec![BoundaryArc::Superellipse {
                domain: *self,
                exponent,
            }],
            Region::Rectangle => self.sides(),
        }
    }

    fn sides(&self) -> Vec<BoundaryArc> {
        let (u, v) = (self.u, self.v);
        let side = |from, to, closed| BoundaryArc::Segment { from, to, closed };
        let mut sides = Vec::new();
        if !v.periodic {
            sides.extend([v.start, v.end].map(|c| side([u.start, c], [u.end, c], u.periodic)));
        }
        if !u.periodic {
            sides.extend([u.start, u.end].map(|c| side([c, v.start], [c, v.end], v.periodic)));
        }
        sides
    }
}

/// A smooth piece of the boundary in the parameter plane, over `t` from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoundaryArc {
    /// A side of the rectangle.
    Segment {
        /// Parameters at `t = 0`.
        from: [f64; 2],
        /// Parameters at `t = 1`.
        to: [f64; 2],
        /// Whether both ends are the same point of the surface.
        closed: bool,
    },
    /// The superellipse inscribed in the rectangle of a domain, counter-clockwise from its largest
    /// `u`.
    Superellipse {
        /// The domain.
        domain: ParameterDomain,
        /// As in [`Region::Superellipse`].
        exponent: f64,
    },
}

impl BoundaryArc {
    /// Whether both ends are the same point of the surface.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Segment { closed, .. } => *closed,
            Self::Superellipse { .. } => true,
        }
    }

    /// Parameters `(u, v)` at `t`.
    pub fn at(&self, t: f64) -> [f64; 2] {
        match self {
            Self::Segment { from, to, .. } => [0, 1].map(|i| from[i] * (1.0 - t) + to[i] * t),
            Self::Superellipse { domain, exponent } => {
                let (sin, cos) = (TAU * t).sin_cos();
                let radius = superellipse_radius(cos, sin, *exponent);
                [
                    domain.u.at(0.5 + 0.5 * radius * cos),
                    domain.v.at(0.5 + 0.5 * radius * sin),
                ]
            }
        }
    }

    /// Derivative of `(u, v)` by `t`.
    pub fn derivative(&self, t: f64) -> [f64; 2] {
        match self {
            Self::Segment { from, to, .. } => [to[0] - from[0], to[1] - from[1]],
            Self::Superellipse { domain, exponent } => {
                let (sin, cos) = (TAU * t).sin_cos();
                let radius = superellipse_radius(cos, sin, *exponent);
                let power = exponent - 2.0;
                let slope = radius.powf(exponent + 1.0)
                    * sin
                    * cos
                    * (cos.abs().powf(power) - sin.abs().powf(power));
                [
                    0.5 * TAU * domain.u.length() * (slope * cos - radius * sin),
                    0.5 * TAU * domain.v.length() * (slope * sin + radius * cos),
                ]
            }
        }
    }
}

/// Distance of the unit superellipse from its centre in the direction `(cos, sin)`.
fn superellipse_radius(cos: f64, sin: f64, exponent: f64) -> f64 {
    (cos.abs().powf(exponent) + sin.abs().powf(exponent)).powf(-1.0 / exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrapping_stays_in_the_half_open_range() {
        let turn = Interval::turn();
        for value in [
            -10.0,
            -3.2,
            0.0,
            3.1,
            3.2,
            100.0,
            turn.end,
            -1e-17 + turn.start,
        ] {
            let wrapped = turn.wrap(value);
            assert!(
                (turn.start..turn.end).contains(&wrapped),
                "{value} -> {wrapped}"
            );
            assert!(
                (wrapped.cos() - value.cos()).abs() < 1e-12
                    && (wrapped.sin() - value.sin()).abs() < 1e-12
            );
        }
        assert_eq!(Interval::open(0.0, 1.0).wrap(1.5), 1.5);
    }

    #[test]
    fn superellipse_arc_bounds_the_region_and_has_its_derivative() {
        let domain = ParameterDomain::superellipse(20.0, 14.0, 2.6);
        let arc = domain.boundary_arcs()[0];
        for k in 0..97 {
            let t = (k as f64 + 0.37) / 97.0;
            let [u, v] = arc.at(t);
            assert!(domain.contains([u * (1.0 - 1e-9), v * (1.0 - 1e-9)]));
            assert!(!domain.contains([u * (1.0 + 1e-9), v * (1.0 + 1e-9)]));
            let (ahead, behind) = (arc.at(t + 1e-6), arc.at(t - 1e-6));
            for (i, exact) in arc.derivative(t).into_iter().enumerate() {
                let difference = (ahead[i] - behind[i]) / 2e-6;
                assert!(
                    (difference - exact).abs() < 1e-6 * 200.0,
                    "{difference} {exact}"
                );
            }
        }
    }

    #[test]
    fn an_annulus_has_two_closed_arcs_and_a_patch_four_sides() {
        let annulus =
            ParameterDomain::rectangle(Interval::turn(), Interval::symmetric(1.0)).boundary_arcs();
        assert!(annulus.len() == 2 && annulus.iter().all(BoundaryArc::is_closed));
        let patch = ParameterDomain::rectangle(Interval::symmetric(2.0), Interval::symmetric(1.0))
            .boundary_arcs();
        assert!(patch.len() == 4 && !patch.iter().any(BoundaryArc::is_closed));
        let torus = ParameterDomain::rectangle(Interval::turn(), Interval::turn()).boundary_arcs();
        assert!(torus.is_empty());
    }
}
