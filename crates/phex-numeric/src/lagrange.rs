//! Newton's method on the Lagrangian: minimise under equations, to the last digits, from a point
//! that nearly meets them.
//!
//! With `L(x) = E(x) + l^T c(x) + rho/2 |c(x)|^2` (augmented Lagrangian) and `K` its Hessian at
//! `x`, each iteration solves
//!
//! ```text
//! K d + J^T y = -grad L,   J d = -c          so   (J K^-1 J^T) y = c - J K^-1 grad L
//! ```
//!
//! adds `y` to the multipliers `l` and moves along `d`, which is a direction of descent for `L`
//! with the new multipliers however roughly `y` is known. On the constraints the dual matrix is
//! about `1 / rho`, so that a few conjugate gradients, each with one solve by the factorisation of
//! `K`, do.
//!
//! | symbol | here |
//! |---|---|
//! | `L`, `grad L`, `c`, `K` | [`LagrangeProblem::merit`], [`LagrangeProblem::linearise`] |
//! | `J d`, `J^T y` | [`LagrangeProblem::product`], [`LagrangeProblem::spread`] |
//! | `l` | [`LagrangeProblem::add_multipliers`] |
//!
//! `K` may be indefinite away from a minimum; it is then shifted (`K + mu I`) until it has a
//! factorisation, and as well where a collision cuts most of the step. Near a minimum `mu` fades
//! and convergence is that of Newton's method.
//!
//! Guaranteed: every iterate is admissible if the first one is. Fails (`Stalled`) where no shift
//! gives a step that lowers `L`. Sources: Powell (1969) and Hestenes (1969) for the method of
//! multipliers, Nocedal and Wright, "Numerical optimization" (2006), chapters 17 and 18.

use crate::conjugate_gradients::{add_scaled, dot};
use crate::outcome::{Outcome, Record, Status};
use crate::{Cholesky, SymmetricMatrix};
use std::ops::ControlFlow;

/// A function to be minimised under equations, which keeps multipliers.
pub trait LagrangeProblem {
    /// `L` at `x`; infinite if `x` is not admissible.
    fn merit(&mut self, x: &[f64]) -> f64;
    /// Gradient and Hessian of `L`, and the values `c`, at `x`; keeps `J` for what follows.
    fn linearise(
        &mut self,
        x: &[f64],
        gradient: &mut [f64],
        values: &mut [f64],
        hessian: &mut SymmetricMatrix,
    );
    /// `values = J d`.
    fn product(&self, d: &[f64], values: &mut [f64]);
    /// `d = J^T y`.
    fn spread(&self, y: &[f64], d: &mut [f64]);
    /// Adds to the multipliers, with the `J` of the last linearisation.
    fn add_multipliers(&mut self, change: &[f64]);
    /// Largest fraction `t` in `(0, 1]` of `step` that keeps clear of collisions.
    fn step_bound(&mut self, x: &[f64], step: &[f64]) -> f64;
    /// Length of a step in the unit of the problem.
    fn step_length(&self, step: &[f64]) -> f64;
    /// Size of `c` at the last point whose merit was asked for, in the unit of the problem.
    fn residual(&self) -> f64;
    /// Brings a point to which a step has led back to where unknowns are held (on a curve, say);
    /// moves nothing by default.
    fn retract(&self, _x: &mut [f64]) {}
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LagrangeOptions {
    /// Iterations at the most.
    pub max_iterations: usize,
    /// Length of a step that counts as none.
    pub step_tolerance: f64,
    /// Number that [`Record::phase`] is set to.
    pub phase: f64,
}

/// Conjugate gradients on the dual: how many at the most, and the share of the defect that may
/// remain.
const DUAL_ITERATIONS: usize = 12;
const DUAL_ACCURACY: f64 = 1e-3;
/// Shifts: the first, the last, and factors after a step that failed, one that was cut short, and
/// one that was taken whole.
const FIRST_SHIFT: f64 = 1e-3;
const LAST_SHIFT: f64 = 10.0;
const RISE: f64 = 4.0;
const RISE_SHORT: f64 = 2.0;
const FALL: f64 = 0.25;
/// Shift below which there is none.
const NO_SHIFT: f64 = 1e-6;
/// Fraction of a step below which collisions have it thrown away, and below which the line search
/// counts as having cut it short.
const SHORT: f64 = 0.2;
const CUT_SHORT: f64 = 0.3;
const HALVINGS: usize = 8;
const ARMIJO: f64 = 1e-4;
/// Relative rounding of the merit.
const ROUNDING: f64 = 1e-13;

/// Memory of [`minimise`](Self::minimise) beside a factorisation and a matrix that are lent.
#[derive(Debug)]
pub struct LagrangeNewton<'a> {
    cholesky: &'a mut Cholesky,
    hessian: &'a mut SymmetricMatrix,
    gradient: Vec<f64>,
    values: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
    shift: f64,
}

struct LagrangeStep {
    merit: f64,
    fraction: f64,
    shift: f64,
}

impl<'a> LagrangeNewton<'a> {
    /// Takes an analysed factorisation, a matrix on its pattern, and the number of equations.
    pub fn new(
        (cholesky, hessian): (&'a mut Cholesky, &'a mut SymmetricMatrix),
        n_equations: usize,
    ) -> Self {
        let n = hessian.dimension();
        Self {
            cholesky,
            hessian,
            gradient: vec![0.0; n],
            values: vec![0.0; n_equations],
            step: vec![0.0; n],
            trial: vec![0.0; n],
            shift: 0.0,
        }
    }

    /// Minimises from `x`, in place. `observe` hears of every iteration and may break off.
    pub fn minimise(
        &mut self,
        problem: &mut impl LagrangeProblem,
        x: &mut [f64],
        options: &LagrangeOptions,
        mut observe: impl FnMut(&Record) -> ControlFlow<()>,
    ) -> Outcome {
        let factorised = self.cholesky.factorisations();
        let mut outcome = Outcome::empty(Status::IterationLimit);
        self.shift = 0.0;
        if !problem.merit(x).is_finite() {
            outcome.status = Status::Stalled;
            return outcome;
        }
        for _ in 0..options.max_iterations {
            problem.linearise(x, &mut self.gradient, &mut self.values, self.hessian);
            let Some(accepted) = self.search(problem, x) else {
                outcome.status = Status::Stalled;
                break;
            };
            add_scaled(x, accepted.fraction, &self.step);
            problem.retract(x);
            let record = Record {
                phase: options.phase,
                energy: accepted.merit,
                residual: problem.residual(),
                step: accepted.fraction * problem.step_length(&self.step),
                fraction: accepted.fraction,
                damping: accepted.shift,
            };
            outcome.history.push(record);
            if observe(&record).is_break() {
                outcome.status = Status::Cancelled;
                break;
            }
            if accepted.fraction == 1.0 && record.step <= options.step_tolerance {
                outcome.status = Status::Converged;
                break;
            }
        }
        outcome.iterations = outcome.history.len();
        outcome.factorisations = self.cholesky.factorisations() - factorised;
        outcome
    }

    /// Finds a shift and a fraction of the step that lower the merit.
    fn search(&mut self, problem: &mut impl LagrangeProblem, x: &[f64]) -> Option<LagrangeStep> {
        while self.shift <= LAST_SHIFT {
            let shift = self.shift;
            if self.factorise(shift) && self.solve(problem) {
                let bound = problem.step_bound(x, &self.step);
                let found = (bound >= SHORT).then(|| self.line_search(problem, x, bound));
                if let Some((fraction, merit)) = found.flatten() {
                    self.adapt(fraction);
                    return Some(LagrangeStep {
                        merit,
                        fraction,
                        shift,
                    });
                }
            }
            self.shift = (RISE * self.shift).max(FIRST_SHIFT);
        }
        None
    }

    /// The shift after a step of which a fraction was taken.
    fn adapt(&mut self, fraction: f64) {
        if fraction == 1.0 {
            self.shift *= FALL;
        } else if fraction < CUT_SHORT {
            self.shift = (RISE_SHORT * self.shift).max(FIRST_SHIFT);
        }
        if self.shift < NO_SHIFT {
            self.shift = 0.0;
        }
    }

    fn factorise(&mut self, shift: f64) -> bool {
        self.cholesky.refactor_shifted(self.hessian, shift).is_ok()
    }

    /// Step and change of the multipliers, which the gradient takes up.
    fn solve(&mut self, problem: &mut impl LagrangeProblem) -> bool {
        let (n, m) = (self.step.len(), self.values.len());
        let negated = self.gradient.iter().map(|g| -g);
        self.step.iter_mut().zip(negated).for_each(|(d, g)| *d = g);
        self.cholesky.solve(&mut self.step);
        let mut defect = vec![0.0; m];
        problem.product(&self.step, &mut defect);
        add_scaled(&mut defect, 1.0, &self.values);
        let (mut direction, mut change) = (defect.clone(), vec![0.0; m]);
        let (mut product, mut response) = (vec![0.0; m], vec![0.0; n]);
        let mut square = dot(&defect, &defect);
        let goal = square * DUAL_ACCURACY * DUAL_ACCURACY;
        for _ in 0..DUAL_ITERATIONS {
            if square <= goal {
                break;
            }
            problem.spread(&direction, &mut response);
            self.cholesky.solve(&mut response);
            problem.product(&response, &mut product);
            let curvature = dot(&direction, &product);
            if curvature.is_nan() || curvature <= 0.0 {
                break;
            }
            let along = square / curvature;
            add_scaled(&mut change, along, &direction);
            add_scaled(&mut self.step, -along, &response);
            add_scaled(&mut defect, -along, &product);
            let next = dot(&defect, &defect);
            let ratio = next / square;
            square = next;
            let pairs = direction.iter_mut().zip(&defect);
            pairs.for_each(|(p, r)| *p = r + ratio * *p);
        }
        problem.add_multipliers(&change);
        problem.spread(&change, &mut response);
        add_scaled(&mut self.gradient, 1.0, &response);
        self.step.iter().all(|d| d.is_finite())
    }

    fn line_search(
        &mut self,
        problem: &mut impl LagrangeProblem,
        x: &[f64],
        bound: f64,
    ) -> Option<(f64, f64)> {
        let merit = problem.merit(x);
        let slope = dot(&self.gradient, &self.step);
        let mut fraction = bound;
        for _ in 0..HALVINGS {
            self.trial.copy_from_slice(x);
            add_scaled(&mut self.trial, fraction, &self.step);
            problem.retract(&mut self.trial);
            let trial = problem.merit(&self.trial);
            if trial <= merit + ARMIJO * fraction * slope + ROUNDING * merit.abs() {
                return Some((fraction, trial));
            }
            fraction *= 0.5;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lowest point of `x^T diag(a) x / 2 + b x` on the unit sphere, with `x_2 > floor`.
    struct OnSphere {
        a: [f64; 3],
        b: [f64; 3],
        floor: f64,
        weight: f64,
        multiplier: f64,
        at: [f64; 3],
        last: f64,
    }

    impl OnSphere {
        fn new(a: [f64; 3], b: [f64; 3], floor: f64) -> Self {
            Self {
                a,
                b,
                floor,
                weight: 100.0,
                multiplier: 0.0,
                at: [0.0; 3],
                last: f64::NAN,
            }
        }

        fn slope(&self, i: usize, x: &[f64]) -> f64 {
            self.a[i] * x[i] + self.b[i]
        }
    }

    impl LagrangeProblem for OnSphere {
        fn merit(&mut self, x: &[f64]) -> f64 {
            self.last = 0.5 * (dot(x, x) - 1.0);
            let energy = |i: usize| (0.5 * self.a[i] * x[i] + self.b[i]) * x[i];
            let sum: f64 = (0..3).map(energy).sum();
            match x[2] > self.floor {
                true => sum + (self.multiplier + 0.5 * self.weight * self.last) * self.last,
                false => f64::INFINITY,
            }
        }
        fn linearise(
            &mut self,
            x: &[f64],
            gradient: &mut [f64],
            values: &mut [f64],
            hessian: &mut SymmetricMatrix,
        ) {
            self.at.copy_from_slice(x);
            values[0] = 0.5 * (dot(x, x) - 1.0);
            let pull = self.multiplier + self.weight * values[0];
            let mut at = 0;
            for j in 0..3 {
                gradient[j] = self.slope(j, x) + pull * x[j];
                for i in j..3 {
                    let diagonal = if i == j { self.a[i] + pull } else { 0.0 };
                    hessian.values_mut()[at] = diagonal + self.weight * x[i] * x[j];
                    at += 1;
                }
            }
        }
        fn product(&self, d: &[f64], values: &mut [f64]) {
            values[0] = dot(&self.at, d);
        }
        fn spread(&self, y: &[f64], d: &mut [f64]) {
            d.iter_mut().zip(self.at).for_each(|(d, x)| *d = x * y[0]);
        }
        fn add_multipliers(&mut self, change: &[f64]) {
            self.multiplier += change[0];
        }
        fn step_bound(&mut self, _x: &[f64], _step: &[f64]) -> f64 {
            1.0
        }
        fn step_length(&self, step: &[f64]) -> f64 {
            dot(step, step).sqrt()
        }
        fn residual(&self) -> f64 {
            self.last.abs()
        }
    }

    fn run(
        problem: &mut OnSphere,
        max_iterations: usize,
        stop_after: usize,
    ) -> (Outcome, Vec<f64>) {
        let dense = (0..3).flat_map(|j| (j..3).map(move |i| (i, j, 1.0)));
        let mut hessian = SymmetricMatrix::from_triplets(3, dense).unwrap();
        let mut cholesky = Cholesky::analyse(hessian.pattern(), 1).unwrap();
        let mut newton = LagrangeNewton::new((&mut cholesky, &mut hessian), 1);
        let mut x = vec![0.8, 0.0, 0.6];
        let options = LagrangeOptions {
            max_iterations,
            step_tolerance: 1e-12,
            phase: 0.0,
        };
        let mut seen = 0;
        let observe = |_: &Record| {
            seen += 1;
            match seen == stop_after {
                true => ControlFlow::Break(()),
                false => ControlFlow::Continue(()),
            }
        };
        let outcome = newton.minimise(problem, &mut x, &options, observe);
        (outcome, x)
    }

    #[test]
    fn reaches_the_minimum_to_rounding_and_ever_faster() {
        let mut problem = OnSphere::new([1.0, 2.0, -3.0], [0.1, 0.2, 0.3], 0.0);
        let (outcome, x) = run(&mut problem, 40, 0);
        assert_eq!(outcome.status, Status::Converged);
        assert!((dot(&x, &x) - 1.0).abs() < 1e-14);
        // Stationary on the sphere: the slope is along x, with the multiplier as the factor.
        for (i, x_i) in x.iter().enumerate() {
            let defect = problem.slope(i, &x) + problem.multiplier * x_i;
            assert!(defect.abs() < 1e-11, "{defect:e}");
        }
        let steps: Vec<f64> = outcome.history.iter().map(|r| r.step).collect();
        let fast = |w: &[f64]| w[0] > 1e-2 || w[1] < 5.0 * w[0].powf(1.5) + 1e-13;
        assert!(steps.windows(2).all(fast), "{steps:?}");
    }

    #[test]
    fn the_guard_is_never_crossed_and_limits_are_told() {
        // The minimum lies below the floor.
        let mut problem = OnSphere::new([1.0, 1.0, 1.0], [0.0, 0.0, 5.0], 0.2);
        let (outcome, x) = run(&mut problem, 30, 0);
        assert!(x[2] > 0.2, "{x:?} {:?}", outcome.status);
        assert_ne!(outcome.status, Status::Converged);
        let mut problem = OnSphere::new([1.0, 2.0, -3.0], [0.1, 0.2, 0.3], 0.0);
        assert_eq!(run(&mut problem, 2, 0).0.status, Status::IterationLimit);
        let (outcome, _) = run(&mut problem, 40, 1);
        assert_eq!((outcome.status, outcome.iterations), (Status::Cancelled, 1));
    }

    #[test]
    fn an_inadmissible_start_is_left_alone() {
        let mut problem = OnSphere::new([1.0; 3], [0.0; 3], 0.7);
        let (outcome, x) = run(&mut problem, 10, 0);
        assert_eq!((outcome.status, x), (Status::Stalled, vec![0.8, 0.0, 0.6]));
    }
}
