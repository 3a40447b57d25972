//! The point of a parametric surface that is closest to a point of space, to rounding.
//!
//! A table of samples finds every place where the distance may be least; from each of them a damped
//! Newton iteration goes down inside the domain, and bisection goes along the boundary curves. The
//! nearest result is returned. A surface with a direct method
//! ([`ParametricSurface::closest_parameters`]) needs none of this.
//!
//! With `r = x(u, v) - p`, the gradient of `|r|^2 / 2` is `(r.x_u, r.x_v)` and its Hessian is
//! `[E + r.x_uu, F + r.x_uv; ., G + r.x_vv]`.
//!
//! The answer is the closest point of all as long as the samples resolve the surface: features
//! smaller than the mean edge of some 4000 triangles may be missed. Where several points are
//! equally close, one of them is returned, always the same.

use super::domain::{BoundaryArc, ParameterDomain};
use super::parametric::ParametricSurface;
use super::triangulate::{Triangulation, TriangulationOptions, triangulate_with_parameters};
use super::{Shape, ShapeError};
use crate::{BoundaryPoint, Vec2, Vec3};
use nalgebra::Matrix2;
use rayon::prelude::*;

/// Triangles in the table of samples.
const SAMPLE_TRIANGLES: usize = 4000;
/// Samples of each boundary arc.
const ARC_SAMPLES: usize = 256;
/// Newton steps, of which a handful is needed unless `p` is near a centre of curvature.
const MAX_STEPS: usize = 100;
/// A step this short, relative to the surface's diagonal, ends the iteration: the next one would be
/// rounding.
const STEP_REL: f64 = 1e-13;

/// A point on a parametric surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePoint {
    /// `(u, v)`, inside the domain.
    pub parameters: [f64; 2],
    /// The point.
    pub position: Vec3,
    /// Unit normal there.
    pub normal: Vec3,
}

/// Closest points on one surface; building it takes a few milliseconds, a query some ten
/// microseconds.
#[derive(Clone, Debug)]
pub struct ShapeProjector<S = Shape> {
    surface: S,
    domain: ParameterDomain,
    samples: Samples,
    arcs: Vec<(BoundaryArc, Vec<Vec3>)>,
}

/// The point of `shape` closest to `p`. For many points build a [`ShapeProjector`] once.
///
/// # Errors
/// If the shape cannot be triangulated, which no built-in shape fails to be.
pub fn closest_point(shape: &Shape, p: Vec3) -> Result<ShapePoint, ShapeError> {
    Ok(ShapeProjector::new(shape.clone())?.closest_point(p))
}

impl<S: ParametricSurface> ShapeProjector<S> {
    /// Samples the surface.
    ///
    /// # Errors
    /// If the surface cannot be triangulated.
    pub fn new(surface: S) -> Result<Self, ShapeError> {
        let options = TriangulationOptions {
            triangles: SAMPLE_TRIANGLES,
            ..TriangulationOptions::default()
        };
        let samples = Samples::new(triangulate_with_parameters(&surface, &options)?);
        let domain = surface.domain();
        let sample_arc = |arc: BoundaryArc| {
            let at = |k: usize| arc.at(k as f64 / ARC_SAMPLES as f64);
            let points = (0..=ARC_SAMPLES).map(at).map(|[u, v]| surface.point(u, v));
            (arc, points.collect())
        };
        let arcs = domain.boundary_arcs().into_iter().map(sample_arc).collect();
        Ok(Self {
            surface,
            domain,
            samples,
            arcs,
        })
    }

    /// The surface.
    pub fn surface(&self) -> &S {
        &self.surface
    }

    /// The point of the surface that is closest to `p` (finite).
    pub fn closest_point(&self, p: Vec3) -> ShapePoint {
        let direct = self.surface.closest_parameters(p);
        let parameters = direct.unwrap_or_else(|| self.search(p));
        let [u, v] = self.domain.wrap(parameters);
        ShapePoint {
            parameters: [u, v],
            position: self.surface.point(u, v),
            normal: self.surface.normal(u, v),
        }
    }

    /// Closest points of many, in their order; the same for any number of threads.
    pub fn closest_points(&self, points: &[Vec3]) -> Vec<ShapePoint> {
        points.par_iter().map(|&p| self.closest_point(p)).collect()
    }

    /// The point of the boundary that is closest to `p` (finite), and the unit tangent there
    /// (either way); `None` for a closed surface.
    pub fn closest_on_boundary(&self, p: Vec3) -> Option<BoundaryPoint> {
        let arcs = self.arcs.iter();
        let feet = arcs.flat_map(|(arc, points)| {
            let nearest = self
                .lowest_on_arc(arc, points, p, f64::INFINITY)
                .into_iter();
            nearest.map(|t| self.on_arc(arc, t))
        });
        let distance = |q: &BoundaryPoint| (q.position - p).norm_squared();
        feet.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    fn on_arc(&self, arc: &BoundaryArc, t: f64) -> BoundaryPoint {
        let ([u, v], [du, dv]) = (arc.at(t), arc.derivative(t));
        let jet = self.surface.jet(u, v);
        BoundaryPoint {
            position: jet.point,
            tangent: (jet.du * du + jet.dv * dv).normalize(),
        }
    }

    fn search(&self, p: Vec3) -> [f64; 2] {
        let starts = self.samples.starts(p);
        let rims = self
            .arcs
            .iter()
            .flat_map(|(arc, points)| self.along_arc(arc, points, p, starts.reach));
        // From a rim sample the way inside may be barred; from the nearest point of the rim it is
        // not.
        let all = starts.parameters.iter().copied().chain(rims);
        let ends = all.map(|start| self.descend(start, p));
        let distance = |&[u, v]: &[f64; 2]| (self.surface.point(u, v) - p).norm_squared();
        let nearest = ends.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(self.samples.triangulation.parameters[0])
    }

    /// Levenberg-Marquardt that never leaves the domain and never moves away from `p`.
    fn descend(&self, start: [f64; 2], p: Vec3) -> [f64; 2] {
        let shortest = STEP_REL * self.samples.diagonal;
        let mut at = Vec2::from(start);
        let mut damping = 0.0;
        for _ in 0..MAX_STEPS {
            if damping > 1e8 {
                break;
            }
            let local = LocalModel::new(&self.surface, at, p);
            let accepted = local
                .step(damping)
                .filter(|step| self.is_descent(at, *step, p));
            let Some(step) = accepted else {
                damping = f64::max(4.0 * damping, 1e-3);
                continue;
            };
            at += step;
            if local.length(step) <= shortest && damping < 1e-2 {
                break;
            }
            damping = if damping < 1e-2 { 0.0 } else { 0.1 * damping };
        }
        at.into()
    }

    /// Whether a step stays in the domain and does not raise the distance by more than rounding.
    fn is_descent(&self, at: Vec2, step: Vec2, p: Vec3) -> bool {
        let distance = |q: Vec2| (self.surface.point(q.x, q.y) - p).norm_squared();
        let end = at + step;
        self.domain.contains(end.into())
            && distance(end) <= distance(at) * (1.0 + 1e-14) + f64::MIN_POSITIVE
    }

    /// The nearest points along a boundary arc, one for each sample that is nearer than its
    /// neighbours and than `bound`.
    fn along_arc(&self, arc: &BoundaryArc, points: &[Vec3], p: Vec3, bound: f64) -> Vec<[f64; 2]> {
        let lowest = self.lowest_on_arc(arc, points, p, bound);
        lowest.into_iter().map(|t| arc.at(t)).collect()
    }

    /// Values of `t` where the distance along an arc has a minimum below `bound`, each found from
    /// the lowest of its samples.
    fn lowest_on_arc(&self, arc: &BoundaryArc, points: &[Vec3], p: Vec3, bound: f64) -> Vec<f64> {
        let distances: Vec<f64> = points.iter().map(|x| (x - p).norm()).collect();
        let last = distances.len() - 1;
        let before = |i: usize| match (i, arc.is_closed()) {
            (0, true) => Some(last - 1),
            _ => i.checked_sub(1),
        };
        let after = |i: usize| match (i == last, arc.is_closed()) {
            (true, true) => Some(1),
            _ => (i < last).then_some(i + 1),
        };
        let lowest = |i: &usize| {
            let no_nearer = |n: Option<usize>| n.is_none_or(|n| distances[*i] <= distances[n]);
            distances[*i] <= bound && no_nearer(before(*i)) && no_nearer(after(*i))
        };
        let middle = |i: usize| i as f64 / last as f64;
        let low = |i: usize| {
            if before(i).is_some() {
                middle(i) - middle(1)
            } else {
                0.0
            }
        };
        let high = |i: usize| {
            if after(i).is_some() {
                middle(i) + middle(1)
            } else {
                1.0
            }
        };
        (0..=last)
            .filter(lowest)
            .map(|i| wrap_arc(arc, self.bisect(arc, p, [low(i), high(i)])))
            .collect()
    }

    /// The zero of `r . dx/dt` between two values of `t`, or the end where the distance still
    /// falls.
    fn bisect(&self, arc: &BoundaryArc, p: Vec3, [mut low, mut high]: [f64; 2]) -> f64 {
        let slope = |t: f64| {
            let ([u, v], [du, dv]) = (arc.at(t), arc.derivative(t));
            let jet = self.surface.jet(u, v);
            (jet.point - p).dot(&(jet.du * du + jet.dv * dv))
        };
        if slope(low) >= 0.0 {
            return low;
        }
        if slope(high) <= 0.0 {
            return high;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if slope(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// Brings `t` back to 0..1 on a closed arc.
fn wrap_arc(arc: &BoundaryArc, t: f64) -> f64 {
    if arc.is_closed() {
        t.rem_euclid(1.0)
    } else {
        t
    }
}

/// Gradient and Hessian of `|x - p|^2 / 2` in the parameters, and the metric.
struct LocalModel {
    gradient: Vec2,
    hessian: Matrix2<f64>,
    metric: Matrix2<f64>,
}

impl LocalModel {
    fn new<S: ParametricSurface>(surface: &S, at: Vec2, p: Vec3) -> Self {
        let jet = surface.jet(at.x, at.y);
        let r = jet.point - p;
        let mixed = jet.du.dot(&jet.dv);
        let metric = Matrix2::new(jet.du.norm_squared(), mixed, mixed, jet.dv.norm_squared());
        let bend = Matrix2::new(
            r.dot(&jet.duu),
            r.dot(&jet.duv),
            r.dot(&jet.duv),
            r.dot(&jet.dvv),
        );
        Self {
            gradient: Vec2::new(r.dot(&jet.du), r.dot(&jet.dv)),
            hessian: metric + bend,
            metric,
        }
    }

    /// The minimum of the model damped in the metric, `None` where it has none.
    fn step(&self, damping: f64) -> Option<Vec2> {
        let matrix = self.hessian + self.metric * damping;
        let step = matrix.cholesky()?.solve(&-self.gradient);
        step.iter().all(|x| x.is_finite()).then_some(step)
    }

    /// Length of a step on the surface.
    fn length(&self, step: Vec2) -> f64 {
        step.dot(&(self.metric * step)).max(0.0).sqrt()
    }
}

/// Points spread over the surface, with their neighbours.
#[derive(Clone, Debug)]
struct Samples {
    triangulation: Triangulation,
    longest_edge: f64,
    diagonal: f64,
}

/// Where to start from.
struct Starts {
    parameters: Vec<[f64; 2]>,
    /// No start is further from the point than this.
    reach: f64,
}

impl Samples {
    fn new(triangulation: Triangulation) -> Self {
        let positions = &triangulation.positions;
        let sides = |t: &[u32; 3]| {
            [0, 1, 2].map(|i| positions[t[i] as usize] - positions[t[(i + 1) % 3] as usize])
        };
        let lengths = triangulation
            .triangles
            .iter()
            .flat_map(sides)
            .map(|side| side.norm());
        let longest_edge = lengths.fold(0.0, f64::max);
        let first = positions[0];
        let (low, high) = positions
            .iter()
            .fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p)));
        Self {
            longest_edge,
            diagonal: (high - low).norm(),
            triangulation,
        }
    }

    /// Samples nearer to `p` than all their neighbours, up to an edge further than the nearest one.
    fn starts(&self, p: Vec3) -> Starts {
        let mesh = &self.triangulation;
        let distances: Vec<f64> = mesh.positions.iter().map(|x| (x - p).norm()).collect();
        let reach = distances.iter().copied().fold(f64::INFINITY, f64::min) + self.longest_edge;
        let mut lowest: Vec<bool> = distances.iter().map(|&d| d <= reach).collect();
        for triangle in &mesh.triangles {
            let nearest = triangle
                .map(|i| distances[i as usize])
                .into_iter()
                .fold(f64::INFINITY, f64::min);
            for &i in triangle {
                lowest[i as usize] &= distances[i as usize] <= nearest;
            }
        }
        let chosen = (0..lowest.len()).filter(|&i| lowest[i]);
        Starts {
            parameters: chosen.map(|i| mesh.parameters[i]).collect(),
            reach,
        }
    }
}
