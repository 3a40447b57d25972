//! The methods that take the tangent planes of a lattice: `projective-dual`, `support-function`,
//! `tangent-planes`. They differ in the metric in which it is regular.

use super::joined::{cells, joined, met};
use super::{ClassicalMesh, ClassicalStatistics, CurvedGround, refusal};
use crate::classical::domain::CurvatureSign;
use crate::classical::duality::Quadric;
use crate::classical::projective_dual::{self, SurfaceDual};
use crate::classical::support_function;
use crate::layout::LayoutError;
use crate::layout::tangent_planes::{METHOD as TANGENT_PLANES, regularised};
use crate::optimise::{self, SurfaceTarget};
use crate::pipeline::brick_wall::kinked;
use crate::pipeline::domain::Ground;
use crate::pipeline::field::Field;
use crate::pipeline::restarts::Drawn;
use crate::pipeline::{Clock, Method, PipelineError};

pub(super) fn projective_dual(
    ground: &Ground,
    clock: &mut Clock<'_>,
) -> Result<ClassicalMesh, PipelineError> {
    let start = CurvedGround::new(ground, clock)?;
    let (surface, curvature) = (start.surface, &start.curvature);
    let given = ground.options.dual.quadric.map(Quadric::from_upper);
    let dual = match given.transpose().map_err(LayoutError::from)? {
        Some(quadric) => SurfaceDual::about(surface, &curvature.normal, quadric),
        None => SurfaceDual::of(surface, &curvature.normal),
    };
    let chosen = ground.options.dual.quadric.is_none();
    let mut classical = start.statistics(Method::ProjectiveDual);
    let method = projective_dual::METHOD;
    let checked = start.resolved(ground, method);
    let checked =
        checked.and_then(|()| projective_dual::check(surface, curvature, &dual, chosen, method));
    classical.outside = refusal(checked, ground)?;
    classical.centre = dual.quadric.centre().map(Into::into);
    classical.clearness = Some(dual.clearness);
    classical.defects = Some(projective_dual::inspect(surface, curvature, &dual));
    let metric = dual.metric(surface, curvature);
    let field = start.field(ground, metric, clock)?;
    tangent_panels(ground, &field, classical, clock)
}

pub(super) fn support_function(
    ground: &Ground,
    clock: &mut Clock<'_>,
) -> Result<ClassicalMesh, PipelineError> {
    let start = CurvedGround::new(ground, clock)?;
    let mut classical = start.statistics(Method::SupportFunction);
    let checked = start.resolved(ground, support_function::METHOD);
    let checked = checked.and_then(|()| support_function::check(start.surface, &start.curvature));
    classical.outside = refusal(checked, ground)?;
    let metric = support_function::metric(&start.curvature);
    let field = start.field(ground, metric, clock)?;
    tangent_panels(ground, &field, classical, clock)
}

pub(super) fn tangent_planes(
    ground: &Ground,
    clock: &mut Clock<'_>,
) -> Result<ClassicalMesh, PipelineError> {
    let options = &ground.options;
    let (start, field) = CurvedGround::with_lattice(ground, clock)?;
    let mut classical = start.statistics(Method::TangentPlanes);
    // Planes of any lattice can be taken; what becomes of them where facets hide the curvature is
    // not the method's fault.
    classical.outside = start.resolved(ground, TANGENT_PLANES).err();
    let (
        fine,
        Drawn {
            placed, mut layout, ..
        },
    ) = cells(ground, &field, clock)?;
    classical.foresee(&layout);
    let (mesh, fitted) = if options.dual.regularisation > 0.0 {
        layout.mesh = regularised(&layout, options.dual.regularisation);
        let target = SurfaceTarget::new(ground.close_to(&fine.surface));
        let progress = clock.progress;
        let optimised = clock.timed("optimise", || {
            optimise::optimise(&layout, &target, &kinked(&options.optimise), progress)
        })?;
        (optimised.mesh, Some((optimised.outcome, optimised.run)))
    } else {
        (met(&layout, &mut classical)?, None)
    };
    let mut made = ClassicalMesh::of(ground, mesh, fine, (&field, placed.statistics), classical);
    if let Some((outcome, run)) = fitted {
        (made.outcome, made.run) = (outcome, Some(run));
    }
    Ok(made)
}

/// The panels of a lattice, joined as their tangent planes want it, in these planes.
fn tangent_panels(
    ground: &Ground,
    field: &Field,
    mut classical: ClassicalStatistics,
    clock: &mut Clock<'_>,
) -> Result<ClassicalMesh, PipelineError> {
    let (fine, Drawn { placed, layout, .. }) = cells(ground, field, clock)?;
    let layout = joined(ground, layout, &mut classical)?;
    // Panels of a hull are convex, whatever the second order says.
    if !(ground.options.dual.hull && classical.curvature == CurvatureSign::Elliptic) {
        classical.foresee(&layout);
    }
    let mesh = met(&layout, &mut classical)?;
    Ok(ClassicalMesh::of(
        ground,
        mesh,
        fine,
        (field, placed.statistics),
        classical,
    ))
}
