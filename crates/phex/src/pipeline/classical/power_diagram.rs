//! `power-diagram`: a Goldberg polyhedron on the ellipsoid that the surface is, or is a piece of.

use super::ClassicalMesh;
use crate::classical::power_diagram::{fit_ellipsoid, goldberg, nearest_goldberg};
use crate::layout::LayoutError;
use crate::pipeline::domain::Ground;
use crate::pipeline::{Clock, Method, PipelineError};
use crate::trim;
use phex_mesh::{FaceId, HexMesh, PerFace, TriangleSurface};

/// A panel of the polyhedron belongs to a patch if its touching point is nearer to it than this
/// share of a panel's length.
const NEAR: f64 = 0.1;

pub(super) fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<ClassicalMesh, PipelineError> {
    let surface = &ground.smooth.levels[0];
    let mut classical = super::CurvedGround::new(ground, clock)?.statistics(Method::PowerDiagram);
    let ellipsoid = fit_ellipsoid(surface).map_err(LayoutError::from)?;
    classical.centre = Some(ellipsoid.centre.into());
    let polyhedron = |panels: usize| -> Result<_, PipelineError> {
        let class = nearest_goldberg(panels);
        let sphere = goldberg(class.0, class.1).map_err(LayoutError::from)?.mesh;
        Ok((class, sphere.mapped(|p| ellipsoid.place(*p))))
    };
    let made = clock.stage("layout", || -> Result<_, PipelineError> {
        let (class, whole) = polyhedron(ground.panels)?;
        if surface.topology().is_closed() {
            return Ok((class, whole));
        }
        let share = surface.area() / phex_mesh::measure(&whole).area;
        let (class, whole) = polyhedron((ground.panels as f64 / share).round() as usize)?;
        Ok((class, patch(&whole, surface)?))
    })?;
    let (class, mesh) = made?;
    classical.goldberg = Some(class);
    let reported = ground.reported(ground.smooth.finest()).clone();
    Ok(ClassicalMesh::new(mesh, reported, classical))
}

/// The panels of a polyhedron that lie over a patch.
fn patch(whole: &HexMesh, surface: &TriangleSurface) -> Result<HexMesh, PipelineError> {
    let centres = whole.centres();
    let feet = PerFace::from_vec(surface.closest_points(centres.as_slice()));
    // Panels stand off the facets of the surface by the sagitta of both; only the way along the
    // surface counts.
    let off = |f: &FaceId| {
        let (d, n) = (centres[*f] - feet[*f].position, feet[*f].normal);
        (d - n * n.dot(&d)).norm()
    };
    let limit = NEAR * 2.0 * whole.mean_edge();
    let kept = whole.topology().faces().filter(|f| off(f) < limit);
    Ok(trim::part(whole, &kept.collect::<Vec<_>>())?)
}
