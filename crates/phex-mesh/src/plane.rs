//! The plane of a face: total least squares, oriented by the face's winding.

use crate::polygon::sides;
use crate::{FaceId, HexMesh, Vec2, Vec3};
use nalgebra::{Matrix3, SymmetricEigen};

/// Least-squares plane of a polygon with an orthonormal frame in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacePlane {
    /// Mean of the corners.
    pub centre: Vec3,
    /// Unit normal; the corners run counter-clockwise round it (Newell).
    pub normal: Vec3,
    /// Orthonormal in-plane axes with `axes[0] x axes[1] = normal`; the first is the direction of
    /// largest extent.
    pub axes: [Vec3; 2],
}

impl FacePlane {
    /// Fits the plane that minimises the sum of squared distances of the corners (at least three).
    /// Where the corners determine no plane (all equal or collinear) some plane through them is
    /// returned.
    pub fn fit(corners: &[Vec3]) -> Self {
        let centre = corners.iter().sum::<Vec3>() / corners.len() as f64;
        let scale = corners
            .iter()
            .map(|p| (p - centre).amax())
            .fold(0.0, f64::max);
        let unit = if scale > 0.0 && scale.is_finite() {
            1.0 / scale
        } else {
            0.0
        };
        let mut covariance = Matrix3::zeros();
        let mut newell = Vec3::zeros();
        for side in sides(corners) {
            let [a, b] = side.map(|p| (p - centre) * unit);
            covariance += a * a.transpose();
            newell += a.cross(&b);
        }
        let eigen = SymmetricEigen::new(covariance);
        let (low, _, high) = ordered(eigen.eigenvalues);
        let normal = eigen.eigenvectors.column(low).into_owned();
        let normal = if normal.dot(&newell) < 0.0 {
            -normal
        } else {
            normal
        };
        let first = eigen.eigenvectors.column(high).into_owned();
        Self {
            centre,
            normal,
            axes: [first, normal.cross(&first)],
        }
    }

    /// The plane of a face's corners.
    pub fn of(mesh: &HexMesh, face: FaceId) -> Self {
        Self::fit(&mesh.corners(face).collect::<Vec<_>>())
    }

    /// In-plane coordinates of a point.
    pub fn project(&self, p: Vec3) -> Vec2 {
        self.project_vector(p - self.centre)
    }

    /// In-plane components of a vector.
    pub fn project_vector(&self, d: Vec3) -> Vec2 {
        Vec2::new(d.dot(&self.axes[0]), d.dot(&self.axes[1]))
    }

    /// Signed distance of a point, positive on the side of the normal.
    pub fn height(&self, p: Vec3) -> f64 {
        (p - self.centre).dot(&self.normal)
    }

    /// The point of space with given in-plane coordinates.
    pub fn lift(&self, q: Vec2) -> Vec3 {
        self.centre + self.axes[0] * q.x + self.axes[1] * q.y
    }
}

fn ordered(values: Vec3) -> (usize, usize, usize) {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    (order[0], order[1], order[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tilted_concave_polygon() {
        let flat = [
            [0.0, 0.0],
            [2.0, 0.0],
            [1.0, 0.4],
            [2.0, 1.0],
            [0.0, 1.0],
            [0.3, 0.5],
        ];
        let (u, v) = (
            Vec3::new(1.0, 2.0, 2.0) / 3.0,
            Vec3::new(2.0, 1.0, -2.0) / 3.0,
        );
        let corners: Vec<Vec3> = flat
            .iter()
            .map(|p| Vec3::new(5.0, -3.0, 7.0) + u * p[0] + v * p[1])
            .collect();
        let plane = FacePlane::fit(&corners);
        assert!((plane.normal - u.cross(&v)).norm() < 1e-14);
        assert!((plane.axes[0].cross(&plane.axes[1]) - plane.normal).norm() < 1e-14);
        for &p in &corners {
            assert!(plane.height(p).abs() < 1e-14);
            assert!((plane.lift(plane.project(p)) - p).norm() < 1e-14);
        }
    }

    #[test]
    fn degenerate_corners_give_finite_axes() {
        let plane = FacePlane::fit(&[Vec3::x(); 4]);
        assert!(
            plane.normal.iter().all(|x| x.is_finite()) && (plane.normal.norm() - 1.0).abs() < 1e-12
        );
    }
}
