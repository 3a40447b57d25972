//! The discrete Gauss image `M'`: a mesh parallel to `M` whose faces, edges or vertices touch the unit sphere.

use phex_mesh::{HexMesh, PerVertex, Vec3};
use serde::{Deserialize, Serialize};

/// What keeps its distance in an offset, and so what of the Gauss image touches the unit sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OffsetKind {
    /// Planes of faces.
    #[default]
    Face,
    /// Edges; the Gauss image is a Koebe mesh.
    Edge,
    /// Vertices.
    Vertex,
}

/// A discrete Gauss image: the direction and speed of every vertex, `M_d = M + d M'`.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussImage {
    /// What touches the unit sphere.
    pub kind: OffsetKind,
    /// The vertices of `M'`.
    pub positions: PerVertex<Vec3>,
}

impl GaussImage {
    /// `M'` as a mesh with the connectivity of `mesh`. Its faces may be turned over where `mesh` is saddle-shaped.
    ///
    /// # Panics
    /// If the number of vertices differs.
    pub fn mesh(&self, mesh: &HexMesh) -> HexMesh {
        mesh.with_positions(self.positions.clone())
    }

    /// `M_d = M + d M'`; that it is valid is not implied.
    ///
    /// # Panics
    /// If the number of vertices differs.
    pub fn offset(&self, mesh: &HexMesh, distance: f64) -> HexMesh {
        let moved = |(x, direction): (&Vec3, &Vec3)| x + direction * distance;
        let positions = mesh.positions.iter().zip(&self.positions).map(moved);
        mesh.with_positions(PerVertex::from_vec(positions.collect()))
    }
}
