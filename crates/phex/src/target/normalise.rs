//! The surface as all later stages see it: the same for the same shape, whatever its unit and however its file numbers it.
//!
//! A millimetre is a thousandth of a metre, but their doubles round differently, and a lattice on a hard surface turns a last bit into
//! another layout. So normalised coordinates are rounded to a grid. Vertices are numbered as a walk over the surface meets them, ring
//! by ring from the vertex that is farthest from the middle: numbers then depend on the shape alone, and mostly not on how it is turned.

use super::{Similarity, triangles};
use phex_mesh::{PerVertex, Topology, TriangleSurface, Vec3, VertexId};
use std::cmp::Reverse;
use std::collections::VecDeque;

/// Steps of the grid in a diagonal. Rounding errors of coordinates are 1e-16 of the diagonal, a millionth of a step: a vertex so near
/// to the middle between two steps that they decide is rare. A step is 7 nanometres on a surface of 30 metres.
const STEPS: f64 = (1_u64 << 32) as f64;

/// A surface in normalised coordinates.
#[derive(Clone)]
pub struct Normalised {
    /// The surface, its vertices and triangles in an order that its shape gives them.
    pub surface: TriangleSurface,
    /// What brings the given surface there, up to the grid.
    pub similarity: Similarity,
    /// The number that each vertex has in the given surface.
    pub given: PerVertex<VertexId>,
}

impl Normalised {
    /// Brings a surface to diagonal 1, its box centre to the origin, its vertices to the grid, and its numbers in order.
    pub fn of(surface: &TriangleSurface) -> Self {
        let similarity = Similarity::normalising(surface);
        let steps = surface
            .positions()
            .map(|p| in_steps(similarity.normalise(*p)));
        let given = Walk::new(surface.topology(), &steps).order();
        let mut number = PerVertex::filled(given.len(), 0);
        for (new, old) in given.iter().enumerate() {
            number[*old] = new as u32;
        }
        let renumbered = |t: [u32; 3]| {
            let mut t = t.map(|v| number[VertexId::new(v)]);
            let least = (0..3).min_by_key(|k| t[*k]).unwrap_or(0);
            t.rotate_left(least);
            t
        };
        let mut lists: Vec<[u32; 3]> = triangles(surface).into_iter().map(renumbered).collect();
        lists.sort_unstable();
        let positions = given.iter().map(|v| of_steps(steps[*v])).collect();
        Self {
            surface: TriangleSurface::new(positions, &lists)
                .expect("other numbers keep a manifold a manifold"),
            similarity,
            given: PerVertex::from_vec(given),
        }
    }

    /// Values of the given surface's vertices, in the order of the normalised one's.
    pub fn in_order(&self, values: &[f64]) -> Vec<f64> {
        self.given.iter().map(|v| values[v.index()]).collect()
    }

    /// A place of the model in normalised coordinates, on the grid.
    pub fn place(&self, p: Vec3) -> Vec3 {
        of_steps(in_steps(self.similarity.normalise(p)))
    }
}

type Steps = [i64; 3];

fn in_steps(p: Vec3) -> Steps {
    std::array::from_fn(|k| (p[k] * STEPS).round() as i64)
}

fn of_steps(steps: Steps) -> Vec3 {
    Vec3::from(steps.map(|c| c as f64 / STEPS))
}

/// A walk over a surface, breadth first.
struct Walk<'a> {
    topology: &'a Topology,
    steps: &'a PerVertex<Steps>,
    /// Sum of all vertices: whole numbers do not depend on the order in which they are added.
    sum: [i128; 3],
    met: PerVertex<bool>,
}

impl<'a> Walk<'a> {
    fn new(topology: &'a Topology, steps: &'a PerVertex<Steps>) -> Self {
        let sum = |k: usize| steps.iter().map(|p| i128::from(p[k])).sum();
        Self {
            topology,
            steps,
            sum: std::array::from_fn(sum),
            met: PerVertex::filled(steps.len(), false),
        }
    }

    /// What vertices are chosen by, the least first: how far they are from the middle, then where they are.
    fn key(&self, v: VertexId) -> (Reverse<u128>, Steps) {
        let count = self.steps.len() as i128;
        let off = |k: usize| i128::from(self.steps[v][k]) - self.sum[k] / count;
        let squares = (0..3).map(|k| off(k).unsigned_abs().pow(2));
        (Reverse(squares.sum()), self.steps[v])
    }

    /// All vertices in the order in which they are met.
    fn order(mut self) -> Vec<VertexId> {
        let mut order = Vec::with_capacity(self.steps.len());
        let mut starts: Vec<VertexId> = self.topology.vertices().collect();
        starts.sort_by_cached_key(|v| self.key(*v));
        for start in starts {
            if !self.met[start] {
                self.component(start, &mut order);
            }
        }
        order
    }

    /// The vertices that hang together with one; the ring of each is met from the vertex on that led to it.
    fn component(&mut self, start: VertexId, order: &mut Vec<VertexId>) {
        let neighbours = self.topology.neighbours(start).into_iter();
        let first = neighbours.min_by_key(|v| self.key(*v)).unwrap_or(start);
        let mut queue = VecDeque::from([(start, first)]);
        self.met[start] = true;
        while let Some((v, from)) = queue.pop_front() {
            order.push(v);
            let mut ring = self.topology.neighbours(v);
            if !self.topology.is_boundary_vertex(v) {
                let at = ring.iter().position(|w| *w == from).unwrap_or(0);
                ring.rotate_left(at);
            }
            for w in ring {
                if !std::mem::replace(&mut self.met[w], true) {
                    queue.push_back((w, v));
                }
            }
        }
    }
}
