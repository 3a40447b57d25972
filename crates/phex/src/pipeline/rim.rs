//! Where vertices are held at the boundary.

use super::{MeshOptions, PipelineError};
use crate::optimise::{self, BoundaryHold, Optimised, SurfaceTarget};
use crate::progress::Progress;
use crate::smooth_surface::boundary_corners;
use crate::trim::Boundary;
use phex_mesh::{BoundaryCurve, HexMesh, TriangleSurface, Vec3};
use std::collections::BTreeSet;

/// The boundary of a surface where a mesh ends at it; `None` if it is closed, or panels stay whole.
pub(super) fn held(surface: &TriangleSurface, options: &MeshOptions) -> Option<BoundaryHold> {
    let ends = options.boundary != Boundary::Whole;
    Some(BoundaryHold {
        curves: ends.then(|| BoundaryCurve::of(surface)).flatten()?,
        corners: corner_points(surface, options),
    })
}

/// The mesh with vertices held as the user wants it, without those that are `loose`, and those on
/// the boundary of `surface` staying there where that can be; with `rests` panels far from what is
/// held stay as they are.
pub(super) fn steered(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    (options, loose, rests): (&MeshOptions, &BTreeSet<u32>, bool),
    progress: &dyn Progress,
) -> Result<Optimised, PipelineError> {
    let target = SurfaceTarget::new(surface);
    let hold = held(surface, options);
    let what = (&options.steering, loose, rests);
    let settings = &options.optimise;
    let made = optimise::steer_on_boundary(mesh, &target, what, hold.as_ref(), settings, progress)?;
    Ok(made)
}

/// Sharp corners of the boundary.
pub(super) fn corner_points(surface: &TriangleSurface, options: &MeshOptions) -> Vec<Vec3> {
    let corners = boundary_corners(surface, options.target.corner_angle.to_radians());
    corners.iter().map(|v| surface.positions()[*v]).collect()
}
