//! Brick wall on a conjugate network: the method of Wang and Liu, "A note on planar hexagonal
//! meshes" (2010), section 3.
//!
//! The network (`crate::directions::network`) is sampled in steps of half a brick along rows and of
//! a row across; alternate rows are shifted by half a brick. Then junctions are moved across their
//! row line by the kink
//!
//! `d = a^2 q_uu / (8 b q_vv)`,  simple while `a^2 |q_uu| < 4 b^2 |q_vv|`
//!
//! which the paper does not have: it makes the panels planar to second order in their size instead
//! of first. The ratio `a / b` is the largest for which 95 % of the surface keep half the distance
//! to that limit. Periods round holes and handles are rounded to translations of the pattern
//! ([`bricks`]), so that rows and columns close.
//!
//! At the boundary, bricks are cut: cells follow from the brick of each vertex, pieces under a
//! quarter of a brick go to a neighbour, and the boundary's sharp corners are kept
//! (`super::cells::complex`). Boundary vertices lie where walls meet the boundary. Where the
//! boundary runs along rows or columns, the pattern is stretched by at most 6 % and shifted so that
//! it falls on them.
//!
//! | symbol | here |
//! |---|---|
//! | `a`, `b` | [`kink::BrickForms::size`] |
//! | `q_uu`, `q_vv` | [`kink::BrickForms::along`] over `a^2`, [`kink::BrickForms::across`] over `b^2` |
//! | `2 d / b` | `rho`, [`kink::BrickForms::kink`], clipped to [`MAX_KINK`] |
//!
//! Guaranteed: the surface's topology, interior vertices of degree 3, only hexagons inside if
//! bricks are resolved (five vertices of the surface along a half brick). Fails: where there is no
//! network, or bricks are too large for the surface.

pub(crate) mod bricks;
pub(crate) mod fit;
pub(crate) mod grid;
pub(crate) mod kink;
pub(crate) mod locate;
#[cfg(test)]
mod tests;

use super::cells::complex::{CellComplex, Node, disc_cells};
use super::{CellSurface, Layout, LayoutError, place, record};
use crate::curvature::Curvature;
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::network::{ConjugateNetwork, NetworkOptions, RowField, conjugate_network};
use bricks::{Brick, Junction};
use grid::BrickGrid;
use kink::BrickForms;
use nalgebra::Matrix3;
use phex_mesh::{FaceId, PerVertex, TriangleSurface, Vec3, VertexId};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// How bricks are laid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BrickWallOptions {
    /// The network.
    pub network: NetworkOptions,
    /// Length of a brick over its height (`a / b`, median); `None` takes it from the validity rule.
    pub ratio: Option<f64>,
}

/// What the wall is like.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct BrickWallStatistics {
    /// Median of `a / b`.
    pub ratio: f64,
    /// 95 % quantile of `|rho|` before clipping.
    pub kink_p95: f64,
    /// Share of the vertices where `|rho|` was clipped.
    pub clipped: f64,
    /// How much of the wished alignment the directions kept, at most 1.
    pub alignment_kept: f64,
}

/// A surface on which bricks are laid.
#[derive(Clone, Copy)]
pub(crate) struct BrickSurface<'a> {
    /// The surface, with normals of fitted jets; a brick should hold some 25 of its vertices.
    pub surface: &'a TriangleSurface,
    /// Its curvature at the scale of a panel.
    pub curvature: &'a Curvature,
    /// Directions of rows and columns.
    pub field: &'a RowField,
    /// Sharp corners of the boundary.
    pub corners: &'a HashSet<VertexId>,
}

/// Least and largest ratio that is chosen; one that is asked for may lie outside.
const RATIO_LIMITS: [f64; 2] = [0.7, 1.6];
/// `|rho|` that 95 % of the surface stay under when the ratio is chosen; panels touch themselves at
/// 1.
const KINK_GOAL: f64 = 0.5;
/// Largest `|rho|` that is built in.
const MAX_KINK: f64 = 0.7;

/// Walls tried until the number of panels fits.
const TRIES: usize = 3;
/// Deviation from that number that is accepted.
const COUNT_TOLERANCE: f64 = 0.04;

/// Lays a wall of about `panels` bricks.
///
/// # Errors
/// If there is no network, or no panelling with the surface's topology.
pub(crate) fn brick_wall(
    on: &BrickSurface<'_>,
    panels: usize,
    options: &BrickWallOptions,
) -> Result<(Layout, BrickWallStatistics), LayoutError> {
    let network = conjugate_network(on.surface, on.field, &options.network)?;
    let mut scale = first_scale(on, &network, panels, options);
    let mut best: Option<(f64, Wall<'_>)> = None;
    for _ in 0..TRIES {
        let wall = Wall::new(on, &network, scale)?;
        let ratio = wall.complex.panels.len() as f64 / panels.max(1) as f64;
        let error = ratio.ln().abs();
        if best.as_ref().is_none_or(|b| error < b.0) {
            best = Some((error, wall));
        }
        if error < COUNT_TOLERANCE {
            break;
        }
        scale = scale.map(|s| s / ratio.sqrt());
    }
    let (_, wall) = best.expect("at least one wall is built");
    Ok((wall.layout()?, wall.statistics()))
}

/// Bricks and rows per length for the wanted number and ratio.
pub(crate) fn first_scale(
    on: &BrickSurface<'_>,
    network: &ConjugateNetwork,
    panels: usize,
    options: &BrickWallOptions,
) -> [f64; 2] {
    // Fine steps, so that rounded periods do not distort the measure.
    const FINE: f64 = 1e3;
    let grid = BrickGrid::new(on.surface, network, [FINE, FINE], [0.0, 0.0]);
    let forms = BrickForms::new(on.surface, on.curvature, &grid);
    let stretch = match options.ratio {
        Some(ratio) => ratio / forms.ratio(),
        None => {
            // `rho` grows with the square of the ratio.
            let free = (KINK_GOAL / forms.kink_quantile(0.95).max(1e-6)).sqrt();
            let [least, largest] = RATIO_LIMITS.map(|r| r / forms.ratio());
            free.clamp(least, largest.max(least))
        }
    };
    let shrink = (panels as f64 / forms.bricks).sqrt();
    [
        FINE * shrink / stretch.sqrt(),
        FINE * shrink * stretch.sqrt(),
    ]
}

/// Cells of a wall and all that places its vertices.
struct Wall<'a> {
    on: BrickSurface<'a>,
    grid: BrickGrid,
    bricks: PerVertex<Brick>,
    forms: BrickForms,
    mesh: IntrinsicMesh,
    metric: PerVertex<Matrix3<f64>>,
    complex: CellComplex,
}

impl<'a> Wall<'a> {
    fn new(
        on: &BrickSurface<'a>,
        network: &ConjugateNetwork,
        scale: [f64; 2],
    ) -> Result<Self, LayoutError> {
        let topology = on.surface.topology();
        let grid = fit::fitted_grid(on.surface, network, scale);
        let forms = BrickForms::new(on.surface, on.curvature, &grid);
        let length_squared = on.surface.area() / forms.bricks.max(1.0);
        let metric = PerVertex::filled(topology.n_vertices(), Matrix3::identity() / length_squared);
        let mesh = IntrinsicMesh::new(on.surface, &metric);
        let bricks = grid.bricks(topology);
        let (label, middles) = grid.cells(topology, &bricks);
        let complex = disc_cells(topology, &mesh, on.corners, label, middles)
            .map_err(|cells| LayoutError::not_discs(on.surface, cells))?;
        Ok(Self {
            on: *on,
            grid,
            bricks,
            forms,
            mesh,
            metric,
            complex,
        })
    }

    fn layout(&self) -> Result<Layout, LayoutError> {
        let fine = CellSurface {
            surface: self.on.surface,
            metric: &self.metric,
            mesh: &self.mesh,
            corners: self.on.corners,
        };
        record(&fine, &self.complex, |node| self.place(node))
    }

    fn place(&self, node: Node) -> Vec3 {
        let surface = self.on.surface;
        match node {
            Node::Triangle(f) => self.junction(f).unwrap_or_else(|| place(surface, node)),
            Node::Edge(e) => {
                let [a, b] = surface.topology().edge_vertices(e);
                let t = self.grid.crossing(surface.topology(), &self.bricks, e);
                surface.positions()[a] * (1.0 - t) + surface.positions()[b] * t
            }
            Node::Corner(_) | Node::Rim(_) => place(surface, node),
        }
    }

    /// The kinked junction of the three bricks at the corners of a triangle, if it lies on the
    /// surface.
    fn junction(&self, f: FaceId) -> Option<Vec3> {
        let (surface, grid) = (self.on.surface, &self.grid);
        let topology = surface.topology();
        let junction = Junction::of(grid.corner_bricks(topology, &self.bricks, f))?;
        let start = (f, grid.chart(topology, f));
        let straight = locate::locate(surface, grid, start, junction.place(0.0))?;
        let corners = topology.face_vertices(straight.face);
        let kink = self.forms.face_kink(corners, straight.barycentric);
        let target = junction.place(kink.clamp(-MAX_KINK, MAX_KINK));
        let from = (straight.face, straight.chart);
        let end = locate::locate(surface, grid, from, target).unwrap_or(straight);
        Some(locate::curved_point(surface, end.face, end.barycentric))
    }

    fn statistics(&self) -> BrickWallStatistics {
        let kinks = || self.forms.along.ids().map(|v| self.forms.kink(v).abs());
        let clipped = kinks().filter(|k| *k > MAX_KINK).count();
        BrickWallStatistics {
            ratio: self.forms.ratio(),
            kink_p95: self.forms.kink_quantile(0.95),
            clipped: clipped as f64 / self.bricks.len() as f64,
            alignment_kept: self.on.field.alignment_kept,
        }
    }
}
