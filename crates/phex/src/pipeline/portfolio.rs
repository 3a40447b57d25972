//! The portfolio: ways of laying panels out, compared after a single pass; only the best is
//! searched.
//!
//! No single layout is best on every surface. A strongly anisotropic lattice follows the curvature
//! closely, a less anisotropic one has calmer panels, a seamless one changes its size smoothly
//! instead of by dislocations, and a brick wall has straight rows where the surface has a network
//! for them. By default one other lattice is laid out, and only where the first is far outside its
//! limits, or its search leaves something outside (then panels are smaller where the surface
//! bends), or where it is less regular than it could be; with [`Effort::Best`] all of them are,
//! side by side.

use super::attempt::{AttemptSummary, is_tight};
use super::domain::Ground;
use super::lattice::{Pass, pass};
use super::{
    Candidate, Clock, Effort, MeshOptions, MeshRun, Method, PipelineError, Statistics, brick_wall,
};
use crate::progress::{Event, Progress};
use crate::quality::Merit;
use phex_mesh::{PolygonSoup, TriangleSurface};
use rayon::prelude::*;
use std::sync::Mutex;

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
    ground: &'a Ground,
}

/// The best mesh of the portfolio, searched.
///
/// # Errors
/// If no member gives a mesh: what the first says.
pub(super) fn mesh_with_panels(
    (surface, panels): (&TriangleSurface, usize),
    ground: &Ground,
    options: &MeshOptions,
    mut clock: Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let progress = clock.progress;
    let task = Task {
        surface,
        panels,
        options,
        ground,
    };
    let mut members = match options.effort {
        Effort::Best => task.all(progress),
        _ => task.one_or_two(progress),
    }?;
    clock.unless_unwanted()?;
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
    clock.unless_unwanted()?;
    run.statistics.tried = tried;
    run.stages = clock.stages;
    Ok(run)
}

impl Task<'_> {
    fn searches(&self) -> bool {
        self.options.effort != Effort::Draft
    }

    /// The lattice of the options, and another where that may be better.
    fn one_or_two(&self, progress: &dyn Progress) -> Result<Vec<Member>, PipelineError> {
        let first = self.member(Candidate::first(&self.ground.options), progress)?;
        let mut members = vec![first];
        let mut other = members[0].summary.alternative(self.options);
        while let Some(candidate) = other.filter(|_| self.searches() && !progress.is_cancelled()) {
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
        let made = pass(self.ground, candidate.into(), &mut clock)?;
        let merit = made.judgement.merit;
        let summary = AttemptSummary {
            dislocations: made.layout.annihilation.kept,
            ..AttemptSummary::new(
                candidate,
                &made.mesh,
                merit,
                made.regular_possible,
                self.options,
            )
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
        let again = again.filter(|_| self.searches() && !first.1.is_within());
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
        if self.searches() && !clock.progress.is_cancelled() {
            let searched = pass.searched(self.ground, clock);
            pass.mesh = searched.mesh;
            clock.progress.preview("search", &|| pass.mesh.to_soup());
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
            orbits: None,
            unrepeated: None,
            outcome,
            statistics,
            stages: Vec::new(),
        };
        (run, merit)
    }

    fn wall(&self, candidate: Candidate, progress: &dyn Progress) -> Result<Member, PipelineError> {
        let clock = Clock::new(progress);
        let run = brick_wall::mesh_with_panels(self.surface, self.panels, self.options, clock)?;
        let merit = brick_wall::merit(&run, self.ground);
        Ok(Member {
            summary: AttemptSummary::new(candidate, &run.mesh, merit, false, self.options),
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

    fn wants_best(&self) -> bool {
        self.alone(|p| p.wants_best())
    }

    fn preview(&self, stage: &'static str, mesh: &dyn Fn() -> PolygonSoup) {
        self.alone(|p| p.preview(stage, mesh));
    }
}
