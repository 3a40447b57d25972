//! A smooth stand-in for what a panelling is kept close to, for the last steps: at each foot point
//! the distance to second order.
//!
//! ```text
//! phi(x) = n . y + y . S y / 2,   y = x - p        closeness  w phi^2 / 2
//! r(x)   = y - s t - s^2 k / 2,   s = t . y        closeness of the rim  w |r|^2 / 2
//! ```
//!
//! with the foot point `p`, its normal `n` and shape operator `S`, or its tangent `t` and curvature
//! vector `k`, both from differences of normals and tangents nearby. The distance to a
//! triangulation has a kink wherever the foot point crosses an edge, which no method can minimise
//! over to the last digits; this is a polynomial. It is off by the third order of how far a vertex
//! still slides.

use super::point_term::PointTerm;
use crate::optimise::TargetPoint;
use crate::optimise::targets::reference::Reference;
use nalgebra::Matrix3;
use phex_mesh::{BoundaryPoint, Vec3};

/// Distance, in mean edges, at which normals and tangents are compared.
const APART: f64 = 0.25;

/// The surface near a foot point.
#[derive(Clone, Debug)]
struct OsculatingQuadric {
    foot: TargetPoint,
    shape: Matrix3<f64>,
}

/// The boundary curve near a foot point.
#[derive(Clone, Debug)]
struct OsculatingArc {
    foot: BoundaryPoint,
    curvature: Vec3,
}

/// The stand-in, for vertices and then face centres, and for the vertices of the rim.
#[derive(Clone, Debug)]
pub(super) struct Osculating {
    quadrics: Vec<OsculatingQuadric>,
    arcs: Vec<OsculatingArc>,
}

impl Osculating {
    /// Takes it at the foot points of some points. Of the `last` one what has the same foot stays.
    pub fn new(
        reference: &Reference<'_>,
        feet: &[TargetPoint],
        rim: &[BoundaryPoint],
        mean_edge: f64,
        last: Option<Self>,
    ) -> Self {
        let apart = APART * mean_edge;
        let mut quadrics = last.map_or_else(Vec::new, |last| last.quadrics);
        quadrics.truncate(feet.len());
        let is_known = |k: &usize| quadrics.get(*k).is_some_and(|q| q.foot == feet[*k]);
        let new: Vec<usize> = (0..feet.len()).filter(|k| !is_known(k)).collect();
        let new_feet: Vec<TargetPoint> = new.iter().map(|k| feet[*k]).collect();
        let found = quadrics_at(reference, &new_feet, apart);
        for (k, quadric) in new.into_iter().zip(found) {
            match quadrics.get_mut(k) {
                Some(place) => *place = quadric,
                None => quadrics.push(quadric),
            }
        }
        Self {
            quadrics,
            arcs: arcs(reference, rim, apart),
        }
    }

    /// `phi` and its gradient at a point.
    fn distance(&self, k: usize, p: Vec3) -> (f64, Vec3) {
        let OsculatingQuadric { foot, shape } = &self.quadrics[k];
        let y = p - foot.position;
        let bend = shape * y;
        (foot.normal.dot(&y) + 0.5 * y.dot(&bend), foot.normal + bend)
    }

    /// From the stand-in to a point.
    pub fn residual(&self, k: usize, p: Vec3) -> Vec3 {
        self.quadrics[k].foot.normal * self.distance(k, p).0
    }

    /// Gradient and Hessian of `w phi^2 / 2`.
    pub fn term(&self, k: usize, p: Vec3, weight: f64) -> PointTerm {
        let (distance, slope) = self.distance(k, p);
        PointTerm {
            gradient: slope * (weight * distance),
            hessian: (slope * slope.transpose() + self.quadrics[k].shape * distance) * weight,
        }
    }

    /// From the boundary curve's stand-in to the `k`-th vertex of the rim; `None` without a curve.
    pub(crate) fn rim_residual(&self, k: usize, p: Vec3) -> Option<Vec3> {
        let OsculatingArc { foot, curvature } = self.arcs.get(k)?;
        let y = p - foot.position;
        let s = foot.tangent.dot(&y);
        Some(y - foot.tangent * s - curvature * (0.5 * s * s))
    }

    /// Adds gradient and Hessian of the rim's closeness.
    pub(crate) fn add_rim(&self, k: usize, p: Vec3, weight: f64, term: &mut PointTerm) {
        let (Some(arc), Some(r)) = (self.arcs.get(k), self.rim_residual(k, p)) else {
            return;
        };
        let (t, c) = (arc.foot.tangent, arc.curvature);
        let s = t.dot(&(p - arc.foot.position));
        let slope = Matrix3::identity() - (t + c * s) * t.transpose();
        term.gradient += slope.transpose() * r * weight;
        term.hessian += (slope.transpose() * slope - t * t.transpose() * r.dot(&c)) * weight;
    }
}

/// Axes, in equal angles, along which normals are compared: with three of them the leading error is
/// the same in every frame.
const AXES: usize = 3;

/// Shape operators `2 / m sum dn t^T` from differences `dn` of normals along `m` axes `t` around
/// each foot point.
fn quadrics_at(
    reference: &Reference<'_>,
    feet: &[TargetPoint],
    apart: f64,
) -> Vec<OsculatingQuadric> {
    let mut shapes = vec![Matrix3::zeros(); feet.len()];
    for axis in 0..AXES {
        let axes: Vec<Vec3> = feet.iter().map(|f| tangent(f.normal, axis)).collect();
        let around = |sign: f64| {
            let moved = |(f, t): (&TargetPoint, &Vec3)| f.position + t * (sign * apart);
            let points: Vec<Vec3> = feet.iter().zip(&axes).map(moved).collect();
            reference.feet(&points, (&[], feet))
        };
        let (ahead, behind) = (around(1.0), around(-1.0));
        for (k, shape) in shapes.iter_mut().enumerate() {
            let t = axes[k];
            let length = t.dot(&(ahead[k].position - behind[k].position));
            // Beyond a rim the foot points no longer part.
            if length > apart {
                let change = (ahead[k].normal - behind[k].normal) / length;
                *shape += change * t.transpose() * (2.0 / AXES as f64);
            }
        }
    }
    let quadric = |(foot, shape): (&TargetPoint, Matrix3<f64>)| {
        let flat = Matrix3::identity() - foot.normal * foot.normal.transpose();
        OsculatingQuadric {
            foot: *foot,
            shape: flat * (shape + shape.transpose()) * flat * 0.5,
        }
    };
    feet.iter().zip(shapes).map(quadric).collect()
}

fn arcs(reference: &Reference<'_>, rim: &[BoundaryPoint], apart: f64) -> Vec<OsculatingArc> {
    let around = |sign: f64| {
        let moved = |c: &BoundaryPoint| c.position + c.tangent * (sign * apart);
        let points: Vec<Vec3> = rim.iter().map(moved).collect();
        reference.on_boundary(&points).unwrap_or_default()
    };
    let (ahead, behind) = (around(1.0), around(-1.0));
    let arc = |(k, foot): (usize, &BoundaryPoint)| {
        let mut curvature = Vec3::zeros();
        if let (Some(a), Some(b)) = (ahead.get(k), behind.get(k)) {
            let length = foot.tangent.dot(&(a.position - b.position));
            // At a corner, or where the curve has another direction, it is taken as straight.
            let turns_little = a.tangent.dot(&b.tangent) > 0.5;
            if length > apart && turns_little {
                let change = (a.tangent - b.tangent) / length;
                curvature = change - foot.tangent * foot.tangent.dot(&change);
            }
        }
        OsculatingArc {
            foot: *foot,
            curvature,
        }
    };
    rim.iter().enumerate().map(arc).collect()
}

/// One of the axes across a unit vector.
fn tangent(normal: Vec3, axis: usize) -> Vec3 {
    let first = normal.cross(&Vec3::ith(normal.iamin(), 1.0));
    let first = first.try_normalize(0.0).unwrap_or_else(Vec3::x);
    let (sin, cos) = (axis as f64 * std::f64::consts::PI / AXES as f64).sin_cos();
    first * cos + normal.cross(&first) * sin
}
