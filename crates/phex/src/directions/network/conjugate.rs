//! Pairs of conjugate directions.

use crate::curvature::tangent_frame;
use nalgebra::Matrix3;
use phex_mesh::Vec3;

/// Largest tangent of the angle by which a row is turned to become conjugate to a given column.
const MAX_TURN: f64 = 0.5;

/// How much an asymptotic direction, which is conjugate to itself, resists being turned: pairs stay
/// transversal.
const ASYMPTOTIC: f64 = 0.3;

/// A unit pair `(row, column)` near `(row, normal x row)` with `II(row, column) = 0`, but for
/// directions that are nearly asymptotic.
///
/// With `a, b, d` the second fundamental form in the given frame, `row + alpha column` and
/// `column + beta row` are conjugate to first order for `beta a + alpha d = -b`; the solution of
/// least norm is taken, three times. Forms below `flat`, in 1 / length, count as none.
pub(crate) fn nearest_pair(normal: Vec3, form: &Matrix3<f64>, row: Vec3, flat: f64) -> [Vec3; 2] {
    let mut pair = [row, normal.cross(&row)];
    let [_, b0, _] = coefficients(form, pair);
    for _ in 0..3 {
        let [a, b, d] = coefficients(form, pair);
        let size = a * a + d * d + ASYMPTOTIC * b0 * b0 + flat * flat;
        if size == 0.0 {
            break;
        }
        let [r, s] = pair;
        pair = [
            (r - s * (b * d / size)).normalize(),
            (s - r * (b * a / size)).normalize(),
        ];
    }
    pair
}

/// The unit direction conjugate to `column`, on its right, within `atan` of `MAX_TURN` of the
/// perpendicular.
pub(crate) fn conjugate_row(normal: Vec3, form: &Matrix3<f64>, column: Vec3, flat: f64) -> Vec3 {
    let right = column.cross(&normal);
    let [_, b, d] = coefficients(form, [right, column]);
    let size = d * d + flat * flat;
    let alpha = if size > 0.0 { -b * d / size } else { 0.0 };
    let alpha = alpha.clamp(-MAX_TURN, MAX_TURN);
    (right + column * alpha).normalize()
}

fn coefficients(form: &Matrix3<f64>, [r, s]: [Vec3; 2]) -> [f64; 3] {
    [r.dot(&(form * r)), r.dot(&(form * s)), s.dot(&(form * s))]
}

/// The projection of a direction of space to the tangent plane: a unit vector and the length of the
/// projection.
pub(crate) fn projected(normal: Vec3, axis: Vec3) -> (Vec3, f64) {
    let tangent = axis - normal * axis.dot(&normal);
    let length = tangent.norm();
    match tangent.try_normalize(1e-9) {
        Some(unit) => (unit, length),
        None => (tangent_frame(normal)[0], 0.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn form(a: f64, b: f64, d: f64) -> Matrix3<f64> {
        Matrix3::new(a, b, 0.0, b, d, 0.0, 0.0, 0.0, 0.0)
    }

    proptest! {
        #[test]
        fn the_pair_is_nearer_to_conjugate_and_transversal(
            k1 in -2.0..2.0f64, k2 in -2.0..2.0f64, turn in -1.6..1.6f64,
        ) {
            let (sin, cos) = turn.sin_cos();
            let tensor = form(
                k1 * cos * cos + k2 * sin * sin,
                (k1 - k2) * sin * cos,
                k1 * sin * sin + k2 * cos * cos,
            );
            let [r, s] = nearest_pair(Vec3::z(), &tensor, Vec3::x(), 1e-9);
            let (before, after) = (tensor[(0, 1)].abs(), r.dot(&(tensor * s)).abs());
            // Near the asymptotic directions of a saddle no conjugate pair is transversal: there
            // only that is kept.
            prop_assert!(k1 * k2 < 0.0 || after <= before + 1e-12);
            if k1 * k2 > 0.1 && turn.abs() < 0.3 {
                prop_assert!(after < 0.2 * before + 1e-12, "{} {}", before, after);
            }
            prop_assert!(r.cross(&s).z > 0.2);
        }
    }

    #[test]
    fn principal_directions_stay_and_asymptotic_ones_stay_transversal() {
        let [r, s] = nearest_pair(Vec3::z(), &form(0.0, 0.0, 3.0), Vec3::x(), 1e-6);
        assert!((r - Vec3::x()).norm() + (s - Vec3::y()).norm() < 1e-15);
        let [r, s] = nearest_pair(Vec3::z(), &form(0.0, 1.0, 0.0), Vec3::x(), 1e-6);
        assert!(r.cross(&s).z >= 0.9);
    }

    #[test]
    fn rows_are_conjugate_to_the_given_columns() {
        let tensor = form(0.4, 0.3, 2.0);
        let r = conjugate_row(Vec3::z(), &tensor, Vec3::y(), 1e-9);
        assert!(r.dot(&(tensor * Vec3::y())).abs() < 1e-12 && r.x > 0.0);
    }
}
