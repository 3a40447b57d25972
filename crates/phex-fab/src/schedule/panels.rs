//! The table of panels.

use super::{Cell, Table, list};
use crate::fabricate::Fabrication;
use crate::ids::{edge_name, node_name};
use crate::nest::Placement;
use crate::outline::least_rectangle;
use phex::quality::{Assessment, Check, Limits, References};
use phex_mesh::{FlatFace, PanelLimit};

pub(super) fn table(fabrication: &Fabrication) -> Table {
    let limits = limits(fabrication);
    let mut head = vec![
        "id",
        "type",
        "corners",
        "convex",
        "area_m2",
        "perimeter_mm",
        "box_length_mm",
        "box_width_mm",
        "volume_m3",
        "planarity_mm",
        "lengths_mm",
        "angles_deg",
        "mitres_deg",
        "neighbours",
        "edges",
        "nodes",
        "sheet",
        "sheet_x_mm",
        "sheet_y_mm",
        "sheet_rotation_deg",
        "centre_x_mm",
        "centre_y_mm",
        "centre_z_mm",
        "labels_left_out",
    ];
    head.extend(limits.iter().map(|(column, _)| *column));
    let of_limits = |k: usize| {
        let face = fabrication.plates[k].face.index();
        limits
            .iter()
            .map(move |(_, check)| Cell::from(check.of_face[face].max(0.0)))
    };
    let mean_edge = fabrication.mesh.mean_edge();
    let placements = fabrication.placements().into_iter().enumerate();
    let rows = placements
        .map(|(k, placed)| {
            row(fabrication, k, placed, mean_edge)
                .into_iter()
                .chain(of_limits(k))
                .collect()
        })
        .collect();
    Table {
        name: "panels",
        head,
        rows,
    }
}

/// The limits that are set, with their columns: how near each panel is, beyond 1 it is outside.
fn limits(fabrication: &Fabrication) -> Vec<(&'static str, Check)> {
    let set = Limits {
        panels: fabrication.options.limits,
        ..Limits::default()
    };
    if set.panels.is_empty() {
        return Vec::new();
    }
    let assessment = Assessment::new(&fabrication.mesh, References::default(), &set);
    let named = |check: Check| {
        let mut kinds = set.panels.set().map(|(kind, _)| kind);
        let kind = kinds.find(|kind| kind.name() == check.name)?;
        Some((column(kind), check))
    };
    assessment.checks.into_iter().filter_map(named).collect()
}

fn column(kind: PanelLimit) -> &'static str {
    match kind {
        PanelLimit::MaxPanel => "max_panel_used",
        PanelLimit::MinEdge => "min_edge_used",
        PanelLimit::MaxEdge => "max_edge_used",
        PanelLimit::MinAngle => "min_angle_used",
        PanelLimit::MaxArea => "max_area_used",
        PanelLimit::MaxAspect => "max_aspect_used",
        PanelLimit::MinDihedral => "min_dihedral_used",
        PanelLimit::MaxDihedral => "max_dihedral_used",
    }
}

fn row(
    fabrication: &Fabrication,
    number: usize,
    (sheet, placement): (usize, Placement),
    mean_edge: f64,
) -> Vec<Cell> {
    let Fabrication {
        mesh, ids, options, ..
    } = fabrication;
    let plate = &fabrication.plates[number];
    let solid = &fabrication.solids[number];
    let face = plate.face;
    let lengths = plate.lengths();
    let [length, width] = least_rectangle(&plate.outline);
    let flat = FlatFace::of(mesh, face);
    let centre = mesh.centre(face) * options.unit_mm;
    let neighbour =
        |side: &crate::plate::PlateSide| side.neighbour.map_or("-", |f| ids.panel(f)).to_owned();
    let degrees = |angle: f64| angle.to_degrees();
    vec![
        ids.panel(face).into(),
        fabrication.groups.panel_type(number).into(),
        plate.top.len().into(),
        (!flat.is_concave(mean_edge)).into(),
        (plate.area() * 1e-6).into(),
        lengths.iter().sum::<f64>().into(),
        length.into(),
        width.into(),
        (solid.volume() * (1e-3 * options.unit_mm).powi(3)).into(),
        (flat.planarity_length * options.unit_mm).into(),
        list(&lengths),
        list(plate.angles().into_iter().map(degrees)),
        list(plate.sides.iter().map(|s| degrees(s.mitre))),
        list(plate.sides.iter().map(neighbour)),
        list(plate.sides.iter().map(|s| edge_name(mesh, s.edge))),
        list(
            mesh.topology()
                .face_vertices(face)
                .iter()
                .map(|&v| node_name(mesh, v)),
        ),
        (sheet + 1).into(),
        placement.translation.x.into(),
        placement.translation.y.into(),
        degrees(placement.rotation).into(),
        centre.x.into(),
        centre.y.into(),
        centre.z.into(),
        list(&fabrication.texts[number].left_out),
    ]
}
