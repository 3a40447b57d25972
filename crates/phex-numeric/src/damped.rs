//! Damped Gauss-Newton (Levenberg-Marquardt) descent whose damping follows the collision step.
//!
//! Each iteration solves `(H + mu I) d = -g` and moves by `t d`, where `t` starts at the largest
//! fraction that keeps the configuration free of collisions and is halved until the energy falls
//! (Armijo).
//!
//! | symbol | here | meaning |
//! |---|---|---|
//! | `E` | [`DampedProblem::energy`] | infinite where not admissible |
//! | `g`, `H` | [`DampedProblem::linearise`] | gradient, positive semidefinite Hessian approximation |
//! | `mu` | [`Damping`] | kept between runs, in the unit of `H` |
//! | `t` | [`DampedProblem::step_bound`] | collision-bounded fraction of the step |
//!
//! The rule, measured on collision-laden problems: below `t = 0.2` the step is thrown away and
//! solved again with `5 mu` (at least 1e-3); below `0.5` it is taken, but `mu` triples; above `0.8`
//! `mu` is halved. Without it, weakly determined unknowns propose long steps, one collision cuts
//! the *whole* step, and the iteration creeps.
//!
//! Guaranteed: every iterate is admissible if the first one is, and the energy never rises.
//! Fails (`Stalled`) where no damping gives a step that lowers the energy.

use crate::conjugate_gradients::{add_scaled, dot};
use crate::outcome::{Outcome, Record, Status};
use crate::{Cholesky, SymmetricMatrix};
use std::ops::ControlFlow;

/// A function to be minimised within an admissible region.
pub trait DampedProblem {
    /// Energy at `x`; infinite if `x` is not admissible.
    fn energy(&mut self, x: &[f64]) -> f64;
    /// Gradient and positive semidefinite Hessian approximation at `x`. Mostly `x` is the point
    /// whose energy was asked for last, so that what was computed there can be used again.
    fn linearise(&mut self, x: &[f64], gradient: &mut [f64], hessian: &mut SymmetricMatrix);
    /// Largest fraction `t` in `(0, 1]` of `step` that keeps clear of collisions.
    fn step_bound(&mut self, x: &[f64], step: &[f64]) -> f64;
    /// Length of a step in the unit of the problem.
    fn step_length(&self, step: &[f64]) -> f64;
    /// What is driven to zero, at the last point whose energy was asked for.
    fn residual(&self) -> f64;
    /// Brings a point to which a step has led back to where unknowns are held (on a curve, say);
    /// moves nothing by default.
    fn retract(&self, _x: &mut [f64]) {}
}

/// When to stop, and how to damp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DampedOptions {
    /// Iterations at the most.
    pub max_iterations: usize,
    /// Relative decrease of the energy that counts as none.
    pub energy_tolerance: f64,
    /// Length of a step that counts as none.
    pub step_tolerance: f64,
    /// Number that [`Record::phase`] is set to.
    pub phase: f64,
}

/// Damping `mu`, handed on from run to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping(pub f64);

impl Default for Damping {
    fn default() -> Self {
        Self(1e-6)
    }
}

impl Damping {
    const MOST: f64 = 10.0;

    fn after_thrown_step(&mut self) {
        self.0 = (5.0 * self.0).max(1e-3);
    }

    fn after_failed_search(&mut self) {
        self.0 = (30.0 * self.0).max(1e-6);
    }

    fn after_step(&mut self, fraction: f64) {
        if fraction > 0.8 {
            self.0 = (0.5 * self.0).max(1e-8);
        } else if fraction <= 0.5 {
            self.0 = (3.0 * self.0).max(1e-3);
        }
    }
}

const TRIES: usize = 6;
const THROWN_STEPS: usize = 3;
const HALVINGS: usize = 8;
const ARMIJO: f64 = 1e-4;
const SHORT: f64 = 0.2;

/// Memory and factorisation of [`minimise`](Self::minimise), kept between runs on the same pattern.
#[derive(Debug)]
pub struct DampedSolver {
    cholesky: Cholesky,
    hessian: SymmetricMatrix,
    gradient: Vec<f64>,
    step: Vec<f64>,
    trial: Vec<f64>,
}

struct DampedStep {
    energy: f64,
    fraction: f64,
    damping: f64,
}

impl DampedSolver {
    /// Takes an analysed factorisation and a matrix on its pattern.
    pub fn new(cholesky: Cholesky, hessian: SymmetricMatrix) -> Self {
        let n = hessian.dimension();
        Self {
            cholesky,
            hessian,
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            trial: vec![0.0; n],
        }
    }

    /// Lends factorisation and matrix, for another method on the same pattern.
    pub fn lend(&mut self) -> (&mut Cholesky, &mut SymmetricMatrix) {
        (&mut self.cholesky, &mut self.hessian)
    }

    /// Number of factorisations so far.
    pub fn factorisations(&self) -> usize {
        self.cholesky.factorisations()
    }

    /// Minimises from `x`, in place. `observe` hears of every iteration and may break off.
    ///
    /// `Converged` means that the energy or the step no longer changes by more than the tolerances.
    ///
    /// ```
    /// use phex_numeric::{Cholesky, DampedOptions, DampedProblem, DampedSolver, Damping};
    /// use phex_numeric::{Status, SymmetricMatrix};
    /// use std::ops::ControlFlow;
    ///
    /// /// `(x - 3)^2`, where `x` must stay positive.
    /// struct Parabola(f64);
    ///
    /// impl DampedProblem for Parabola {
    ///     fn energy(&mut self, x: &[f64]) -> f64 {
    ///         self.0 = x[0] - 3.0;
    ///         if x[0] > 0.0 { self.0.powi(2) } else { f64::INFINITY }
    ///     }
    ///     fn linearise(&mut self, x: &[f64], gradient: &mut [f64], hessian: &mut SymmetricMatrix) {
    ///         gradient[0] = 2.0 * (x[0] - 3.0);
    ///         hessian.values_mut()[0] = 2.0;
    ///     }
    ///     fn step_bound(&mut self, x: &[f64], step: &[f64]) -> f64 {
    ///         if x[0] + step[0] > 0.0 { 1.0 } else { 0.5 * x[0] / -step[0] }
    ///     }
    ///     fn step_length(&self, step: &[f64]) -> f64 {
    ///         step[0].abs()
    ///     }
    ///     fn residual(&self) -> f64 {
    ///         self.0.abs()
    ///     }
    /// }
    ///
    /// let hessian = SymmetricMatrix::from_triplets(1, [(0, 0, 2.0)].into_iter())?;
    /// let mut solver = DampedSolver::new(Cholesky::new(&hessian)?, hessian);
    /// let options = DampedOptions {
    ///     max_iterations: 30,
    ///     energy_tolerance: 1e-15,
    ///     step_tolerance: 1e-9,
    ///     phase: 0.0,
    /// };
    /// let (mut problem, mut x) = (Parabola(0.0), [1.0]);
    /// let observe = |_: &_| ControlFlow::Continue(());
    /// let damping = &mut Damping::default();
    /// let outcome = solver.minimise(&mut problem, &mut x, damping, &options, observe);
    /// assert_eq!(outcome.status, Status::Converged);
    /// assert!((x[0] - 3.0).abs() < 1e-6);
    /// # Ok::<(), phex_numeric::NumericError>(())
    /// ```
    pub fn minimise(
        &mut self,
        problem: &mut impl DampedProblem,
        x: &mut [f64],
        damping: &mut Damping,
        options: &DampedOptions,
        mut observe: impl FnMut(&Record) -> ControlFlow<()>,
    ) -> Outcome {
        let factorised = self.factorisations();
        let mut outcome = Outcome::empty(Status::IterationLimit);
        let mut energy = problem.energy(x);
        if !energy.is_finite() {
            outcome.status = Status::Stalled;
            return outcome;
        }
        for _ in 0..options.max_iterations {
            problem.linearise(x, &mut self.gradient, &mut self.hessian);
            let Some(step) = self.search(problem, x, energy, damping) else {
                outcome.status = Status::Stalled;
                break;
            };
            add_scaled(x, step.fraction, &self.step);
            problem.retract(x);
            let record = Record {
                phase: options.phase,
                energy: step.energy,
                residual: problem.residual(),
                step: step.fraction * problem.step_length(&self.step),
                fraction: step.fraction,
                damping: step.damping,
            };
            outcome.history.push(record);
            let decrease = energy - step.energy;
            energy = step.energy;
            if observe(&record).is_break() {
                outcome.status = Status::Cancelled;
                break;
            }
            let small_step = record.step < options.step_tolerance;
            if small_step || decrease <= options.energy_tolerance * energy {
                outcome.status = Status::Converged;
                break;
            }
        }
        outcome.iterations = outcome.history.len();
        outcome.factorisations = self.factorisations() - factorised;
        outcome
    }

    /// Finds a damping and a fraction of the step that lower the energy.
    fn search(
        &mut self,
        problem: &mut impl DampedProblem,
        x: &[f64],
        energy: f64,
        damping: &mut Damping,
    ) -> Option<DampedStep> {
        for attempt in 0..TRIES {
            let used = damping.0;
            if self.solve(used) {
                let bound = problem.step_bound(x, &self.step);
                if bound < SHORT && attempt < THROWN_STEPS && used < Damping::MOST {
                    damping.after_thrown_step();
                    continue;
                }
                if let Some((fraction, energy)) = self.line_search(problem, x, energy, bound) {
                    damping.after_step(fraction);
                    return Some(DampedStep {
                        energy,
                        fraction,
                        damping: used,
                    });
                }
            }
            damping.after_failed_search();
        }
        None
    }

    /// `(H + mu I) step = -gradient`.
    fn solve(&mut self, damping: f64) -> bool {
        if self
            .cholesky
            .refactor_shifted(&self.hessian, damping)
            .is_err()
        {
            return false;
        }
        // The next step makes good what rounding does to this one.
        self.cholesky.precondition(&self.gradient, &mut self.step);
        self.step.iter_mut().for_each(|d| *d = -*d);
        self.step.iter().all(|d| d.is_finite())
    }

    fn line_search(
        &mut self,
        problem: &mut impl DampedProblem,
        x: &[f64],
        energy: f64,
        bound: f64,
    ) -> Option<(f64, f64)> {
        let slope = dot(&self.gradient, &self.step);
        let mut fraction = bound;
        for _ in 0..HALVINGS {
            self.trial.copy_from_slice(x);
            add_scaled(&mut self.trial, fraction, &self.step);
            problem.retract(&mut self.trial);
            let trial_energy = problem.energy(&self.trial);
            if trial_energy <= energy + ARMIJO * fraction * slope {
                return Some((fraction, trial_energy));
            }
            fraction *= 0.5;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(1 - x)^2 + 100 (y - x^2)^2`, admissible below a ceiling for `y`.
    struct Rosenbrock {
        ceiling: f64,
        last: [f64; 2],
    }

    impl Rosenbrock {
        fn residuals(x: &[f64]) -> [f64; 2] {
            [1.0 - x[0], 10.0 * (x[1] - x[0] * x[0])]
        }
    }

    impl DampedProblem for Rosenbrock {
        fn energy(&mut self, x: &[f64]) -> f64 {
            self.last = [x[0], x[1]];
            let [r, s] = Self::residuals(x);
            if x[1] < self.ceiling {
                0.5 * (r * r + s * s)
            } else {
                f64::INFINITY
            }
        }
        fn linearise(&mut self, x: &[f64], gradient: &mut [f64], hessian: &mut SymmetricMatrix) {
            let [r, s] = Self::residuals(x);
            let rows = [[-1.0, 0.0], [-20.0 * x[0], 10.0]];
            for i in 0..2 {
                gradient[i] = rows[0][i] * r + rows[1][i] * s;
            }
            let entry = |i: usize, j: usize| rows[0][i] * rows[0][j] + rows[1][i] * rows[1][j];
            let values = [entry(0, 0), entry(1, 0), entry(1, 1)];
            hessian.values_mut().copy_from_slice(&values);
        }
        fn step_bound(&mut self, x: &[f64], step: &[f64]) -> f64 {
            let hit = (self.ceiling - x[1]) / step[1];
            if hit > 0.0 {
                (0.85 * hit).min(1.0)
            } else {
                1.0
            }
        }
        fn step_length(&self, step: &[f64]) -> f64 {
            step[0].hypot(step[1])
        }
        fn residual(&self) -> f64 {
            let [r, s] = Self::residuals(&self.last);
            r.hypot(s)
        }
    }

    fn run(ceiling: f64, max_iterations: usize, stop_after: usize) -> (Outcome, [f64; 2]) {
        let triplets = [(0, 0, 1.0), (1, 0, 1.0), (1, 1, 1.0)];
        let hessian = SymmetricMatrix::from_triplets(2, triplets.into_iter()).unwrap();
        let cholesky = Cholesky::analyse(hessian.pattern(), 1).unwrap();
        let mut solver = DampedSolver::new(cholesky, hessian);
        let mut problem = Rosenbrock {
            ceiling,
            last: [0.0; 2],
        };
        let mut x = [-1.2, 1.0];
        let options = DampedOptions {
            max_iterations,
            energy_tolerance: 0.0,
            step_tolerance: 1e-12,
            phase: 0.0,
        };
        let mut seen = 0;
        let observe = |_: &Record| {
            seen += 1;
            if seen == stop_after {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let mut damping = Damping::default();
        let outcome = solver.minimise(&mut problem, &mut x, &mut damping, &options, observe);
        (outcome, x)
    }

    #[test]
    fn finds_the_minimum_with_falling_energy() {
        let (outcome, x) = run(f64::INFINITY, 100, 0);
        assert_eq!(outcome.status, Status::Converged);
        assert!((x[0] - 1.0).abs() < 1e-10 && (x[1] - 1.0).abs() < 1e-10);
        let falling = |w: &[Record]| w[1].energy <= w[0].energy;
        assert!(outcome.history.windows(2).all(falling));
        assert!(outcome.factorisations >= outcome.iterations);
    }

    #[test]
    fn stays_below_the_ceiling() {
        let (outcome, x) = run(1.05, 60, 0);
        assert!(x[1] < 1.05, "{x:?}");
        assert!((x[0] - 1.0).abs() < 1e-6, "{x:?} {:?}", outcome.status);
    }

    #[test]
    fn limit_and_cancel_are_told() {
        assert_eq!(run(f64::INFINITY, 2, 0).0.status, Status::IterationLimit);
        let (outcome, _) = run(f64::INFINITY, 100, 3);
        assert_eq!((outcome.status, outcome.iterations), (Status::Cancelled, 3));
    }

    #[test]
    fn an_inadmissible_start_is_left_alone() {
        let (outcome, x) = run(0.9, 100, 0);
        assert_eq!((outcome.status, x), (Status::Stalled, [-1.2, 1.0]));
    }
}
