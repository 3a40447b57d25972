//! One run: rising penalties from one start, then the projection.

use super::barrier::{Barrier, clearance};
use super::closeness::ClosenessWeights;
use super::energy::{PanelEnergy, Setting, Weights, deviation};
use super::inspect::{Offender, inspect};
use super::options::{OptimiseError, OptimiseOptions, PathKind, Solver, StartKind};
use super::panels::{Panels, Shape};
use super::path::Path;
use super::simple::{area, is_simple};
use super::solvers::Solvers;
use super::start::Start;
use super::{RunSummary, Stage};
use crate::progress::Progress;
use phex_numeric::{Assembly, Outcome, Status};

/// Area of a regular hexagon over the square of its edge.
const HEXAGON: f64 = 2.598_076_211_353_316;

/// Planarity up to which a mesh is projected without being optimised first.
const NEARLY_PLANAR: f64 = 1e-3;

/// What came of one start.
pub(super) struct Run {
    pub x: Vec<f64>,
    pub outcome: Outcome,
    pub offenders: Vec<Offender>,
    pub summary: RunSummary,
}

impl Run {
    pub fn is_cancelled(&self) -> bool {
        self.outcome.status == Status::Cancelled
    }
}

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
        let mut best = path.settle()?;
        if !path.is_over() && !best.is_planar(options) {
            best = better(best, path.project(options.least_clearance));
        }
        if !path.is_over() && best.is_planar(options) {
            best = path.finish(best)?;
        }
        if !path.is_over() && best.is_planar(options) && kind != StartKind::Local {
            best = path.retry(best)?;
        }
        let way = Way {
            kind,
            path: PathKind::Feasible,
            in_parts: path.in_parts,
            outcome: path.outcome,
        };
        Ok(self.conclude(start.n_bad, best, way, options))
    }

    /// Makes a mesh planar as it is: nothing if it is sound, a projection if that is enough, then the fast path, else the
    /// feasible one.
    pub fn run_as_given(
        &self,
        solvers: &mut Solvers,
        x: &[f64],
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        let start = self.start_at(x);
        let planarity = Shape::at(&self.panels, x).max_height() / self.panels.mean_edge(x);
        let by_barrier = options.solver == Solver::Barrier;
        let planar = planarity <= options.planarity_tolerance;
        if planarity <= NEARLY_PLANAR && (by_barrier || planar) {
            let run = self.run_projection(solvers, &start, options, progress);
            if run.offenders.is_empty() || run.is_cancelled() {
                return Ok(run);
            }
        }
        if by_barrier && self.holds.held.is_empty() {
            let kinked = self.kinked(&start);
            if let Some(run) = self.run_fast(solvers, &kinked, options, progress) {
                return Ok(run);
            }
        }
        self.run_from(solvers, x, options, progress)
    }

    /// Optimises a mesh from where it is.
    pub fn run_from(
        &self,
        solvers: &mut Solvers,
        x: &[f64],
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        let start = self.start_at(x);
        self.run(solvers, StartKind::AsGiven, &start, options, progress)
    }

    pub fn start_at(&self, x: &[f64]) -> Start {
        let shape = Shape::at(&self.panels, x);
        let simple = |f: &usize| is_simple(shape.face(&self.panels, *f));
        let n_bad = (0..self.panels.n_faces()).filter(|f| !simple(f)).count();
        Start {
            x: x.to_vec(),
            n_bad,
        }
    }

    /// Judges what a run has reached.
    pub fn conclude(
        &self,
        start_faults: usize,
        reached: Reached,
        way: Way,
        options: &OptimiseOptions,
    ) -> Run {
        let mut outcome = way.outcome;
        let deviation = deviation(&self.setting(&reached.x), &reached.x);
        let (quality, offenders) =
            inspect(&self.panels, &self.guard, &reached.x, deviation, options);
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
            x: reached.x,
            outcome,
            offenders,
            summary,
        }
    }
}

/// How a result came about.
pub(super) struct Way {
    pub kind: StartKind,
    pub path: PathKind,
    /// Factorisations for parts of the mesh alone.
    pub in_parts: usize,
    pub outcome: Outcome,
}

/// Positions and what they are judged by on the way.
pub(super) struct Reached {
    pub x: Vec<f64>,
    planarity: f64,
    clearance: f64,
}

impl Reached {
    pub fn at(setting: &Setting<'_>, x: Vec<f64>) -> Self {
        let shape = Shape::at(setting.panels, &x);
        let faces = 0..setting.panels.n_faces();
        let clearances = faces.map(|f| clearance(shape.face(setting.panels, f)));
        Self {
            planarity: shape.max_height() / setting.mean_edge,
            clearance: clearances.fold(f64::INFINITY, f64::min) / setting.panels.mean_edge(&x),
            x,
        }
    }

    pub fn is_planar(&self, options: &OptimiseOptions) -> bool {
        self.planarity <= options.planarity_tolerance
    }

    /// Whether a panel is squeezed so that a stronger barrier may do better.
    pub fn is_tight(&self, options: &OptimiseOptions) -> bool {
        const BLOCKED: f64 = 1.5;
        let margin = options.clearance_margin;
        self.clearance < margin || (!self.is_planar(options) && self.clearance < BLOCKED * margin)
    }
}

/// The planar one; of two planar ones that with more clearance.
pub(super) fn better(a: Reached, b: Reached) -> Reached {
    const PLANAR: f64 = 1e-12;
    let planar = [a.planarity <= PLANAR, b.planarity <= PLANAR];
    let second = match planar {
        [true, false] => false,
        [false, true] => true,
        [false, false] => b.planarity < a.planarity,
        [true, true] => b.clearance > a.clearance,
    };
    if second { b } else { a }
}

/// The energy with the weights of the options; `start` is the anchor.
pub(super) fn panel_energy<'a>(
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    start: &[f64],
    options: &OptimiseOptions,
) -> PanelEnergy<'a> {
    let barriers = barriers(setting.panels, start, options);
    PanelEnergy::new(setting, assembly, weights(options), barriers, start)
}

/// Weights of the energy, that of planarity 0.
pub(super) fn weights(options: &OptimiseOptions) -> Weights {
    Weights {
        planarity: 0.0,
        closeness: ClosenessWeights {
            vertex: options.vertex_closeness,
            centre: options.centre_closeness,
            rim: options.boundary_closeness,
        },
        fairness: options.fairness,
        anchor: options.anchor,
        corner: options.corner_closeness,
    }
}

/// Barriers in proportion to each panel's own area, so that graded meshes are treated alike everywhere.
pub(super) fn barriers(panels: &Panels, start: &[f64], options: &OptimiseOptions) -> Vec<Barrier> {
    let shape = Shape::at(panels, start);
    let areas: Vec<f64> = (0..panels.n_faces())
        .map(|f| area(shape.face(panels, f)).abs())
        .collect();
    let mean = areas.iter().sum::<f64>() / areas.len() as f64;
    let barrier = |&area: &f64| {
        let area = area.max(0.05 * mean);
        Barrier {
            weight: options.barrier * options.vertex_closeness * area / HEXAGON,
            reach: options.barrier_reach * area.sqrt(),
        }
    };
    areas.iter().map(barrier).collect()
}
