//! `dual-subdivision`: a coarse mesh of tangent planes, refined by a rule of triangle meshes through its dual.

use super::{Made, refusal, tangent_planes};
use crate::ground::Ground;
use crate::layout::LayoutError;
use crate::layout::dual_subdivision::dual_subdivision;
use crate::layout::duality::{DualityError, Quadric};
use crate::layout::projective_dual::{self, SurfaceDual};
use crate::pipeline::{Clock, Method, PipelineError};

pub(super) fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    let options = &ground.options.dual;
    let mut coarse = ground.clone();
    coarse.panels = (ground.panels >> (2 * options.levels)).max(12);
    let start = super::Start::new(&coarse, clock)?;
    let dual = SurfaceDual::of(start.surface, &start.curvature.normal);
    let checked =
        projective_dual::check(start.surface, &start.curvature, &dual, "dual-subdivision");
    let outside_domain = refusal(checked, ground)?;
    let mut made = tangent_planes(&coarse, clock)?;
    made.classical.method = Method::DualSubdivision;
    made.classical.outside_domain = outside_domain;
    made.classical.centre = Some(dual.centre.into());
    made.classical.clearness = Some(dual.clearness);
    let levels = clock.stage("subdivision", || -> Result<_, DualityError> {
        let quadric = Quadric::sphere(dual.centre, 1.0)?;
        dual_subdivision(&made.mesh, &quadric, options.rule, options.levels)
    })?;
    if let Some(finest) = levels.map_err(LayoutError::from)?.pop() {
        made.mesh = finest;
    }
    Ok(made)
}
