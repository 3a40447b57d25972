//! Tangential tensors: frames, smoothing, principal values.

use nalgebra::{Matrix2, Matrix3, SymmetricEigen, UnitQuaternion};
use phex_mesh::{PerVertex, Topology, Vec3};
use std::f64::consts::PI;

/// Two unit tangents that make a right-handed frame with the unit normal `n`.
pub fn tangent_frame(n: Vec3) -> [Vec3; 2] {
    let axis = if n.x.abs() < 0.8 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let e1 = (axis - n * axis.dot(&n)).normalize();
    [e1, n.cross(&e1)]
}

/// The rotation that brings a direction to the north pole: half a turn from the south pole.
pub(crate) fn turn_to_pole(direction: &Vec3) -> UnitQuaternion<f64> {
    let half_turn = || UnitQuaternion::from_axis_angle(&Vec3::x_axis(), PI);
    UnitQuaternion::rotation_between(direction, &Vec3::z()).unwrap_or_else(half_turn)
}

/// Averages tensors over one-rings (half own value, half the neighbours') and projects them to the
/// tangent planes.
pub fn smoothed(
    topology: &Topology,
    normal: &PerVertex<Vec3>,
    tensor: PerVertex<Matrix3<f64>>,
    passes: usize,
) -> PerVertex<Matrix3<f64>> {
    let rings: Vec<Vec<_>> = topology
        .vertices()
        .map(|v| topology.neighbours(v))
        .collect();
    let mut current = tensor;
    for _ in 0..passes {
        current = PerVertex::from_fn(current.len(), |v| {
            let ring = &rings[phex_mesh::ElementId::index(v)];
            let mean = ring.iter().map(|&w| current[w]).sum::<Matrix3<f64>>() / ring.len() as f64;
            tangential(normal[v], &(current[v] * 0.5 + mean * 0.5))
        });
    }
    current
}

/// `P S P` with the projector `P = 1 - n n^T`.
pub(super) fn tangential(n: Vec3, s: &Matrix3<f64>) -> Matrix3<f64> {
    let p = Matrix3::identity() - n * n.transpose();
    p * s * p
}

/// Principal curvatures, ordered by absolute value, with unit directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principal {
    /// Curvature of smaller absolute value, 1 / length.
    pub small: f64,
    /// Curvature of larger absolute value, 1 / length.
    pub large: f64,
    /// Unit tangent of the smaller one.
    pub small_direction: Vec3,
    /// Unit tangent of the larger one.
    pub large_direction: Vec3,
}

/// Principal values of a tangential tensor at a point with unit normal `n`.
pub fn principal(n: Vec3, s: &Matrix3<f64>) -> Principal {
    let [e1, e2] = tangent_frame(n);
    let form = Matrix2::new(
        e1.dot(&(s * e1)),
        e1.dot(&(s * e2)),
        e1.dot(&(s * e2)),
        e2.dot(&(s * e2)),
    );
    let eigen = SymmetricEigen::new(form);
    let (i, j) = if eigen.eigenvalues[0].abs() <= eigen.eigenvalues[1].abs() {
        (0, 1)
    } else {
        (1, 0)
    };
    let direction = |k: usize| e1 * eigen.eigenvectors[(0, k)] + e2 * eigen.eigenvectors[(1, k)];
    Principal {
        small: eigen.eigenvalues[i],
        large: eigen.eigenvalues[j],
        small_direction: direction(i),
        large_direction: direction(j),
    }
}

/// The 90 % quantile of the larger principal curvature.
pub fn large_curvature(principal: &PerVertex<Principal>) -> f64 {
    let mut values: Vec<f64> = principal.iter().map(|p| p.large.abs()).collect();
    values.sort_by(f64::total_cmp);
    values[(values.len() * 9 / 10).min(values.len() - 1)]
}
