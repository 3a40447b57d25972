//! The way from the start onto the constraints, and down the energy within them.

use super::AngleOptions;
use super::constraints::AngleConstraints;
use super::tangent::Tangent;
use crate::optimise::error::OptimiseError;
use crate::optimise::solver::energy::{PanelEnergy, panel_energy};
use crate::optimise::solver::solvers::{StepReporter, system};
use crate::optimise::terms::angle_term::walks::Walks;
use crate::optimise::terms::setting::Setting;
use crate::progress::Progress;
use phex_mesh::ValidateOptions;
use phex_numeric::{
    Assembly, Constraints, DampedProblem, MinimumNorm, Outcome, ProjectionOptions, Record, Status,
};
use std::ops::ControlFlow;

/// Residual (radians, mean edges) below which steps of minimum norm converge fast.
const NEAR: f64 = 1e-2;
/// Straight projections at the most, with the parting of panels between them.
const PROJECTIONS: usize = 4;
/// Newton iterations of a projection that parts panels, over those of a straight one: it goes
/// slowly, but steadily.
const APART: usize = 4;
/// Halvings of a step of the descent.
const HALVINGS: usize = 5;
/// Relative decrease of the energy that ends the descent.
const LITTLE: f64 = 1e-3;
/// Projection iterations after a step of the descent.
const RETRACTIONS: usize = 6;

/// The way from the start: constraints, energy and factorisations.
pub(super) struct AnglePath<'a> {
    pub(super) constraints: AngleConstraints<'a>,
    projector: MinimumNorm,
    tangent: Tangent,
    pub(super) energy: PanelEnergy<'a>,
    options: &'a AngleOptions,
    progress: &'a dyn Progress,
    pub(super) outcome: Outcome,
}

impl<'a> AnglePath<'a> {
    /// `way` is the clearance that is kept, over the least one of a result.
    pub(super) fn new(
        setting: &'a Setting<'a>,
        [energy, angles]: &'a [Assembly; 2],
        walks: &'a Walks,
        x: &[f64],
        options: &'a AngleOptions,
        way: f64,
        progress: &'a dyn Progress,
    ) -> Result<Self, OptimiseError> {
        let least = way * ValidateOptions::CLEARANCE * setting.mean_edge;
        let (cholesky, normal) = system(angles, 1)?;
        Ok(Self {
            constraints: AngleConstraints::new(setting, angles, walks, x, least),
            projector: MinimumNorm::new(cholesky, normal),
            tangent: Tangent::new(energy, angles, x.len())?,
            energy: panel_energy(setting, energy, x, &options.optimise),
            options,
            progress,
            outcome: Outcome::empty(Status::Converged),
        })
    }

    /// Whether `x` is sound, planar and has the right angles as it is.
    pub(super) fn is_met(&mut self, x: &[f64]) -> bool {
        let residual = self.constraints.admissible(x);
        residual.is_some_and(|r| r <= self.options.tolerance)
    }

    /// Projects `x` onto the constraints. Where panels that must not come closer stop that, they
    /// are parted first.
    pub(super) fn project(&mut self, x: &mut [f64]) {
        for _ in 0..PROJECTIONS {
            self.project_straight(x);
            if self.outcome.status != Status::Stalled || !self.project_apart(x) {
                return;
            }
        }
    }

    /// Newton steps of minimum norm.
    fn project_straight(&mut self, x: &mut [f64]) {
        let options = self.projection(self.options.newton_iterations);
        let mut reporter = self.reporter(options.max_iterations);
        let observe = |record: &Record| reporter.observe(record);
        let projector = &mut self.projector;
        let outcome = projector.project(&mut self.constraints, x, &options, observe);
        self.outcome.append(outcome);
    }

    /// Newton steps in the metric of the energy, whose barrier makes tight corners stiff, along its
    /// gradient, which opens them; ends near the constraints, where straight steps do better. False
    /// if it does not get there.
    fn project_apart(&mut self, x: &mut [f64]) -> bool {
        let mut values = vec![0.0; self.tangent.multiplier.len()];
        let mut residual = self.constraints.admissible(x).unwrap_or(f64::INFINITY);
        for _ in 0..APART * self.options.newton_iterations {
            if residual <= NEAR || self.progress.is_cancelled() {
                break;
            }
            self.energy.arm(x);
            let tangent = &mut self.tangent;
            self.energy
                .linearise(x, &mut tangent.gradient, &mut tangent.hessian);
            self.constraints
                .linearise(x, &mut values, &mut tangent.normal);
            if !tangent.solve(&mut self.constraints, Some(&values)) {
                break;
            }
            self.outcome.iterations += 1;
            self.outcome.factorisations += 1;
            match self.lower_residual(x, residual) {
                Some(reached) => residual = reached,
                None => break,
            }
        }
        residual <= NEAR
    }

    /// Moves `x` by the first fraction of the step that lowers the residual, which it returns.
    fn lower_residual(&mut self, x: &mut [f64], residual: f64) -> Option<f64> {
        let mut fraction = self.constraints.step_bound(x, &self.tangent.step);
        for _ in 0..HALVINGS {
            let step = self.tangent.step.iter();
            let trial: Vec<f64> = x.iter().zip(step).map(|(x, d)| x + fraction * d).collect();
            let reached = self.constraints.admissible(&trial);
            if let Some(reached) = reached.filter(|&r| r < residual) {
                x.copy_from_slice(&trial);
                return Some(reached);
            }
            fraction *= 0.5;
        }
        None
    }

    fn reporter(&self, limit: usize) -> StepReporter<'a> {
        StepReporter::new(self.progress, super::STAGE, limit)
    }

    fn projection(&self, max_iterations: usize) -> ProjectionOptions {
        ProjectionOptions {
            max_iterations,
            goal: 0.0,
            tolerance: self.options.tolerance,
            phase: f64::INFINITY,
        }
    }

    /// Lowers the energy within the constraints, which `x` must meet.
    pub(super) fn descend(&mut self, x: &mut Vec<f64>) {
        self.energy.arm(x);
        let mut energy = self.energy.energy(x);
        let mut reporter = self.reporter(super::DESCENT_STEPS);
        for _ in 0..super::DESCENT_STEPS {
            if !energy.is_finite() {
                break;
            }
            let Some((trial, lower)) = self.descent_step(x, energy) else {
                break;
            };
            let decrease = (energy - lower) / energy;
            (*x, energy) = (trial, lower);
            let record = self.outcome.history.last().copied();
            let over = record.is_some_and(|r| reporter.observe(&r).is_break());
            if over {
                self.outcome.status = Status::Cancelled;
            }
            if over || decrease < LITTLE {
                break;
            }
        }
    }

    /// The first fraction of a step that, projected back, lowers the energy.
    fn descent_step(&mut self, x: &[f64], energy: f64) -> Option<(Vec<f64>, f64)> {
        let tangent = &mut self.tangent;
        self.energy
            .linearise(x, &mut tangent.gradient, &mut tangent.hessian);
        self.constraints.update_rows(x);
        if !tangent.solve(&mut self.constraints, None) {
            return None;
        }
        let mut fraction = self.constraints.step_bound(x, &self.tangent.step);
        for _ in 0..HALVINGS {
            let step = self.tangent.step.iter();
            let moved = x.iter().zip(step).map(|(x, d)| x + fraction * d);
            let mut trial: Vec<f64> = moved.collect();
            if self.retract(&mut trial) {
                let lower = self.energy.energy(&trial);
                if lower < energy {
                    self.tangent.adapt(fraction);
                    return Some((trial, lower));
                }
            }
            fraction *= 0.5;
        }
        None
    }

    /// Projects a trial back; false if it does not get there.
    fn retract(&mut self, trial: &mut [f64]) -> bool {
        let options = self.projection(RETRACTIONS);
        let go_on = |_: &Record| ControlFlow::Continue(());
        let outcome = self
            .projector
            .project(&mut self.constraints, trial, &options, go_on);
        let arrived = outcome.status == Status::Converged;
        self.outcome.iterations += outcome.iterations;
        self.outcome.factorisations += outcome.factorisations;
        self.outcome.history.extend(outcome.history);
        arrived
    }
}
