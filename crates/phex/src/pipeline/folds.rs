//! The last resort against folds: panels are turned, or edges cut off.

use super::judge::{Left, between_panels, inner_deviation, invalid_panels};
use crate::optimise::{Fault, Offender};
use crate::trim::{Boundary, folds};
use phex_mesh::{TriangleSurface, Violation};

/// What the repair loop has left, with fewer folds, and the number of panels that are still wrong. `None` where there
/// would be as many as before, `invalid`.
pub(super) fn unfolded(
    left: &Left,
    [surface, beyond]: [&TriangleSurface; 2],
    boundary: Boundary,
    invalid: usize,
) -> Option<(Left, usize)> {
    let is_fold = |v: &Violation| matches!(v, Violation::Fold { .. });
    if !left.violations.iter().any(is_fold) {
        return None;
    }
    let trimmed = folds::without_folds(&left.trimmed, Some(surface))?;
    let violations = between_panels(&trimmed.mesh, surface);
    // Folds that are still there are among the violations; panels keep their numbers.
    let other = |o: &&Offender| !matches!(o.fault, Fault::Folded { .. });
    let offenders: Vec<Offender> = left.offenders.iter().filter(other).copied().collect();
    let wrong = invalid_panels(&offenders, &trimmed, &violations, boundary).len();
    let deviation = phex_mesh::deviation_beyond(&trimmed.mesh, surface, beyond);
    let better = Left {
        start: left.start.clone(),
        deviation: inner_deviation(&deviation),
        trimmed,
        offenders,
        violations,
    };
    (wrong < invalid).then_some((better, wrong))
}
