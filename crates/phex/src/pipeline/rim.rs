//! The last steps at the boundary: vertices exactly on the boundary curve where panels allow it, and corners of panels where their
//! edges would cut the curve short.

use super::judge::{Left, between_panels, inner_deviation};
use super::{MeshOptions, PipelineError};
use crate::optimise::{self, BoundaryHold, Optimised, RunSummary, SurfaceTarget};
use crate::progress::Progress;
use crate::target::boundary_corners;
use crate::trim::{Boundary, follow};
use phex_mesh::{BoundaryCurve, HexMesh, TriangleSurface, Vec3, VertexId};

/// Brings a valid mesh to the boundary of `surface`; it is left as it was where that does harm. Told is the optimiser's run, if there
/// was one.
pub(super) fn to_boundary(
    left: &mut Left,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Option<RunSummary>, PipelineError> {
    let sound = left.offenders.is_empty() && left.violations.is_empty();
    if !sound || options.boundary == Boundary::Whole {
        return Ok(None);
    }
    let valid = |mesh: &HexMesh| between_panels(mesh, surface).is_empty();
    let held = on_curve(&left.trimmed.mesh, surface, options, progress)?;
    let held = held.filter(|h| valid(&h.mesh));
    let run = held.as_ref().and_then(|h| h.runs.first().cloned());
    if let Some(held) = held {
        left.trimmed.mesh = held.mesh;
    }
    let corner_angle = options.target.corner_angle.to_radians();
    let followed = follow::followed(&left.trimmed.mesh, surface, corner_angle);
    if let Some(mesh) = followed.filter(valid) {
        left.trimmed.mesh = mesh;
    }
    left.deviation = inner_deviation(&phex_mesh::deviation(&left.trimmed.mesh, surface));
    Ok(run)
}

/// A valid mesh with more room in tight panels; `None` where there is none to be had, or panels and surface would come to stand off
/// farther for it, or more panels at the boundary would be small.
pub(super) fn roomier(
    mesh: &HexMesh,
    [surface, beyond]: [&TriangleSurface; 2],
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, PipelineError> {
    let curves = match options.boundary {
        Boundary::Whole => None,
        _ => BoundaryCurve::of(surface),
    };
    let corners = corner_points(surface, options);
    let hold = curves.as_ref().map(|curves| BoundaryHold {
        curves,
        corners: &corners,
    });
    let (target, settings) = (SurfaceTarget::new(beyond), &options.optimise);
    let roomy = optimise::give_room(mesh, &target, hold.as_ref(), settings, progress)?;
    let off = |mesh: &HexMesh| {
        let deviation = phex_mesh::deviation_beyond(mesh, surface, beyond);
        [inner_deviation(&deviation), deviation.coverage_max]
    };
    Ok(roomy.filter(|roomy| {
        let (before, now) = (off(mesh), off(&roomy.mesh));
        let as_near = (0..2).all(|k| now[k] <= before[k]);
        let small = |mesh: &HexMesh| phex_mesh::small_rim_faces(mesh).len();
        let as_large = options.boundary == Boundary::Whole || small(&roomy.mesh) <= small(mesh);
        as_near && as_large && between_panels(&roomy.mesh, surface).is_empty()
    }))
}

/// Points of the boundary of `surface` that are farther than `limit` from the boundary of the mesh.
pub(super) fn bare_rim(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    limit: f64,
) -> Vec<(VertexId, f64)> {
    if options.boundary == Boundary::Whole {
        return Vec::new();
    }
    let followed = follow::followed(mesh, surface, options.target.corner_angle.to_radians());
    let mesh = followed.as_ref().unwrap_or(mesh);
    let place = |v: &VertexId| mesh.position(*v);
    let closed = |l: &Vec<VertexId>| l.iter().chain(l.first()).map(place).collect();
    let loops: Vec<Vec<Vec3>> = (mesh.topology().boundary_loops().iter())
        .map(closed)
        .collect();
    let Some(rim) = BoundaryCurve::of_polylines(&loops) else {
        return Vec::new();
    };
    let distance = |v: VertexId| {
        let p = surface.positions()[v];
        (rim.closest_point(p).position - p).norm()
    };
    let boundary = surface.boundary_loops().into_iter().flatten();
    let distances = boundary.map(|v| (v, distance(v)));
    distances.filter(|(_, d)| *d > limit).collect()
}

/// The mesh with vertices held as the user wants it, those on the boundary of `surface` staying there where that can be.
pub(super) fn steered(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Optimised, PipelineError> {
    let target = SurfaceTarget::new(surface);
    let (steering, settings) = (&options.steering, &options.optimise);
    let curves = match options.boundary {
        Boundary::Whole => None,
        _ => BoundaryCurve::of(surface),
    };
    let held = match curves {
        None => optimise::steer(mesh, Some(&target), steering, settings, progress),
        Some(curves) => {
            let corners = corner_points(surface, options);
            let hold = BoundaryHold {
                curves: &curves,
                corners: &corners,
            };
            optimise::steer_on_boundary(mesh, &target, steering, &hold, settings, progress)
        }
    };
    Ok(held?)
}

/// Sharp corners of the boundary.
fn corner_points(surface: &TriangleSurface, options: &MeshOptions) -> Vec<Vec3> {
    let corners = boundary_corners(surface, options.target.corner_angle.to_radians());
    corners.iter().map(|v| surface.positions()[*v]).collect()
}

/// The mesh with the ends of interior edges on the boundary, and vertices near its corners on these.
fn on_curve(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, PipelineError> {
    let Some(curves) = BoundaryCurve::of(surface) else {
        return Ok(None);
    };
    let corners = corner_points(surface, options);
    let hold = BoundaryHold {
        curves: &curves,
        corners: &corners,
    };
    let target = SurfaceTarget::new(surface);
    let held = optimise::onto_boundary(mesh, &target, &hold, &options.optimise, progress)?;
    Ok(held)
}
