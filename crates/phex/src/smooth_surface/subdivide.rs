//! One step of Loop subdivision as linear stencils (C. Loop, 1987), with kept boundary corners.

use phex_mesh::{EdgeId, PerVertex, Topology, VertexId};
use std::f64::consts::PI;
use std::ops::{Add, Mul};

/// A refinement step: old vertices keep their numbers, edge points follow in the order of the
/// edges.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// Triangles of the refined mesh.
    pub faces: Vec<[u32; 3]>,
    start: Vec<u32>,
    source: Vec<u32>,
    weight: Vec<f64>,
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
        Self::with_stencils(topology, vertex, |e| edge_stencil(topology, e))
    }

    /// The step that splits each triangle in four and has the given stencils for old vertices and
    /// for edges.
    pub(crate) fn with_stencils(
        topology: &Topology,
        vertex: impl Fn(VertexId) -> Vec<(VertexId, f64)>,
        edge: impl Fn(EdgeId) -> Vec<(VertexId, f64)>,
    ) -> (Self, Topology) {
        let mut step = Self {
            faces: split_faces(topology),
            start: vec![0],
            source: Vec::new(),
            weight: Vec::new(),
        };
        topology.vertices().for_each(|v| step.push(&vertex(v)));
        topology.edges().for_each(|e| step.push(&edge(e)));
        let refined = Topology::from_faces(topology.n_vertices() + topology.n_edges(), &step.faces)
            .expect("splitting triangles keeps a manifold a manifold");
        (step, refined)
    }

    /// The step that keeps all old vertices, with new ones half-way between `ends`, and the given
    /// triangles.
    pub(crate) fn with_middles(
        n_vertices: usize,
        ends: impl Iterator<Item = [VertexId; 2]>,
        faces: Vec<[u32; 3]>,
    ) -> Self {
        let mut step = Self {
            faces,
            start: vec![0],
            source: Vec::new(),
            weight: Vec::new(),
        };
        let old = (0..n_vertices as u32).map(VertexId::new);
        old.for_each(|v| step.push(&[(v, 1.0)]));
        ends.for_each(|[a, b]| step.push(&[(a, 0.5), (b, 0.5)]));
        step
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

fn split_faces(topology: &Topology) -> Vec<[u32; 3]> {
    let n = topology.n_vertices() as u32;
    let mut faces = Vec::with_capacity(4 * topology.n_faces());
    for f in topology.faces() {
        let corner: Vec<u32> = topology
            .face_vertices(f)
            .iter()
            .map(|v| v.index() as u32)
            .collect();
        let middle: Vec<u32> = topology
            .face_half_edges(f)
            .map(|h| n + topology.edge(h).index() as u32)
            .collect();
        for k in 0..3 {
            faces.push([corner[k], middle[k], middle[(k + 2) % 3]]);
        }
        faces.push([middle[0], middle[1], middle[2]]);
    }
    faces
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
