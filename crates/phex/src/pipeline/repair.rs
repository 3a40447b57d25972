//! Layout, optimiser and the repair loop for a lattice of one kind.

use super::cures::{Cures, Place};
use super::field::{Field, FineSurface, Way, direction_options, finer_ground};
use super::judge::{Badness, Judge, Judged, Left};
use super::{Clock, MeshOptions, PipelineError, RepairRound, folds, rim};
use crate::directions::guides::Cone;
use crate::ground::{Beyond, Ground};
use crate::layout::reseed::Neighbourhoods;
use crate::layout::seeds::Seed;
use crate::layout::{self, Layout, LayoutError, LayoutStatistics};
use crate::optimise::{self, Optimised, SurfaceTarget};
use phex_mesh::{TriangleSurface, VertexId};
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
/// panels more room.
const MAX_POLISHES: usize = 3;
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
    let mut seeds = field.placed.seeds.clone();
    let mut layout = clock.stage("layout", || calm_panels(&fine, &seeds))??;
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
    let mut result = whole(&layout, clock)?;
    let mut factorisations = count(&result);
    let mut repairs = Vec::new();
    let mut cures = Cures::default();
    let mut polished = 0;
    let mut best: Option<(Judged, Layout)> = None;
    // Whether only parts of the best have been optimised.
    let mut in_parts = false;
    let mut better_at = 0;
    loop {
        let places = result.mesh.positions.clone();
        let (judged, wrong) = judge.judged(&layout, result, clock)?;
        let (badness, panels) = (judged.badness, layout.mesh.topology().n_faces());
        if best.as_ref().is_none_or(|b| badness < b.0.badness) {
            best = Some((judged, layout.clone()));
            in_parts = !repairs.is_empty();
            better_at = repairs.len();
        }
        polished += usize::from(badness.invalid == 0);
        let stalled = repairs.len() - better_at >= PATIENCE;
        let over =
            polished > MAX_POLISHES || repairs.len() >= most_repairs(&badness, panels, options);
        if over || stalled || progress.is_cancelled() {
            break;
        }
        let ill = wrong.places(&layout, &fine.surface);
        let round = clock.timed("layout", || {
            next_round(&mut cures, ill, &mut seeds, &fine, &layout)
        });
        let Some(round) = round else { break };
        repairs.push(round);
        let Ok(next) = clock.timed("layout", || calm_panels(&fine, &seeds)) else {
            break;
        };
        let again = clock.timed("optimise", || {
            let earlier = (&layout, places.as_slice());
            optimise::optimise_again(&next, earlier, &target, &options.optimise, progress)
        })?;
        result = match again {
            Some(again) => again,
            None => whole(&next, clock)?,
        };
        factorisations += count(&result);
        layout = next;
    }
    let (mut judged, layout) = best.expect("the loop runs at least once");
    if in_parts && !progress.is_cancelled() {
        // Parts do not move what is around them: all together panels come out calmer.
        let result = whole(&layout, clock)?;
        factorisations += count(&result);
        let (all, _) = judge.judged(&layout, result, clock)?;
        if all.badness <= judged.badness {
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
    Ok(Attempt {
        invalid,
        planar: !badness.not_planar,
        layout: field.placed.statistics,
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

/// Rounds at the most for a layout of so many panels.
fn most_repairs(badness: &Badness, panels: usize, options: &MeshOptions) -> usize {
    match badness.invalid as f64 > HOPELESS * panels as f64 {
        true => FEW_REPAIRS,
        false => options.max_repairs,
    }
}

/// Factorisations of all runs.
fn count(result: &Optimised) -> usize {
    result.runs.iter().map(|r| r.factorisations).sum()
}

fn calm_panels(fine: &FineSurface, seeds: &[Seed]) -> Result<Layout, LayoutError> {
    layout::panelling(&fine.cells(), seeds).map(layout::calmed)
}
/// Takes back what did not help and changes the seeds where something is wrong; `None` if there is nothing left to do.
fn next_round(
    cures: &mut Cures,
    places: Vec<Place>,
    seeds: &mut Vec<Seed>,
    fine: &FineSurface,
    layout: &Layout,
) -> Option<RepairRound> {
    let (open, undone) = cures.take_back(places, seeds);
    let before = seeds.clone();
    let cells = fine.cells();
    cures.give(&open, &Neighbourhoods::new(&cells, &before), seeds);
    let lost = |a: &[Seed], b: &[Seed]| {
        let kept: HashSet<VertexId> = b.iter().map(|s| s.vertex).collect();
        a.iter().filter(|s| !kept.contains(&s.vertex)).count()
    };
    (cures.count() > 0).then(|| RepairRound {
        panels: layout.mesh.topology().n_faces(),
        dropped: lost(&before, seeds),
        added: lost(seeds, &before),
        places: cures.count(),
        undone,
    })
}
