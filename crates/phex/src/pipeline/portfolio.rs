//! The portfolio: ways of laying panels out, compared after a single pass; only the best is
//! searched, and the next where that is not enough.
//!
//! No single layout is best on every surface. A strongly anisotropic lattice follows the curvature
//! closely, a less anisotropic one has calmer panels, a seamless one changes its size smoothly
//! instead of by dislocations, and a brick wall has straight rows where the surface has a network
//! for them. By default one other lattice is laid out, and only where the first is far outside its
//! limits, or its search leaves something outside (then panels are smaller where the surface bends,
//! and dislocations stay where strain pulls hard at them), or where it is less regular than it
//! could be. Of two the one with the smaller excess over limits is searched, what is broken counted
//! alike: of 12 hard bodies it was the better one each time. The other one is searched, too, where
//! that leaves a panel broken. With [`Effort::Best`] all of them are
//! laid out, side by side, and searched one after the other until one is within its limits.
//!
//! Where a tighter `max_deviation` than usual is missed all of this is done for the usual one too,
//! and what comes of it searched with the tight one: panels that can't be as near as asked for are
//! drawn hither and thither, and a mesh for a tight limit must not end farther off.

use super::attempt::{AttemptSummary, is_tight};
use super::domain::Ground;
use super::lattice::{Pass, pass};
use super::{Candidate, Clock, Effort, MeshOptions, MeshRun, Method, PipelineError, Statistics};
use crate::progress::{Event, Progress};
use crate::quality::{Merit, USUAL_DEVIATION};
use crate::ranges::without_unit;
use crate::search::SearchSummary;
use phex_mesh::PolygonSoup;
use rayon::prelude::*;
use std::sync::Mutex;

/// What is told where nothing was searched.
const HOPELESS: &str = "more than a third of the panels are invalid, and no local change was tried: they are too large for the surface, or another number of them is needed";

/// A member of the portfolio after its single pass.
struct Member {
    summary: AttemptSummary,
    made: Pass,
    clock: Vec<super::StageSeconds>,
}

/// A member, searched.
struct SearchedMember {
    /// Which of those that were tried it is.
    number: usize,
    made: Pass,
    merit: Merit,
    search: Option<SearchSummary>,
}

/// What is made, and on what, all normalised.
struct Task<'a> {
    options: &'a MeshOptions,
    ground: &'a Ground,
}

/// The best mesh of the portfolio, searched.
///
/// # Errors
/// If no member gives a mesh: what the first says.
pub(super) fn mesh_with_panels(
    ground: &Ground,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let progress = clock.progress;
    let task = Task { options, ground };
    let (mut found, mut tried) = task.best(clock)?;
    let misses = is_tight(options) && !found.merit.is_within();
    if misses && task.searches() && !progress.is_cancelled() {
        let options = &with_usual_deviation(options);
        let ground = &ground.again(options);
        let usual = Task { options, ground };
        if let Ok((other, others)) = usual.best(clock) {
            let mut other = task.searched(other, clock);
            other.number += tried.len();
            tried.extend(others.into_iter().map(AttemptSummary::for_usual_deviation));
            if other.merit.is_nearer(&found.merit) {
                found = other;
            }
        }
    }
    clock.unless_unwanted()?;
    tried[found.number].kept = true;
    let mut run = task.run(found);
    run.statistics.tried = tried;
    Ok(run)
}

/// The options with the usual largest deviation.
fn with_usual_deviation(options: &MeshOptions) -> MeshOptions {
    let mut usual = options.clone();
    usual.optimise.max_deviation = Some(without_unit(USUAL_DEVIATION));
    usual
}

impl Task<'_> {
    /// The best of the portfolio, searched, and all that were tried.
    fn best(
        &self,
        clock: &mut Clock<'_>,
    ) -> Result<(SearchedMember, Vec<AttemptSummary>), PipelineError> {
        let members = match self.options.effort {
            Effort::Best => self.all(clock.progress),
            _ => self.one_or_two(clock.progress),
        }?;
        clock.unless_unwanted()?;
        members.iter().for_each(|m| clock.add(&m.clock));
        let mut tried: Vec<AttemptSummary> = members.iter().map(|m| m.summary.clone()).collect();
        let mut left: Vec<(usize, Member)> = members.into_iter().enumerate().collect();
        let best = self.taken(&mut left).ok_or(PipelineError::Cancelled)?;
        let mut found = self.finished(best, clock);
        while let Some(next) = self.next(&found, &mut left, &mut tried, clock) {
            let other = self.finished(next, clock);
            if other.merit.is_better(&found.merit) {
                found = other;
            }
        }
        Ok((found, tried))
    }

    fn searches(&self) -> bool {
        self.options.effort != Effort::Draft
    }

    /// The lattice of the options, and another where that may be better.
    fn one_or_two(&self, progress: &dyn Progress) -> Result<Vec<Member>, PipelineError> {
        let first = self.member(Candidate::first(&self.ground.options), progress)?;
        let mut members = vec![first];
        let other = members[0].summary.alternative(self.options);
        if let Some(candidate) = other.filter(|_| self.searches() && !progress.is_cancelled()) {
            members.iter_mut().for_each(|m| m.made.surfaces.set_aside());
            members.extend(self.member(candidate, progress));
        }
        Ok(members)
    }

    /// All of them side by side.
    fn all(&self, progress: &dyn Progress) -> Result<Vec<Member>, PipelineError> {
        let one_at_a_time = OneAtATime(Mutex::new(()), progress);
        let first = Candidate::first(&self.ground.options);
        let others = self.options.portfolio.iter().copied();
        let others = first.resolving(self.options).into_iter().chain(others);
        let fits = |c: &Candidate| c.seamless || c.method == Method::BrickWall;
        let others = others.filter(|c| {
            let is_open = self.options.method == Method::Lattice;
            is_open && *c != first && (fits(c) || !self.options.regular)
        });
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
        let mut clock = Clock::new(progress);
        let made = pass(self.ground, candidate, &mut clock)?;
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
            made,
            clock: clock.stages,
        })
    }

    /// Takes the best of those that are left: of the best that needs no search, and the best of
    /// those that do, the one whose sizes jump less.
    fn taken(&self, left: &mut Vec<(usize, Member)>) -> Option<(usize, Member)> {
        let best_of = |needs_search: bool| {
            let merit = |k: usize| left[k].1.summary.before_search();
            let better = |a, b| match merit(b).is_better(&merit(a)) {
                true => b,
                false => a,
            };
            let fits = |k: &usize| left[*k].1.summary.merit.is_within() != needs_search;
            (0..left.len()).filter(fits).reduce(better)
        };
        let jumping = |k: usize| left[k].1.summary.outside_or_uneven();
        let best = match (best_of(false), best_of(true)) {
            (Some(within), Some(other)) if self.searches() && jumping(other) < jumping(within) => {
                other
            }
            (within, other) => within.or(other)?,
        };
        Some(left.remove(best))
    }

    /// What is searched next, where the search has left something outside limits: the other lattice
    /// if only one was tried; the best of those that are left with [`Effort::Best`], and where a
    /// panel is still broken or one of them is within limits as it is.
    fn next(
        &self,
        found: &SearchedMember,
        left: &mut Vec<(usize, Member)>,
        tried: &mut Vec<AttemptSummary>,
        clock: &mut Clock<'_>,
    ) -> Option<(usize, Member)> {
        if found.merit.is_within() || !self.searches() || clock.progress.is_cancelled() {
            return None;
        }
        let [only] = &tried[..] else {
            let is_there = left.iter().any(|(_, m)| m.summary.merit.is_within());
            let all = self.options.effort == Effort::Best || found.merit.invalid > 0.0 || is_there;
            return all.then(|| self.taken(left)).flatten();
        };
        let candidate = only.candidate.resolving(self.options)?;
        let member = self.member(candidate, clock.progress).ok()?;
        clock.add(&member.clock);
        tried.push(member.summary.clone());
        Some((1, member))
    }

    /// A member, searched unless there is no time.
    fn finished(&self, (number, member): (usize, Member), clock: &mut Clock<'_>) -> SearchedMember {
        let member = SearchedMember {
            number,
            made: member.made,
            merit: member.summary.merit,
            search: None,
        };
        match self.searches() && !clock.progress.is_cancelled() {
            true => self.searched(member, clock),
            false => member,
        }
    }

    /// A member searched with the limits of this task.
    fn searched(&self, mut member: SearchedMember, clock: &mut Clock<'_>) -> SearchedMember {
        let found = member.made.searched(self.ground, clock);
        member.made.mesh = found.mesh;
        let mesh = &member.made.mesh;
        clock.progress.preview("search", &|| mesh.to_soup());
        if found.summary.is_hopeless {
            let message = HOPELESS.to_owned();
            clock.progress.report(&Event::Note { message });
        }
        member.merit = found.judgement.merit;
        member.search = Some(found.summary);
        member
    }

    /// A member as a run.
    fn run(&self, member: SearchedMember) -> MeshRun {
        let Pass {
            mesh,
            start,
            optimised,
            surfaces,
            ..
        } = member.made;
        let mut statistics = Statistics {
            layout: member.made.layout,
            brick_wall: member.made.brick_wall,
            cones: member.made.cones,
            search: member.search,
            ..Statistics::of(&self.ground.smooth, self.ground.asked)
        };
        statistics.add(optimised.run);
        MeshRun {
            start: Some(start),
            wished: surfaces.areas().wished(&mesh),
            beyond: surfaces.beyond,
            ..MeshRun::new(mesh, surfaces.reported, optimised.outcome, statistics)
        }
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
