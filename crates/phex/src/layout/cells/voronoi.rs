//! Geodesic Voronoi cells of seed vertices on an intrinsic triangle mesh.
//!
//! Fronts grow as in Dijkstra's algorithm; across a triangle whose two known corners belong to the
//! same seed the distance comes from unfolding the seed into the triangle's plane (the virtual
//! source of Novotni and Klein, 2002), which makes cells as straight as the triangulation allows.

use crate::directions::intrinsic::IntrinsicMesh;
use crate::layout::seeds::Seed;
use phex_mesh::{HalfEdgeId, PerVertex, Topology, VertexId};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Label of a vertex that no seed reaches.
pub(crate) const UNREACHED: u32 = u32::MAX;

/// Cells of seeds: for each vertex the number of the nearest seed and the distance to it.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    /// Number of the seed, or [`UNREACHED`].
    pub label: PerVertex<u32>,
    /// Distance to it in intrinsic lengths.
    pub distance: PerVertex<f64>,
}

/// Distance, label and vertex in one number, which sorts by them in this order: comparing is most
/// of what the heap does.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Front(u128);

impl Front {
    /// Bits of numbers that are not negative sort as the numbers do.
    fn new(distance: f64, label: u32, vertex: VertexId) -> Self {
        let low = (u64::from(label) << 32) | vertex.index() as u64;
        Self((u128::from(distance.to_bits()) << 64) | u128::from(low))
    }

    fn label(self) -> u32 {
        (self.0 >> 32) as u32
    }

    fn vertex(self) -> VertexId {
        VertexId::new(self.0 as u32)
    }
}

/// Grows cells over all vertices.
pub(crate) fn grow(topology: &Topology, mesh: &IntrinsicMesh, seeds: &[Seed]) -> Cells {
    let (mut cells, mut settled) = nothing_grown(topology);
    spread(
        topology,
        mesh,
        seeds.iter().enumerate(),
        &mut cells,
        &mut settled,
    );
    cells
}

fn nothing_grown(topology: &Topology) -> (Cells, PerVertex<bool>) {
    let n = topology.n_vertices();
    let cells = Cells {
        label: PerVertex::filled(n, UNREACHED),
        distance: PerVertex::filled(n, f64::INFINITY),
    };
    (cells, PerVertex::filled(n, false))
}

/// Cells in small parts of a surface, one part after the other: each costs what its size is.
pub(in crate::layout) struct PartCells<'a> {
    topology: &'a Topology,
    mesh: &'a IntrinsicMesh,
    cells: Cells,
    /// What lies outside the part is settled, and nobody's.
    settled: PerVertex<bool>,
}

impl<'a> PartCells<'a> {
    pub fn new(topology: &'a Topology, mesh: &'a IntrinsicMesh) -> Self {
        let (cells, settled) = nothing_grown(topology);
        Self {
            topology,
            mesh,
            cells,
            settled: settled.map(|_| true),
        }
    }

    /// Number of the nearest of some seeds and the distance to it, of the vertices of a part.
    pub fn grow(&mut self, seeds: &[Seed], part: &[VertexId]) -> Vec<(u32, f64)> {
        part.iter().for_each(|v| self.settled[*v] = false);
        let all = seeds.iter().enumerate();
        spread(
            self.topology,
            self.mesh,
            all,
            &mut self.cells,
            &mut self.settled,
        );
        let (cells, settled) = (&mut self.cells, &mut self.settled);
        let found = part.iter().map(|v| {
            settled[*v] = true;
            let label = std::mem::replace(&mut cells.label[*v], UNREACHED);
            (
                label,
                std::mem::replace(&mut cells.distance[*v], f64::INFINITY),
            )
        });
        found.collect()
    }
}

/// Grows the cells of `labels` again, and those round them up to the second neighbours: what is
/// farther stays as it is, for a cell changes no border but its own. `number` is the new number of
/// each old cell, `None` for those whose seeds are gone.
pub(crate) fn regrow(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    seeds: &[Seed],
    before: &Cells,
    labels: impl Iterator<Item = usize>,
    number: &[Option<u32>],
) -> Cells {
    let mut open = vec![false; number.len()];
    labels.for_each(|l| open[l] = true);
    for _ in 0..2 {
        widen(topology, &before.label, &mut open);
    }
    let is_open = |v: VertexId| open.get(before.label[v] as usize).is_none_or(|o| *o);
    let mut cells = before.clone();
    let mut settled = PerVertex::filled(topology.n_vertices(), true);
    for v in topology.vertices() {
        let new = number.get(before.label[v] as usize).copied().flatten();
        cells.label[v] = new.unwrap_or(UNREACHED);
        if is_open(v) {
            cells.label[v] = UNREACHED;
            cells.distance[v] = f64::INFINITY;
            settled[v] = false;
        }
    }
    let opened = number.iter().zip(&open).filter(|(_, o)| **o);
    let opened = opened.filter_map(|(n, _)| *n);
    let opened = opened.map(|n| (n as usize, &seeds[n as usize]));
    spread(topology, mesh, opened, &mut cells, &mut settled);
    cells
}

/// Marks the cells beside those that are marked.
fn widen(topology: &Topology, label: &PerVertex<u32>, open: &mut [bool]) {
    let marked = open.to_vec();
    let is = |l: u32| marked.get(l as usize).is_some_and(|m| *m);
    for [a, b] in topology.edges().map(|e| topology.edge_vertices(e)) {
        for (from, to) in [(label[a], label[b]), (label[b], label[a])] {
            if let (true, Some(to)) = (is(from), open.get_mut(to as usize)) {
                *to = true;
            }
        }
    }
}

/// Lets fronts grow from seeds over what is not settled.
fn spread<'a>(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    seeds: impl Iterator<Item = (usize, &'a Seed)>,
    cells: &mut Cells,
    settled: &mut PerVertex<bool>,
) {
    let mut heap = BinaryHeap::new();
    for (label, seed) in seeds {
        for &(vertex, distance) in &seed.core {
            if distance < cells.distance[vertex] {
                cells.distance[vertex] = distance;
                cells.label[vertex] = label as u32;
                heap.push(Reverse(Front::new(distance, label as u32, vertex)));
            }
        }
    }
    while let Some(Reverse(front)) = heap.pop() {
        let (v, label) = (front.vertex(), front.label());
        if settled[v] || label != cells.label[v] {
            continue;
        }
        settled[v] = true;
        for h in topology.outgoing(v) {
            // The two other corners of the triangle, each reached from `v` alone and with the help
            // of the third corner.
            let (a, b) = (topology.target(h), topology.origin(topology.prev(h)));
            for (to, third) in [(a, b), (b, a)] {
                if settled[to] {
                    continue;
                }
                let distance = reach(topology, mesh, (cells, settled), h, [to, third]);
                if (distance, label) < (cells.distance[to], cells.label[to]) {
                    cells.distance[to] = distance;
                    cells.label[to] = label;
                    heap.push(Reverse(Front::new(distance, label, to)));
                }
            }
        }
    }
}

/// The distance at which a front that has come to the origin of a half-edge reaches another corner
/// of its triangle, given before the third one.
fn reach(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    (cells, settled): (&Cells, &PerVertex<bool>),
    h: HalfEdgeId,
    [to, third]: [VertexId; 2],
) -> f64 {
    let v = topology.origin(h);
    let side = |h| mesh.length[topology.edge(h)];
    let (to_a, between, to_b) = (side(h), side(topology.next(h)), side(topology.prev(h)));
    let (v_to, v_third) = if to == topology.target(h) {
        (to_a, to_b)
    } else {
        (to_b, to_a)
    };
    let along_edge = cells.distance[v] + v_to;
    if !settled[third] || cells.label[third] != cells.label[v] {
        return along_edge;
    }
    let unfolded = unfold(
        v_third,
        v_to,
        between,
        cells.distance[v],
        cells.distance[third],
    );
    unfolded.map_or(along_edge, |d| d.min(along_edge))
}

/// Distance from a virtual source, at `dv` and `dt` from the ends `v` and `t` of an edge of length
/// `edge`, to the apex on the other side, at `va` and `ta` from them; `None` if the straight line
/// does not cross the edge.
fn unfold(edge: f64, va: f64, ta: f64, dv: f64, dt: f64) -> Option<f64> {
    let foot = |p: f64, q: f64| (p * p - q * q + edge * edge) / (2.0 * edge);
    let (xs, xa) = (foot(dv, dt), foot(va, ta));
    let (ys2, ya2) = (dv * dv - xs * xs, va * va - xa * xa);
    if ys2 < 0.0 || ya2 <= 0.0 {
        return None;
    }
    let (ys, ya) = (ys2.sqrt(), ya2.sqrt());
    let crossing = xs + (xa - xs) * ys / (ys + ya);
    (crossing >= 0.0 && crossing <= edge).then(|| (xa - xs).hypot(ys + ya))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unfolding_measures_the_straight_line() {
        // Source (0.3, -1), edge (0,0)-(1,0), apex (0.5, 0.8).
        let d = |a: (f64, f64), b: (f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
        let (s, v, t, a) = ((0.3, -1.0), (0.0, 0.0), (1.0, 0.0), (0.5, 0.8));
        let got = unfold(1.0, d(v, a), d(t, a), d(s, v), d(s, t)).unwrap();
        assert!((got - d(s, a)).abs() < 1e-12);
        // A source far to the side does not see the apex through the edge.
        let s = (-5.0, -0.1);
        assert_eq!(unfold(1.0, d(v, a), d(t, a), d(s, v), d(s, t)), None);
    }
}
