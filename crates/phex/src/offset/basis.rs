//! A sparse basis of the space of parallel meshes.
//!
//! Every edge in turn, numbered breadth first, is asked whether its length can change while only
//! edges near it with lower numbers change too; *near* grows until they say yes. An elimination
//! tells beforehand which edges can. Vectors found so are independent, since each has a last edge
//! of its own. Source: Berry, Heath, Kaneko, Lawo, Plemmons, Ward, "An algorithm to compute a
//! sparse basis of the null space" (1985): turnback.

use super::null_space::{NullSpace, Rows};
use super::space::ParallelSpace;
use phex_mesh::{EdgeId, PerEdge};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Square of an edge's share in the closest vector, from which on it can change.
const CAN_CHANGE: f64 = 1e-7;
/// The same where there is nothing better.
const CAN_HARDLY_CHANGE: f64 = 1e-12;
/// Entry, over the largest of its column, up to which the elimination takes it for nothing.
const DEPENDENT: f64 = 1e-9;
/// Changes below this, over the largest, are none.
const NONE: f64 = 1e-12;

/// Changes of edge lengths after which every face still closes; edges that are not named keep
/// theirs.
pub type LengthChange = Vec<(EdgeId, f64)>;

impl ParallelSpace {
    /// As many independent changes of the edge lengths as the space has dimensions, each of few
    /// edges that lie together where there are such; the last edge of each changes by 1. On a mesh
    /// with holes a few of them go round the holes.
    pub fn basis(&self) -> Vec<LengthChange> {
        let search = Search::new(self);
        let dimension = self.dimension();
        let mut found: BTreeMap<usize, LengthChange> = BTreeMap::new();
        let likely = search.dependent_columns();
        search.extend(&mut found, &likely, dimension, CAN_CHANGE);
        // Where faces have sharp corners, an edge may have to change little and others much.
        search.extend(&mut found, &likely, dimension, CAN_HARDLY_CHANGE);
        // Rounding may hide some from the elimination.
        let all: Vec<usize> = (0..search.order.len()).collect();
        search.extend(&mut found, &all, dimension, CAN_CHANGE);
        found.into_values().collect()
    }
}

/// The closure equations by columns, and who is near whom.
struct Search {
    columns: Vec<Vec<(u32, f64)>>,
    /// Edges, breadth first.
    order: Vec<EdgeId>,
    /// Where an edge is in that order.
    number: PerEdge<usize>,
    /// The other edges of the faces at an edge.
    neighbours: PerEdge<Vec<EdgeId>>,
}

impl Search {
    fn new(space: &ParallelSpace) -> Self {
        let topology = space.mesh().topology();
        let neighbours = PerEdge::from_fn(topology.n_edges(), |e| {
            let around = (topology.edge_faces(e)).flat_map(|f| topology.face_half_edges(f));
            around
                .map(|h| topology.edge(h))
                .filter(|&other| other != e)
                .collect::<Vec<_>>()
        });
        let mut order = Vec::with_capacity(topology.n_edges());
        let mut seen = PerEdge::filled(topology.n_edges(), false);
        for root in topology.edges() {
            if !seen[root] {
                order.extend(within(&neighbours, root, usize::MAX, &mut seen));
            }
        }
        let mut number = PerEdge::filled(order.len(), 0);
        for (k, &e) in order.iter().enumerate() {
            number[e] = k;
        }
        Self {
            columns: space.closure_rows().columns(),
            order,
            number,
            neighbours,
        }
    }

    /// Finds changes that end with one of `lasts` until there are as many as dimensions.
    fn extend(
        &self,
        found: &mut BTreeMap<usize, LengthChange>,
        lasts: &[usize],
        dimension: usize,
        least: f64,
    ) {
        let mut radius = 1;
        while found.len() < dimension && radius <= 2 * self.order.len() {
            let open: Vec<usize> = lasts
                .iter()
                .copied()
                .filter(|k| !found.contains_key(k))
                .collect();
            let tried: Vec<_> = open
                .par_iter()
                .map(|&last| (last, self.change(last, radius, least)))
                .collect();
            let yes = tried
                .into_iter()
                .filter_map(|(last, c)| c.map(|c| (last, c)));
            found.extend(yes.take(dimension - found.len()));
            radius += 1 + radius / 2;
        }
    }

    /// Edges, by number, whose column depends on those with lower numbers: left-looking elimination
    /// with partial pivoting.
    fn dependent_columns(&self) -> Vec<usize> {
        let mut pivots: Vec<Pivot> = Vec::new();
        let mut pivot_of_row = BTreeMap::new();
        let mut dependent = Vec::new();
        for (number, e) in self.order.iter().enumerate() {
            let mut column = Remainder::default();
            for &(row, entry) in &self.columns[e.index()] {
                column.add(row, entry, &pivot_of_row);
            }
            let size = column.largest().map_or(0.0, |(_, entry)| entry.abs());
            while let Some(next) = column.due.pop_first() {
                let pivot: &Pivot = &pivots[next];
                let factor = column.entries.remove(&pivot.row).unwrap_or(0.0);
                for &(row, entry) in &pivot.others {
                    column.add(row, -factor * entry, &pivot_of_row);
                }
            }
            match column.largest().filter(|(_, p)| p.abs() > DEPENDENT * size) {
                Some((row, by)) => {
                    column.entries.remove(&row);
                    let others = column.entries.into_iter().map(|(r, x)| (r, x / by));
                    pivot_of_row.insert(row, pivots.len());
                    pivots.push(Pivot {
                        row,
                        others: others.collect(),
                    });
                }
                None => dependent.push(number),
            }
        }
        dependent
    }

    /// The change that ends with an edge and reaches `radius` faces far at the most, if there is
    /// one.
    fn change(&self, last: usize, radius: usize, least: f64) -> Option<LengthChange> {
        let root = self.order[last];
        let mut seen = PerEdge::filled(self.order.len(), false);
        let mut near = within(&self.neighbours, root, radius, &mut seen);
        near.retain(|&e| self.number[e] <= last);
        let change = |n: usize| self.change_of_first(&near[..n], least);
        let mut found = change(near.len())?;
        // As few of them as will do: the change is then the only one there is.
        let mut range = 1..near.len();
        while !range.is_empty() {
            let middle = range.start + range.len() / 2;
            match change(middle) {
                Some(smaller) => (found, range.end) = (smaller, middle),
                None => range.start = middle + 1,
            }
        }
        Some(found)
    }

    /// The change of some edges that is closest to one of the first of them alone, if that can
    /// change.
    fn change_of_first(&self, edges: &[EdgeId], least: f64) -> Option<LengthChange> {
        let space = NullSpace::new(self.rows(edges)).ok()?;
        let mut x = vec![0.0; edges.len()];
        x[0] = 1.0;
        space.project(&mut x);
        let own = x[0];
        let largest = x.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        (own > least).then(|| {
            let changes = edges
                .iter()
                .zip(&x)
                .filter(|(_, x)| x.abs() > NONE * largest);
            changes.map(|(&e, x)| (e, x / own)).collect()
        })
    }

    /// The equations that hold some edges, in their columns alone.
    fn rows(&self, edges: &[EdgeId]) -> Rows {
        let mut by_row: BTreeMap<u32, Vec<(usize, f64)>> = BTreeMap::new();
        for (k, e) in edges.iter().enumerate() {
            for &(row, entry) in &self.columns[e.index()] {
                by_row.entry(row).or_default().push((k, entry));
            }
        }
        let mut rows = Rows::new(edges.len());
        by_row.into_values().for_each(|row| rows.push(row));
        rows
    }
}

/// A column of the elimination, over its entry in its own row.
struct Pivot {
    row: u32,
    /// Entries in rows that were nobody's own.
    others: Vec<(u32, f64)>,
}

/// What is left of a column, and which pivots it still has to be reduced by.
#[derive(Default)]
struct Remainder {
    entries: BTreeMap<u32, f64>,
    due: BTreeSet<usize>,
}

impl Remainder {
    fn add(&mut self, row: u32, by: f64, pivot_of_row: &BTreeMap<u32, usize>) {
        *self.entries.entry(row).or_insert(0.0) += by;
        self.due.extend(pivot_of_row.get(&row));
    }

    fn largest(&self) -> Option<(u32, f64)> {
        let entries = self.entries.iter().map(|(&row, &entry)| (row, entry));
        entries.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    }
}

/// Edges up to `radius` faces away from an edge, which comes first, that have not been seen.
fn within(
    neighbours: &PerEdge<Vec<EdgeId>>,
    root: EdgeId,
    radius: usize,
    seen: &mut PerEdge<bool>,
) -> Vec<EdgeId> {
    seen[root] = true;
    let mut found = vec![root];
    let mut front = 0..1;
    for _ in 0..radius {
        for k in front.clone() {
            for &e in &neighbours[found[k]] {
                if !std::mem::replace(&mut seen[e], true) {
                    found.push(e);
                }
            }
        }
        front = front.end..found.len();
        if front.is_empty() {
            break;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::koebe::{KoebeOptions, koebe};
    use crate::progress::Silent;
    use crate::test_meshes::*;
    use nalgebra::DMatrix;
    use phex_mesh::HexMesh;

    /// Checks number, closing and independence, and returns the mean number of edges.
    fn check(name: &str, mesh: &HexMesh) -> f64 {
        let space = ParallelSpace::new(mesh).unwrap();
        let (basis, n) = (space.basis(), mesh.topology().n_edges());
        assert_eq!(basis.len(), space.dimension(), "{name}");
        let mut dense = DMatrix::zeros(n, basis.len());
        for (k, change) in basis.iter().enumerate() {
            let mut lengths = PerEdge::filled(n, 0.0);
            for &(e, by) in change {
                lengths[e] += by;
                dense[(e.index(), k)] = by;
            }
            let size = lengths.iter().fold(0.0f64, |m, l| m.max(l.abs()));
            assert!(
                space.closure_defect(&lengths) <= 1e-10 * size,
                "{name}: {k}"
            );
            dense.column_mut(k).scale_mut(1.0 / size);
        }
        let least = dense.singular_values().min();
        assert!(least > 1e-9, "{name}: {least:e}");
        let entries: usize = basis.iter().map(Vec::len).sum();
        entries as f64 / basis.len().max(1) as f64
    }

    #[test]
    fn as_many_independent_vectors_as_dimensions() {
        check("brick", &prism(4));
        check("prism", &prism(11));
        let graph = dual(&graph(&random_triangulation(60, 3)));
        let trivalent = koebe(&graph, &KoebeOptions::default(), &Silent).unwrap();
        check("tangent planes", &trivalent.mesh);
        let patch = hexagon_patch(5);
        let entries = check("patch", &patch);
        // A hexagon and its spokes have twelve edges.
        assert!(entries < 14.0, "{entries}");
    }
}
