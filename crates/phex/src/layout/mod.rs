//! Layout: connectivity and first positions of the panels.
//!
//! 1. `lattice/waves`: lattice offsets by diffusion and projection of three waves in the charts of
//!    the direction field; `lattice/polish`: Gauss-Seidel.
//! 2. `lattice/dislocations`: Burgers vectors moved into opposites, cones or the boundary;
//!    `lattice/seamless`: one linear solve for the lattice; vectors come back where it would be
//!    strained too much (`lattice/strain`).
//! 3. `cells/clusters`: one seed vertex per lattice point; `cells/voronoi`: geodesic cells in the
//!    metric, on a finer mesh.
//! 4. `cells/complex`: discs whose outlines are the panels; triangles with three labels are
//!    vertices, so every interior vertex has degree 3 by construction.
//! 5. `moves/flips`, `moves/glide`, `moves/halves`: edges turn and cut panels are joined where that
//!    makes the panels more regular.
//!
//! Guaranteed: the panelling has the Euler characteristic and the boundary loops of the surface,
//! every interior vertex has degree 3, sharp boundary corners are kept as corners of one panel.
//! Fails, with an error that says so: where panels are so large that cells can't be made discs.

pub(crate) mod brick_wall;
mod cells;
pub(crate) mod forecast;
pub(crate) mod lattice;
pub(crate) mod moves;
pub(crate) mod record;
pub(crate) mod seeds;
#[cfg(test)]
mod stage_tests;
pub(crate) mod tangent_planes;

pub use brick_wall::{BrickWallOptions, BrickWallStatistics};
pub use lattice::dislocations::Annihilation;
pub use lattice::eisenstein::CELL;
pub use record::{Layout, PanelWish, VertexKind};
pub use seeds::Seed;

use crate::classical::{DomainError, DualityError, PowerError};
use crate::directions::Directions;
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::network::NetworkError;
use crate::progress::Progress;
use cells::complex::{CellComplex, Node, NotDiscs, disc_cells};
use cells::voronoi::UNREACHED;
use cells::{boundary_nodes, clusters, rim};
use lattice::charted::ChartedSurface;
use lattice::eisenstein::Charts;
use lattice::seamless::Offsets;
use lattice::{boundary, polish, strain, waves};
use moves::{flips, halves};
use nalgebra::Matrix3;
use phex_mesh::{HexMesh, PerFace, PerVertex, Topology, TriangleSurface, Vec3, VertexId, numbered};
use phex_numeric::NumericError;
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::fmt;
use thiserror::Error;

/// Most panels that one run is asked for: the refined surface has 25 vertices and more for each,
/// and memory ends.
pub const MAX_PANELS: usize = 200_000;

/// How panels are laid out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LayoutOptions {
    /// Seed of the random start of the waves.
    pub seed: u64,
    /// Sweeps of the Gauss-Seidel polish.
    pub sweeps: usize,
    /// Longest path, in panels, along which a dislocation is moved to vanish (0: dislocations stay;
    /// `None`: any).
    pub annihilation_length: Option<f64>,
    /// Largest 95 % quantile of the edges' distortion that vanished dislocations may cost; above it
    /// those come back that strain pulls on the hardest.
    pub max_distortion: f64,
    /// Largest pull of strain on a dislocation that has vanished (the fall of the sum over edges of
    /// weights and squared residuals, in lattice spacings, when it comes back); above it the
    /// dislocation does come back, and panels are more even. `None`: any.
    pub max_pull: Option<f64>,
}

impl Default for LayoutOptions {
    fn default() -> Self {
        Self {
            seed: 0,
            sweeps: 60,
            annihilation_length: None,
            max_distortion: 0.35,
            max_pull: None,
        }
    }
}

/// Why no layout exists.
#[derive(Clone, Debug, Error)]
pub enum LayoutError {
    /// A linear system could not be solved.
    #[error("the layout's equations could not be solved: {0}")]
    Numeric(#[from] NumericError),
    /// There is no conjugate network for a brick wall.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The surface is none that the method is made for.
    #[error(transparent)]
    Domain(#[from] DomainError),
    /// Planes that do not meet.
    #[error(transparent)]
    Duality(#[from] DualityError),
    /// There is no power diagram.
    #[error(transparent)]
    Power(#[from] PowerError),
    /// The caller cancelled before there was a layout.
    #[error("cancelled")]
    Cancelled,
    /// Panels are larger than what the surface goes round.
    #[error(
        "no panelling with the topology of the surface was found: {}; ask for smaller panels",
        told_not_discs(*panels, *place, *handles)
    )]
    NotDiscs {
        /// How many.
        panels: usize,
        /// The middle of the first one.
        place: Vec3,
        /// Handles of the surface: the holes through a closed one, one of a torus.
        handles: usize,
    },
    /// There are no panels, or they are joined otherwise than the surface.
    #[error(
        "no panelling with the topology of the surface was found: {reason}; ask for smaller panels"
    )]
    Topology {
        /// What went wrong.
        reason: String,
    },
}

impl LayoutError {
    pub(crate) fn topology(reason: impl fmt::Display) -> Self {
        let reason = reason.to_string();
        Self::Topology { reason }
    }

    pub(crate) fn not_discs(surface: &TriangleSurface, cells: NotDiscs) -> Self {
        let topology = surface.topology();
        let loops = topology.boundary_loops().len() as i64;
        let handles = (2 - topology.euler_characteristic() - loops) / 2;
        Self::NotDiscs {
            panels: cells.cells,
            place: surface.positions()[cells.seed],
            handles: handles.max(0) as usize,
        }
    }

    /// The error with places mapped.
    pub(crate) fn mapped(self, map: impl Fn(Vec3) -> Vec3) -> Self {
        match self {
            Self::Duality(e) => e.mapped(map).into(),
            Self::Network(e) => e.mapped(map).into(),
            Self::NotDiscs {
                panels,
                place,
                handles,
            } => Self::NotDiscs {
                panels,
                place: map(place),
                handles,
            },
            other => other,
        }
    }
}

fn told_not_discs(panels: usize, place: Vec3, handles: usize) -> String {
    let [x, y, z] = [place.x, place.y, place.z];
    let why = match handles {
        0 => ", where the surface has a neck or a hole that is smaller than a panel".into(),
        n => format!(
            " (handles of the surface: {n}; one that is smaller than a panel, as reconstructed \
             surfaces have by mistake, must be closed first)"
        ),
    };
    let place = format!("({x:.6}, {y:.6}, {z:.6})");
    match panels {
        1 => format!("a panel could not be made a disc, near {place}{why}"),
        _ => format!("{panels} panels could not be made discs, the first near {place}{why}"),
    }
}

/// What the position step reached.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct LayoutStatistics {
    /// Seed of the random start that led to it.
    pub seed: u64,
    /// Cones of the direction field (triangles with an index).
    pub cones: usize,
    /// Pairs of opposite cones that were cancelled.
    pub cancelled: usize,
    /// What became of the dislocations.
    pub annihilation: Annihilation,
    /// 95 % quantile of the edges' distortion.
    pub distortion_p95: f64,
}

/// The panels' seeds and the lattice that they lie on.
#[derive(Clone, Debug)]
pub struct Placed {
    /// One seed per panel, in the order of their vertices.
    pub seeds: Vec<Seed>,
    /// What was reached.
    pub statistics: LayoutStatistics,
}

/// Seed vertices of the panels.
///
/// # Errors
/// If a linear system can't be solved, or the caller cancels.
pub fn place_seeds(
    topology: &Topology,
    directions: &Directions,
    options: &LayoutOptions,
    progress: &dyn Progress,
) -> Result<Placed, LayoutError> {
    let charted = ChartedSurface {
        topology,
        mesh: &directions.intrinsic,
        charts: &Charts::new(topology, directions),
        pins: &boundary::pins(topology, directions),
    };
    let mut position = waves::diffuse(&charted, options.seed, progress);
    unless_cancelled(progress)?;
    polish::polish(&charted, &mut position, options.sweeps);
    unless_cancelled(progress)?;
    let rounded = Offsets::rounded(&charted, position);
    let (offsets, annihilation, distortion_p95) =
        strain::seamless_offsets(&charted, rounded, options, progress)?;
    let offsets = offsets.reduced(&charted);
    let statistics = LayoutStatistics {
        seed: options.seed,
        cones: directions.cone.iter().filter(|c| **c != 0).count(),
        cancelled: directions.cancelled,
        annihilation,
        distortion_p95,
    };
    Ok(Placed {
        seeds: clusters::seeds(&charted, &offsets),
        statistics,
    })
}

/// Ends a layout that is not wanted any more.
fn unless_cancelled(progress: &dyn Progress) -> Result<(), LayoutError> {
    match progress.is_cancelled() {
        true => Err(LayoutError::Cancelled),
        false => Ok(()),
    }
}

/// The fine surface on which cells are drawn.
pub struct CellSurface<'a> {
    /// The surface.
    pub surface: &'a TriangleSurface,
    /// Its metric, in lattice spacings.
    pub metric: &'a PerVertex<Matrix3<f64>>,
    /// The same as lengths.
    pub mesh: &'a IntrinsicMesh,
    /// Sharp corners of the boundary.
    pub corners: &'a HashSet<VertexId>,
}

/// The panelling whose cells grow from `seeds`.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let torus = triangulate(&Shape::from_name("torus", &[])?, &TriangulationOptions::default())?;
/// use phex::Silent;
/// use phex::curvature::{CurvatureOptions, curvature};
/// use phex::directions::{DirectionOptions, directions};
/// use phex::layout::{CellSurface, LayoutOptions, panelling, place_seeds};
///
/// let length = 0.1 * torus.diagonal();
/// let bent = curvature(&torus, length, &CurvatureOptions::default());
/// let field = directions(&torus, &bent, length, &DirectionOptions::default())?;
/// let placed = place_seeds(torus.topology(), &field, &LayoutOptions::default(), &Silent)?;
/// let cells = CellSurface {
///     surface: &torus.with_normals(bent.normal),
///     metric: &field.metric,
///     mesh: &field.intrinsic,
///     corners: &Default::default(),
/// };
/// let layout = panelling(&cells, &placed.seeds, &Silent)?;
/// // Hexagons alone cover a torus.
/// let panels = layout.mesh.topology();
/// assert!(panels.faces().all(|f| panels.valence(f) == 6));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If no panelling with the surface's topology is found, or the caller cancels.
pub fn panelling(
    fine: &CellSurface<'_>,
    seeds: &[Seed],
    progress: &dyn Progress,
) -> Result<Layout, LayoutError> {
    if seeds.is_empty() {
        return Err(LayoutError::topology(
            "panels are too large for the surface: none of them lies on it",
        ));
    }
    let topology = fine.surface.topology();
    let (seeds, grown) = rim::even_rim(fine, seeds, progress);
    unless_cancelled(progress)?;
    if grown.label.iter().any(|l| *l == UNREACHED) {
        return Err(LayoutError::topology(
            "a part of it is not connected with the rest, and no panel is there",
        ));
    }
    let vertices = seeds.iter().map(|s| s.vertex).collect();
    let mut complex = disc_cells(topology, fine.mesh, fine.corners, grown.label, vertices)
        .map_err(|cells| LayoutError::not_discs(fine.surface, cells))?;
    boundary_nodes::follow_boundary(fine.surface, &mut complex);
    unless_cancelled(progress)?;
    record(fine, &complex, |node| place(fine.surface, node))
}

/// The layout with panels made more regular where turning edges or joining halves can: for the
/// optimiser, which finds them good places; methods that need the cells' own neighbours do without.
///
/// # Errors
/// If the caller cancels.
pub fn calmed(layout: Layout, progress: &dyn Progress) -> Result<Layout, LayoutError> {
    let turned = flips::turn_edges(layout, progress);
    let joined = halves::join_halves(turned, progress);
    let calm = flips::turn_edges(joined, progress);
    unless_cancelled(progress).map(|()| calm)
}

fn centroids(fine: &CellSurface<'_>, label: &PerVertex<u32>, count: usize) -> Vec<Vec3> {
    let mut sum = vec![Vec3::zeros(); count];
    let mut area = vec![0.0; count];
    for (v, &l) in label.enumerate() {
        sum[l as usize] += fine.surface.positions()[v] * fine.mesh.mass[v];
        area[l as usize] += fine.mesh.mass[v];
    }
    let middle = |(s, a): (Vec3, &f64)| s / a.max(f64::MIN_POSITIVE);
    sum.into_iter().zip(&area).map(middle).collect()
}

/// The layout whose panels are the cells, with its vertices where `place` says.
fn record(
    fine: &CellSurface<'_>,
    complex: &CellComplex,
    place: impl Fn(Node) -> Vec3,
) -> Result<Layout, LayoutError> {
    let topology = fine.surface.topology();
    let outlines = complex.panels.iter().map(|(_, l)| l.iter().copied());
    let (nodes, faces) = numbered(outlines);
    let positions = nodes.iter().map(|n| place(*n)).collect();
    let mesh = HexMesh::new(positions, &faces).map_err(LayoutError::topology)?;
    same_topology(topology, mesh.topology()).map_err(LayoutError::topology)?;
    let centroid = centroids(fine, &complex.label, complex.seed.len());
    let middle: Vec<Vec3> = complex
        .panels
        .iter()
        .map(|(c, _)| centroid[*c as usize])
        .collect();
    let foot = fine.surface.closest_points(&middle);
    let seed: Vec<VertexId> = complex
        .panels
        .iter()
        .map(|(c, _)| complex.seed[*c as usize])
        .collect();
    let length = seed.iter().map(|&s| local_length(fine, s)).collect();
    let kinds = PerVertex::from_vec(nodes.iter().map(|n| kind(*n)).collect());
    let feet = foot.iter().map(|p| (p.position, p.normal));
    Ok(Layout {
        face_seed: PerFace::from_vec(seed),
        ..Layout::new(mesh, kinds, feet, PerFace::from_vec(length))
    })
}

/// Length of a lattice spacing at a vertex: the determinant of the metric in the tangent plane is
/// its inverse squared, squared.
fn local_length(fine: &CellSurface<'_>, v: VertexId) -> f64 {
    let [e1, e2] = crate::curvature::tangent_frame(fine.surface.normals()[v]);
    let m = &fine.metric[v];
    let (a, b, d) = (e1.dot(&(m * e1)), e1.dot(&(m * e2)), e2.dot(&(m * e2)));
    (a * d - b * b).max(f64::MIN_POSITIVE).powf(-0.25)
}

fn kind(node: Node) -> VertexKind {
    match node {
        Node::Triangle(_) => VertexKind::Interior,
        Node::Edge(_) | Node::Rim(_) => VertexKind::Boundary,
        Node::Corner(_) => VertexKind::BoundaryCorner,
    }
}

fn place(surface: &TriangleSurface, node: Node) -> Vec3 {
    match node {
        Node::Triangle(f) => surface.centroid(f),
        Node::Edge(e) => {
            let [a, b] = surface.topology().edge_vertices(e);
            (surface.positions()[a] + surface.positions()[b]) * 0.5
        }
        Node::Corner(v) | Node::Rim(v) => surface.positions()[v],
    }
}

/// Whether panels have the Euler characteristic and as many boundary loops as their surface.
///
/// # Errors
/// What they have instead.
pub(crate) fn same_topology(surface: &Topology, panels: &Topology) -> Result<(), String> {
    let figures = |t: &Topology| (t.euler_characteristic(), t.boundary_loops().len());
    let (want, got) = (figures(surface), figures(panels));
    if want == got {
        return Ok(());
    }
    Err(format!(
        "the panels have Euler characteristic {} and {} boundary loops, the surface {} and {}",
        got.0, got.1, want.0, want.1
    ))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    #[test]
    fn panels_that_are_no_discs_are_told_with_their_place_and_why() {
        let made = |name| {
            let shape = Shape::from_name(name, &[]).unwrap();
            let surface = triangulate(&shape, &TriangulationOptions::default()).unwrap();
            let seed = VertexId::new(7);
            let error = LayoutError::not_discs(&surface, NotDiscs { cells: 2, seed });
            let p = surface.positions()[seed] * 10.0;
            let place = format!("({:.6}, {:.6}, {:.6})", p.x, p.y, p.z);
            (error.mapped(|p| p * 10.0).to_string(), place)
        };
        for (name, why) in [
            ("torus", "handles of the surface: 1"),
            ("sphere", "a neck or a hole"),
        ] {
            let (told, place) = made(name);
            assert!(
                told.contains(&format!(
                    "2 panels could not be made discs, the first near {place}"
                )),
                "{told}"
            );
            assert!(told.contains(why), "{told}");
        }
    }

    /// Regular hexagons in a rhombus of `n` by `n`.
    pub(crate) fn lattice_patch(n: i32) -> Layout {
        let mut index = std::collections::HashMap::new();
        let mut positions = Vec::new();
        let mut faces = Vec::new();
        let mut middle = Vec::new();
        for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
            let c = Vec3::new(f64::from(i) + 0.5 * f64::from(k), CELL * f64::from(k), 0.0);
            let corner = |m: u32| {
                let a = std::f64::consts::FRAC_PI_3 * (f64::from(m) + 0.5);
                c + Vec3::new(a.cos(), a.sin(), 0.0) / 3.0_f64.sqrt()
            };
            let face = (0..6).map(corner).map(|p| {
                let key = [p.x, p.y].map(|x| (x * 1e6).round() as i64);
                *index.entry(key).or_insert_with(|| {
                    positions.push(p);
                    positions.len() as u32 - 1
                })
            });
            faces.push(face.collect::<Vec<u32>>());
            middle.push(c);
        }
        let mesh = HexMesh::new(positions, &faces).expect("a patch of a lattice");
        let kinds = VertexKind::of_mesh(&mesh);
        let feet = middle.into_iter().map(|p| (p, Vec3::z()));
        let lengths = PerFace::filled(faces.len(), 1.0);
        Layout {
            face_seed: PerFace::from_vec((0..faces.len() as u32).map(VertexId::new).collect()),
            ..Layout::new(mesh, kinds, feet, lengths)
        }
    }

    /// The layout with a panel cut from the middle of one edge to the middle of the opposite one.
    pub(crate) fn cut_in_two(layout: &Layout, f: phex_mesh::FaceId) -> Layout {
        let topology = layout.mesh.topology();
        let ring: Vec<VertexId> = topology.face_vertices(f).to_vec();
        let mut faces = topology.face_lists();
        let mut positions = layout.mesh.positions.as_slice().to_vec();
        let new = [0, 1].map(|k| (positions.len() + k) as u32);
        let id = |i: usize| ring[i].index() as u32;
        for (k, i) in [0, 3].into_iter().enumerate() {
            positions
                .push((layout.mesh.position(ring[i]) + layout.mesh.position(ring[i + 1])) * 0.5);
            let across = faces.iter_mut().enumerate().find(|(g, face)| {
                *g != f.index() && face.contains(&id(i)) && face.contains(&id(i + 1))
            });
            let face = across.expect("a panel across").1;
            let at = face.iter().position(|w| *w == id(i)).expect("its corner");
            face.insert(at, new[k]);
        }
        faces[f.index()] = vec![new[0], id(1), id(2), id(3), new[1]];
        faces.push(vec![new[1], id(4), id(5), id(0), new[0]]);
        let mut cut = layout.clone();
        let mut kinds = cut.vertex_kind.into_vec();
        kinds.extend([VertexKind::Interior; 2]);
        cut.vertex_kind = PerVertex::from_vec(kinds);
        let again =
            |v: &PerFace<Vec3>| PerFace::from_vec(v.iter().copied().chain([v[f]]).collect());
        cut.face_point = again(&cut.face_point);
        cut.face_normal = again(&cut.face_normal);
        cut.face_length = PerFace::filled(faces.len(), 1.0);
        cut.face_wish = PerFace::filled(faces.len(), PanelWish::ANY);
        cut.face_seed = PerFace::from_vec((0..faces.len() as u32).map(VertexId::new).collect());
        cut.mesh = HexMesh::new(positions, &faces).expect("a cut patch");
        cut
    }
}
