//! What is tried at one place, and which of it is best.

use super::candidates::{candidates, distinct};
use super::chamfer::chamfered;
use super::draft::Draft;
use super::patch::{Built, Change, Patch};
use super::site::{LocalStep, Site, Whole};
use crate::optimise::EMPHASES;
use crate::progress::Progress;
use crate::quality::{Defect, Judgement, Merit, Shapes};
use phex_mesh::{HexMesh, VertexId};
use std::cmp::Ordering;

/// Share of a defect with which it counts as cured: nothing else is tried then.
const CURED: f64 = 0.99;
/// Depths of strips that take the place of folds, in largest distances that are allowed, and the
/// round of emphasis that makes their panels planar: those that are just deep enough in the first
/// one, deeper ones in the last, in which closeness makes them flatter again.
const STRIPS: [(f64, usize); 2] = [(0.75, 0), (1.2, EMPHASES - 1)];
/// Candidates that are tried again with all that the optimiser can do for them.
const IMPROVED: usize = 2;

/// A defect, and the patch around it.
pub(super) struct DefectPatch {
    pub defect: Defect,
    pub patch: Patch,
    /// Whether mild changes have failed there.
    pub wide: bool,
}

impl DefectPatch {
    /// The best candidate, if it is better than what there is, and how many were tried.
    pub fn best(
        &self,
        whole: &Whole,
        site: &Site<'_>,
        progress: &dyn Progress,
    ) -> (Option<Change>, usize) {
        self.tried(whole, site, progress, |trial, now| trial.best(now))
            .unwrap_or((None, 0))
    }

    /// The same panels with more weight on what they lack, if they are better for it.
    pub fn emphasised(
        &self,
        whole: &Whole,
        site: &Site<'_>,
        progress: &dyn Progress,
    ) -> Option<Change> {
        self.tried(whole, site, progress, |trial, now| {
            let same = trial.same(now);
            trial.is_less(&same).then(|| trial.change(&same))
        })?
    }

    /// All folds cut off, if the panels are better for it.
    pub fn chamfered(
        &self,
        whole: &Whole,
        site: &Site<'_>,
        progress: &dyn Progress,
    ) -> Option<Change> {
        self.tried(whole, site, progress, |trial, _| {
            let strips = STRIPS.into_iter().filter_map(|strip| trial.cut(strip));
            let best = strips
                .map(|settled| trial.improved(settled))
                .min_by(by_merit);
            best.filter(|best| trial.is_less(best))
                .map(|best| trial.change(&best))
        })?
    }

    fn tried<T>(
        &self,
        whole: &Whole,
        site: &Site<'_>,
        progress: &dyn Progress,
        what: impl FnOnce(PlaceTrial<'_>, Built) -> T,
    ) -> Option<T> {
        let now = self.patch.built(&self.patch.draft)?;
        let points = whole.points(&self.patch);
        let before = site.judged_part(&now.mesh, &now.counts, whole, &points);
        let trial = PlaceTrial {
            place: self,
            goal: before.amount(&now.counts) - CURED * self.defect.amount,
            before: &before,
            points,
            whole,
            site,
            progress,
        };
        Some(what(trial, now))
    }
}

/// A place where candidates are tried.
struct PlaceTrial<'a> {
    place: &'a DefectPatch,
    whole: &'a Whole,
    site: &'a Site<'a>,
    progress: &'a dyn Progress,
    /// The vertices of the surface that the patch is to cover.
    points: Vec<VertexId>,
    /// What the judge says of the patch as it is.
    before: &'a Judgement,
    /// Amount of defects with which that at the place is cured.
    goal: f64,
}

/// A candidate with planar panels.
struct Settled {
    judgement: Judgement,
    /// Whether the optimiser has done all that it can for it.
    is_improved: bool,
    draft: Draft,
    built: Built,
}

impl Settled {
    fn merit(&self) -> &Merit {
        &self.judgement.merit
    }

    fn amount(&self) -> f64 {
        self.judgement.amount(&self.built.counts)
    }
}

/// The better one first.
fn by_merit(a: &Settled, b: &Settled) -> Ordering {
    a.merit().total_cmp(b.merit())
}

impl PlaceTrial<'_> {
    fn best(&self, now: Built) -> (Option<Change>, usize) {
        let patch = &self.place.patch;
        let same = self.same(now);
        if self.place.defect.is_slight || same.amount() <= self.goal {
            return (self.is_less(&same).then(|| self.change(&same)), 1);
        }
        let mut settled = vec![same];
        let mut tried = 1;
        let others = candidates(patch, self.place.defect.needs_more, self.place.wide);
        let others = others.into_iter().map(|draft| (draft, LocalStep::Settle));
        for (draft, step) in self.cuts().into_iter().chain(others) {
            let Some(built) = patch.built(&draft) else {
                continue;
            };
            if self.progress.is_cancelled() {
                break;
            }
            tried += 1;
            let Some(next) = self.settled(draft, built, step) else {
                continue;
            };
            if self.is_cured(&next) && self.is_fair(&next.judgement) {
                return (Some(self.change(&next)), tried);
            }
            settled.push(next);
        }
        settled.sort_by(by_merit);
        settled.truncate(IMPROVED);
        let improved = settled.into_iter().map(|s| self.improved(s));
        let best = (improved.min_by(by_merit))
            .filter(|best| best.merit().is_better(&self.before.merit))
            .filter(|best| self.is_fair(&best.judgement));
        (best.map(|best| self.change(&best)), tried)
    }

    /// The panels as they are with more weight on what they lack.
    fn same(&self, now: Built) -> Settled {
        self.improved(Settled {
            judgement: self.before.clone(),
            is_improved: false,
            draft: self.place.patch.draft.clone(),
            built: now,
        })
    }

    fn is_less(&self, settled: &Settled) -> bool {
        settled.merit().is_less(&self.before.merit)
    }

    fn judged(&self, built: &Built, mesh: &HexMesh) -> Judgement {
        (self.site).judged_part(mesh, &built.counts, self.whole, &self.points)
    }

    fn made_planar(&self, built: &Built, step: LocalStep<'_>) -> Option<HexMesh> {
        let place = (self.whole, &self.points[..]);
        self.site.settled(built, place, step, self.progress)
    }

    fn is_cured(&self, next: &Settled) -> bool {
        next.amount() <= self.goal && next.merit().is_less(&self.before.merit)
    }

    /// No corner and no edge is worth a distance that no panel has, and no edge a corner.
    fn is_fair(&self, judgement: &Judgement) -> bool {
        let near = judgement.merit.off <= self.whole.findings.merit.off;
        match self.whole.yardstick.shapes {
            Shapes::Any => true,
            Shapes::Corners => near,
            Shapes::Sizes => near && judgement.sharp() <= self.before.sharp(),
        }
    }

    /// Folds of the defect, or of the whole patch, cut off, and what makes the panels planar.
    fn cuts(&self) -> Vec<(Draft, LocalStep<'_>)> {
        let patch = &self.place.patch;
        let strips = if self.place.wide {
            &STRIPS[..]
        } else {
            &STRIPS[..1]
        };
        let cuts = strips.iter().flat_map(|&(depth, round)| {
            let deepest = depth * self.site.judge.largest_distance();
            let cores = [Some(&patch.core[..]), None];
            let cuts = cores.map(|core| chamfered(&patch.draft, core, deepest));
            let cuts = distinct(cuts.into_iter().flatten()).into_iter();
            cuts.map(move |draft| (draft, LocalStep::Cut(round)))
        });
        cuts.collect()
    }

    /// All folds of the patch cut off by strips of a depth.
    fn cut(&self, (depth, round): (f64, usize)) -> Option<Settled> {
        let patch = &self.place.patch;
        let deepest = depth * self.site.judge.largest_distance();
        let draft = chamfered(&patch.draft, None, deepest)?;
        let built = patch.built(&draft)?;
        self.settled(draft, built, LocalStep::Cut(round))
    }

    /// A candidate made planar, and what the judge says of it.
    fn settled(&self, draft: Draft, built: Built, step: LocalStep<'_>) -> Option<Settled> {
        let mesh = self.made_planar(&built, step)?;
        Some(Settled {
            judgement: self.judged(&built, &mesh),
            is_improved: false,
            draft,
            built: built.with(mesh),
        })
    }

    /// A candidate with more weight on what it lacks, as long as it is better for it.
    fn improved(&self, mut next: Settled) -> Settled {
        let rounds = if next.is_improved { 0 } else { EMPHASES };
        for round in 0..rounds {
            let step = LocalStep::Improve(round, &next.judgement);
            let Some(mesh) = self.made_planar(&next.built, step) else {
                continue;
            };
            let judgement = self.judged(&next.built, &mesh);
            if judgement.merit.is_less(next.merit()) && self.is_fair(&judgement) {
                (next.judgement, next.built.mesh) = (judgement, mesh);
                if self.is_cured(&next) {
                    break;
                }
            }
        }
        next.is_improved = true;
        next
    }

    fn change(&self, settled: &Settled) -> Change {
        Change::new(&self.place.patch, &settled.draft, &settled.built)
    }
}
