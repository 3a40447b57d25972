//! Distance between a mesh and the surface it stands for, both ways.

use super::Metric;
use super::metric::quantile;
use crate::clipped::ClippedMesh;
use crate::{
    BoundaryCurve, ElementId, FaceId, FlatFace, HexMesh, PerElement, PerFace, PerVertex,
    TriangleSurface, Vec3, VertexId,
};
use rayon::prelude::*;
use serde::Serialize;

/// Distances between a mesh and a surface, over the diagonal of the surface's bounding box unless
/// said otherwise.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Deviation {
    /// The diagonal that the figures refer to, in model units.
    pub diagonal: f64,
    /// Largest distance of a mesh vertex or face centre to the surface.
    pub deviation_max: f64,
    /// Root mean square of these distances.
    pub deviation_rms: f64,
    /// Distances of the mesh vertices to the surface.
    pub vertices: Metric<VertexId>,
    /// Distances of the face centres (mean of the corners) to the surface.
    pub face_centres: Metric<FaceId>,
    /// Largest distance of a surface vertex to the mesh.
    pub coverage_max: f64,
    /// 99 % quantile of these distances.
    pub coverage_p99: f64,
    /// Largest of them among the surface vertices that lie not in a band along the surface's
    /// boundary, which is two mean edges of the mesh wide or as the caller says; 0 if there are
    /// none, and `coverage_max` if the surface is closed.
    pub coverage_inner_max: f64,
    /// Distances of the surface vertices to the mesh; the ids are those of the surface.
    pub coverage: Metric<VertexId>,
    /// Whether the Euler characteristic and the number of boundary loops are those of the surface.
    pub same_topology: bool,
    /// Distance of each mesh vertex to the surface, in model units; not serialised.
    #[serde(skip)]
    pub vertex_distance: PerVertex<f64>,
    /// Distance of each face centre to the surface, in model units; not serialised.
    #[serde(skip)]
    pub face_distance: PerFace<f64>,
    /// Distance of each surface vertex to the mesh, in model units; not serialised.
    #[serde(skip)]
    pub coverage_distance: PerVertex<f64>,
    /// The face of the mesh closest to each surface vertex; not serialised.
    #[serde(skip)]
    pub coverage_face: PerVertex<FaceId>,
    /// Surface vertices that count for `coverage_inner_max`; not serialised.
    #[serde(skip)]
    pub inside: PerVertex<bool>,
}

/// Measures the distance between a mesh and a surface, both ways. The mesh's faces count as their
/// ear-clipped triangles.
pub fn deviation(mesh: &HexMesh, surface: &TriangleSurface) -> Deviation {
    let rows = 2.0 * mesh.mean_edge();
    deviation_beyond(mesh, surface, surface, |_| rows)
}

/// The same where panels may stick out beyond the boundary of `surface`: `beyond` is the surface
/// continued there, and the distance of the mesh is that to the continued surface. Points of the
/// surface that are as close to its boundary as `bare_rim` of the face closest to them, a length,
/// do not count as inside.
pub fn deviation_beyond(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    beyond: &TriangleSurface,
    bare_rim: impl Fn(FaceId) -> f64 + Sync,
) -> Deviation {
    let diagonal = surface.diagonal();
    let vertex_distance = to_surface(beyond, mesh.positions.as_slice());
    let face_distance: PerFace<f64> = to_surface(beyond, mesh.centres().as_slice());
    let both: Vec<f64> = vertex_distance
        .iter()
        .chain(&face_distance)
        .map(|d| d / diagonal)
        .collect();
    let (coverage_face, coverage_distance) = to_mesh(surface, mesh);
    let coverage = metric(&coverage_distance, diagonal);
    let inside = inside(surface, &coverage_face, bare_rim);
    let inner = coverage_distance.iter().zip(&inside).filter(|(_, i)| **i);
    Deviation {
        diagonal,
        deviation_max: both.iter().copied().fold(0.0, f64::max),
        deviation_rms: (both.iter().map(|d| d * d).sum::<f64>() / both.len() as f64).sqrt(),
        vertices: metric(&vertex_distance, diagonal),
        face_centres: metric(&face_distance, diagonal),
        coverage_max: coverage.max,
        coverage_p99: sorted_quantile(&coverage_distance, 0.99) / diagonal,
        coverage_inner_max: inner.map(|(d, _)| *d).fold(0.0, f64::max) / diagonal,
        coverage,
        same_topology: topology_key(mesh.topology()) == topology_key(surface.topology()),
        vertex_distance,
        face_distance,
        coverage_distance,
        coverage_face,
        inside,
    }
}

fn metric<I: ElementId>(distance: &PerElement<I, f64>, diagonal: f64) -> Metric<I> {
    Metric::large_is_bad(distance.enumerate().map(|(i, d)| (i, d / diagonal)))
}

fn to_surface<I: ElementId>(surface: &TriangleSurface, points: &[Vec3]) -> PerElement<I, f64> {
    let closest = surface.closest_points(points);
    let distances = points
        .iter()
        .zip(closest)
        .map(|(p, q)| (p - q.position).norm());
    PerElement::from_vec(distances.collect())
}

/// The face of the mesh closest to each surface vertex, and its distance.
fn to_mesh(surface: &TriangleSurface, mesh: &HexMesh) -> (PerVertex<FaceId>, PerVertex<f64>) {
    let closest = closest_faces(mesh, surface.positions().as_slice());
    let closest: (Vec<FaceId>, Vec<f64>) = closest.into_iter().unzip();
    (
        PerVertex::from_vec(closest.0),
        PerVertex::from_vec(closest.1),
    )
}

/// The face of the mesh closest to each point, and its distance, in model units. Faces count as
/// their ear-clipped triangles.
pub fn closest_faces(mesh: &HexMesh, points: &[Vec3]) -> Vec<(FaceId, f64)> {
    ClippedMesh::new(mesh, &FlatFace::all(mesh)).closest_of(points)
}

fn sorted_quantile(values: &PerVertex<f64>, q: f64) -> f64 {
    let mut sorted = values.as_slice().to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile(&sorted, q)
}

/// Surface vertices farther from the boundary than the bare rim of the face `closest` to them.
fn inside(
    surface: &TriangleSurface,
    closest: &PerVertex<FaceId>,
    bare_rim: impl Fn(FaceId) -> f64 + Sync,
) -> PerVertex<bool> {
    let boundary = BoundaryCurve::of(surface);
    let far = |(p, &f): (&Vec3, &FaceId)| {
        let curve = boundary.as_ref();
        curve.is_none_or(|b| !b.is_within(*p, bare_rim(f)))
    };
    let points = surface.positions().as_slice().par_iter();
    PerVertex::from_vec(points.zip(closest.as_slice()).map(far).collect())
}

fn topology_key(topology: &crate::Topology) -> (i64, usize) {
    (
        topology.euler_characteristic(),
        topology.boundary_loops().len(),
    )
}
