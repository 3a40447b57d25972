//! Clusters of vertices that name the same lattice point, and a seed vertex for each.

use super::voronoi::PartCells;
use crate::layout::lattice::charted::ChartedSurface;
use crate::layout::lattice::eisenstein::CELL;
use crate::layout::lattice::seamless::Offsets;
use crate::layout::seeds::{CORE, Seed};
use phex_mesh::{PerEdge, PerVertex, Topology, VertexId};
use std::collections::BTreeMap;

/// Clusters smaller than this share of a lattice cell get no seed.
const MIN_AREA: f64 = 0.35;
/// The same at the boundary, where cells are cut.
const MIN_BOUNDARY_AREA: f64 = 0.25;
/// Clusters larger than this many cells are split.
const SPLIT_AREA: f64 = 1.75;

/// Lattice points nearer to each other than this are one point, seen twice across a cone.
const SAME_POINT: f64 = 0.6;

/// One seed per panel, in the order of their vertices.
pub(crate) fn seeds(charted: &ChartedSurface<'_>, offsets: &Offsets) -> Vec<Seed> {
    let (topology, mesh) = (charted.topology, charted.mesh);
    let same = offsets.same_point(charted, SAME_POINT);
    let label = clusters(topology, &same);
    let count = label.iter().map(|l| *l as usize + 1).max().unwrap_or(0);
    let mut area = vec![0.0; count];
    let mut touches_boundary = vec![false; count];
    let mut images = vec![1; count];
    let mut centre: Vec<Option<VertexId>> = vec![None; count];
    for v in topology.vertices() {
        let c = label[v] as usize;
        area[c] += mesh.mass[v];
        touches_boundary[c] |= topology.is_boundary_vertex(v);
        images[c] = images[c].max(mesh.multiplicity[v]);
        let distance = |w: VertexId| offsets.position[w].norm_sqr();
        if centre[c].is_none_or(|w| distance(v) < distance(w)) {
            centre[c] = Some(v);
        }
    }
    let mut seeds = Vec::new();
    for c in 0..count {
        let share = area[c] * f64::from(images[c]) / CELL;
        if share > MIN_AREA || (touches_boundary[c] && share > MIN_BOUNDARY_AREA) {
            seeds.extend(centre[c].map(|vertex| Seed {
                vertex,
                core: Vec::new(),
            }));
        }
    }
    fill_cores(topology, offsets, &label, &mut seeds);
    let is_large = |c: usize| area[c] > SPLIT_AREA * CELL;
    let mut large: BTreeMap<u32, LargeCluster> = BTreeMap::new();
    for (v, &c) in label.enumerate().filter(|(_, c)| is_large(**c as usize)) {
        large.entry(c).or_default().members.push(v);
    }
    for seed in &seeds {
        if let Some(cluster) = large.get_mut(&label[seed.vertex]) {
            cluster.seeds.push(seed.clone());
        }
    }
    let mut cells = PartCells::new(topology, mesh);
    for (c, cluster) in large {
        let extra = (area[c as usize] / CELL).round() as usize - 1;
        seeds.extend(cluster.split(extra, &mut cells));
    }
    seeds.sort_by_key(|s| s.vertex);
    seeds.dedup_by_key(|s| s.vertex);
    seeds
}

/// Collects the vertices near each lattice point, connected to the seed: near a cone a cluster may
/// see its point twice.
fn fill_cores(topology: &Topology, offsets: &Offsets, label: &PerVertex<u32>, seeds: &mut [Seed]) {
    let mut seen = PerVertex::filled(topology.n_vertices(), false);
    for seed in seeds {
        let reach = CORE.max(offsets.position[seed.vertex].norm() + 0.05);
        let mut stack = vec![seed.vertex];
        seen[seed.vertex] = true;
        while let Some(v) = stack.pop() {
            seed.core.push((v, offsets.position[v].norm()));
            for w in topology.neighbours(v) {
                let same = label[w] == label[seed.vertex];
                if same && !seen[w] && offsets.position[w].norm() < reach {
                    seen[w] = true;
                    stack.push(w);
                }
            }
        }
    }
}

/// Number of the cluster of each vertex: connected by edges whose ends name the same point.
fn clusters(topology: &Topology, same: &PerEdge<bool>) -> PerVertex<u32> {
    const NONE: u32 = u32::MAX;
    let mut label = PerVertex::filled(topology.n_vertices(), NONE);
    let mut count = 0;
    let mut stack = Vec::new();
    for start in topology.vertices() {
        if label[start] != NONE {
            continue;
        }
        label[start] = count;
        stack.push(start);
        while let Some(v) = stack.pop() {
            for (edge, other) in topology.spokes(v) {
                if same[edge] && label[other] == NONE {
                    label[other] = count;
                    stack.push(other);
                }
            }
        }
        count += 1;
    }
    label
}

/// A cluster that is larger than a cell.
#[derive(Default)]
struct LargeCluster {
    members: Vec<VertexId>,
    seeds: Vec<Seed>,
}

impl LargeCluster {
    /// At most `extra` seeds more, each the vertex farthest from those that there are.
    fn split(mut self, extra: usize, cells: &mut PartCells<'_>) -> Vec<Seed> {
        let given = self.seeds.len();
        for _ in 0..if given == 0 { 0 } else { extra } {
            let grown = cells.grow(&self.seeds, &self.members);
            let reached = self
                .members
                .iter()
                .zip(grown)
                .filter(|(_, g)| g.1.is_finite());
            let farthest = reached.max_by(|(v, a), (w, b)| a.1.total_cmp(&b.1).then(w.cmp(v)));
            match farthest {
                Some((v, (_, d))) if d > 0.0 => self.seeds.push(Seed::at(*v)),
                _ => break,
            }
        }
        self.seeds.split_off(given)
    }
}
