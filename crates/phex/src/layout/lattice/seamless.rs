//! Lattice offsets, the integer jumps between them, and the offsets that fit given jumps best.
//!
//! Integer jumps `n` along edges say which lattice point of one vertex is the origin of the next.
//! With jumps free of [dislocations](super::dislocations), `min sum w |z_i - R z_j - d + n|^2` is
//! one linear solve.

use super::boundary::Pin;
use super::chart_graph::ANCHOR;
use super::charted::ChartedSurface;
use super::eisenstein::{Charts, Eisenstein, Plane, dot, rotate, waves};
use super::waves::Projector;
use crate::directions::intrinsic::row;
use phex_mesh::{EdgeId, PerEdge, PerVertex, Topology, VertexId};
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
    pub fn rounded(charted: &ChartedSurface<'_>, position: PerVertex<Plane>) -> Self {
        let (topology, charts) = (charted.topology, charted.charts);
        let jump = PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            Eisenstein::nearest(charts.edge(e).apply(position[j]) - position[i])
        });
        Self { position, jump }
    }

    /// The same lattice, each vertex naming the point nearest to it.
    pub(crate) fn reduced(mut self, charted: &ChartedSurface<'_>) -> Self {
        let (topology, charts) = (charted.topology, charted.charts);
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
    pub(crate) fn same_point(&self, charted: &ChartedSurface<'_>, distance: f64) -> PerEdge<bool> {
        let (topology, charts) = (charted.topology, charted.charts);
        PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            let apart = charts.edge(e).apply(self.position[j]) - self.position[i];
            self.jump[e] == Eisenstein::ZERO || apart.norm() < distance
        })
    }

    /// By how much what an edge's ends say of the same lattice point differs, lattice spacings.
    pub fn residual(&self, charted: &ChartedSurface<'_>, e: EdgeId) -> Plane {
        let [i, j] = charted.topology.edge_vertices(e);
        charted.charts.edge(e).apply(self.position[j]) - self.jump[e].to_plane() - self.position[i]
    }

    /// Residuals over the lengths of the edges.
    pub(crate) fn distortion(&self, charted: &ChartedSurface<'_>) -> PerEdge<f64> {
        PerEdge::from_fn(charted.topology.n_edges(), |e| {
            self.residual(charted, e).norm() / charted.mesh.length[e]
        })
    }
}

/// The system whose solution are lattice offsets that fit the edges and the pins best, whatever the
/// jumps are.
pub(crate) struct OffsetSystem<'a> {
    charted: ChartedSurface<'a>,
    factor: Factor,
}

enum Factor {
    Free(Cholesky<Plane>),
    /// The real form: pins hold one direction alone, which is no product of complex numbers.
    Pinned(Cholesky),
}

impl<'a> OffsetSystem<'a> {
    /// # Errors
    /// If it is singular to rounding.
    pub fn new(charted: ChartedSurface<'a>) -> Result<Self, NumericError> {
        let ChartedSurface { mesh, pins, .. } = charted;
        let own = mesh.mass.iter().map(|m| ANCHOR * m).collect();
        let seen = |e: EdgeId, w: f64, is_along: bool| {
            let seen = -rotate(Plane::new(w, 0.0), charted.charts.edge(e).turn);
            if is_along { seen.conj() } else { seen }
        };
        let entries = mesh.laplacian(charted.topology, 1.0, own, seen);
        let factor = match pins.iter().any(Option::is_some) {
            true => Factor::Pinned(pinned(&entries, pins)?),
            false => {
                let matrix = SymmetricMatrix::from_triplets(pins.len(), entries.into_iter())?;
                Factor::Free(Cholesky::new(&matrix)?)
            }
        };
        Ok(Self { charted, factor })
    }

    /// The offsets for given jumps; nearest to `near` where jumps and pins leave them free.
    pub fn solve(&self, jump: &PerEdge<Eisenstein>, near: &PerVertex<Plane>) -> PerVertex<Plane> {
        let ChartedSurface {
            topology,
            mesh,
            charts,
            pins,
        } = self.charted;
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
        let mut position = PerVertex::from_vec(self.factor.solution(rhs));
        translate(&self.charted, near, &mut position);
        position
    }
}

impl Factor {
    fn solution(&self, rhs: Vec<Plane>) -> Vec<Plane> {
        match self {
            Self::Free(factor) => {
                let mut solution = rhs.clone();
                factor.precondition(&rhs, &mut solution);
                solution
            }
            Self::Pinned(factor) => {
                let rhs: Vec<f64> = rhs.iter().flat_map(|z| [z.re, z.im]).collect();
                let mut solution = rhs.clone();
                factor.precondition(&rhs, &mut solution);
                let pairs = solution.chunks_exact(2);
                pairs.map(|z| Plane::new(z[0], z[1])).collect()
            }
        }
    }
}

/// The factor of a Hermitian matrix in its real form, pins added.
fn pinned(
    entries: &[(u32, u32, Plane)],
    pins: &PerVertex<Option<Pin>>,
) -> Result<Cholesky, NumericError> {
    let block = |&(r, c, z): &(u32, u32, Plane)| {
        [
            (2 * r, 2 * c, z.re),
            (2 * r, 2 * c + 1, -z.im),
            (2 * r + 1, 2 * c, z.im),
            (2 * r + 1, 2 * c + 1, z.re),
        ]
    };
    // `w <n, z - z0>^2`, or its place.
    let pin = |(v, pin): (VertexId, &Option<Pin>)| {
        let (n, w) = pin.map_or((Plane::default(), 0.0), |p| (p.normal, p.weight));
        let v = row(v);
        [
            (2 * v, 2 * v, w * n.re * n.re),
            (2 * v + 1, 2 * v, w * n.re * n.im),
            (2 * v + 1, 2 * v + 1, w * n.im * n.im),
        ]
    };
    let blocks = entries.iter().flat_map(block);
    let all = blocks.chain(pins.enumerate().flat_map(pin));
    let matrix = SymmetricMatrix::from_triplets(2 * pins.len(), all)?;
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
    charted: &ChartedSurface<'_>,
    near: &PerVertex<Plane>,
    position: &mut PerVertex<Plane>,
) {
    let Some(turn) = common_frame(charted.topology, charted.charts) else {
        return;
    };
    let mut sum = [Plane::new(0.0, 0.0); 3];
    for (v, &t) in turn.enumerate() {
        let seen = waves(rotate(near[v] - position[v], t));
        for (sum, wave) in sum.iter_mut().zip(seen) {
            *sum += wave * charted.mesh.mass[v];
        }
    }
    let shift = Projector::new().project(&sum);
    for (v, &t) in turn.enumerate() {
        position[v] += rotate(shift, (6 - t) % 6);
    }
}
