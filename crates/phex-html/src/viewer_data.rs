//! The data of the interactive view.

use crate::arrays::{PackedArray, floats, numbers};
use crate::layers::{Curves, Gauss, PackedSurface, StartLayer, other_gauss_images};
use crate::mesh_data::MeshData;
use crate::{CurveFamily, Report, tables};
use phex::quality::{Check, ElementKind};
use phex_mesh::{FaceId, HexMesh, Vec3, Violation, bounds};
use phex_picture::maps::{ColourMap, ColourScale, Coloured};
use serde::Serialize;
use std::collections::BTreeMap;

/// Most offenders that are listed one by one; the JSON report has all of them.
pub const MOST_OFFENDERS: usize = 500;

/// Everything that the viewer draws.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ViewerData<'a> {
    unit: &'a str,
    mean_edge: f64,
    mesh: MeshData,
    names: Option<&'a [String]>,
    area: PackedArray,
    planarity: PackedArray,
    angles: PackedArray,
    concave: PackedArray,
    maps: Vec<MapData>,
    offenders: Vec<FaultyPanels>,
    gauss: Option<Gauss>,
    /// Gauss images of the other kinds, by the names of their layers.
    spheres: BTreeMap<&'static str, PackedArray>,
    surface: Option<PackedSurface>,
    curves: Vec<Curves>,
    start: Option<StartLayer>,
    missing: BTreeMap<&'static str, String>,
}

impl<'a> ViewerData<'a> {
    /// Collects the data of a report; coordinates are relative to `origin`.
    pub fn new(report: &Report<'a>, maps: &[ColourMap], origin: Vec3) -> Self {
        let mesh = report.mesh;
        let elements = &report.run.assessment.measures.per_element;
        let topology = mesh.topology();
        let angles = topology
            .faces()
            .flat_map(|f| topology.face_half_edges(f))
            .map(|h| elements.corner_angle[h].to_degrees());
        let mut missing = BTreeMap::new();
        let gauss = Gauss::new(report).map_err(|reason| {
            missing.insert("gauss", reason.clone());
            missing.insert("offset", reason);
        });
        if gauss.as_ref().is_ok_and(|g| !g.has_offset()) {
            missing.insert("offset", "no distance gives a sound offset".to_owned());
        }
        let mut spheres = BTreeMap::new();
        for (layer, image) in other_gauss_images(report) {
            match image {
                Ok(directions) => drop(spheres.insert(layer, directions)),
                Err(reason) => drop(missing.insert(layer, reason)),
            };
        }
        if report.surface.is_none() {
            missing.insert("surface", "no surface was given".to_owned());
        }
        if let Err(reason) = report.curves {
            missing.insert("curves", reason.to_owned());
        }
        let mean_edge = report.run.assessment.measures.mean_edge;
        Self {
            unit: &report.run.unit,
            mean_edge,
            mesh: MeshData::of_topology(mesh.positions.as_slice(), topology, origin),
            names: report.names,
            area: floats(elements.area.iter().copied()),
            planarity: floats(elements.planarity_length.iter().copied()),
            angles: floats(angles),
            concave: numbers(elements.concave.iter().map(|&c| u32::from(c))),
            maps: maps.iter().map(MapData::new).collect(),
            offenders: offenders(report),
            gauss: gauss.ok(),
            spheres,
            surface: report.surface.map(|s| PackedSurface::new(s, origin)),
            curves: Vec::new(),
            start: report.start.map(|s| StartLayer::new(s, mean_edge, origin)),
            missing,
        }
        .with_curves(report.curves.unwrap_or_default(), origin)
    }

    /// The same with these curves.
    pub fn with_curves(mut self, curves: &[CurveFamily], origin: Vec3) -> Self {
        self.curves = curves.iter().map(|c| Curves::new(c, origin)).collect();
        self
    }
}

/// Middle of the bounding box.
pub fn centre(mesh: &HexMesh) -> Vec3 {
    let [low, high] = bounds(&mesh.positions);
    low / 2.0 + high / 2.0
}

/// A colour map with its legend.
#[derive(Debug, Serialize)]
struct MapData {
    name: &'static str,
    title: &'static str,
    caption: &'static str,
    element: Coloured,
    values: PackedArray,
    scale: ColourScale,
    counts: Vec<usize>,
    below: usize,
    above: usize,
    ticks: Vec<(f64, String)>,
}

impl MapData {
    fn new(map: &ColourMap) -> Self {
        let histogram = map.histogram();
        Self {
            name: map.map.name(),
            title: map.map.title(),
            caption: map.map.caption(),
            element: map.element,
            values: floats(map.values.iter().copied()),
            counts: histogram.counts,
            below: histogram.below,
            above: histogram.above,
            ticks: match &map.scale {
                ColourScale::Continuous(scale) => scale.ticks(),
                ColourScale::Classes(_) => Vec::new(),
            },
            scale: map.scale.clone(),
        }
    }
}

/// Something that is wrong with panels.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultyPanels {
    kind: &'static str,
    /// Whether it makes the mesh no panelling at all.
    pub loud: bool,
    /// The panels that take part, the named one first.
    pub faces: Vec<usize>,
    /// What is wrong.
    pub text: String,
}

/// What is wrong with panels, the worst kinds first.
pub fn offenders(report: &Report<'_>) -> Vec<FaultyPanels> {
    let violations = report.run.assessment.violations.iter();
    let mut list: Vec<FaultyPanels> = violations.map(|v| violation(report, v)).collect();
    let far = report
        .run
        .assessment
        .checks
        .iter()
        .find(|c| c.name == "deviation");
    list.extend(far.into_iter().flat_map(too_far));
    list.extend(report.run.assessment.checks.iter().flat_map(beyond_limit));
    list.retain(|o| !o.faces.is_empty());
    list.sort_by_key(|o| (!o.loud, o.kind != "not_simple"));
    list.truncate(MOST_OFFENDERS);
    list
}

fn violation(report: &Report<'_>, violation: &Violation) -> FaultyPanels {
    let kind = violation.kind();
    let faces = violation.faces(report.mesh.topology());
    FaultyPanels {
        kind,
        loud: violation.is_decisive(),
        faces: faces.into_iter().map(FaceId::index).collect(),
        text: violation.to_string(),
    }
}

/// The panels that a limit of a workshop is broken at.
fn beyond_limit(check: &Check) -> impl Iterator<Item = FaultyPanels> {
    let faces = check.faces.iter().filter(|f| **f < check.of_face.len());
    faces.map(move |&face| {
        let name = tables::title(check.name);
        let times = check.of_face[face];
        let text = match check.is_least {
            true => format!("{name}: {:.3} of what is asked for", 1.0 / times),
            false => format!("{name}: {times:.3} times what is allowed"),
        };
        FaultyPanels {
            kind: check.name,
            loud: false,
            faces: vec![face],
            text,
        }
    })
}

fn too_far(check: &Check) -> impl Iterator<Item = FaultyPanels> {
    let limit = 100.0 * check.limit;
    let faces = if check.element == ElementKind::Face {
        check.ids.as_slice()
    } else {
        &[]
    };
    faces.iter().map(move |&face| FaultyPanels {
        kind: "deviation",
        loud: false,
        faces: vec![face],
        text: format!("farther from the surface than {limit:.3} % of its diagonal"),
    })
}
