//! The lattice of a surface: curvature, metric and seeds on the level where it is computed, and the
//! fine surface for its cells.

use super::domain::Ground;
use super::sized::{SizedCurvature, Sizes, panel_length};
use super::{Candidate, Clock, MeshOptions, PipelineError};
use crate::curvature::{self, Curvature, Principal};
use crate::directions::cones;
use crate::directions::guides::Cone;
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::{self, DirectionOptions, Directions};
use crate::layout::lattice::eisenstein::CELL;
use crate::layout::seeds::Seed;
use crate::layout::{self, CellSurface, Layout, LayoutError, LayoutOptions, PanelWish, Placed};
use crate::progress::Progress;
use crate::quality::Merit;
use crate::smooth_surface::SmoothTarget;
use nalgebra::Matrix3;
use phex_mesh::{PerVertex, Topology, TriangleSurface, Vec3, VertexId};
use std::collections::HashSet;

/// Curvature, metric and directions on the level where a lattice is computed.
pub(super) struct Directed {
    level: usize,
    sized: SizedCurvature,
    directions: Directions,
    settings: DirectionOptions,
}

/// Curvature, metric and seeds on the level where the lattice is computed.
pub(super) struct Field {
    pub level: usize,
    pub curvature: Curvature,
    pub directions: Directions,
    /// Panel length at each vertex as the field of sizes asks for it, without the metric's own
    /// changes of size.
    pub length: PerVertex<f64>,
    /// Length over width of panels in its metric at the most.
    pub anisotropy: f64,
    pub placed: Placed,
    /// How its lattice was made.
    pub layout: LayoutOptions,
}

/// Deviation from the number of panels asked for that is corrected by another lattice.
const COUNT_TOLERANCE: f64 = 0.06;
/// Lattices tried for that at the most.
const COUNT_TRIES: usize = 3;

impl Directed {
    pub(super) fn new(
        ground: &Ground,
        level: usize,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        let (smooth, panels, progress) = (&ground.smooth, ground.panels, clock.progress);
        let surface = &smooth.levels[level];
        let settings = direction_options(options);
        cones::prescribed_faces(surface, &settings.guides.cones)?;
        let sized = clock.stage("curvature", || {
            ground.known.at(smooth, level, panels, options)
        })?;
        let (curvature, length) = (&sized.curvature, &sized.length);
        let directions = clock.stage("directions", || {
            directions::directions_sized(surface, curvature, length, &settings, progress)
        })??;
        Ok(Self {
            level,
            sized,
            directions,
            settings,
        })
    }

    /// What the judge will not like of the sizes in its metric: the panels of its lattice are
    /// hardly more even. Panels at the boundary do not count.
    pub(super) fn disliked(&self, smooth: &SmoothTarget) -> f64 {
        let surface = &smooth.levels[self.level];
        let (area, panels) = (surface.vertex_areas(), &self.directions.intrinsic.mass);
        let inside = away_from_boundary(surface.topology());
        // Panels at a vertex, and their area over the wished one.
        let at = |v: &VertexId| {
            (
                panels[*v],
                area[*v] / (panels[*v] * self.sized.length[*v].powi(2)),
            )
        };
        let pairs: Vec<(f64, f64)> = inside.iter().map(at).collect();
        let inner = pairs
            .iter()
            .map(|(n, _)| n)
            .sum::<f64>()
            .max(f64::MIN_POSITIVE);
        let mean: f64 = pairs.iter().map(|(n, size)| n * size.ln()).sum::<f64>() / inner;
        let uneven = pairs.iter().map(|(n, size)| n * (size.ln() - mean).powi(2));
        let all: f64 = panels.iter().sum();
        Merit::cost_of_layout(0.0, uneven.sum::<f64>() / all, 0.0)
    }

    /// Whether cones are left, at most so many panels apart, that could cancel.
    pub(super) fn has_opposites(&self, smooth: &SmoothTarget, reach: f64) -> bool {
        let topology = smooth.levels[self.level].topology();
        cones::has_opposites(topology, &self.directions, reach)
    }

    /// The field with the seeds of its lattice.
    pub(super) fn placed(
        mut self,
        ground: &Ground,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Field, PipelineError> {
        let topology = ground.smooth.levels[self.level].topology();
        let (directions, panels) = (&mut self.directions, ground.panels);
        let (ratio, placed) =
            counted_lattice(topology, directions, panels, &options.layout, clock)?;
        let mut length = self.sized.length;
        length.iter_mut().for_each(|l| *l *= ratio);
        Ok(Field {
            level: self.level,
            curvature: self.sized.curvature,
            directions: self.directions,
            length,
            anisotropy: self.settings.anisotropy,
            placed,
            layout: options.layout.clone(),
        })
    }
}

/// Vertices of which no panel at the boundary comes, in a field of several vertices a panel.
fn away_from_boundary(topology: &Topology) -> Vec<VertexId> {
    let mut is_near = PerVertex::filled(topology.n_vertices(), false);
    topology.boundary_vertices().for_each(|v| is_near[v] = true);
    let rim = is_near.clone();
    for f in topology.faces() {
        let corners = topology.face_vertices(f);
        if corners.iter().any(|v| rim[*v]) {
            corners.iter().for_each(|v| is_near[*v] = true);
        }
    }
    topology.vertices().filter(|v| !is_near[*v]).collect()
}

impl Field {
    pub(super) fn new(
        ground: &Ground,
        level: usize,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<Self, PipelineError> {
        Directed::new(ground, level, options, clock)?.placed(ground, options, clock)
    }

    /// Whether a lattice on the surface could do without any irregular panel but those that
    /// topology asks for: it is closed, and its Euler characteristic is 0, or its Gauss curvature
    /// positive everywhere.
    pub(super) fn regular_possible(&self, smooth: &SmoothTarget) -> bool {
        let topology = smooth.levels[self.level].topology();
        let elliptic = |p: &Principal| p.small * p.large > 0.0;
        let closed = topology.is_closed();
        let flat = topology.euler_characteristic() == 0;
        closed && (flat || self.curvature.principal().iter().all(elliptic))
    }

    /// Cones of the direction field.
    pub(super) fn cones(&self, smooth: &SmoothTarget) -> Vec<Cone> {
        let surface = &smooth.levels[self.level];
        let cones = self.directions.cone.enumerate().filter(|(_, i)| **i != 0);
        let cone = |(f, index): (_, &i32)| Cone {
            position: surface.centroid(f).into(),
            index: *index,
        };
        cones.map(cone).collect()
    }
}

/// Longest edge of the surface on which a seamless lattice is computed, in lattice spacings: that
/// of the fewest vertices under other lattices. Between vertices farther apart lattice points get
/// lost.
const LONGEST_EDGE: f64 = 0.5;
/// Vertices of the refined surface over those before, at the most: bodies with ears need up to 2.7,
/// and on a needle, on which every lattice is finer than the triangles, no refinement is enough.
const LOCAL_REFINEMENT: usize = 4;

/// The ground of a seamless lattice, refined where the surface bends so fast that the lattice is
/// finer than the triangles, and the level to compute it on. `None` where triangles are small
/// enough, and for surfaces with a strip beyond their boundary.
pub(super) fn finer_ground(
    ground: &Ground,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<Option<(Ground, usize)>, PipelineError> {
    if ground.is_extended() {
        return Ok(None);
    }
    let (smooth, panels, progress) = (&ground.smooth, ground.panels, clock.progress);
    let first = ground.field_level(options);
    let surface = &smooth.levels[first];
    let uniform = panel_length(surface, panels);
    let settings = &direction_options(options);
    let mut metric = clock.stage("directions", || {
        let curvature = curvature::curvature(surface, uniform, &options.curvature);
        let length = Sizes::new(smooth, first, panels, options).with(&curvature);
        let found = directions::directions_sized(surface, &curvature, &length, settings, progress)?;
        Ok::<_, PipelineError>(found.metric)
    })??;
    let mut finest: Option<SmoothTarget> = None;
    let mut level = first;
    loop {
        let now = finest.as_ref().unwrap_or(smooth);
        let length = IntrinsicMesh::new(&now.levels[level], &metric).length;
        let few = |finer: &SmoothTarget| {
            finer.finest().positions().len() <= LOCAL_REFINEMENT * surface.positions().len()
        };
        let Some(finer) = now.split_longer(level, &length, LONGEST_EDGE).filter(few) else {
            break;
        };
        metric = finer.refinements[level].apply(&metric);
        finest = Some(finer);
        level += 1;
    }
    Ok(finest.map(|smooth| (ground.with_smooth(smooth), level)))
}

/// The lattice whose number of panels is nearest to what is asked for, of a few along the same
/// directions: by how much its panels are longer than those that the directions were made for, and
/// its seeds. The directions are scaled with it.
pub(super) fn counted_lattice(
    topology: &Topology,
    directions: &mut Directions,
    panels: usize,
    options: &LayoutOptions,
    clock: &mut Clock<'_>,
) -> Result<(f64, Placed), PipelineError> {
    let progress = clock.progress;
    let mut best: Option<(f64, f64, Placed)> = None;
    let mut longer = 1.0;
    for _ in 0..COUNT_TRIES {
        let placed = clock.stage("layout", || {
            layout::place_seeds(topology, directions, options, progress)
        })??;
        let ratio = placed.seeds.len().max(1) as f64 / panels as f64;
        let error = ratio.ln().abs();
        if best.as_ref().is_none_or(|b| error < b.0) {
            best = Some((error, longer, placed));
        }
        if error < COUNT_TOLERANCE {
            break;
        }
        directions.lengthen(ratio.sqrt());
        longer *= ratio.sqrt();
    }
    let (_, kept, placed) = best.expect("at least one lattice is tried");
    directions.lengthen(kept / longer);
    Ok((kept, placed))
}

/// Largest panel length over the least radius of curvature with which panels resolve a surface: all
/// those with at most half of it pass at once, and most of those with more than 1.2 do not.
const RESOLVED: f64 = 0.8;

/// Pull from which on a dislocation stays in such a lattice.
const EVEN_PULL: f64 = 2.5;

/// What the conformal factor's screening and limit are multiplied by for a seamless lattice.
const SEAMLESS_SCREENING: f64 = 0.025;
const SEAMLESS_LIMIT: f64 = 2.0;

impl Candidate {
    /// Options for panels that are laid out so.
    pub(super) fn options(self, options: &MeshOptions) -> MeshOptions {
        let mut options = options.clone();
        options.directions.anisotropy = self.anisotropy;
        if self.resolving {
            options.sizes.adaptive = Some(RESOLVED);
            options.layout.max_pull.get_or_insert(EVEN_PULL);
        }
        if self.seamless {
            allow_sizes(&mut options);
        }
        if options.regular {
            // Opposite cones cancel however far apart they are.
            options.directions.cancel_reach.get_or_insert(f64::INFINITY);
        }
        options
    }
}

/// Lets the size of a lattice's panels change so far that it needs no dislocations.
pub(super) fn allow_sizes(options: &mut MeshOptions) {
    options.directions.conformal_screening *= SEAMLESS_SCREENING;
    options.directions.conformal_limit *= SEAMLESS_LIMIT;
    options.layout.max_distortion = f64::MAX;
}

/// Screening that keeps varying sizes against the conformal factor, which would even them out.
const SIZED_SCREENING: f64 = 0.5;

/// The options of a lattice's directions, whose panels may vary in size.
pub(super) fn direction_options(options: &MeshOptions) -> DirectionOptions {
    let mut settings = options.directions.clone();
    if options.varies_sizes() {
        settings.conformal_screening = settings.conformal_screening.max(SIZED_SCREENING);
    }
    settings
}

/// The finest level with everything that cells need.
pub(super) struct FineSurface {
    pub surface: TriangleSurface,
    metric: PerVertex<Matrix3<f64>>,
    mesh: IntrinsicMesh,
    corners: HashSet<VertexId>,
    /// Area that a panel is to have at each vertex.
    pub wish: PerVertex<PanelWish>,
}

impl FineSurface {
    pub(super) fn new(ground: &Ground, field: &Field) -> Self {
        let smooth = &ground.smooth;
        let mut curvature = field.curvature.clone();
        let mut metric = field.directions.metric.clone();
        let mut length = field.length.clone();
        for step in &smooth.refinements[field.level..] {
            curvature = curvature.refined(step);
            metric = step.apply(&metric);
            length = step.apply(&length);
        }
        let wish = wished(&curvature, &length, BRICK * field.anisotropy);
        let surface = smooth.finest().unshared().with_normals(curvature.normal);
        let mirrors = &ground.options.directions.mirrors;
        let mesh = IntrinsicMesh::new(&surface, &metric).with_mirrors(&surface, mirrors);
        let corners = spaced_corners(smooth, |v, d| {
            d.dot(&(field.directions.metric[v] * d)).sqrt()
        });
        Self {
            surface,
            metric,
            mesh,
            corners,
            wish,
        }
    }

    /// The panels that grow from seeds, made more regular.
    pub(super) fn calm_panels(
        &self,
        seeds: &[Seed],
        progress: &dyn Progress,
    ) -> Result<Layout, LayoutError> {
        let layout = layout::panelling(&self.cells(), seeds, progress)?;
        let mut layout = layout::calmed(layout, progress)?;
        layout.face_wish = layout.face_seed.map(|seed| self.wish[*seed]);
        Ok(layout)
    }

    pub(super) fn cells(&self) -> CellSurface<'_> {
        CellSurface {
            surface: &self.surface,
            metric: &self.metric,
            mesh: &self.mesh,
            corners: &self.corners,
        }
    }
}

/// Length over width of a brick in a lattice, over that of the regular hexagon from which it is
/// made with the same area.
const BRICK: f64 = 1.0 / CELL;

/// Sizes and shapes that panels are to have. Where a panel is longer than the radius of curvature
/// planarity decides what area it can have: wishes fade there with the fourth power of their ratio.
fn wished(curvature: &Curvature, length: &PerVertex<f64>, aspect: f64) -> PerVertex<PanelWish> {
    let principal = curvature.principal();
    PerVertex::from_fn(length.len(), |v| {
        let turn = length[v] * principal[v].large.abs().max(principal[v].small.abs());
        PanelWish {
            area: CELL * length[v].powi(2),
            share: 1.0 / (1.0 + turn.powi(4)),
            aspect,
        }
    })
}

/// Sharp boundary corners at least half a panel apart, the sharpest first; `distance` in panels.
pub(super) fn spaced_corners(
    smooth: &SmoothTarget,
    distance: impl Fn(VertexId, Vec3) -> f64,
) -> HashSet<VertexId> {
    let positions = smooth.finest().positions();
    let mut kept: Vec<VertexId> = Vec::new();
    for &corner in &smooth.corners {
        let far = |other: &VertexId| distance(corner, positions[corner] - positions[*other]) > 0.5;
        if kept.iter().all(far) {
            kept.push(corner);
        }
    }
    kept.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::smooth_surface::TargetKind;

    #[test]
    fn a_needle_is_not_refined_without_end() {
        let tip = |x, y| Vec3::new(x, y, 0.0);
        let corners = vec![tip(0.0, 0.0), tip(1e4, 0.0), tip(5e3, 1.0)];
        let needle = TriangleSurface::new(corners, &[[0, 1, 2]]).unwrap();
        let way = Candidate {
            anisotropy: 1.0,
            seamless: true,
            ..Candidate::default()
        };
        // Half-way to their facets surfaces keep their long triangles.
        let mut options = way.options(&MeshOptions::default());
        options.target.kind = TargetKind::HalfWay;
        let ground = Ground::new(&needle, 50, &options);
        let (finer, _) = finer_ground(&ground, &options, &mut Clock::new(&Silent))
            .unwrap()
            .expect("the lattice is finer than the triangles");
        let vertices = |of: &Ground| of.smooth.finest().positions().len();
        assert!(vertices(&finer) <= LOCAL_REFINEMENT * vertices(&ground));
    }
}
