//! Lengths that edges share: one-dimensional k-means.

use phex_mesh::cluster::by_value;
use phex_mesh::{HexMesh, PerEdge};

/// Halvings of the width of intervals that give a number of clusters.
const HALVINGS: usize = 60;
/// Steps of k-means at the most.
const STEPS: usize = 50;

/// Lengths of all edges.
pub(super) fn lengths(mesh: &HexMesh) -> Vec<f64> {
    let edges = mesh.topology().edges();
    edges.map(|e| mesh.edge_length(e)).collect()
}

/// The least number of intervals of a width that hold all edge lengths.
pub(super) fn distinct_lengths(mesh: &HexMesh, tolerance: f64) -> usize {
    by_value(&lengths(mesh), tolerance).len()
}

/// The lengths of clusters, growing.
pub(super) struct SharedLengths(Vec<f64>);

impl SharedLengths {
    /// At most `clusters` of them: k-means from the intervals of equal width that are as many.
    pub fn new(lengths: &[f64], clusters: usize) -> Self {
        let longest = lengths.iter().copied().fold(0.0, f64::max);
        let (mut narrow, mut wide) = (0.0, longest);
        for _ in 0..HALVINGS {
            let width = 0.5 * (narrow + wide);
            *(match by_value(lengths, width).len() > clusters {
                true => &mut narrow,
                false => &mut wide,
            }) = width;
        }
        let mut shared = Self(by_value(lengths, wide).iter().map(|c| c.value).collect());
        shared.settle(lengths);
        shared
    }

    /// Moves each to the mean of the edges that are nearest to it, until none moves.
    pub fn settle(&mut self, lengths: &[f64]) {
        for _ in 0..STEPS {
            let mut sums = vec![(0.0, 0_usize); self.0.len()];
            for length in lengths {
                let (sum, count) = &mut sums[self.nearest(*length)];
                (*sum, *count) = (*sum + length, *count + 1);
            }
            let filled = sums.iter().filter(|(_, count)| *count > 0);
            let next: Vec<f64> = filled.map(|(sum, count)| sum / *count as f64).collect();
            if next == self.0 {
                break;
            }
            self.0 = next;
        }
    }

    fn nearest(&self, length: f64) -> usize {
        let above = self.0.partition_point(|l| *l < length);
        let below = above.saturating_sub(1);
        match self.0.get(above) {
            Some(l) if l - length < length - self.0[below] => above,
            _ => below,
        }
    }

    /// The length that each edge is to have.
    pub fn targets(&self, mesh: &HexMesh) -> PerEdge<f64> {
        let target = |length: &f64| self.0[self.nearest(*length)];
        PerEdge::from_vec(lengths(mesh).iter().map(target).collect())
    }

    /// Largest difference between an edge and the length that it is to have.
    pub fn spread(&self, mesh: &HexMesh) -> f64 {
        let off = |length: &f64| (length - self.0[self.nearest(*length)]).abs();
        lengths(mesh).iter().map(off).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clusters_are_as_many_as_asked_for_and_sit_where_lengths_are() {
        let lengths = [1.0, 1.01, 1.02, 2.0, 2.01, 5.0];
        let shared = SharedLengths::new(&lengths, 3);
        let near = |a: &f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(&shared.0[0], 1.01) && near(&shared.0[1], 2.005) && near(&shared.0[2], 5.0));
        assert_eq!(SharedLengths::new(&lengths, 1).0.len(), 1);
        assert_eq!(SharedLengths::new(&lengths, 100).0.len(), 6);
    }

    #[test]
    fn the_nearest_cluster_is_the_nearest() {
        let shared = SharedLengths(vec![1.0, 2.0, 4.0]);
        let nearest = [0.0, 1.4, 1.6, 2.9, 3.1, 9.0].map(|l| shared.nearest(l));
        assert_eq!(nearest, [0, 0, 1, 1, 2, 2]);
    }
}
