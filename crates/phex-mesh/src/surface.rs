//! The triangle surface: what phex approximates.
//!
//! Positions, topology, vertex normals, and closest points with interpolated normal over a bounding
//! volume hierarchy.

use crate::Vec3;
use crate::extent::bounds;
use crate::ids::{EdgeId, FaceId, VertexId};
use crate::per_element::PerVertex;
use crate::polygon::sides;
use crate::segment::{passes_through, segment_box, to_parry};
use crate::topology::{Topology, TopologyError};
use parry3d_f64::bounding_volume::BoundingVolume;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{TriMesh, TrianglePointLocation};
use rayon::prelude::*;
use std::sync::{Arc, OnceLock};

/// Barycentric coordinate up to which a point is on the opposite edge of its triangle.
const ON_EDGE: f64 = 1e-9;

/// An oriented manifold triangle mesh with closest-point queries. It never changes: clones share
/// what they hold.
#[derive(Clone)]
pub struct TriangleSurface {
    positions: Arc<PerVertex<Vec3>>,
    normals: Arc<PerVertex<Vec3>>,
    topology: Arc<Topology>,
    /// Made by the first query.
    hierarchy: Arc<OnceLock<TriMesh>>,
    /// Found when they are first asked for.
    self_crossings: Arc<OnceLock<Vec<Vec3>>>,
}

/// A point on a [`TriangleSurface`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The triangle.
    pub triangle: FaceId,
    /// Barycentric coordinates in the triangle, in the order of its vertices; they sum to 1.
    pub barycentric: [f64; 3],
    /// The point.
    pub position: Vec3,
    /// Unit normal, interpolated from the vertices.
    pub normal: Vec3,
}

impl TriangleSurface {
    /// Builds a surface from triangles that already are an oriented manifold.
    /// Vertex normals are those of Max (weights `1 / (|a|^2 |b|^2)`).
    ///
    /// # Errors
    /// If the triangles are not an oriented manifold, or two of them have the same corners.
    pub fn new(positions: Vec<Vec3>, triangles: &[[u32; 3]]) -> Result<Self, TopologyError> {
        let topology = Topology::from_faces(positions.len(), triangles)?;
        if let Some([first, second]) = doubled(&topology) {
            return Err(TopologyError::DoubledTriangle { first, second });
        }
        Ok(Self::of(PerVertex::from_vec(positions), Arc::new(topology)))
    }

    /// The surface with known triangles.
    ///
    /// # Panics
    /// If a face is no triangle, or the number of vertices differs.
    pub fn from_topology(positions: PerVertex<Vec3>, topology: Topology) -> Self {
        assert_eq!(topology.n_half_edges(), 3 * topology.n_faces(), "triangles");
        assert_eq!(
            topology.n_vertices(),
            positions.len(),
            "one place per vertex"
        );
        Self::of(positions, Arc::new(topology))
    }

    fn of(positions: PerVertex<Vec3>, topology: Arc<Topology>) -> Self {
        Self {
            normals: Arc::new(max_normals(&positions, &topology)),
            positions: Arc::new(positions),
            topology,
            hierarchy: Arc::default(),
            self_crossings: Arc::default(),
        }
    }

    /// The same triangles between other places.
    ///
    /// # Panics
    /// If the number of places differs.
    pub fn with_positions(&self, positions: PerVertex<Vec3>) -> Self {
        assert_eq!(
            positions.len(),
            self.positions.len(),
            "one place per vertex"
        );
        Self::of(positions, Arc::clone(&self.topology))
    }

    /// The same triangles with every place moved by a map.
    pub fn mapped(&self, place: impl Fn(&Vec3) -> Vec3) -> Self {
        self.with_positions(self.positions.map(place))
    }

    /// The same triangles with every place moved by a similarity that turns nothing: normals stay.
    pub fn moved(&self, place: impl Fn(&Vec3) -> Vec3) -> Self {
        Self {
            positions: Arc::new(self.positions.map(place)),
            hierarchy: Arc::default(),
            self_crossings: Arc::default(),
            ..self.clone()
        }
    }

    /// The same surface with a hierarchy of its own, which the first query makes and which ends
    /// with its last clone: of a large surface it is the largest part.
    pub fn unshared(&self) -> Self {
        Self {
            hierarchy: Arc::default(),
            ..self.clone()
        }
    }

    /// Whether this is a clone of another surface.
    pub fn is_clone_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.positions, &other.positions) && Arc::ptr_eq(&self.normals, &other.normals)
    }

    /// The same surface with other unit vertex normals (those of a fitted jet, say).
    ///
    /// # Panics
    /// If the number of normals differs.
    pub fn with_normals(mut self, normals: PerVertex<Vec3>) -> Self {
        assert_eq!(normals.len(), self.positions.len(), "one normal per vertex");
        self.normals = Arc::new(normals);
        self
    }

    /// Position of each vertex.
    pub fn positions(&self) -> &PerVertex<Vec3> {
        &self.positions
    }

    /// Unit normal of each vertex.
    pub fn normals(&self) -> &PerVertex<Vec3> {
        &self.normals
    }

    /// The connectivity.
    pub fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Boundary loops; the surface lies to their left (see [`Topology::boundary_loops`]).
    pub fn boundary_loops(&self) -> Vec<Vec<VertexId>> {
        self.topology.boundary_loops()
    }

    /// The three corners of a triangle.
    pub fn corners(&self, f: FaceId) -> [Vec3; 3] {
        let v = self.topology.face_vertices(f);
        [
            self.positions[v[0]],
            self.positions[v[1]],
            self.positions[v[2]],
        ]
    }

    /// The centroid of a triangle.
    pub fn centroid(&self, f: FaceId) -> Vec3 {
        self.corners(f).iter().sum::<Vec3>() / 3.0
    }

    /// The numbers of a triangle's vertices, as [`Self::new`] takes them.
    pub fn triangle(&self, f: FaceId) -> [u32; 3] {
        let corners = self.topology.face_vertices(f);
        std::array::from_fn(|k| corners[k].index() as u32)
    }

    /// Those of all triangles.
    pub fn triangles(&self) -> impl ExactSizeIterator<Item = [u32; 3]> {
        self.topology.faces().map(|f| self.triangle(f))
    }

    /// Length of an edge.
    pub fn edge_length(&self, e: EdgeId) -> f64 {
        let [a, b] = self.topology.edge_vertices(e).map(|v| self.positions[v]);
        (b - a).norm()
    }

    /// Mean length of the edges.
    pub fn mean_edge(&self) -> f64 {
        let t = &self.topology;
        t.edges().map(|e| self.edge_length(e)).sum::<f64>() / t.n_edges() as f64
    }

    /// Normal of a triangle times twice its area.
    pub fn area_vector(&self, f: FaceId) -> Vec3 {
        let [a, b, c] = self.corners(f);
        (b - a).cross(&(c - a))
    }

    /// The triangles that hold a point: one, or those at the edge or the vertex that it is on.
    pub fn triangles_at(&self, point: &SurfacePoint) -> Vec<FaceId> {
        let corners = self.topology.face_vertices(point.triangle);
        let weights = corners.iter().zip(point.barycentric);
        let held: Vec<VertexId> = weights
            .filter(|(_, weight)| *weight > ON_EDGE)
            .map(|(v, _)| *v)
            .collect();
        match held[..] {
            [first, _] | [first] => {
                let is_held = |f: &FaceId| {
                    let corners = self.topology.face_vertices(*f);
                    held.iter().all(|v| corners.contains(v))
                };
                self.topology.faces_at(first).filter(is_held).collect()
            }
            _ => vec![point.triangle],
        }
    }

    /// Area of a triangle.
    pub fn face_area(&self, f: FaceId) -> f64 {
        0.5 * self.area_vector(f).norm()
    }

    /// A third of the area of the triangles at each vertex, squared model units.
    pub fn vertex_areas(&self) -> PerVertex<f64> {
        let topology = self.topology();
        let mut area = PerVertex::filled(topology.n_vertices(), 0.0);
        for f in topology.faces() {
            let third = self.area_vector(f).norm() / 6.0;
            let corners = topology.face_vertices(f).iter();
            corners.for_each(|&v| area[v] += third);
        }
        area
    }

    /// Total area.
    pub fn area(&self) -> f64 {
        self.topology.faces().map(|f| self.face_area(f)).sum()
    }

    /// Length of a closed line of vertices.
    pub fn length_round(&self, line: &[VertexId]) -> f64 {
        let length = |[a, b]: [VertexId; 2]| (self.positions[b] - self.positions[a]).norm();
        sides(line).map(length).sum()
    }

    /// Mean thickness of what a closed surface encloses: twice its volume over its area. Of a plate
    /// it is the distance of the two sides, of a thin pipe its radius. `None` with a boundary.
    pub fn thickness(&self) -> Option<f64> {
        let is_closed = self.topology.is_closed();
        let first = self.positions.as_slice()[0];
        let volume = |f: FaceId| {
            let [a, b, c] = self.corners(f).map(|p| p - first);
            a.dot(&b.cross(&c)) / 6.0
        };
        let volume: f64 = self.topology.faces().map(volume).sum();
        is_closed.then(|| 2.0 * volume.abs() / self.area())
    }

    /// Corner with the smallest and corner with the largest coordinates.
    pub fn bounding_box(&self) -> (Vec3, Vec3) {
        bounds(self.positions.iter()).into()
    }

    /// Diagonal of the bounding box, the length that percentages refer to.
    pub fn diagonal(&self) -> f64 {
        let (lo, hi) = self.bounding_box();
        (hi - lo).norm()
    }

    /// The point of the surface that is closest to `p`.
    pub fn closest_point(&self, p: Vec3) -> SurfacePoint {
        self.closest_within(p, f64::MAX)
            .expect("a surface has a point")
    }

    /// The point of the surface that is closest to `p`, sought no farther away than the point
    /// `near` of the surface is: that spares most of the search where `near` is nearly closest. The
    /// result is that of [`Self::closest_point`].
    pub fn closest_point_near(&self, p: Vec3, near: Vec3) -> SurfacePoint {
        // Rounding must not exclude `near` itself.
        let bound = (p - near).norm() * (1.0 + 1e-6);
        self.closest_within(p, bound)
            .unwrap_or_else(|| self.closest_point(p))
    }

    /// Makes what closest points are sought with, once for all clones, so that the first query does
    /// not wait for it.
    pub fn prepare(&self) {
        self.hierarchy();
    }

    fn hierarchy(&self) -> &TriMesh {
        self.hierarchy.get_or_init(|| {
            let points = self.positions.iter().map(|&p| to_parry(p)).collect();
            TriMesh::new(points, self.triangles().collect()).expect("a surface has a triangle")
        })
    }

    /// Where it passes through itself: the middle of each edge that passes through a triangle with
    /// which it has no vertex in common, in the order of edges. None in an embedded surface; sheets
    /// that meet in their vertices count.
    ///
    /// ```
    /// # use phex_mesh::{TriangleSurface, Vec3};
    /// let flat = [[0., 0., 0.], [4., 0., 0.], [0., 4., 0.]];
    /// let upright = [[1., 1., 1.], [1., 1., -1.], [9., 9., 0.]];
    /// let places = [flat, upright].concat().into_iter().map(Vec3::from).collect();
    /// let surface = TriangleSurface::new(places, &[[0, 1, 2], [3, 4, 5]])?;
    /// // An edge of each of them passes through the other.
    /// assert_eq!(surface.self_crossings().len(), 2);
    /// assert!(surface.self_crossings().contains(&Vec3::new(1.0, 1.0, 0.0)));
    /// # Ok::<(), phex_mesh::TopologyError>(())
    /// ```
    pub fn self_crossings(&self) -> &[Vec3] {
        self.self_crossings.get_or_init(|| {
            let (places, margin) = self.nudged();
            let edges = 0..self.topology.n_edges() as u32;
            let found = edges.into_par_iter().map(EdgeId::new);
            let crossing = |e| self.crossing_at(e, &places, margin);
            found.filter_map(crossing).collect()
        })
    }

    /// Vertices off the boundary moved at random, so that sheets that meet in a row of vertices
    /// pass through each other as all others do; and how far, model units.
    fn nudged(&self) -> (PerVertex<Vec3>, f64) {
        let t = &self.topology;
        let far = NUDGE * self.mean_edge();
        let place = |v: VertexId| {
            let share = |ratio: f64| 2.0 * (ratio * (1.0 + v.index() as f64)).fract() - 1.0;
            let is_fixed = t.is_boundary_vertex(v);
            self.positions[v] + Vec3::from(SPREAD.map(share)) * if is_fixed { 0.0 } else { far }
        };
        (PerVertex::from_fn(t.n_vertices(), place), far)
    }

    fn crossing_at(&self, edge: EdgeId, places: &PerVertex<Vec3>, margin: f64) -> Option<Vec3> {
        let ends = self.topology.edge_vertices(edge);
        let [from, to] = ends.map(|v| places[v]);
        let crosses = |t: u32| {
            let corners = self.topology.face_vertices(FaceId::new(t));
            !ends.iter().any(|v| corners.contains(v))
                && passes_through(
                    from,
                    to,
                    std::array::from_fn(|k| places[corners[k]]),
                    [false; 3],
                )
        };
        let near = segment_box(from, to).loosened(2.0 * margin);
        let crossed = self.hierarchy().bvh().intersect_aabb(&near).any(crosses);
        let [from, to] = ends.map(|v| self.positions[v]);
        crossed.then(|| (from + to) * 0.5)
    }

    /// The point of the surface that is closest to `p` among those nearer than `bound`.
    pub fn closest_within(&self, p: Vec3, bound: f64) -> Option<SurfacePoint> {
        let query = to_parry(p);
        let (_, (triangle, location)) = self
            .hierarchy()
            .project_local_point_and_get_location_with_max_dist(query, false, bound)?;
        Some(self.at(FaceId::new(triangle), barycentric(location)))
    }

    /// Closest points of many, in their order; the same for any number of threads. It takes least
    /// time where points that follow one another are near one another.
    pub fn closest_points(&self, points: &[Vec3]) -> Vec<SurfacePoint> {
        in_runs(points, |p, last: Option<&SurfacePoint>| match last {
            Some(last) => self.closest_point_near(p, last.position),
            None => self.closest_point(p),
        })
    }

    /// The point with barycentric coordinates `b` in a triangle.
    pub fn at(&self, triangle: FaceId, b: [f64; 3]) -> SurfacePoint {
        let v = self.topology.face_vertices(triangle);
        let mix = |values: &PerVertex<Vec3>| {
            values[v[0]] * b[0] + values[v[1]] * b[1] + values[v[2]] * b[2]
        };
        let normal = mix(&self.normals);
        let normal = normal
            .try_normalize(1e-12)
            .unwrap_or_else(|| self.area_vector(triangle).normalize());
        SurfacePoint {
            triangle,
            barycentric: b,
            position: mix(&self.positions),
            normal,
        }
    }
}

/// How far vertices are moved before edges are asked whether they pass through triangles, over the
/// mean edge: as little as is told from a mere touch.
const NUDGE: f64 = 1e-7;
/// Multiples of these spread evenly over the unit cube, modulo 1: powers of the root of
/// `x^4 = x + 1`. Source: Roberts, "The unreasonable effectiveness of quasirandom sequences"
/// (2018).
const SPREAD: [f64; 3] = [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9];

/// Points in a run, in which each is sought from what was found for the one before.
const RUN: usize = 64;

/// What is found for each of many points, given what was found for the one before it in its run.
pub(crate) fn in_runs<T: Send>(
    points: &[Vec3],
    find: impl Fn(Vec3, Option<&T>) -> T + Sync,
) -> Vec<T> {
    let run = |points: &[Vec3]| {
        let mut found: Vec<T> = Vec::with_capacity(points.len());
        for p in points {
            found.push(find(*p, found.last()));
        }
        found
    };
    points.par_chunks(RUN).flat_map_iter(run).collect()
}

fn barycentric(location: TrianglePointLocation) -> [f64; 3] {
    match location {
        TrianglePointLocation::OnVertex(i) => {
            std::array::from_fn(|k| f64::from(u8::from(k == i as usize)))
        }
        _ => location.barycentric_coordinates().unwrap_or([1.0 / 3.0; 3]),
    }
}

/// Vertex normals with weights `1 / (|a|^2 |b|^2)` (N. Max, "Weights for computing vertex normals",
/// 1999).
fn max_normals(positions: &PerVertex<Vec3>, topology: &Topology) -> PerVertex<Vec3> {
    PerVertex::from_fn(positions.len(), |v| {
        let mut normal = Vec3::zeros();
        for h in topology.outgoing(v) {
            let a = positions[topology.target(h)] - positions[v];
            let b = positions[topology.origin(topology.prev(h))] - positions[v];
            let weight = a.norm_squared() * b.norm_squared();
            if weight > 0.0 {
                normal += a.cross(&b) / weight;
            }
        }
        normal.try_normalize(0.0).unwrap_or_else(Vec3::z)
    })
}

/// Two triangles that share all their edges.
fn doubled(topology: &Topology) -> Option<[FaceId; 2]> {
    topology.faces().find_map(|f| {
        let mut others = topology.face_half_edges(f).map(|h| topology.across(h));
        let first = others.next()??;
        others.all(|g| g == Some(first)).then_some([f, first])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// A bumpy grid of `2 n^2` triangles over the square of side `size`, far from the origin by
    /// `offset` sides.
    fn bumps(n: u32, size: f64, offset: f64) -> TriangleSurface {
        let position = |i: u32, j: u32| {
            let (x, y) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
            let z = 0.1 * (7.0 * x).sin() + 0.08 * (5.0 * y + 2.0 * x).cos();
            (Vec3::new(x, y, z) + Vec3::repeat(offset)) * size
        };
        let positions = (0..=n).flat_map(|i| (0..=n).map(move |j| position(i, j)));
        let id = |i: u32, j: u32| i * (n + 1) + j;
        let cells = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        TriangleSurface::new(positions.collect(), &triangles).unwrap()
    }

    /// Two square sheets of `2 n^2` triangles: the second is the image of the first.
    fn sheets(
        n: u32,
        first: impl Fn(f64, f64) -> Vec3,
        image: fn(Vec3) -> Vec3,
    ) -> TriangleSurface {
        let grid = bumps(n, 1.0, 0.0);
        let flat: Vec<Vec3> = grid.positions().iter().map(|p| first(p.x, p.y)).collect();
        let images = flat.iter().map(|p| image(*p));
        let places = flat.iter().copied().chain(images).collect();
        let shift = flat.len() as u32;
        let own: Vec<[u32; 3]> = grid.triangles().collect();
        let moved = own.iter().map(|t| t.map(|v| v + shift));
        TriangleSurface::new(
            places,
            &own.iter().copied().chain(moved).collect::<Vec<_>>(),
        )
        .unwrap()
    }

    #[test]
    fn sheets_that_cross_in_a_row_of_vertices_pass_through_each_other() {
        let slope = |x: f64, y: f64| Vec3::new(x - 0.5, y, x - 0.5);
        let crossed = sheets(6, slope, |p| Vec3::new(p.x, p.y, -p.z));
        let found = crossed.self_crossings();
        assert!(!found.is_empty());
        assert!(found.iter().all(|p| p.x.abs() < 0.2));
        // Beside each other, with boundaries that coincide, as along a slit.
        let flat = |x: f64, y: f64| Vec3::new(x, y, 0.1 * (3.0 * y).sin());
        let beside = sheets(6, flat, |p| Vec3::new(-p.x, p.y, p.z));
        assert!(beside.self_crossings().is_empty());
    }

    fn random_points(surface: &TriangleSurface, count: usize, margin: f64) -> Vec<Vec3> {
        let (low, high) = surface.bounding_box();
        let (low, high) = (low - (high - low) * margin, high + (high - low) * margin);
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut random = |k: usize| rng.random_range(low[k]..high[k]);
        (0..count)
            .map(|_| Vec3::new(random(0), random(1), random(2)))
            .collect()
    }

    /// Distance to a triangle as the least over its inside, its sides and its corners, each by its
    /// own formula.
    fn distance_to_triangle(p: Vec3, [a, b, c]: [Vec3; 3]) -> f64 {
        let n = (b - a).cross(&(c - a));
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|(q, r)| (r - q).cross(&(p - q)).dot(&n) >= 0.0);
        let to_side = |q: Vec3, r: Vec3| {
            let t = ((p - q).dot(&(r - q)) / (r - q).norm_squared()).clamp(0.0, 1.0);
            (q + (r - q) * t - p).norm()
        };
        let to_plane = if inside {
            (p - a).dot(&n).abs() / n.norm()
        } else {
            f64::INFINITY
        };
        to_plane
            .min(to_side(a, b))
            .min(to_side(b, c))
            .min(to_side(c, a))
    }

    fn zeros(b: [f64; 3]) -> usize {
        b.iter().filter(|&&x| x == 0.0).count()
    }

    #[test]
    fn closest_points_are_those_of_all_triangles() {
        for (size, offset) in [(1.0, 0.0), (1.0, 1e3), (1e-3, 0.0), (1e4, 0.0)] {
            let surface = bumps(9, size, offset);
            let points = random_points(&surface, 400, 0.3);
            let (mut of_faces, mut of_edges, mut of_vertices) = (0, 0, 0);
            for (&p, found) in points.iter().zip(surface.closest_points(&points)) {
                let distances = surface
                    .topology()
                    .faces()
                    .map(|f| distance_to_triangle(p, surface.corners(f)));
                let least = distances.fold(f64::INFINITY, f64::min);
                let rounding = 1e-14 * size * (1.0 + offset);
                assert!(
                    ((found.position - p).norm() - least).abs() <= 10.0 * rounding,
                    "size {size} offset {offset}"
                );
                let rebuilt: Vec3 = surface
                    .corners(found.triangle)
                    .iter()
                    .zip(found.barycentric)
                    .map(|(q, b)| q * b)
                    .sum();
                assert!((rebuilt - found.position).norm() <= rounding);
                assert!((found.barycentric.iter().sum::<f64>() - 1.0).abs() < 1e-14);
                assert!(
                    found
                        .barycentric
                        .iter()
                        .all(|&b| (-1e-14..=1.0 + 1e-14).contains(&b))
                );
                match zeros(found.barycentric) {
                    0 => of_faces += 1,
                    1 => of_edges += 1,
                    _ => of_vertices += 1,
                }
            }
            assert!(
                of_faces > 50 && of_edges > 20 && of_vertices > 5,
                "{of_faces} {of_edges} {of_vertices}"
            );
        }
    }

    #[test]
    fn a_near_point_changes_nothing() {
        let surface = bumps(20, 1.0, 0.0);
        let points = random_points(&surface, 600, 0.2);
        let others = random_points(&surface, 600, 0.2);
        for (&p, &q) in points.iter().zip(&others) {
            let expected = surface.closest_point(p);
            for near in [surface.closest_point(q).position, expected.position] {
                let found = surface.closest_point_near(p, near);
                assert!((found.position - expected.position).norm() < 1e-14);
            }
        }
    }

    #[test]
    fn scaling_changes_neither_triangle_nor_barycentric_coordinates() {
        let unit = bumps(20, 1.0, 0.0);
        let points = random_points(&unit, 500, 0.2);
        let expected = unit.closest_points(&points);
        for size in [1e-40, 1e-6, 1e-3, 1e4, 1e40] {
            let scaled = bumps(20, size, 0.0);
            for (p, expected) in points.iter().zip(&expected) {
                let found = scaled.closest_point(p * size);
                let off = |a: Vec3, b: Vec3| (a - b).norm();
                assert!(
                    off(found.position / size, expected.position) < 1e-12,
                    "size {size}"
                );
                assert!(off(found.normal, expected.normal) < 1e-9, "size {size}");
                // On an edge or vertex either of its triangles may be named.
                if zeros(expected.barycentric) == 0 {
                    assert_eq!(found.triangle, expected.triangle);
                    assert!(
                        off(found.barycentric.into(), expected.barycentric.into()) < 1e-9,
                        "size {size}"
                    );
                }
            }
        }
    }

    #[test]
    fn normals_are_interpolated() {
        let surface = bumps(9, 1.0, 0.0);
        let f = FaceId::new(40);
        let v = surface.topology().face_vertices(f);
        let b = [0.2, 0.3, 0.5];
        let expected = (0..3)
            .map(|k| surface.normals()[v[k]] * b[k])
            .sum::<Vec3>()
            .normalize();
        assert!((surface.at(f, b).normal - expected).norm() < 1e-15);
        for (k, &v) in v.iter().enumerate() {
            let corner =
                surface.closest_point(surface.positions()[v] + surface.normals()[v] * 1e-3);
            assert!(
                (corner.position - surface.positions()[v]).norm() < 1e-3,
                "corner {k}"
            );
            assert!(corner.normal.dot(&surface.normals()[v]) > 0.99);
        }
    }

    #[test]
    fn max_normals_are_exact_on_a_sphere() {
        let circle = |k: u32| f64::from(k).sin_cos();
        let mut positions = vec![Vec3::z()];
        // A fan of uneven triangles inscribed in the unit sphere.
        positions.extend([0, 1, 2, 3, 5].map(|k| {
            let ((s, c), tilt) = (circle(k), 0.3 + 0.1 * f64::from(k));
            Vec3::new(tilt.sin() * c, tilt.sin() * s, tilt.cos())
        }));
        let triangles = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]];
        let surface = TriangleSurface::new(positions, &triangles).unwrap();
        assert!((surface.normals().as_slice()[0] - Vec3::z()).norm() < 1e-14);
    }

    #[test]
    fn same_points_with_one_and_many_threads() {
        let surface = bumps(30, 1.0, 0.0);
        let points = random_points(&surface, 3000, 0.5);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| surface.closest_points(&points))
        };
        let one = with(1);
        assert_eq!(one, with(4));
        let in_order: Vec<SurfacePoint> =
            points.iter().map(|&p| surface.closest_point(p)).collect();
        assert_eq!(one, in_order);
    }

    #[test]
    fn one_boundary_loop() {
        let loops = bumps(3, 1.0, 0.0).boundary_loops();
        assert_eq!((loops.len(), loops[0].len()), (1, 12));
    }

    #[test]
    fn two_triangles_with_the_same_corners_are_named() {
        let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        let pillow = TriangleSurface::new(corners, &[[0, 1, 2], [0, 2, 1]]);
        let error = pillow.err().unwrap().to_string();
        assert!(
            error.contains("faces 0 and 1 have the same corners"),
            "{error}"
        );
    }
}
