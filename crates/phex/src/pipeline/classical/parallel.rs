//! `parallel`: the mesh parallel to a given P-Hex mesh that is closest to the surface. What is given is made from tangent planes: where `K > 0` a convex mesh
//! about the unit sphere, the lattice's discrete Gauss image; where `K < 0` the tangent planes' mesh itself, because edges there run against those of
//! their Gauss image.

use super::{Made, Start, cells, refusal};
use crate::ground::Ground;
use crate::layout::domain::{CurvatureSign, SignedPlaces};
use crate::layout::duality::{Plane, envelope};
use crate::layout::tangent_planes::tangent_planes;
use crate::layout::{Layout, LayoutError};
use crate::parallel_mesh::fit::{FitOptions, FitStart, fit_parallel};
use crate::pipeline::{Clock, Method, PipelineError};
use phex_mesh::{HexMesh, PerVertex, TriangleSurface};
use phex_numeric::Outcome;

pub(super) fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    let (start, field) = Start::with_lattice(ground, clock)?;
    let mut classical = start.statistics(Method::Parallel);
    let places = SignedPlaces::find(start.surface, &start.curvature);
    let checked = places.one_sign("parallel", "edges of the Gauss image vanish and turn round");
    classical.outside_domain = refusal(checked, ground)?;
    let (fine, layout) = cells(ground, &field, clock)?;
    let elliptic = classical.curvature == CurvatureSign::Elliptic;
    let given = if elliptic {
        gauss_image(&layout, &fine.surface)
    } else {
        envelope(&layout.mesh, &tangent_planes(&layout)).map_err(LayoutError::from)
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
    Ok(Made {
        reported: ground.reported(&fine.surface).clone(),
        mesh: fitted.mesh,
        fine: Some(fine),
        layout: field.statistics,
        outcome,
        optimised: None,
        classical,
    })
}

/// The mesh with the layout's normals whose faces touch the unit sphere.
fn gauss_image(layout: &Layout, surface: &TriangleSurface) -> Result<HexMesh, LayoutError> {
    let planes = layout.face_normal.map(|n| Plane {
        normal: *n,
        offset: 1.0,
    });
    let feet = surface.closest_points(layout.mesh.positions.as_slice());
    let near = PerVertex::from_vec(feet.iter().map(|f| f.normal).collect());
    Ok(envelope(&layout.mesh.with_positions(near), &planes)?)
}
