//! A start that nearly meets the constraints: the energy is minimised with the angle condition and
//! what closes as penalties that rise.
//!
//! ```text
//! E + w_a/2 u^2 (sum r^2 + sum c^2)     r of even faces, c of closing equations, u an eighth of the mean edge
//! ```
//!
//! The feasible path of the stage: the barrier keeps panels simple however far they go. Near
//! parabolic curves they go along the surface by an edge and more; central symmetry, which
//! satisfies the condition, shows the way.

use super::AngleOptions;
use crate::optimise::error::OptimiseError;
use crate::optimise::panels::FaceShapes;
use crate::optimise::solver::energy::panel_energy;
use crate::optimise::solver::solvers::{StepReporter, energy_assembly_with, system};
use crate::optimise::terms::angle_term::closing::Closing;
use crate::optimise::terms::angle_term::walks::{Walk, Walks};
use crate::optimise::terms::angle_term::{AngleTerm, branches};
use crate::optimise::terms::setting::Setting;
use crate::progress::Progress;
use phex_numeric::{DampedOptions, DampedSolver, Damping, Outcome, Status};

/// Weights of planarity and of angles, phase by phase.
const PHASES: [[f64; 2]; 9] = [
    [1e2, 0.0],
    [1e3, 1e0],
    [1e3, 1e1],
    [1e4, 1e2],
    [1e5, 1e3],
    [1e6, 1e4],
    [1e7, 1e5],
    [1e8, 1e6],
    [1e9, 1e7],
];
/// Iterations of a phase at the most.
const ITERATIONS: usize = 60;
/// Relative decrease of the energy, and step in mean edges, that end a phase.
const LITTLE: [f64; 2] = [1e-4, 1e-4];

/// Minimises from `start` on, with factors of the weights of fairness and barrier.
pub(super) fn by_continuation(
    setting: &Setting<'_>,
    walks: &Walks,
    start: &[f64],
    options: &AngleOptions,
    [fairness, barrier]: [f64; 2],
    progress: &dyn Progress,
) -> Result<(Vec<f64>, Outcome), OptimiseError> {
    let mut x = start.to_vec();
    let of_walks = walks.walks.iter().map(Walk::distinct);
    let assembly = energy_assembly_with(setting.panels, of_walks);
    let (cholesky, matrix) = system(&assembly, 3)?;
    let mut minimiser = DampedSolver::new(cholesky, matrix);
    let mut energy = panel_energy(setting, &assembly, start, &options.optimise);
    energy.weights.fairness *= fairness;
    energy.barriers.iter_mut().for_each(|b| b.weight *= barrier);
    let mut damping = Damping::default();
    let mut reporter = StepReporter::new(progress, super::STAGE, PHASES.len() * ITERATIONS);
    let mut outcome = Outcome::empty(Status::Converged);
    for [planarity, angles] in PHASES {
        energy.weights.planarity = planarity;
        let shape = FaceShapes::at(setting.panels, &x);
        energy.angles = Some(AngleTerm::new(
            angles,
            setting.mean_edge,
            branches(setting.panels, &shape),
            Closing::new(walks, setting.panels, &shape, &x),
        ));
        energy.arm(&x);
        let limits = DampedOptions {
            max_iterations: ITERATIONS,
            energy_tolerance: LITTLE[0],
            step_tolerance: LITTLE[1],
            phase: angles,
        };
        let observe = |record: &_| reporter.observe(record);
        outcome.append(minimiser.minimise(&mut energy, &mut x, &mut damping, &limits, observe));
        if outcome.status == Status::Cancelled {
            break;
        }
    }
    Ok((x, outcome))
}
