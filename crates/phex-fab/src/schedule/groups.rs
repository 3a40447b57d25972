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
    let corner = |k: usize| {
        let (plate, corner) = groups.corner_of[k];
        format!("{}:{}", panel(plate), corner + 1)
    };
    let degrees = |c: &Cluster| [c.value, c.spread].map(f64::to_degrees);
    let rows = [
        rows(
            ["panel", "m2, spread in mm"],
            (&groups.panels, |k| groups.panel_name(k)),
            |c| [c.value * 1e-6, c.spread],
            panel,
        ),
        rows(
            ["edge length", "mm"],
            (&groups.lengths, |k| groups.length_name(k)),
            |c| [c.value, c.spread],
            |k| edge_name(mesh, EdgeId::from_index(k)),
        ),
        rows(
            ["dihedral angle", "deg"],
            (&groups.dihedrals, |k| groups.dihedral_name(k)),
            degrees,
            |k| edge_name(mesh, groups.inner_edges[k]),
        ),
        rows(
            ["corner angle", "deg"],
            (&groups.corners, |k| groups.corner_name(k)),
            degrees,
            corner,
        ),
    ]
    .concat();
    Table {
        name: "groups",
        head,
        rows,
    }
}

/// The rows of the groups of a kind.
fn rows(
    [kind, unit]: [&str; 2],
    (groups, name): (&[Cluster], impl Fn(usize) -> String),
    values: impl Fn(&Cluster) -> [f64; 2],
    member: impl Fn(usize) -> String,
) -> Vec<Vec<Cell>> {
    let row = |(k, c): (usize, &Cluster)| {
        let [value, spread] = values(c);
        vec![
            kind.into(),
            name(k).into(),
            c.members.len().into(),
            value.into(),
            unit.into(),
            spread.into(),
            list(c.members.iter().map(|&m| member(m))),
        ]
    };
    groups.iter().enumerate().map(row).collect()
}
