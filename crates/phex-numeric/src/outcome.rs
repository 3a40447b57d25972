//! How an iteration ended, and the way it went.

use serde::{Deserialize, Serialize};

/// Why an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The goal was reached.
    Converged,
    /// The number of iterations that was allowed is used up.
    IterationLimit,
    /// No step makes progress any more, short of the goal.
    Stalled,
    /// Not a number, or a system that stays indefinite with any damping.
    NumericalBreakdown,
    /// The caller asked to stop.
    Cancelled,
}

/// One iteration.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Phase of the whole iteration that it belongs to (the penalty weight, say).
    pub phase: f64,
    /// Energy after the iteration.
    pub energy: f64,
    /// What is driven to zero.
    pub residual: f64,
    /// Length of the step, in the unit of the problem.
    pub step: f64,
    /// Fraction of the full step that was taken.
    pub fraction: f64,
    /// Damping that the step was computed with.
    pub damping: f64,
}

/// How an iteration ended, and the way it went.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Why it ended.
    pub status: Status,
    /// Every iteration, in order.
    pub history: Vec<Record>,
    /// Number of iterations.
    pub iterations: usize,
    /// Number of matrix factorisations.
    pub factorisations: usize,
}

impl Outcome {
    /// The outcome of a run that did nothing.
    pub fn empty(status: Status) -> Self {
        Self {
            status,
            history: Vec::new(),
            iterations: 0,
            factorisations: 0,
        }
    }

    /// Appends a later run; its status becomes the status of the whole.
    pub fn append(&mut self, later: Outcome) {
        self.status = later.status;
        self.history.extend(later.history);
        self.iterations += later.iterations;
        self.factorisations += later.factorisations;
    }
}
