//! How large and how small coordinates may be.

use crate::Vec3;
use nalgebra::SVector;
use std::ops::RangeInclusive;

/// Largest coordinate that is computed with, in any unit: fourth powers of lengths must not
/// overflow.
pub const LARGEST_COORDINATE: f64 = 1e50;

/// Bounds of the largest coordinate and of the bounding box's longest side: fourth powers must
/// neither over- nor underflow.
const EXTENT: RangeInclusive<f64> = 1e-50..=LARGEST_COORDINATE;

/// Least and largest coordinates of points, model units; infinite of none.
pub fn bounds<'a, const D: usize>(
    points: impl IntoIterator<Item = &'a SVector<f64, D>>,
) -> [SVector<f64, D>; 2] {
    let none = [f64::INFINITY, f64::NEG_INFINITY].map(SVector::repeat);
    let points = points.into_iter();
    points.fold(none, |[low, high], p| [low.inf(p), high.sup(p)])
}

/// The largest coordinate of points, which are finite.
///
/// # Errors
/// The longest side of their bounding box, or else their largest coordinate, if it is outside
/// [`EXTENT`].
pub(crate) fn largest_coordinate<'a>(points: impl Iterator<Item = &'a Vec3>) -> Result<f64, f64> {
    let [low, high] = bounds(points);
    let (size, largest) = ((high - low).amax(), low.amax().max(high.amax()));
    let outside = |extent: &f64| !EXTENT.contains(extent);
    match [size, largest].into_iter().find(outside) {
        Some(extent) => Err(extent),
        None => Ok(largest),
    }
}
