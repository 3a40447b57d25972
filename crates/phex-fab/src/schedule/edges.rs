//! The table of edges.

use super::{Cell, Table};
use crate::fabricate::Fabrication;
use crate::ids::{edge_name, node_name};
use phex_mesh::EdgeId;

pub(super) fn table(fabrication: &Fabrication) -> Table {
    let head = vec![
        "id",
        "boundary",
        "length_mm",
        "length_type",
        "panel_1",
        "panel_2",
        "node_1",
        "node_2",
        "dihedral_deg",
        "dihedral_type",
        "mitre_deg",
    ];
    let rows = fabrication
        .mesh
        .topology()
        .edges()
        .map(|e| row(fabrication, e))
        .collect();
    Table {
        name: "edges",
        head,
        rows,
    }
}

fn row(fabrication: &Fabrication, edge: EdgeId) -> Vec<Cell> {
    let Fabrication {
        mesh,
        ids,
        options,
        groups,
        ..
    } = fabrication;
    let topology = mesh.topology();
    let h = topology.edge_half_edge(edge);
    let panel = |h| ids.panel(topology.face(h)).to_owned();
    let [a, b] = topology.edge_vertices(edge).map(|v| node_name(mesh, v));
    let dihedral = groups.dihedral(edge);
    let place = topology
        .face_half_edges(topology.face(h))
        .position(|g| g == h)
        .unwrap_or(0);
    let mitre = fabrication.plates[topology.face(h).index()].sides[place].mitre;
    vec![
        edge_name(mesh, edge).into(),
        topology.is_boundary_edge(edge).into(),
        (mesh.edge_length(edge) * options.unit_mm).into(),
        groups.length_type(edge).into(),
        panel(h).into(),
        topology.twin(h).map_or("-".to_owned(), panel).into(),
        a.into(),
        b.into(),
        dihedral
            .as_ref()
            .map_or("".into(), |(angle, _)| angle.to_degrees().into()),
        dihedral.map_or("".into(), |(_, name)| name.into()),
        mitre.to_degrees().into(),
    ]
}
