//! Planes, and where they meet.

use nalgebra::{Matrix3, Vector3};
use phex_mesh::{FaceId, FacePlane, HexMesh, Vec3};

/// Three planes whose normals span less than this volume are taken to be parallel to a line.
const LEAST_VOLUME: f64 = 1e-14;
/// Steps of iterative refinement: the first removes the error of the elimination, the second that
/// of the first.
const REFINEMENTS: usize = 3;

/// The plane `normal . x = offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedPlane {
    /// Unit normal.
    pub normal: Vec3,
    /// Signed distance from the origin, in the unit of the coordinates.
    pub offset: f64,
}

impl OrientedPlane {
    /// The plane through a point with a unit normal.
    pub fn through(point: Vec3, normal: Vec3) -> Self {
        Self {
            normal,
            offset: normal.dot(&point),
        }
    }

    /// The best plane of a face's corners.
    pub(crate) fn of(mesh: &HexMesh, face: FaceId) -> Self {
        let fitted = FacePlane::of(mesh, face);
        Self::through(fitted.centre, fitted.normal)
    }

    /// Signed distance of a point, positive on the side of the normal.
    pub fn height(&self, p: Vec3) -> f64 {
        self.normal.dot(&p) - self.offset
    }
}

/// The point of up to three planes that is closest to `near`; `None` where they have no common
/// point, or no unique one of three.
///
/// # Panics
/// If there are no planes or more than three.
pub(crate) fn meet(planes: &[OrientedPlane], near: Vec3) -> Option<Vec3> {
    let mut x = near;
    for _ in 0..REFINEMENTS {
        x += step(planes, x)?;
    }
    x.iter().all(|c| c.is_finite()).then_some(x)
}

/// The shortest way from a point to the planes.
fn step(planes: &[OrientedPlane], x: Vec3) -> Option<Vec3> {
    match planes {
        [p] => Some(p.normal * -p.height(x)),
        [p, q] => to_line(p, q, x),
        [p, q, r] => {
            let rows = [p, q, r].map(|p| p.normal.transpose());
            let matrix = Matrix3::from_rows(&rows);
            if matrix.determinant().abs() < LEAST_VOLUME {
                return None;
            }
            matrix
                .full_piv_lu()
                .solve(&Vector3::new(-p.height(x), -q.height(x), -r.height(x)))
        }
        _ => panic!("one to three planes"),
    }
}

/// Sum and difference of two unit normals are perpendicular, so that the two components can be
/// found one by one.
fn to_line(p: &OrientedPlane, q: &OrientedPlane, x: Vec3) -> Option<Vec3> {
    let (a, b) = (p.height(x), q.height(x));
    let (sum, difference) = (p.normal + q.normal, p.normal - q.normal);
    let along = |direction: Vec3, height: f64| direction * (-height / direction.norm_squared());
    if difference.norm() < LEAST_VOLUME || sum.norm() < LEAST_VOLUME {
        // One plane given twice is no contradiction.
        let same = if sum.norm() > difference.norm() {
            a - b
        } else {
            a + b
        };
        return (same.abs() < LEAST_VOLUME).then(|| p.normal * -a);
    }
    Some(along(sum, a + b) + along(difference, a - b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(x: f64, y: f64, z: f64, offset: f64) -> OrientedPlane {
        let n = Vec3::new(x, y, z);
        OrientedPlane {
            normal: n.normalize(),
            offset: offset / n.norm(),
        }
    }

    #[test]
    fn planes_meet_where_each_of_them_is() {
        let planes = [
            plane(1.0, 0.2, 0.1, 1.0),
            plane(0.1, 1.0, -0.3, 0.5),
            plane(0.2, 0.3, 1.0, -2.0),
        ];
        let near = Vec3::new(0.3, -0.8, 0.4);
        for count in 1..=3 {
            let x = meet(&planes[..count], near).unwrap();
            for p in &planes[..count] {
                assert!(p.height(x).abs() < 1e-15, "{count} planes");
            }
            // The shortest way lies in the span of the normals.
            if count == 2 {
                let along = planes[0].normal.cross(&planes[1].normal);
                assert!((x - near).dot(&along).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn nearly_parallel_planes_are_still_met() {
        let tilt = 1e-5;
        let planes = [
            plane(tilt, 0.0, 1.0, 0.0),
            plane(0.0, tilt, 1.0, 0.0),
            plane(-tilt, -tilt, 1.0, tilt * tilt),
        ];
        let x = meet(&planes, Vec3::new(0.1, 0.1, 0.0)).unwrap();
        assert!(planes.iter().all(|p| p.height(x).abs() < 1e-17), "{x:?}");
    }

    #[test]
    fn parallel_planes_have_no_meet() {
        let z = |offset| plane(0.0, 0.0, 1.0, offset);
        assert_eq!(meet(&[z(0.0), z(1.0)], Vec3::zeros()), None);
        assert_eq!(
            meet(
                &[z(0.0), plane(1.0, 0.0, 0.0, 0.0), plane(1.0, 0.0, 1.0, 0.0)],
                Vec3::zeros()
            ),
            None
        );
        assert!(meet(&[z(0.5), z(0.5)], Vec3::zeros()).is_some());
    }
}
