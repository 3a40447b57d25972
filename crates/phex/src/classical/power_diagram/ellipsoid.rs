//! Whether a surface is an ellipsoid, or a piece of one.

use crate::classical::domain::{DomainError, LocatedVertex};
use nalgebra::{DMatrix, Matrix3, Matrix4, SMatrix, SVector, SymmetricEigen, Vector4};
use phex_mesh::{TriangleSurface, Vec3, VertexId};

/// Name in messages.
const METHOD: &str = "power-diagram";
/// Largest distance of a vertex to the ellipsoid, over the diagonal of the surface's bounding box.
const TOLERANCE: f64 = 2e-3;
/// Longest over shortest axis beyond which a surface counts as no ellipsoid: a cylinder or
/// paraboloid, up to rounding.
const MAX_AXIS_RATIO: f64 = 100.0;

/// An ellipsoid `|A^-1 (p - c)| = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ellipsoid {
    /// Centre `c`.
    pub centre: Vec3,
    /// `A`, symmetric: the affine map that takes the unit sphere to the ellipsoid about the origin.
    pub shape: Matrix3<f64>,
}

impl Ellipsoid {
    /// The image of a point of the unit sphere.
    pub fn place(&self, unit: Vec3) -> Vec3 {
        self.centre + self.shape * unit
    }

    /// Distance of a point to the ellipsoid: to first order, or towards the centre if that is less.
    pub fn distance(&self, p: Vec3) -> f64 {
        let Some(inverse) = self.shape.try_inverse() else {
            return f64::INFINITY;
        };
        let from_centre = p - self.centre;
        let unit = inverse * from_centre;
        let gradient = inverse * unit * 2.0;
        let level = unit.norm();
        if level < f64::EPSILON {
            return self.shape.norm();
        }
        let radial = from_centre.norm() * (1.0 - level.recip()).abs();
        radial.min((level * level - 1.0).abs() / gradient.norm())
    }
}

/// The ellipsoid that a surface is, or is a piece of: the quadric that fits its vertices in the
/// sense of least squares (Taubin 1991).
///
/// # Errors
/// If the quadric is no ellipsoid, or a vertex lies off it.
pub(crate) fn fit_ellipsoid(surface: &TriangleSurface) -> Result<Ellipsoid, DomainError> {
    let place = |vertex| LocatedVertex::of(surface, vertex);
    let farthest = |e: &Ellipsoid| {
        let distance = |v: VertexId| e.distance(surface.positions()[v]) / surface.diagonal();
        let vertices = surface.topology().vertices().map(|v| (distance(v), v));
        let farthest = vertices.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        farthest.map_or((0.0, place(VertexId::new(0))), |(d, v)| (d, place(v)))
    };
    let points = surface.positions().as_slice();
    let found = quadric(points).ok_or("not determined");
    let ellipsoid = found.and_then(|c| canonical(&c)).map_err(|found| {
        let (distance, place) = farthest(&sphere(points));
        DomainError::OtherQuadric {
            method: METHOD,
            found,
            place,
            distance,
        }
    })?;
    match farthest(&ellipsoid) {
        (distance, place) if distance > TOLERANCE => Err(DomainError::NotAnEllipsoid {
            method: METHOD,
            place,
            distance,
        }),
        _ => Ok(ellipsoid),
    }
}

/// The sphere that fits points best: `2 c . p + d = |p|^2` in the sense of least squares.
fn sphere(points: &[Vec3]) -> Ellipsoid {
    let middle = points.iter().sum::<Vec3>() / points.len().max(1) as f64;
    let (mut matrix, mut rhs) = (Matrix4::zeros(), Vector4::zeros());
    for p in points.iter().map(|p| p - middle) {
        let row = (2.0 * p).push(1.0);
        matrix += row * row.transpose();
        rhs += row * p.norm_squared();
    }
    // Points in a plane leave the height of the centre open: the least one is taken.
    let least = 1e-12 * matrix.norm();
    let solved = matrix.svd(true, true).solve(&rhs, least);
    let solved = solved.unwrap_or_default();
    let centre = solved.xyz();
    let radius = (solved.w + centre.norm_squared()).max(0.0).sqrt();
    Ellipsoid {
        centre: middle + centre,
        shape: Matrix3::identity() * radius,
    }
}

type Coefficients = SVector<f64, 10>;

/// Monomials of the general quadric.
fn monomials(p: Vec3) -> Coefficients {
    let (x, y, z) = (p.x, p.y, p.z);
    Coefficients::from([
        x * x,
        y * y,
        z * z,
        2.0 * y * z,
        2.0 * x * z,
        2.0 * x * y,
        2.0 * x,
        2.0 * y,
        2.0 * z,
        1.0,
    ])
}

/// Their derivatives.
fn gradients(p: Vec3) -> SMatrix<f64, 10, 3> {
    let (x, y, z) = (p.x, p.y, p.z);
    let rows = [
        [x, 0.0, 0.0],
        [0.0, y, 0.0],
        [0.0, 0.0, z],
        [0.0, z, y],
        [z, 0.0, x],
        [y, x, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0; 3],
    ];
    SMatrix::from_fn(|i, j| 2.0 * rows[i][j])
}

/// Coefficients that minimise `sum f^2 / sum |grad f|^2`, the generalised eigenvector of the least
/// eigenvalue.
fn quadric(points: &[Vec3]) -> Option<Coefficients> {
    let mut value = SMatrix::<f64, 10, 10>::zeros();
    let mut slope = SMatrix::<f64, 10, 10>::zeros();
    for &p in points {
        let (m, g) = (monomials(p), gradients(p));
        value += m * m.transpose();
        slope += g * g.transpose();
    }
    // The constant has no slope: it is eliminated, f = g - mean(g).
    let count = value[(9, 9)];
    let mean = value.fixed_view::<9, 1>(0, 9) / count;
    let reduced = value.fixed_view::<9, 9>(0, 0) - mean * mean.transpose() * count;
    let slope = slope.fixed_view::<9, 9>(0, 0).into_owned();
    let slope = slope + SMatrix::identity() * (1e-12 * slope.trace());
    let factor = slope.cholesky()?.l();
    let inverse = factor.try_inverse()?;
    let symmetric = inverse * reduced * inverse.transpose();
    let eigen = SymmetricEigen::new(DMatrix::from_iterator(9, 9, symmetric.iter().copied()));
    let least = eigen.eigenvalues.imin();
    let whitened =
        SVector::<f64, 9>::from_iterator(eigen.eigenvectors.column(least).iter().copied());
    let first = inverse.transpose() * whitened;
    let constant = -mean.dot(&first);
    Some(Coefficients::from_fn(|i, _| {
        if i < 9 { first[i] } else { constant }
    }))
}

/// Centre and shape of a quadric, or what it is instead of an ellipsoid.
fn canonical(c: &Coefficients) -> Result<Ellipsoid, &'static str> {
    let matrix = Matrix3::new(c[0], c[5], c[4], c[5], c[1], c[3], c[4], c[3], c[2]);
    let linear = Vec3::new(c[6], c[7], c[8]);
    let eigen = SymmetricEigen::new(matrix);
    let (low, high) = (eigen.eigenvalues.amin(), eigen.eigenvalues.amax());
    if low * MAX_AXIS_RATIO * MAX_AXIS_RATIO < high {
        return Err("a plane, a cylinder or a paraboloid");
    }
    let centre = -matrix.try_inverse().ok_or("not determined")? * linear;
    let level = -(c[9] + linear.dot(&centre));
    let squares = eigen.eigenvalues.map(|e| level / e);
    match squares.iter().filter(|s| **s > 0.0).count() {
        3 => {}
        2 => return Err("a hyperboloid of one sheet or a cone"),
        1 => return Err("a hyperboloid of two sheets or a cone"),
        _ => return Err("imaginary"),
    }
    let axes = Matrix3::from_diagonal(&squares.map(f64::sqrt));
    let shape = eigen.eigenvectors * axes * eigen.eigenvectors.transpose();
    Ok(Ellipsoid { centre, shape })
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn surface(name: &str) -> TriangleSurface {
        let options = TriangulationOptions {
            triangles: 1000,
            jitter: 0.2,
            ..Default::default()
        };
        triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap()
    }

    #[test]
    fn axes_and_place_of_a_moved_ellipsoid() {
        let turn = nalgebra::Rotation3::from_euler_angles(0.4, 1.1, -0.3);
        let (shift, surface) = (Vec3::new(3.0, -2.0, 0.5), surface("ellipsoid"));
        let moved = surface.mapped(|p| turn * p + shift);
        let found = fit_ellipsoid(&moved).unwrap();
        assert!((found.centre - shift).norm() < 1e-9);
        let expected = turn.matrix()
            * Matrix3::from_diagonal(&Vec3::new(1.5, 1.0, 0.7))
            * turn.matrix().transpose();
        assert!((found.shape - expected).norm() < 1e-9, "{}", found.shape);
    }

    #[test]
    fn other_surfaces_are_told_from_ellipsoids() {
        let error = |name| fit_ellipsoid(&surface(name)).unwrap_err().to_string();
        assert!(
            error("hyperboloid").contains("one sheet"),
            "{}",
            error("hyperboloid")
        );
        assert!(error("elliptic-paraboloid").contains("paraboloid"));
        assert!(error("torus").contains("off the ellipsoid") || error("torus").contains("quadric"));
        assert!(fit_ellipsoid(&surface("sphere")).is_ok());
        // The place is where the surface is farthest from being a sphere: at the waist of a tower.
        let tower = surface("hyperboloid");
        let Err(DomainError::OtherQuadric { place, .. }) = fit_ellipsoid(&tower) else {
            panic!("a hyperboloid is no ellipsoid");
        };
        assert_eq!(place.position, tower.positions()[place.vertex]);
        let sphere = Ellipsoid {
            centre: Vec3::x(),
            shape: Matrix3::identity() * 2.0,
        };
        for (x, distance) in [(1.01, 1.99), (3.5, 0.5), (-0.5, 0.5)] {
            let found = sphere.distance(Vec3::new(x, 0.0, 0.0));
            assert!(
                found <= distance + 1e-12 && found > 0.5 * distance,
                "{found}"
            );
        }
        assert!(place.position.z.abs() < 0.1, "{place}");
    }
}
