//! The Gauss image for edge-distance offsets: the Koebe mesh that a given mesh is parallel to.
//!
//! At a vertex `x` of the image with three edges of unit directions `e_i` all three lines touch the
//! unit sphere if and only if `(x . e_i)^2 = |x|^2 - 1`, so that
//!
//! ```text
//! x = w / sqrt(|w|^2 - D^2),   w = +- e_2 x e_3 +- e_3 x e_1 +- e_1 x e_2,   D = e_1 . (e_2 x e_3).
//! ```
//!
//! The edges lie on a cone of revolution about the sphere with the apex `x`. No vertex leaves a
//! choice but for the signs, which say to which side of the vertex each line touches. One start
//! decides them: the touching point of an edge is the same from both of its ends. The start that
//! closes is taken; among several, the one that faces the normals best. At a corner of a single
//! face both edges touch to the same side, or to opposite sides where one of them runs against that
//! of the image, as on saddles ([`EdgeSigns`](super::EdgeSigns)): what closes at the next vertex
//! with two faces is taken.
//!
//! So a mesh has an edge-distance offset if and only if it closes, and the image is found from its
//! directions alone. Source: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer
//! freeform structures for architecture" (2007), section 4 (edge offset meshes are parallel to
//! Koebe meshes; cones at vertices).
//!
//! *Guaranteed*: every edge line of an offset by `d` has the distance `|d|` from that of the mesh,
//! to rounding, at both of its ends; the edges are parallel up to [`EdgeGaussImage::defect`].
//! *Fails*: where that is more than allowed ([`OffsetError::NotParallelToKoebe`]).

mod inner_edges;

use super::accuracy::edge_distance_error;
use super::face_offset::{MOST_AT_BOUNDARY, check_planar_mesh};
use super::gauss_image::{GaussImage, OffsetKind};
use super::vertex_offset::{check_connected, vertex_directions};
use super::{OffsetError, OffsetOptions};
use inner_edges::inner_edge_image;
use phex_mesh::{EdgeId, HalfEdgeId, HexMesh, PerVertex, Vec3, VertexId};
use std::collections::{BTreeSet, VecDeque};

/// Touching points up to this far apart are the same.
const SAME_POINT: f64 = 1e-6;

/// A mesh whose edges touch the unit sphere, parallel to a given one.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeGaussImage {
    /// The Gauss image; a Koebe mesh.
    pub image: GaussImage,
    /// Largest distance of the touching points of an edge as found from its two ends, on the unit
    /// sphere.
    pub defect: f64,
    /// The edge where that is.
    pub edge: EdgeId,
    /// Least cosine between a vertex of the Gauss image and the mean normal of the faces there.
    pub facing: f64,
    /// Boundary edges without a distance of their own, where the mesh has been cut: all of them or,
    /// if all edges touch the sphere, none.
    pub free_edges: Vec<EdgeId>,
}

impl EdgeGaussImage {
    /// Largest error of the distances of the edges of `moved` from those of `mesh`, model units,
    /// but for the free ones.
    ///
    /// # Panics
    /// If the connectivity differs.
    pub fn distance_error(&self, mesh: &HexMesh, moved: &HexMesh, distance: f64) -> f64 {
        let free: BTreeSet<EdgeId> = self.free_edges.iter().copied().collect();
        edge_distance_error(mesh, moved, distance, |e| !free.contains(&e))
    }
}

/// The Gauss image whose edges touch the unit sphere; where not all can, as in a mesh that has been
/// cut along a curve, that whose inner edges do (`inner_edges`).
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::koebe::touching_points;
/// use phex::offset::{OffsetOptions, edge_gauss_image};
///
/// let found = edge_gauss_image(&cube, &OffsetOptions::default())?;
/// let koebe = found.image.mesh(&cube);
/// assert!(touching_points(&koebe).iter().all(|p| (p.norm() - 1.0).abs() < 1e-9));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the mesh is not planar with vertices of degree 3, or no Koebe mesh has inner edges that are
/// parallel to its.
pub fn edge_gauss_image(
    mesh: &HexMesh,
    options: &OffsetOptions,
) -> Result<EdgeGaussImage, OffsetError> {
    // A cut may part a panel in a corner, where a fourth face then ends.
    check_planar_mesh(mesh, &options.validity, MOST_AT_BOUNDARY + 1)?;
    check_connected(mesh)?;
    let normals = vertex_directions(mesh)?;
    let vertices = mesh.topology().vertices();
    let most_edges = |&v: &VertexId| (star(mesh, v).len().min(3), std::cmp::Reverse(v));
    let root = vertices.max_by_key(most_edges).unwrap_or(VertexId::new(0));
    let images = starts(mesh, root, normals[root]).map(|x| spread(mesh, root, x, &normals));
    let better = |a: EdgeGaussImage, b: EdgeGaussImage| {
        let closes = |image: &EdgeGaussImage| image.defect <= options.closing;
        let b_is = match (closes(&a), closes(&b)) {
            (true, true) => b.facing > a.facing,
            (false, false) => b.defect < a.defect,
            (_, closes) => closes,
        };
        if b_is { b } else { a }
    };
    let whole = images.reduce(better);
    let best = match whole {
        Some(image) if image.defect <= options.closing => return Ok(image),
        _ => whole
            .into_iter()
            .chain(inner_edge_image(mesh, &normals)?)
            .reduce(better),
    };
    let (edge, defect) = match best {
        Some(best) if best.defect <= options.closing => return Ok(best),
        Some(best) => (best.edge, best.defect),
        None => (EdgeId::new(0), f64::INFINITY),
    };
    let vertices = mesh.topology().edge_vertices(edge);
    Err(OffsetError::NotParallelToKoebe {
        edge,
        vertices,
        defect,
    })
}

/// An edge at a vertex.
struct Spoke {
    edge: EdgeId,
    to: VertexId,
    /// Unit vector away from the vertex.
    along: Vec3,
}

/// Edges at a vertex, counter-clockwise.
fn star(mesh: &HexMesh, v: VertexId) -> Vec<Spoke> {
    let spoke = |(edge, to): (EdgeId, VertexId)| Spoke {
        edge,
        to,
        along: (mesh.position(to) - mesh.position(v)).normalize(),
    };
    let edges = mesh.topology().spokes(v);
    edges.into_iter().map(spoke).collect()
}

/// Where the line through `x` along a unit vector is closest to the centre.
pub(super) fn touching(x: Vec3, along: &Vec3) -> Vec3 {
    x - along * x.dot(along)
}

/// The eight apexes of cones about the sphere that hold lines of three directions.
fn apexes([a, b, c]: [Vec3; 3]) -> impl Iterator<Item = Vec3> {
    let products = [b.cross(&c), c.cross(&a), a.cross(&b)];
    let volume = a.dot(&products[0]);
    let apex = move |signs: u32| {
        let signed = |k: usize| {
            if signs >> k & 1 == 0 {
                products[k]
            } else {
                -products[k]
            }
        };
        let w = signed(0) + signed(1) + signed(2);
        w / (w.norm_squared() - volume * volume).sqrt()
    };
    (0..8).map(apex).filter(|x| x.iter().all(|c| c.is_finite()))
}

/// Where the image of the root may be, on the side of the normal. A face alone gets the circle
/// half-way between point and equator.
fn starts(mesh: &HexMesh, root: VertexId, normal: Vec3) -> impl Iterator<Item = Vec3> {
    let spokes = star(mesh, root);
    let candidates: Vec<Vec3> = match &spokes[..] {
        [a, b, c, ..] => apexes([a.along, b.along, c.along]).collect(),
        [a, b] => {
            let outward = a.along.cross(&normal.normalize());
            let point = (normal.normalize() + outward).normalize();
            [b.along, -b.along]
                .map(|ahead| corner(point, &a.along, &ahead))
                .to_vec()
        }
        _ => Vec::new(),
    };
    candidates.into_iter().filter(move |x| x.dot(&normal) > 0.0)
}

/// The point on the line of direction `back` that touches the sphere in `point`, from where a line
/// along `ahead` touches it to the same side.
fn corner(point: Vec3, back: &Vec3, ahead: &Vec3) -> Vec3 {
    point + back * (point.dot(ahead) / (1.0 - back.dot(ahead)))
}

/// The image of a vertex one of whose edges touches in a given point. Where cones of both sides
/// hold it, as at right angles, the one that faces the normal is meant.
fn reached(mesh: &HexMesh, v: VertexId, through: EdgeId, point: Vec3, normal: &Vec3) -> Vec3 {
    let mut spokes = star(mesh, v);
    let first = spokes.iter().position(|s| s.edge == through).unwrap_or(0);
    spokes.rotate_left(first);
    let miss = |x: &Vec3| (touching(*x, &spokes[0].along) - point).norm();
    let cosine = |x: &Vec3| x.dot(normal) / x.norm();
    match &spokes[..] {
        [a, b, c, ..] => {
            let all: Vec<Vec3> = apexes([a.along, b.along, c.along]).collect();
            let least = all.iter().map(miss).fold(f64::INFINITY, f64::min);
            let meant = all.into_iter().filter(|x| miss(x) <= least + SAME_POINT);
            meant
                .max_by(|x, y| cosine(x).total_cmp(&cosine(y)))
                .unwrap_or(point)
        }
        [a, b] => corner(point, &a.along, &b.along),
        _ => point,
    }
}

/// The image that one start leads to. Corners of single faces come last, since they do not check
/// what they are given.
fn spread(
    mesh: &HexMesh,
    root: VertexId,
    start: Vec3,
    normals: &PerVertex<Vec3>,
) -> EdgeGaussImage {
    let topology = mesh.topology();
    let mut positions: PerVertex<Option<Vec3>> = PerVertex::filled(topology.n_vertices(), None);
    positions[root] = Some(start);
    let rows = corner_rows(mesh, root);
    let mut queue = VecDeque::from([root]);
    loop {
        while let Some(v) = queue.pop_front() {
            let x = positions[v].unwrap_or(start);
            for s in star(mesh, v) {
                if positions[s.to].is_none() && topology.face_degree(s.to) > 1 {
                    let (point, normal) = (touching(x, &s.along), &normals[s.to]);
                    positions[s.to] = Some(reached(mesh, s.to, s.edge, point, normal));
                    queue.push_back(s.to);
                }
            }
        }
        let next = rows.iter().find(|r| {
            positions[r.from].is_some() && r.corners.iter().any(|v| positions[*v].is_none())
        });
        let Some(row) = next else {
            break;
        };
        let placed = row.placed(mesh, &positions);
        for (&v, x) in row.corners.iter().zip(&placed.corners) {
            positions[v] = Some(*x);
        }
        if positions[row.to].is_none() {
            let normal = &normals[row.to];
            positions[row.to] = Some(reached(mesh, row.to, row.last, placed.point, normal));
            queue.push_back(row.to);
        }
    }
    let positions = positions.map(|x| x.unwrap_or(start));
    let (edge, defect) = largest_defect(mesh, &positions);
    EdgeGaussImage {
        facing: facing(&positions, normals),
        image: GaussImage {
            kind: OffsetKind::Edge,
            positions,
        },
        defect,
        edge,
        free_edges: Vec::new(),
    }
}

/// Least cosine between the vertices of an image and normals there.
pub(super) fn facing(positions: &PerVertex<Vec3>, normals: &PerVertex<Vec3>) -> f64 {
    let cosine = |(x, n): (&Vec3, &Vec3)| x.dot(n) / (x.norm() * n.norm());
    let cosines = positions.iter().zip(normals).map(cosine);
    cosines.fold(f64::INFINITY, f64::min)
}

/// Corners of one face in a row along the boundary, between two vertices that are none (or, for a
/// face alone, all but one).
pub(super) struct CornerRow {
    pub from: VertexId,
    corners: Vec<VertexId>,
    pub to: VertexId,
    /// The edge between the last of them and `to`.
    last: EdgeId,
}

/// The images of a row of corners, and where the edge after them touches.
struct PlacedRow {
    corners: Vec<Vec3>,
    point: Vec3,
}

/// The rows of corners along all boundaries.
pub(super) fn corner_rows(mesh: &HexMesh, root: VertexId) -> Vec<CornerRow> {
    let t = mesh.topology();
    let ends = |v: VertexId| v == root || t.face_degree(v) > 1;
    let along = t
        .half_edges()
        .filter(|h| t.twin(*h).is_none() && ends(t.origin(*h)));
    let row = |start: HalfEdgeId| {
        let (mut h, mut corners) = (start, Vec::new());
        while !ends(t.target(h)) {
            corners.push(t.target(h));
            h = t.next(h);
        }
        let (from, to, last) = (t.origin(start), t.target(h), t.edge(h));
        CornerRow {
            from,
            corners,
            to,
            last,
        }
    };
    along
        .map(row)
        .filter(|row| !row.corners.is_empty())
        .collect()
}

/// Corners in a row up to which all choices of sides are tried.
const MOST_CORNERS: usize = 10;
/// Choices close as well as each other up to this, on the unit sphere.
const SAME_MISS: f64 = 1e-9;

impl PlacedRow {
    /// How far its corners are from the sphere.
    fn size(&self) -> f64 {
        self.corners.iter().map(Vec3::norm_squared).sum()
    }
}

impl CornerRow {
    /// The corners with their shares of the way along the row.
    pub fn shares<'a>(&'a self, mesh: &HexMesh) -> impl Iterator<Item = (VertexId, f64)> + use<'a> {
        let mut way = vec![0.0];
        let (mut length, mut at) = (0.0, self.from);
        for &v in self.corners.iter().chain([&self.to]) {
            length += (mesh.position(v) - mesh.position(at)).norm();
            way.push(length);
            at = v;
        }
        let shares = way.into_iter().skip(1).map(move |w| w / length);
        self.corners.iter().copied().zip(shares)
    }

    /// At a corner both edges touch to the same side or, where one of them runs against its image,
    /// to opposite sides. Of the choices that meet the end of the row the nearest to the sphere is
    /// taken: an edge between two corners may touch the circle of its face in two points, of which
    /// one makes the face cross itself.
    fn placed(&self, mesh: &HexMesh, positions: &PerVertex<Option<Vec3>>) -> PlacedRow {
        let choices = if self.corners.len() > MOST_CORNERS {
            1
        } else {
            1 << self.corners.len()
        };
        let choice = |sides| {
            let placed = self.choice(mesh, positions, sides);
            let miss = self.miss(mesh, positions, placed.point);
            (placed, miss)
        };
        let (mut best, mut least) = choice(0);
        for sides in 1..choices {
            let (placed, miss) = choice(sides);
            let closes_as_well = miss < least + SAME_MISS && placed.size() < best.size();
            if miss < least - SAME_MISS || closes_as_well {
                (best, least) = (placed, miss);
            }
        }
        best
    }

    /// The row with one bit for each corner: whether its edges touch to opposite sides.
    fn choice(&self, mesh: &HexMesh, positions: &PerVertex<Option<Vec3>>, sides: u32) -> PlacedRow {
        let ends = [self.from].into_iter().chain(self.corners.iter().copied());
        let path: Vec<VertexId> = ends.chain([self.to]).collect();
        let along = |k: usize| (mesh.position(path[k + 1]) - mesh.position(path[k])).normalize();
        let start = positions[self.from].unwrap_or_default();
        let mut point = touching(start, &along(0));
        let mut corners = Vec::with_capacity(self.corners.len());
        for k in 1..=self.corners.len() {
            let ahead = if sides >> (k - 1) & 1 == 0 {
                along(k)
            } else {
                -along(k)
            };
            let x = corner(point, &-along(k - 1), &ahead);
            point = touching(x, &along(k));
            corners.push(x);
        }
        PlacedRow { corners, point }
    }

    /// How far the last edge's touching point is from that of the end of the row.
    fn miss(&self, mesh: &HexMesh, positions: &PerVertex<Option<Vec3>>, point: Vec3) -> f64 {
        let spokes = star(mesh, self.to);
        let Some(last) = spokes.iter().find(|s| s.edge == self.last) else {
            return f64::INFINITY;
        };
        let off = |x: Vec3| (touching(x, &last.along) - point).norm();
        match (positions[self.to], &spokes[..]) {
            (Some(x), _) => off(x),
            (None, [a, b, c, ..]) => {
                let all = apexes([a.along, b.along, c.along]);
                all.map(off).fold(f64::INFINITY, f64::min)
            }
            _ => 0.0,
        }
    }
}

/// The edge whose touching points, found from its ends, differ most.
fn largest_defect(mesh: &HexMesh, positions: &PerVertex<Vec3>) -> (EdgeId, f64) {
    let topology = mesh.topology();
    let mut largest = (EdgeId::new(0), 0.0);
    for edge in topology.edges() {
        let [a, b] = topology.edge_vertices(edge);
        let along = mesh.edge_vector(edge).normalize();
        let defect = (touching(positions[a], &along) - touching(positions[b], &along)).norm();
        if defect > largest.1 || defect.is_nan() {
            largest = (edge, defect);
        }
    }
    largest
}
