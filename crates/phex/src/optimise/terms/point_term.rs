//! What a term of the energy says of one point.

use nalgebra::Matrix3;
use phex_mesh::Vec3;

/// A gradient and a Hessian in one point's coordinates.
pub(in crate::optimise) struct PointTerm {
    pub gradient: Vec3,
    pub hessian: Matrix3<f64>,
}
