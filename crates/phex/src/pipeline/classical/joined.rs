//! The panels of a lattice, joined as their tangent planes want it, and the mesh of these planes.

use super::ClassicalStatistics;
use crate::classical::domain::CurvatureSign;
use crate::classical::duality::{
    OrientedPlane, convex_panels, envelope, saddle_flips, uncrossing_flips,
};
use crate::layout::seeds::Seed;
use crate::layout::tangent_planes::tangent_planes as tangent_planes_of;
use crate::layout::{self, Layout, LayoutError};
use crate::pipeline::domain::Ground;
use crate::pipeline::field::{Field, FineSurface};
use crate::pipeline::restarts::{Drawn, most_regular};
use crate::pipeline::{Clock, PipelineError};
use crate::progress::Progress;
use phex_mesh::{HexMesh, PerFace, PerVertex, TriangleSurface};

/// The panels of a lattice as its cells give them, the most regular of a few.
pub(super) fn cells(
    ground: &Ground,
    field: &Field,
    clock: &mut Clock<'_>,
) -> Result<(FineSurface, Drawn), PipelineError> {
    let fine = FineSurface::new(ground, field);
    let made =
        |seeds: &[Seed], progress: &dyn Progress| layout::panelling(&fine.cells(), seeds, progress);
    let first = Drawn::first(ground, field, made, clock)?;
    let drawn = most_regular(ground, field, first, made, clock)?;
    Ok((fine, drawn))
}

/// The mesh of a layout's tangent planes.
pub(super) fn met(
    layout: &Layout,
    classical: &mut ClassicalStatistics,
) -> Result<HexMesh, LayoutError> {
    let planes = tangent_planes_of(layout);
    let mesh = envelope(&layout.mesh, &planes)?;
    Ok(classical.with_sound_rim(mesh, &planes))
}

/// The layout with its panels joined as the poles of their planes are in their hull where `K > 0`;
/// where `K < 0` by the sign rule, and then so that fewer panels cross themselves.
pub(super) fn joined(
    ground: &Ground,
    layout: Layout,
    classical: &mut ClassicalStatistics,
) -> Result<Layout, LayoutError> {
    if !ground.options.dual.hull {
        return Ok(layout);
    }
    let planes = tangent_planes_of(&layout);
    let (mesh, points) = (&layout.mesh, &layout.face_point);
    match classical.curvature {
        CurvatureSign::Elliptic => {
            let convex = convex_panels(mesh, &planes, points)?;
            classical.count(&convex, planes.len());
            Ok(layout.joined(&convex))
        }
        CurvatureSign::Hyperbolic => {
            let ruled = saddle_flips(mesh, &planes, points);
            let simple = uncrossing_flips(&envelope(&ruled.mesh, &planes)?, &planes);
            classical.count(&ruled, planes.len());
            classical.count(&simple, planes.len());
            Ok(layout.joined(&ruled).joined(&simple))
        }
        CurvatureSign::Mixed => Ok(layout),
    }
}

/// A mesh with the normals of a surface, where it is nearest to its vertices, in their place.
pub(super) fn on_gauss_sphere(mesh: &HexMesh, surface: &TriangleSurface) -> HexMesh {
    let feet = surface.closest_points(mesh.positions.as_slice());
    mesh.with_positions(PerVertex::from_vec(feet.iter().map(|f| f.normal).collect()))
}

/// The planes of a mesh's faces.
pub(super) fn fitted_planes(mesh: &HexMesh) -> PerFace<OrientedPlane> {
    PerFace::from_fn(mesh.topology().n_faces(), |f| OrientedPlane::of(mesh, f))
}
