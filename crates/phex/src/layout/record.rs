//! What the layout hands to the optimiser.

use crate::classical::duality::Flipped;
use phex_mesh::{FaceId, HexMesh, PerFace, PerVertex, Vec3, VertexId};
use serde::{Deserialize, Serialize};

/// Where a vertex of the panelling lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum VertexKind {
    /// Three panels meet.
    Interior,
    /// On the boundary curve of the surface, between two panels (or, without a neighbour, on the
    /// rim of one).
    Boundary,
    /// At a sharp corner of the boundary: one panel, two boundary edges. It is drawn to that
    /// corner.
    BoundaryCorner,
}

impl VertexKind {
    /// Kinds of vertices as far as the mesh alone tells: it has no corners.
    pub(crate) fn of_mesh(mesh: &HexMesh) -> PerVertex<Self> {
        let topology = mesh.topology();
        PerVertex::from_fn(topology.n_vertices(), |v| {
            match topology.is_boundary_vertex(v) {
                true => Self::Boundary,
                false => Self::Interior,
            }
        })
    }
}

/// Size and shape that a panel is to have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PanelWish {
    /// Area, in any unit: only the proportions between panels count.
    pub area: f64,
    /// How much it counts, 0 (any area will do) to 1.
    pub share: f64,
    /// Length over width at the most ([`phex_mesh::measure::aspect`]), > 1; infinite for any.
    pub aspect: f64,
}

impl PanelWish {
    /// Any area and shape.
    pub const ANY: Self = Self {
        area: 1.0,
        share: 0.0,
        aspect: f64::INFINITY,
    };
}

/// A panelling before optimisation. Lengths are those of the normalised model (bounding-box
/// diagonal 1).
#[derive(Clone, Debug)]
pub struct Layout {
    /// Connectivity (interior vertices of degree 3) and positions of the raw cells.
    pub mesh: HexMesh,
    /// Kind of each vertex.
    pub vertex_kind: PerVertex<VertexKind>,
    /// Point of the surface at the middle of each panel's cell.
    pub face_point: PerFace<Vec3>,
    /// Unit surface normal there: the only global guard against flipped panels.
    pub face_normal: PerFace<Vec3>,
    /// Local panel length (distance of neighbouring panel centres).
    pub face_length: PerFace<f64>,
    /// Area and shape of each panel as the field of sizes and the metric ask for them, whatever the
    /// lattice could give it.
    pub face_wish: PerFace<PanelWish>,
    /// Vertex of the refined surface that each cell grew from: panels have the wishes there.
    pub face_seed: PerFace<VertexId>,
}

impl Layout {
    /// A mesh as a layout whose panels may have any area, and grew from no seed: the points of the
    /// surface at their middles are given with its normals there.
    pub(crate) fn new(
        mesh: HexMesh,
        vertex_kind: PerVertex<VertexKind>,
        feet: impl Iterator<Item = (Vec3, Vec3)>,
        face_length: PerFace<f64>,
    ) -> Self {
        let (points, normals) = feet.unzip();
        let n_faces = mesh.topology().n_faces();
        Self {
            mesh,
            vertex_kind,
            face_point: PerFace::from_vec(points),
            face_normal: PerFace::from_vec(normals),
            face_length,
            face_wish: PerFace::filled(n_faces, PanelWish::ANY),
            face_seed: PerFace::filled(n_faces, VertexId::new(0)),
        }
    }

    /// The layout with its panels joined otherwise; vertices of its mesh are where they are in that
    /// one.
    pub fn joined(&self, flipped: &Flipped) -> Self {
        self.part(flipped.mesh.clone(), &flipped.vertices, &flipped.faces)
    }

    /// The layout of a mesh that has some of its vertices and faces, in the order in which they are
    /// named.
    pub(super) fn part(&self, mesh: HexMesh, vertices: &[VertexId], faces: &[FaceId]) -> Self {
        Self {
            mesh,
            vertex_kind: self.vertex_kind.picked(vertices),
            face_point: self.face_point.picked(faces),
            face_normal: self.face_normal.picked(faces),
            face_length: self.face_length.picked(faces),
            face_wish: self.face_wish.picked(faces),
            face_seed: self.face_seed.picked(faces),
        }
    }
}
