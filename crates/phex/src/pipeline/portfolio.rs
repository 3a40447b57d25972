//! The portfolio: ways of laying panels out, compared after a single pass; only the best is
//! searched.
//!
//! No single layout is best on every surface. A strongly anisotropic lattice follows the curvature
//! closely, a less anisotropic one has calmer panels, a seamless one changes its size smoothly
//! instead of by dislocations, and a brick wall has straight rows where the surface has a network
//! for them. By default one other lattice is laid out, and only where the first is far outside its
//! limits, or its search leaves something outside (then panels are smaller where the surface
//! bends), or where it is less regular than it could be; with [`Method::Best`] all of them are,
//! side by side.

use super::domain::Ground;
use super::field::LatticeFreedom;
use super::lattice::{Pass, pass};
use super::{
    Candidate, Clock, MeshOptions, MeshRun, Method, PipelineError, Statistics, brick_wall,
};
use crate::progress::{Event, Progress};
use crate::quality::{Merit, USUAL_DEVIATION};
use phex_mesh::{HexMesh, TriangleSurface};
use rayon::prelude::*;
use serde::Serialize;
use std::sync::Mutex;

/// Excess over limits, in limits and summed over panels, that is left to the search.
const CURABLE: f64 = 2.0;

/// One member of the portfolio, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttemptSummary {
    /// How its panels were laid out.
    #[serde(flatten)]
    pub candidate: Candidate,
    /// Panels.
    pub panels: usize,
    /// What it is compared by.
    pub merit: Merit,
    /// Share of hexagons among the panels inside.
    pub hex: f64,
    /// Panels inside that are no hexagons, beyond those that the topology of a closed surface asks
    /// for.
    pub irregular: usize,
    /// Dislocations that the lattice kept.
    pub dislocations: usize,
    /// Whether a lattice could do without any irregular panel but those that topology asks for: on
    /// closed surfaces of Euler characteristic 0, and where the Gauss curvature is positive
    /// everywhere.
    pub regular_possible: bool,
    /// Least clearance, mean edges.
    pub clearance: f64,
    /// Least angle at a corner, degrees.
    pub least_angle: f64,
    /// Whether it is the one that was kept.
    pub kept: bool,
}

impl AttemptSummary {
    fn new(candidate: Candidate, mesh: &HexMesh, merit: Merit, regular_possible: bool) -> Self {
        let measures = phex_mesh::measure(mesh);
        let panels = mesh.topology().n_faces();
        let merit = match regular_possible {
            true => merit.regular_possible(measures.irregular as f64 / panels as f64),
            false => merit,
        };
        Self {
            candidate,
            panels,
            merit,
            hex: measures.hex.unwrap_or(1.0),
            irregular: measures.irregular,
            dislocations: 0,
            regular_possible,
            clearance: measures.clearance.min,
            least_angle: measures.angle.min,
            kept: false,
        }
    }

    /// What else is worth a try: a lattice without dislocations where one can be, or with sizes
    /// that resolve the surface where the options leave sizes free. `None` if this one is within
    /// limits and as regular as can be.
    fn alternative(&self, options: &MeshOptions) -> Option<Candidate> {
        let within = self.merit.is_within();
        let seamless = self.regular_possible && self.irregular > 0;
        let usual_deviation = !within && is_tight(options);
        let much = self.merit.invalid > 0.0 || self.merit.outside > CURABLE;
        let resolving = self.resolving(options).is_some() && much && !usual_deviation;
        (seamless || resolving || usual_deviation).then_some(Candidate {
            seamless: seamless && within,
            resolving,
            usual_deviation,
            ..self.candidate
        })
    }
}

impl AttemptSummary {
    /// The same with sizes that resolve the surface, where the options leave sizes free.
    fn resolving(&self, options: &MeshOptions) -> Option<Candidate> {
        let free = options.sizes.adaptive.is_none() && options.size_field.is_none();
        free.then_some(Candidate {
            resolving: true,
            ..self.candidate
        })
    }

    /// What the usual limit would have tried after this one, if it was laid out for that.
    fn after_usual(&self, options: &MeshOptions) -> Option<Candidate> {
        let limit = options.optimise.max_deviation.unwrap_or(USUAL_DEVIATION);
        let misses = self.merit.off * limit > USUAL_DEVIATION || self.merit.invalid > 0.0;
        let is_usual = self.candidate.usual_deviation && !self.candidate.resolving;
        self.resolving(options).filter(|_| is_usual && misses)
    }
}

/// Whether a largest deviation is asked for that is tighter than usual; in single precision the
/// usual one itself is a little less.
fn is_tight(options: &MeshOptions) -> bool {
    let limit = options.optimise.max_deviation;
    limit.is_some_and(|limit| limit < (1.0 - 1e-6) * USUAL_DEVIATION)
}

/// The kind of lattice that a candidate asks for.
fn way_of(candidate: Candidate) -> LatticeFreedom {
    LatticeFreedom {
        anisotropy: candidate.anisotropy,
        seamless: candidate.seamless,
        resolving: candidate.resolving,
        usual_deviation: candidate.usual_deviation,
    }
}

/// A member of the portfolio after its single pass.
struct Member {
    summary: AttemptSummary,
    made: AttemptMesh,
    clock: Vec<super::StageSeconds>,
}

enum AttemptMesh {
    Lattice(Box<Pass>),
    Wall(Box<MeshRun>),
}

/// What is made, of what, and how large, all normalised.
struct Task<'a> {
    surface: &'a TriangleSurface,
    panels: usize,
    options: &'a MeshOptions,
    ground: Ground,
}

/// The best mesh of the portfolio, searched.
///
/// # Errors
/// If no member gives a mesh: what the first says.
pub(super) fn mesh_with_panels(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    let mut clock = Clock::new(progress);
    let ground = clock.stage("target", || Ground::new(surface, panels, options))?;
    let task = Task {
        surface,
        panels,
        options,
        ground,
    };
    let mut members = match options.method {
        Method::Best => task.all(progress),
        _ => task.one_or_two(progress),
    }?;
    let best = (0..members.len()).reduce(|a, b| {
        let [first, second] = [a, b].map(|k| &members[k].summary.merit);
        // Of two that miss a tight limit the nearer one is better: it is no worse than what the
        // usual limit gives.
        let misses =
            is_tight(options) && first.invalid == second.invalid && first.off.max(second.off) > 1.0;
        let better = if misses {
            second.off < first.off
        } else {
            second.is_better(first)
        };
        if better { b } else { a }
    });
    let best = best.ok_or(PipelineError::Cancelled)?;
    members[best].summary.kept = true;
    let mut tried: Vec<AttemptSummary> = members.iter().map(|m| m.summary.clone()).collect();
    members.iter().for_each(|m| clock.add(&m.clock));
    let mut run = match members.swap_remove(best).made {
        AttemptMesh::Lattice(pass) => {
            let searched = task.searched(*pass, &mut clock);
            task.cured(searched, &mut tried, &mut clock).0
        }
        AttemptMesh::Wall(wall) => *wall,
    };
    run.statistics.tried = tried;
    run.stages = clock.stages;
    Ok(run)
}

impl Task<'_> {
    /// The lattice of the options, and another where that may be better.
    fn one_or_two(&self, progress: &dyn Progress) -> Result<Vec<Member>, PipelineError> {
        let first = self.member(Candidate::first(&self.ground.options), progress)?;
        let mut members = vec![first];
        let mut other = members[0].summary.alternative(self.options);
        while let Some(candidate) =
            other.filter(|_| self.options.search && !progress.is_cancelled())
        {
            let member = self.member(candidate, progress);
            other = member
                .as_ref()
                .ok()
                .and_then(|m| m.summary.after_usual(self.options));
            members.extend(member);
        }
        Ok(members)
    }

    /// All of them side by side.
    fn all(&self, progress: &dyn Progress) -> Result<Vec<Member>, PipelineError> {
        let one_at_a_time = OneAtATime(Mutex::new(()), progress);
        let first = Candidate::first(&self.ground.options);
        let others = self
            .options
            .portfolio
            .iter()
            .copied()
            .filter(|c| *c != first);
        let all: Vec<Candidate> = std::iter::once(first).chain(others).collect();
        let one = |c: &Candidate| self.member(*c, &one_at_a_time);
        let results: Vec<_> = all.par_iter().with_max_len(1).map(one).collect();
        let (mut members, mut errors) = (Vec::new(), Vec::new());
        for result in results {
            match result {
                Ok(member) => members.push(member),
                Err(error) => errors.push(error),
            }
        }
        match (members.is_empty(), errors.into_iter().next()) {
            (true, Some(error)) => Err(error),
            _ => Ok(members),
        }
    }

    fn member(
        &self,
        candidate: Candidate,
        progress: &dyn Progress,
    ) -> Result<Member, PipelineError> {
        match candidate.method {
            Method::BrickWall => self.wall(candidate, progress),
            _ => self.lattice(candidate, progress),
        }
    }

    fn lattice(
        &self,
        candidate: Candidate,
        progress: &dyn Progress,
    ) -> Result<Member, PipelineError> {
        let mut clock = Clock::new(progress);
        let made = pass(&self.ground, way_of(candidate), &mut clock)?;
        let merit = made.judgement.merit;
        let summary = AttemptSummary {
            dislocations: made.layout.annihilation.kept,
            ..AttemptSummary::new(candidate, &made.mesh, merit, made.regular_possible)
        };
        Ok(Member {
            summary,
            made: AttemptMesh::Lattice(Box::new(made)),
            clock: clock.stages,
        })
    }

    /// Where the search has left something outside limits, the other lattice that was not tried
    /// before, if it comes out better.
    fn cured(
        &self,
        first: (MeshRun, Merit),
        tried: &mut Vec<AttemptSummary>,
        clock: &mut Clock<'_>,
    ) -> (MeshRun, Merit) {
        let [only] = &mut tried[..] else {
            return first;
        };
        let again = only.resolving(self.options);
        let again = again.filter(|_| self.options.search && !first.1.is_within());
        let Some(candidate) = again.filter(|_| !clock.progress.is_cancelled()) else {
            return first;
        };
        let Ok(mut member) = self.member(candidate, clock.progress) else {
            return first;
        };
        clock.add(&member.clock);
        let AttemptMesh::Lattice(pass) = member.made else {
            return first;
        };
        let second = self.searched(*pass, clock);
        let is_better = second.1.is_better(&first.1);
        (only.kept, member.summary.kept) = (!is_better, is_better);
        tried.push(member.summary);
        if is_better { second } else { first }
    }

    /// The pass searched, as a run, and what it is compared by.
    fn searched(&self, mut pass: Pass, clock: &mut Clock<'_>) -> (MeshRun, Merit) {
        let mut found = None;
        if self.options.search && !clock.progress.is_cancelled() {
            let searched = pass.searched(&self.ground, clock);
            pass.mesh = searched.mesh;
            pass.judgement = searched.judgement;
            found = Some(searched.summary);
        }
        let merit = pass.judgement.merit;
        let runs = pass.optimised.runs.clone();
        let statistics = Statistics {
            layout: pass.layout,
            cones: pass.cones.clone(),
            factorisations: runs.iter().map(|r| r.factorisations).sum(),
            runs,
            search: found,
            ..Statistics::of(&self.ground.smooth, self.panels)
        };
        let (mesh, start) = (pass.mesh.clone(), pass.start.clone());
        let outcome = pass.optimised.outcome.clone();
        let surfaces = pass.into_surfaces();
        let run = MeshRun {
            start: Some(start),
            violations: clock.timed("validate", || surfaces.violations(&mesh)),
            mesh,
            target: surfaces.reported,
            beyond: surfaces.beyond,
            outcome,
            statistics,
            stages: Vec::new(),
        };
        (run, merit)
    }

    fn wall(&self, candidate: Candidate, progress: &dyn Progress) -> Result<Member, PipelineError> {
        let run = brick_wall::mesh_with_panels(self.surface, self.panels, self.options, progress)?;
        let merit = brick_wall::merit(&run, &self.ground);
        Ok(Member {
            summary: AttemptSummary::new(candidate, &run.mesh, merit, false),
            clock: run.stages.clone(),
            made: AttemptMesh::Wall(Box::new(run)),
        })
    }
}

/// Lets several runs speak to one listener.
struct OneAtATime<'a>(Mutex<()>, &'a dyn Progress);

impl OneAtATime<'_> {
    fn alone<T>(&self, talk: impl FnOnce(&dyn Progress) -> T) -> T {
        // A listener that panicked left nothing behind that could be half-done here.
        let _turn = self
            .0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        talk(self.1)
    }
}

impl Progress for OneAtATime<'_> {
    fn report(&self, event: &Event) {
        self.alone(|p| p.report(event));
    }

    fn is_cancelled(&self) -> bool {
        self.alone(|p| p.is_cancelled())
    }
}
