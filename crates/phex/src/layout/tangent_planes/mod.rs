//! Tangent planes: the panels lie in tangent planes at the points of any triangulation, the
//! vertices where three of them meet.
//!
//! To second order the vertex of a triangle of touching points is its circumcentre in the metric
//! `q = II` (Dupin duality), so a panel is simple where `super::forecast` says so. The lattice in
//! the metric `|II|` obeys it everywhere, but near parabolic curves so narrowly that small errors
//! break it.
//!
//! Raw, the result is planar to rounding. Regularised, vertices solve
//!
//! `min_x sum_i (n_i . (x - p_i))^2 + lambda^2 |x - c|^2`
//!
//! with `c` the mean of the touching points: simple and close to the surface where planes meet
//! badly, but planar only as far as `lambda` is small; planarity is left to the optimiser.
//!
//! | symbol | here |
//! |---|---|
//! | `p_i`, `n_i` | [`Layout::face_point`], [`Layout::face_normal`] |
//! | `lambda` | `regularisation`, over the middle singular value of the three normals (a pure number) |
//!
//! Source: the report on tangent duality that W. Wang and Y. Liu, "A note on planar hexagonal
//! meshes" (2010), section 5, refer to.

use super::Layout;
use crate::classical::duality::OrientedPlane;
use nalgebra::Matrix3;
use phex_mesh::{HexMesh, PerFace, PerVertex, Vec3, VertexId};

/// Name in messages.
pub(crate) const METHOD: &str = "tangent-planes";

/// The tangent planes of a layout's panels.
pub(crate) fn tangent_planes(layout: &Layout) -> PerFace<OrientedPlane> {
    let pairs = layout.face_point.iter().zip(&layout.face_normal);
    PerFace::from_vec(pairs.map(|(p, n)| OrientedPlane::through(*p, *n)).collect())
}

/// The layout's mesh with regularised meets inside; at the boundary vertices stay where the layout
/// has them.
pub(crate) fn regularised(layout: &Layout, regularisation: f64) -> HexMesh {
    let topology = layout.mesh.topology();
    let place = |v: VertexId| {
        if topology.is_boundary_vertex(v) {
            return layout.mesh.positions[v];
        }
        let faces = topology.faces_at(v);
        regularised_meet(
            faces.map(|f| (layout.face_point[f], layout.face_normal[f])),
            regularisation,
        )
    };
    let positions = PerVertex::from_fn(topology.n_vertices(), place);
    layout.mesh.with_positions(positions)
}

fn regularised_meet(planes: impl Iterator<Item = (Vec3, Vec3)>, regularisation: f64) -> Vec3 {
    let planes: Vec<(Vec3, Vec3)> = planes.collect();
    let centre = planes.iter().map(|p| p.0).sum::<Vec3>() / planes.len() as f64;
    let mut matrix = Matrix3::zeros();
    let mut rhs = Vec3::zeros();
    for (p, n) in &planes {
        matrix += n * n.transpose();
        rhs += n * n.dot(&(p - centre));
    }
    let mut squares = matrix.symmetric_eigenvalues();
    squares.as_mut_slice().sort_by(f64::total_cmp);
    let weight = regularisation.powi(2) * squares[1].max(f64::EPSILON);
    let solved = (matrix + Matrix3::from_diagonal_element(weight)).cholesky();
    centre + solved.map_or_else(Vec3::zeros, |c| c.solve(&rhs))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(tilt: f64) -> Vec<(Vec3, Vec3)> {
        // Touching points on z = -tilt |x|^2 / 2, whose planes meet on the axis at height tilt / 2.
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / 3.0;
        let point = |k: usize| Vec3::new(angle(k).cos(), angle(k).sin(), -0.5 * tilt);
        let normal =
            |k: usize| Vec3::new(tilt * angle(k).cos(), tilt * angle(k).sin(), 1.0).normalize();
        (0..3).map(|k| (point(k), normal(k))).collect()
    }

    #[test]
    fn without_regularisation_planes_meet_exactly() {
        let x = regularised_meet(corner(0.2).into_iter(), 1e-9);
        assert!((x - Vec3::new(0.0, 0.0, 0.1)).norm() < 1e-9, "{x:?}");
    }

    #[test]
    fn regularisation_holds_back_where_planes_meet_far_away() {
        // Nearly parallel to a line: the raw meet is far off.
        let planes = [
            (Vec3::zeros(), Vec3::new(0.0, 0.1, 1.0).normalize()),
            (Vec3::x(), Vec3::new(1e-4, -0.1, 1.0).normalize()),
            (Vec3::y(), Vec3::new(-1e-4, 0.1, 1.02).normalize()),
        ];
        let far = regularised_meet(planes.into_iter(), 1e-9).norm();
        let near = regularised_meet(planes.into_iter(), 0.3).norm();
        assert!(far > 10.0 && near < 2.0, "{far} {near}");
    }
}
