//! The table of panels.

use super::{Cell, Table, list};
use crate::fabricate::Fabrication;
use crate::ids::{edge_name, node_name};
use crate::nest::Placement;
use crate::outline::least_rectangle;
use crate::plate::Plate;
use phex_mesh::{
    ElementId, FaceId, FlatFace, HexMesh, LimitedFigure, PanelLimit, PerFace, ROUNDING, Vec2,
};

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
    head.extend(limits.iter().map(|(kind, _)| column(*kind)));
    let of_limits = |k: usize| limits.iter().map(move |(_, used)| Cell::from(used[k]));
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

/// How near each plate is to the limits that are set; beyond 1 it is outside. What is cut is
/// judged: the upper face, which the joint makes smaller, and for the sheet the outline of both
/// faces; angles between panels are the mesh's.
fn limits(fabrication: &Fabrication) -> Vec<(PanelLimit, Vec<f64>)> {
    let (plates, limits) = (&fabrication.plates, &fabrication.options.limits);
    let tops = limits.figures(&laid_out(fabrication, |plate| &plate.top));
    let outlines = limits.figures(&laid_out(fabrication, |plate| &plate.outline));
    let joints = limits.figures(&fabrication.mesh);
    let of_kind = |(kind, _)| {
        let (figures, of_mesh) = match kind {
            PanelLimit::MaxPanel => (&outlines, false),
            PanelLimit::MinDihedral | PanelLimit::MaxDihedral => (&joints, true),
            _ => (&tops, false),
        };
        let mut used = PerFace::from_vec(vec![0.0_f64; plates.len()]);
        for figure in figures.iter().filter(|figure| figure.kind == kind) {
            for &f in figure.faces.iter().flatten() {
                used[f] = used[f].max(nearness(figure));
            }
        }
        let number = |(k, plate): (usize, &Plate)| match of_mesh {
            true => used[plate.face],
            false => used[FaceId::from_index(k)],
        };
        (kind, plates.iter().enumerate().map(number).collect())
    };
    limits.set().map(of_kind).collect()
}

/// How many plates are beyond any of the limits that are set, and beyond each of them.
pub(super) fn beyond_limits(fabrication: &Fabrication) -> (usize, Vec<(PanelLimit, usize)>) {
    let limits = limits(fabrication);
    let is_beyond = |used: &f64| *used > 1.0 + ROUNDING;
    let panels = 0..fabrication.plates.len();
    let any = panels.filter(|&k| limits.iter().any(|(_, used)| is_beyond(&used[k])));
    let of = |(kind, used): &(PanelLimit, Vec<f64>)| {
        (*kind, used.iter().filter(|used| is_beyond(used)).count())
    };
    (any.count(), limits.iter().map(of).collect())
}

/// The polygons of all plates side by side, in model units: face `k` is that of plate `k`.
fn laid_out(fabrication: &Fabrication, polygon: fn(&Plate) -> &Vec<Vec2>) -> HexMesh {
    let mut positions = Vec::new();
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for plate in &fabrication.plates {
        let first = positions.len() as u32;
        let corners = polygon(plate)
            .iter()
            .map(|p| p / fabrication.options.unit_mm);
        positions.extend(corners.map(|p| p.push(0.0)));
        faces.push((first..positions.len() as u32).collect());
    }
    HexMesh::new(positions, &faces).expect("polygons that share no corner")
}

/// How near a figure is to its limit; above 1 beyond it.
fn nearness(figure: &LimitedFigure) -> f64 {
    match figure.kind.is_least() {
        true => figure.limit / figure.value,
        false => figure.value / figure.limit,
    }
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
