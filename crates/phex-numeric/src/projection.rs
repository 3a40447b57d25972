//! Projection onto constraints by steps of minimum norm.
//!
//! `d = -J^T (J J^T + eps I)^-1 c`, refined with the unshifted `J J^T`, repeated until `c` is at
//! the floor of rounding. Where constraints depend on each other `J J^T` is singular up to
//! rounding; the shift `eps` makes it factorise, and the refinement takes its effect back in the
//! directions that count.
//!
//! | symbol | here |
//! |---|---|
//! | `c`, `J` | [`Constraints::linearise`] |
//! | `J J^T` | `normal`, assembled by [`Constraints::linearise`] |
//! | `eps` | [`SHIFT`], times 100 for each failed factorisation |
//!
//! Guaranteed: every iterate is admissible in the sense of [`Constraints::admissible`] if the first
//! one is, and what is returned has the least residual of all of them. Fails (`Stalled`) where the
//! guard forbids every fraction of a step.

use crate::cholesky::max_abs;
use crate::conjugate_gradients::add_scaled;
use crate::outcome::{Outcome, Record, Status};
use crate::{Cholesky, SymmetricMatrix};
use std::ops::ControlFlow;

/// First diagonal shift of `J J^T`, whose diagonal should be about 1.
pub const SHIFT: f64 = 1e-12;

const SHIFT_TRIES: usize = 5;
const REFINEMENTS: usize = 4;
/// Defect of the multiplier, over the constraints' values, that is rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
const HALVINGS: usize = 8;
/// Fraction of a step below which it is short, and short steps in a row, none of which halves the
/// residual, after which it has stalled.
const SHORT: f64 = 0.1;
const CREEPING: usize = 3;

/// Equations `c(x) = 0` with a region that must not be left.
pub trait Constraints {
    /// Values `c` and the matrix `J J^T` at `x`; keeps `J` for [`transposed`](Self::transposed).
    fn linearise(&mut self, x: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix);
    /// `d = J^T y`, with the `J` of the last linearisation.
    fn transposed(&self, y: &[f64], d: &mut [f64]);
    /// Largest fraction `t` in `(0, 1]` of `step` that may be tried.
    fn step_bound(&mut self, x: &[f64], step: &[f64]) -> f64;
    /// Residual at `x` if `x` may be visited, otherwise `None`.
    fn admissible(&mut self, x: &[f64]) -> Option<f64>;
    /// Shortens a step where `x`, to which it has led, may not be visited.
    fn hold_back(&mut self, x: &[f64], step: &mut [f64]);
    /// Length of a step in the unit of the problem.
    fn step_length(&self, step: &[f64]) -> f64;
    /// Brings a point to which a step has led back to where unknowns are held (on a curve, say);
    /// moves nothing by default.
    fn retract(&self, _x: &mut [f64]) {}
}

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProjectionOptions {
    /// Iterations at the most.
    pub max_iterations: usize,
    /// Residual below which the iteration stops at once.
    pub goal: f64,
    /// Residual that counts as converged when the iteration can't go on, or no longer halves it.
    pub tolerance: f64,
    /// Number that [`Record::phase`] is set to.
    pub phase: f64,
}

/// Memory and factorisation of the projection, kept between runs on the same pattern.
#[derive(Debug)]
pub struct MinimumNorm {
    cholesky: Cholesky,
    normal: SymmetricMatrix,
    values: Vec<f64>,
    multiplier: Vec<f64>,
    defect: Vec<f64>,
    change: Vec<f64>,
}

impl MinimumNorm {
    /// Takes an analysed factorisation and a matrix on its pattern.
    pub fn new(cholesky: Cholesky, normal: SymmetricMatrix) -> Self {
        let n = normal.dimension();
        Self {
            cholesky,
            normal,
            values: vec![0.0; n],
            multiplier: vec![0.0; n],
            defect: vec![0.0; n],
            change: vec![0.0; n],
        }
    }

    /// Gives factorisation and matrix back.
    pub fn into_parts(self) -> (Cholesky, SymmetricMatrix) {
        (self.cholesky, self.normal)
    }

    /// Number of factorisations so far.
    pub fn factorisations(&self) -> usize {
        self.cholesky.factorisations()
    }

    /// Projects `x`, in place. `observe` hears of every iteration and may break off.
    ///
    /// ```
    /// use phex_numeric::{Cholesky, Constraints, MinimumNorm, ProjectionOptions};
    /// use phex_numeric::{Status, SymmetricMatrix};
    /// use std::ops::ControlFlow;
    ///
    /// /// Points of the unit circle: `x^2 + y^2 = 1`.
    /// struct Circle([f64; 2]);
    ///
    /// impl Constraints for Circle {
    ///     fn linearise(&mut self, x: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix) {
    ///         self.0 = [2.0 * x[0], 2.0 * x[1]];
    ///         values[0] = x[0] * x[0] + x[1] * x[1] - 1.0;
    ///         normal.values_mut()[0] = self.0[0].powi(2) + self.0[1].powi(2);
    ///     }
    ///     fn transposed(&self, y: &[f64], d: &mut [f64]) {
    ///         d.copy_from_slice(&[self.0[0] * y[0], self.0[1] * y[0]]);
    ///     }
    ///     fn step_bound(&mut self, _: &[f64], _: &[f64]) -> f64 {
    ///         1.0
    ///     }
    ///     fn admissible(&mut self, x: &[f64]) -> Option<f64> {
    ///         Some((x[0] * x[0] + x[1] * x[1] - 1.0).abs())
    ///     }
    ///     fn hold_back(&mut self, _: &[f64], step: &mut [f64]) {
    ///         step.iter_mut().for_each(|d| *d *= 0.5);
    ///     }
    ///     fn step_length(&self, step: &[f64]) -> f64 {
    ///         step[0].hypot(step[1])
    ///     }
    /// }
    ///
    /// let normal = SymmetricMatrix::from_triplets(1, [(0, 0, 1.0)].into_iter())?;
    /// let mut projection = MinimumNorm::new(Cholesky::new(&normal)?, normal);
    /// let options = ProjectionOptions {
    ///     max_iterations: 30,
    ///     goal: 1e-14,
    ///     tolerance: 1e-12,
    ///     phase: 0.0,
    /// };
    /// let mut point = [0.0, 2.0];
    /// let observe = |_: &_| ControlFlow::Continue(());
    /// let outcome = projection.project(&mut Circle([0.0; 2]), &mut point, &options, observe);
    /// assert_eq!(outcome.status, Status::Converged);
    /// assert!((point[1] - 1.0).abs() < 1e-9);
    /// # Ok::<(), phex_numeric::NumericError>(())
    /// ```
    pub fn project(
        &mut self,
        problem: &mut impl Constraints,
        x: &mut [f64],
        options: &ProjectionOptions,
        mut observe: impl FnMut(&Record) -> ControlFlow<()>,
    ) -> Outcome {
        let factorised = self.factorisations();
        let mut outcome = Outcome::empty(Status::IterationLimit);
        let (mut step, mut trial) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        let Some(residual) = problem.admissible(x) else {
            outcome.status = Status::Stalled;
            return outcome;
        };
        let mut watchdog = Watchdog::new(x, residual);
        let mut creeping = 0;
        while outcome.history.len() < options.max_iterations && watchdog.best > options.goal {
            if !self.solve(problem, x, &mut step) {
                outcome.status = Status::NumericalBreakdown;
                break;
            }
            let bound = problem.step_bound(x, &step);
            let limit = watchdog.limit();
            let before = watchdog.best;
            let reached = guarded(problem, x, &mut step, (bound, limit), &mut trial);
            let Some((fraction, reached)) = reached else {
                if watchdog.go_back(x) {
                    continue;
                }
                outcome.status = Status::Stalled;
                break;
            };
            x.copy_from_slice(&trial);
            let record = Record {
                phase: options.phase,
                energy: f64::NAN,
                residual: reached,
                step: fraction * problem.step_length(&step),
                fraction,
                damping: 0.0,
            };
            outcome.history.push(record);
            if observe(&record).is_break() {
                outcome.status = Status::Cancelled;
                watchdog.note(x, reached);
                break;
            }
            watchdog.note(x, reached);
            let falls = watchdog.best <= 0.5 * before;
            // Converged, and what is left is rounding.
            if watchdog.best <= options.tolerance && !falls {
                break;
            }
            let creeps = fraction < SHORT && !falls;
            creeping = if creeps { creeping + 1 } else { 0 };
            if creeping >= CREEPING {
                outcome.status = Status::Stalled;
                break;
            }
            if watchdog.has_waited() {
                watchdog.go_back(x);
            }
        }
        x.copy_from_slice(&watchdog.place);
        if watchdog.best <= options.tolerance && outcome.status != Status::Cancelled {
            outcome.status = Status::Converged;
        }
        outcome.iterations = outcome.history.len();
        outcome.factorisations = self.factorisations() - factorised;
        outcome
    }

    /// The step of minimum norm that meets the linearised constraints.
    fn solve(&mut self, problem: &mut impl Constraints, x: &[f64], step: &mut [f64]) -> bool {
        problem.linearise(x, &mut self.values, &mut self.normal);
        if !self.factorise() {
            return false;
        }
        let (cholesky, change) = (&self.cholesky, &mut self.change);
        cholesky.precondition(&self.values, &mut self.multiplier);
        let floor = ROUNDING * max_abs(&self.values);
        for _ in 0..REFINEMENTS {
            self.normal.mul(&self.multiplier, &mut self.defect);
            let defects = self.defect.iter_mut().zip(&self.values);
            defects.for_each(|(d, c)| *d = c - *d);
            if max_abs(&self.defect) <= floor {
                break;
            }
            cholesky.precondition(&self.defect, change);
            add_scaled(&mut self.multiplier, 1.0, change);
        }
        problem.transposed(&self.multiplier, step);
        step.iter_mut().for_each(|d| *d = -*d);
        step.iter().all(|d| d.is_finite())
    }

    fn factorise(&mut self) -> bool {
        let mut shift = SHIFT;
        for _ in 0..SHIFT_TRIES {
            if self.cholesky.refactor_shifted(&self.normal, shift).is_ok() {
                return true;
            }
            shift *= 100.0;
        }
        false
    }
}

/// Lets the residual rise for a few iterations, and fall again for as many as it takes, and knows
/// the best place to go back to.
///
/// Near dependent constraints a full step is long, and its second-order error disturbs
/// well-determined constraints, which the next steps repair; to demand a falling residual there
/// would mean to creep.
struct Watchdog {
    place: Vec<f64>,
    best: f64,
    last: f64,
    /// Iterations since the best one in which the residual has not fallen.
    waited: usize,
    patience: usize,
}

impl Watchdog {
    const PATIENCE: usize = 3;
    const RISE: f64 = 100.0;

    fn new(x: &[f64], residual: f64) -> Self {
        Self {
            place: x.to_vec(),
            best: residual,
            last: residual,
            waited: 0,
            patience: Self::PATIENCE,
        }
    }

    /// Residual that the next place must stay below.
    fn limit(&self) -> f64 {
        if self.patience > 0 {
            Self::RISE * self.best
        } else {
            self.best
        }
    }

    fn note(&mut self, x: &[f64], residual: f64) {
        if residual < self.best {
            self.place.copy_from_slice(x);
            self.best = residual;
            self.waited = 0;
        } else if residual >= self.last {
            self.waited += 1;
        }
        self.last = residual;
    }

    fn has_waited(&self) -> bool {
        self.patience > 0 && self.waited >= self.patience
    }

    /// Goes back to the best place, and demands a falling residual from then on; `false` if that
    /// was so already.
    fn go_back(&mut self, x: &mut [f64]) -> bool {
        x.copy_from_slice(&self.place);
        self.waited = 0;
        std::mem::take(&mut self.patience) > 0
    }
}

/// Largest tried fraction of the step, from `bound` on, that stays admissible with a residual below
/// `limit`; `trial` holds the point. The step is held back where it is not admissible.
fn guarded(
    problem: &mut impl Constraints,
    x: &[f64],
    step: &mut [f64],
    (bound, limit): (f64, f64),
    trial: &mut [f64],
) -> Option<(f64, f64)> {
    let mut fraction = bound;
    for _ in 0..HALVINGS {
        trial.copy_from_slice(x);
        add_scaled(trial, fraction, step);
        problem.retract(trial);
        match problem.admissible(trial) {
            Some(reached) if reached < limit => return Some((fraction, reached)),
            Some(_) => fraction *= 0.5,
            None => problem.hold_back(trial, step),
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `A x = b` (rows of `A`), with a bound for the first coordinate, and one for the fraction of
    /// a step.
    struct Linear {
        bound: f64,
        rows: Vec<Vec<f64>>,
        b: Vec<f64>,
        floor: f64,
        /// Where residuals end: each that is looked at is a little smaller than the last one.
        rounding: f64,
    }

    impl Linear {
        fn values(&self, x: &[f64]) -> Vec<f64> {
            let value = |(row, b): (&Vec<f64>, &f64)| crate::conjugate_gradients::dot(row, x) - b;
            self.rows.iter().zip(&self.b).map(value).collect()
        }
    }

    impl Constraints for Linear {
        fn linearise(&mut self, x: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix) {
            values.copy_from_slice(&self.values(x));
            let m = self.rows.len();
            let mut at = 0;
            for j in 0..m {
                for i in j..m {
                    normal.values_mut()[at] =
                        crate::conjugate_gradients::dot(&self.rows[i], &self.rows[j]);
                    at += 1;
                }
            }
        }
        fn transposed(&self, y: &[f64], d: &mut [f64]) {
            d.fill(0.0);
            for (row, y) in self.rows.iter().zip(y) {
                add_scaled(d, *y, row);
            }
        }
        fn step_bound(&mut self, _x: &[f64], _step: &[f64]) -> f64 {
            self.bound
        }
        fn admissible(&mut self, x: &[f64]) -> Option<f64> {
            self.rounding *= 0.99;
            let values = self.values(x);
            let size = values
                .iter()
                .fold(self.rounding, |m: f64, c| m.max(c.abs()));
            (x[0] >= self.floor).then_some(size)
        }
        fn hold_back(&mut self, _: &[f64], step: &mut [f64]) {
            step[0] *= 0.5;
        }
        fn step_length(&self, step: &[f64]) -> f64 {
            crate::conjugate_gradients::dot(step, step).sqrt()
        }
    }

    fn project(problem: &mut Linear, x: &mut [f64]) -> Outcome {
        let m = problem.rows.len() as u32;
        let dense = (0..m).flat_map(|j| (j..m).map(move |i| (i, j, 1.0)));
        let normal = SymmetricMatrix::from_triplets(m as usize, dense).unwrap();
        let cholesky = Cholesky::analyse(normal.pattern(), 1).unwrap();
        let options = ProjectionOptions {
            max_iterations: 10,
            goal: 1e-15,
            tolerance: 1e-13,
            phase: 0.0,
        };
        let observe = |_: &Record| ControlFlow::Continue(());
        MinimumNorm::new(cholesky, normal).project(problem, x, &options, observe)
    }

    fn rows() -> Vec<Vec<f64>> {
        vec![vec![1.0, 0.0, 0.6, 0.2], vec![0.3, 1.0, -0.1, 0.5]]
    }

    #[test]
    fn equals_the_pseudo_inverse() {
        let mut problem = Linear {
            bound: 1.0,
            rows: rows(),
            b: vec![1.0, -2.0],
            floor: f64::NEG_INFINITY,
            rounding: 0.0,
        };
        let mut x = vec![0.4, 0.1, -0.3, 0.8];
        let start = x.clone();
        assert_eq!(project(&mut problem, &mut x).status, Status::Converged);
        assert!(problem.values(&x).iter().all(|c| c.abs() < 1e-14));
        // Minimum norm: the movement lies in the row space, so it is orthogonal to the null space
        // of the rows, here spanned by two vectors found by hand elimination.
        let null = [[-0.6, 0.28, 1.0, 0.0], [-0.2, -0.44, 0.0, 1.0]];
        for n in null {
            assert!(
                problem
                    .rows
                    .iter()
                    .all(|r| crate::conjugate_gradients::dot(r, &n).abs() < 1e-15)
            );
            let along: f64 = (0..4).map(|k| n[k] * (x[k] - start[k])).sum();
            assert!(along.abs() < 1e-14);
        }
    }

    #[test]
    fn dependent_constraints_are_met_through_the_shift() {
        let mut doubled = rows();
        doubled.push(doubled[0].clone());
        let mut problem = Linear {
            bound: 1.0,
            rows: doubled,
            b: vec![1.0, -2.0, 1.0],
            floor: f64::NEG_INFINITY,
            rounding: 0.0,
        };
        let mut x = vec![0.0; 4];
        assert_eq!(project(&mut problem, &mut x).status, Status::Converged);
        assert!(x.iter().all(|x| x.abs() < 10.0));
    }

    #[test]
    fn short_steps_without_progress_end_it_soon() {
        let mut problem = Linear {
            bound: 0.05,
            rows: vec![vec![1.0, 0.0]],
            b: vec![0.0],
            floor: f64::NEG_INFINITY,
            rounding: 0.0,
        };
        let mut x = vec![1.0, 3.0];
        let creeping = project(&mut problem, &mut x);
        assert_eq!(creeping.status, Status::Stalled);
        assert_eq!(creeping.iterations, CREEPING);
        assert!(
            (x[0] - 0.95_f64.powi(3)).abs() < 1e-12,
            "what was won stays: {x:?}"
        );
        // Steps that are half as long as wanted are not short.
        problem.bound = 0.5;
        let slow = project(&mut problem, &mut x);
        assert_eq!(slow.iterations, 10);
    }

    #[test]
    fn it_ends_where_only_rounding_is_left() {
        let [mut exact, mut rounded] = [0.0, 5e-14].map(|rounding| Linear {
            bound: 1.0,
            rows: rows(),
            b: vec![1.0, -2.0],
            floor: f64::NEG_INFINITY,
            rounding,
        });
        let ends = [&mut exact, &mut rounded].map(|problem| {
            let outcome = project(problem, &mut [0.0; 4]);
            assert_eq!(outcome.status, Status::Converged);
            outcome.iterations
        });
        assert!(ends[1] <= ends[0] + 1, "{ends:?}");
    }

    /// An equation in one unknown whose full steps go from each number to the next, with given
    /// residuals there and larger ones between.
    struct Ridge([f64; 7]);

    impl Constraints for Ridge {
        fn linearise(&mut self, _: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix) {
            values[0] = 1.0;
            normal.values_mut()[0] = 1.0;
        }
        fn transposed(&self, y: &[f64], d: &mut [f64]) {
            d[0] = -y[0];
        }
        fn step_bound(&mut self, _: &[f64], _: &[f64]) -> f64 {
            1.0
        }
        fn admissible(&mut self, x: &[f64]) -> Option<f64> {
            let at = x[0].round();
            Some(self.0[at as usize] + (x[0] - at).abs())
        }
        fn hold_back(&mut self, _: &[f64], step: &mut [f64]) {
            step[0] *= 0.5;
        }
        fn step_length(&self, step: &[f64]) -> f64 {
            step[0].abs()
        }
    }

    #[test]
    fn a_residual_that_has_risen_and_falls_again_is_waited_for() {
        let ends = [
            [1.0, 5.0, 4.0, 3.0, 2.0, 1.5, 0.0],
            [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.0],
        ];
        let [falls, rises] = ends.map(|residuals| {
            let normal = SymmetricMatrix::from_triplets(1, [(0, 0, 1.0)].into_iter()).unwrap();
            let cholesky = Cholesky::new(&normal).unwrap();
            let options = ProjectionOptions {
                max_iterations: 20,
                goal: 1e-9,
                tolerance: 1e-9,
                phase: 0.0,
            };
            let observe = |_: &Record| ControlFlow::Continue(());
            let mut x = [0.0];
            let mut projector = MinimumNorm::new(cholesky, normal);
            let outcome = projector.project(&mut Ridge(residuals), &mut x, &options, observe);
            (outcome.status, outcome.iterations)
        });
        assert_eq!(falls, (Status::Converged, 6));
        assert_eq!(rises, (Status::Stalled, 3), "three steps, and back");
    }

    #[test]
    fn the_guard_is_never_crossed() {
        let mut problem = Linear {
            bound: 1.0,
            rows: vec![vec![1.0, 0.0]],
            b: vec![0.0],
            floor: 0.25,
            rounding: 0.0,
        };
        let mut x = vec![1.0, 3.0];
        let outcome = project(&mut problem, &mut x);
        assert_eq!(outcome.status, Status::Stalled);
        assert!(x[0] >= 0.25 && x[0] < 0.3 && x[1] == 3.0, "{x:?}");
    }

    #[test]
    fn a_step_is_held_back_only_where_it_leads_out() {
        let mut problem = Linear {
            bound: 1.0,
            rows: vec![vec![1.0, 0.0], vec![0.0, 1.0]],
            b: vec![0.0; 2],
            floor: 0.25,
            rounding: 0.0,
        };
        let mut x = vec![1.0, 3.0];
        project(&mut problem, &mut x);
        assert_eq!(x, [0.25, 0.0], "the second equation is met all the same");
    }
}
