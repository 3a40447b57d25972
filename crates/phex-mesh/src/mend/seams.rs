//! Seams: boundaries that lie on one another, as between the patches of a CAD model, each of which
//! was cut into triangles by itself.
//!
//! Two boundaries belong together along an edge if the edge lies on the other boundary over its
//! length, up to a gap. Then each takes the vertices of the other one, and vertices within the gap
//! become one. What touches in a point alone stays apart.
//!
//! *The gap.* A ten-thousandth of the diagonal, since files are rounded to six digits and CAD
//! programs work to tolerances of that size, and no more than a twentieth of the edges there.
//! To it come the sagittas of the two polylines, since the same curve with other vertices lies
//! beside its chords by so much: `c t / 8` for chords of length `c` that turn by `t` at their ends.
//! No gap is wider than a fifth of the height of the faces there, so that narrow strips stay open.

use super::{FaceSide, Mended, sides};
use crate::disjoint_sets::DisjointSets;
use crate::{PolygonSoup, Vec3, bounds};
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::Polyline;
use std::collections::HashMap;

/// Largest gap by the diagonal of the bounding box.
const GAP_OF_DIAGONAL: f64 = 1e-4;
/// Gaps by the diagonal that are roundings.
const NO_GAP: f64 = 1e-9;
/// Largest gap by the shorter of the edges there.
const GAP_OF_EDGE: f64 = 0.05;
/// Largest distance, sagittas included, by the height of the face over its edge.
const GAP_OF_FACE: f64 = 0.2;
/// Polylines that turn by more than this, in radians, have a corner there, and no sagitta.
const CORNER: f64 = 0.6;
/// The sagitta that is granted, by that of an arc with the same turn.
const SAGITTAS: f64 = 1.5;
/// Where an edge has to lie on the other boundary, as parts of its length.
const SAMPLES: [f64; 3] = [0.25, 0.5, 0.75];

/// Joins boundaries that lie on one another. `None` where there are none.
///
/// Vertices exist, coordinates are finite, and no face repeats a vertex.
pub(crate) fn sewn(soup: &PolygonSoup) -> Option<Mended> {
    let boundary = OpenEdges::new(soup)?;
    let marked: Vec<bool> = (0..boundary.edges.len())
        .map(|e| boundary.lies_on_others(e))
        .collect();
    if !marked.contains(&true) {
        return None;
    }
    let mut at_seam = vec![false; soup.positions.len()];
    for (edge, _) in boundary.edges.iter().zip(&marked).filter(|(_, m)| **m) {
        edge.side
            .ends
            .iter()
            .for_each(|&v| at_seam[v as usize] = true);
    }
    let mut mended = Mended::unchanged(soup);
    let mut sets = DisjointSets::new(soup.positions.len());
    let mut insertions: Vec<Insertion> = Vec::new();
    for &v in &boundary.vertices {
        let mut hits = boundary.hits(v);
        hits.retain(|hit| at_seam[v as usize] || marked[hit.edge]);
        hits.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        let inside = hits.iter().find(|hit| hit.end.is_none());
        insertions.extend(inside.map(|hit| boundary.insertion(v, hit)));
        let ends = hits.iter().filter_map(|hit| Some((hit, hit.end?)));
        for (_, end) in ends.clone() {
            sets.join(v, end);
        }
        let used = inside.into_iter().chain(ends.map(|(hit, _)| hit));
        mended.widest_gap = used.map(|h| h.distance).fold(mended.widest_gap, f64::max);
    }
    insert(&mut mended, insertions);
    mended.join_vertices(&mut sets);
    let open = |faces: &[Vec<u32>]| single_sides(faces).len();
    mended.sewn_edges = boundary
        .edges
        .len()
        .saturating_sub(open(&mended.soup.faces));
    if mended.widest_gap < NO_GAP / GAP_OF_DIAGONAL * boundary.gap {
        mended.widest_gap = 0.0;
    }
    (mended.sewn_edges > 0).then_some(mended)
}

/// Sides of faces that no other face has.
fn single_sides(faces: &[Vec<u32>]) -> Vec<FaceSide> {
    let sides = sides(faces);
    let edges = sides.chunk_by(|a, b| a.ends == b.ends);
    edges.filter(|e| e.len() == 1).map(|e| e[0]).collect()
}

/// The edges of one face each.
struct OpenEdges<'a> {
    positions: &'a [Vec3],
    edges: Vec<BoundaryEdge>,
    /// The edges at each vertex that has any.
    at_vertex: HashMap<u32, Vec<usize>>,
    /// The vertices, growing.
    vertices: Vec<u32>,
    /// Largest gap by the diagonal.
    gap: f64,
    /// The longest distance at which anything is sewn.
    reach: f64,
    hierarchy: Polyline,
}

struct BoundaryEdge {
    side: FaceSide,
    length: f64,
    sagitta: f64,
    /// Height of the face over it.
    height: f64,
}

/// A vertex that lies on an edge of another boundary.
struct Hit {
    edge: usize,
    distance: f64,
    /// Place on the edge, from 0 at its first end to 1.
    place: f64,
    /// The end of the edge with which the vertex coincides.
    end: Option<u32>,
}

/// A vertex that a face takes in behind one of its corners.
struct Insertion {
    face: u32,
    corner: u32,
    /// Place along the side, in the direction of the face.
    place: f64,
    vertex: u32,
}

impl<'a> OpenEdges<'a> {
    fn new(soup: &'a PolygonSoup) -> Option<Self> {
        let single = single_sides(&soup.faces);
        if single.is_empty() {
            return None;
        }
        let positions = &soup.positions;
        let at = |v: u32| positions[v as usize];
        let mut at_vertex: HashMap<u32, Vec<usize>> = HashMap::new();
        for (e, side) in single.iter().enumerate() {
            for v in side.ends {
                at_vertex.entry(v).or_default().push(e);
            }
        }
        let mut edges: Vec<BoundaryEdge> = (single.iter())
            .map(|&side| {
                let length = (at(side.ends[1]) - at(side.ends[0])).norm();
                let corners = soup.faces[side.face as usize].iter();
                BoundaryEdge {
                    side,
                    length,
                    sagitta: 0.0,
                    height: 2.0 * area(&corners.map(|&v| at(v)).collect::<Vec<_>>()) / length,
                }
            })
            .collect();
        for edge in &mut edges {
            let turn = (edge.side.ends.iter())
                .map(|&v| turn(positions, &single, &at_vertex[&v], v))
                .fold(0.0, f64::max);
            edge.sagitta = SAGITTAS * edge.length * turn / 8.0;
        }
        let mut vertices: Vec<u32> = at_vertex.keys().copied().collect();
        vertices.sort_unstable();
        let used = soup.faces.iter().flatten();
        let [low, high] = bounds(used.map(|&v| &positions[v as usize]));
        let gap = GAP_OF_DIAGONAL * (high - low).norm();
        let largest = edges.iter().map(|e| e.sagitta).fold(0.0, f64::max);
        let points = single.iter().flat_map(|s| s.ends).map(|v| vector(at(v)));
        let segments = (0..single.len() as u32).map(|e| [2 * e, 2 * e + 1]);
        let hierarchy = Polyline::new(points.collect(), Some(segments.collect()));
        Some(Self {
            positions,
            edges,
            at_vertex,
            vertices,
            gap,
            reach: gap + 2.0 * largest,
            hierarchy,
        })
    }

    /// Whether the edge lies on other edges.
    fn lies_on_others(&self, e: usize) -> bool {
        let edge = &self.edges[e];
        let [a, b] = edge.side.ends.map(|v| self.positions[v as usize]);
        SAMPLES.iter().all(|t| {
            let p = a + (b - a) * *t;
            self.near(p).any(|f| {
                let other = &self.edges[f];
                let sagitta = edge.sagitta + other.sagitta;
                let widest = self.widest(edge, other, sagitta);
                other.side.face != edge.side.face && self.foot(p, f).0 <= widest
            })
        })
    }

    /// The largest distance at which two edges are sewn, with the sagittas that come to the gap.
    fn widest(&self, edge: &BoundaryEdge, other: &BoundaryEdge, sagitta: f64) -> f64 {
        let gap = self.gap.min(GAP_OF_EDGE * edge.length.min(other.length));
        (gap + sagitta).min(GAP_OF_FACE * edge.height.min(other.height))
    }

    /// Edges whose boxes are within reach of a point.
    fn near(&self, p: Vec3) -> impl Iterator<Item = usize> + '_ {
        let reach = Vec3::repeat(self.reach);
        let bounds = Aabb::new(vector(p - reach), vector(p + reach));
        let found = self.hierarchy.bvh().intersect_aabb(&bounds);
        found.map(|e| e as usize).collect::<Vec<_>>().into_iter()
    }

    /// Distance of a point from an edge, and its place there.
    fn foot(&self, p: Vec3, e: usize) -> (f64, f64) {
        let [a, b] = self.edges[e].side.ends.map(|v| self.positions[v as usize]);
        let along = b - a;
        let square = along.norm_squared();
        let place = if square > 0.0 {
            ((p - a).dot(&along) / square).clamp(0.0, 1.0)
        } else {
            0.0
        };
        ((p - a - along * place).norm(), place)
    }

    /// Edges of others on which a vertex lies.
    fn hits(&self, v: u32) -> Vec<Hit> {
        let p = self.positions[v as usize];
        let own = &self.at_vertex[&v];
        let on_edge = |f: usize| {
            let other = &self.edges[f];
            if other.side.ends.contains(&v) {
                return None;
            }
            let widest = |e: &usize| self.widest(&self.edges[*e], other, other.sagitta);
            let widest = own.iter().map(widest).fold(f64::INFINITY, f64::min);
            let (distance, place) = self.foot(p, f);
            let shortest = own.iter().map(|e| self.edges[*e].length);
            let shortest = shortest.fold(other.length, f64::min);
            let ends = other
                .side
                .ends
                .map(|w| (self.positions[w as usize] - p).norm());
            let nearer = usize::from(ends[1] < ends[0]);
            let at_end = ends[nearer] <= GAP_OF_EDGE * shortest;
            let is_inside = 0.0 < place && place < 1.0;
            (distance <= widest && (at_end || is_inside)).then(|| Hit {
                edge: f,
                distance: if at_end { ends[nearer] } else { distance },
                place,
                end: at_end.then(|| other.side.ends[nearer]),
            })
        };
        self.near(p).filter_map(on_edge).collect()
    }

    fn insertion(&self, v: u32, hit: &Hit) -> Insertion {
        let side = self.edges[hit.edge].side;
        Insertion {
            face: side.face,
            corner: side.corner,
            place: hit.place,
            vertex: v,
        }
    }
}

/// Takes the vertices into the sides of faces, in their order along them.
fn insert(mended: &mut Mended, mut insertions: Vec<Insertion>) {
    insertions.sort_by(|a, b| {
        let sides = (a.face, a.corner).cmp(&(b.face, b.corner));
        sides
            .then(a.place.total_cmp(&b.place))
            .then(a.vertex.cmp(&b.vertex))
    });
    // From the last side of a face to the first, so that corners keep their numbers.
    let sides = insertions.chunk_by(|a, b| (a.face, a.corner) == (b.face, b.corner));
    for side in sides.rev() {
        let face = &mut mended.soup.faces[side[0].face as usize];
        let corner = side[0].corner as usize;
        let forward = face[corner] < face[(corner + 1) % face.len()];
        let mut vertices: Vec<u32> = side.iter().map(|i| i.vertex).collect();
        if !forward {
            vertices.reverse();
        }
        face.splice(corner + 1..corner + 1, vertices);
    }
}

/// Angle by which a boundary turns at a vertex with two edges; zero at corners.
fn turn(positions: &[Vec3], sides: &[FaceSide], edges: &[usize], v: u32) -> f64 {
    let [e, f] = edges[..] else { return 0.0 };
    let away = |e: usize| {
        let [a, b] = sides[e].ends;
        positions[(if a == v { b } else { a }) as usize] - positions[v as usize]
    };
    let turn = std::f64::consts::PI - away(e).angle(&away(f));
    if turn <= CORNER { turn } else { 0.0 }
}

fn area(corners: &[Vec3]) -> f64 {
    let fan = corners.windows(2).skip(1);
    let sum: Vec3 = fan
        .map(|w| (w[0] - corners[0]).cross(&(w[1] - corners[0])))
        .sum();
    0.5 * sum.norm()
}

fn vector(p: Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}
