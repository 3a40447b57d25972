//! Groups of panels, edges and angles, with names that hold a dash, which no panel's own has:
//! a panel in row T may be `T1`, and the first type is `T-1`.

use crate::options::FabOptions;
use crate::plate::Plate;
use phex_mesh::cluster::{Cluster, Congruence, Rings, by_value, congruent};
use phex_mesh::{EdgeId, FlatFace, HexMesh, PerEdge};
use std::f64::consts::PI;

/// What is the same in a mesh and its panels.
#[derive(Clone, Debug, PartialEq)]
pub struct Groups {
    /// Congruent panels; members are panels.
    pub panels: Vec<Cluster>,
    /// Equal lengths of the mesh's edges, in mm; members are edges.
    pub lengths: Vec<Cluster>,
    /// Equal dihedral angles, in radians; members are places in `inner_edges`.
    pub dihedrals: Vec<Cluster>,
    /// Equal angles of panels at their corners, in radians; members are places in `corner_of`.
    pub corners: Vec<Cluster>,
    /// The edges with two panels.
    pub inner_edges: Vec<EdgeId>,
    /// Panel and corner of each corner.
    pub corner_of: Vec<(usize, usize)>,
    panel_group: Vec<usize>,
    length_group: Vec<usize>,
    dihedral: PerEdge<Option<(f64, usize)>>,
}

impl Groups {
    /// Groups everything within the options' tolerances.
    pub fn new(mesh: &HexMesh, plates: &[Plate], options: &FabOptions) -> Self {
        let topology = mesh.topology();
        let lengths: Vec<f64> = topology
            .edges()
            .map(|e| mesh.edge_length(e) * options.unit_mm)
            .collect();
        let lengths = by_value(&lengths, options.tolerance_mm);
        let inner_edges: Vec<EdgeId> = topology.inner_edges().collect();
        let angles = dihedrals(mesh, &inner_edges);
        let dihedrals = by_value(&angles, options.angle_tolerance);
        let mut dihedral = PerEdge::filled(topology.n_edges(), None);
        for (group, cluster) in dihedrals.iter().enumerate() {
            cluster
                .members
                .iter()
                .for_each(|&m| dihedral[inner_edges[m]] = Some((angles[m], group)));
        }
        let corner_of: Vec<(usize, usize)> = plates
            .iter()
            .enumerate()
            .flat_map(|(k, p)| (0..p.top.len()).map(move |c| (k, c)))
            .collect();
        let angles: Vec<f64> = plates.iter().flat_map(Plate::angles).collect();
        let rings = |p: &Plate| vec![p.top.clone(), p.bottom.clone()];
        let rings: Vec<Rings> = plates.iter().map(rings).collect();
        let panels = congruent(&rings, options.tolerance_mm, Congruence::Turned);
        Self {
            panel_group: group_of(&panels, plates.len()),
            length_group: group_of(&lengths, topology.n_edges()),
            corners: by_value(&angles, options.angle_tolerance),
            panels,
            lengths,
            dihedrals,
            inner_edges,
            corner_of,
            dihedral,
        }
    }

    /// Name of a group of panels.
    pub fn panel_name(&self, group: usize) -> String {
        format!("T-{}", group + 1)
    }

    /// Name of a group of lengths.
    pub fn length_name(&self, group: usize) -> String {
        format!("L-{}", group + 1)
    }

    /// Name of a group of dihedral angles.
    pub fn dihedral_name(&self, group: usize) -> String {
        format!("D-{}", group + 1)
    }

    /// Name of a group of corner angles.
    pub fn corner_name(&self, group: usize) -> String {
        format!("C-{}", group + 1)
    }

    /// Name of the group of a panel.
    pub fn panel_type(&self, panel: usize) -> String {
        self.panel_name(self.panel_group[panel])
    }

    /// Name of the group of an edge's length.
    pub fn length_type(&self, edge: EdgeId) -> String {
        self.length_name(self.length_group[edge.index()])
    }

    /// Angle between the two panels of an edge, measured inside (below 180 degrees at ridges, above
    /// in valleys), in radians, and the name of its group; `None` on the boundary.
    pub fn dihedral(&self, edge: EdgeId) -> Option<(f64, String)> {
        self.dihedral[edge].map(|(angle, group)| (angle, self.dihedral_name(group)))
    }
}

fn group_of(clusters: &[Cluster], count: usize) -> Vec<usize> {
    let mut group = vec![0; count];
    for (k, cluster) in clusters.iter().enumerate() {
        cluster.members.iter().for_each(|&m| group[m] = k);
    }
    group
}

fn dihedrals(mesh: &HexMesh, edges: &[EdgeId]) -> Vec<f64> {
    let flat = FlatFace::all(mesh);
    let topology = mesh.topology();
    let angle = |&edge: &EdgeId| {
        let Some(beside) = topology.faces_beside(edge) else {
            return PI;
        };
        let [a, b] = beside.map(|f| flat[f].normal());
        let h = topology.edge_half_edge(edge);
        let along =
            (mesh.position(topology.target(h)) - mesh.position(topology.origin(h))).normalize();
        PI - a.cross(&b).dot(&along).atan2(a.dot(&b))
    };
    edges.iter().map(angle).collect()
}
