//! How large and how small coordinates may be.

use crate::Vec3;
use std::ops::RangeInclusive;

/// Largest coordinate that is computed with, in any unit: fourth powers of lengths must not
/// overflow.
pub const LARGEST_COORDINATE: f64 = 1e50;

/// Bounds of the largest coordinate and of the bounding box's longest side: fourth powers must
/// neither over- nor underflow.
const EXTENT: RangeInclusive<f64> = 1e-50..=LARGEST_COORDINATE;

/// The largest coordinate of points, which are finite.
///
/// # Errors
/// The longest side of their bounding box, or else their largest coordinate, if it is outside
/// [`EXTENT`].
pub(crate) fn largest_coordinate<'a>(points: impl Iterator<Item = &'a Vec3>) -> Result<f64, f64> {
    let none = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    let [low, high] = points.fold(none, |[low, high], p| [low.inf(p), high.sup(p)]);
    let (size, largest) = ((high - low).amax(), low.amax().max(high.amax()));
    let outside = |extent: &f64| !EXTENT.contains(extent);
    match [size, largest].into_iter().find(outside) {
        Some(extent) => Err(extent),
        None => Ok(largest),
    }
}
