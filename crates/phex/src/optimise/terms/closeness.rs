//! Closeness: vertices, face centres and the rim are drawn to the surface.
//!
//! `w/2 |x - p(x)|^2` with the foot point `p`, gradient `w (x - p)`, Hessian `w n n^T` (distance to
//! the tangent plane). Face centres count as well, since the middle of a large convex panel may
//! stand off where its corners do not. Vertices of the boundary are drawn to the boundary curve
//! too, Hessian `w (I - t t^T)`. Beyond the rim the foot point lies on the curve, so there the
//! surface term takes the same form.

use super::inequality::Elastic;
use super::osculating::Osculating;
use super::point_term::PointTerm;
use crate::optimise::TargetPoint;
use crate::optimise::panels::{FaceShapes, extent};
use crate::optimise::targets::reference::Reference;
use nalgebra::Matrix3;
use phex_mesh::{BoundaryPoint, Vec3};

/// Share of the extent of the mesh within which a point lies on the boundary curve.
const ON_CURVE: f64 = 1e-10;

/// Foot points at some positions; asked for once and used for energy, gradient and Hessian.
#[derive(Clone, Debug, Default)]
pub(in crate::optimise) struct Feet {
    points: Vec<Vec3>,
    /// Where foot points were found last, and these.
    found_at: Vec<Vec3>,
    feet: Vec<TargetPoint>,
    rim_points: Vec<Vec3>,
    rim: Vec<BoundaryPoint>,
    /// What stands in for surface and boundary curve while it is frozen.
    osculating: Option<Osculating>,
    is_frozen: bool,
    /// Distance to the boundary curve up to which a point lies on it: rounding decides nothing.
    on_curve: f64,
}

/// A limit of the distance to the surface, as an inequality with slack: `c = 1 - |r|^2 / most^2`.
#[derive(Clone, Copy, Debug)]
pub(in crate::optimise) struct DistanceLimit {
    pub elastic: Elastic,
    /// The largest distance; infinite where any will do.
    pub most: f64,
}

impl DistanceLimit {
    /// Any distance will do.
    pub const NONE: Self = Self {
        elastic: Elastic { weight: 0.0 },
        most: f64::INFINITY,
    };

    /// Cost of a distance by its square.
    fn value(&self, square: f64) -> f64 {
        self.elastic.value(1.0 - square / (self.most * self.most))
    }

    /// The weight of closeness that has the same gradient, and the factor of `r r^T` that the
    /// Gauss-Newton Hessian has besides.
    fn derivatives(&self, square: f64) -> [f64; 2] {
        let slope = -2.0 / (self.most * self.most);
        let [first, second] = self.elastic.derivatives(1.0 + 0.5 * slope * square);
        [first * slope, second * slope * slope]
    }
}

/// Weights of closeness.
#[derive(Clone, Copy, Debug)]
pub(in crate::optimise) struct ClosenessWeights {
    pub vertex: f64,
    pub centre: f64,
    pub rim: f64,
    pub limit: DistanceLimit,
}

impl Feet {
    /// Finds the foot points; `rim_vertices` are drawn to the boundary curve.
    pub(crate) fn update(
        &mut self,
        reference: &Reference<'_>,
        shape: &FaceShapes,
        x: &[f64],
        rim_vertices: &[u32],
    ) {
        self.points.clear();
        self.points
            .extend(x.chunks_exact(3).map(Vec3::from_column_slice));
        self.rim_points.clear();
        let rim = rim_vertices.iter().map(|&v| self.points[v as usize]);
        self.rim_points.extend(rim);
        self.on_curve = ON_CURVE * extent(x);
        let centres = shape.frames.iter().map(|frame| frame.plane.centre);
        self.points.extend(centres);
        if self.is_frozen {
            return;
        }
        self.feet = reference.feet(&self.points, (&self.found_at, &self.feet));
        self.found_at.clone_from(&self.points);
        self.rim = reference.on_boundary(&self.rim_points).unwrap_or_default();
    }

    /// From now on a smooth stand-in at the foot points found last takes the place of surface and
    /// boundary curve.
    pub(crate) fn freeze(&mut self, reference: &Reference<'_>, mean_edge: f64) {
        let last = self.osculating.take();
        let now = Osculating::new(reference, &self.feet, &self.rim, mean_edge, last);
        self.osculating = Some(now);
        self.is_frozen = true;
    }

    fn stand_in(&self) -> Option<&Osculating> {
        self.osculating.as_ref().filter(|_| self.is_frozen)
    }

    /// Goes back to surface and boundary curve themselves.
    pub(crate) fn thaw(&mut self) {
        self.is_frozen = false;
    }

    /// From the foot point to the point: vertices, then face centres.
    pub fn residual(&self, k: usize) -> Vec3 {
        match self.stand_in() {
            Some(o) => o.residual(k, self.points[k]),
            None => self.points[k] - self.feet[k].position,
        }
    }

    /// From the boundary curve to the `k`-th vertex of the rim; `None` without a curve.
    fn rim_residual(&self, k: usize) -> Option<Vec3> {
        match self.stand_in() {
            Some(o) => o.rim_residual(k, self.rim_points[k]),
            None => Some(self.rim_points[k] - self.rim.get(k)?.position),
        }
    }

    pub fn energy(&self, n_vertices: usize, weights: &ClosenessWeights) -> f64 {
        let weight = |k: usize| {
            if k < n_vertices {
                weights.vertex
            } else {
                weights.centre
            }
        };
        let surface: f64 = (0..self.points.len())
            .map(|k| {
                let square = self.residual(k).norm_squared();
                weight(k) * square + 2.0 * weights.limit.value(square)
            })
            .sum();
        let rim = (0..self.rim_points.len()).filter_map(|k| self.rim_residual(k));
        let curve: f64 = rim.map(|r| r.norm_squared()).sum();
        0.5 * (surface + weights.rim * curve)
    }

    /// Surface term of a vertex.
    pub fn vertex(&self, v: usize, weight: f64) -> PointTerm {
        if let Some(o) = self.stand_in() {
            return o.term(v, self.points[v], weight);
        }
        let normal = self.feet[v].normal;
        PointTerm {
            gradient: self.residual(v) * weight,
            hessian: normal * normal.transpose() * weight,
        }
    }

    /// Surface term of a point whose distance is limited.
    pub fn limited(&self, k: usize, weight: f64, limit: &DistanceLimit) -> PointTerm {
        let r = self.residual(k);
        let [more, curved] = limit.derivatives(r.norm_squared());
        let mut term = self.vertex(k, weight + more);
        term.hessian += r * r.transpose() * curved;
        term
    }

    /// Surface term of a face centre.
    pub fn centre(&self, n_vertices: usize, f: usize, weights: &ClosenessWeights) -> PointTerm {
        self.limited(n_vertices + f, weights.centre, &weights.limit)
    }

    /// Surface and boundary term of the `k`-th rim vertex `v`.
    pub(crate) fn rim_vertex(&self, k: usize, v: usize, weights: &ClosenessWeights) -> PointTerm {
        let mut term = self.limited(v, weights.vertex, &weights.limit);
        if let Some(o) = self.stand_in() {
            o.add_rim(k, self.points[v], weights.rim, &mut term);
            return term;
        }
        let Some(q) = self.rim.get(k) else {
            return term;
        };
        let across = Matrix3::identity() - q.tangent * q.tangent.transpose();
        let offset = self.points[v] - q.position;
        let apart = (q.position - self.feet[v].position).norm();
        let beyond = offset.norm() > self.on_curve && apart <= 1e-9 * offset.norm();
        if beyond {
            term.hessian = across * weights.vertex;
        }
        term.gradient += offset * weights.rim;
        term.hessian += across * weights.rim;
        term
    }

    /// Distances of vertices, then of face centres, to their foot points.
    pub fn distances(&self) -> Vec<f64> {
        let all = 0..self.points.len();
        all.map(|k| self.residual(k).norm()).collect()
    }
}
