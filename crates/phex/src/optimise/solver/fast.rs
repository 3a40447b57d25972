//! The fast path: sequential quadratic programming from a start that is nearly planar, on the dual.
//!
//! The start is the mesh with every vertex moved to where the tangent planes of its faces meet
//! (Dupin duality; on rows of bricks this is the kink). From there
//!
//! ```text
//! E = w_c/2 sum |x - p(x) + b r|^2 + w_c/2 sum |x - x_0|^2   under   Q^T h = 0
//! ```
//!
//! is minimised, `W = (w_c n n^T + w_c I)^-1`. The hold on the start is as strong as closeness:
//! with a weak one vertices slide far along the surface where constraints nearly depend on each
//! other, and the iteration swings. Where faces are convex their centres stand off by `r`; shifting
//! the vertices by `b r`, `b = w_cf / (2 w_c + w_cf)`, balances both. There is neither barrier nor
//! fairness: on a conjugate layout none is needed, and elsewhere the result is not accepted. Then,
//! and where the iteration does not converge, the feasible path is taken instead.

use crate::optimise::constraints::guarded::GuardedSteps;
use crate::optimise::constraints::jacobian::Jacobian;
use crate::optimise::options::{KEPT_CLEARANCE, OptimiseOptions};
use crate::optimise::panels::{FaceShapes, point, put};
use crate::optimise::terms::closeness::{ClosenessWeights, DistanceLimit, Feet};
use crate::optimise::terms::setting::Setting;
use nalgebra::Matrix3;
use phex_mesh::Vec3;
use phex_numeric::{Assembly, SchurProblem, SymmetricMatrix};

/// Closeness under planarity, as a problem for `phex_numeric::SchurSqp`.
pub(super) struct NearlyPlanar<'a> {
    setting: &'a Setting<'a>,
    jacobian: Jacobian<'a>,
    weights: ClosenessWeights,
    hold: f64,
    anchor: Vec<f64>,
    /// What vertices are to keep from the surface.
    shift: Vec<Vec3>,
    feet: Feet,
    steps: GuardedSteps<'a>,
}

impl<'a> NearlyPlanar<'a> {
    /// The problem anchored at `start`.
    pub fn new(
        setting: &'a Setting<'a>,
        assembly: &'a Assembly,
        start: &[f64],
        options: &OptimiseOptions,
    ) -> Self {
        let panels = setting.panels;
        let shape = FaceShapes::at(panels, start);
        let mut feet = Feet::default();
        feet.update(setting.reference, &shape, start, setting.rim);
        let weights = ClosenessWeights {
            vertex: options.vertex_closeness,
            centre: options.centre_closeness,
            rim: options.boundary_closeness,
            limit: DistanceLimit::NONE,
        };
        let least = KEPT_CLEARANCE * setting.mean_edge;
        Self {
            shift: shifts(setting, &feet, &weights),
            jacobian: Jacobian::new(panels, assembly),
            hold: options.vertex_closeness,
            anchor: start.to_vec(),
            steps: GuardedSteps::new(setting, start, Some(least)),
            weights,
            feet,
            setting,
        }
    }

    /// Planarity of the start, in mean edges.
    pub fn planarity(&self) -> f64 {
        self.steps.planarity()
    }

    /// Metric and free step.
    fn weigh(&mut self, x: &[f64], free: &mut [f64]) {
        let setting = self.setting;
        let mut rim = setting.rim.iter().enumerate().peekable();
        for v in 0..setting.panels.n_vertices() {
            let term = match rim.next_if(|(_, r)| **r as usize == v) {
                Some((k, _)) => self.feet.rim_vertex(k, v, &self.weights),
                None => self.feet.vertex(v, self.weights.vertex),
            };
            let pull = (point(x, v) - point(&self.anchor, v)) * self.hold;
            let gradient = term.gradient + self.shift[v] * self.weights.vertex + pull;
            let hessian = term.hessian + Matrix3::from_diagonal_element(self.hold);
            let metric = hessian.try_inverse().unwrap_or_else(Matrix3::identity);
            let step = -metric * gradient;
            self.jacobian.metric[v] = metric;
            put(free, v, &step);
        }
    }
}

/// `b r` at each vertex: the mean of what its face centres stand off more than their corners.
fn shifts(setting: &Setting<'_>, feet: &Feet, weights: &ClosenessWeights) -> Vec<Vec3> {
    let panels = setting.panels;
    let n = panels.n_vertices();
    let share = weights.centre / (2.0 * weights.vertex + weights.centre);
    let sagitta = |f: usize| {
        let corners = panels.vertices(f);
        let mean: Vec3 = corners.iter().map(|&v| feet.residual(v as usize)).sum();
        feet.residual(n + f) - mean / corners.len() as f64
    };
    let sagittas: Vec<Vec3> = (0..panels.n_faces()).map(sagitta).collect();
    let shift = |v: usize| {
        let corners = panels.corners_at(v);
        let sum: Vec3 = corners.iter().map(|&c| sagittas[panels.face_of(c)]).sum();
        sum * (share / corners.len() as f64)
    };
    (0..n).map(shift).collect()
}

impl SchurProblem for NearlyPlanar<'_> {
    fn linearise(
        &mut self,
        x: &[f64],
        values: &mut [f64],
        free: &mut [f64],
        schur: &mut SymmetricMatrix,
    ) {
        let setting = self.setting;
        std::mem::swap(&mut self.steps.linearised, &mut self.steps.trial);
        self.feet
            .update(setting.reference, &self.steps.linearised, x, setting.rim);
        self.weigh(x, free);
        self.jacobian.linearise(&self.steps.linearised, values);
        self.jacobian.normal_matrix(schur);
    }

    fn product(&self, d: &[f64], values: &mut [f64]) {
        self.jacobian.product(d, values);
    }

    fn spread(&self, y: &[f64], d: &mut [f64]) {
        self.jacobian.spread(y, d);
    }

    fn step_bound(&mut self, step: &[f64]) -> f64 {
        self.steps.bound(step)
    }

    fn admissible(&mut self, x: &[f64]) -> Option<f64> {
        self.steps.admits(x).then(|| self.steps.planarity())
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        self.steps.length(step)
    }
}
