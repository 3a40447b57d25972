//! Where cells begin to grow.

use phex_mesh::VertexId;

/// Vertices nearer to a lattice point than this start in its cell, at the distance that the lattice
/// says.
pub(super) const CORE: f64 = 0.45;

/// Where a cell begins to grow.
#[derive(Clone, Debug, PartialEq)]
pub struct Seed {
    /// The vertex nearest to the lattice point; it names the seed.
    pub vertex: VertexId,
    /// Vertices round it with their distances, so that a cell's middle need not be a vertex.
    pub core: Vec<(VertexId, f64)>,
}

impl Seed {
    /// A seed in a vertex.
    pub fn at(vertex: VertexId) -> Self {
        Self {
            vertex,
            core: vec![(vertex, 0.0)],
        }
    }
}
