//! `dual-subdivision`: a coarse mesh of tangent planes, refined by a rule of triangle meshes through its dual.
//!
//! Rules for the rim of a triangle mesh know nothing of the surface, so an open one is subdivided with a strip beyond its boundary, of panels of the
//! coarse mesh, and the panels of the finest level are trimmed back to it.

use super::{Made, Start, cells, hull_panels, refusal};
use crate::ground::Ground;
use crate::layout::LayoutError;
use crate::layout::dual_subdivision::dual_subdivision;
use crate::layout::duality::{DualityError, Plane, Quadric, envelope, hull_about};
use crate::layout::projective_dual::{self, SurfaceDual};
use crate::layout::tangent_planes::tangent_planes;
use crate::pipeline::{Clock, MeshOptions, Method, PipelineError};
use crate::trim::Boundary;
use phex_mesh::{FacePlane, HexMesh, PerFace, TriangleSurface};

/// Least number of coarse panels.
const LEAST: usize = 12;

/// The ground of the coarse mesh: panels are trimmed whole, since none of them can be fitted to the boundary.
pub(super) fn ground(surface: &TriangleSurface, panels: usize, options: &MeshOptions) -> Ground {
    let mut options = options.clone();
    if options.boundary == Boundary::Snap {
        options.boundary = Boundary::Whole;
    }
    let coarse = (panels >> (2 * options.dual.levels)).max(LEAST);
    Ground::new(surface, coarse, &options)
}

pub(super) fn make(coarse: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    let options = &coarse.options.dual;
    let (start, field) = Start::with_lattice(coarse, clock)?;
    let mut classical = start.statistics(Method::DualSubdivision);
    let dual = SurfaceDual::of(start.surface, &start.curvature.normal);
    let checked =
        projective_dual::check(start.surface, &start.curvature, &dual, "dual-subdivision");
    classical.outside = refusal(checked, coarse)?;
    classical.centre = Some(dual.centre.into());
    classical.clearness = Some(dual.clearness);
    let (fine, layout) = cells(coarse, &field, clock)?;
    let planes = tangent_planes(&layout);
    let panels = hull_panels(coarse, &layout, &planes, &mut classical)?;
    let given = envelope(&panels, &planes).map_err(LayoutError::from)?;
    let quadric = Quadric::sphere(dual.centre, 1.0).map_err(LayoutError::from)?;
    let finest = clock.stage("subdivision", || -> Result<_, DualityError> {
        let levels = dual_subdivision(&given, &quadric, options.rule, options.levels)?;
        let finest = levels.last().unwrap_or(&given);
        if classical.flips.is_none() {
            return Ok((finest.clone(), 0));
        }
        with_hull(finest, &quadric)
    })?;
    let (mesh, flips) = finest.map_err(LayoutError::from)?;
    classical.flips = classical.flips.map(|coarse| coarse + flips);
    let statistics = field.placed.statistics;
    Ok(Made::of(coarse, mesh, fine, statistics, None, classical))
}

/// The mesh with the panels of its planes' hull: rules of subdivision do not keep the dual's edges convex.
fn with_hull(mesh: &HexMesh, quadric: &Quadric) -> Result<(HexMesh, usize), DualityError> {
    let plane = |f| {
        let fitted = FacePlane::fit(&mesh.corners(f).collect::<Vec<_>>());
        Plane::through(fitted.centre, fitted.normal)
    };
    let faces = mesh.topology().faces();
    let planes: PerFace<Plane> = PerFace::from_vec(faces.map(plane).collect());
    let (panels, flips) = hull_about(mesh, &planes, quadric)?;
    Ok((envelope(&panels, &planes)?, flips))
}
