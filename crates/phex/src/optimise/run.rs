//! One run: rising penalties from one start, then the projection.

use super::error::OptimiseError;
use super::inspect::{Offender, OptimisedFigures, inspect};
use super::options::{OptimiseOptions, Solver, StartKind};
use super::panels::FaceShapes;
use super::simple::crossed;
use super::solver::emphasis::{EMPHASES, FREE_TURN};
use super::solver::path::Path;
use super::solver::reached::{ResultOrigin, Run, better};
use super::solver::solvers::Solvers;
use super::solver::start::{Start, kinked};
use super::terms::setting::{Setting, deviation, distances};
use super::terms::shape_limits::ShapeLimits;
use super::{RunSummary, Stage};
use crate::progress::Progress;
use phex_mesh::ValidateOptions;
use phex_numeric::Status;

/// Planarity up to which a mesh is projected without being optimised first.
const NEARLY_PLANAR: f64 = 1e-3;

impl Stage<'_> {
    /// The stage at given positions.
    pub fn setting(&self, x: &[f64]) -> Setting<'_> {
        Setting {
            panels: &self.panels,
            reference: &self.reference,
            guard: &self.guard,
            rim: &self.rim,
            corner: &self.corner,
            holds: &self.holds,
            areas: &self.areas,
            limits: &self.limits,
            mean_edge: self.panels.mean_edge(x),
        }
    }

    /// Optimises one start along the feasible path.
    pub fn run(
        &self,
        solvers: &mut Solvers,
        kind: StartKind,
        start: &Start,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        if options.solver == Solver::Tetrahedra {
            return self.run_tetrahedra(solvers, kind, start, options, progress);
        }
        let setting = self.setting(&start.x);
        let mut path = Path::new(&setting, solvers, &start.x, options, progress)?;
        let mut best = path.arrive()?;
        // A place that is tried in other ways is not worth a second run.
        let insists = kind != StartKind::Local && !path.is_over();
        if insists && !best.is_planar(options) {
            best = better(best, path.insist()?, options);
            if !path.is_over() && !best.is_planar(options) {
                best = better(
                    best,
                    path.project(Some(ValidateOptions::CLEARANCE)),
                    options,
                );
            }
        }
        // A few panels stand in the way. The others become planar without regard to them, and the
        // search, which follows a layout, repairs these.
        if !path.is_over() && !best.is_planar(options) && kind == StartKind::SmoothedCells {
            best = better(best, path.project(None), options);
        }
        if !path.is_over() && best.is_planar(options) {
            best = path.finish(best)?;
        }
        Ok(self.conclude(start.n_bad, best.x, path.way(kind), options))
    }

    /// Makes a mesh planar as it is: nothing if it is sound, a projection if that is enough, then
    /// the fast path, else the feasible one.
    pub(crate) fn run_as_given(
        &self,
        solvers: &mut Solvers,
        x: &[f64],
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        let start = self.start_at(x);
        let planarity = FaceShapes::at(&self.panels, x).max_height() / self.panels.mean_edge(x);
        let by_barrier = options.solver == Solver::Barrier;
        let planar = planarity <= options.planarity_tolerance;
        if planarity <= NEARLY_PLANAR && (by_barrier || planar) {
            let run = self.run_projection(solvers, &start, options, progress);
            if run.offenders.is_empty() || run.is_cancelled() {
                return Ok(run);
            }
        }
        if by_barrier && self.holds.held.is_empty() {
            let kinked = kinked(self.topology, &self.panels, &self.guard, &start);
            if let Some(run) = self.run_fast(solvers, &kinked, options, progress) {
                return Ok(run);
            }
        }
        self.run_from(solvers, x, options, progress)
    }

    /// Optimises a mesh from where it is.
    pub(crate) fn run_from(
        &self,
        solvers: &mut Solvers,
        x: &[f64],
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        let start = self.start_at(x);
        let mut best = self.run(solvers, StartKind::AsGiven, &start, options, progress)?;
        // What the paper's formulation comes to is left as it is.
        let rounds = match options.solver {
            Solver::Barrier => EMPHASES,
            Solver::Tetrahedra => 0,
        };
        for round in 0..rounds {
            let lack = self.lack(&best);
            if lack == (0, 0.0) || best.is_cancelled() || progress.is_cancelled() {
                break;
            }
            let mut now = self.emphasised(&best.x, (round, FREE_TURN), options, progress)?;
            if now.summary.quality.planarity <= options.planarity_tolerance
                && self.lack(&now) < lack
            {
                now.summary.start_faults = best.summary.start_faults;
                best = now;
            }
        }
        Ok(best)
    }

    /// What is wrong with a mesh, and by how much it is beyond its limits.
    fn lack(&self, run: &Run) -> (usize, f64) {
        let setting = self.setting(&run.x);
        let shape = FaceShapes::at(&self.panels, &run.x);
        let limits = ShapeLimits::new(&self.limits, &self.panels, &shape);
        let margins = limits.margins(&self.panels, &shape).into_iter();
        let off = distances(&setting, &run.x).into_iter();
        let margins = margins.chain(off.map(|d| 1.0 - d / self.limits.distance));
        let beyond = margins.map(|c| c.min(0.0).powi(2)).sum();
        (run.offenders.len(), beyond)
    }

    pub(crate) fn start_at(&self, x: &[f64]) -> Start {
        let shape = FaceShapes::at(&self.panels, x);
        Start {
            x: x.to_vec(),
            n_bad: crossed(&self.panels, &shape).len(),
        }
    }

    /// Figures of positions as they are, and what is wrong with them.
    pub(crate) fn inspected(
        &self,
        x: &[f64],
        options: &OptimiseOptions,
    ) -> (OptimisedFigures, Vec<Offender>) {
        let deviation = deviation(&self.setting(x), x);
        inspect(&self.panels, &self.guard, x, deviation, options)
    }

    /// Judges what a run has reached.
    pub(crate) fn conclude(
        &self,
        start_faults: usize,
        x: Vec<f64>,
        way: ResultOrigin,
        options: &OptimiseOptions,
    ) -> Run {
        let mut outcome = way.outcome;
        let (quality, offenders) = self.inspected(&x, options);
        let planar = quality.planarity <= options.planarity_tolerance;
        if planar && outcome.status != Status::Cancelled {
            outcome.status = Status::Converged;
        }
        let summary = RunSummary {
            start: way.kind,
            path: way.path,
            start_faults,
            status: outcome.status,
            iterations: outcome.iterations,
            factorisations: outcome.factorisations,
            part_factorisations: way.in_parts,
            offenders: offenders.len(),
            quality,
        };
        Run {
            x,
            outcome,
            offenders,
            summary,
        }
    }
}
