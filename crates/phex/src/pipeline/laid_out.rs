//! Panels that are laid out: cells of a lattice, or bricks, on the surface and not planar.

use super::best_field::FieldPanels;
use super::domain::Ground;
use super::field::finer_ground;
use super::options::Candidate;
use super::restarts::most_regular;
use super::{Clock, PipelineError};
use crate::directions::guides::Cone;
use crate::layout::brick_wall::BrickWallStatistics;
use crate::layout::seeds::Seed;
use crate::layout::{Layout, LayoutStatistics, PanelWish};
use crate::progress::Progress;
use phex_mesh::{PerVertex, TriangleSurface};

/// Panels that are laid out, and what they lie on.
pub(super) struct LaidOut {
    /// The ground where they have one of their own.
    pub own: Option<Ground>,
    /// The surface on which cells were drawn.
    pub surface: TriangleSurface,
    /// Area that a panel is to have at each of its vertices.
    pub wish: PerVertex<PanelWish>,
    pub layout: Layout,
    pub statistics: LayoutStatistics,
    /// The brick wall, if it is one.
    pub brick_wall: Option<BrickWallStatistics>,
    /// Cones of the direction field, normalised.
    pub cones: Vec<Cone>,
    /// See [`Field::regular_possible`].
    pub regular_possible: bool,
}

impl LaidOut {
    /// Lays out a lattice of one kind. Field and metric, the largest things of a run, end here.
    pub fn new(
        ground: &Ground,
        candidate: Candidate,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let options = &candidate.options(&ground.options);
        let finer = match candidate.seamless {
            true => finer_ground(ground, options, clock)?,
            false => None,
        };
        let (finer, level) = finer.map_or((None, ground.field_level(options)), |(finer, level)| {
            (Some(finer), level)
        });
        let ground = finer.as_ref().unwrap_or(ground);
        let better = FieldPanels::better(ground, level, options, clock)?;
        let FieldPanels { field, fine, first } = better;
        let made = |seeds: &[Seed], progress: &dyn Progress| fine.calm_panels(seeds, progress);
        let drawn = most_regular(ground, &field, first, made, clock)?;
        Ok(Self {
            cones: field.cones(&ground.smooth),
            regular_possible: field.regular_possible(&ground.smooth),
            own: finer,
            brick_wall: None,
            surface: fine.surface,
            wish: fine.wish,
            layout: drawn.layout,
            statistics: drawn.placed.statistics,
        })
    }

    /// What they lie on, given that they were laid out on `given`.
    pub fn ground<'a>(&'a self, given: &'a Ground) -> &'a Ground {
        self.own.as_ref().unwrap_or(given)
    }
}
