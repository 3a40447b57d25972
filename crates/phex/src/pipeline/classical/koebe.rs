//! `koebe`: panels with offsets at constant edge distance. A lattice that is regular on the Gauss
//! sphere, where circles pack, is pulled back by the Gauss map; the Koebe mesh of its graph is the
//! Gauss image of the panels, and the mesh parallel to it that is closest to the surface has them,
//! with one of three families of edges reversed where `K < 0` ([`crate::offset::EdgeSigns`]).
//!
//! Edges between panels whose normals differ by `dn` are perpendicular to `dn` on the surface and
//! on the sphere: that is why a lattice from the sphere has the directions of a Koebe mesh on any
//! surface with `K != 0`. Where `K < 0` the Gauss map turns the orientation round, and so the Koebe
//! mesh is that of the panels seen from below.

use super::{ClassicalMesh, CurvedGround, cells, fitted_planes, on_gauss_sphere};
use crate::classical::domain::{
    CurvatureSign, DomainError, SignedPlaces, no_flat_point, not_flat, without_holes,
};
use crate::classical::support_function;
use crate::directions::guides::Cone;
use crate::koebe::{BoundaryCondition, KoebeOptions, koebe};
use crate::layout::lattice::gauss_lattice::gauss_lattice;
use crate::layout::{LayoutError, LayoutStatistics};
use crate::offset::fit::{FitError, FitOptions, Fitted, fit_beyond};
use crate::offset::signs::{EdgeSigns, SIGNED_FAIRNESS};
use crate::pipeline::domain::{Ground, WHOLE_STRIP};
use crate::pipeline::restarts::Drawn;
use crate::pipeline::{Clock, MeshOptions, Method, PipelineError, panel_length};
use crate::progress::Progress;
use crate::trim::Boundary;
use phex_mesh::{HexMesh, TriangleSurface};
use phex_numeric::Outcome;

/// Name in messages.
const METHOD: &str = "koebe";

/// The surface and a strip beyond its boundary that is wide enough for whole panels: where they are
/// cut, too, nothing may turn at the rim.
pub(super) fn ground(surface: &TriangleSurface, panels: usize, options: &MeshOptions) -> Ground {
    Ground::with_strip(
        surface,
        panels,
        options,
        WHOLE_STRIP * panel_length(surface, panels),
    )
}

pub(super) fn make(ground: &Ground, clock: &mut Clock<'_>) -> Result<ClassicalMesh, PipelineError> {
    let closed = ground.given_facets().topology().is_closed();
    if !closed && ground.options.boundary == Boundary::Snap {
        return Err(PipelineError::Snap { method: METHOD });
    }
    let given = CurvedGround::on(ground.given(), ground, clock)?;
    let mut classical = given.statistics(Method::Koebe);
    check(&given, ground).map_err(LayoutError::from)?;
    let made = match closed {
        true => closed_graph(ground, clock)?,
        false => patch_graph(ground, &given, clock)?,
    };
    let options = KoebeOptions {
        boundary: BoundaryCondition::Sphere,
        ..KoebeOptions::default()
    };
    let progress = clock.progress;
    let image = clock.timed("koebe", || koebe(&made.graph, &options, progress))?;
    let fitted = clock.timed("parallel", || {
        fitted(
            &image.mesh,
            &made.surface,
            ground,
            classical.curvature,
            progress,
        )
    })?;
    classical.edges_at_bound = Some(fitted.edges_at_bound);
    classical.reversed_edges = Some(fitted.reversed_edges.len());
    let (mean, spread) = (fitted.mean_curvature, fitted.mean_curvature_spread);
    classical.mean_curvature_rel = Some([mean, mean.abs() * spread.hypot(1.0)]);
    let mesh = oriented(fitted.mesh, classical.curvature);
    let mesh = classical.with_sound_rim(mesh, &fitted_planes(&image.mesh));
    let reported = ground.reported(&made.surface).clone();
    Ok(ClassicalMesh {
        fine: Some(made.surface),
        layout: made.layout,
        cones: made.cones,
        outcome: Outcome::empty(fitted.status),
        ..ClassicalMesh::new(mesh, reported, classical)
    })
}

/// Least length of an edge over the mean where `K > 0` and there are such panels: where the radii
/// of curvature differ by 3 the sign rule has edges without length. Where `K < 0` it has none.
const LEAST_EDGE: f64 = 0.25;

/// The mesh parallel to an image that is closest to the surface.
fn fitted(
    image: &HexMesh,
    surface: &TriangleSurface,
    ground: &Ground,
    curvature: CurvatureSign,
    progress: &dyn Progress,
) -> Result<Fitted, FitError> {
    let given = ground.given().finest();
    let with = |least_edge: f64| {
        let fit = FitOptions {
            signs: EdgeSigns::SignRule,
            fairness: SIGNED_FAIRNESS,
            minimal: ground.options.dual.minimal,
            least_edge,
            ..FitOptions::default()
        };
        fit_beyond(image, surface, given, &fit, progress)
    };
    let usual = FitOptions::default().least_edge;
    if curvature == CurvatureSign::Hyperbolic {
        return with(usual);
    }
    match with(LEAST_EDGE) {
        Err(FitError::NoneWithSigns { .. }) => with(usual),
        made => made,
    }
}

/// Panels about the Gauss sphere: the normals of the surface for places, faces outwards.
struct GaussGraph {
    graph: HexMesh,
    /// The finest surface, with the strip beyond its boundary.
    surface: TriangleSurface,
    layout: LayoutStatistics,
    cones: Vec<Cone>,
}

/// On a closed surface: the cells of a lattice with 12 pentagons that is regular in the third
/// fundamental form.
fn closed_graph(ground: &Ground, clock: &mut Clock<'_>) -> Result<GaussGraph, PipelineError> {
    let start = CurvedGround::new(ground, clock)?;
    let metric = support_function::metric(&start.curvature);
    let field = start.field(ground, metric, clock)?;
    let (fine, Drawn { placed, layout, .. }) = cells(ground, &field, clock)?;
    Ok(GaussGraph {
        graph: on_gauss_sphere(&layout.mesh, &fine.surface),
        surface: fine.surface,
        layout: placed.statistics,
        cones: field.cones(&ground.smooth),
    })
}

/// On a patch: the conformal image of a regular lattice, hexagons only.
fn patch_graph(
    ground: &Ground,
    given: &CurvedGround<'_>,
    clock: &mut Clock<'_>,
) -> Result<GaussGraph, PipelineError> {
    let all = ground.smooth.finest();
    let share = ground.given().finest().area() / all.area();
    let panels = (ground.panels as f64 * share).round() as usize;
    let rotate = ground.options.directions.rotate;
    let graph = clock.stage("layout", || {
        gauss_lattice(given.surface, &given.curvature, panels.max(1), rotate)
    })??;
    Ok(GaussGraph {
        graph,
        surface: all.clone(),
        layout: LayoutStatistics::default(),
        cones: Vec::new(),
    })
}

/// Whether the surface has a Gauss map that is one to one, and `K` of one sign.
fn check(given: &CurvedGround<'_>, ground: &Ground) -> Result<(), DomainError> {
    let (surface, curvature) = (given.surface, &given.curvature);
    let consequence = "edges of the Gauss image vanish and turn round";
    given.resolved(ground, METHOD)?;
    let sign = SignedPlaces::find(surface, curvature).one_sign(METHOD, consequence)?;
    not_flat(surface, curvature, METHOD, consequence)?;
    without_holes(surface, METHOD)?;
    no_flat_point(sign, surface, curvature, METHOD, consequence)?;
    support_function::one_to_one(surface, curvature, METHOD)
}

/// The Gauss map turns the orientation round where `K < 0`.
fn oriented(mesh: HexMesh, curvature: CurvatureSign) -> HexMesh {
    match curvature {
        CurvatureSign::Hyperbolic => mesh.turned_over(),
        _ => mesh,
    }
}
