//! Creases of a triangle mesh.
//!
//! Facets of a curved surface turn alike from one to the next, however large they are. An edge is a
//! crease where triangles meet at a sharp angle, and where they turn by several times as much as
//! they do at all edges beside it, as where a cone runs into a plane face.

use phex_mesh::{EdgeId, PerEdge, PerFace, TriangleSurface};

/// Turn between triangles, degrees, from which on their common edge is a crease: more than facets
/// of a round with twelve of them turn, and less than chamfers of boxes do.
const SHARP: f64 = 35.0;
/// The same for edges that turn by several times as much as those beside them.
const BLUNT: f64 = 12.0;
/// These times.
const TIMES: f64 = 3.0;

/// Which edges are creases; those of the boundary are none.
pub(super) fn creases(surface: &TriangleSurface) -> PerEdge<bool> {
    let topology = surface.topology();
    let area = PerFace::from_fn(topology.n_faces(), |f| surface.area_vector(f));
    let turn = PerEdge::from_fn(topology.n_edges(), |e| {
        let beside = topology.faces_beside(e);
        beside.map_or(0.0, |[f, g]| area[f].angle(&area[g]).to_degrees())
    });
    let blunter = |e: EdgeId| {
        let faces = topology.edge_faces(e);
        let sides = faces.flat_map(|f| topology.face_half_edges(f));
        let others = sides.map(|h| topology.edge(h)).filter(|k| *k != e);
        let turns = others.map(|k| turn[k]).filter(|t| *t <= SHARP);
        turns.fold(0.0, f64::max)
    };
    PerEdge::from_fn(topology.n_edges(), |e| {
        turn[e] > SHARP || turn[e] > BLUNT && turn[e] > TIMES * blunter(e)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    /// Strips along x, each turned by so many degrees to the one before.
    fn strips(turns: &[f64]) -> TriangleSurface {
        let (mut places, mut angle, mut at) = (Vec::new(), 0.0_f64, Vec3::zeros());
        for turn in std::iter::once(&0.0).chain(turns).chain(&[0.0]) {
            places.extend([at, at + Vec3::x()]);
            angle += turn.to_radians();
            at += Vec3::new(0.0, angle.cos(), angle.sin());
        }
        let cells = (0..turns.len() as u32 + 1).map(|i| 2 * i);
        let triangles = cells.flat_map(|a| [[a, a + 1, a + 3], [a, a + 3, a + 2]]);
        TriangleSurface::new(places, &triangles.collect::<Vec<_>>()).unwrap()
    }

    fn found(turns: &[f64]) -> usize {
        let surface = strips(turns);
        creases(&surface).iter().filter(|c| **c).count()
    }

    #[test]
    fn what_turns_alike_is_smooth_and_what_turns_more_a_crease() {
        assert_eq!(found(&[40.0, 40.0, 40.0]), 3);
        assert_eq!(found(&[30.0, 30.0, 30.0]), 0);
        assert_eq!(found(&[5.0, 5.0, 30.0, 0.0, 0.0]), 1);
        assert_eq!(found(&[5.0, 5.0, 10.0, 0.0, 0.0]), 0);
        // Two strips of a chamfer, between plane faces.
        assert_eq!(found(&[0.0, 30.0, 30.0, 0.0]), 0);
    }
}
