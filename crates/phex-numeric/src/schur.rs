//! Sequential quadratic programming on the Schur complement: minimise under equations, from a start
//! that is nearly there.
//!
//! Each iteration minimises `d^T H d / 2 + g^T d` under `J d = -c`, where `W = H^-1` is cheap to
//! apply (block diagonal):
//!
//! ```text
//! (J W J^T) y = c + J d_0,   d = d_0 - W J^T y,   d_0 = -W g
//! ```
//!
//! The multipliers `y` are held by a proximal term that fades (method of multipliers), and only
//! their change is solved for. The matrix changes little from one iteration to the next, so that a
//! factorisation serves several of them as the preconditioner of conjugate gradients
//! ([`LaggedCholesky`]).
//!
//! | symbol | here |
//! |---|---|
//! | `c`, `J W J^T`, `d_0` | [`SchurProblem::linearise`] |
//! | `J d`, `W J^T y` | [`SchurProblem::product`], [`SchurProblem::spread`] |
//!
//! Guaranteed: every iterate is admissible if the first one is. There is no merit function: where
//! neither residual nor step falls, or a step is blocked, it ends as `Stalled`, and the caller
//! takes another way.

use crate::conjugate_gradients::{add_scaled, dot};
use crate::outcome::{Outcome, Record, Status};
use crate::{
    Cholesky, ConjugateGradientOptions, SymmetricMatrix, preconditioned_conjugate_gradients,
};
use std::ops::ControlFlow;

/// A function to be minimised under equations.
pub trait SchurProblem {
    /// Values `c`, free step `d_0 = -W g` and `J W J^T` at `x`; keeps `J` and `W` for what follows.
    fn linearise(
        &mut self,
        x: &[f64],
        values: &mut [f64],
        free: &mut [f64],
        schur: &mut SymmetricMatrix,
    );
    /// `values = J d`.
    fn product(&self, d: &[f64], values: &mut [f64]);
    /// `d = W J^T y`.
    fn spread(&self, y: &[f64], d: &mut [f64]);
    /// Largest fraction `t` in `(0, 1]` of `step` that may be tried.
    fn step_bound(&mut self, step: &[f64]) -> f64;
    /// Residual at `x` if `x` may be visited, otherwise `None`.
    fn admissible(&mut self, x: &[f64]) -> Option<f64>;
    /// Length of a step in the unit of the problem.
    fn step_length(&self, step: &[f64]) -> f64;
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SchurOptions {
    /// Iterations at the most.
    pub max_iterations: usize,
    /// Residual that counts as none.
    pub tolerance: f64,
    /// Length of a step that counts as none.
    pub step_tolerance: f64,
    /// Number that [`Record::phase`] is set to.
    pub phase: f64,
}

/// Solves with a slowly changing matrix: the last factorisation is the preconditioner until that
/// takes too long.
#[derive(Debug)]
pub struct LaggedCholesky {
    cholesky: Cholesky,
    usable: bool,
}

/// Relative residual to which equations are solved; Newton's next step takes care of the rest.
const ACCURACY: f64 = 1e-4;
/// Iterations after which a new factorisation is cheaper.
const PATIENCE: usize = 6;
/// Shift over the mean of the diagonal, so that dependent equations factorise, and its growth.
const SHIFTS: [f64; 4] = [1e-14, 1e-12, 1e-10, 1e-8];

impl LaggedCholesky {
    /// Takes an analysed factorisation.
    pub fn new(cholesky: Cholesky) -> Self {
        Self {
            cholesky,
            usable: false,
        }
    }

    /// Number of factorisations so far.
    pub fn factorisations(&self) -> usize {
        self.cholesky.factorisations()
    }

    /// Forgets the last factorisation, which belongs to another start.
    pub fn forget(&mut self) {
        self.usable = false;
    }

    /// Solves `A x = b`; `x` is overwritten. False if `A` can't be factorised or the solution is
    /// not finite.
    pub fn solve(&mut self, matrix: &SymmetricMatrix, b: &[f64], x: &mut [f64]) -> bool {
        if self.usable && self.iterate(matrix, b, x) {
            return true;
        }
        self.factorise(matrix) && {
            self.iterate(matrix, b, x);
            x.iter().all(|x| x.is_finite())
        }
    }

    fn iterate(&self, matrix: &SymmetricMatrix, b: &[f64], x: &mut [f64]) -> bool {
        let options = ConjugateGradientOptions {
            tolerance: ACCURACY,
            max_iterations: PATIENCE,
        };
        x.fill(0.0);
        let apply = |p: &[f64], y: &mut [f64]| matrix.mul(p, y);
        let precondition = |r: &[f64], z: &mut [f64]| self.cholesky.precondition(r, z);
        let result = preconditioned_conjugate_gradients(apply, precondition, b, x, &options);
        result.status == Status::Converged
    }

    fn factorise(&mut self, matrix: &SymmetricMatrix) -> bool {
        let mean = matrix.diagonal().sum::<f64>() / matrix.dimension().max(1) as f64;
        let mut tries = SHIFTS.iter().map(|shift| shift * mean);
        self.usable = tries.any(|shift| self.cholesky.refactor_shifted(matrix, shift).is_ok());
        self.usable
    }
}

/// Memory and factorisation of the iteration, kept between runs on the same pattern.
#[derive(Debug)]
pub struct SchurSqp {
    solver: LaggedCholesky,
    schur: SymmetricMatrix,
    values: Vec<f64>,
    multiplier: Vec<f64>,
}

/// Weight that holds the multipliers where they are, over the mean of the diagonal, and its factor
/// from one iteration to the next: equations that nearly depend on each other would else ask for
/// long steps at once.
const PROXIMITY: f64 = 1e-3;
const FADING: f64 = 0.03;

/// Iterations in a row without progress that end it.
const IDLE: usize = 2;
const HALVINGS: usize = 3;
/// Fraction of a step below which the start was not near.
const SHORT: f64 = 0.1;

impl SchurSqp {
    /// Takes an analysed factorisation and a matrix on its pattern.
    pub fn new(cholesky: Cholesky, schur: SymmetricMatrix) -> Self {
        let n = schur.dimension();
        Self {
            solver: LaggedCholesky::new(cholesky),
            schur,
            values: vec![0.0; n],
            multiplier: vec![0.0; n],
        }
    }

    /// Gives factorisation and matrix back.
    pub fn into_parts(self) -> (Cholesky, SymmetricMatrix) {
        (self.solver.cholesky, self.schur)
    }

    /// Minimises from `x`, in place. `observe` hears of every iteration and may break off.
    pub fn minimise(
        &mut self,
        problem: &mut impl SchurProblem,
        x: &mut [f64],
        options: &SchurOptions,
        mut observe: impl FnMut(&Record) -> ControlFlow<()>,
    ) -> Outcome {
        let factorised = self.solver.factorisations();
        self.solver.forget();
        self.multiplier.fill(0.0);
        let mut outcome = Outcome::empty(Status::IterationLimit);
        let (mut step, mut trial) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        let mut best = [f64::INFINITY; 2];
        let mut idle = 0;
        let mut proximity = PROXIMITY;
        for _ in 0..options.max_iterations {
            let solved = self.solve(problem, x, proximity, &mut step);
            proximity *= FADING;
            if !solved {
                outcome.status = Status::NumericalBreakdown;
                break;
            }
            let reached = admitted(problem, x, &step, &mut trial);
            let Some((fraction, residual)) = reached.filter(|(t, _)| *t >= SHORT) else {
                outcome.status = Status::Stalled;
                break;
            };
            x.copy_from_slice(&trial);
            let length = problem.step_length(&step);
            let record = Record {
                phase: options.phase,
                energy: f64::NAN,
                residual,
                step: fraction * length,
                fraction,
                damping: 0.0,
            };
            outcome.history.push(record);
            if observe(&record).is_break() {
                outcome.status = Status::Cancelled;
                break;
            }
            if residual <= options.tolerance && length <= options.step_tolerance {
                outcome.status = Status::Converged;
                break;
            }
            let progress = residual < 0.5 * best[0] || length < 0.5 * best[1];
            idle = if progress { 0 } else { idle + 1 };
            best = [best[0].min(residual), best[1].min(length)];
            if idle >= IDLE {
                outcome.status = Status::Stalled;
                break;
            }
        }
        outcome.iterations = outcome.history.len();
        outcome.factorisations = self.solver.factorisations() - factorised;
        outcome
    }

    /// Finds the step. The multipliers hardly change from one iteration to the next, so only their
    /// change is solved for: at the end it is small, and with it the error of the solution.
    fn solve(
        &mut self,
        problem: &mut impl SchurProblem,
        x: &[f64],
        proximity: f64,
        step: &mut [f64],
    ) -> bool {
        problem.linearise(x, &mut self.values, step, &mut self.schur);
        let n = self.values.len();
        let (mut defect, mut change) = (vec![0.0; n], vec![0.0; n]);
        self.schur.mul(&self.multiplier, &mut defect);
        problem.product(step, &mut change);
        let right = self.values.iter().zip(&change).map(|(c, d)| c + d);
        defect.iter_mut().zip(right).for_each(|(d, b)| *d = b - *d);
        let mean = self.schur.diagonal().sum::<f64>() / n.max(1) as f64;
        self.schur.shift_diagonal(proximity * mean);
        if dot(&defect, &defect) > 0.0 {
            if !self.solver.solve(&self.schur, &defect, &mut change) {
                return false;
            }
            add_scaled(&mut self.multiplier, 1.0, &change);
        }
        let mut back = vec![0.0; step.len()];
        problem.spread(&self.multiplier, &mut back);
        add_scaled(step, -1.0, &back);
        step.iter().all(|d| d.is_finite())
    }
}

/// First fraction of a step that is admissible, and the residual there; `trial` holds the point.
fn admitted(
    problem: &mut impl SchurProblem,
    x: &[f64],
    step: &[f64],
    trial: &mut [f64],
) -> Option<(f64, f64)> {
    let mut fraction = problem.step_bound(step);
    for _ in 0..HALVINGS {
        trial.copy_from_slice(x);
        add_scaled(trial, fraction, step);
        if let Some(residual) = problem.admissible(trial) {
            return Some((fraction, residual));
        }
        fraction *= 0.5;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The point of the unit circle nearest to `goal` in the metric `diag(weight)`; only the strip
    /// `x_1 > floor` may be visited.
    struct Circle {
        goal: [f64; 2],
        weight: [f64; 2],
        floor: f64,
        gradient: [f64; 2],
    }

    impl SchurProblem for Circle {
        fn linearise(
            &mut self,
            x: &[f64],
            values: &mut [f64],
            free: &mut [f64],
            schur: &mut SymmetricMatrix,
        ) {
            values[0] = 0.5 * (dot(x, x) - 1.0);
            self.gradient = [x[0], x[1]];
            for (i, free) in free.iter_mut().enumerate() {
                *free = self.goal[i] - x[i];
            }
            let sum = (0..2).map(|i| x[i] * x[i] / self.weight[i]).sum();
            schur.values_mut()[0] = sum;
        }
        fn product(&self, d: &[f64], values: &mut [f64]) {
            values[0] = dot(&self.gradient, d);
        }
        fn spread(&self, y: &[f64], d: &mut [f64]) {
            for (i, d) in d.iter_mut().enumerate() {
                *d = self.gradient[i] / self.weight[i] * y[0];
            }
        }
        fn step_bound(&mut self, _step: &[f64]) -> f64 {
            1.0
        }
        fn admissible(&mut self, x: &[f64]) -> Option<f64> {
            (x[1] > self.floor).then(|| (dot(x, x).sqrt() - 1.0).abs())
        }
        fn step_length(&self, step: &[f64]) -> f64 {
            dot(step, step).sqrt()
        }
    }

    fn run(goal: [f64; 2], weight: [f64; 2], floor: f64, stop_after: usize) -> (Outcome, [f64; 2]) {
        let schur = SymmetricMatrix::from_triplets(1, [(0, 0, 1.0)].into_iter()).unwrap();
        let cholesky = Cholesky::analyse(schur.pattern(), 1).unwrap();
        let mut problem = Circle {
            goal,
            weight,
            floor,
            gradient: [0.0; 2],
        };
        let mut x = [0.9, 0.5];
        let options = SchurOptions {
            max_iterations: 60,
            tolerance: 1e-14,
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
        let outcome =
            SchurSqp::new(cholesky, schur).minimise(&mut problem, &mut x, &options, observe);
        (outcome, x)
    }

    #[test]
    fn finds_the_nearest_point_of_a_circle() {
        let (outcome, x) = run([1.1, 0.66], [1.0, 1.0], 0.0, 0);
        assert_eq!(outcome.status, Status::Converged);
        let expected = 0.66f64.atan2(1.1);
        assert!((x[1].atan2(x[0]) - expected).abs() < 1e-11, "{x:?}");
        assert_eq!(outcome.factorisations, 1);
        // Stationary in the metric: the weighted way to the goal is along the normal.
        let (outcome, x) = run([1.1, 0.66], [1.0, 4.0], 0.0, 0);
        assert_eq!(outcome.status, Status::Converged);
        let pull = [1.1 - x[0], 4.0 * (0.66 - x[1])];
        assert!((pull[0] * x[1] - pull[1] * x[0]).abs() < 1e-11, "{x:?}");
    }

    #[test]
    fn what_is_not_admissible_is_not_visited() {
        let (outcome, x) = run([1.1, -0.66], [1.0, 1.0], 0.4, 0);
        assert_eq!(outcome.status, Status::Stalled);
        assert!(x[1] > 0.4, "{x:?}");
    }

    #[test]
    fn cancelling_is_told() {
        let (outcome, _) = run([1.1, 0.66], [1.0, 1.0], 0.0, 2);
        assert_eq!((outcome.status, outcome.iterations), (Status::Cancelled, 2));
    }

    #[test]
    fn a_factorisation_is_made_anew_when_it_no_longer_helps() {
        let n = 200;
        let matrix = |stiff: f64| {
            let springs = (0..n as u32 - 1).flat_map(|k| {
                let s = stiff.powf(f64::from(k % 17) / 16.0);
                [(k, k, s), (k + 1, k + 1, s), (k + 1, k, -s)]
            });
            SymmetricMatrix::from_triplets(n, springs.chain([(0, 0, 1.0)])).unwrap()
        };
        let b: Vec<f64> = (0..n).map(|k| (k as f64).sin()).collect();
        let first = matrix(1.0);
        let mut solver = LaggedCholesky::new(Cholesky::analyse(first.pattern(), 1).unwrap());
        for (stiff, expected) in [(1.0, 1), (1.001, 1), (1e4, 2), (1e4, 2)] {
            let (a, mut x) = (matrix(stiff), vec![0.0; n]);
            assert!(solver.solve(&a, &b, &mut x));
            let mut product = vec![0.0; n];
            a.mul(&x, &mut product);
            let error: Vec<f64> = product.iter().zip(&b).map(|(p, b)| p - b).collect();
            assert!(dot(&error, &error).sqrt() <= 1.1 * ACCURACY * dot(&b, &b).sqrt());
            assert_eq!(solver.factorisations(), expected, "{stiff}");
        }
    }
}
