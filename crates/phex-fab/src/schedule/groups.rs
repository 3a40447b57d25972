//! The table of groups: congruent panels, equal lengths, equal angles.

use super::{Cell, Table, list};
use crate::fabricate::Fabrication;
use crate::ids::edge_name;
use phex_mesh::cluster::Cluster;
use phex_mesh::{EdgeId, ElementId};

pub(super) fn table(fabrication: &Fabrication) -> Table {
    let head = vec![
        "kind", "type", "count", "value", "unit", "spread", "members",
    ];
    let Fabrication {
        mesh,
        ids,
        plates,
        groups,
        ..
    } = fabrication;
    let panel = |k: usize| ids.panel(plates[k].face).to_owned();
    let edge = |k: usize| edge_name(mesh, EdgeId::from_index(k));
    let mut rows = Vec::new();
    for (k, c) in groups.panels.iter().enumerate() {
        let values = [c.value * 1e-6, c.spread];
        rows.push(row(
            ["panel", &groups.panel_name(k), "m2, spread in mm"],
            c,
            values,
            list(c.members.iter().map(|&m| panel(m))),
        ));
    }
    for (k, c) in groups.lengths.iter().enumerate() {
        let members = list(c.members.iter().map(|&m| edge(m)));
        rows.push(row(
            ["edge length", &groups.length_name(k), "mm"],
            c,
            [c.value, c.spread],
            members,
        ));
    }
    for (k, c) in groups.dihedrals.iter().enumerate() {
        let values = [c.value, c.spread].map(f64::to_degrees);
        let members = list(
            c.members
                .iter()
                .map(|&m| edge_name(mesh, groups.inner_edges[m])),
        );
        rows.push(row(
            ["dihedral angle", &groups.dihedral_name(k), "deg"],
            c,
            values,
            members,
        ));
    }
    for (k, c) in groups.corners.iter().enumerate() {
        let values = [c.value, c.spread].map(f64::to_degrees);
        let corner = |&m: &usize| {
            let (plate, corner) = groups.corner_of[m];
            format!("{}:{}", panel(plate), corner + 1)
        };
        rows.push(row(
            ["corner angle", &groups.corner_name(k), "deg"],
            c,
            values,
            list(c.members.iter().map(corner)),
        ));
    }
    Table {
        name: "groups",
        head,
        rows,
    }
}

fn row(
    [kind, name, unit]: [&str; 3],
    cluster: &Cluster,
    [value, spread]: [f64; 2],
    members: Cell,
) -> Vec<Cell> {
    vec![
        kind.into(),
        name.into(),
        cluster.members.len().into(),
        value.into(),
        unit.into(),
        spread.into(),
        members,
    ]
}
