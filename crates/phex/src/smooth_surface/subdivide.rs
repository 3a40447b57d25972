//! One step of Loop subdivision as linear stencils (C. Loop, 1987), with kept boundary corners.

use phex_mesh::{EdgeId, FaceId, HalfEdgeId, PerEdge, PerVertex, Topology, VertexId};
use std::f64::consts::PI;
use std::ops::{Add, Mul};

/// A refinement step: old vertices keep their numbers, new ones on the edges that were split
/// follow.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// Triangles of the refined mesh.
    pub faces: Vec<[u32; 3]>,
    start: Vec<u32>,
    source: Vec<u32>,
    weight: Vec<f64>,
}

/// Edges that a refinement step splits, and the lengths by which it cuts the triangles of which it
/// splits two.
pub(crate) struct Splits {
    edges: Vec<EdgeId>,
    length: PerEdge<f64>,
}

impl Splits {
    /// All edges of a mesh: each triangle becomes four.
    pub fn all(topology: &Topology) -> Self {
        Self {
            edges: topology.edges().collect(),
            length: PerEdge::filled(topology.n_edges(), 0.0),
        }
    }

    /// The edges longer than a limit.
    pub fn longer(length: PerEdge<f64>, limit: f64) -> Self {
        let long = length.enumerate().filter(|(_, l)| **l > limit);
        Self {
            edges: long.map(|(e, _)| e).collect(),
            length,
        }
    }

    /// The edges, in the order of their new vertices.
    pub fn edges(&self) -> &[EdgeId] {
        &self.edges
    }
}

impl Refinement {
    /// The Loop step of a triangle mesh; vertices in `corners` do not move. Returns the refined
    /// connectivity too.
    pub fn of(topology: &Topology, corners: &[VertexId]) -> (Self, Topology) {
        let mut fixed = PerVertex::filled(topology.n_vertices(), false);
        corners.iter().for_each(|&v| fixed[v] = true);
        let vertex = |v| {
            if fixed[v] {
                vec![(v, 1.0)]
            } else {
                vertex_stencil(topology, v)
            }
        };
        let all = Splits::all(topology);
        Self::with_stencils(topology, &all, vertex, |e| edge_stencil(topology, e))
    }

    /// The step that splits these edges and has the given stencils for old vertices and for edges.
    pub(crate) fn with_stencils(
        topology: &Topology,
        splits: &Splits,
        vertex: impl Fn(VertexId) -> Vec<(VertexId, f64)>,
        edge: impl Fn(EdgeId) -> Vec<(VertexId, f64)>,
    ) -> (Self, Topology) {
        let mut step = Self {
            faces: pieces(topology, splits),
            start: vec![0],
            source: Vec::new(),
            weight: Vec::new(),
        };
        topology.vertices().for_each(|v| step.push(&vertex(v)));
        splits.edges.iter().for_each(|e| step.push(&edge(*e)));
        let refined = Topology::from_faces(topology.n_vertices() + splits.edges.len(), &step.faces)
            .expect("splitting triangles keeps a manifold a manifold");
        (step, refined)
    }

    fn push(&mut self, stencil: &[(VertexId, f64)]) {
        for &(v, w) in stencil {
            self.source.push(v.index() as u32);
            self.weight.push(w);
        }
        self.start.push(self.source.len() as u32);
    }

    /// Values of the refined vertices from those of the coarse ones.
    pub fn apply<T>(&self, values: &PerVertex<T>) -> PerVertex<T>
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        let values = values.as_slice();
        PerVertex::from_fn(self.start.len() - 1, |v: VertexId| {
            let range = self.start[v.index()] as usize..self.start[v.index() + 1] as usize;
            let term = |i: usize| values[self.source[i] as usize] * self.weight[i];
            let first = term(range.start);
            range.skip(1).fold(first, |sum, i| sum + term(i))
        })
    }
}

/// The pieces of all triangles.
fn pieces(topology: &Topology, splits: &Splits) -> Vec<[u32; 3]> {
    let mut middle = PerEdge::filled(topology.n_edges(), None);
    for (i, e) in splits.edges.iter().enumerate() {
        middle[*e] = Some((topology.n_vertices() + i) as u32);
    }
    let mut faces = Vec::with_capacity(topology.n_faces() + 2 * splits.edges.len());
    for f in topology.faces() {
        split_face(topology, f, &middle, &splits.length, &mut faces);
    }
    faces
}

/// The pieces of a triangle; one of which two edges are split is cut along the shorter median.
fn split_face(
    topology: &Topology,
    f: FaceId,
    middle: &PerEdge<Option<u32>>,
    length: &PerEdge<f64>,
    faces: &mut Vec<[u32; 3]>,
) {
    let sides: Vec<HalfEdgeId> = topology.face_half_edges(f).collect();
    let edge = |k: usize| topology.edge(sides[k % 3]);
    let corner = |k: usize| topology.origin(sides[k % 3]).index() as u32;
    let middles = [0, 1, 2].map(|k| middle[edge(k)]);
    match middles {
        [None, None, None] => faces.push([0, 1, 2].map(corner)),
        [Some(a), Some(b), Some(c)] => faces.extend([
            [corner(0), a, c],
            [corner(1), b, a],
            [corner(2), c, b],
            [a, b, c],
        ]),
        _ => {
            // Turned so that the only long edge is the first, or the two long ones are the first
            // two.
            let first = |k: &usize| middles[*k].is_some() && middles[(k + 2) % 3].is_none();
            let k = (0..3)
                .find(first)
                .expect("one or two of three edges are long");
            let (p, q, r) = (corner(k), corner(k + 1), corner(k + 2));
            match (middles[k], middles[(k + 1) % 3]) {
                (Some(a), Some(b)) => {
                    faces.push([a, q, b]);
                    faces.extend(if length[edge(k)] >= length[edge(k + 1)] {
                        [[a, b, r], [a, r, p]]
                    } else {
                        [[a, b, p], [b, r, p]]
                    });
                }
                (Some(a), _) => faces.extend([[p, a, r], [a, q, r]]),
                _ => unreachable!("the first edge is long"),
            }
        }
    }
}

/// Loop's stencil of an old vertex.
pub(crate) fn vertex_stencil(topology: &Topology, v: VertexId) -> Vec<(VertexId, f64)> {
    let ring = topology.neighbours(v);
    if topology.is_boundary_vertex(v) {
        return vec![(v, 0.75), (ring[0], 0.125), (ring[ring.len() - 1], 0.125)];
    }
    let n = ring.len() as f64;
    let beta = (0.625 - (0.375 + 0.25 * (2.0 * PI / n).cos()).powi(2)) / n;
    let mut stencil = vec![(v, 1.0 - n * beta)];
    stencil.extend(ring.into_iter().map(|w| (w, beta)));
    stencil
}

/// Loop's stencil of the new vertex on an edge.
pub(crate) fn edge_stencil(topology: &Topology, e: EdgeId) -> Vec<(VertexId, f64)> {
    let [a, b] = topology.edge_vertices(e);
    let h = topology.edge_half_edge(e);
    let opposite = |h| topology.origin(topology.prev(h));
    match topology.twin(h) {
        None => vec![(a, 0.5), (b, 0.5)],
        Some(t) => vec![
            (a, 0.375),
            (b, 0.375),
            (opposite(h), 0.125),
            (opposite(t), 0.125),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn stencils_are_affine_and_reproduce_a_plane() {
        let faces = [[0u32, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]];
        let topology = Topology::from_faces(6, &faces).unwrap();
        let points = PerVertex::from_fn(6, |v: VertexId| {
            let t = v.index() as f64;
            let (x, y) = if t == 0.0 {
                (0.0, 0.0)
            } else {
                ((1.3 * t).cos(), (1.3 * t).sin())
            };
            Vec3::new(x, y, 1.0 + 2.0 * x - 3.0 * y)
        });
        let (step, refined) = Refinement::of(&topology, &[VertexId::new(2)]);
        let fine = step.apply(&points);
        assert_eq!(
            refined.euler_characteristic(),
            topology.euler_characteristic()
        );
        assert_eq!(fine.len(), topology.n_vertices() + topology.n_edges());
        assert_eq!(fine[VertexId::new(2)], points[VertexId::new(2)]);
        for p in &fine {
            assert!((p.z - (1.0 + 2.0 * p.x - 3.0 * p.y)).abs() < 1e-14);
        }
    }
}
