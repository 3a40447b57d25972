//! Creases of a triangle mesh.

use phex_mesh::{PerEdge, PerFace, TriangleSurface};

/// Cosine of the angle between triangles from which on their common edge is a crease: 35 degrees,
/// more than facets of a round with twelve of them turn, and less than chamfers of boxes do.
const CREASE: f64 = 0.82;

/// Which edges are creases, at which triangles meet at a sharp angle; those of the boundary are
/// none.
pub(super) fn creases(surface: &TriangleSurface) -> PerEdge<bool> {
    let topology = surface.topology();
    let area = PerFace::from_fn(topology.n_faces(), |f| surface.area_vector(f));
    PerEdge::from_fn(topology.n_edges(), |e| {
        topology.faces_beside(e).is_some_and(|beside| {
            let [m, n] = beside.map(|f| area[f]);
            m.dot(&n) < CREASE * m.norm() * n.norm()
        })
    })
}
