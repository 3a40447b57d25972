//! Edges that pass through faces they do not belong to.

use super::violation::{Violation, edge_faces};
use crate::clipped::{ClippedMesh, to_parry};
use crate::{EdgeId, FaceId, FlatFace, HexMesh, PerFace, Vec3};
use parry3d_f64::bounding_volume::Aabb;
use rayon::prelude::*;
use robust::{Coord3D, orient3d};

/// All crossings, by edge and then by face.
///
/// A face counts as its ear-clipped triangles. Triangles with a vertex of the edge, and all triangles of the edge's own
/// faces, are left out. Touching (an end on a face, an edge on an edge) is no crossing.
pub(super) fn crossings(mesh: &HexMesh, faces: &PerFace<FlatFace>) -> Vec<Violation> {
    let clipped = ClippedMesh::new(mesh, faces);
    let edges = 0..mesh.topology().n_edges() as u32;
    let found = edges
        .into_par_iter()
        .flat_map_iter(|e| edge_crossings(mesh, &clipped, EdgeId::new(e)));
    found.collect()
}

fn edge_crossings(mesh: &HexMesh, clipped: &ClippedMesh, edge: EdgeId) -> Vec<Violation> {
    let topology = mesh.topology();
    let vertices = topology.edge_vertices(edge);
    let own: Vec<FaceId> = edge_faces(topology, edge).collect();
    let [from, to] = vertices.map(|v| mesh.position(v));
    let bounds = Aabb::new(to_parry(from.inf(&to)), to_parry(from.sup(&to)));
    let numbers = vertices.map(|v| v.index() as u32);
    let crosses = |t: usize| {
        let corners = clipped.hierarchy.indices()[t];
        !own.contains(&clipped.owner[t])
            && !numbers.iter().any(|v| corners.contains(v))
            && passes_through(
                from,
                to,
                corners.map(|v| mesh.positions.as_slice()[v as usize]),
                clipped.diagonal[t],
            )
    };
    let candidates = clipped
        .hierarchy
        .bvh()
        .intersect_aabb(&bounds)
        .map(|t| t as usize);
    let mut crossed: Vec<FaceId> = candidates
        .filter(|&t| crosses(t))
        .map(|t| clipped.owner[t])
        .collect();
    crossed.sort();
    crossed.dedup();
    crossed
        .into_iter()
        .map(|face| Violation::Crossing {
            edge,
            vertices,
            face,
        })
        .collect()
}

/// Whether the open segment passes through the inside of a triangle (exact). Sides that are diagonals of the face
/// belong to its inside, but not their ends.
fn passes_through(from: Vec3, to: Vec3, triangle: [Vec3; 3], diagonal: [bool; 3]) -> bool {
    let [a, b, c] = triangle;
    let (below, above) = (volume(a, b, c, from), volume(a, b, c, to));
    if !((below > 0.0 && above < 0.0) || (below < 0.0 && above > 0.0)) {
        return false;
    }
    let sides = [
        volume(from, to, a, b),
        volume(from, to, b, c),
        volume(from, to, c, a),
    ];
    let on_border = (0..3).any(|k| sides[k] == 0.0 && !diagonal[k]);
    let zeros = sides.iter().filter(|&&s| s == 0.0).count();
    let one_way = sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0);
    one_way && zeros <= 1 && !on_border
}

/// Exact sign of the volume of a tetrahedron.
fn volume(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let coord = |p: Vec3| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    };
    orient3d(coord(a), coord(b), coord(c), coord(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn passes(from: [f64; 3], to: [f64; 3], diagonal: [bool; 3]) -> bool {
        passes_through(from.into(), to.into(), TRIANGLE.map(Vec3::from), diagonal)
    }

    #[test]
    fn inside_outside_and_one_side() {
        assert!(passes([1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [false; 3]));
        assert!(passes([1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [false; 3]));
        assert!(
            !passes([3.0, 3.0, 1.0], [3.0, 3.0, -1.0], [false; 3]),
            "beside"
        );
        assert!(
            !passes([1.0, 1.0, 1.0], [1.0, 1.0, 0.5], [false; 3]),
            "above"
        );
        assert!(
            !passes([1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [false; 3]),
            "touching with an end"
        );
        assert!(
            !passes([-1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [false; 3]),
            "in the plane"
        );
    }

    #[test]
    fn a_diagonal_is_inside_and_a_border_is_not() {
        let hypotenuse = ([2.0, 2.0, 1.0], [2.0, 2.0, -1.0]);
        assert!(!passes(hypotenuse.0, hypotenuse.1, [false; 3]));
        assert!(passes(hypotenuse.0, hypotenuse.1, [false, true, false]));
        assert!(
            !passes([4.0, 0.0, 1.0], [4.0, 0.0, -1.0], [true; 3]),
            "a vertex is never inside"
        );
    }
}
