//! How a mesh ends where its surface ends.

use super::Metric;
use crate::clipped::ClippedMesh;
use crate::{BoundaryCurve, FaceId, FlatFace, HexMesh, TriangleSurface, Vec3, VertexId};
use rayon::prelude::*;
use serde::Serialize;

/// Least area of a face at the boundary, in mean areas.
pub const LEAST_RIM_AREA: f64 = 0.25;
/// Points on each edge of the mesh's boundary whose distance to the curve is measured, its start
/// included.
const ALONG: usize = 4;
/// Rows of points in a triangle near a boundary, of which those count that lie on this side of it.
const ROWS: usize = 8;
/// Turning angle, degrees, above which a vertex of the surface's boundary is a corner.
const CORNER: f64 = 40.0;
/// Difference of two distances, over the diagonal, that is rounding.
const SAME: f64 = 1e-9;

/// Figures of the boundary; lengths over the diagonal of the surface's bounding box.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BoundaryFit {
    /// Largest distance of a vertex of the mesh's boundary to the surface's boundary.
    pub vertices_max: f64,
    /// Largest distance of a point on the mesh's boundary to the surface's boundary.
    pub to_curve_max: f64,
    /// Largest distance of a vertex of the surface's boundary to the mesh's boundary.
    pub from_curve_max: f64,
    /// Share of the surface's area that panels cover, 0 to 1: that whose closest point of the mesh
    /// is not on its boundary.
    pub covered_area: f64,
    /// Share of the mesh's area beyond the boundary, 0 to 1: that whose closest point of the
    /// surface is on its boundary.
    pub overhang_area: f64,
    /// Corners of the surface's boundary: vertices where it turns by more than 40 degrees.
    pub corners: usize,
    /// Largest distance of a corner to the nearest vertex of the mesh's boundary; 0 if there are
    /// none.
    pub corner_max: f64,
    /// Areas of the faces at the boundary over the mean area of all faces.
    pub rim_area: Metric<FaceId>,
    /// Those with less than [`LEAST_RIM_AREA`].
    pub small: Vec<FaceId>,
    /// How far the boundaries are apart, at points of both; not serialised.
    #[serde(skip)]
    pub apart: Vec<Spot>,
    /// Points of the surface that no panel covers, with their distance to the mesh; not serialised.
    #[serde(skip)]
    pub bare: Vec<Spot>,
}

/// A point, how far it is from what it is compared with, and the face there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The face of the mesh that holds the point, or is closest to it.
    pub face: FaceId,
    /// The point, model coordinates.
    pub point: Vec3,
    /// The distance over the diagonal of the surface's bounding box.
    pub distance: f64,
}

impl BoundaryFit {
    /// Largest distance between the two boundaries, either way.
    pub fn distance_max(&self) -> f64 {
        self.to_curve_max.max(self.from_curve_max)
    }
}

/// Compares the boundary of a mesh with that of a surface; `None` if one of them is closed.
pub fn boundary_fit(mesh: &HexMesh, surface: &TriangleSurface) -> Option<BoundaryFit> {
    let curve = BoundaryCurve::of(surface)?;
    let rim: Vec<Vec<Vec3>> = rim_loops(mesh);
    let rim_curve = BoundaryCurve::of_polylines(&rim)?;
    let diagonal = surface.diagonal();
    let vertices: Vec<Vec3> = rim.iter().flatten().copied().collect();
    let panels = ClippedMesh::new(mesh, &FlatFace::all(mesh));
    let loops = surface.topology().boundary_loops();
    let place = |v: &VertexId| surface.positions()[*v];
    let boundary: Vec<Vec3> = loops.iter().flatten().map(place).collect();
    let mut apart = spots(&points_on_boundary(mesh), &curve, diagonal);
    let to_curve_max = largest(&apart);
    let behind: Vec<(FaceId, Vec3)> = (boundary.par_iter())
        .map(|&p| (panels.closest(p).0, p))
        .collect();
    let from_boundary = spots(&behind, &rim_curve, diagonal);
    let from_curve_max = largest(&from_boundary);
    apart.extend(from_boundary);
    let (covered_area, bare) = covered(&panels, surface, &rim_curve);
    let corners: Vec<Vec3> = loops.iter().flat_map(|l| corners(surface, l)).collect();
    let to_vertex = |p: &Vec3| {
        let distances = vertices.iter().map(|v| (v - p).norm());
        distances.fold(f64::INFINITY, f64::min)
    };
    Some(BoundaryFit {
        vertices_max: vertices
            .iter()
            .map(|p| distance(&curve, *p))
            .fold(0.0, f64::max)
            / diagonal,
        to_curve_max,
        from_curve_max,
        covered_area,
        overhang_area: overhang(&panels, surface, &curve),
        corners: corners.len(),
        corner_max: corners.iter().map(to_vertex).fold(0.0, f64::max) / diagonal,
        rim_area: Metric::small_is_bad(rim_areas(mesh)),
        small: small_rim_faces(mesh),
        apart,
        bare,
    })
}

/// Points of faces with their distances to a curve over a diagonal.
fn spots(points: &[(FaceId, Vec3)], curve: &BoundaryCurve, diagonal: f64) -> Vec<Spot> {
    let spot = |&(face, point): &(FaceId, Vec3)| Spot {
        face,
        point,
        distance: distance(curve, point) / diagonal,
    };
    points.par_iter().map(spot).collect()
}

fn largest(spots: &[Spot]) -> f64 {
    spots.iter().map(|s| s.distance).fold(0.0, f64::max)
}

/// Points along the edges of the mesh's boundary, four on each, with the faces of their edges.
pub fn points_on_boundary(mesh: &HexMesh) -> Vec<(FaceId, Vec3)> {
    let topology = mesh.topology();
    let rim = topology.boundary_edges();
    let of_edge = |e| {
        let h = topology.edge_half_edge(e);
        let [a, b] = [topology.origin(h), topology.target(h)].map(|v| mesh.position(v));
        points_between(a, b).map(move |p| (topology.face(h), p))
    };
    rim.flat_map(of_edge).collect()
}

fn distance(curve: &BoundaryCurve, p: Vec3) -> f64 {
    (curve.closest_point(p).position - p).norm()
}

/// The boundary loops of a mesh, each with its first point repeated at the end.
fn rim_loops(mesh: &HexMesh) -> Vec<Vec<Vec3>> {
    let closed = |l: &Vec<VertexId>| {
        let first = l.iter().take(1);
        l.iter().chain(first).map(|&v| mesh.position(v)).collect()
    };
    mesh.topology()
        .boundary_loops()
        .iter()
        .map(closed)
        .collect()
}

fn points_between(a: Vec3, b: Vec3) -> impl Iterator<Item = Vec3> {
    (0..ALONG).map(move |k| a + (b - a) * (k as f64 / ALONG as f64))
}

/// Points of a boundary loop at which it turns sharply.
fn corners(surface: &TriangleSurface, boundary: &[VertexId]) -> Vec<Vec3> {
    let n = boundary.len();
    let at = |i: usize| surface.positions()[boundary[i % n]];
    let turning = |i: &usize| (at(i + n) - at(i + n - 1)).angle(&(at(i + 1) - at(*i)));
    let sharp = |i: &usize| turning(i) > CORNER.to_radians();
    (0..n).filter(sharp).map(at).collect()
}

/// Share of the surface's area whose closest point of the mesh is not on the mesh's boundary, and
/// points of the rest.
fn covered(
    panels: &ClippedMesh,
    surface: &TriangleSurface,
    rim: &BoundaryCurve,
) -> (f64, Vec<Spot>) {
    let diagonal = surface.diagonal();
    let rounding = SAME * diagonal;
    let triangles: Vec<[Vec3; 3]> = (surface.topology().faces())
        .map(|f| surface.corners(f))
        .collect();
    let (share, outside) = share_of(&triangles, rim, |p| {
        !rim.is_within(p, panels.distance(p) + rounding)
    });
    let bare = |&point: &Vec3| {
        let (face, distance) = panels.closest(point);
        Spot {
            face,
            point,
            distance: distance / diagonal,
        }
    };
    (share, outside.par_iter().map(bare).collect())
}

/// Share of the mesh's area whose closest point of the surface is on the surface's boundary.
fn overhang(panels: &ClippedMesh, surface: &TriangleSurface, curve: &BoundaryCurve) -> f64 {
    let rounding = SAME * surface.diagonal();
    let triangles: Vec<[Vec3; 3]> = (panels.hierarchy.triangles())
        .map(|t| [t.a, t.b, t.c].map(|p| Vec3::new(p.x, p.y, p.z)))
        .collect();
    let beyond = |p: Vec3| {
        let foot = surface.closest_point(p).position;
        curve.is_within(p, (foot - p).norm() + rounding)
    };
    share_of(&triangles, curve, beyond).0
}

/// Share of the triangles' area where a predicate holds that changes near a curve only, and points
/// where it does not.
fn share_of(
    triangles: &[[Vec3; 3]],
    curve: &BoundaryCurve,
    holds: impl Fn(Vec3) -> bool + Sync,
) -> (f64, Vec<Vec3>) {
    let part = |&[a, b, c]: &[Vec3; 3]| {
        let centre = (a + b + c) / 3.0;
        let reach = [a, b, c].map(|p| (p - centre).norm());
        let near = curve.is_within(centre, reach.into_iter().fold(0.0, f64::max));
        let mut points = spread([a, b, c], if near { ROWS } else { 1 });
        let all = points.len() as f64;
        points.retain(|p| !holds(*p));
        let area = (b - a).cross(&(c - a)).norm();
        ((area * (1.0 - points.len() as f64 / all), area), points)
    };
    let parts: (Vec<(f64, f64)>, Vec<Vec<Vec3>>) = triangles.par_iter().map(part).unzip();
    (share(parts.0), parts.1.concat())
}

/// The sum of the first over the sum of the second figures, in their order.
fn share(parts: Vec<(f64, f64)>) -> f64 {
    let sum = |(a, b): (f64, f64), (c, d): &(f64, f64)| (a + c, b + d);
    let (part, whole) = parts.iter().fold((0.0, 0.0), sum);
    part / whole.max(f64::MIN_POSITIVE)
}

/// Centroids of the `n^2` equal triangles into which one is divided.
fn spread([a, b, c]: [Vec3; 3], n: usize) -> Vec<Vec3> {
    let point = |i: f64, k: f64| a + ((b - a) * i + (c - a) * k) / n as f64;
    let mut points = Vec::with_capacity(n * n);
    for i in 0..n {
        for k in 0..n - i {
            points.push(point(i as f64 + 1.0 / 3.0, k as f64 + 1.0 / 3.0));
            if i + k + 1 < n {
                points.push(point(i as f64 + 2.0 / 3.0, k as f64 + 2.0 / 3.0));
            }
        }
    }
    points
}

/// Faces at the boundary with less than [`LEAST_RIM_AREA`] of the mean area, in their order.
pub fn small_rim_faces(mesh: &HexMesh) -> Vec<FaceId> {
    let small = rim_areas(mesh).into_iter().filter(|r| r.1 < LEAST_RIM_AREA);
    small.map(|(f, _)| f).collect()
}

/// Areas of the faces at the boundary over the mean area of all faces.
fn rim_areas(mesh: &HexMesh) -> Vec<(FaceId, f64)> {
    let topology = mesh.topology();
    let area = FlatFace::all(mesh).map(FlatFace::area);
    let mean = area.iter().sum::<f64>() / area.len() as f64;
    let rim = topology.boundary_faces();
    rim.map(|f| (f, area[f] / mean)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The square from 0 to `size`, of triangles or as one panel per unit square.
    fn square(size: u32, inset: f64) -> (TriangleSurface, HexMesh) {
        let n = size + 1;
        let at = |i: u32, k: u32| Vec3::new(f64::from(i), f64::from(k), 0.0);
        let places = || (0..n * n).map(|v| at(v % n, v / n));
        let id = |i: u32, k: u32| k * n + i;
        let cells = (0..size * size).map(|c| (c % size, c / size));
        let quads: Vec<[u32; 4]> = cells
            .map(|(i, k)| [id(i, k), id(i + 1, k), id(i + 1, k + 1), id(i, k + 1)])
            .collect();
        let triangles: Vec<[u32; 3]> = quads
            .iter()
            .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
            .collect();
        let middle = Vec3::new(1.0, 1.0, 0.0) * (0.5 * f64::from(size));
        let scale = 1.0 - 2.0 * inset / f64::from(size);
        let shrunk = places().map(|p| middle + (p - middle) * scale).collect();
        (
            TriangleSurface::new(places().collect(), &triangles).unwrap(),
            HexMesh::new(shrunk, &quads).unwrap(),
        )
    }

    #[test]
    fn panels_that_end_at_the_boundary_fit() {
        let (surface, mesh) = square(4, 0.0);
        let fit = boundary_fit(&mesh, &surface).unwrap();
        assert_eq!((fit.distance_max(), fit.vertices_max), (0.0, 0.0));
        assert_eq!((fit.covered_area, fit.overhang_area), (1.0, 0.0));
        assert_eq!((fit.corners, fit.corner_max), (4, 0.0));
        assert_eq!((fit.rim_area.count, fit.rim_area.min), (12, 1.0));
    }

    #[test]
    fn what_is_left_bare_and_what_sticks_out_is_measured() {
        // A margin of 1/4 all round a square of side 4 and diagonal sqrt(32).
        let (surface, mesh) = square(4, 0.25);
        let fit = boundary_fit(&mesh, &surface).unwrap();
        let diagonal = 32.0_f64.sqrt();
        assert!((fit.to_curve_max - 0.25 / diagonal).abs() < 1e-12);
        assert!((fit.corner_max - 0.125_f64.sqrt() / diagonal).abs() < 1e-12);
        assert!((fit.from_curve_max - fit.corner_max).abs() < 1e-12);
        assert!((fit.covered_area - (3.5_f64 / 4.0).powi(2)).abs() < 0.02);
        assert_eq!(fit.overhang_area, 0.0);
        let (surface, mesh) = square(4, -0.25);
        let fit = boundary_fit(&mesh, &surface).unwrap();
        assert_eq!(fit.covered_area, 1.0);
        assert!((fit.overhang_area - (1.0 - (4.0_f64 / 4.5).powi(2))).abs() < 0.03);
        assert!((fit.vertices_max - 0.125_f64.sqrt() / diagonal).abs() < 1e-12);
    }

    #[test]
    fn a_closed_surface_has_no_boundary_to_fit() {
        let (_, mesh) = square(1, 0.0);
        let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let closed = TriangleSurface::new(corners, &faces).unwrap();
        assert!(boundary_fit(&mesh, &closed).is_none());
    }
}
