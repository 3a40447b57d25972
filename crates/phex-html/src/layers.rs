//! What is shown besides the panels.

use crate::arrays::{PackedArray, floats, numbers, points};
use crate::mesh_data::MeshData;
use crate::thin::thinned;
use crate::{CurveFamily, Report};
use phex::offset::{
    GaussImage, OffsetOptions, edge_gauss_image, face_gauss_image, safe_distances_up_to,
    vertex_gauss_image,
};
use phex_mesh::{FlatFace, PolygonSoup, TriangleSurface, Vec3};
use serde::Serialize;

/// The Gauss image, which is also the direction of offsets, with the distances that offsets may
/// have.
#[derive(Debug, Serialize)]
pub struct Gauss {
    directions: PackedArray,
    inward: f64,
    outward: f64,
}

impl Gauss {
    /// The Gauss image of a planar mesh, or why there is none.
    pub fn new(report: &Report<'_>) -> Result<Self, String> {
        let options = offset_options(report);
        let image = face_gauss_image(report.mesh, &options).map_err(|e| e.to_string())?;
        // A flat mesh may be offset without end; a mean edge is plenty to look at.
        let most = report.mesh.mean_edge();
        let safe = safe_distances_up_to(most, report.mesh, &image, &options);
        Ok(Self {
            directions: points(&image.positions, Vec3::zeros()),
            inward: safe.inward.distance.min(most),
            outward: safe.outward.distance.min(most),
        })
    }

    /// Whether there is a distance at which an offset is sound.
    pub fn has_offset(&self) -> bool {
        self.inward + self.outward > 0.0
    }
}

/// The Gauss images whose edges touch the unit sphere and whose vertices lie on it, by the names of
/// their layers, or why there is none.
pub fn other_gauss_images(report: &Report<'_>) -> [(&'static str, Result<PackedArray, String>); 2] {
    let options = offset_options(report);
    let directions = |image: GaussImage| points(&image.positions, Vec3::zeros());
    let edges = edge_gauss_image(report.mesh, &options).map(|found| directions(found.image));
    let vertices = vertex_gauss_image(report.mesh, &options).map(|found| directions(found.image));
    [
        ("gauss-edges", edges.map_err(|e| e.to_string())),
        ("gauss-vertices", vertices.map_err(|e| e.to_string())),
    ]
}

/// What counts as planar in the report counts here.
fn offset_options(report: &Report<'_>) -> OffsetOptions {
    let mut options = OffsetOptions::default();
    let planarity = report
        .run
        .assessment
        .checks
        .iter()
        .find(|c| c.name == "planarity");
    if let Some(check) = planarity {
        options.validity.planarity = Some(check.limit);
    }
    options
}

/// The surface, thinned out where it is very fine.
#[derive(Debug, Serialize)]
pub struct PackedSurface {
    positions: PackedArray,
    triangles: PackedArray,
}

impl PackedSurface {
    /// Packs a surface.
    pub fn new(surface: &TriangleSurface, origin: Vec3) -> Self {
        let soup = thinned(surface);
        Self {
            positions: points(&soup.positions, origin),
            triangles: numbers(soup.faces.into_iter().flatten()),
        }
    }
}

/// Curves of one family, one after the other.
#[derive(Debug, Serialize)]
pub struct Curves {
    name: String,
    points: PackedArray,
    /// Number of the first point of each curve, and the number of all points.
    starts: PackedArray,
}

impl Curves {
    /// Packs a family.
    pub fn new(family: &CurveFamily, origin: Vec3) -> Self {
        let mut starts = vec![0];
        for curve in &family.curves {
            starts.push(starts[starts.len() - 1] + curve.len() as u32);
        }
        Self {
            name: family.name.clone(),
            points: points(family.curves.iter().flatten(), origin),
            starts: numbers(starts),
        }
    }
}

/// The mesh before the last step.
#[derive(Debug, Serialize)]
pub struct StartLayer {
    mesh: MeshData,
    planarity: PackedArray,
}

impl StartLayer {
    /// Packs polygons with their planarity over the result's mean edge.
    pub fn new(soup: &PolygonSoup, mean_edge: f64, origin: Vec3) -> Self {
        let planarity = soup.faces.iter().map(|face| {
            let corners: Vec<Vec3> = face.iter().map(|&v| soup.positions[v as usize]).collect();
            FlatFace::new(&corners).planarity_length / mean_edge
        });
        Self {
            planarity: floats(planarity),
            mesh: MeshData::new(soup, origin),
        }
    }
}
