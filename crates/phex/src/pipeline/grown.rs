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
use crate::layout::seeds::Seed;
use crate::progress::Progress;

/// Distance, in panels, up to which opposite cones are cancelled in the second field.
const FAR_REACH: f64 = 12.0;

/// A field, the surface on which its cells are drawn, and the panels of its own seeds.
pub(super) struct Grown {
    pub field: Field,
    pub fine: FineSurface,
    pub first: Drawn,
}

impl Grown {
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
        if !near.may_have_fewer_cones(ground) {
            return Ok(near);
        }
        let settings = DirectionOptions {
            cancel_reach: FAR_REACH.max(settings.cancel_reach),
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

    /// Whether opposite cones are left, panels are not regular, and few enough for another try.
    fn may_have_fewer_cones(&self, ground: &Ground) -> bool {
        let cone = &self.field.directions.cone;
        let has = |sign: i32| cone.iter().any(|c| c.signum() == sign);
        restarts(ground) > 1 && !self.first.is_regular() && has(1) && has(-1)
    }
}
