//! The table of nodes.

use super::{Cell, Table, list};
use crate::fabricate::Fabrication;
use crate::ids::{edge_name, node_name};
use phex_mesh::polygon::interior_angles;
use phex_mesh::{EdgeId, FlatFace, Vec3, VertexId};

pub(super) fn table(fabrication: &Fabrication) -> Table {
    let head = vec![
        "id",
        "boundary",
        "x_mm",
        "y_mm",
        "z_mm",
        "edges",
        "panels",
        "angles_deg",
        "normal_x",
        "normal_y",
        "normal_z",
    ];
    let rows = fabrication
        .mesh
        .topology()
        .vertices()
        .map(|v| row(fabrication, v))
        .collect();
    Table {
        name: "nodes",
        head,
        rows,
    }
}

fn row(fabrication: &Fabrication, vertex: VertexId) -> Vec<Cell> {
    let Fabrication {
        mesh, ids, options, ..
    } = fabrication;
    let topology = mesh.topology();
    let p = mesh.position(vertex) * options.unit_mm;
    let panels: Vec<_> = topology.faces_at(vertex).collect();
    let flat: Vec<FlatFace> = panels.iter().map(|&f| FlatFace::of(mesh, f)).collect();
    let normal: Vec3 = flat.iter().map(FlatFace::normal).sum();
    let normal = normal.try_normalize(0.0).unwrap_or_default();
    let angle = |(k, f): (usize, &FlatFace)| {
        let corner = topology
            .face_vertices(panels[k])
            .iter()
            .position(|&v| v == vertex)?;
        Some(interior_angles(&f.polygon).nth(corner)?.to_degrees())
    };
    vec![
        node_name(mesh, vertex).into(),
        topology.is_boundary_vertex(vertex).into(),
        p.x.into(),
        p.y.into(),
        p.z.into(),
        list(
            edges(fabrication, vertex)
                .into_iter()
                .map(|e| edge_name(mesh, e)),
        ),
        list(panels.iter().map(|&f| ids.panel(f))),
        list(flat.iter().enumerate().filter_map(angle)),
        normal.x.into(),
        normal.y.into(),
        normal.z.into(),
    ]
}

/// The edges at a vertex, counter-clockwise; panel `i` lies between edges `i` and `i + 1`.
fn edges(fabrication: &Fabrication, vertex: VertexId) -> Vec<EdgeId> {
    let spokes = fabrication.mesh.topology().spokes(vertex);
    spokes.into_iter().map(|(e, _)| e).collect()
}
