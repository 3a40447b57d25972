//! The clipped `|II|` metric and the weight of alignment.

use super::DirectionOptions;
pub(crate) use crate::curvature::large_curvature;
use crate::curvature::{Curvature, Principal, tangent_frame};
use nalgebra::Matrix3;
use phex_mesh::{PerVertex, TriangleSurface, Vec3};

/// Curvatures below one over this many bounding-box diagonals are flat whatever the surface looks
/// like.
const FLAT_RADIUS: f64 = 1e3;
/// Ratio of the principal curvatures, times the square of the anisotropy, below which rows must
/// follow the smaller one.
pub(super) const COMPULSORY: f64 = 0.8;
/// Curvature below which a surface counts as flat, over the 90 % quantile of `|k2|`.
const CURVATURE_FLOOR: f64 = 0.05;
/// Weight of the alignment where rows need not follow the smaller curvature.
const GENTLE_ALIGNMENT: f64 = 0.3;
/// Passes of smoothing over one-rings.
const SMOOTHING: usize = 4;

/// Metric tensors with unit determinant over `panel_length^2`.
pub(crate) fn metric(
    surface: &TriangleSurface,
    curvature: &Curvature,
    principal: &PerVertex<Principal>,
    panel_length: &PerVertex<f64>,
    options: &DirectionOptions,
) -> PerVertex<Matrix3<f64>> {
    let floor = CURVATURE_FLOOR * large_curvature(principal) + 1.0 / FLAT_RADIUS;
    let raw = principal.map(|p| shape(p, floor, options.anisotropy));
    let smooth = crate::curvature::smoothed(surface.topology(), &curvature.normal, raw, SMOOTHING);
    PerVertex::from_fn(smooth.len(), |v| {
        smooth[v] / (panel_length[v].powi(2) * determinant_root(curvature.normal[v], &smooth[v]))
    })
}

fn shape(p: &Principal, floor: f64, anisotropy: f64) -> Matrix3<f64> {
    let across = p.large.hypot(floor);
    let along = p.small.hypot(floor).max(across / (anisotropy * anisotropy));
    let ratio = (along / across).sqrt();
    let outer = |d: Vec3| d * d.transpose();
    outer(p.small_direction) * ratio + outer(p.large_direction) / ratio
}

fn determinant_root(n: Vec3, m: &Matrix3<f64>) -> f64 {
    let [e1, e2] = tangent_frame(n);
    let (a, b, d) = (e1.dot(&(m * e1)), e1.dot(&(m * e2)), e2.dot(&(m * e2)));
    (a * d - b * b).max(1e-12).sqrt()
}

/// Weight of alignment with the direction of smaller curvature: compulsory near parabolic curves,
/// gentle elsewhere, none where the surface is flat or two radii disagree about its curvature.
pub(crate) fn alignment_weight(
    principal: &PerVertex<Principal>,
    curvature: &Curvature,
    options: &DirectionOptions,
) -> PerVertex<f64> {
    let large = large_curvature(principal).max(10.0 / FLAT_RADIUS);
    PerVertex::from_fn(principal.len(), |v| {
        let p = &principal[v];
        let k2 = p.large.abs();
        let ratio = p.small.abs() / k2.max(1e-12);
        let clipped = ratio * options.anisotropy * options.anisotropy;
        let t = ((COMPULSORY - clipped) / 0.6).clamp(0.0, 1.0);
        let curved = k2 * k2 / (k2 * k2 + (0.1 * large).powi(2));
        let weight =
            options.alignment * t * t * (3.0 - 2.0 * t) + GENTLE_ALIGNMENT * (1.0 - ratio).powi(2);
        weight * curved * curvature.confidence.as_slice()[v.index()]
    })
}
