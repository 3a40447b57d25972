//! Panels of the better of two fields: opposite cones that are far apart may cancel, or stay, and
//! rows may run across small holes, or round them.
//!
//! A pair of cones costs two irregular panels. Without it panels of a smooth roof are hardly less
//! even, and those of a body whose curvature comes in lumps are. Rows round a small hole want cones
//! near it, towards which panels shrink, and a hole with room for them wants such rows. Which of
//! both it is shows in the panels as they are laid out.

use super::domain::Ground;
use super::field::{Field, FineSurface};
use super::restarts::{Drawn, restarts};
use super::{Clock, MeshOptions, PipelineError};
use crate::directions::FAR_REACH;
use crate::directions::cones::has_opposites;
use crate::directions::holes::has_small_holes;
use crate::layout::seeds::Seed;
use crate::progress::{Progress, Quiet};
use std::sync::atomic::{AtomicBool, Ordering};

/// A field, the surface on which its cells are drawn, and the panels of its own seeds.
pub(super) struct FieldPanels {
    pub field: Field,
    pub fine: FineSurface,
    pub first: Drawn,
}

impl FieldPanels {
    /// Those of the field of the options, or of one with fewer cones, and across small holes,
    /// where these can be had and the panels are better for it.
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
        let mut far_options = options.clone();
        far_options.directions.cancel_reach = Some(FAR_REACH);
        far_options.directions.across_holes = true;
        // The second is begun where a thread is idle, and ends as soon as it is not wanted.
        let alone = AtomicBool::new(false);
        let progress = Quiet::unless(clock.progress, &alone);
        let near = || {
            let field = Field::new(ground, level, options, clock);
            let has_other = !directions.mirrors.is_empty()
                || field
                    .as_ref()
                    .is_ok_and(|f| f.has_opposites(ground) || f.has_small_holes(ground));
            alone.fetch_or(!has_other, Ordering::Relaxed);
            let near = field.and_then(|field| Self::of(ground, field, clock));
            let is_irregular = near.as_ref().is_ok_and(|n| !n.first.is_regular());
            alone.fetch_or(!is_irregular, Ordering::Relaxed);
            near
        };
        let far = || {
            let mut clock = Clock::new(&progress);
            let far = Self::new(ground, level, &far_options, &mut clock);
            (far, clock.stages)
        };
        let (near, (far, stages)) = rayon::join(near, far);
        let near = near?;
        if alone.into_inner() {
            return Ok(near);
        }
        clock.add(&stages);
        // A field from which no panels come is no better.
        let better = far
            .ok()
            .filter(|far| far.first.disliked() < near.first.disliked());
        Ok(better.unwrap_or(near))
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

impl Field {
    /// Whether cones are left that could cancel.
    fn has_opposites(&self, ground: &Ground) -> bool {
        let topology = ground.smooth.levels[self.level].topology();
        has_opposites(topology, &self.directions, FAR_REACH)
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

    /// Cones, and what is not liked, of the field of the options and of the better one.
    fn both(name: &str, panels: usize, reach: Option<f64>) -> [(usize, f64); 2] {
        let triangulation = TriangulationOptions {
            triangles: 4000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &triangulation).unwrap();
        let mut options = MeshOptions::default();
        options.directions.cancel_reach = reach;
        let mut clock = Clock::new(&Silent);
        let ground = Ground::new(&surface, panels, &options);
        let level = ground.field_level(&options);
        let near = FieldPanels::new(&ground, level, &options, &mut clock).unwrap();
        let better = FieldPanels::better(&ground, level, &options, &mut clock).unwrap();
        [near, better].map(|g| (g.field.cones(&ground.smooth).len(), g.first.disliked()))
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
