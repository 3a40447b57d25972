//! Polarity with respect to a quadric.

use super::{DualityError, OrientedPlane};
use nalgebra::{Matrix4, Vector4};
use phex_mesh::{FaceId, Vec3};

/// Poles whose last coordinate is below this share of the others are at infinity.
const AT_INFINITY: f64 = 1e-12;

/// A quadric `X^T Q^-1 X = 0` in homogeneous coordinates; its polarity maps planes to points by
/// `Q`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadric {
    matrix: Matrix4<f64>,
    inverse: Matrix4<f64>,
}

impl Quadric {
    /// The quadric of a symmetric matrix (the symmetric part is taken).
    ///
    /// # Errors
    /// If the matrix has no inverse or is not finite.
    pub fn new(matrix: Matrix4<f64>) -> Result<Self, DualityError> {
        let matrix = (matrix + matrix.transpose()) * 0.5;
        let inverse = matrix
            .try_inverse()
            .filter(|m| m.iter().all(|x| x.is_finite()));
        let inverse = inverse.ok_or(DualityError::SingularQuadric)?;
        Ok(Self { matrix, inverse })
    }

    /// The quadric of a symmetric matrix by its upper triangle, row by row.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn from_upper(upper: [f64; 10]) -> Result<Self, DualityError> {
        let [a, b, c, d, e, f, g, h, i, j] = upper;
        Self::new(Matrix4::new(a, b, c, d, b, e, f, g, c, f, h, i, d, g, i, j))
    }

    /// The upper triangle of the matrix, row by row.
    pub fn upper(&self) -> [f64; 10] {
        let m = &self.matrix;
        let at = [
            (0, 0),
            (0, 1),
            (0, 2),
            (0, 3),
            (1, 1),
            (1, 2),
            (1, 3),
            (2, 2),
            (2, 3),
            (3, 3),
        ];
        at.map(|i| m[i])
    }

    /// The image under `p -> (p - centre) / scale`: poles of moved planes are moved poles.
    ///
    /// # Errors
    /// If the image is singular by rounding.
    pub fn normalised(&self, centre: Vec3, scale: f64) -> Result<Self, DualityError> {
        let mut map = Matrix4::from_diagonal_element(1.0 / scale);
        map.fixed_view_mut::<3, 1>(0, 3)
            .copy_from(&(-centre / scale));
        map[(3, 3)] = 1.0;
        Self::new(map * self.matrix * map.transpose())
    }

    /// The sphere with a centre and a radius in model units: the plane `n . x = h` gets the pole
    /// `c + r^2 n / (h - n . c)`.
    ///
    /// # Errors
    /// If the radius is 0, or a number is not finite.
    pub fn sphere(centre: Vec3, radius: f64) -> Result<Self, DualityError> {
        let mut shift = Matrix4::identity();
        shift.fixed_view_mut::<3, 1>(0, 3).copy_from(&centre);
        let sphere = Matrix4::from_diagonal(&Vector4::new(1.0, 1.0, 1.0, -1.0 / (radius * radius)));
        Self::new(shift * sphere * shift.transpose())
    }

    /// The matrix `Q`.
    pub fn matrix(&self) -> &Matrix4<f64> {
        &self.matrix
    }

    /// The centre, pole of the plane at infinity; `None` if that is at infinity too, as for a
    /// paraboloid.
    pub fn centre(&self) -> Option<Vec3> {
        let x = self.matrix.column(3).into_owned();
        let scale = x.xyz().amax();
        (x.w.abs() > AT_INFINITY * scale && x.w != 0.0).then(|| x.xyz() / x.w)
    }

    /// The pole of a plane; `None` if it is at infinity.
    pub fn pole(&self, plane: &OrientedPlane) -> Option<Vec3> {
        let n = plane.normal;
        let x = self.matrix * Vector4::new(n.x, n.y, n.z, -plane.offset);
        let scale = x.xyz().amax();
        (x.w.abs() > AT_INFINITY * scale && x.w.is_finite()).then(|| x.xyz() / x.w)
    }

    /// The pole of the plane of a face.
    ///
    /// # Errors
    /// If it is at infinity.
    pub(crate) fn pole_of(
        &self,
        face: FaceId,
        plane: &OrientedPlane,
    ) -> Result<Vec3, DualityError> {
        self.pole(plane)
            .ok_or(DualityError::PoleAtInfinity { face })
    }

    /// The polar plane of a point; `None` if it is the plane at infinity (that of the quadric's
    /// centre).
    pub fn polar(&self, point: Vec3) -> Option<OrientedPlane> {
        let p = self.inverse * point.push(1.0);
        let length = p.xyz().norm();
        (length > AT_INFINITY * p.w.abs() && length.is_finite()).then(|| OrientedPlane {
            normal: p.xyz() / length,
            offset: -p.w / length,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn unit_sphere_inverts_distances() {
        let sphere = Quadric::sphere(Vec3::zeros(), 1.0).unwrap();
        let n = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        let pole = sphere
            .pole(&OrientedPlane {
                normal: n,
                offset: 0.25,
            })
            .unwrap();
        assert!((pole - n * 4.0).norm() < 1e-14);
        assert_eq!(
            sphere.pole(&OrientedPlane {
                normal: n,
                offset: 0.0
            }),
            None
        );
        assert_eq!(sphere.polar(Vec3::zeros()), None);
    }

    #[test]
    fn matrices_that_define_no_polarity_are_refused() {
        for matrix in [
            Matrix4::zeros(),
            Matrix4::repeat(1.0),
            Matrix4::repeat(f64::NAN),
        ] {
            assert_eq!(Quadric::new(matrix), Err(DualityError::SingularQuadric));
        }
        assert!(Quadric::sphere(Vec3::zeros(), 0.0).is_err());
    }

    #[test]
    fn a_normalised_quadric_has_the_normalised_poles() {
        let upper = [1.0, 0.2, -0.1, 0.1, 2.0, 0.3, -0.05, 1.5, 0.02, -1.2];
        let quadric = Quadric::from_upper(upper).unwrap();
        assert_eq!(quadric.upper(), upper);
        let (centre, scale) = (Vec3::new(3.0, -1.0, 0.5), 4.0);
        let there = |p: Vec3| (p - centre) / scale;
        let point = Vec3::new(0.7, -0.2, 1.9);
        let normal = Vec3::new(2.0, -1.0, 2.0) / 3.0;
        let pole = quadric
            .pole(&OrientedPlane::through(point, normal))
            .unwrap();
        let moved = quadric.normalised(centre, scale).unwrap();
        let pole_there = moved
            .pole(&OrientedPlane::through(there(point), normal))
            .unwrap();
        assert!((there(pole) - pole_there).norm() < 1e-13);
    }

    proptest! {
        /// Pole and polar undo each other for any regular symmetric matrix, and incidence is kept.
        #[test]
        fn polarity_is_an_involution(
            diagonal in prop::array::uniform4(prop_oneof![-2.0..-0.5, 0.5..2.0f64]),
            off in prop::array::uniform6(-0.1..0.1f64),
            point in prop::array::uniform3(-3.0..3.0f64),
        ) {
            let [a, b, c, d, e, f] = off;
            let upper = Matrix4::new(
                0.0, a, b, c,
                0.0, 0.0, d, e,
                0.0, 0.0, 0.0, f,
                0.0, 0.0, 0.0, 0.0,
            );
            let matrix = Matrix4::from_diagonal(&Vector4::from(diagonal)) + upper + upper.transpose();
            let quadric = Quadric::new(matrix).unwrap();
            let point = Vec3::from(point);
            if let Some(polar) = quadric.polar(point)
                && let Some(back) = quadric.pole(&polar)
            {
                let size = 1.0 + point.norm() + back.norm();
                prop_assert!((back - point).norm() < 1e-9 * size * size);
            }
        }
    }
}
