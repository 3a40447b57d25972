//! One pass for panels laid out in one way: layout, optimiser, boundary; then they are judged, and
//! nothing has been repaired.

use super::domain::{Beyond, Ground};
use super::finish::finished;
use super::laid_out::LaidOut;
use super::{Candidate, Clock, MeshOptions, Method, PipelineError, brick_wall, rim};
use crate::directions::guides::Cone;
use crate::layout::brick_wall::BrickWallStatistics;
use crate::layout::{Layout, LayoutStatistics, PanelWish};
use crate::optimise::{self, Optimised, SurfaceTarget};
use crate::quality::{Judge, Judgement, References};
use crate::search::{AreaField, Searched, Site, search};
use crate::trim::Trimmed;
use phex_mesh::{FaceId, HexMesh, PerVertex, PolygonSoup, TriangleSurface};
use std::collections::BTreeSet;

/// A panelling made in one way.
pub(super) struct Pass {
    pub mesh: HexMesh,
    /// The panels as they were laid out.
    pub start: PolygonSoup,
    pub layout: LayoutStatistics,
    /// The brick wall, if it is one.
    pub brick_wall: Option<BrickWallStatistics>,
    /// Cones of the direction field, normalised.
    pub cones: Vec<Cone>,
    /// See [`Field::regular_possible`].
    pub regular_possible: bool,
    pub optimised: Optimised,
    pub judgement: Judgement,
    /// The surfaces that the mesh is reported against.
    pub surfaces: Surfaces,
}

/// The surfaces of a pass.
pub(super) struct Surfaces {
    /// The surface on which cells were drawn, and the areas that panels are to have there.
    fine: TriangleSurface,
    wish: PerVertex<PanelWish>,
    pub reported: TriangleSurface,
    facets: TriangleSurface,
    pub beyond: Option<Beyond>,
}

impl Surfaces {
    fn new(ground: &Ground, fine: TriangleSurface, wish: PerVertex<PanelWish>) -> Self {
        Self {
            reported: ground.reported(&fine).clone(),
            facets: ground.given_facets().clone(),
            beyond: ground.beyond(&fine),
            fine,
            wish,
        }
    }

    /// Gives up what the next query makes again: room for another pass.
    pub fn set_aside(&mut self) {
        let fine = self.fine.unshared();
        let smooth = self.beyond.as_mut().map(|beyond| &mut beyond.smooth);
        for surface in smooth.into_iter().chain([&mut self.reported]) {
            if surface.is_clone_of(&self.fine) {
                *surface = fine.clone();
            }
        }
        self.fine = fine;
    }

    /// Areas that panels are to have.
    pub fn areas(&self) -> AreaField<'_> {
        AreaField {
            surface: &self.fine,
            wish: &self.wish,
        }
    }

    /// Does something with the site of these surfaces.
    fn with_site<T>(&self, options: &MeshOptions, work: impl FnOnce(&Site<'_>) -> T) -> T {
        let beyond = self.beyond.as_ref().map(Beyond::surfaces);
        let others = References {
            beyond,
            ..References::of_facets(Some(&self.facets))
        };
        let judge = Judge::new(&self.reported, others, options.limits());
        work(&Site {
            judge: &judge,
            close_to: &SurfaceTarget::new(beyond.map_or(&self.reported, |b| b[0])),
            hold: rim::held(&self.reported, options),
            mirrors: &[],
            areas: Some(self.areas()),
            options: &options.optimise,
        })
    }
}

/// Panels laid out in one way.
pub(super) fn laid_out(
    ground: &Ground,
    candidate: Candidate,
    clock: &mut Clock<'_>,
) -> Result<LaidOut, PipelineError> {
    match candidate.method {
        Method::BrickWall => brick_wall::laid_out(ground, clock),
        _ => LaidOut::new(ground, candidate, clock),
    }
}

/// One pass for panels laid out in one way.
pub(super) fn pass(
    ground: &Ground,
    candidate: Candidate,
    clock: &mut Clock<'_>,
) -> Result<Pass, PipelineError> {
    let (options, progress) = (&candidate.options(&ground.options), clock.progress);
    let laid = laid_out(ground, candidate, clock)?;
    let settings = match candidate.method {
        Method::BrickWall => brick_wall::kinked(&options.optimise),
        _ => options.optimise.clone(),
    };
    let (ground, layout, fine) = (laid.ground(ground), &laid.layout, &laid.surface);
    clock.unless_unwanted()?;
    progress.preview("layout", &|| layout.mesh.to_soup());
    let optimised = {
        let target = SurfaceTarget::new(ground.close_to(fine));
        let made = || optimise::optimise(layout, &target, &settings, progress);
        clock.timed("optimise", made)?
    };
    clock.unless_unwanted()?;
    progress.preview("optimise", &|| optimised.mesh.to_soup());
    let trimmed = clock.timed("trim", || ground.trimmed(&optimised.mesh, fine))?;
    clock.unless_unwanted()?;
    let start = kept_panels(layout, &trimmed);
    let surfaces = Surfaces::new(ground, fine.clone(), laid.wish.clone());
    let made = surfaces.with_site(options, |site| finished(trimmed.mesh, site, ground, clock));
    let (mesh, judgement) = made?;
    clock.unless_unwanted()?;
    progress.preview("trim", &|| mesh.to_soup());
    Ok(Pass {
        mesh,
        start,
        layout: laid.statistics,
        brick_wall: laid.brick_wall,
        cones: laid.cones,
        regular_possible: laid.regular_possible,
        optimised,
        judgement,
        surfaces,
    })
}

impl Pass {
    /// Searches the mesh where something is wrong.
    pub(crate) fn searched(&self, ground: &Ground, clock: &mut Clock<'_>) -> Searched {
        let progress = clock.progress;
        let work = |site: &Site<'_>| search(self.mesh.clone(), site, progress);
        clock.timed("search", || self.surfaces.with_site(&ground.options, work))
    }
}

/// The panels of a layout of which something is left.
fn kept_panels(layout: &Layout, trimmed: &Trimmed) -> PolygonSoup {
    let kept: BTreeSet<FaceId> = trimmed.parent.iter().copied().collect();
    let mut soup = layout.mesh.to_soup();
    let mut numbers = layout.mesh.topology().faces();
    soup.faces
        .retain(|_| numbers.next().is_some_and(|f| kept.contains(&f)));
    soup
}
