//! Seeds of a neighbourhood changed: dropped, added, or spread anew.
//!
//! Spreading is Lloyd's iteration in the metric (Du, Faber and Gunzburger 1999): cells grow from the seeds that may move and from a
//! ring round them that may not, and every seed goes to the middle of its cell. Further seeds start where the others are
//! farthest. Outside the ring nothing changes.

use super::CellSurface;
use super::seeds::Seed;
use super::voronoi::{self, Cells, UNREACHED};
use phex_mesh::{Vec3, VertexId};
use std::collections::BTreeSet;

/// Steps of Lloyd's iteration.
const STEPS: usize = 8;

/// What becomes of the seeds of a neighbourhood.
#[derive(Clone, Debug, Default)]
pub struct Reseeded {
    /// Seeds that go.
    pub removed: Vec<Seed>,
    /// Seeds that come.
    pub added: Vec<Seed>,
}

impl Reseeded {
    /// The seeds with the change made, in the order of their vertices.
    pub fn apply(&self, seeds: &mut Vec<Seed>) {
        replace(seeds, &self.removed, &self.added);
    }

    /// The seeds as they were before.
    pub fn undo(&self, seeds: &mut Vec<Seed>) {
        replace(seeds, &self.added, &self.removed);
    }
}

fn replace(seeds: &mut Vec<Seed>, old: &[Seed], new: &[Seed]) {
    let gone: BTreeSet<VertexId> = old.iter().map(|s| s.vertex).collect();
    seeds.retain(|s| !gone.contains(&s.vertex));
    seeds.extend_from_slice(new);
    seeds.sort_by_key(|s| s.vertex);
    seeds.dedup_by_key(|s| s.vertex);
}

/// Seeds with their cells and which of them are neighbours.
pub struct Neighbourhoods<'a> {
    fine: &'a CellSurface<'a>,
    seeds: &'a [Seed],
    cells: Cells,
    beside: Vec<BTreeSet<u32>>,
}

impl<'a> Neighbourhoods<'a> {
    /// Those of all seeds.
    pub fn new(fine: &'a CellSurface<'a>, seeds: &'a [Seed]) -> Self {
        let topology = fine.surface.topology();
        let cells = voronoi::grow(topology, fine.mesh, seeds, |_| true);
        let mut beside = vec![BTreeSet::new(); seeds.len()];
        for e in topology.edges() {
            let [a, b] = topology.edge_vertices(e).map(|v| cells.label[v]);
            if a != b && a != UNREACHED && b != UNREACHED {
                beside[a as usize].insert(b);
                beside[b as usize].insert(a);
            }
        }
        Self {
            fine,
            seeds,
            cells,
            beside,
        }
    }

    /// Number of the seed in whose cell a vertex lies.
    pub fn seed_at(&self, v: VertexId) -> Option<u32> {
        let label = self.cells.label[v];
        (label != UNREACHED).then_some(label)
    }

    /// Some seeds and their neighbours.
    pub fn with_ring(&self, seeds: &BTreeSet<u32>) -> BTreeSet<u32> {
        let around = seeds.iter().flat_map(|s| &self.beside[*s as usize]);
        around.chain(seeds).copied().collect()
    }

    /// Seeds dropped, never two neighbours: one of them grows into the gap.
    pub fn dropped(&self, seeds: &BTreeSet<u32>) -> Reseeded {
        let mut chosen: BTreeSet<u32> = BTreeSet::new();
        for &s in seeds {
            if self.beside[s as usize].is_disjoint(&chosen) {
                chosen.insert(s);
            }
        }
        Reseeded {
            removed: self.named(&chosen),
            added: Vec::new(),
        }
    }

    /// A seed more.
    pub fn added(&self, at: VertexId) -> Reseeded {
        Reseeded {
            removed: Vec::new(),
            added: vec![Seed::at(at)],
        }
    }

    /// Seeds spread anew, with some vertices in addition as seeds, and then as many more as `count` asks for in all; or the
    /// last ones left out where it asks for fewer.
    pub fn spread(&self, moving: &BTreeSet<u32>, more: &[VertexId], count: usize) -> Reseeded {
        let all = self.with_ring(moving);
        let fixed: Vec<Seed> = self.named(&all.difference(moving).copied().collect());
        let old = self.named(moving);
        let mut own: Vec<Seed> = more.iter().map(|v| Seed::at(*v)).collect();
        own.extend(old.iter().cloned());
        own.dedup_by_key(|s| s.vertex);
        own.truncate(count.max(1));
        while own.len() < count {
            match self.farthest(&self.grown(&own, &fixed, &all)) {
                Some(v) => own.push(Seed::at(v)),
                None => break,
            }
        }
        for _ in 0..STEPS {
            let cells = self.grown(&own, &fixed, &all);
            let middles = self.middles(&cells, own.len());
            own = middles.into_iter().flatten().map(Seed::at).collect();
        }
        Reseeded {
            removed: old,
            added: own,
        }
    }

    fn named(&self, seeds: &BTreeSet<u32>) -> Vec<Seed> {
        let seed = |s: &u32| self.seeds[*s as usize].clone();
        seeds.iter().map(seed).collect()
    }

    /// Cells of seeds within the cells that others had.
    fn grown(&self, own: &[Seed], fixed: &[Seed], within: &BTreeSet<u32>) -> Cells {
        let seeds: Vec<Seed> = own.iter().chain(fixed).cloned().collect();
        let topology = self.fine.surface.topology();
        let inside = |v: VertexId| within.contains(&self.cells.label[v]);
        voronoi::grow(topology, self.fine.mesh, &seeds, inside)
    }

    fn farthest(&self, cells: &Cells) -> Option<VertexId> {
        let reached = cells.distance.enumerate().filter(|(_, d)| d.is_finite());
        let farthest = reached.max_by(|a, b| a.1.total_cmp(b.1).then(b.0.cmp(&a.0)));
        farthest.filter(|(_, d)| **d > 0.0).map(|(v, _)| v)
    }

    /// The vertex nearest to the centroid of each of the first cells.
    fn middles(&self, cells: &Cells, count: usize) -> Vec<Option<VertexId>> {
        let (positions, mass) = (self.fine.surface.positions(), &self.fine.mesh.mass);
        let mut members: Vec<Vec<VertexId>> = vec![Vec::new(); count];
        for (v, &label) in cells.label.enumerate() {
            if let Some(cell) = members.get_mut(label as usize) {
                cell.push(v);
            }
        }
        let middle = |cell: Vec<VertexId>| {
            let total: f64 = cell.iter().map(|v| mass[*v]).sum();
            let sum: Vec3 = cell.iter().map(|v| positions[*v] * mass[*v]).sum();
            let centroid = sum / total.max(f64::MIN_POSITIVE);
            let distance = |v: &VertexId| (positions[*v] - centroid).norm_squared();
            cell.into_iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        };
        members.into_iter().map(middle).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::directions::intrinsic::IntrinsicMesh;
    use nalgebra::Matrix3;
    use phex_mesh::{PerVertex, TriangleSurface};
    use std::collections::HashSet;

    const SIDE: u32 = 21;

    fn square() -> TriangleSurface {
        let at = |v: u32| Vec3::new(f64::from(v % SIDE), f64::from(v / SIDE), 0.0) * 0.25;
        let n = SIDE - 1;
        let cells = (0..n * n).map(|c| c % n + (c / n) * SIDE);
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|a| [[a, a + 1, a + SIDE + 1], [a, a + SIDE + 1, a + SIDE]])
            .collect();
        TriangleSurface::new((0..SIDE * SIDE).map(at).collect(), &triangles).unwrap()
    }

    /// Calls `f` with 25 seeds on a flat square and their neighbourhoods.
    fn with_square(f: impl FnOnce(&[Seed], &Neighbourhoods<'_>)) {
        let surface = square();
        let metric = PerVertex::filled(surface.positions().len(), Matrix3::identity());
        let mesh = IntrinsicMesh::new(&surface, &metric);
        let fine = CellSurface {
            surface: &surface,
            metric: &metric,
            mesh: &mesh,
            corners: &HashSet::new(),
        };
        let rows = (0..5).flat_map(|j| (0..5).map(move |i| (2 + 4 * i) + SIDE * (2 + 4 * j)));
        let seeds: Vec<Seed> = rows.map(|v| Seed::at(VertexId::new(v))).collect();
        f(&seeds, &Neighbourhoods::new(&fine, &seeds));
    }

    #[test]
    fn changes_can_be_taken_back() {
        with_square(|seeds, around| {
            let moving = around.with_ring(&BTreeSet::from([12]));
            assert!(moving.len() >= 5 && moving.len() <= 9);
            for count in [moving.len() - 1, moving.len(), 2 * moving.len()] {
                let change = around.spread(&moving, &[], count);
                assert_eq!(change.removed.len(), moving.len());
                assert_eq!(change.added.len(), count);
                let mut now = seeds.to_vec();
                change.apply(&mut now);
                assert_eq!(now.len(), seeds.len() - moving.len() + count);
                change.undo(&mut now);
                assert_eq!(now, seeds);
            }
        });
    }

    #[test]
    fn a_seed_that_stands_off_goes_towards_the_middle_of_its_cell() {
        with_square(|seeds, around| {
            let middle = seeds[12].vertex.index() as u32;
            let alone = BTreeSet::from([12]);
            let change = around.spread(&alone, &[VertexId::new(middle + 2)], 1);
            // The middle of the cell that grows from between two vertices may be either of them.
            let [seed] = &change.added[..] else {
                panic!("one seed for one");
            };
            assert!((seed.vertex.index() as u32).abs_diff(middle) <= 1);
            assert_eq!(change.removed, [seeds[12].clone()]);
        });
    }

    #[test]
    fn neighbours_are_not_dropped_together() {
        with_square(|_, around| {
            let all: BTreeSet<u32> = (0..25).collect();
            let gone = around.dropped(&all).removed;
            assert!(gone.len() > 3 && gone.len() < 15);
            let labels: BTreeSet<u32> = gone
                .iter()
                .filter_map(|s| around.seed_at(s.vertex))
                .collect();
            for label in &labels {
                let beside = around.with_ring(&BTreeSet::from([*label]));
                assert_eq!(beside.intersection(&labels).count(), 1);
            }
        });
    }
}
