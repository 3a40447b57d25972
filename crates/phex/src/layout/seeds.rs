//! Clusters of vertices that name the same lattice point, and a seed vertex for each.

use super::lattice::CELL;
use super::seamless::Offsets;
use super::voronoi;
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{PerVertex, Topology, VertexId};

/// Clusters smaller than this share of a lattice cell get no seed.
const MIN_AREA: f64 = 0.35;
/// The same at the boundary, where cells are cut.
const MIN_BOUNDARY_AREA: f64 = 0.25;
/// Clusters larger than this many cells are split.
const SPLIT_AREA: f64 = 1.75;

/// One seed vertex per panel, in the order of the vertices.
pub fn seeds(topology: &Topology, mesh: &IntrinsicMesh, offsets: &Offsets) -> Vec<VertexId> {
    let label = clusters(topology, offsets);
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
            seeds.extend(centre[c]);
        }
    }
    let large: Vec<usize> = (0..count).filter(|&c| area[c] > SPLIT_AREA * CELL).collect();
    for c in large {
        let extra = (area[c] / CELL).round() as usize - 1;
        split(topology, mesh, &label, c as u32, extra, &mut seeds);
    }
    seeds.sort();
    seeds.dedup();
    seeds
}

/// Number of the cluster of each vertex: connected by edges without jump.
fn clusters(topology: &Topology, offsets: &Offsets) -> PerVertex<u32> {
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
                    let other = if topology.origin(h) == v { topology.target(h) } else { topology.origin(h) };
                    let joined = offsets.jump[topology.edge(h)] == super::lattice::Eisenstein::ZERO;
                    if joined && label[other] == NONE {
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
    seeds: &mut Vec<VertexId>,
) {
    for _ in 0..extra {
        let own: Vec<VertexId> = seeds.iter().copied().filter(|&s| label[s] == cluster).collect();
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
            Some((v, d)) if d > 0.0 => seeds.push(v),
            _ => return,
        }
    }
    debug_assert!(seeds.iter().all(|s| s.index() < topology.n_vertices()));
}
