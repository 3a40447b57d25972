//! The rounds of the repair loop: seeds change where something is wrong, and panels are laid out, optimised and judged again.

use super::cures::{Cures, Place};
use super::field::FineSurface;
use super::judge::{Badness, Judge, Judged, Wrong};
use super::{Clock, MeshOptions, PipelineError, RepairRound};
use crate::layout::Layout;
use crate::layout::reseed::Neighbourhoods;
use crate::layout::seeds::Seed;
use crate::optimise::{self, Again, Known, Optimised, SurfaceTarget};
use phex_mesh::{TriangleSurface, Vec3, VertexId};
use std::collections::HashSet;

/// Rounds of the repair loop at the most on a mesh that is valid: they add panels where the surface stands off, or give tight
/// panels more room. More where features are to be resolved.
const MAX_POLISHES: usize = 3;
const MAX_RESOLVING: usize = 8;
/// Rounds that may come to nothing one after the other.
const PATIENCE: usize = 6;
/// Share of invalid panels above which they are too large for the surface, and rounds after which that is known.
const HOPELESS: f64 = 0.1;
const FEW_REPAIRS: usize = 2;

/// What rounds are made with.
pub(super) struct Means<'a> {
    pub judge: Judge<'a>,
    pub fine: &'a FineSurface,
    pub target: &'a SurfaceTarget<'a>,
}

/// A mesh after the last round.
pub(super) struct Repaired {
    pub judged: Judged,
    /// Factorisations of all rounds.
    pub factorisations: usize,
    pub repairs: Vec<RepairRound>,
}

/// The repair loop between two rounds.
pub(super) struct Rounds<'a> {
    means: Means<'a>,
    /// See [`is_apart`].
    apart: bool,
    seeds: Vec<Seed>,
    cures: Cures,
    /// Places that are wrong.
    ill: Vec<Place>,
    /// What is to be cured, with all that helped: the best there is, in places that were optimised apart.
    known: Known,
    best: (Judged, Layout),
    /// Whether only parts of the best have been optimised, and whether it is what is known.
    in_parts: bool,
    is_known: bool,
    is_valid: bool,
    /// Panels of the last round.
    panels: usize,
    /// Rounds at the most, rounds with a valid mesh, and the last one that made something better.
    most: usize,
    polished: usize,
    better_at: usize,
    factorisations: usize,
    repairs: Vec<RepairRound>,
}

impl<'a> Rounds<'a> {
    /// The loop before its first round, with the layout optimised and judged.
    pub fn new(
        means: Means<'a>,
        seeds: Vec<Seed>,
        layout: Layout,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let first = means.whole(&layout, clock)?;
        let factorisations = count(&first);
        let known = Known::of(&layout, first.mesh.positions.as_slice());
        let (judged, wrong) = means.judge.judged(&layout, first, clock)?;
        let panels = layout.mesh.topology().n_faces();
        let apart = is_apart(&means.fine.surface, means.judge.options);
        Ok(Self {
            apart,
            seeds,
            cures: Cures::new(apart),
            ill: wrong.places(&layout, &means.fine.surface),
            known,
            in_parts: false,
            is_known: true,
            is_valid: judged.badness.invalid == 0,
            panels,
            most: most_repairs(&judged.badness, panels, means.judge.options),
            polished: 0,
            better_at: 0,
            factorisations,
            repairs: Vec::new(),
            best: (judged, layout),
            means,
        })
    }

    /// Runs until nothing is wrong, or nothing helps.
    pub fn run(mut self, clock: &mut Clock<'_>) -> Result<Repaired, PipelineError> {
        while !self.is_over(clock) && self.round(clock)? {}
        if !self.is_known && !clock.progress.is_cancelled() {
            self.take_known(clock)?;
        }
        if self.in_parts && !clock.progress.is_cancelled() {
            self.all_together(clock)?;
        }
        Ok(Repaired {
            judged: self.best.0,
            factorisations: self.factorisations,
            repairs: self.repairs,
        })
    }

    fn is_over(&mut self, clock: &Clock<'_>) -> bool {
        self.polished += usize::from(self.is_valid);
        let stalled = self.repairs.len() - self.better_at >= PATIENCE;
        let enough = self.polished > most_polishes(self.means.judge.options);
        stalled || enough || self.repairs.len() >= self.most || clock.progress.is_cancelled()
    }

    /// Changes seeds and judges what comes of it; `false` if there is nothing to change, or no mesh with it.
    fn round(&mut self, clock: &mut Clock<'_>) -> Result<bool, PipelineError> {
        let Some(round) = clock.timed("layout", || self.reseeded()) else {
            return Ok(false);
        };
        self.repairs.push(round);
        let Ok(next) = clock.timed("layout", || self.means.fine.calm_panels(&self.seeds)) else {
            return Ok(false);
        };
        let again = self.again(&next, clock)?;
        let Again { result, unsettled } = match again {
            Some(again) if self.apart || again.unsettled.is_empty() => again,
            _ => Again {
                result: self.means.whole(&next, clock)?,
                unsettled: Vec::new(),
            },
        };
        self.factorisations += count(&result);
        let found = Known::of(&next, result.mesh.positions.as_slice());
        let failed: Vec<Vec3> = unsettled.iter().map(|f| next.face_point[*f]).collect();
        // What can't be trimmed is no better than what there is.
        let Ok((judged, wrong)) = self.means.judge.judged(&next, result, clock) else {
            return Ok(false);
        };
        self.compare(next, judged, &wrong, found, &failed);
        Ok(true)
    }

    /// Changes the seeds where something is wrong; `None` if there is nothing left to do.
    fn reseeded(&mut self) -> Option<RepairRound> {
        let before = self.seeds.clone();
        let cells = self.means.fine.cells();
        let around = Neighbourhoods::new(&cells, &before);
        self.cures.give(&self.ill, &around, &mut self.seeds);
        let lost = |a: &[Seed], b: &[Seed]| {
            let kept: HashSet<VertexId> = b.iter().map(|s| s.vertex).collect();
            a.iter().filter(|s| !kept.contains(&s.vertex)).count()
        };
        (self.cures.count() > 0).then(|| RepairRound {
            panels: self.panels,
            dropped: lost(&before, &self.seeds),
            added: lost(&self.seeds, &before),
            places: self.cures.count(),
            undone: 0,
        })
    }

    /// Judges the cures by what is wrong now, and keeps the mesh if it is the best.
    fn compare(
        &mut self,
        next: Layout,
        judged: Judged,
        wrong: &Wrong,
        found: Known,
        failed: &[Vec3],
    ) {
        self.panels = next.mesh.topology().n_faces();
        let now = wrong.places(&next, &self.means.fine.surface);
        let is_better = judged.badness < self.best.0.badness;
        let verdict = self.cures.judge(&self.ill, now, failed, &mut self.seeds);
        if let Some(round) = self.repairs.last_mut() {
            round.undone = verdict.undone.len();
        }
        if is_better || (self.apart && !verdict.helped.is_empty()) {
            self.better_at = self.repairs.len();
        }
        if self.apart {
            self.known = found.with(&self.known, |p| verdict.is_undone(p));
            self.is_known = verdict.undone.is_empty() && is_better;
            self.is_valid = verdict.open.iter().all(Place::is_valid);
        } else {
            self.known = found;
            self.is_valid = judged.badness.invalid == 0;
            self.most = most_repairs(&judged.badness, self.panels, self.means.judge.options);
        }
        self.ill = verdict.open;
        if is_better {
            self.best = (judged, next);
            self.in_parts = true;
        }
    }

    /// What is known, optimised and judged; kept if it is better than the best.
    fn take_known(&mut self, clock: &mut Clock<'_>) -> Result<(), PipelineError> {
        let Ok(last) = clock.timed("layout", || self.means.fine.calm_panels(&self.seeds)) else {
            return Ok(());
        };
        let Some(again) = self.again(&last, clock)? else {
            return Ok(());
        };
        self.factorisations += count(&again.result);
        let judged = self.means.judge.judged(&last, again.result, clock);
        let better = |j: &Judged| j.badness < self.best.0.badness;
        if let Some(judged) = judged.ok().map(|j| j.0).filter(better) {
            self.best = (judged, last);
            self.in_parts = true;
        }
        Ok(())
    }

    /// Parts do not move what is around them: all together panels come out calmer.
    fn all_together(&mut self, clock: &mut Clock<'_>) -> Result<(), PipelineError> {
        let (best, layout) = &mut self.best;
        let result = self.means.whole(layout, clock)?;
        self.factorisations += count(&result);
        let all = self.means.judge.judged(layout, result, clock);
        let no_worse = |all: &Judged| all.badness <= best.badness;
        if let Some(all) = all.ok().map(|all| all.0).filter(no_worse) {
            *best = all;
        }
        Ok(())
    }

    /// What has changed since it was known, optimised.
    fn again(
        &self,
        layout: &Layout,
        clock: &mut Clock<'_>,
    ) -> Result<Option<Again>, PipelineError> {
        let &Means {
            ref judge, target, ..
        } = &self.means;
        let (options, progress) = (&judge.options.optimise, clock.progress);
        let again = || optimise::optimise_again(layout, &self.known, target, options, progress);
        Ok(clock.timed("optimise", again)?)
    }
}

impl Means<'_> {
    /// All panels, optimised.
    fn whole(&self, layout: &Layout, clock: &mut Clock<'_>) -> Result<Optimised, PipelineError> {
        let (options, progress) = (&self.judge.options.optimise, clock.progress);
        let made = || optimise::optimise(layout, self.target, options, progress);
        Ok(clock.timed("optimise", made)?)
    }
}

/// Whether places are cured apart from each other, panels included. A change at a boundary shifts panels all along it, and uniform panels are soon right, with
/// all of them together.
fn is_apart(surface: &TriangleSurface, options: &MeshOptions) -> bool {
    let closed = surface.topology().boundary_loops().is_empty();
    closed && options.sizes.adaptive.is_some()
}

/// Rounds at the most for a layout of so many panels.
fn most_repairs(badness: &Badness, panels: usize, options: &MeshOptions) -> usize {
    match badness.invalid as f64 > HOPELESS * panels as f64 {
        true => FEW_REPAIRS,
        false => options.max_repairs,
    }
}

fn most_polishes(options: &MeshOptions) -> usize {
    match options.sizes.adaptive {
        Some(_) => MAX_RESOLVING,
        None => MAX_POLISHES,
    }
}

/// Factorisations of all runs.
fn count(result: &Optimised) -> usize {
    result.runs.iter().map(|r| r.factorisations).sum()
}
