//! Clusters of vertices that name the same lattice point, and a seed vertex for each.

use super::lattice::{CELL, Charts};
use super::seamless::Offsets;
use super::seeds::{CORE, Seed};
use super::voronoi;
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{PerEdge, PerVertex, Topology, VertexId};

/// Clusters smaller than this share of a lattice cell get no seed.
const MIN_AREA: f64 = 0.35;
/// The same at the boundary, where cells are cut.
const MIN_BOUNDARY_AREA: f64 = 0.25;
/// Clusters larger than this many cells are split.
const SPLIT_AREA: f64 = 1.75;

/// Lattice points nearer to each other than this are one point, seen twice across a cone.
const SAME_POINT: f64 = 0.6;

/// One seed per panel, in the order of their vertices.
pub(crate) fn seeds(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    offsets: &Offsets,
) -> Vec<Seed> {
    let same = offsets.same_point(topology, charts, SAME_POINT);
    let label = clusters(topology, &same);
    let count = label.iter().map(|l| *l as usize + 1).max().unwrap_or(0);
    let mut area = vec![0.0; count];
    let mut touches_boundary = vec![false; count];
    let mut centre: Vec<Option<VertexId>> = vec![None; count];
    for v in topology.vertices() {
        let c = label[v] as usize;
        area[c] += mesh.mass[v];
        touches_boundary[c] |= topology.is_boundary_vertex(v);
        let distance = |w: VertexId| offsets.position[w].norm_sqr();
        if centre[c].is_none_or(|w| distance(v) < distance(w)) {
            centre[c] = Some(v);
        }
    }
    let mut seeds = Vec::new();
    for c in 0..count {
        let share = area[c] / CELL;
        if share > MIN_AREA || (touches_boundary[c] && share > MIN_BOUNDARY_AREA) {
            seeds.extend(centre[c].map(|vertex| Seed {
                vertex,
                core: Vec::new(),
            }));
        }
    }
    fill_cores(topology, offsets, &label, &mut seeds);
    let large: Vec<usize> = (0..count)
        .filter(|&c| area[c] > SPLIT_AREA * CELL)
        .collect();
    for c in large {
        let extra = (area[c] / CELL).round() as usize - 1;
        split(topology, mesh, &label, c as u32, extra, &mut seeds);
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
            for h in topology.outgoing(v) {
                for h in [h, topology.prev(h)] {
                    let other = if topology.origin(h) == v {
                        topology.target(h)
                    } else {
                        topology.origin(h)
                    };
                    if same[topology.edge(h)] && label[other] == NONE {
                        label[other] = count;
                        stack.push(other);
                    }
                }
            }
        }
        count += 1;
    }
    label
}

/// Adds `extra` seeds to a cluster, each the vertex farthest from the seeds that it has.
fn split(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    label: &PerVertex<u32>,
    cluster: u32,
    extra: usize,
    seeds: &mut Vec<Seed>,
) {
    for _ in 0..extra {
        let own: Vec<Seed> = seeds
            .iter()
            .filter(|s| label[s.vertex] == cluster)
            .cloned()
            .collect();
        if own.is_empty() {
            return;
        }
        let cells = voronoi::grow(topology, mesh, &own, |v| label[v] == cluster);
        let farthest = label
            .enumerate()
            .filter(|(_, l)| **l == cluster)
            .map(|(v, _)| (v, cells.distance[v]))
            .filter(|(_, d)| d.is_finite())
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
        match farthest {
            Some((v, d)) if d > 0.0 => seeds.push(Seed::at(v)),
            _ => return,
        }
    }
}
