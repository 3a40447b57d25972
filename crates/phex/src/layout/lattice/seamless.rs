//! Lattice offsets, the integer jumps between them, and the offsets that fit given jumps best.
//!
//! Integer jumps `n` along edges say which lattice point of one vertex is the origin of the next.
//! With jumps free of [dislocations](super::dislocations), `min sum w |z_i - R z_j - d + n|^2` is
//! one linear solve.

use super::boundary::Pin;
use super::chart_graph::ANCHOR;
use super::eisenstein::{Charts, Eisenstein, Plane, dot, rotate, waves};
use super::waves::Projector;
use crate::directions::intrinsic::IntrinsicMesh;
use crate::directions::rosy::{push_block, rough_solution};
use phex_mesh::{EdgeId, PerEdge, PerVertex, Topology};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};

/// Lattice offsets and the integer jumps between them.
#[derive(Clone, Debug)]
pub(crate) struct Offsets {
    /// Position of the nearest lattice point in the chart of each vertex.
    pub position: PerVertex<Plane>,
    /// Jump along each edge: the target's lattice point is the origin's moved by it. Zero: both
    /// name the same point.
    pub jump: PerEdge<Eisenstein>,
}

impl Offsets {
    /// Jumps by rounding.
    pub fn rounded(topology: &Topology, charts: &Charts, position: PerVertex<Plane>) -> Self {
        let jump = PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            Eisenstein::nearest(charts.edge(e).apply(position[j]) - position[i])
        });
        Self { position, jump }
    }

    /// The same lattice, each vertex naming the point nearest to it.
    pub(crate) fn reduced(mut self, topology: &Topology, charts: &Charts) -> Self {
        let shift = self.position.map(|z| Eisenstein::nearest(*z));
        for e in topology.edges() {
            let [i, j] = topology.edge_vertices(e);
            self.jump[e] = self.jump[e] - shift[j].rotated(charts.edge(e).turn) + shift[i];
        }
        for (z, p) in self.position.iter_mut().zip(&shift) {
            *z -= p.to_plane();
        }
        self
    }

    /// Whether the ends of each edge name the same lattice point, or points nearer to each other
    /// than `distance`: the offsets about a cone do not close, so that a point beside it is seen
    /// twice.
    pub(crate) fn same_point(
        &self,
        topology: &Topology,
        charts: &Charts,
        distance: f64,
    ) -> PerEdge<bool> {
        PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            let apart = charts.edge(e).apply(self.position[j]) - self.position[i];
            self.jump[e] == Eisenstein::ZERO || apart.norm() < distance
        })
    }

    /// By how much what an edge's ends say of the same lattice point differs, lattice spacings.
    pub fn residual(&self, topology: &Topology, charts: &Charts, e: EdgeId) -> Plane {
        let [i, j] = topology.edge_vertices(e);
        charts.edge(e).apply(self.position[j]) - self.jump[e].to_plane() - self.position[i]
    }

    /// Residuals over the lengths of the edges.
    pub(crate) fn distortion(
        &self,
        topology: &Topology,
        mesh: &IntrinsicMesh,
        charts: &Charts,
    ) -> PerEdge<f64> {
        PerEdge::from_fn(topology.n_edges(), |e| {
            self.residual(topology, charts, e).norm() / mesh.length[e]
        })
    }
}

/// Lattice offsets that fit the edges best with given jumps, and the pins; nearest to `near` where
/// that leaves them free. `factor` is that of [`factorised`] with the same charts and pins.
pub(crate) fn solve_offsets(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    jump: &PerEdge<Eisenstein>,
    pins: &PerVertex<Option<Pin>>,
    near: &PerVertex<Plane>,
    factor: &Cholesky,
) -> PerVertex<Plane> {
    let held = near.iter().zip(&mesh.mass);
    let mut rhs: Vec<Plane> = held.map(|(z, m)| z * (ANCHOR * m)).collect();
    for e in topology.edges() {
        let [i, j] = topology.edge_vertices(e).map(|v| v.index());
        let t = charts.edge(e);
        let c = (t.offset - jump[e].to_plane()) * mesh.weight[e];
        rhs[i] += c;
        rhs[j] -= rotate(c, (6 - t.turn) % 6);
    }
    for (v, pin) in pins.enumerate() {
        if let Some(pin) = pin {
            let wanted = near[v] + pin.correction(near[v]);
            rhs[v.index()] += pin.normal * (pin.weight * dot(pin.normal, wanted));
        }
    }
    let mut position = PerVertex::from_vec(rough_solution(factor, |i| rhs[i], rhs.len()));
    translate(topology, mesh, charts, near, &mut position);
    position
}

/// The system of [`solve_offsets`], factorised.
///
/// # Errors
/// If it is singular to rounding.
pub(crate) fn factorised(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    pins: &PerVertex<Option<Pin>>,
) -> Result<Cholesky, NumericError> {
    let n = topology.n_vertices();
    let mut own: Vec<f64> = mesh.mass.iter().map(|m| ANCHOR * m).collect();
    let mut entries = Vec::with_capacity(4 * topology.n_edges() + 2 * n);
    for e in topology.edges() {
        let ([i, j], w, t) = (
            topology.edge_vertices(e).map(|v| v.index()),
            mesh.weight[e],
            charts.edge(e),
        );
        own[i] += w;
        own[j] += w;
        push_block(
            &mut entries,
            i as u32,
            j as u32,
            -rotate(Plane::new(w, 0.0), t.turn),
        );
    }
    for (v, d) in own.iter().enumerate() {
        entries.push((2 * v as u32, 2 * v as u32, *d));
        entries.push((2 * v as u32 + 1, 2 * v as u32 + 1, *d));
    }
    for (v, pin) in pins.enumerate() {
        push_pin(&mut entries, v.index() as u32, pin.as_ref());
    }
    let matrix = SymmetricMatrix::from_triplets(2 * n, entries.into_iter())?;
    Cholesky::again(None, &matrix, 2)
}

/// Turns that take each chart to that of the first vertex, where no loop turns: then a common
/// translation costs nothing.
fn common_frame(topology: &Topology, charts: &Charts) -> Option<PerVertex<u8>> {
    let mut turn: PerVertex<Option<u8>> = PerVertex::filled(topology.n_vertices(), None);
    let first = topology.vertices().next()?;
    turn[first] = Some(0);
    let mut stack = vec![first];
    while let Some(v) = stack.pop() {
        for h in topology.outgoing(v) {
            for h in [h, topology.prev(h)] {
                let seen = charts.half_edge(topology, h).turn;
                let (w, step) = if topology.origin(h) == v {
                    (topology.target(h), seen)
                } else {
                    (topology.origin(h), 6 - seen)
                };
                let there = turn[v].map(|t| (t + step) % 6);
                if turn[w].is_none() {
                    turn[w] = there;
                    stack.push(w);
                } else if turn[w] != there {
                    return None;
                }
            }
        }
    }
    turn.iter()
        .copied()
        .collect::<Option<Vec<u8>>>()
        .map(PerVertex::from_vec)
}

/// Translates a lattice to where it fits `near` best, modulo the lattice, if a common translation
/// costs nothing: which of several shortest paths a dislocation took shifts offsets by lattice
/// vectors and must not matter.
pub(super) fn translate(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    near: &PerVertex<Plane>,
    position: &mut PerVertex<Plane>,
) {
    let Some(turn) = common_frame(topology, charts) else {
        return;
    };
    let mut sum = [Plane::new(0.0, 0.0); 3];
    for (v, &t) in turn.enumerate() {
        let seen = waves(rotate(near[v] - position[v], t));
        for (sum, wave) in sum.iter_mut().zip(seen) {
            *sum += wave * mesh.mass[v];
        }
    }
    let shift = Projector::new().project(&sum);
    for (v, &t) in turn.enumerate() {
        position[v] += rotate(shift, (6 - t) % 6);
    }
}

/// Adds the matrix of `w <n, z - z0>^2`, or its place.
fn push_pin(entries: &mut Vec<(u32, u32, f64)>, v: u32, pin: Option<&Pin>) {
    let (n, w) = pin.map_or((Plane::default(), 0.0), |p| (p.normal, p.weight));
    entries.push((2 * v, 2 * v, w * n.re * n.re));
    entries.push((2 * v + 1, 2 * v, w * n.re * n.im));
    entries.push((2 * v + 1, 2 * v + 1, w * n.im * n.im));
}
