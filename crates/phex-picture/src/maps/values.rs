//! The values that maps show.

use super::{Class, Coloured, Map, panel_kinds};
use phex::curvature::{self, CurvatureOptions, Principal};
use phex::quality::Assessment;
use phex::report::FeatureSizes;
use phex_mesh::measure::aspect;
use phex_mesh::{ElementId, FaceId, FlatFace, HexMesh, PerFace, TriangleSurface};
use std::collections::BTreeSet;

/// A mesh with everything that is known of it.
#[derive(Clone, Copy)]
pub struct Subject<'a> {
    /// The mesh.
    pub mesh: &'a HexMesh,
    /// What was measured of it.
    pub assessment: &'a Assessment,
    /// The surface that it stands for; without it, curvature is that of the mesh's own faces.
    pub surface: Option<&'a TriangleSurface>,
}

/// Classes of [`Map::Validity`]. Concave panels are valid and quiet, panels that cross themselves
/// are loud.
pub const VALIDITY: [Class; 5] = [
    class("convex, valid", [0xF0, 0xE9, 0xE0]),
    class("concave, valid", [0xC4, 0xDB, 0xD2]),
    class("outside a tolerance", [0xE6, 0x9F, 0x00]),
    class("folded, flipped or crossed", [0xD5, 0x4A, 0x00]),
    class("self-intersecting", [0xD4, 0x00, 0x6A]),
];

const fn class(label: &'static str, colour: [u8; 3]) -> Class {
    Class { label, colour }
}

/// One value per element; `None` if the map needs a surface, or a limit, and there is none.
pub fn values(map: Map, subject: &Subject<'_>) -> Option<(Coloured, Vec<f64>)> {
    use Coloured::{Edge, Face};
    let measures = &subject.assessment.measures;
    let (unit, elements) = (measures.mean_edge, &measures.per_element);
    Some(match map {
        Map::Planarity => {
            let lengths = elements.planarity_length.iter();
            (Face, lengths.map(|d| d / unit).collect())
        }
        Map::Deviation => (Face, deviation(subject)?),
        Map::EdgeLength => {
            let lengths = elements.edge_length.iter();
            (Edge, lengths.map(|l| l / unit).collect())
        }
        Map::Dihedral => {
            let angles = elements.dihedral.iter();
            let degrees = angles.map(|a| a.map_or(f64::NAN, f64::to_degrees));
            (Edge, degrees.collect())
        }
        Map::Curvature => (Face, curvature_ratios(subject)?),
        Map::FeatureSize => {
            let sizes = FeatureSizes::new(subject.mesh, subject.surface?);
            (Face, sizes.per_face)
        }
        Map::PanelArea => {
            let mean = measures.area / measures.faces as f64;
            (Face, elements.area.iter().map(|a| a / mean).collect())
        }
        Map::PanelAspect => {
            let faces = FlatFace::all(subject.mesh);
            let aspects = faces.iter().map(|f| aspect(&f.polygon));
            (Face, aspects.map(finite).collect())
        }
        Map::Valence => (Face, panel_kinds::class_numbers(subject.mesh)),
        Map::Validity => (Face, validity(subject)),
        _ => (Face, limited(map, subject)?),
    })
}

/// How near each panel is to a limit of a workshop; `None` where that is not set.
fn limited(map: Map, subject: &Subject<'_>) -> Option<Vec<f64>> {
    let name = map.limit()?;
    let mut checks = subject.assessment.checks.iter();
    let check = checks.find(|c| c.name == name)?;
    Some(check.of_face.iter().copied().map(finite).collect())
}

/// A value that can be drawn.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { f64::NAN }
}

/// Largest distance of a panel's corners and centre to the surface, in % of the surface's diagonal.
fn deviation(subject: &Subject<'_>) -> Option<Vec<f64>> {
    let deviation = subject.assessment.judged_deviation()?;
    let topology = subject.mesh.topology();
    let largest = |f: FaceId| {
        let corners = topology.face_vertices(f).iter();
        let distances = corners.map(|&v| deviation.vertex_distance[v]);
        distances.fold(deviation.face_distance[f], f64::max)
    };
    let percent = |f| 100.0 * largest(f) / deviation.diagonal;
    Some(topology.faces().map(percent).collect())
}

/// Class of each panel in [`VALIDITY`].
fn validity(subject: &Subject<'_>) -> Vec<f64> {
    let topology = subject.mesh.topology();
    let assessment = subject.assessment;
    let concave = &assessment.measures.per_element.concave;
    let mut class: PerFace<u8> = concave.map(|&c| u8::from(c));
    let missed = assessment.checks.iter().filter(|c| !c.pass && !c.decisive);
    for &f in missed.flat_map(|check| &check.faces) {
        class[FaceId::from_index(f)] = 2;
    }
    for violation in &assessment.violations {
        let worse = match violation.is_decisive() {
            true if violation.kind() == "not_simple" => 4,
            true => 3,
            false => 2,
        };
        let faces: BTreeSet<FaceId> = violation.faces(topology).into_iter().collect();
        for f in faces {
            class[f] = class[f].max(worse);
        }
    }
    class.iter().map(|&c| f64::from(c)).collect()
}

/// Side length of a square of a panel's area over the fitted length of [`curvature::curvature`].
const PANEL_LENGTH: f64 = 1.07;
/// Largest curvature times panel length at which a surface counts as flat, hence parabolic.
const FLAT: f64 = 1e-3;

/// Smaller over larger principal curvature at the centre of each panel.
fn curvature_ratios(subject: &Subject<'_>) -> Option<Vec<f64>> {
    let flat = FLAT / panel_length(subject);
    let ratio = |p: &Principal| {
        if p.large.abs() <= flat {
            0.0
        } else {
            p.small / p.large
        }
    };
    Some(principal_at_panels(subject)?.iter().map(ratio).collect())
}

/// Length of a panel, in model units.
fn panel_length(subject: &Subject<'_>) -> f64 {
    let measures = &subject.assessment.measures;
    PANEL_LENGTH * (measures.area / measures.faces as f64).sqrt()
}

/// Principal curvatures and directions at the centre of each panel, at the scale of a panel: of the
/// surface, or without one of the mesh's own faces; `None` if these are no surface.
pub fn principal_at_panels(subject: &Subject<'_>) -> Option<Vec<Principal>> {
    let mesh = subject.mesh;
    let length = panel_length(subject);
    let own;
    let (surface, radius) = match subject.surface {
        Some(surface) => (surface, length),
        None => {
            own = own_surface(mesh)?;
            (&own, OWN_RADIUS * length)
        }
    };
    let points = surface.closest_points(mesh.centres().as_slice());
    let options = CurvatureOptions::default();
    let tensors = curvature::tensors_at_points(surface, &points, radius, &options);
    let places = points.iter().zip(&tensors);
    let principal = places.map(|(p, tensor)| curvature::principal(p.normal, tensor));
    Some(principal.collect())
}

/// How much farther curvature looks on a mesh's own faces, which are as large as panels.
const OWN_RADIUS: f64 = 3.0;

fn own_surface(mesh: &HexMesh) -> Option<TriangleSurface> {
    let parts = TriangleSurface::from_soup(&mesh.to_soup()).ok()?.components;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for part in parts {
        let first = positions.len() as u32;
        positions.extend_from_slice(part.surface.positions().as_slice());
        triangles.extend((part.surface.triangles()).map(|t| t.map(|v| v + first)));
    }
    TriangleSurface::new(positions, &triangles).ok()
}
