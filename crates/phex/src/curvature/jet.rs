//! Fitting one second-order jet.

use super::tensor::tangent_frame;
use nalgebra::{Matrix2, Matrix3, SMatrix, SVector};
use phex_mesh::{TriangleSurface, Vec3, VertexId};

/// Normal and second fundamental form at a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jet {
    pub normal: Vec3,
    pub tensor: Matrix3<f64>,
}

/// Collects connected neighbourhoods without allocating for each vertex.
pub(super) struct Neighbourhood<'a> {
    surface: &'a TriangleSurface,
    stamp: Vec<u32>,
    round: u32,
    members: Vec<VertexId>,
}

/// Fewest neighbours that determine a jet with something to spare.
const MIN_NEIGHBOURS: usize = 9;

impl<'a> Neighbourhood<'a> {
    pub fn new(surface: &'a TriangleSurface) -> Self {
        Self {
            surface,
            stamp: vec![0; surface.positions().len()],
            round: 0,
            members: Vec::new(),
        }
    }

    /// Vertices connected to `v` within `radius`, and at least two rings.
    pub fn collect(&mut self, v: VertexId, radius: f64) -> &[VertexId] {
        self.round += 1;
        self.members.clear();
        self.members.push(v);
        self.stamp[v.index()] = self.round;
        let (mut ring_start, mut ring) = (0, 0);
        while ring_start < self.members.len() {
            let ring_end = self.members.len();
            let enough = ring >= 2 && (ring_end > MIN_NEIGHBOURS || ring >= 4);
            for i in ring_start..ring_end {
                self.visit_ring(
                    self.members[i],
                    v,
                    if enough { radius } else { f64::INFINITY },
                );
            }
            ring_start = ring_end;
            ring += 1;
        }
        &self.members
    }

    fn visit_ring(&mut self, at: VertexId, centre: VertexId, reach: f64) {
        let positions = self.surface.positions();
        let topology = self.surface.topology();
        for h in topology.outgoing(at) {
            // The origin of the previous half-edge covers the last neighbour at a boundary.
            for w in [topology.target(h), topology.origin(topology.prev(h))] {
                if self.stamp[w.index()] != self.round
                    && (positions[w] - positions[centre]).norm() < reach
                {
                    self.stamp[w.index()] = self.round;
                    self.members.push(w);
                }
            }
        }
    }
}

/// Fits a jet at `v` to the members within `reach` (all, when too few are).
pub(super) fn fit(surface: &TriangleSurface, v: VertexId, members: &[VertexId], reach: f64) -> Jet {
    let (p, n) = (surface.positions()[v], surface.normals()[v]);
    let [e1, e2] = tangent_frame(n);
    let within = |w: &VertexId| (surface.positions()[*w] - p).norm() <= reach;
    let enough = members.iter().filter(|w| within(w)).count() > MIN_NEIGHBOURS;
    let local: Vec<Vec3> = members
        .iter()
        .filter(|w| (!enough || within(w)) && surface.normals()[**w].dot(&n) > 0.2)
        .map(|w| surface.positions()[*w] - p)
        .map(|d| Vec3::new(d.dot(&e1), d.dot(&e2), d.dot(&n)))
        .collect();
    let reach = local.iter().map(|q| q.xy().norm()).fold(0.0, f64::max);
    let flat = Jet {
        normal: n,
        tensor: Matrix3::zeros(),
    };
    if reach == 0.0 || reach.is_nan() {
        return flat;
    }
    match solve(&local, reach) {
        Some(c) => jet(&c, reach, n, e1, e2),
        None => flat,
    }
}

fn row(x: f64, y: f64) -> SVector<f64, 6> {
    SVector::from([1.0, x, y, 0.5 * x * x, x * y, 0.5 * y * y])
}

fn solve(local: &[Vec3], reach: f64) -> Option<SVector<f64, 6>> {
    let mut normal_matrix = SMatrix::<f64, 6, 6>::identity() * 1e-9;
    let mut rhs = SVector::<f64, 6>::zeros();
    for q in local {
        let (x, y, z) = (q.x / reach, q.y / reach, q.z / reach);
        let row = row(x, y);
        let weight = (-2.0 * (x * x + y * y)).exp();
        normal_matrix += row * row.transpose() * weight;
        rhs += row * (weight * z);
    }
    normal_matrix.cholesky().map(|c| c.solve(&rhs))
}

fn jet(c: &SVector<f64, 6>, reach: f64, n: Vec3, e1: Vec3, e2: Vec3) -> Jet {
    let (p, q) = (c[1], c[2]);
    let w = (1.0 + p * p + q * q).sqrt();
    let second = Matrix2::new(c[3], c[4], c[4], c[5]) / (w * reach);
    let first = Matrix2::new(1.0 + p * p, p * q, p * q, 1.0 + q * q);
    let inverse = first.try_inverse().unwrap_or_else(Matrix2::identity);
    let tangents = SMatrix::<f64, 3, 2>::from_columns(&[e1 + n * p, e2 + n * q]) * inverse;
    Jet {
        normal: (n - e1 * p - e2 * q) / w,
        tensor: -(tangents * second * tangents.transpose()),
    }
}
