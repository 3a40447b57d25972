//! `parallel`: the mesh parallel to a given P-Hex mesh that is closest to the surface. What is
//! given is made from tangent planes: where `K > 0` a convex mesh about the unit sphere, the
//! lattice's discrete Gauss image; where `K < 0` the tangent planes' mesh itself, because edges
//! there run against those of their Gauss image.

use super::{
    ClassicalMesh, ClassicalStatistics, CurvedGround, cells, fitted_planes, joined, met,
    on_gauss_sphere, refusal,
};
use crate::classical::domain::{CurvatureSign, SignedPlaces, no_flat_point, not_flat};
use crate::classical::duality::{OrientedPlane, convex_panels, envelope};
use crate::layout::{Layout, LayoutError};
use crate::offset::fit::{FitOptions, FitStart, fit_parallel};
use crate::pipeline::domain::Ground;
use crate::pipeline::restarts::Drawn;
use crate::pipeline::{Clock, Method, PipelineError};
use phex_mesh::{HexMesh, TriangleSurface};
use phex_numeric::Outcome;

/// Name in messages.
const METHOD: &str = "parallel";

pub(super) fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<ClassicalMesh, PipelineError> {
    let (start, field) = CurvedGround::with_lattice(ground, clock)?;
    let mut classical = start.statistics(Method::Parallel);
    let places = SignedPlaces::find(start.surface, &start.curvature);
    let consequence = "edges of the Gauss image vanish and turn round";
    let checked = start.resolved(ground, METHOD);
    let checked = checked.and_then(|()| places.one_sign(METHOD, consequence));
    let (surface, curvature) = (start.surface, &start.curvature);
    let checked =
        checked.and_then(|sign| no_flat_point(sign, surface, curvature, METHOD, consequence));
    let checked = checked.and_then(|_| not_flat(surface, curvature, METHOD, consequence));
    classical.outside = refusal(checked, ground)?;
    let (fine, Drawn { placed, layout, .. }) = cells(ground, &field, clock)?;
    let elliptic = classical.curvature == CurvatureSign::Elliptic;
    let given = if elliptic {
        gauss_image(&layout, &fine.surface, ground, &mut classical)
    } else {
        joined(ground, layout, &mut classical).and_then(|layout| met(&layout, &mut classical))
    }?;
    let fit = FitOptions {
        start: if elliptic {
            FitStart::Normals
        } else {
            FitStart::Positions
        },
        ..FitOptions::default()
    };
    let progress = clock.progress;
    let fitted = clock.timed("parallel", || {
        fit_parallel(&given, &fine.surface, &fit, progress)
    })?;
    classical.edges_at_bound = Some(fitted.edges_at_bound);
    let outcome = Outcome::empty(fitted.status);
    // Lengths of edges at the rim are free, but for what closes their panel: some turn over.
    let mesh = classical.with_sound_rim(fitted.mesh, &fitted_planes(&given));
    let made = ClassicalMesh::of(ground, mesh, fine, (&field, placed.statistics), classical);
    Ok(ClassicalMesh { outcome, ..made })
}

/// The mesh with the layout's normals whose faces touch the unit sphere. With convex panels so are
/// those of every mesh that is parallel to it with edges in the same sense.
fn gauss_image(
    layout: &Layout,
    surface: &TriangleSurface,
    ground: &Ground,
    classical: &mut ClassicalStatistics,
) -> Result<HexMesh, LayoutError> {
    let touching = |layout: &Layout| {
        layout.face_normal.map(|n| OrientedPlane {
            normal: *n,
            offset: 1.0,
        })
    };
    let planes = touching(layout);
    let mut layout = layout.clone();
    if ground.options.dual.hull {
        let convex = convex_panels(&layout.mesh, &planes, &layout.face_normal)?;
        classical.count(&convex, layout.mesh.topology().n_faces());
        layout = layout.joined(&convex);
    }
    let near = on_gauss_sphere(&layout.mesh, surface);
    Ok(envelope(&near, &touching(&layout))?)
}
