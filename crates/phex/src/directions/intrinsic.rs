//! A triangle mesh known by its edge lengths only.

use super::mirrors::{MirrorPlane, multiplicity};
use nalgebra::Matrix3;
use phex_mesh::{
    EdgeId, ElementId, FaceId, HalfEdgeId, PerEdge, PerElement, PerFace, PerHalfEdge, PerVertex,
    Topology, TriangleSurface,
};
use std::f64::consts::PI;

/// Largest share of the sum of the two other sides that a side may have.
const MAX_SIDE: f64 = 0.98;
/// Smallest cotangent weight: keeps every system positive definite on obtuse triangles.
const MIN_WEIGHT: f64 = 0.02;

/// Lengths, angles and Laplacian weights of a metric on the triangles of a surface. Lengths are in
/// lattice spacings.
#[derive(Clone, Debug)]
pub struct IntrinsicMesh {
    /// Length of each edge.
    pub length: PerEdge<f64>,
    /// Cotangent weight of each edge, at least a small positive number.
    pub weight: PerEdge<f64>,
    /// Interior angle at the origin of each half-edge, in its triangle.
    pub corner: PerHalfEdge<f64>,
    /// Area of each triangle.
    pub area: PerFace<f64>,
    /// A third of the area of the triangles at each vertex.
    pub mass: PerVertex<f64>,
    /// Sum of the angles at each vertex.
    pub angle_sum: PerVertex<f64>,
    /// Polar angle of each edge at the origin of its half-edge.
    pub polar_origin: PerEdge<f64>,
    /// Polar angle of each edge at the target of its half-edge.
    pub polar_target: PerEdge<f64>,
    /// How many images of a vertex lie in its place, itself one of them: more than 1 in mirror
    /// planes alone.
    pub multiplicity: PerVertex<u32>,
}

impl IntrinsicMesh {
    /// Length, in lattice spacings, that a path through a triangle is charged on either side of an
    /// edge: half of its way from centre to centre.
    pub(crate) fn half_crossing(&self, f: FaceId) -> f64 {
        0.375 * self.area[f].sqrt()
    }

    /// The entries of the lower triangle of `t` times the Laplacian with `own` added to its
    /// diagonal. `between` says what stands there for an edge: minus its weight, which it is
    /// given, times what turns the value at the end with the smaller number to the other one;
    /// whether that is the first end it is told.
    pub(crate) fn laplacian<T: From<f64>>(
        &self,
        topology: &Topology,
        t: f64,
        mut own: Vec<f64>,
        between: impl Fn(EdgeId, f64, bool) -> T,
    ) -> Vec<(u32, u32, T)> {
        let mut entries = Vec::with_capacity(topology.n_edges() + own.len());
        for e in topology.edges() {
            let [i, j] = topology.edge_vertices(e).map(row);
            let w = t * self.weight[e];
            own[i as usize] += w;
            own[j as usize] += w;
            entries.push((i.max(j), i.min(j), between(e, w, i < j)));
        }
        entries.extend((0..).zip(own).map(|(v, d)| (v, v, T::from(d))));
        entries
    }

    /// Multiplies all lengths by a `factor`; angles and weights stay as they are.
    pub(crate) fn scale(&mut self, factor: f64) {
        let area = factor.powi(2);
        self.length.iter_mut().for_each(|l| *l *= factor);
        self.area.iter_mut().for_each(|a| *a *= area);
        self.mass.iter_mut().for_each(|m| *m *= area);
    }

    /// Measures the edges of `surface` in the tensors `metric`.
    pub fn new(surface: &TriangleSurface, metric: &PerVertex<Matrix3<f64>>) -> Self {
        let topology = surface.topology();
        let mut length = PerEdge::from_fn(topology.n_edges(), |e| {
            let [a, b] = topology.edge_vertices(e);
            let d = surface.positions()[b] - surface.positions()[a];
            (0.5 * d.dot(&((metric[a] + metric[b]) * d)) + 1e-18).sqrt()
        });
        mend_triangles(topology, &mut length);
        Self::from_lengths(topology, length)
    }

    /// The same on a surface whose boundary lies in mirror planes.
    pub(crate) fn with_mirrors(
        mut self,
        surface: &TriangleSurface,
        mirrors: &[MirrorPlane],
    ) -> Self {
        self.multiplicity = multiplicity(surface, mirrors);
        self
    }

    /// Everything else from edge lengths that satisfy the triangle inequalities.
    pub(crate) fn from_lengths(topology: &Topology, length: PerEdge<f64>) -> Self {
        let side = |h: HalfEdgeId| length[topology.edge(h)];
        let corner = PerHalfEdge::from_fn(topology.n_half_edges(), |h| {
            let (b, c, a) = (side(h), side(topology.prev(h)), side(topology.next(h)));
            ((b * b + c * c - a * a) / (2.0 * b * c))
                .clamp(-0.99999, 0.99999)
                .acos()
        });
        let area = PerFace::from_fn(topology.n_faces(), |f| {
            let h = topology
                .face_half_edges(f)
                .next()
                .expect("a triangle has half-edges");
            0.5 * side(h) * side(topology.prev(h)) * corner[h].sin()
        });
        let mut weight = PerEdge::filled(topology.n_edges(), 0.0);
        let mut mass = PerVertex::filled(topology.n_vertices(), 0.0);
        let mut angle_sum = PerVertex::filled(topology.n_vertices(), 0.0);
        for h in topology.half_edges() {
            weight[topology.edge(h)] += 0.5 / corner[topology.prev(h)].tan();
            mass[topology.origin(h)] += area[topology.face(h)] / 3.0;
            angle_sum[topology.origin(h)] += corner[h];
        }
        weight.iter_mut().for_each(|w| *w = w.max(MIN_WEIGHT));
        let mut mesh = Self {
            length,
            weight,
            corner,
            area,
            mass,
            angle_sum,
            polar_origin: PerElement::filled(topology.n_edges(), 0.0),
            polar_target: PerElement::filled(topology.n_edges(), 0.0),
            multiplicity: PerVertex::filled(topology.n_vertices(), 1),
        };
        mesh.unroll(topology);
        mesh
    }

    /// Polar angles round each vertex from its first half-edge, scaled to a full turn at interior
    /// vertices.
    fn unroll(&mut self, topology: &Topology) {
        for v in topology.vertices() {
            let full = if topology.is_boundary_vertex(v) {
                1.0
            } else {
                2.0 * PI / self.angle_sum[v]
            };
            let mut angle = 0.0;
            let mut last = None;
            for h in topology.outgoing(v) {
                self.set_polar(topology, h, angle * full);
                angle += self.corner[h];
                last = Some(h);
            }
            if let (true, Some(h)) = (topology.is_boundary_vertex(v), last) {
                // The boundary edge that enters `v` has no half-edge that leaves it.
                self.polar_target[topology.edge(topology.prev(h))] = angle;
            }
        }
    }

    fn set_polar(&mut self, topology: &Topology, h: HalfEdgeId, angle: f64) {
        let e = topology.edge(h);
        if topology.runs_along(h) {
            self.polar_origin[e] = angle;
        } else {
            self.polar_target[e] = angle;
        }
    }

    /// Rotation that parallel transport along an edge (from the origin to the target of its
    /// half-edge) adds to a polar angle.
    pub(crate) fn transport(&self, e: phex_mesh::EdgeId) -> f64 {
        self.polar_target[e] + PI - self.polar_origin[e]
    }

    /// Polar angle, at its origin, of the direction of a half-edge.
    pub fn polar(&self, topology: &Topology, h: HalfEdgeId) -> f64 {
        let e = topology.edge(h);
        if topology.runs_along(h) {
            self.polar_origin[e]
        } else {
            self.polar_target[e]
        }
    }
}

/// Shortens the longest side of triangles that violate the triangle inequality, and lengthens the
/// others a little.
fn mend_triangles(topology: &Topology, length: &mut PerEdge<f64>) {
    for _ in 0..100 {
        let mut mended = true;
        for f in topology.faces() {
            let edges: Vec<_> = topology
                .face_half_edges(f)
                .map(|h| topology.edge(h))
                .collect();
            let sum: f64 = edges.iter().map(|&e| length[e]).sum();
            let longest = *edges
                .iter()
                .max_by(|a, b| length[**a].total_cmp(&length[**b]))
                .expect("three edges");
            if length[longest] > MAX_SIDE * (sum - length[longest]) {
                mended = false;
                edges
                    .iter()
                    .for_each(|&e| length[e] *= if e == longest { 0.98 } else { 1.01 });
            }
        }
        if mended {
            return;
        }
    }
    // What small changes did not mend is made equilateral enough by force. Sides only grow, each at
    // most to a share of one that is longer, so this ends.
    while force_triangles(topology, length) {}
}

/// Lengthens the shorter sides of triangles that violate the triangle inequality; false if there is
/// none.
fn force_triangles(topology: &Topology, length: &mut PerEdge<f64>) -> bool {
    let mut forced = false;
    for f in topology.faces() {
        let edges = || topology.face_half_edges(f).map(|h| topology.edge(h));
        let sum: f64 = edges().map(|e| length[e]).sum();
        let longest = edges().map(|e| length[e]).fold(0.0, f64::max);
        if longest > MAX_SIDE * (sum - longest) {
            edges().for_each(|e| length[e] = length[e].max(0.52 * longest));
            forced = true;
        }
    }
    forced
}

/// Total order for distances in a heap.
#[derive(Clone, Copy, PartialEq)]
pub(crate) struct Distance(pub f64);
impl Eq for Distance {}
impl PartialOrd for Distance {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Distance {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// Index of a vertex in a system with one unknown per vertex.
pub(crate) fn row<I: ElementId>(v: I) -> u32 {
    v.index() as u32
}
