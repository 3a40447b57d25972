//! Panels as a brick wall: how they are laid out, and the curves that they follow.

use super::domain::Ground;
use super::field::spaced_corners;
use super::laid_out::LaidOut;
use super::{Clock, MeshOptions, PipelineError, panel_count, panel_length};
use crate::curvature::{self, Curvature};
use crate::directions::network::{
    Conjugacy, ConjugateNetwork, Curve, Function, NetworkError, RowField, conjugacy,
    conjugate_network, level_lines, row_field,
};
use crate::layout::brick_wall::{BrickSurface, brick_wall, first_scale};
use crate::layout::{LayoutError, LayoutStatistics, PanelWish};
use crate::optimise::OptimiseOptions;
use crate::progress::Progress;
use crate::smooth_surface::Normalised;
use phex_mesh::{PerVertex, TriangleSurface, VertexId};
use std::collections::HashSet;

/// Turning angle of the boundary, degrees, above which bricks keep a corner at the most: rows that
/// meet it askew would cut off blunter ones than other panels do.
const CORNER: f64 = 30.0;

/// The options with the corners that bricks keep.
pub(super) fn with_corners(options: &MeshOptions) -> MeshOptions {
    let mut options = options.clone();
    options.target.corner_angle = options.target.corner_angle.min(CORNER);
    options
}

/// The same ground with the corners that bricks keep.
fn ground_with_corners(ground: &Ground) -> Ground {
    let options = MeshOptions {
        size_field: None,
        ..with_corners(&ground.options)
    };
    match options.target == ground.options.target {
        true => ground.clone(),
        false => ground.again(&options),
    }
}

/// The ground with everything that bricks are laid on, in normalised coordinates.
struct BrickSite {
    ground: Ground,
    surface: TriangleSurface,
    curvature: Curvature,
    field: RowField,
    corners: HashSet<VertexId>,
}

impl BrickSite {
    fn new(ground: &Ground, clock: &mut Clock<'_>) -> Result<Self, PipelineError> {
        let ground = clock.stage("target", || ground_with_corners(ground))?;
        let options = &ground.options;
        let smooth = &ground.smooth;
        let level = ground.field_level(options);
        let coarse = &smooth.levels[level];
        let length = panel_length(coarse, ground.panels);
        let mut curvature = clock.stage("curvature", || {
            curvature::curvature(coarse, length, &options.curvature)
        })?;
        let mut field = clock
            .stage("directions", || {
                row_field(coarse, &curvature, length, &options.brick_wall.network)
            })?
            .map_err(LayoutError::from)?;
        for step in &smooth.refinements[level..] {
            curvature = curvature.refined(step);
            field = field.refined(step);
        }
        let surface = smooth
            .finest()
            .clone()
            .with_normals(curvature.normal.clone());
        let corners = spaced_corners(smooth, |_, d| d.norm() / length);
        Ok(Self {
            ground,
            surface,
            curvature,
            field,
            corners,
        })
    }

    fn bricks(&self) -> BrickSurface<'_> {
        BrickSurface {
            surface: &self.surface,
            curvature: &self.curvature,
            field: &self.field,
            corners: &self.corners,
        }
    }
}

/// A brick wall laid out on what its ground is laid on, with the corners that bricks keep.
pub(super) fn laid_out(ground: &Ground, clock: &mut Clock<'_>) -> Result<LaidOut, PipelineError> {
    let site = BrickSite::new(ground, clock)?;
    let (layout, wall) = clock.stage("layout", || {
        brick_wall(
            &site.bricks(),
            site.ground.panels,
            &ground.options.brick_wall,
        )
    })??;
    Ok(LaidOut {
        wish: PerVertex::filled(site.surface.positions().len(), PanelWish::ANY),
        own: Some(site.ground),
        surface: site.surface,
        layout,
        statistics: LayoutStatistics::default(),
        brick_wall: Some(wall),
        cones: Vec::new(),
        regular_possible: false,
    })
}

/// Options that do not smooth a start which is simple: smoothing would undo the kinks.
pub(super) fn kinked(options: &OptimiseOptions) -> OptimiseOptions {
    OptimiseOptions {
        smoothing: [0, options.smoothing[1]],
        ..options.clone()
    }
}

/// The curves of a conjugate network, in model coordinates.
#[derive(Clone, Debug)]
pub struct NetworkCurves {
    /// Curves along rows, one row of panels apart.
    pub rows: Vec<Curve>,
    /// Curves across rows, half a brick apart.
    pub columns: Vec<Curve>,
    /// How conjugate they are; nothing on a flat surface.
    pub conjugacy: Option<Conjugacy>,
}

/// The conjugate network of a surface, sampled as densely as a brick wall of the given size samples
/// it.
///
/// # Errors
/// If the input can't be used or the surface has no global network.
pub fn network_curves(
    input: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<NetworkCurves, PipelineError> {
    options.check()?;
    let mut clock = Clock::new(progress);
    let panels = panel_count(input, options.size)?;
    let model = Normalised::of(input);
    let in_model = |e: PipelineError| e.in_model(&model);
    // Sizes do not matter to curves, and are those of the input's vertices.
    let unsized_options = MeshOptions {
        size_field: None,
        ..with_corners(options)
    };
    let ground = Ground::new(&model.surface, panels, &unsized_options);
    let site = BrickSite::new(&ground, &mut clock).map_err(in_model)?;
    let sampled = clock.stage("layout", || {
        sampled_network(&site, site.ground.panels, options)
    })?;
    let [rows, columns] = sampled.map_err(|e| in_model(LayoutError::from(e).into()))?;
    let curves = |function: &Function| {
        let mut lines = level_lines(&site.surface, function);
        for point in lines.iter_mut().flat_map(|c| &mut c.points) {
            *point = model.affinity.restore(*point);
        }
        lines
    };
    let measured = conjugacy(&site.surface, &site.curvature, [&rows, &columns]);
    Ok(NetworkCurves {
        rows: curves(&rows),
        columns: curves(&columns),
        conjugacy: measured.map(|c| Conjugacy {
            place: model.affinity.restore(c.place),
            ..c
        }),
    })
}

/// Functions whose whole values are the rows and the columns.
fn sampled_network(
    site: &BrickSite,
    panels: usize,
    options: &MeshOptions,
) -> Result<[Function; 2], NetworkError> {
    let network: ConjugateNetwork =
        conjugate_network(&site.surface, &site.field, &options.brick_wall.network)?;
    let scale = first_scale(&site.bricks(), &network, panels, &options.brick_wall);
    let whole = |family: &crate::directions::network::FunctionFamily, scale: f64| {
        let periods: Vec<f64> = family.periods.iter().map(|p| (p * scale).round()).collect();
        family.function(site.surface.topology(), &network.basis, scale, &periods)
    };
    Ok([
        whole(&network.across, scale[1]),
        whole(&network.along, 2.0 * scale[0]),
    ])
}
