//! Edges turn where that makes triangles Delaunay.

use super::ChangingMesh;
use super::corner_table::{next, prev};

/// What the sum of the cotangents opposite to an edge must fall below for the edge to turn, so that
/// rounding never turns it back and forth.
const DELAUNAY: f64 = -1e-6;
/// Cosine of the angle between triangles above which their common edge may turn.
const FLAT: f64 = 0.9;
/// Turns of each edge at the most: in space the process need not end.
const TURNS: usize = 8;

/// Turns edges until the mesh is Delaunay where it is flat enough.
pub(super) fn turn_edges(mesh: &mut ChangingMesh) {
    let mut stack: Vec<u32> = mesh.table.edges().collect();
    let mut most = TURNS * stack.len();
    while let Some(h) = stack.pop() {
        if most == 0 || !mesh.table.is_there(h) || !wants_to_turn(mesh, h) {
            continue;
        }
        most -= 1;
        let t = mesh.table.twin(h);
        mesh.table.flip(h);
        let sides = [Some(h), t].into_iter().flatten();
        stack.extend(sides.flat_map(|s| [next(s), prev(s)]));
    }
}

fn wants_to_turn(mesh: &ChangingMesh, h: u32) -> bool {
    let Some([a, b]) = mesh.table.apexes(h) else {
        return false;
    };
    let [u, v] = mesh.table.ends(h);
    !mesh.table.is_crease(h)
        && cotangent(mesh, [a, u, v]) + cotangent(mesh, [b, v, u]) < DELAUNAY
        && is_flat(mesh, [u, v, a, b])
        && [u, v].iter().all(|w| mesh.table.neighbours(*w).count() > 3)
        && mesh.table.neighbours(a).all(|w| w != b)
}

/// Cotangent of the first angle of a triangle.
fn cotangent(mesh: &ChangingMesh, [a, b, c]: [u32; 3]) -> f64 {
    let (p, q) = (mesh.place(b) - mesh.place(a), mesh.place(c) - mesh.place(a));
    p.dot(&q) / p.cross(&q).norm().max(f64::MIN_POSITIVE)
}

/// Whether the triangles on either side, and those after the turn, lie nearly in one plane.
fn is_flat(mesh: &ChangingMesh, [u, v, a, b]: [u32; 4]) -> bool {
    let triangles = [[u, v, a], [v, u, b], [a, b, v], [b, a, u]];
    let [first, second, third, fourth] = triangles.map(|t| mesh.area_vector(t));
    let same = |m: phex_mesh::Vec3, n: phex_mesh::Vec3| m.dot(&n) > FLAT * m.norm() * n.norm();
    let mean = first + second;
    same(first, second) && same(third, mean) && same(fourth, mean)
}
