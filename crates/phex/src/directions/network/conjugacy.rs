//! How conjugate the curves of a network are.
//!
//! `|II(a, b)| / |II|` with unit tangents `a, b` of the two curves through a point and `|II| =
//! max(|k1|, |k2|)`: 0 where they are conjugate, 1 at most. Curves follow their field in the sense
//! of least squares, so this is not 0, and largest where the field turns quickly. Not defined where
//! the surface is flat: there any two curves are conjugate.

use super::function::Function;
use crate::curvature::{Curvature, principal};
use nalgebra::Matrix3;
use phex_mesh::{FaceId, TriangleSurface, Vec3};

/// Largest principal curvature below which a surface is flat, over its bounding box's diagonal.
const FLAT: f64 = 1e-6;

/// `|II(a, b)| / |II|` over the area of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conjugacy {
    /// Half of the area has less.
    pub median: f64,
    /// 95 % of the area have less.
    pub p95: f64,
    /// The largest of all.
    pub worst: f64,
    /// Where that is, in the surface's coordinates.
    pub place: Vec3,
}

/// Measures the level lines of two functions; nothing where the surface is flat everywhere.
pub(crate) fn conjugacy(
    surface: &TriangleSurface,
    curvature: &Curvature,
    functions: [&Function; 2],
) -> Option<Conjugacy> {
    let least = FLAT / surface.diagonal();
    let faces = surface.topology().faces();
    let measured =
        faces.filter_map(|f| Some((defect(surface, curvature, functions, f, least)?, f)));
    let mut all: Vec<(f64, FaceId)> = measured.collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let area = |f: FaceId| surface.area_vector(f).norm();
    let total: f64 = all.iter().map(|(_, f)| area(*f)).sum();
    let quantile = |share: f64| {
        let mut sum = 0.0;
        let reached = all.iter().find(|(_, f)| {
            sum += area(*f);
            sum >= share * total
        });
        reached.map(|(defect, _)| *defect)
    };
    let &(worst, face) = all.last()?;
    Some(Conjugacy {
        median: quantile(0.5)?,
        p95: quantile(0.95)?,
        worst,
        place: surface.centroid(face),
    })
}

/// `|II(a, b)| / |II|` in a triangle.
fn defect(
    surface: &TriangleSurface,
    curvature: &Curvature,
    functions: [&Function; 2],
    f: FaceId,
    least: f64,
) -> Option<f64> {
    let vertices = surface.topology().face_vertices(f);
    let tensor: Matrix3<f64> = vertices.iter().map(|v| curvature.tensor[*v] / 3.0).sum();
    let normal: Vec3 = vertices.iter().map(|v| curvature.normal[*v]).sum();
    let large = principal(normal.try_normalize(0.0)?, &tensor).large.abs();
    let [a, b] = functions.map(|function| tangent(surface, function, f));
    (large > least).then_some(())?;
    Some((a?.dot(&(tensor * b?)) / large).abs())
}

/// Unit tangent of a function's level lines in a triangle: its gradient is `n x t` up to a factor.
fn tangent(surface: &TriangleSurface, function: &Function, f: FaceId) -> Option<Vec3> {
    let values = function.corners(surface.topology(), f);
    let p = surface.corners(f);
    let along = (0..3).map(|k| values[k] * (p[(k + 2) % 3] - p[(k + 1) % 3]));
    along.sum::<Vec3>().try_normalize(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::{CurvatureOptions, curvature};
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
    use phex_mesh::{PerEdge, PerVertex};

    /// The function `m . p` on a surface.
    fn linear(surface: &TriangleSurface, m: Vec3) -> Function {
        let value = PerVertex::from_fn(surface.positions().len(), |v| {
            surface.positions()[v].dot(&m)
        });
        let topology = surface.topology();
        let change = PerEdge::from_fn(topology.n_edges(), |e| {
            let [i, j] = topology.edge_vertices(e);
            value[j] - value[i]
        });
        Function { value, change }
    }

    #[test]
    fn curves_along_the_axes_of_a_paraboloid_are_conjugate_at_its_top_and_diagonals_are_not() {
        // On z = -(x^2 + y^2 / 4): the curves x = constant and y = constant are conjugate
        // everywhere.
        let shape = Shape::from_name("elliptic-paraboloid", &[("a", 1.0), ("b", 2.0)]).unwrap();
        let options = TriangulationOptions {
            triangles: 3000,
            ..Default::default()
        };
        let surface = triangulate(&shape, &options).unwrap();
        let curvature = curvature(&surface, 0.15, &CurvatureOptions::default());
        let measure = |a: Vec3, b: Vec3| {
            let functions = [linear(&surface, a), linear(&surface, b)];
            conjugacy(&surface, &curvature, [&functions[0], &functions[1]]).unwrap()
        };
        let axes = measure(Vec3::x(), Vec3::y());
        assert!(axes.median < 0.01 && axes.p95 < 0.05, "{axes:?}");
        assert!(axes.median <= axes.p95 && axes.p95 <= axes.worst && axes.worst <= 1.0);
        let diagonals = measure(Vec3::x() + Vec3::y(), Vec3::x() - Vec3::y());
        assert!(diagonals.median > 0.2, "{diagonals:?}");
    }
}
