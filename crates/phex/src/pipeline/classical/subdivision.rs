//! `dual-subdivision`: a coarse mesh of tangent planes, refined by a rule of triangle meshes
//! through its dual.
//!
//! The panels along the boundary of the coarse mesh have tangent planes like all others, and rules
//! at the rim of their dual go on as inside, so every level covers the surface.

use super::{
    ClassicalMesh, ClassicalStatistics, CurvedGround, boundary_length, cells, fitted_planes,
    joined, panel_length, refusal,
};
use crate::classical::domain::{CurvatureSign, DomainError, LocatedVertex};
use crate::classical::dual_subdivision::dual_subdivision;
use crate::classical::duality::{
    DualityError, OrientedPlane, Quadric, clear_centre, envelope, hull_about, uncrossing_flips,
};
use crate::classical::projective_dual::{self, SurfaceDual};
use crate::layout::tangent_planes::tangent_planes;
use crate::layout::{Layout, LayoutError};
use crate::pipeline::domain::Ground;
use crate::pipeline::restarts::Drawn;
use crate::pipeline::{Clock, MeshOptions, Method, PipelineError};
use phex_mesh::{FaceId, HexMesh, PerFace, TriangleSurface, Vec3, VertexId};

/// Name in messages.
const METHOD: &str = "dual-subdivision";
/// Least number of coarse panels.
const LEAST: usize = 12;

/// The ground of the coarse mesh.
pub(super) fn ground(surface: &TriangleSurface, panels: usize, options: &MeshOptions) -> Ground {
    Ground::new(
        surface,
        coarse_panels(surface, panels, options.dual.levels),
        options,
    )
}

/// Panels of the coarse mesh. A level makes four of each, but of one at the boundary, of which
/// there are twice as many then, it makes three.
fn coarse_panels(surface: &TriangleSurface, panels: usize, levels: usize) -> usize {
    let (four, two) = (4f64.powi(levels as i32), 2f64.powi(levels as i32));
    let rim = boundary_length(surface);
    let mut coarse = panels as f64 / four;
    for _ in 0..3 {
        let at_rim = rim / panel_length(surface, (coarse as usize).max(LEAST));
        coarse = (panels as f64 + 0.5 * (four - two) * at_rim) / four;
    }
    (coarse.round() as usize).max(LEAST)
}

pub(super) fn make(coarse: &Ground, clock: &mut Clock<'_>) -> Result<ClassicalMesh, PipelineError> {
    // The strip beyond the boundary is not the user's: curvature of the other sign there is no
    // reason to refuse.
    let start = CurvedGround::on(coarse.given(), coarse, clock)?;
    let mut classical = start.statistics(Method::DualSubdivision);
    let dual = SurfaceDual::of(start.surface, &start.curvature.normal);
    let checked = start.resolved(coarse, METHOD);
    let checked = checked.and_then(|()| {
        projective_dual::check(start.surface, &start.curvature, &dual, true, METHOD)
    });
    classical.outside = refusal(checked, coarse)?;
    let (_, field) = CurvedGround::with_lattice(coarse, clock)?;
    let (fine, Drawn { placed, layout, .. }) = cells(coarse, &field, clock)?;
    let refined = clock.stage("subdivision", || refined(coarse, layout, &classical))?;
    let (mesh, classical) = refined?;
    Ok(ClassicalMesh::of(
        coarse,
        mesh,
        fine,
        (&field, placed.statistics),
        classical,
    ))
}

/// The finest mesh. Where `K < 0` the rules do better on a regular coarse mesh, but for panels that
/// cross themselves: then on a joined one.
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
        let checked = clear(layout, &planes, centre, clearness);
        let follows = || match classical.curvature {
            CurvatureSign::Hyperbolic => follows_surface(layout),
            _ => Ok(()),
        };
        classical.outside = refusal(checked.and_then(|()| follows()), coarse)?;
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
    planes: &PerFace<OrientedPlane>,
    centre: Vec3,
    clearness: f64,
) -> Result<(), DomainError> {
    if clearness >= projective_dual::CLEAR {
        return Ok(());
    }
    let distance = |f: &FaceId| planes[*f].height(centre).abs();
    let faces = layout.mesh.topology().faces();
    let nearest = faces.min_by(|a, b| distance(a).total_cmp(&distance(b)));
    let place = LocatedVertex {
        vertex: VertexId::new(0),
        position: nearest.map_or(centre, |f| layout.face_point[f]),
    };
    Err(DomainError::NoCentre {
        method: METHOD,
        place,
    })
}

/// Angle between the planes of neighbouring coarse panels, degrees, beyond which rules know nothing
/// of what is between them where `K < 0`.
const LARGEST_TURN: f64 = 50.0;

/// Whether the planes of a coarse mesh turn little enough from one panel to the next.
fn follows_surface(layout: &Layout) -> Result<(), DomainError> {
    let topology = layout.mesh.topology();
    let turn = |e| {
        let [f, g] = topology.faces_beside(e)?;
        let angle = layout.face_normal[f].angle(&layout.face_normal[g]);
        Some((f, angle.to_degrees()))
    };
    let turns = topology.edges().filter_map(turn);
    let largest = turns.max_by(|a, b| a.1.total_cmp(&b.1));
    match largest.filter(|t| t.1 > LARGEST_TURN) {
        None => Ok(()),
        Some((f, degrees)) => Err(DomainError::Coarse {
            method: METHOD,
            place: LocatedVertex {
                vertex: VertexId::new(0),
                position: layout.face_point[f],
            },
            degrees,
        }),
    }
}

/// The mesh with its panels joined as their planes want it: rules of subdivision know neither hulls
/// nor signs.
fn rejoined(
    mesh: HexMesh,
    quadric: &Quadric,
    classical: &mut ClassicalStatistics,
) -> Result<HexMesh, DualityError> {
    let planes = fitted_planes(&mesh);
    let flipped = match classical.curvature {
        CurvatureSign::Elliptic => hull_about(&mesh, &planes, quadric)?,
        CurvatureSign::Hyperbolic => uncrossing_flips(&mesh, &planes),
        CurvatureSign::Mixed => return Ok(mesh),
    };
    classical.count(&flipped, planes.len());
    let planes = planes.picked(&flipped.faces);
    let mesh = envelope(&flipped.mesh, &planes)?;
    Ok(classical.with_sound_rim(mesh, &planes))
}
