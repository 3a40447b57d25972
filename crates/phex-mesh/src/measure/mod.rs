//! Figures of a mesh: per element, and summed up.
//!
//! All lengths in the summary are relative, so that no unit matters; the per-element values are in
//! model units and radians. Definitions, with `L` the mean length of all edges:
//!
//! | figure | definition |
//! |---|---|
//! | `planarity` | of a face: largest distance of its vertices to its least-squares plane, over `L` |
//! | `planarity_diagonals` | of a face: root mean square, over the quadruples of consecutive vertices, of the distance between the lines of the two diagonals over their mean length |
//! | `edge_length` | over `L` |
//! | `clearance` | of a face, in its plane: least distance of a vertex to an edge that does not hold it, over `L` |
//! | `angle` | of a face, in its plane: least interior angle, in degrees |
//! | `area_ratio` | of a face, over the mean area; those below [`LEAST_RIM_AREA`] are `small_faces`, at the boundary or not |
//! | `dihedral` | of an interior edge: angle between its faces on the side away from their normals, in degrees; 180 is flat, less is convex |
//! | `hex` | faces with six corners among the faces without a boundary edge |
//! | `irregular` | faces without a boundary edge that have not six corners, less the `6 |chi|` that a closed mesh can't do without |
//! | `evenness` | spread of areas, edges and aspects of the faces without a boundary edge, see [`Evenness`] |
//! | `degree3` | interior vertices with exactly three faces, as a fraction |
//! | concave face | some corner turns to the right: unavoidable where the Gauss curvature is negative, and no fault |
//! | simple face | see [`is_simple`], in the face's plane |
//!
//! The two planarities are both in use and differ: 1 % by the diagonals is 1 to 2.5 % of an edge. A
//! planar face that intersects itself has planarity 0 by either, so planarity and simplicity are
//! always to be reported together.

mod boundary_fit;
mod deviation;
mod evenness;
mod metric;

pub use boundary_fit::{
    BoundaryFit, LEAST_RIM_AREA, Spot, boundary_fit, points_on_boundary, small_rim_faces,
};
pub use deviation::{Deviation, closest_faces, deviation, deviation_beyond};
pub use evenness::{AreasOverWished, Evenness, aspect};
pub use metric::{BINS, Histogram, Metric, WORST, quantile};

use crate::polygon::{interior_angles, is_simple};
use crate::{
    EdgeId, FaceId, FlatFace, HexMesh, PerEdge, PerElement, PerFace, PerHalfEdge, Topology, Vec3,
};
use serde::Serialize;

/// Clearance, in mean edges, below which a panel of mean area counts as tight.
const ROOMY_CLEARANCE: f64 = 0.31;
/// Area, over the mean, below which a panel needs less.
const NEEDS_LESS: f64 = 0.4;

/// Angle, degrees, that a corner should have at the least: a sharper one is allowed and not liked.
pub const WANTED_ANGLE: f64 = 20.0;
/// Length, in mean edges, that an edge of an inner panel should have at the most.
pub const WANTED_LENGTH: f64 = 2.2;
/// Area, over the mean, that a panel at the boundary should have at the most.
pub const WANTED_RIM_AREA: f64 = 2.0;
/// Length over width that a panel at the boundary should have at the most.
pub const WANTED_RIM_ASPECT: f64 = 3.0;
/// Distance between the boundaries of panels and surface, mean edges, that should not be exceeded.
pub const WANTED_RIM_DISTANCE: f64 = 0.15;

/// Clearance, in mean edges, that a panel should have, by its area over the mean: below it is
/// tight, which is allowed and not liked.
pub fn wanted_clearance(area_ratio: f64) -> f64 {
    ROOMY_CLEARANCE * (area_ratio / NEEDS_LESS).sqrt().min(1.0)
}
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Figures of a mesh; see the [module](self) for the definitions.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeshMeasures {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of edges.
    pub edges: usize,
    /// Number of faces.
    pub faces: usize,
    /// Number of edges with one face only.
    pub boundary_edges: usize,
    /// Number of closed loops that they form.
    pub boundary_loops: usize,
    /// Number of connected components.
    pub components: usize,
    /// Vertices minus edges plus faces.
    pub euler_characteristic: i64,
    /// Number of vertices that are not on the boundary.
    pub interior_vertices: usize,
    /// Fraction of those with exactly three faces; 1 if there are none.
    pub degree3: f64,
    /// Number of faces without a boundary edge.
    pub interior_faces: usize,
    /// Fraction of those with six corners; `None` if there are none.
    pub hex: Option<f64>,
    /// Number of interior faces that are irregular without need: see [`irregular_faces`].
    pub irregular: usize,
    /// Evenness of the interior faces; `None` if there are none.
    pub evenness: Option<Evenness>,
    /// Number of faces by their number of corners.
    pub face_sizes: BTreeMap<usize, usize>,
    /// Number of faces that are not simple in their plane.
    pub faces_not_simple: usize,
    /// Number of faces with a reflex corner, whether simple or not.
    pub faces_concave: usize,
    /// Number of faces with a reflex corner that are simple, hence valid.
    pub faces_concave_simple: usize,
    /// Mean edge length, in model units.
    pub mean_edge: f64,
    /// Diagonal of the bounding box, in model units.
    pub diagonal: f64,
    /// Sum of the faces' areas, in squared model units.
    pub area: f64,
    /// Area of the largest face over the total.
    pub largest_face_over_area: f64,
    /// Planarity by the distance to the least-squares plane, over the mean edge.
    pub planarity: Metric<FaceId>,
    /// The same in model units.
    pub planarity_length: Metric<FaceId>,
    /// Planarity by the distance between diagonals, over their mean length.
    pub planarity_diagonals: Metric<FaceId>,
    /// Edge lengths over the mean edge.
    pub edge_length: Metric<EdgeId>,
    /// Clearances over the mean edge.
    pub clearance: Metric<FaceId>,
    /// Least interior angles of the faces, in degrees.
    pub angle: Metric<FaceId>,
    /// Dihedral angles of the interior edges, in degrees; the ones farthest from 180 are the worst.
    pub dihedral: Metric<EdgeId>,
    /// Areas of the faces over the total.
    pub face_area: Metric<FaceId>,
    /// The same over the mean area; small ones are the worst.
    pub area_ratio: Metric<FaceId>,
    /// Faces with less than [`LEAST_RIM_AREA`] of the mean area, wherever they are.
    pub small_faces: Vec<FaceId>,
    /// The values that were summed up; not serialised.
    #[serde(skip)]
    pub per_element: ElementMeasures,
}

/// Figures per element, in model units and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct ElementMeasures {
    /// Largest distance of a face's vertices to its least-squares plane, a length.
    pub planarity_length: PerFace<f64>,
    /// Planarity by the diagonals, without unit.
    pub planarity_diagonals: PerFace<f64>,
    /// Clearance of each face, a length.
    pub clearance: PerFace<f64>,
    /// Area of each face.
    pub area: PerFace<f64>,
    /// Whether each face is simple.
    pub simple: PerFace<bool>,
    /// Whether each face has a reflex corner.
    pub concave: PerFace<bool>,
    /// Interior angle of the corner where each half-edge starts, in radians, in the face's plane.
    pub corner_angle: PerHalfEdge<f64>,
    /// Length of each edge.
    pub edge_length: PerEdge<f64>,
    /// Dihedral angle of each edge in radians, in (0, 2 pi); `None` on the boundary.
    pub dihedral: PerEdge<Option<f64>>,
}

/// Measures a mesh, valid or not.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// let measures = phex_mesh::measure(&cube);
/// assert_eq!((measures.faces, measures.degree3), (6, 1.0));
/// assert_eq!(measures.per_element.planarity_length.iter().copied().fold(0.0, f64::max), 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn measure(mesh: &HexMesh) -> MeshMeasures {
    let topology = mesh.topology();
    let mean_edge = mesh.mean_edge();
    let flat = FlatFace::all(mesh);
    let values = ElementMeasures::new(mesh, &flat, mean_edge);
    let area: f64 = values.area.iter().sum();
    let face_area = Metric::large_is_bad(scaled(&values.area, 1.0 / area));
    let over_mean = topology.n_faces() as f64 / area;
    let small = scaled(&values.area, over_mean).filter(|a| a.1 < LEAST_RIM_AREA);
    MeshMeasures {
        vertices: topology.n_vertices(),
        edges: topology.n_edges(),
        faces: topology.n_faces(),
        boundary_edges: topology.boundary_edges().count(),
        boundary_loops: topology.boundary_loops().len(),
        components: topology.components().1,
        euler_characteristic: topology.euler_characteristic(),
        interior_vertices: interior_vertices(topology),
        degree3: degree3(topology),
        interior_faces: interior_faces(topology).count(),
        hex: hex(topology),
        irregular: irregular_faces(topology),
        evenness: Evenness::of(mesh, &flat),
        face_sizes: face_sizes(topology),
        faces_not_simple: values.simple.iter().filter(|&&s| !s).count(),
        faces_concave: values.concave.iter().filter(|&&c| c).count(),
        faces_concave_simple: values
            .concave
            .iter()
            .zip(&values.simple)
            .filter(|&(&c, &s)| c && s)
            .count(),
        mean_edge,
        diagonal: mesh.diagonal(),
        area,
        largest_face_over_area: face_area.max,
        planarity: Metric::large_is_bad(scaled(&values.planarity_length, 1.0 / mean_edge)),
        planarity_length: Metric::large_is_bad(scaled(&values.planarity_length, 1.0)),
        planarity_diagonals: Metric::large_is_bad(scaled(&values.planarity_diagonals, 1.0)),
        edge_length: Metric::small_is_bad(scaled(&values.edge_length, 1.0 / mean_edge)),
        clearance: Metric::small_is_bad(scaled(&values.clearance, 1.0 / mean_edge)),
        angle: Metric::small_is_bad(least_angles(topology, &values.corner_angle)),
        dihedral: dihedral_metric(&values.dihedral),
        face_area,
        area_ratio: Metric::small_is_bad(scaled(&values.area, over_mean)),
        small_faces: small.map(|a| a.0).collect(),
        per_element: values,
    }
}

impl MeshMeasures {
    /// The same, with the areas of the inner faces compared with those that they are to have.
    pub fn over_wished(mut self, mesh: &HexMesh, wished: &PerFace<f64>) -> Self {
        if let Some(evenness) = &mut self.evenness {
            let areas = &self.per_element.area;
            evenness.over_wished = AreasOverWished::of(mesh.topology(), areas, wished);
        }
        self
    }
}

impl ElementMeasures {
    fn new(mesh: &HexMesh, faces: &PerFace<FlatFace>, mean_edge: f64) -> Self {
        let topology = mesh.topology();
        let corner_angles = faces
            .iter()
            .flat_map(|f| interior_angles(&f.polygon))
            .collect();
        Self {
            planarity_length: faces.map(|f| f.planarity_length),
            planarity_diagonals: PerFace::from_fn(faces.len(), |f| {
                planarity_diagonals(&mesh.corners(f).collect::<Vec<_>>())
            }),
            clearance: faces.map(|f| f.clearance().distance),
            area: faces.map(FlatFace::area),
            simple: faces.map(|f| is_simple(&f.polygon)),
            concave: faces.map(|f| f.is_concave(mean_edge)),
            corner_angle: PerHalfEdge::from_vec(corner_angles),
            edge_length: PerEdge::from_fn(topology.n_edges(), |e| mesh.edge_length(e)),
            dihedral: PerEdge::from_fn(topology.n_edges(), |e| dihedral(mesh, faces, e)),
        }
    }
}

/// Root mean square, over the quadruples of consecutive corners, of the distance between the lines
/// of the two diagonals over their mean length; 0 for a triangle, and for diagonals that are
/// parallel to 1e-8.
pub fn planarity_diagonals(corners: &[Vec3]) -> f64 {
    let n = corners.len();
    if n < 4 {
        return 0.0;
    }
    let quadruple = |i: usize| diagonal_distance(std::array::from_fn(|k| corners[(i + k) % n]));
    ((0..n).map(|i| quadruple(i).powi(2)).sum::<f64>() / n as f64).sqrt()
}

fn diagonal_distance([a, b, c, d]: [Vec3; 4]) -> f64 {
    let (first, second) = (c - a, d - b);
    let (lengths, cross) = ([first.norm(), second.norm()], first.cross(&second));
    if cross.norm() <= 1e-8 * lengths[0] * lengths[1] {
        return 0.0;
    }
    let distance = cross.dot(&(b - a)).abs() / cross.norm();
    distance / (0.5 * (lengths[0] + lengths[1]))
}

/// Angle in radians between the faces of an edge on the side away from their normals, in (0, 2 pi);
/// `None` on the boundary.
fn dihedral(mesh: &HexMesh, faces: &PerFace<FlatFace>, e: EdgeId) -> Option<f64> {
    let topology = mesh.topology();
    let h = topology.edge_half_edge(e);
    let twin = topology.twin(h)?;
    let (left, right) = (
        faces[topology.face(h)].normal(),
        faces[topology.face(twin)].normal(),
    );
    let along = mesh.position(topology.target(h)) - mesh.position(topology.origin(h));
    let bend = left
        .cross(&right)
        .norm()
        .copysign(left.cross(&right).dot(&along));
    Some(PI - bend.atan2(left.dot(&right)))
}

fn dihedral_metric(dihedral: &PerEdge<Option<f64>>) -> Metric<EdgeId> {
    let values = dihedral
        .enumerate()
        .filter_map(|(e, d)| d.map(|d| (e, d.to_degrees())));
    Metric::new(values, |degrees| (degrees - 180.0).abs())
}

fn least_angles(
    topology: &Topology,
    angles: &PerHalfEdge<f64>,
) -> impl Iterator<Item = (FaceId, f64)> {
    let least = move |f| {
        topology
            .face_half_edges(f)
            .map(|h| angles[h])
            .fold(f64::INFINITY, f64::min)
    };
    topology.faces().map(move |f| (f, least(f).to_degrees()))
}

fn scaled<I: crate::ElementId>(
    values: &PerElement<I, f64>,
    factor: f64,
) -> impl Iterator<Item = (I, f64)> {
    values.enumerate().map(move |(i, x)| (i, x * factor))
}

fn interior_vertices(topology: &Topology) -> usize {
    topology.inner_vertices().count()
}

fn degree3(topology: &Topology) -> f64 {
    let regular = |&v: &_| !topology.is_boundary_vertex(v) && topology.face_degree(v) == 3;
    match interior_vertices(topology) {
        0 => 1.0,
        interior => topology.vertices().filter(regular).count() as f64 / interior as f64,
    }
}

fn interior_faces(topology: &Topology) -> impl Iterator<Item = FaceId> {
    topology.inner_faces()
}

fn hex(topology: &Topology) -> Option<f64> {
    let interior = interior_faces(topology).count();
    let hexagons = interior_faces(topology)
        .filter(|&f| topology.valence(f) == 6)
        .count();
    (interior > 0).then(|| hexagons as f64 / interior as f64)
}

/// Number of faces without a boundary edge that have not six corners, beyond those that the Euler
/// characteristic `chi` of a closed mesh of degree 3 asks for: `6 |chi|` pentagons or heptagons.
pub fn irregular_faces(topology: &Topology) -> usize {
    let irregular = interior_faces(topology).filter(|&f| topology.valence(f) != 6);
    let closed = topology.is_closed();
    let needed = 6 * topology.euler_characteristic().unsigned_abs() as usize;
    irregular
        .count()
        .saturating_sub(if closed { needed } else { 0 })
}

fn face_sizes(topology: &Topology) -> BTreeMap<usize, usize> {
    let mut sizes = BTreeMap::new();
    for f in topology.faces() {
        *sizes.entry(topology.valence(f)).or_insert(0) += 1;
    }
    sizes
}
