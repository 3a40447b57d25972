//! Layout, optimiser and the repair loop for a lattice of one kind.

use super::draws::{Drawn, most_regular};
use super::field::{Field, FineSurface, Way, direction_options, finer_ground};
use super::judge::{Judge, Judged, Left};
use super::rounds::{Means, Repaired, Rounds};
use super::{Clock, PipelineError, RepairRound, folds, rim};
use crate::directions::guides::Cone;
use crate::ground::{Beyond, Ground};
use crate::layout::LayoutStatistics;
use crate::optimise::{Optimised, SurfaceTarget};
use crate::trim::Boundary;
use phex_mesh::TriangleSurface;

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
    let reach = judge.reach;
    let means = Means {
        judge,
        fine: &fine,
        target: &target,
    };
    let rounds = Rounds::new(means, placed.seeds, layout, clock)?;
    let Repaired {
        judged,
        factorisations,
        repairs,
    } = rounds.run(clock)?;
    let Judged {
        badness,
        mut result,
        mut left,
    } = judged;
    let mut invalid = badness.invalid;
    let cut = clock.timed("trim", || {
        folds::unfolded(&left, [reported, reach], options.boundary, invalid)
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
