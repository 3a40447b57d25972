//! Where vertices are held at the boundary.

use super::{MeshOptions, PipelineError};
use crate::optimise::{self, BoundaryHold, Optimised, SurfaceTarget};
use crate::progress::Progress;
use crate::smooth_surface::boundary_corners;
use crate::trim::Boundary;
use phex_mesh::{BoundaryCurve, HexMesh, TriangleSurface, Vec3};

/// Where vertices of the boundary are held.
pub(super) struct Rim {
    curves: BoundaryCurve,
    corners: Vec<Vec3>,
}

impl Rim {
    /// The boundary of a surface; `None` if it is closed.
    fn of(surface: &TriangleSurface, options: &MeshOptions) -> Option<Self> {
        Some(Self {
            curves: BoundaryCurve::of(surface)?,
            corners: corner_points(surface, options),
        })
    }

    /// The same where the mesh ends at the boundary, `None` also where panels stay whole.
    pub fn kept(surface: &TriangleSurface, options: &MeshOptions) -> Option<Self> {
        match options.boundary {
            Boundary::Whole => None,
            _ => Self::of(surface, options),
        }
    }

    pub fn hold(&self) -> BoundaryHold<'_> {
        BoundaryHold {
            curves: &self.curves,
            corners: &self.corners,
        }
    }
}

/// The mesh with vertices held as the user wants it, those on the boundary of `surface` staying
/// there where that can be.
pub(super) fn steered(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Optimised, PipelineError> {
    let target = SurfaceTarget::new(surface);
    let (steering, settings) = (&options.steering, &options.optimise);
    let held = match Rim::kept(surface, options) {
        None => optimise::steer(mesh, Some(&target), steering, settings, progress),
        Some(rim) => {
            let hold = rim.hold();
            optimise::steer_on_boundary(mesh, &target, steering, &hold, settings, progress)
        }
    };
    Ok(held?)
}

/// Sharp corners of the boundary.
pub(super) fn corner_points(surface: &TriangleSurface, options: &MeshOptions) -> Vec<Vec3> {
    let corners = boundary_corners(surface, options.target.corner_angle.to_radians());
    corners.iter().map(|v| surface.positions()[*v]).collect()
}
