//! Panels of the better of two fields: opposite cones that are far apart may cancel, or stay.
//!
//! A pair of cones costs two irregular panels. Without it panels of a smooth roof are hardly less
//! even, and those of a body whose curvature comes in lumps are. Which of both it is shows in the
//! panels as they are laid out.

use super::domain::Ground;
use super::field::{Field, FineSurface};
use super::restarts::{Drawn, restarts};
use super::{Clock, MeshOptions, PipelineError};
use crate::directions::DirectionOptions;
use crate::directions::cones::{FAR_REACH, has_opposites};
use crate::layout::seeds::Seed;
use crate::progress::Progress;

/// A field, the surface on which its cells are drawn, and the panels of its own seeds.
pub(super) struct FieldPanels {
    pub field: Field,
    pub fine: FineSurface,
    pub first: Drawn,
}

impl FieldPanels {
    /// Those of the field of the settings, or of one with fewer cones where these can be had and
    /// the panels are better for it.
    pub fn better(
        ground: &Ground,
        level: usize,
        options: &MeshOptions,
        settings: &DirectionOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let near = Self::new(ground, level, options, settings, clock)?;
        let is_given = settings.cancel_reach.is_some() || !settings.guides.cones.is_empty();
        if is_given || !near.may_have_fewer_cones(ground) {
            return Ok(near);
        }
        let settings = DirectionOptions {
            cancel_reach: Some(FAR_REACH),
            ..settings.clone()
        };
        // A field from which no panels come is no better.
        let far = Self::new(ground, level, options, &settings, clock);
        let better = far
            .ok()
            .filter(|far| far.first.disliked() < near.first.disliked());
        Ok(better.unwrap_or(near))
    }

    fn new(
        ground: &Ground,
        level: usize,
        options: &MeshOptions,
        settings: &DirectionOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let field = Field::new(ground, level, options, settings, clock)?;
        let fine = FineSurface::new(ground, &field);
        let made = |seeds: &[Seed], progress: &dyn Progress| fine.calm_panels(seeds, progress);
        let first = Drawn::first(ground, &field, made, clock)?;
        Ok(Self { field, fine, first })
    }

    /// Whether panels are not regular, few enough for another try, and cones are left that could
    /// cancel.
    fn may_have_fewer_cones(&self, ground: &Ground) -> bool {
        let field = &self.field;
        let topology = ground.smooth.levels[field.level].topology();
        let is_worth = restarts(ground) > 1 && !self.first.is_regular();
        is_worth && has_opposites(topology, &field.directions, FAR_REACH)
    }
}

#[cfg(test)]
mod tests {
    use super::super::field::direction_options;
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
        let settings = direction_options(&options, 2.0);
        let level = ground.field_level(&options);
        let near = FieldPanels::new(&ground, level, &options, &settings, &mut clock).unwrap();
        let better = FieldPanels::better(&ground, level, &options, &settings, &mut clock).unwrap();
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
