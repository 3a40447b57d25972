//! The feasible path from one start: phases of rising penalties, and what is tried where they do
//! not lead to planar panels.

use super::endgame::{RIGIDITY, minimise_on_constraints};
use super::energy::{PanelEnergy, Weights};
use super::parts::{Cuts, LARGE, Part, finish_in_parts, minimise_in_parts};
use super::reached::{Reached, ResultOrigin, better};
use super::shortcut::Projection;
use super::solvers::{Dual, Solvers, StepReporter};
use crate::optimise::error::OptimiseError;
use crate::optimise::options::{
    KEPT_CLEARANCE, NEWTON_ITERATIONS, OptimiseOptions, PENALTIES, PROJECTION_ITERATIONS, PathKind,
    StartKind,
};
use crate::optimise::panels::FaceShapes;
use crate::optimise::targets::reference::Reference;
use crate::optimise::terms::barrier::{Barrier, barriers, clearance};
use crate::optimise::terms::setting::{Setting, deviation};
use crate::progress::Progress;
use phex_numeric::{Assembly, DampedOptions, DampedSolver, Damping, Outcome, Status};

/// Factor of the barriers of tight panels where the projection has not arrived, and the clearance
/// over the one that is kept below which they are tight.
const STRONGER: f64 = 4.0;
const TIGHT: f64 = 1.5;

/// Iterations of Newton's method on the constraints there.
const INSISTING: usize = 12;

/// Hold on the start that never keeps panels from becoming planar.
const WEAK_HOLD: f64 = 1e-4;

/// Weight of planarity of the first phase for a mesh that is kept close to itself: with less weight
/// it is at its minimum already.
const FIRST_PENALTY: f64 = 1e3;
/// Bending, in mean edges, that the projection takes away without long steps, and phases beyond the
/// last one that may lead there, each with ten times the weight: what parts leave are waves longer
/// than they are, which a projection of the whole turns into long steps.
const BENT: f64 = 1e-4;
const STIFFER: usize = 2;
/// Share of the bending at the start that is left after such a phase where the hold on the start is
/// too strong.
const STUBBORN: f64 = 0.5;

/// Deviation, in mean edges, that a minimum may always have at its farthest point.
const STILL_NEAR: f64 = 0.02;

/// The positions, the energy, and everything that is handed on from phase to phase.
pub(in crate::optimise) struct Path<'a> {
    pub setting: &'a Setting<'a>,
    pub options: &'a OptimiseOptions,
    descent: Descent<'a>,
    dual: &'a mut Option<Dual>,
    constraint_assembly: &'a Assembly,
    pub reporter: StepReporter<'a>,
    pub outcome: Outcome,
    /// Factorisations for parts of the mesh alone.
    in_parts: usize,
    pub weights: Weights,
    pub barriers: Vec<Barrier>,
    pub start: &'a [f64],
    x: Vec<f64>,
    phases: usize,
}

/// Makes the energies of parts.
fn of_parts(
    barriers: &[Barrier],
    start: &[f64],
    weights: Weights,
) -> impl for<'b> Fn(&'b Setting<'b>, &'b Assembly, &Part<'_>) -> PanelEnergy<'b> + Sync {
    move |setting, assembly, part| {
        let anchor = part.of_vertices(start);
        PanelEnergy::new(setting, assembly, weights, part.of_faces(barriers), &anchor)
    }
}

/// How a phase is minimised.
enum Descent<'a> {
    /// All vertices at once.
    Whole(Box<WholeDescent<'a>>),
    /// One part of a large mesh after the other.
    Parts,
}

struct WholeDescent<'a> {
    energy: PanelEnergy<'a>,
    minimiser: &'a mut DampedSolver,
    damping: Damping,
}

impl<'a> Path<'a> {
    pub fn new(
        setting: &'a Setting<'a>,
        solvers: &'a mut Solvers,
        start: &'a [f64],
        options: &'a OptimiseOptions,
        progress: &'a dyn Progress,
    ) -> Result<Self, OptimiseError> {
        let limit = PENALTIES.len() * options.max_iterations + PROJECTION_ITERATIONS;
        let barriers = barriers(setting.panels, start, options);
        let weights = Weights::of(options, setting);
        let descent = if setting.panels.n_faces() > LARGE {
            Descent::Parts
        } else {
            let (assembly, minimiser) = solvers.energy.prepare(setting.panels)?;
            Descent::Whole(Box::new(WholeDescent {
                energy: PanelEnergy::new(setting, assembly, weights, barriers.clone(), start),
                minimiser,
                damping: Damping::default(),
            }))
        };
        Ok(Self {
            descent,
            dual: &mut solvers.constraints,
            constraint_assembly: &solvers.constraint_assembly,
            setting,
            options,
            reporter: StepReporter::new(progress, "optimise", limit),
            outcome: Outcome::empty(Status::Converged),
            in_parts: 0,
            weights,
            barriers,
            start,
            x: start.to_vec(),
            phases: 0,
        })
    }

    /// The energy of all panels, whose solvers must have room for the terms that are set. Meshes in
    /// parts do without.
    pub fn energy(&mut self) -> Option<&mut PanelEnergy<'a>> {
        match &mut self.descent {
            Descent::Whole(whole) => Some(&mut whole.energy),
            Descent::Parts => None,
        }
    }

    /// How a result from a kind of start came about.
    pub(crate) fn way(self, kind: StartKind) -> ResultOrigin {
        ResultOrigin {
            kind,
            path: PathKind::Feasible,
            in_parts: self.in_parts,
            outcome: self.outcome,
        }
    }

    pub fn is_over(&self) -> bool {
        self.outcome.status == Status::Cancelled
    }

    /// All phases from the start and the projection, once more with a weak hold on the start if a
    /// strong one keeps panels from becoming planar.
    pub(crate) fn arrive(&mut self) -> Result<Reached, OptimiseError> {
        let gives_way = self.descend_all()?;
        let held = gives_way.then(|| self.project(Some(KEPT_CLEARANCE)));
        let is_done = |held: &Reached| held.is_planar(self.options);
        if self.is_over() || held.as_ref().is_some_and(is_done) || !self.loosen() {
            return Ok(held.unwrap_or_else(|| self.project(Some(KEPT_CLEARANCE))));
        }
        self.descend_loosened()?;
        let free = self.project(Some(KEPT_CLEARANCE));
        Ok(match held {
            Some(held) => better(held, free, self.options),
            None => free,
        })
    }

    /// All phases; false if they were broken off because the hold on the start does not let panels
    /// become planar.
    fn descend_all(&mut self) -> Result<bool, OptimiseError> {
        let bent = self.bending();
        let is_strong = self.weights.anchor > WEAK_HOLD;
        let rests = self.starts_at_rest();
        let from = if rests { FIRST_PENALTY } else { 0.0 };
        for &penalty in PENALTIES.iter().filter(|w| **w >= from) {
            self.descend(penalty)?;
            let counts = rests && is_strong && penalty >= FIRST_PENALTY && !self.is_over();
            if counts && self.bending() > STUBBORN * bent {
                return Ok(false);
            }
        }
        self.stiffen()?;
        Ok(true)
    }

    /// All phases with a weak hold on the start; from rest the highest penalty at once, and once
    /// more where it has ended early: a weak hold and less weight on planarity may lead rows to
    /// where they turn round, and few panels hinder all others. Parts of a mesh, of which each
    /// rests on its neighbours, come there sooner by phases.
    fn descend_loosened(&mut self) -> Result<(), OptimiseError> {
        let is_whole = matches!(self.descent, Descent::Whole(_));
        if !(is_whole && self.starts_at_rest()) {
            return self.descend_all().map(|_| ());
        }
        let bent = self.bending();
        self.descend_last(1)?;
        if self.bending() > STUBBORN * bent {
            self.descend_last(1)?;
        }
        Ok(())
    }

    /// Goes on with higher penalties where a mesh that is minimised in parts is still bent.
    fn stiffen(&mut self) -> Result<(), OptimiseError> {
        let limit = BENT * self.setting.mean_edge;
        let in_parts = matches!(self.descent, Descent::Parts);
        let mut left = if in_parts { STIFFER } else { 0 };
        while left > 0 && !self.is_over() && self.bending() > limit {
            self.descend(10.0 * self.weights.planarity)?;
            left -= 1;
        }
        Ok(())
    }

    /// Whether the start is the minimum of everything but planarity: that of a mesh that is kept
    /// close to itself, unless vertices are held or drawn elsewhere.
    fn starts_at_rest(&self) -> bool {
        let holds = self.setting.holds;
        matches!(self.setting.reference, Reference::Start { .. })
            && holds.anchors.is_empty()
            && holds.held.is_empty()
    }

    /// Largest distance of a corner to its face's plane.
    fn bending(&self) -> f64 {
        FaceShapes::at(self.setting.panels, &self.x).max_height()
    }

    /// Weakens a strong hold on the start, which may keep panels from becoming planar, and goes
    /// back there; false if it is weak already.
    fn loosen(&mut self) -> bool {
        let strong = self.weights.anchor > WEAK_HOLD;
        if strong {
            self.weights.anchor = WEAK_HOLD;
            self.restart();
        }
        strong
    }

    /// Goes back to the start.
    fn restart(&mut self) {
        self.x.copy_from_slice(self.start);
        if let Descent::Whole(whole) = &mut self.descent {
            whole.damping = Damping::default();
        }
    }

    /// Counts factorisations of parts by themselves.
    fn count_parts(&mut self, outcome: &mut Outcome) {
        if matches!(self.descent, Descent::Parts) {
            self.in_parts += std::mem::take(&mut outcome.factorisations);
        }
    }

    /// One phase: minimises the energy with a weight of planarity.
    fn descend(&mut self, penalty: f64) -> Result<(), OptimiseError> {
        if self.is_over() {
            return Ok(());
        }
        self.weights.planarity = penalty;
        let limits = self.options.phase(penalty);
        let mut outcome = match &mut self.descent {
            Descent::Whole(whole) => whole.minimise(
                self.weights,
                &self.barriers,
                &mut self.x,
                &limits,
                &mut self.reporter,
            ),
            Descent::Parts => minimise_in_parts(
                self.setting,
                of_parts(&self.barriers, self.start, self.weights),
                &mut self.x,
                &Cuts::of_phase(self.phases),
                &limits,
                &mut self.reporter,
            )?,
        };
        self.count_parts(&mut outcome);
        self.phases += 1;
        self.outcome.append(outcome);
        Ok(())
    }

    /// The last `count` phases from `x`, the projection, and the minimum on the constraints.
    /// Whether that is better is for the caller to say.
    pub fn again(&mut self, x: &[f64], count: usize) -> Result<Vec<f64>, OptimiseError> {
        self.x.copy_from_slice(x);
        self.descend_last(count)?;
        let projected = self.project(Some(KEPT_CLEARANCE));
        let finished = self.minimised(&projected)?;
        Ok(finished
            .filter(|now| now.is_planar(self.options))
            .unwrap_or(projected)
            .x)
    }

    fn descend_last(&mut self, count: usize) -> Result<(), OptimiseError> {
        let last = &PENALTIES[PENALTIES.len().saturating_sub(count)..];
        last.iter().try_for_each(|&w| self.descend(w))?;
        self.stiffen()
    }

    /// Projects a copy of the positions onto the planarity constraints, with a clearance to keep,
    /// or wherever it leads.
    pub fn project(&mut self, margin: Option<f64>) -> Reached {
        let mut x = self.x.clone();
        if !self.is_over() {
            let projection = Projection {
                setting: self.setting,
                assembly: self.constraint_assembly,
                options: self.options,
                margin,
                passes_by: true,
            };
            let outcome = projection.project(self.dual, &mut x, &mut self.reporter);
            self.outcome.append(outcome);
        }
        Reached::at(self.setting, x)
    }

    /// Iterations of Newton's method on the constraints at the most.
    pub fn newton_iterations(&self) -> usize {
        let by_default = match (&self.setting.reference, &self.descent) {
            (Reference::Start { .. }, Descent::Whole(_)) => NEWTON_ITERATIONS,
            // Part by part the places near cuts lose room by it.
            (Reference::Start { .. }, Descent::Parts) | (Reference::Surface(_), _) => 0,
        };
        self.options.newton_iterations.unwrap_or(by_default)
    }

    /// Begins again without limits, since planar panels come before them.
    pub fn insist(&mut self) -> Result<Reached, OptimiseError> {
        self.weights.limits = 0.0;
        self.weights.closeness.limit.elastic.weight = 0.0;
        match self.starts_at_rest() {
            true => self.insist_by_phases(),
            false => self.insist_by_penalties(),
        }
    }

    /// From rest all phases, where the highest penalty at once was not enough. Newton's method on
    /// the constraints goes on, whose steps cost the least energy, where the projection's are the
    /// shortest.
    fn insist_by_phases(&mut self) -> Result<Reached, OptimiseError> {
        self.restart();
        self.descend_all()?;
        self.minimise_on_constraints(INSISTING)
    }

    /// All phases with stronger barriers of the panels that have come out tight, and two more.
    fn insist_by_penalties(&mut self) -> Result<Reached, OptimiseError> {
        let panels = self.setting.panels;
        let shape = FaceShapes::at(panels, &self.x);
        let limit = TIGHT * KEPT_CLEARANCE * panels.mean_edge(&self.x);
        for (f, barrier) in self.barriers.iter_mut().enumerate() {
            if clearance(shape.face(panels, f)) < limit {
                barrier.weight *= STRONGER;
            }
        }
        self.restart();
        self.descend_all()?;
        let last = PENALTIES.into_iter().fold(0.0, f64::max);
        self.descend(10.0 * last)?;
        self.descend(100.0 * last)?;
        Ok(self.project(Some(KEPT_CLEARANCE)))
    }

    /// The minimum on the constraints, from planar positions. They stand if that comes to nothing,
    /// or if a vertex or panel would stand off the surface more than any does now (and more than is
    /// near): what counts is the sum, and one panel may have to pay.
    pub fn finish(&mut self, reached: Reached) -> Result<Reached, OptimiseError> {
        let Some(now) = self.minimised(&reached)? else {
            return Ok(reached);
        };
        let farthest = |x: &[f64]| deviation(self.setting, x).0;
        let limit = farthest(&reached.x).max(STILL_NEAR * self.setting.mean_edge);
        let better = !self.is_over() && now.is_planar(self.options) && farthest(&now.x) <= limit;
        Ok(if better { now } else { reached })
    }

    /// Minimises on the constraints, from planar positions, if there are iterations for it.
    fn minimised(&mut self, reached: &Reached) -> Result<Option<Reached>, OptimiseError> {
        let most = self.newton_iterations();
        if self.is_over() || most == 0 || !reached.is_planar(self.options) {
            return Ok(None);
        }
        self.x.copy_from_slice(&reached.x);
        self.minimise_on_constraints(most).map(Some)
    }

    /// Minimises on the constraints from where the positions are, with `most` iterations at the
    /// most, and projects what is left.
    fn minimise_on_constraints(&mut self, most: usize) -> Result<Reached, OptimiseError> {
        let weights = Weights {
            planarity: RIGIDITY,
            ..self.weights
        };
        let mut outcome = match &mut self.descent {
            Descent::Whole(whole) => {
                whole.energy.weights = weights;
                whole.energy.barriers.copy_from_slice(&self.barriers);
                let system = whole.minimiser.lend();
                let assembly = self.constraint_assembly;
                let energy = &mut whole.energy;
                let x = &mut self.x;
                let observe = |record: &_| self.reporter.observe(record);
                minimise_on_constraints(energy, assembly, system, x, most, observe)
            }
            Descent::Parts => finish_in_parts(
                self.setting,
                of_parts(&self.barriers, self.start, weights),
                &mut self.x,
                &Cuts::of_phase(self.phases),
                most,
                &mut self.reporter,
            )?,
        };
        self.count_parts(&mut outcome);
        self.outcome.append(outcome);
        Ok(self.project(Some(KEPT_CLEARANCE)))
    }
}

impl WholeDescent<'_> {
    fn minimise(
        &mut self,
        weights: Weights,
        barriers: &[Barrier],
        x: &mut [f64],
        limits: &DampedOptions,
        reporter: &mut StepReporter<'_>,
    ) -> Outcome {
        self.energy.weights = weights;
        self.energy.barriers.copy_from_slice(barriers);
        self.energy.arm(x);
        let observe = |record: &_| reporter.observe(record);
        self.minimiser
            .minimise(&mut self.energy, x, &mut self.damping, limits, observe)
    }
}
