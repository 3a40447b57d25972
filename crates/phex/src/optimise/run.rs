//! One run: rising penalties from one start, then the projection.

use super::barrier::{Barrier, clearance};
use super::closeness::ClosenessWeights;
use super::energy::{PanelEnergy, Setting, Weights, deviation};
use super::inspect::{Offender, inspect};
use super::options::{OptimiseError, OptimiseOptions, PathKind, Solver, StartKind};
use super::panels::{Panels, Shape};
use super::shortcut::Projection;
use super::simple::{area, is_simple};
use super::solvers::{Dual, Reporter, Solvers};
use super::start::Start;
use super::{RunSummary, Stage};
use crate::progress::Progress;
use phex_numeric::{Assembly, DampedOptions, DampedSolver, Damping, Outcome, Status};

/// Area of a regular hexagon over the square of its edge.
const HEXAGON: f64 = 2.598_076_211_353_316;

/// Factor of the barriers of panels that have come out with too little clearance.
const STRONGER: f64 = 4.0;

/// Hold on the start that never keeps panels from becoming planar.
const WEAK_HOLD: f64 = 1e-4;

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

    /// Whether there is no reason to try another start.
    pub fn is_good(&self, options: &OptimiseOptions, diagonal: f64) -> bool {
        let quality = &self.summary.quality;
        self.offenders.is_empty()
            && quality.clearance >= options.clearance_margin
            && quality.deviation_max <= options.good_deviation * diagonal
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
        path.descend_all();
        let mut best = path.project(options.clearance_margin);
        if !path.is_over() && !best.is_planar(options) && path.loosen(&start.x) {
            path.descend_all();
            best = better(best, path.project(options.clearance_margin));
        }
        if !path.is_over() && best.is_tight(options) {
            best = better(best, path.strengthen());
        }
        if !path.is_over() && !best.is_planar(options) {
            best = better(best, path.insist());
        }
        if !path.is_over() && !best.is_planar(options) {
            best = better(best, path.project(options.least_clearance));
        }
        let way = Way {
            kind,
            path: PathKind::Feasible,
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
        let faulty = offenders.chunk_by(|a, b| a.face == b.face).count() as f64;
        // Valid first, then close, then clear.
        let score = f64::from(u8::from(!planar)) * 100.0
            + 10.0 * faulty
            + quality.deviation_max / (2e-3 * self.diagonal)
            + 0.1 / quality.clearance.max(1e-3);
        let summary = RunSummary {
            start: way.kind,
            path: way.path,
            start_faults,
            status: outcome.status,
            iterations: outcome.iterations,
            factorisations: outcome.factorisations,
            offenders: offenders.len(),
            quality,
            score,
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
    pub outcome: Outcome,
}

/// Positions and what they are judged by on the way.
pub(super) struct Reached {
    x: Vec<f64>,
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

    fn is_planar(&self, options: &OptimiseOptions) -> bool {
        self.planarity <= options.planarity_tolerance
    }

    /// Whether a panel is squeezed so that a stronger barrier may do better.
    fn is_tight(&self, options: &OptimiseOptions) -> bool {
        const BLOCKED: f64 = 1.5;
        let margin = options.clearance_margin;
        self.clearance < margin || (!self.is_planar(options) && self.clearance < BLOCKED * margin)
    }
}

/// The planar one; of two planar ones that with more clearance.
fn better(a: Reached, b: Reached) -> Reached {
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

/// The way from one start: the positions, the energy, and everything that is handed on from phase to phase.
struct Path<'a> {
    setting: &'a Setting<'a>,
    options: &'a OptimiseOptions,
    energy: PanelEnergy<'a>,
    minimiser: &'a mut DampedSolver,
    dual: &'a mut Option<Dual>,
    constraint_assembly: &'a Assembly,
    reporter: Reporter<'a>,
    damping: Damping,
    outcome: Outcome,
    x: Vec<f64>,
}

impl<'a> Path<'a> {
    fn new(
        setting: &'a Setting<'a>,
        solvers: &'a mut Solvers,
        start: &[f64],
        options: &'a OptimiseOptions,
        progress: &'a dyn Progress,
    ) -> Result<Self, OptimiseError> {
        let limit =
            options.penalties.len() * options.max_iterations + options.projection_iterations;
        let (assembly, minimiser) = solvers.energy.prepare(setting.panels)?;
        Ok(Self {
            energy: panel_energy(setting, assembly, start, options),
            minimiser,
            dual: &mut solvers.constraints,
            constraint_assembly: &solvers.constraint_assembly,
            setting,
            options,
            reporter: Reporter::new(progress, limit),
            damping: Damping::default(),
            outcome: Outcome::empty(Status::Converged),
            x: start.to_vec(),
        })
    }

    fn is_over(&self) -> bool {
        self.outcome.status == Status::Cancelled
    }

    /// All phases.
    fn descend_all(&mut self) {
        let options = self.options;
        options.penalties.iter().for_each(|&w| self.descend(w));
    }

    /// Weakens a strong hold on the start, which may keep panels from becoming planar, and goes back there; false if it is weak
    /// already.
    fn loosen(&mut self, start: &[f64]) -> bool {
        let strong = self.energy.weights.anchor > WEAK_HOLD;
        if strong {
            self.energy.weights.anchor = WEAK_HOLD;
            self.damping = Damping::default();
            self.x.copy_from_slice(start);
        }
        strong
    }

    /// One phase: minimises the energy with a weight of planarity.
    fn descend(&mut self, penalty: f64) {
        if self.is_over() {
            return;
        }
        self.energy.weights.planarity = penalty;
        self.energy.arm(&self.x);
        let phase = DampedOptions {
            max_iterations: self.options.max_iterations,
            energy_tolerance: self.options.energy_tolerance,
            step_tolerance: self.options.step_tolerance,
            phase: penalty,
        };
        let reporter = &mut self.reporter;
        let outcome = self.minimiser.minimise(
            &mut self.energy,
            &mut self.x,
            &mut self.damping,
            &phase,
            |record| reporter.observe(record),
        );
        self.outcome.append(outcome);
    }

    /// Projects a copy of the positions onto the planarity constraints.
    fn project(&mut self, margin: f64) -> Reached {
        let mut x = self.x.clone();
        if !self.is_over() {
            let projection = Projection {
                setting: self.setting,
                assembly: self.constraint_assembly,
                options: self.options,
                margin,
            };
            let outcome = projection.project(self.dual, &mut x, &mut self.reporter);
            self.outcome.append(outcome);
        }
        Reached::at(self.setting, x)
    }

    /// Goes on with higher penalties where the projection has not arrived.
    fn insist(&mut self) -> Reached {
        let last = self.options.penalties.iter().copied().fold(1.0, f64::max);
        self.descend(10.0 * last);
        self.descend(100.0 * last);
        self.project(self.options.clearance_margin)
    }

    /// Repeats the last two phases with stronger barriers of the panels that have come out tight.
    fn strengthen(&mut self) -> Reached {
        const TIGHT: f64 = 1.5;
        let panels = self.setting.panels;
        let shape = Shape::at(panels, &self.x);
        let limit = TIGHT * self.options.clearance_margin * panels.mean_edge(&self.x);
        for (f, barrier) in self.energy.barriers.iter_mut().enumerate() {
            if clearance(shape.face(panels, f)) < limit {
                barrier.weight *= STRONGER;
            }
        }
        let penalties = &self.options.penalties;
        for &penalty in &penalties[penalties.len().saturating_sub(2)..] {
            self.descend(penalty);
        }
        self.project(self.options.clearance_margin)
    }
}

/// The energy with the weights of the options; `start` is the anchor.
pub(super) fn panel_energy<'a>(
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    start: &[f64],
    options: &OptimiseOptions,
) -> PanelEnergy<'a> {
    let weights = Weights {
        planarity: 0.0,
        closeness: ClosenessWeights {
            vertex: options.vertex_closeness,
            centre: options.centre_closeness,
            rim: options.boundary_closeness,
        },
        fairness: options.fairness,
        anchor: options.anchor,
        corner: options.corner_closeness,
    };
    let barriers = barriers(setting.panels, start, options);
    PanelEnergy::new(setting, assembly, weights, barriers, start)
}

/// Barriers in proportion to each panel's own area, so that graded meshes are treated alike everywhere.
fn barriers(panels: &Panels, start: &[f64], options: &OptimiseOptions) -> Vec<Barrier> {
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
