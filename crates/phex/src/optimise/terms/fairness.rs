//! Fairness: panels are drawn to central symmetry.
//!
//! `w/2 sum_a |x_a + x_(a+m) - M|^2` for a `2m`-gon, `M` the mean of the `m` sums: the main
//! diagonals share a midpoint. Every Dupin hexagon satisfies this, convex or concave, which no
//! averaging of neighbours does. A panel of odd valence has no such symmetry and is left alone:
//! what is affine-regular there is convex, and wrong where the surface is a saddle.

use crate::optimise::panels::{Corner, add_block};
use nalgebra::Matrix3;
use phex_mesh::Vec3;

/// `x_a + x_(a+m) - M`.
fn defect(corners: &[Corner], mean: Vec3, a: usize) -> Vec3 {
    let m = corners.len() / 2;
    corners[a].position + corners[a + m].position - mean
}

/// Mean of the sums of opposite corners.
fn mean_sum(corners: &[Corner]) -> Vec3 {
    let m = (corners.len() / 2) as f64;
    corners.iter().map(|c| c.position).sum::<Vec3>() / m
}

fn applies(corners: &[Corner]) -> bool {
    corners.len().is_multiple_of(2)
}

/// Energy of a face.
pub(in crate::optimise) fn energy(corners: &[Corner], weight: f64) -> f64 {
    if !applies(corners) {
        return 0.0;
    }
    let mean = mean_sum(corners);
    let defects = (0..corners.len() / 2).map(|a| defect(corners, mean, a).norm_squared());
    0.5 * weight * defects.sum::<f64>()
}

/// Adds gradient and Hessian block of a face, both exact.
pub(in crate::optimise) fn add(
    corners: &[Corner],
    weight: f64,
    gradient: &mut [Vec3],
    block: &mut [f64],
) {
    if !applies(corners) {
        return;
    }
    let m = corners.len() / 2;
    let mean = mean_sum(corners);
    let other = -weight / m as f64;
    for (i, force) in gradient.iter_mut().enumerate() {
        *force += defect(corners, mean, i % m) * weight;
        for j in 0..=i {
            let value = if i % m == j % m {
                weight + other
            } else {
                other
            };
            add_block(block, i, j, &Matrix3::from_diagonal_element(value));
        }
    }
}
