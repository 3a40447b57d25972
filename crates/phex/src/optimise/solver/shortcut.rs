//! Shorter ways than the feasible path: the projection alone, and the fast path.

use super::fast::NearlyPlanar;
use super::parts::{Part, PartRegion};
use super::reached::{ResultOrigin, Run};
use super::solvers::{Dual, Solvers, StepReporter};
use super::start::Start;
use crate::optimise::Stage;
use crate::optimise::constraints::minimum_norm::PlanarityConstraints;
use crate::optimise::options::{
    KEPT_CLEARANCE, OptimiseOptions, PROJECTION_ITERATIONS, PathKind, StartKind,
};
use crate::optimise::panels::FaceShapes;
use crate::optimise::terms::setting::Setting;
use crate::optimise::terms::shape_limits::ShapeLimits;
use crate::progress::Progress;
use phex_numeric::{
    Assembly, MinimumNorm, Outcome, ProjectionOptions, Record, SchurOptions, SchurSqp, Status,
};

/// Planarity, in mean edges, at which the projection stops. It converges quadratically, so the last
/// step mostly ends at the floor of rounding.
const GOAL: f64 = 5e-14;

/// Iterations of the fast path at the most.
const FAST_ITERATIONS: usize = 40;
/// Step of the fast path, in mean edges, that counts as none.
const FAST_STEP: f64 = 1e-8;
/// Planarity of a start, in mean edges, beyond which the fast path is not tried.
const FAST_START: f64 = 1e-2;

/// The projection of minimum norm onto the planarity constraints.
pub(super) struct Projection<'a> {
    pub setting: &'a Setting<'a>,
    pub assembly: &'a Assembly,
    pub options: &'a OptimiseOptions,
    /// Clearance to keep, in mean edges; `None` where nothing is guarded.
    pub margin: Option<f64>,
    /// Whether what is in the way is passed by; else it ends the projection, and another way is
    /// taken.
    pub passes_by: bool,
}

impl Projection<'_> {
    /// Projects `x` in place.
    pub fn project(
        &self,
        dual: &mut Option<Dual>,
        x: &mut [f64],
        reporter: &mut StepReporter<'_>,
    ) -> Outcome {
        let Some((cholesky, matrix)) = dual.take() else {
            return Outcome::empty(Status::Converged);
        };
        let edge = self.setting.panels.mean_edge(x);
        let least = self.margin.map(|margin| margin * edge);
        let mut constraints = PlanarityConstraints::new(self.setting, self.assembly, x, least);
        constraints.passes_by = self.passes_by;
        let options = ProjectionOptions {
            max_iterations: PROJECTION_ITERATIONS,
            goal: GOAL.min(self.options.planarity_tolerance),
            tolerance: self.options.planarity_tolerance,
            phase: f64::INFINITY,
        };
        let mut projector = MinimumNorm::new(cholesky, matrix);
        let observe = |record: &Record| reporter.observe(record);
        let outcome = projector.project(&mut constraints, x, &options, observe);
        *dual = Some(projector.into_parts());
        outcome
    }
}

/// Projects positions in place.
fn projected(
    setting: &Setting<'_>,
    solvers: &mut Solvers,
    x: &mut [f64],
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Outcome {
    let projection = Projection {
        setting,
        assembly: &solvers.constraint_assembly,
        options,
        margin: Some(KEPT_CLEARANCE),
        passes_by: false,
    };
    let mut reporter = StepReporter::new(progress, "optimise", PROJECTION_ITERATIONS);
    projection.project(&mut solvers.constraints, x, &mut reporter)
}

fn way(outcome: Outcome) -> ResultOrigin {
    ResultOrigin {
        kind: StartKind::AsGiven,
        path: PathKind::Projection,
        in_parts: 0,
        outcome,
    }
}

impl Stage<'_> {
    /// Only projects a start.
    pub(crate) fn run_projection(
        &self,
        solvers: &mut Solvers,
        start: &Start,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Run {
        let setting = self.setting(&start.x);
        let mut x = start.x.clone();
        let outcome = projected(&setting, solvers, &mut x, options, progress);
        self.conclude(start.n_bad, x, way(outcome), options)
    }

    /// Only projects a start, in a region, whose constraints `solvers` are for.
    pub(crate) fn run_projection_of(
        &self,
        region: &PartRegion,
        solvers: &mut Solvers,
        start: &Start,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Run {
        let whole = self.setting(&start.x);
        let part = Part::of(&whole, region.clone(), &start.x);
        let (mut x, mut y) = (start.x.clone(), part.of_vertices(&start.x));
        let setting = part.setting(whole.mean_edge);
        let outcome = projected(&setting, solvers, &mut y, options, progress);
        region.write_back(&y, &mut x);
        self.conclude(start.n_bad, x, way(outcome), options)
    }

    /// Takes the fast path from a start; `None` if the result is outside limits.
    pub(crate) fn run_fast(
        &self,
        solvers: &mut Solvers,
        start: &Start,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Option<Run> {
        let setting = self.setting(&start.x);
        let mut problem =
            NearlyPlanar::new(&setting, &solvers.constraint_assembly, &start.x, options);
        if start.n_bad > 0 || problem.planarity() > FAST_START {
            return None;
        }
        let (cholesky, matrix) = solvers.constraints.take()?;
        let mut x = start.x.clone();
        let mut reporter = StepReporter::new(progress, "optimise", FAST_ITERATIONS);
        let rounding = 4.0 * f64::EPSILON * self.diagonal / setting.mean_edge;
        let limits = SchurOptions {
            max_iterations: FAST_ITERATIONS,
            tolerance: GOAL.min(options.planarity_tolerance).max(rounding),
            step_tolerance: FAST_STEP,
            phase: f64::INFINITY,
        };
        let mut solver = SchurSqp::new(cholesky, matrix);
        let observe = |record: &Record| reporter.observe(record);
        let outcome = solver.minimise(&mut problem, &mut x, &limits, observe);
        solvers.constraints = Some(solver.into_parts());
        let way = ResultOrigin {
            kind: StartKind::Circumcentres,
            path: PathKind::Fast,
            in_parts: 0,
            outcome,
        };
        let run = self.conclude(start.n_bad, x, way, options);
        let near = run.summary.quality.deviation_max <= self.limits.distance;
        let shape = FaceShapes::at(&self.panels, &run.x);
        let margins =
            ShapeLimits::new(&self.limits, &self.panels, &shape).margins(&self.panels, &shape);
        let fits = margins.iter().all(|c| *c >= 0.0);
        let good = near && fits && run.offenders.is_empty();
        (run.is_cancelled() || good).then_some(run)
    }
}
