//! The last steps at the boundary: vertices exactly on the boundary curve where panels allow it, and corners of panels where their
//! edges would cut the curve short.

use super::judge::{Left, between_panels, inner_deviation};
use super::{MeshOptions, PipelineError};
use crate::optimise::{self, BoundaryHold, Optimised, RunSummary, SurfaceTarget};
use crate::progress::Progress;
use crate::target::boundary_corners;
use crate::trim::{Boundary, follow};
use phex_mesh::{BoundaryCurve, HexMesh, TriangleSurface, Vec3, VertexId};

/// Brings a valid mesh to the boundary of `surface`, and makes small panels there larger; it is left as it was where that does harm. Told
/// are the optimiser's runs.
pub(super) fn to_boundary(
    left: &mut Left,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Vec<RunSummary>, PipelineError> {
    if !left.is_sound() || options.boundary == Boundary::Whole {
        return Ok(Vec::new());
    }
    let valid = |mesh: &HexMesh| between_panels(mesh, surface).is_empty();
    let mut runs = Vec::new();
    for step in [on_curve, enlarged] {
        let next = step(&left.trimmed.mesh, surface, options, progress)?;
        if let Some(next) = next.filter(|n| valid(&n.mesh)) {
            left.trimmed.mesh = next.mesh;
            runs.extend(next.runs.into_iter().take(1));
        }
    }
    let corner_angle = options.target.corner_angle.to_radians();
    let followed = follow::followed(&left.trimmed.mesh, surface, corner_angle);
    if let Some(mesh) = followed.filter(valid) {
        left.trimmed.mesh = mesh;
    }
    left.deviation = inner_deviation(&phex_mesh::deviation(&left.trimmed.mesh, surface));
    Ok(runs)
}

/// Where vertices of the boundary are held.
struct Rim {
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
    fn kept(surface: &TriangleSurface, options: &MeshOptions) -> Option<Self> {
        match options.boundary {
            Boundary::Whole => None,
            _ => Self::of(surface, options),
        }
    }

    fn hold(&self) -> BoundaryHold<'_> {
        BoundaryHold {
            curves: &self.curves,
            corners: &self.corners,
        }
    }
}

/// A mesh with larger panels at the boundary in place of small ones; `None` where none gets larger, or panels and surface would
/// come to stand off farther for it than is good.
pub(super) fn enlarged(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, PipelineError> {
    if phex_mesh::small_rim_faces(mesh).is_empty() {
        return Ok(None);
    }
    let Some(rim) = Rim::of(surface, options) else {
        return Ok(None);
    };
    let (target, settings) = (SurfaceTarget::new(surface), &options.optimise);
    let larger = optimise::enlarge_small(mesh, &target, &rim.hold(), settings, progress)?;
    let good = options.good_deviation();
    let off = |mesh: &HexMesh| off(mesh, [surface, surface])[0];
    let bare = |mesh: &HexMesh| bare_rim(mesh, surface, options, good).len();
    Ok(larger.filter(|larger| {
        let near = off(&larger.mesh) <= off(mesh).max(good);
        near && bare(&larger.mesh) <= bare(mesh)
    }))
}

/// How far panels stand off the surface, and the surface off the panels, over the diagonal.
fn off(mesh: &HexMesh, [surface, beyond]: [&TriangleSurface; 2]) -> [f64; 2] {
    let deviation = phex_mesh::deviation_beyond(mesh, surface, beyond);
    [inner_deviation(&deviation), deviation.coverage_max]
}

/// Relative difference of distances that is rounding: the place that is farthest off stays where it is, mostly.
const ROUNDING: f64 = 1e-9;

/// A valid mesh with more room in tight panels; `None` where there is none to be had, or panels and surface would come to stand off
/// farther for it, or more panels at the boundary would be small.
pub(super) fn roomier(
    mesh: &HexMesh,
    surfaces: [&TriangleSurface; 2],
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, PipelineError> {
    let [surface, beyond] = surfaces;
    let rim = Rim::kept(surface, options);
    let hold = rim.as_ref().map(Rim::hold);
    let (target, settings) = (SurfaceTarget::new(beyond), &options.optimise);
    let roomy = optimise::give_room(mesh, &target, hold.as_ref(), settings, progress)?;
    Ok(roomy.filter(|roomy| {
        let (before, now) = (off(mesh, surfaces), off(&roomy.mesh, surfaces));
        let as_near = (0..2).all(|k| now[k] <= before[k] * (1.0 + ROUNDING));
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
    let Some(rim) = Rim::of(surface, options) else {
        return Ok(None);
    };
    let (target, settings) = (SurfaceTarget::new(surface), &options.optimise);
    let held = optimise::onto_boundary(mesh, &target, &rim.hold(), settings, progress)?;
    Ok(held)
}
