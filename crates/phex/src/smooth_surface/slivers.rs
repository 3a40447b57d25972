//! Slivers along the boundary taken away.
//!
//! CAD programs span a straight edge of a face, however long, by triangles whose third vertices
//! lie next to it. Cut short they would be thousands of triangles without normals. Without them
//! their vertices are those of the boundary, which moves by their height.

use phex_mesh::{HalfEdgeId, PerFace, PerVertex, TriangleSurface, Vec3, VertexId};

/// Height of a sliver over its shorter side, at the most: the boundary turns by no more than about
/// twice that angle where it is taken away.
const FLAT: f64 = 0.1;
/// Distance from a mirror plane, diagonals, within which vertices of the boundary lie in it.
pub(crate) const IN_PLANE: f64 = 1e-7;

/// The surface without triangles that are lower than `height` over an edge of the boundary, as long
/// as there are any; vertices stay, with their numbers. Edges in one of the `mirrors`, each a point
/// of a plane and its unit normal, stay on the boundary. `None` where there are no slivers.
pub(super) fn without_slivers(
    surface: &TriangleSurface,
    height: f64,
    mirrors: &[[Vec3; 2]],
) -> Option<TriangleSurface> {
    let topology = surface.topology();
    let near = IN_PLANE * surface.diagonal();
    let is_sliver = |corners: [VertexId; 3]| {
        let [a, b, c] = corners.map(|v| surface.positions()[v]);
        let lies_in = |[o, n]: &[Vec3; 2]| [a, b].iter().all(|p| n.dot(&(p - o)).abs() <= near);
        let (along, [from_a, from_b]) = (b - a, [c - a, c - b]);
        let is_above = from_a.dot(&along) > 0.0 && from_b.dot(&along) < 0.0;
        let shorter = from_a.norm().min(from_b.norm());
        let low = height.min(FLAT * shorter);
        let is_low = along.cross(&from_a).norm() < low * along.norm();
        is_above && is_low && !mirrors.iter().any(lies_in)
    };
    let mut is_left = PerFace::filled(topology.n_faces(), true);
    let mut faces_at = PerVertex::from_fn(topology.n_vertices(), |v| topology.face_degree(v));
    let mut is_outer =
        PerVertex::from_fn(topology.n_vertices(), |v| topology.is_boundary_vertex(v));
    let mut open: Vec<HalfEdgeId> = topology.half_edges().collect();
    open.retain(|h| topology.twin(*h).is_none());
    while let Some(h) = open.pop() {
        let corners = [h, topology.next(h), topology.prev(h)].map(|h| topology.origin(h));
        let [a, b, c] = corners;
        if is_outer[c] || faces_at[a] < 2 || faces_at[b] < 2 || !is_sliver(corners) {
            continue;
        }
        corners.into_iter().for_each(|v| faces_at[v] -= 1);
        (is_left[topology.face(h)], is_outer[c]) = (false, true);
        let sides = [topology.next(h), topology.prev(h)];
        open.extend(sides.into_iter().filter_map(|h| topology.twin(h)));
    }
    if is_left.iter().all(|is_left| *is_left) {
        return None;
    }
    let left = topology.faces().filter(|f| is_left[*f]);
    let faces: Vec<[u32; 3]> = left.map(|f| surface.triangle(f)).collect();
    TriangleSurface::new(surface.positions().as_slice().to_vec(), &faces).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of side 8 with vertices of these heights over its lower edge, which is an edge of
    /// one triangle alone.
    fn square(heights: &[f64]) -> TriangleSurface {
        let n = heights.len() as u32;
        let step = 8.0 / f64::from(n + 1);
        let low = (1..)
            .zip(heights)
            .map(|(i, h)| Vec3::new(step * f64::from(i), *h, 0.0));
        let corners = [[0.0, 0.0], [8.0, 0.0], [8.0, 8.0], [0.0, 8.0]];
        let corners = corners.map(|[x, y]| Vec3::new(x, y, 0.0));
        let places = corners.into_iter().chain(low).collect();
        let mut faces = vec![[0, 1, 4], [0, 4, 3], [n + 3, 1, 2], [n + 3, 2, 3]];
        for i in 4..n + 3 {
            faces.extend([[i, 1, i + 1], [i, i + 1, 3]]);
        }
        TriangleSurface::new(places, &faces).unwrap()
    }

    #[test]
    fn a_fan_of_slivers_goes_vertex_by_vertex() {
        let surface = square(&[0.01, 0.02, 0.03, 0.02]);
        let calm = without_slivers(&surface, 0.1, &[]).unwrap();
        let topology = calm.topology();
        assert_eq!(topology.n_vertices(), surface.topology().n_vertices());
        assert_eq!(topology.n_faces(), surface.topology().n_faces() - 4);
        assert_eq!(topology.euler_characteristic(), 1);
        assert!(topology.vertices().all(|v| topology.is_boundary_vertex(v)));
        assert!((calm.area() - surface.area()).abs() < 0.2);
    }

    #[test]
    fn what_is_high_or_in_a_mirror_plane_stays() {
        assert!(without_slivers(&square(&[0.2, 0.2]), 0.1, &[]).is_none());
        let plane = [Vec3::zeros(), Vec3::y()];
        assert!(without_slivers(&square(&[0.01, 0.01]), 0.1, &[plane]).is_none());
    }
}
