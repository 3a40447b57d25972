//! Radii of the circles of an orthogonal circle pattern: Newton's method on a convex energy.

use super::circles::{Circles, NodeId};
use phex_numeric::{Cholesky, NumericError, Outcome, Record, Status, SymmetricMatrix, max_abs};
use std::f64::consts::TAU;

/// Trial steps of a line search at the most.
const LINE_SEARCH_STEPS: usize = 30;

/// A step is accepted when the slope along it has fallen below this fraction of the slope at its
/// start.
const SLOPE_FRACTION: f64 = 0.5;

/// Residual below which one that does not fall is at the floor of rounding.
const STALL: f64 = 1e-9;

/// Logarithms of the radii, and which of them are unknown.
#[derive(Clone, Debug)]
pub(super) struct Radii {
    /// `rho` of each node; infinite for circles that are lines.
    pub rho: Vec<f64>,
    /// Angle sum that each node shall have.
    pub target_angle: Vec<f64>,
    /// Number of the unknown of each node, none where the radius is given.
    unknown: Vec<Option<u32>>,
    n_unknowns: usize,
}

/// When to stop.
pub(super) struct RadiiOptions {
    pub max_iterations: usize,
    pub tolerance: f64,
}

impl Radii {
    /// Start values, radii given where `given` says so; all angle sums are full turns.
    pub fn new(circles: &Circles, given: impl Fn(NodeId) -> Option<f64>) -> Self {
        let mut radii = Self {
            rho: Vec::with_capacity(circles.n_nodes()),
            target_angle: vec![TAU; circles.n_nodes()],
            unknown: Vec::with_capacity(circles.n_nodes()),
            n_unknowns: 0,
        };
        for node in circles.nodes() {
            let known = given(node);
            radii
                .rho
                .push(known.unwrap_or_else(|| start(circles.degree(node))));
            radii
                .unknown
                .push(known.is_none().then_some(radii.n_unknowns as u32));
            radii.n_unknowns += usize::from(known.is_none());
        }
        radii
    }

    /// Keeps the start value of the last unknown: where no radius is given the pattern is free to
    /// grow, and the other angle sums imply that of one node.
    pub(crate) fn fix_scale(&mut self) {
        if let Some(last) = self.unknown.iter_mut().rev().find(|u| u.is_some()) {
            *last = None;
            self.n_unknowns -= 1;
        }
    }

    /// Half the angle at which node `j` sees its kite with node `k`.
    pub fn half_angle(&self, j: NodeId, k: NodeId) -> f64 {
        (self.rho[k] - self.rho[j]).exp().atan()
    }

    /// Radius of a node, infinite for a line.
    pub fn radius(&self, j: NodeId) -> f64 {
        self.rho[j].exp()
    }

    /// Finds the radii that give every unknown node its angle sum.
    pub fn solve(
        &mut self,
        circles: &Circles,
        options: &RadiiOptions,
        report: &impl Fn(usize, &Record) -> bool,
    ) -> Result<Outcome, NumericError> {
        let mut outcome = Outcome::empty(Status::IterationLimit);
        let mut gradient = self.gradient(circles, &self.rho);
        let mut residual = max_abs(&gradient);
        let mut hessian = self.hessian(circles)?;
        let mut cholesky = Cholesky::analyse(hessian.pattern(), 1)?;
        while residual > options.tolerance && outcome.iterations < options.max_iterations {
            if outcome.iterations > 0 {
                hessian = self.hessian(circles)?;
            }
            outcome.factorisations += 1;
            if cholesky.refactor(&hessian).is_err() {
                outcome.status = Status::NumericalBreakdown;
                return Ok(outcome);
            }
            let mut step: Vec<f64> = gradient.iter().map(|g| -g).collect();
            cholesky.solve(&mut step);
            let fraction = self.line_search(circles, &gradient, &step);
            self.rho = self.moved(&step, fraction);
            gradient = self.gradient(circles, &self.rho);
            let before = std::mem::replace(&mut residual, max_abs(&gradient));
            outcome.iterations += 1;
            let record = record(residual, fraction * max_abs(&step), fraction);
            outcome.history.push(record);
            if residual.is_nan() || (residual >= before && before < STALL) {
                outcome.status = Status::Stalled;
                break;
            }
            if !report(outcome.iterations, &record) {
                outcome.status = Status::Cancelled;
                return Ok(outcome);
            }
        }
        if residual <= options.tolerance {
            outcome.status = Status::Converged;
        }
        Ok(outcome)
    }

    fn moved(&self, step: &[f64], fraction: f64) -> Vec<f64> {
        let shift = |u: &Option<u32>| u.map_or(0.0, |i| fraction * step[i as usize]);
        self.rho
            .iter()
            .zip(&self.unknown)
            .map(|(r, u)| r + shift(u))
            .collect()
    }

    /// Derivative of the energy: target angle minus angle sum of each unknown node.
    fn gradient(&self, circles: &Circles, rho: &[f64]) -> Vec<f64> {
        let mut gradient = vec![0.0; self.n_unknowns];
        for (unknown, target) in self.unknown.iter().zip(&self.target_angle) {
            if let Some(i) = unknown {
                gradient[*i as usize] = *target;
            }
        }
        for (j, k) in circles.pairs() {
            for (a, b) in [(j, k), (k, j)] {
                if let Some(i) = self.unknown[a] {
                    gradient[i as usize] -= 2.0 * (rho[b] - rho[a]).exp().atan();
                }
            }
        }
        gradient
    }

    /// Second derivative: a graph Laplacian with the weights `1 / cosh(rho_j - rho_k)`.
    fn hessian(&self, circles: &Circles) -> Result<SymmetricMatrix, NumericError> {
        let mut triplets = Vec::with_capacity(3 * circles.n_pairs());
        for (j, k) in circles.pairs() {
            let weight = || 1.0 / (self.rho[j] - self.rho[k]).cosh();
            match (self.unknown[j], self.unknown[k]) {
                (Some(a), Some(b)) => {
                    let w = weight();
                    triplets.extend([(a, a, w), (b, b, w), (a.max(b), a.min(b), -w)]);
                }
                (Some(a), None) | (None, Some(a)) => triplets.push((a, a, weight())),
                (None, None) => {}
            }
        }
        SymmetricMatrix::from_triplets(self.n_unknowns, triplets.into_iter())
    }

    /// Fraction of the step where the slope of the convex energy has fallen enough; it needs no
    /// energy.
    fn line_search(&self, circles: &Circles, gradient: &[f64], step: &[f64]) -> f64 {
        let slope = |t: f64| dot(&self.gradient(circles, &self.moved(step, t)), step);
        let goal = SLOPE_FRACTION * dot(gradient, step).abs();
        let (mut low, mut high, mut t) = (0.0, f64::INFINITY, 1.0);
        for _ in 0..LINE_SEARCH_STEPS {
            let here = slope(t);
            if here.abs() <= goal {
                break;
            }
            if here < 0.0 {
                low = t;
            } else {
                high = t;
            }
            t = if high.is_finite() {
                0.5 * (low + high)
            } else {
                2.0 * t
            };
        }
        t
    }
}

fn record(residual: f64, step: f64, fraction: f64) -> Record {
    Record {
        phase: 0.0,
        energy: f64::NAN,
        residual,
        step,
        fraction,
        damping: 0.0,
    }
}

/// Log of the radius that suits a node amid regular ones.
fn start(degree: usize) -> f64 {
    -0.5 * (std::f64::consts::PI / degree.max(3) as f64).tan().ln()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
