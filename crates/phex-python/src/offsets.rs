//! Requests for layers and for curve networks.

use crate::answer::{Answer, AnswerPart};
use crate::inputs::Inputs;
use crate::judged::stopped;
use phex::directions::{Curve, NetworkFamily};
use phex::offset::{
    GaussImage, OffsetError, OffsetKind, OffsetOptions, PanelSolid, SafeDistances, beam_axes,
    edge_gauss_image, face_gauss_image, joined, layer, node_axes, panel_solids, rounded_down,
    safe_distances, successive, vertex_gauss_image,
};
use phex::{MeshOptions, PanelSize, Progress};
use phex_job::{JobError, Quantity, TypedPanelSize, Unit, chain, check_distances};
use phex_mesh::{HexMesh, ValidateOptions};
use serde::Deserialize;
use serde_json::json;

/// Options of `phex.offset`; distances are model units.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OffsetRequest {
    kind: OffsetKind,
    distances: Vec<f64>,
    max_distance: bool,
    gauss_image: bool,
    solids: bool,
    /// Width of the joints between solids, model units.
    gap: f64,
    beams: bool,
    planarity: Option<Quantity>,
    unit: Unit,
}

/// Layers of a mesh, its largest distances, and its Gauss image.
///
/// # Errors
/// If the mesh has no such offset, or a distance goes too far.
pub fn offset(
    request: OffsetRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let mesh = inputs.panels()?;
    check_distances("distance", &request.distances, &mesh)?;
    let fraction = |q: Quantity| q.fraction(request.unit, mesh.mean_edge());
    let options = OffsetOptions {
        validity: ValidateOptions {
            planarity: request.planarity.map(fraction),
            ..ValidateOptions::default()
        },
        ..OffsetOptions::default()
    };
    let image = image(&mesh, request.kind, &options)?;
    let mut layers: Vec<HexMesh> = Vec::new();
    for &distance in &request.distances {
        stopped(progress)?;
        let moved = layer(&mesh, &image, distance, &options);
        let moved = moved.map_err(|e| {
            too_far(&chain(&e), distance, || {
                safe_distances(&mesh, &image, &options)
            })
        })?;
        layers.push(moved);
    }
    let soups = layers.iter().map(HexMesh::to_soup).collect();
    let mut answer = vec![("layers", AnswerPart::Meshes(soups))];
    if request.solids || request.beams {
        let numbered = request.distances.iter().copied().zip(&layers);
        answer.extend(between(&successive(&mesh, numbered), &request)?);
    }
    if request.max_distance {
        let safe = safe_distances(&mesh, &image, &options);
        let ends = vec![-safe.inward.distance, safe.outward.distance];
        answer.push(("max_distance", AnswerPart::Numbers(ends)));
    }
    if request.gauss_image {
        let touching = mesh.with_positions(image.positions.clone()).to_soup();
        answer.push(("gauss_image", AnswerPart::Mesh(Some(touching))));
    }
    Ok(answer)
}

/// What lies between layers: solids, beams and nodes.
fn between(pairs: &[[&HexMesh; 2]], request: &OffsetRequest) -> Result<Answer, JobError> {
    let told = |e: &dyn std::error::Error| JobError::NoResult(chain(e));
    let (mut solids, mut volumes, mut beams) = (Vec::new(), Vec::new(), Vec::new());
    for [lower, upper] in pairs {
        if request.solids {
            let made = panel_solids(lower, upper, request.gap).map_err(|e| match e {
                OffsetError::Gap { .. } => JobError::Input(format!("gap: {e}")),
                e => told(&e),
            })?;
            volumes.push(made.iter().map(PanelSolid::volume).sum());
            solids.push(joined(&made));
        }
        if request.beams {
            let axes = beam_axes(lower, upper).map_err(|e| told(&e))?;
            let nodes = node_axes(lower, upper).map_err(|e| told(&e))?;
            beams.push(json!({
                "edge": axes.iter().map(|b| b.edge.index()).collect::<Vec<_>>(),
                "vertices": axes.iter().map(|b| b.vertices.map(|v| v.index())).collect::<Vec<_>>(),
                "ends": axes.iter().map(|b| b.ends.map(<[f64; 3]>::from)).collect::<Vec<_>>(),
                "plane_normal": axes.iter().map(|b| <[f64; 3]>::from(b.plane_normal)).collect::<Vec<_>>(),
                "torsion": axes.iter().map(|b| b.torsion).collect::<Vec<_>>(),
                "node": nodes.iter().map(|n| n.vertex.index()).collect::<Vec<_>>(),
                "base": nodes.iter().map(|n| <[f64; 3]>::from(n.base)).collect::<Vec<_>>(),
                "direction": nodes.iter().map(|n| <[f64; 3]>::from(n.direction)).collect::<Vec<_>>(),
                "length": nodes.iter().map(|n| n.length).collect::<Vec<_>>(),
            }));
        }
    }
    Ok(vec![
        ("solids", AnswerPart::Meshes(solids)),
        ("volumes", AnswerPart::Numbers(volumes)),
        ("beams", AnswerPart::Text(json!(beams).to_string())),
    ])
}

fn image(
    mesh: &HexMesh,
    kind: OffsetKind,
    options: &OffsetOptions,
) -> Result<GaussImage, JobError> {
    let image = match kind {
        OffsetKind::Face => face_gauss_image(mesh, options),
        OffsetKind::Edge => edge_gauss_image(mesh, options).map(|found| found.image),
        OffsetKind::Vertex => vertex_gauss_image(mesh, options).map(|s| s.image),
    };
    image.map_err(|e| JobError::Input(chain(&e)))
}

fn too_far(cause: &str, distance: f64, safe: impl FnOnce() -> SafeDistances) -> JobError {
    let safe = safe();
    let most = match distance < 0.0 {
        true => -rounded_down(safe.inward.distance),
        false => rounded_down(safe.outward.distance),
    };
    JobError::NoResult(format!(
        "{cause}; the largest safe distance on that side is {most} (model units)"
    ))
}

/// Lengths in model units, for options that take `20mm` or `1%`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LengthsRequest {
    lengths: Vec<Quantity>,
    unit: Unit,
}

/// Lengths in model units; percentages refer to the diagonal of the mesh.
///
/// # Errors
/// If the mesh can't be used.
pub fn lengths(
    request: LengthsRequest,
    inputs: Inputs,
    _: &dyn Progress,
) -> Result<Answer, JobError> {
    let size = inputs.panels()?.diagonal();
    let lengths = request.lengths.iter().map(|q| q.length(request.unit, size));
    Ok(vec![("lengths", AnswerPart::Numbers(lengths.collect()))])
}

/// Options of `phex.network`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkRequest {
    panels: u64,
    columns_along: Option<[f64; 3]>,
}

/// A conjugate curve network of a surface.
///
/// # Errors
/// If the surface can't be used or has no network.
pub fn network(
    request: NetworkRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let surface = inputs.first()?.surface()?;
    let size = TypedPanelSize::Panels(request.panels);
    let panels = phex_job::panels(size, &surface, Unit::default())?;
    let mut options = MeshOptions {
        size: PanelSize::Panels(usize::try_from(panels).unwrap_or(usize::MAX)),
        ..MeshOptions::default()
    };
    if let Some(axis) = request.columns_along {
        options.brick_wall.network.family = NetworkFamily::ConjugateTo(axis);
    }
    let found = phex_job::network(&surface, &options, progress)?;
    let points = |curve: &Curve| {
        let first = curve.points.first().filter(|_| curve.closed);
        curve.points.iter().chain(first).copied().collect()
    };
    let family = |curves: &[Curve]| AnswerPart::Curves(curves.iter().map(points).collect());
    let figures = found.conjugacy.map(|c| vec![c.median, c.p95, c.worst]);
    Ok(vec![
        ("rows", family(&found.rows)),
        ("columns", family(&found.columns)),
        (
            "conjugacy",
            AnswerPart::Numbers(figures.unwrap_or_default()),
        ),
    ])
}
