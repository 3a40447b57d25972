//! Layout, optimiser and the repair loop for a lattice of one kind.

use super::cures::{Cures, Place};
use super::draws::{Drawn, most_regular};
use super::field::{Field, FineSurface, Way, direction_options, finer_ground};
use super::judge::{Badness, Judge, Judged, Left};
use super::{Clock, MeshOptions, PipelineError, RepairRound, folds, rim};
use crate::directions::guides::Cone;
use crate::ground::{Beyond, Ground};
use crate::layout::reseed::Neighbourhoods;
use crate::layout::seeds::Seed;
use crate::layout::{Layout, LayoutStatistics};
use crate::optimise::{self, Known, Optimised, SurfaceTarget};
use crate::trim::Boundary;
use phex_mesh::{TriangleSurface, Vec3, VertexId};
use std::collections::HashSet;

/// A panelling made in one way.
pub(super) struct Attempt {
    /// Panels that are not as they should be.
    pub invalid: usize,
    pub planar: bool,
    pub layout: LayoutStatistics,
    /// Cones of the direction field, normalised.
    pub cones: Vec<Cone>,
    /// See [`Field::regular_possible`].
    pub regular_possible: bool,
    pub result: Optimised,
    pub left: Left,
    pub reported: TriangleSurface,
    pub beyond: Option<Beyond>,
    pub factorisations: usize,
    pub repairs: Vec<RepairRound>,
}

/// Rounds of the repair loop at the most on a mesh that is valid: they add panels where the surface stands off, or give tight
/// panels more room. More where features are to be resolved.
const MAX_POLISHES: usize = 3;
const MAX_RESOLVING: usize = 8;
/// Rounds that may come to nothing one after the other.
const PATIENCE: usize = 6;
/// Share of invalid panels above which they are too large for the surface, and rounds after which that is known.
const HOPELESS: f64 = 0.1;
const FEW_REPAIRS: usize = 2;

/// Layout, optimiser and the repair loop for a lattice of one kind.
pub(super) fn attempt(
    ground: &Ground,
    way: Way,
    clock: &mut Clock<'_>,
) -> Result<Attempt, PipelineError> {
    let (options, progress) = (&way.options(&ground.options), clock.progress);
    let settings = direction_options(options, way.anisotropy);
    let finer = match way.seamless {
        true => finer_ground(ground, options, &settings, clock)?,
        false => None,
    };
    let plain = || (ground, ground.field_level(options));
    let (ground, level) = finer.as_ref().map_or_else(plain, |(g, l)| (g, *l));
    let field = Field::new(ground, level, options, &settings, clock)?;
    let fine = FineSurface::new(ground, &field);
    let Drawn { placed, layout } = most_regular(ground, &field, |s| fine.calm_panels(s), clock)?;
    let mut seeds = placed.seeds;
    let target = SurfaceTarget::new(ground.close_to(&fine.surface));
    let reported = ground.reported(&fine.surface);
    let beyond = ground.beyond(&fine.surface);
    let judge = Judge {
        ground,
        fine: &fine.surface,
        reported,
        reach: beyond.as_ref().map_or(reported, |b| &b.smooth),
        options,
    };
    let whole = |layout: &Layout, clock: &mut Clock<'_>| {
        let made = || optimise::optimise(layout, &target, &options.optimise, progress);
        clock.timed("optimise", made)
    };
    let first = whole(&layout, clock)?;
    let mut factorisations = count(&first);
    let mut repairs: Vec<RepairRound> = Vec::new();
    let apart = is_apart(&fine.surface, options);
    let mut cures = Cures::new(apart);
    let mut polished = 0;
    // What is to be cured, with all that helped: the best there is, in places that were optimised apart.
    let mut known = Known::of(&layout, first.mesh.positions.as_slice());
    let (judged, wrong) = judge.judged(&layout, first, clock)?;
    let mut panels = layout.mesh.topology().n_faces();
    let mut most = most_repairs(&judged.badness, panels, options);
    let mut is_valid = judged.badness.invalid == 0;
    let mut ill = wrong.places(&layout, &fine.surface);
    let mut best = (judged, layout);
    // Whether only parts of the best have been optimised, and whether it is what is known.
    let mut in_parts = false;
    let mut is_known = true;
    let mut better_at = 0;
    loop {
        polished += usize::from(is_valid);
        let stalled = repairs.len() - better_at >= PATIENCE;
        let over = polished > most_polishes(options) || repairs.len() >= most;
        if over || stalled || progress.is_cancelled() {
            break;
        }
        let round = clock.timed("layout", || {
            next_round(&mut cures, &ill, &mut seeds, &fine, panels)
        });
        let Some(round) = round else { break };
        repairs.push(round);
        let Ok(next) = clock.timed("layout", || fine.calm_panels(&seeds)) else {
            break;
        };
        let again = clock.timed("optimise", || {
            optimise::optimise_again(&next, &known, &target, &options.optimise, progress)
        })?;
        let (result, unsettled) = match again {
            Some(again) if apart || again.unsettled.is_empty() => (again.result, again.unsettled),
            _ => (whole(&next, clock)?, Vec::new()),
        };
        factorisations += count(&result);
        let found = Known::of(&next, result.mesh.positions.as_slice());
        let failed: Vec<Vec3> = unsettled.iter().map(|f| next.face_point[*f]).collect();
        // What can't be trimmed is no better than what there is.
        let Ok((judged, wrong)) = judge.judged(&next, result, clock) else {
            break;
        };
        panels = next.mesh.topology().n_faces();
        let now = wrong.places(&next, &fine.surface);
        let is_better = judged.badness < best.0.badness;
        let verdict = cures.judge(&ill, now, &failed, &mut seeds);
        if let Some(round) = repairs.last_mut() {
            round.undone = verdict.undone.len();
        }
        if is_better || (apart && !verdict.helped.is_empty()) {
            better_at = repairs.len();
        }
        if apart {
            known = found.with(&known, |p| verdict.is_undone(p));
            is_known = verdict.undone.is_empty() && is_better;
            is_valid = verdict.open.iter().all(Place::is_valid);
        } else {
            known = found;
            is_valid = judged.badness.invalid == 0;
            most = most_repairs(&judged.badness, panels, options);
        }
        ill = verdict.open;
        if is_better {
            best = (judged, next);
            in_parts = true;
        }
    }
    if !is_known && !progress.is_cancelled() {
        let last = clock.timed("layout", || fine.calm_panels(&seeds));
        if let Ok(last) = last {
            let again = clock.timed("optimise", || {
                optimise::optimise_again(&last, &known, &target, &options.optimise, progress)
            })?;
            if let Some(again) = again {
                factorisations += count(&again.result);
                let judged = judge.judged(&last, again.result, clock);
                let better = judged.ok().filter(|j| j.0.badness < best.0.badness);
                if let Some((judged, _)) = better {
                    best = (judged, last);
                    in_parts = true;
                }
            }
        }
    }
    let (mut judged, layout) = best;
    if in_parts && !progress.is_cancelled() {
        // Parts do not move what is around them: all together panels come out calmer.
        let result = whole(&layout, clock)?;
        factorisations += count(&result);
        let all = judge.judged(&layout, result, clock);
        let better = all.ok().filter(|all| all.0.badness <= judged.badness);
        if let Some((all, _)) = better {
            judged = all;
        }
    }
    let Judged {
        badness,
        mut result,
        mut left,
    } = judged;
    let mut invalid = badness.invalid;
    let cut = clock.timed("trim", || {
        folds::unfolded(&left, [reported, judge.reach], options.boundary, invalid)
    });
    if let Some(cut) = cut {
        (left, invalid) = cut;
    }
    let held = clock.timed("optimise", || {
        rim::to_boundary(&mut left, reported, options, progress)
    })?;
    result.runs.extend(held);
    if left.is_sound() && options.boundary != Boundary::Whole {
        invalid = phex_mesh::small_rim_faces(&left.trimmed.mesh).len();
    }
    Ok(Attempt {
        invalid,
        planar: !badness.not_planar,
        layout: placed.statistics,
        cones: field.cones(&ground.smooth),
        regular_possible: field.regular_possible(&ground.smooth),
        result,
        left,
        reported: reported.clone(),
        beyond,
        factorisations,
        repairs,
    })
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

/// Changes the seeds where something is wrong; `None` if there is nothing left to do.
fn next_round(
    cures: &mut Cures,
    ill: &[Place],
    seeds: &mut Vec<Seed>,
    fine: &FineSurface,
    panels: usize,
) -> Option<RepairRound> {
    let before = seeds.clone();
    let cells = fine.cells();
    cures.give(ill, &Neighbourhoods::new(&cells, &before), seeds);
    let lost = |a: &[Seed], b: &[Seed]| {
        let kept: HashSet<VertexId> = b.iter().map(|s| s.vertex).collect();
        a.iter().filter(|s| !kept.contains(&s.vertex)).count()
    };
    (cures.count() > 0).then(|| RepairRound {
        panels,
        dropped: lost(&before, seeds),
        added: lost(seeds, &before),
        places: cures.count(),
        undone: 0,
    })
}
