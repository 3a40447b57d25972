//! Panels of the best of four fields: opposite cones that are far apart may cancel, or stay; rows
//! may run across small holes, or round them; and sizes may change until no dislocation is needed.
//!
//! A pair of cones costs two irregular panels. Without it panels of a smooth roof are hardly less
//! even, and those of a body whose curvature comes in lumps are. Rows round a small hole want cones
//! near it, towards which panels shrink, and a hole with room for them wants such rows. A shallow
//! vault without dislocations has panels as even as with them, and a vase has not. Which of these
//! it is shows in the panels as they are laid out, or in their metric already.

use super::clock::StageSeconds;
use super::domain::Ground;
use super::field::{Directed, Field, FineSurface, allow_sizes};
use super::restarts::{Drawn, restarts};
use super::{Clock, MeshOptions, PipelineError};
use crate::directions::FAR_REACH;
use crate::directions::cones::has_opposites;
use crate::directions::holes::has_small_holes;
use crate::layout::seeds::Seed;
use crate::progress::{Progress, Quiet};
use rayon::prelude::*;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// A field, the surface on which its cells are drawn, and the panels of its own seeds.
pub(super) struct FieldPanels {
    pub field: Field,
    pub fine: FineSurface,
    pub first: Drawn,
}

/// A field that may be better than that of the options.
struct Other {
    options: MeshOptions,
    is_unwanted: AtomicBool,
}

/// What came of it.
#[derive(Default)]
struct MadeOther {
    /// What is not liked of its sizes, whatever its panels.
    least: f64,
    /// Whether some of its cones could cancel; none if it was given up before.
    has_opposites: Option<bool>,
    is_laid_out: bool,
    /// None if they are not better.
    panels: Option<FieldPanels>,
    stages: Vec<StageSeconds>,
}

impl FieldPanels {
    /// Those of the field of the options, or of another one where it can be had and the panels are
    /// better for it.
    pub fn better(
        ground: &Ground,
        level: usize,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let directions = &options.directions;
        let is_given = directions.cancel_reach.is_some() || !directions.guides.cones.is_empty();
        if is_given || restarts(ground) <= 1 {
            return Self::new(ground, level, options, clock);
        }
        // Others are begun where a thread is idle, and end as soon as they are not wanted.
        let others = Other::all(options);
        let [far, _, all] = &others;
        let (limit, progress) = (OnceLock::new(), clock.progress);
        let near = || {
            let field = Field::new(ground, level, options, clock);
            let has = |wanted: &dyn Fn(&Field) -> bool| field.as_ref().is_ok_and(wanted);
            far.unless(
                !directions.mirrors.is_empty()
                    || has(&|f| f.has_opposites(ground, FAR_REACH) || f.has_small_holes(ground)),
            );
            all.unless(has(&|f| f.has_opposites(ground, f64::INFINITY)));
            let near = field.and_then(|field| Self::of(ground, field, clock));
            match &near {
                Ok(near) if !near.first.is_regular() => {
                    limit.get_or_init(|| near.first.disliked());
                }
                _ => others.iter().for_each(|other| other.unless(false)),
            }
            near
        };
        let made = |(k, other): (usize, &Other)| {
            let made = other.made(ground, level, &limit, progress);
            // One that is regular and better is enough.
            let is_enough = limit.get().is_some_and(|l| made.is_regular_and_better(*l));
            let later = others[k + 1..].iter();
            later.for_each(|other| other.unless(!is_enough));
            all.unless(k > 0 || made.has_opposites != Some(false));
            made
        };
        let each = || {
            others
                .par_iter()
                .enumerate()
                .with_max_len(1)
                .map(made)
                .collect()
        };
        let (near, made): (_, Vec<MadeOther>) = rayon::join(near, each);
        let mut best = near?;
        let (limit, mut compared) = (best.first.disliked(), 0);
        let is_wanted = |other: &Other| !other.is_unwanted.load(Ordering::Relaxed);
        for (_, made) in (others.iter().zip(made)).filter(|(other, _)| is_wanted(other)) {
            clock.add(&made.stages);
            compared += usize::from(made.is_laid_out && made.least < limit);
            let is_enough = made.is_regular_and_better(limit);
            let least = made.is_better(limit).then_some(best.first.disliked());
            best = match made.panels {
                Some(panels) if least.is_some_and(|l| panels.first.disliked() < l) => panels,
                _ => best,
            };
            if is_enough {
                break;
            }
        }
        best.first.compared = compared;
        Ok(best)
    }

    fn new(
        ground: &Ground,
        level: usize,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let field = Field::new(ground, level, options, clock)?;
        Self::of(ground, field, clock)
    }

    fn of(ground: &Ground, field: Field, clock: &mut Clock<'_>) -> Result<Self, PipelineError> {
        let fine = FineSurface::new(ground, &field);
        let made = |seeds: &[Seed], progress: &dyn Progress| fine.calm_panels(seeds, progress);
        // The panels' middles are sought on the fine surface as soon as cells have grown.
        let (first, ()) = rayon::join(
            || Drawn::first(ground, &field, made, clock),
            || fine.surface.prepare(),
        );
        let first = first?;
        Ok(Self { field, fine, first })
    }
}

impl Other {
    /// One in which far cones cancel; one with sizes that need no dislocations, where none are
    /// asked for; and one in which all cones cancel. Rows run across small holes in each.
    fn all(options: &MeshOptions) -> [Self; 3] {
        let far = Self::cancelling(options, FAR_REACH);
        let all = Self::cancelling(options, f64::INFINITY);
        let mut seamless = Self::cancelling(options, f64::INFINITY);
        allow_sizes(&mut seamless.options);
        seamless.unless(seamless.options.layout != options.layout && !options.varies_sizes());
        [far, seamless, all]
    }

    fn cancelling(options: &MeshOptions, reach: f64) -> Self {
        let mut options = options.clone();
        options.directions.cancel_reach = Some(reach);
        options.directions.across_holes = true;
        Self {
            options,
            is_unwanted: AtomicBool::new(false),
        }
    }

    /// Ends it unless it is wanted.
    fn unless(&self, is_wanted: bool) {
        self.is_unwanted.fetch_or(!is_wanted, Ordering::Relaxed);
    }

    /// Its panels, unless less is liked of its sizes alone than the `limit`.
    fn made(
        &self,
        ground: &Ground,
        level: usize,
        limit: &OnceLock<f64>,
        progress: &dyn Progress,
    ) -> MadeOther {
        let progress = Quiet::unless(progress, &self.is_unwanted);
        let mut clock = Clock::new(&progress);
        let mut made = MadeOther::default();
        // A field from which no panels come is no better.
        if let Ok(directed) = Directed::new(ground, level, &self.options, &mut clock) {
            made.least = directed.disliked(&ground.smooth);
            made.has_opposites = Some(directed.has_opposites(&ground.smooth, f64::INFINITY));
            if limit.get().is_none_or(|limit| made.least < *limit) {
                let field = directed.placed(ground, &self.options, &mut clock);
                let panels = field.and_then(|f| FieldPanels::of(ground, f, &mut clock));
                made.panels = panels.ok();
                made.is_laid_out = made.panels.is_some();
                if limit.get().is_some_and(|limit| !made.is_better(*limit)) {
                    made.panels = None;
                }
            }
        }
        made.stages = clock.stages;
        made
    }
}

impl MadeOther {
    /// Whether less is disliked of its panels, and of its sizes alone, than the `limit`.
    fn is_better(&self, limit: f64) -> bool {
        let disliked = |p: &FieldPanels| p.first.disliked().max(self.least);
        self.panels.as_ref().is_some_and(|p| disliked(p) < limit)
    }

    fn is_regular_and_better(&self, limit: f64) -> bool {
        let is_regular = |p: &FieldPanels| p.first.is_regular();
        self.is_better(limit) && self.panels.as_ref().is_some_and(is_regular)
    }
}

impl Field {
    fn has_opposites(&self, ground: &Ground, reach: f64) -> bool {
        let topology = ground.smooth.levels[self.level].topology();
        has_opposites(topology, &self.directions, reach)
    }

    fn has_small_holes(&self, ground: &Ground) -> bool {
        let surface = &ground.smooth.levels[self.level];
        has_small_holes(surface, &self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
    use phex_mesh::{TriangleSurface, Vec3};
    use std::f64::consts::PI;

    fn shape(name: &str) -> TriangleSurface {
        let triangulation = TriangulationOptions {
            triangles: 4000,
            ..Default::default()
        };
        triangulate(&Shape::from_name(name, &[]).unwrap(), &triangulation).unwrap()
    }

    /// A vault of 24 x 6 over its plan that rises and falls across its length.
    fn vault() -> TriangleSurface {
        let (long, wide) = (70_u32, 20_u32);
        let at = |i: u32, j: u32| {
            let (u, v) = (
                f64::from(i) / f64::from(long),
                f64::from(j) / f64::from(wide),
            );
            let (rise, wave) = (1.0 - 4.0 * (u - 0.5).powi(2), (PI * v).sin().powi(2));
            let height = rise * (2.2 + 1.1 * (2.0 * wave - 1.0) * (PI * u).sin());
            Vec3::new(24.0 * u, 6.0 * v, height)
        };
        let corners = (0..=long).flat_map(|i| (0..=wide).map(move |j| (i, j)));
        let cells = (0..long).flat_map(|i| (0..wide).map(move |j| i * (wide + 1) + j));
        let halves = |a: u32| {
            let [b, c, d] = [a + wide + 1, a + wide + 2, a + 1];
            [[a, b, c], [a, c, d]]
        };
        let faces: Vec<[u32; 3]> = cells.flat_map(halves).collect();
        TriangleSurface::new(corners.map(|(i, j)| at(i, j)).collect(), &faces).unwrap()
    }

    /// The field of the options and the best one.
    fn fields(surface: &TriangleSurface, panels: usize, reach: Option<f64>) -> [FieldPanels; 2] {
        let mut options = MeshOptions::default();
        options.directions.cancel_reach = reach;
        let mut clock = Clock::new(&Silent);
        let ground = Ground::new(surface, panels, &options);
        let level = ground.field_level(&options);
        let near = FieldPanels::new(&ground, level, &options, &mut clock).unwrap();
        let better = FieldPanels::better(&ground, level, &options, &mut clock).unwrap();
        [near, better]
    }

    /// Cones, and what is not liked, of both.
    fn both(name: &str, panels: usize, reach: Option<f64>) -> [(usize, f64); 2] {
        fields(&shape(name), panels, reach).map(|g| {
            let cones = g.field.directions.cone.iter().filter(|c| **c != 0);
            (cones.count(), g.first.disliked())
        })
    }

    /// A vault of 1,000 panels had 20 irregular ones with less even areas.
    #[test]
    fn a_shallow_vault_needs_no_dislocations() {
        let [near, better] = fields(&vault(), 600, None);
        assert!(!near.first.is_regular() && better.first.is_regular());
        assert!(better.first.disliked() < 0.5 * near.first.disliked());
        // The sizes in the metric of closed bodies say at once that they would jump.
        let [near, better] = fields(&shape("sphere"), 600, None);
        assert_eq!(near.first.disliked(), better.first.disliked());
    }

    #[test]
    fn far_cones_cancel_where_panels_are_better_for_it() {
        let [near, better] = both("hyperbolic-paraboloid", 200, None);
        assert!(
            better.0 < near.0 && better.1 < near.1,
            "{near:?} {better:?}"
        );
        // What is typed is what holds.
        let typed = both("hyperbolic-paraboloid", 200, Some(4.0));
        assert_eq!(typed, [near, near]);
        for (name, panels) in [("wave", 400), ("b-spline", 300), ("sphere", 100)] {
            let [near, better] = both(name, panels, None);
            assert!(better.1 <= near.1, "{name}: {near:?} {better:?}");
        }
    }
}
