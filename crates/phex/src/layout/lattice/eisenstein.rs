//! The hexagonal lattice `Z[w]`, `w = exp(i pi / 3)`, and how neighbouring vertices see it.

use crate::directions::Directions;
use nalgebra::Complex;
use phex_mesh::{EdgeId, HalfEdgeId, PerEdge, Topology};
use std::f64::consts::TAU;
use std::ops::{Add, AddAssign, Neg, Sub};

/// Complex numbers: positions in a tangent plane, in lattice spacings.
pub(crate) type Plane = Complex<f64>;

/// Half the square root of three: height of the lattice's triangle, and area of its cell.
pub const CELL: f64 = 0.866_025_403_784_438_6;

/// A lattice point `a + b w`, exact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Eisenstein {
    /// Multiple of 1.
    pub a: i32,
    /// Multiple of `w`.
    pub b: i32,
}

impl Eisenstein {
    /// The origin.
    pub const ZERO: Self = Self { a: 0, b: 0 };

    /// The lattice point nearest to `z`; of several the first in the order of `b`, then `a`.
    pub fn nearest(z: Plane) -> Self {
        // Well within the cell round 0.
        if z.norm_sqr() < 0.24 {
            return Self::ZERO;
        }
        let b = z.im / CELL;
        let a = z.re - 0.5 * b;
        let (fa, fb) = (a.floor(), b.floor());
        let mut best = (f64::INFINITY, Self::ZERO);
        for (da, db) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let p = Self {
                a: fa as i32 + da,
                b: fb as i32 + db,
            };
            let distance = (z - p.to_plane()).norm_sqr();
            if distance < best.0 - 1e-12 {
                best = (distance, p);
            }
        }
        best.1
    }

    /// Position in the plane.
    pub fn to_plane(self) -> Plane {
        Plane::new(
            f64::from(self.a) + 0.5 * f64::from(self.b),
            CELL * f64::from(self.b),
        )
    }

    /// Product with `w^k`, a rotation by `k` sixths of a turn.
    pub(crate) fn rotated(self, k: u8) -> Self {
        (0..k % 6).fold(self, |p, _| Self {
            a: -p.b,
            b: p.a + p.b,
        })
    }
}

impl Add for Eisenstein {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            a: self.a + o.a,
            b: self.b + o.b,
        }
    }
}

impl AddAssign for Eisenstein {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Eisenstein {
    type Output = Self;
    fn sub(self, o: Self) -> Self {
        Self {
            a: self.a - o.a,
            b: self.b - o.b,
        }
    }
}

impl Neg for Eisenstein {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            a: -self.a,
            b: -self.b,
        }
    }
}

/// `z` rotated by `k` sixths of a turn.
pub(crate) fn rotate(z: Plane, k: u8) -> Plane {
    const H: f64 = CELL;
    match k % 6 {
        0 => z,
        1 => Plane::new(0.5 * z.re - H * z.im, H * z.re + 0.5 * z.im),
        2 => Plane::new(-0.5 * z.re - H * z.im, H * z.re - 0.5 * z.im),
        3 => -z,
        4 => Plane::new(-0.5 * z.re + H * z.im, -H * z.re - 0.5 * z.im),
        _ => Plane::new(0.5 * z.re + H * z.im, -H * z.re + 0.5 * z.im),
    }
}

/// The change of chart across an edge: a point `z` of the target's chart is `rotate(z, turn) +
/// offset` in the origin's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transition {
    /// Sixths of a turn.
    pub turn: u8,
    /// Position of the target vertex in the chart of the origin.
    pub offset: Plane,
}

impl Transition {
    /// The transition the other way.
    pub fn inverse(self) -> Self {
        let turn = (6 - self.turn) % 6;
        Self {
            turn,
            offset: -rotate(self.offset, turn),
        }
    }
    /// The point `z` of the target's chart, in the origin's.
    pub fn apply(self, z: Plane) -> Plane {
        rotate(z, self.turn) + self.offset
    }
}

/// Transitions along all edges, from the target's chart to the origin's of the edge's half-edge.
#[derive(Clone, Debug)]
pub(crate) struct Charts {
    edge: PerEdge<Transition>,
}

impl Charts {
    /// Charts aligned with the direction field.
    pub fn new(topology: &Topology, directions: &Directions) -> Self {
        let edge = PerEdge::from_fn(topology.n_edges(), |e| transition(topology, directions, e));
        Self { edge }
    }

    /// The same, with the lattice points that jumps name for the origins of the targets' charts.
    pub(super) fn with_jumps(&self, jump: &PerEdge<Eisenstein>) -> Self {
        let edge = PerEdge::from_fn(self.edge.len(), |e| Transition {
            offset: self.edge[e].offset - jump[e].to_plane(),
            ..self.edge[e]
        });
        Self { edge }
    }

    /// The transition along an edge, from target to origin of its half-edge.
    pub fn edge(&self, e: EdgeId) -> Transition {
        self.edge[e]
    }

    /// The transition from target to origin of any half-edge.
    pub fn half_edge(&self, topology: &Topology, h: HalfEdgeId) -> Transition {
        let e = topology.edge(h);
        if topology.runs_along(h) {
            self.edge[e]
        } else {
            self.edge[e].inverse()
        }
    }
}

fn transition(topology: &Topology, directions: &Directions, e: EdgeId) -> Transition {
    let mesh = &directions.intrinsic;
    let [i, j] = topology.edge_vertices(e);
    let turn = directions.turn[e].rem_euclid(6) as u8;
    // Both ends see the edge; their views are averaged.
    let from_origin = Plane::from_polar(1.0, mesh.polar_origin[e] - directions.angle[i]);
    let from_target = -rotate(
        Plane::from_polar(1.0, mesh.polar_target[e] - directions.angle[j]),
        turn,
    );
    let mean = from_origin + from_target;
    let offset = mean * (mesh.length[e] / (mean.norm() + 1e-12));
    Transition { turn, offset }
}

/// The six shortest vectors `g` of the reciprocal lattice: `<g, z>` is an integer at lattice
/// points.
pub(crate) fn reciprocal(m: usize) -> Plane {
    const THIRD: f64 = 0.5 / CELL;
    match m % 6 {
        0 => Plane::new(1.0, THIRD),
        1 => Plane::new(0.0, 2.0 * THIRD),
        2 => Plane::new(-1.0, THIRD),
        m => -reciprocal(m - 3),
    }
}

/// The three waves of a lattice offset.
pub(super) fn waves(z: Plane) -> [Plane; 3] {
    let [first, second] = [0, 1].map(|m| Plane::from_polar(1.0, TAU * dot(reciprocal(m), z)));
    [first, second, third(first, second)]
}

/// The reciprocal vectors are a sixth of a turn apart, so that the third is the second less the
/// first.
pub(super) fn third(first: Plane, second: Plane) -> Plane {
    second * first.conj()
}

/// Real scalar product of two plane vectors.
pub(crate) fn dot(a: Plane, b: Plane) -> f64 {
    a.re * b.re + a.im * b.im
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_agree() {
        let p = Eisenstein { a: 3, b: -5 };
        for k in 0..12 {
            assert!((p.rotated(k).to_plane() - rotate(p.to_plane(), k)).norm() < 1e-12);
        }
    }

    #[test]
    fn nearest_is_nearest() {
        for i in 0..400 {
            let z = Plane::new(
                (f64::from(i) * 0.731).sin() * 4.0,
                (f64::from(i) * 1.377).cos() * 4.0,
            );
            let p = Eisenstein::nearest(z);
            for k in 0..6 {
                let q = p + Eisenstein { a: 1, b: 0 }.rotated(k);
                assert!((z - p.to_plane()).norm() <= (z - q.to_plane()).norm() + 1e-9);
            }
        }
    }

    #[test]
    fn reciprocal_vectors_give_integers() {
        for m in 0..6 {
            for (a, b) in [(1, 0), (0, 1), (7, -3)] {
                let x = dot(reciprocal(m), Eisenstein { a, b }.to_plane());
                assert!((x - x.round()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn one_minus_w_is_a_unit() {
        // A cone of one sixth absorbs any translation: (1 - w) z = t has a lattice solution z = w
        // t.
        let t = Eisenstein { a: 4, b: -7 };
        let z = t.rotated(1);
        assert_eq!(z - z.rotated(1), t);
    }

    #[test]
    fn transitions_invert() {
        let t = Transition {
            turn: 2,
            offset: Plane::new(0.3, -1.2),
        };
        let z = Plane::new(-2.0, 0.7);
        assert!((t.inverse().apply(t.apply(z)) - z).norm() < 1e-12);
    }
}
