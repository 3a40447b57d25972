//! `dual-subdivision`: a coarse mesh of tangent planes, refined by a rule of triangle meshes through its dual.
//!
//! Rules for the rim of a triangle mesh know nothing of the surface, so an open one is subdivided with a strip beyond its boundary, of panels of the
//! coarse mesh, and the panels of the finest level are trimmed back to it.

use super::{ClassicalStatistics, Made, Start, cells, joined, panel_length, refusal};
use crate::ground::Ground;
use crate::layout::domain::{CurvatureSign, DomainError, Place};
use crate::layout::dual_subdivision::dual_subdivision;
use crate::layout::duality::{
    DualityError, Plane, Quadric, clear_centre, envelope, hull_about, uncrossing_flips,
};
use crate::layout::projective_dual::{self, SurfaceDual};
use crate::layout::tangent_planes::tangent_planes;
use crate::layout::{Layout, LayoutError};
use crate::pipeline::{Clock, MeshOptions, Method, PipelineError};
use crate::trim::Boundary;
use phex_mesh::{FaceId, FacePlane, HexMesh, PerFace, TriangleSurface, Vec3, VertexId};

/// Name in messages.
const METHOD: &str = "dual-subdivision";
/// Least number of coarse panels.
const LEAST: usize = 12;

/// Width of the strip beyond the boundary, in lengths of coarse panels: rules at the rim reach one panel further in than the trimming.
const STRIP: f64 = 2.5;
/// Width of that strip over the root of the surface's area beyond which a narrow one must do: so far out nothing is known of the surface.
const WIDEST: f64 = 0.32;

/// The ground of the coarse mesh: panels are trimmed whole, since none of them can be fitted to the boundary. The strip is wide if the dual can go so far.
pub(super) fn ground(surface: &TriangleSurface, panels: usize, options: &MeshOptions) -> Ground {
    let mut options = options.clone();
    if options.boundary == Boundary::Snap {
        options.boundary = Boundary::Whole;
    }
    let coarse = (panels >> (2 * options.dual.levels)).max(LEAST);
    let width = STRIP * panel_length(surface, coarse);
    if width < WIDEST * surface.area().sqrt() {
        let wide = Ground::with_strip(surface, coarse, &options, width);
        let level = &wide.smooth.levels[0];
        if SurfaceDual::of(level, level.normals()).is_affine() {
            return wide;
        }
    }
    Ground::new(surface, coarse, &options)
}

pub(super) fn make(coarse: &Ground, clock: &mut Clock<'_>) -> Result<Made, PipelineError> {
    // The strip beyond the boundary is not the user's: curvature of the other sign there is no reason to refuse.
    let start = Start::on(coarse.given(), coarse, clock)?;
    let mut classical = start.statistics(Method::DualSubdivision);
    let dual = SurfaceDual::of(start.surface, &start.curvature.normal);
    let checked = projective_dual::check(start.surface, &start.curvature, &dual, METHOD);
    classical.outside = refusal(checked, coarse)?;
    let (_, field) = Start::with_lattice(coarse, clock)?;
    let (fine, layout) = cells(coarse, &field, clock)?;
    let refined = clock.stage("subdivision", || refined(coarse, layout, &classical))?;
    let (mesh, classical) = refined?;
    let statistics = field.placed.statistics;
    Ok(Made::of(coarse, mesh, fine, statistics, None, classical))
}

/// The finest mesh. Where `K < 0` the rules do better on a regular coarse mesh, but for panels that cross themselves: then on a joined one.
fn refined(
    coarse: &Ground,
    layout: Layout,
    classical: &ClassicalStatistics,
) -> Result<(HexMesh, ClassicalStatistics), LayoutError> {
    let crossing = |mesh: &HexMesh| phex_mesh::measure(mesh).faces_not_simple;
    let mut told = classical.clone();
    let mut regular = None;
    if classical.curvature == CurvatureSign::Hyperbolic {
        let mesh = finest(coarse, &layout, &mut told)?;
        if crossing(&mesh) == 0 || !coarse.options.dual.hull {
            return Ok((mesh, told));
        }
        regular = Some((mesh, told));
        told = classical.clone();
    }
    let layout = joined(coarse, layout, &mut told)?;
    let mesh = finest(coarse, &layout, &mut told)?;
    let better = regular.filter(|(m, _)| crossing(m) <= crossing(&mesh));
    Ok(better.unwrap_or((mesh, told)))
}

/// The finest mesh of a coarse layout's tangent planes.
fn finest(
    coarse: &Ground,
    layout: &Layout,
    classical: &mut ClassicalStatistics,
) -> Result<HexMesh, LayoutError> {
    let options = &coarse.options.dual;
    let planes = tangent_planes(layout);
    let given = envelope(&layout.mesh, &planes)?;
    let (centre, clearness) = clear_centre(planes.as_slice(), layout.face_point.as_slice());
    classical.centre = Some(centre.into());
    classical.clearness = Some(clearness);
    if classical.outside.is_none() {
        classical.outside = refusal(clear(layout, &planes, centre, clearness), coarse)?;
    }
    let quadric = Quadric::sphere(centre, 1.0)?;
    let mut levels = dual_subdivision(&given, &quadric, options.rule, options.levels)?;
    let finest = levels.pop().unwrap_or(given);
    if !options.hull {
        return Ok(finest);
    }
    Ok(rejoined(finest, &quadric, classical)?)
}

/// Whether the planes of a coarse mesh, strip and all, keep off the centre.
fn clear(
    layout: &Layout,
    planes: &PerFace<Plane>,
    centre: Vec3,
    clearness: f64,
) -> Result<(), DomainError> {
    if clearness >= projective_dual::CLEAR {
        return Ok(());
    }
    let distance = |f: &FaceId| planes[*f].height(centre).abs();
    let faces = layout.mesh.topology().faces();
    let nearest = faces.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let place = Place {
        vertex: VertexId::new(0),
        position: nearest.map_or(centre, |f| layout.face_point[f]),
    };
    Err(DomainError::NoCentre {
        method: METHOD,
        place,
    })
}

/// The mesh with its panels joined as their planes want it: rules of subdivision know neither hulls nor signs.
fn rejoined(
    mesh: HexMesh,
    quadric: &Quadric,
    classical: &mut ClassicalStatistics,
) -> Result<HexMesh, DualityError> {
    let plane = |f| {
        let fitted = FacePlane::fit(&mesh.corners(f).collect::<Vec<_>>());
        Plane::through(fitted.centre, fitted.normal)
    };
    let planes: PerFace<Plane> = PerFace::from_vec(mesh.topology().faces().map(plane).collect());
    let flipped = match classical.curvature {
        CurvatureSign::Elliptic => hull_about(&mesh, &planes, quadric)?,
        CurvatureSign::Hyperbolic => uncrossing_flips(&mesh, &planes),
        CurvatureSign::Mixed => return Ok(mesh),
    };
    classical.count(&flipped, planes.len());
    let planes = PerFace::from_vec(flipped.faces.iter().map(|f| planes[*f]).collect());
    envelope(&flipped.mesh, &planes)
}
