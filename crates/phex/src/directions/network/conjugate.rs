//! Pairs of conjugate directions.

use crate::curvature::tangent_frame;
use nalgebra::Matrix3;
use phex_mesh::Vec3;

/// Largest tangent of the angle by which a direction is turned to become conjugate: the pair stays transversal where
/// rows run along an asymptotic direction, which is conjugate to itself.
const MAX_TURN: f64 = 0.5;

/// The unit pair `(row, column)` nearest to `(row, normal x row)` with `II(row, column) = 0`.
///
/// With `a, b, d` the second fundamental form in the given frame, `row + alpha column` and `column + beta row` are
/// conjugate to first order for `beta a + alpha d = -b`; the solution of least norm is taken. Forms below `flat`, in
/// 1 / length, count as none.
pub fn nearest_pair(normal: Vec3, form: &Matrix3<f64>, row: Vec3, flat: f64) -> [Vec3; 2] {
    let mut pair = [row, normal.cross(&row)];
    for _ in 0..3 {
        let [a, b, d] = coefficients(form, pair);
        let size = a * a + d * d + flat * flat;
        let turn = |t: f64| t.clamp(-MAX_TURN, MAX_TURN);
        let (alpha, beta) = (turn(-b * d / size), turn(-b * a / size));
        let [r, s] = pair;
        let turned = [(r + s * alpha).normalize(), (s + r * beta).normalize()];
        if turned[0].cross(&turned[1]).dot(&normal) < MAX_TURN {
            break;
        }
        pair = turned;
    }
    pair
}

/// The unit direction conjugate to `column`, on its right, within `atan` of [`MAX_TURN`] of the perpendicular.
pub fn conjugate_row(normal: Vec3, form: &Matrix3<f64>, column: Vec3, flat: f64) -> Vec3 {
    let right = column.cross(&normal);
    let [_, b, d] = coefficients(form, [right, column]);
    let alpha = (-b * d / (d * d + flat * flat)).clamp(-MAX_TURN, MAX_TURN);
    (right + column * alpha).normalize()
}

fn coefficients(form: &Matrix3<f64>, [r, s]: [Vec3; 2]) -> [f64; 3] {
    [r.dot(&(form * r)), r.dot(&(form * s)), s.dot(&(form * s))]
}

/// The projection of a direction of space to the tangent plane: a unit vector and the length of the projection.
pub fn projected(normal: Vec3, axis: Vec3) -> (Vec3, f64) {
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
        fn the_pair_is_conjugate_wherever_it_is_not_held_back(
            k1 in 0.2..2.0f64, k2 in -2.0..2.0f64, turn in -0.2..0.2f64,
        ) {
            let (sin, cos) = turn.sin_cos();
            let tensor = form(
                k1 * cos * cos + k2 * sin * sin,
                (k1 - k2) * sin * cos,
                k1 * sin * sin + k2 * cos * cos,
            );
            let [r, s] = nearest_pair(Vec3::z(), &tensor, Vec3::x(), 1e-9);
            prop_assert!(r.dot(&(tensor * s)).abs() < 1e-3);
            prop_assert!(r.cross(&s).z > 0.4);
        }
    }

    #[test]
    fn principal_directions_stay_and_asymptotic_ones_stay_transversal() {
        let [r, s] = nearest_pair(Vec3::z(), &form(0.0, 0.0, 3.0), Vec3::x(), 1e-6);
        assert!((r - Vec3::x()).norm() + (s - Vec3::y()).norm() < 1e-15);
        let [r, s] = nearest_pair(Vec3::z(), &form(0.0, 1.0, 0.0), Vec3::x(), 1e-6);
        assert!(r.cross(&s).z >= 0.5);
    }

    #[test]
    fn rows_are_conjugate_to_the_given_columns() {
        let tensor = form(0.4, 0.3, 2.0);
        let r = conjugate_row(Vec3::z(), &tensor, Vec3::y(), 1e-9);
        assert!(r.dot(&(tensor * Vec3::y())).abs() < 1e-12 && r.x > 0.0);
    }
}
