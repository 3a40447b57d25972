//! The discrete Gauss image `M'`: a mesh parallel to `M` whose faces, edges or vertices touch the
//! unit sphere.

use phex_mesh::{EdgeId, HexMesh, PerVertex, Vec3};
use serde::{Deserialize, Serialize};

/// Part of an edge across its direction in the mesh, over the largest vector of the image, above
/// which it is not parallel.
const TURNED: f64 = 1e-9;

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
    /// `M'` as a mesh with the connectivity of `mesh`. Its faces may be turned over where `mesh` is
    /// saddle-shaped.
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

    /// The edges of `M'` that are not parallel to those of `mesh`. Only edges at the boundary can
    /// be: in a face-distance offset fewer than three faces say where a vertex goes there, and a
    /// vertex-distance offset leaves an edge of an odd face free.
    ///
    /// # Panics
    /// If the number of vertices differs.
    pub fn turned_edges(&self, mesh: &HexMesh) -> Vec<TurnedEdge> {
        let largest = self.positions.iter().map(Vec3::norm).fold(0.0, f64::max);
        let topology = mesh.topology();
        let edges = topology.edges().filter_map(|edge| {
            let [a, b] = topology.edge_vertices(edge);
            let (before, image) = (
                mesh.edge_vector(edge),
                self.positions[b] - self.positions[a],
            );
            let direction = before.try_normalize(0.0)?;
            let along = image.dot(&direction);
            let across = (image - direction * along).norm();
            (across > TURNED * largest).then_some(TurnedEdge {
                edge,
                length: before.norm(),
                along,
                across,
            })
        });
        edges.collect()
    }
}

/// An edge of a mesh that turns when the mesh is offset.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TurnedEdge {
    /// The edge.
    pub edge: EdgeId,
    /// Its length in the mesh, in model units.
    pub length: f64,
    /// Part of its image along its direction in the mesh, with a sign, on the unit sphere.
    pub along: f64,
    /// Part of its image across that direction, at least 0, on the unit sphere.
    pub across: f64,
}

impl TurnedEdge {
    /// How far it turns in the offset by `distance` (model units), in radians from 0 to pi.
    pub fn angle(&self, distance: f64) -> f64 {
        (distance * self.across)
            .abs()
            .atan2(self.length + distance * self.along)
    }
}
