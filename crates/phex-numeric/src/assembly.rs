//! Assembly of a sparse symmetric matrix from dense element blocks, on a pattern that never
//! changes.
//!
//! `A = sum_e S_e^T B_e S_e`, where `S_e` selects the unknowns of element `e`. Where each entry of
//! each block goes is found once; an assembly then only adds, in the order of the elements, so that
//! its result does not depend on how the blocks were computed.

use crate::symmetric::{Pattern, SymmetricMatrix};
use std::ops::Range;
use std::sync::Arc;

/// Map from the blocks of elements to the entries of the assembled matrix.
///
/// A block over `m` unknowns is stored as the packed rows of its lower triangle, entry `(a, b)`,
/// `a >= b`, at [`packed`]`(a, b)`.
#[derive(Clone, Debug)]
pub struct Assembly {
    pattern: Arc<Pattern>,
    /// Entry of the matrix that each entry of each block is added to.
    target: Vec<u32>,
    /// First entry of each block, and one past the last.
    block_start: Vec<u32>,
}

/// Place of entry `(a, b)`, `a >= b`, in the packed lower triangle of a block.
pub const fn packed(a: usize, b: usize) -> usize {
    a * (a + 1) / 2 + b
}

impl Assembly {
    /// Builds the map for elements given by their unknowns (each below `dimension`, none repeated
    /// in an element).
    pub fn new(dimension: usize, elements: &[Vec<u32>]) -> Self {
        let pattern = Pattern::visited(dimension, |visit| for_each_entry(elements, visit));
        let pattern = Arc::new(pattern);
        let mut target = Vec::new();
        for_each_entry(elements, |row, column| {
            // Present by construction.
            target.push(pattern.position(row, column).unwrap_or_default() as u32);
        });
        let mut block_start = vec![0];
        for element in elements {
            let last = block_start[block_start.len() - 1];
            block_start.push(last + packed(element.len(), 0) as u32);
        }
        Self {
            pattern,
            target,
            block_start,
        }
    }

    /// The pattern of the assembled matrix.
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// Number of stored entries of all blocks.
    pub fn n_block_entries(&self) -> usize {
        self.target.len()
    }

    /// Entries of an element's block among those of all blocks.
    pub fn block(&self, element: usize) -> Range<usize> {
        self.block_start[element] as usize..self.block_start[element + 1] as usize
    }

    /// Overwrites `matrix` with the sum of all blocks.
    ///
    /// # Panics
    /// If `blocks` has another length than [`n_block_entries`](Self::n_block_entries), or `matrix`
    /// another pattern.
    pub fn assemble(&self, blocks: &[f64], matrix: &mut SymmetricMatrix) {
        assert_eq!(blocks.len(), self.target.len(), "one value per block entry");
        assert!(
            Arc::ptr_eq(matrix.pattern(), &self.pattern),
            "a matrix on this pattern"
        );
        let values = matrix.values_mut();
        values.fill(0.0);
        for (&at, &value) in self.target.iter().zip(blocks) {
            values[at as usize] += value;
        }
    }
}

fn for_each_entry(elements: &[Vec<u32>], mut visit: impl FnMut(u32, u32)) {
    for element in elements {
        for (a, &i) in element.iter().enumerate() {
            for &j in &element[..=a] {
                visit(i.max(j), i.min(j));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_land_where_the_dense_sum_says() {
        let elements = vec![vec![2, 0, 3], vec![1, 3], vec![3, 2]];
        let assembly = Assembly::new(4, &elements);
        let mut matrix = SymmetricMatrix::zeros(assembly.pattern().clone());
        for round in 1..3 {
            let value = |k: usize| (k * k * round) as f64;
            let blocks: Vec<f64> = (0..assembly.n_block_entries()).map(value).collect();
            assembly.assemble(&blocks, &mut matrix);
            let mut dense = [[0.0; 4]; 4];
            for (e, element) in elements.iter().enumerate() {
                let block = &blocks[assembly.block(e)];
                for a in 0..element.len() {
                    for b in 0..element.len() {
                        let (i, j) = (element[a] as usize, element[b] as usize);
                        dense[i][j] += block[packed(a.max(b), a.min(b))];
                    }
                }
            }
            for j in 0..4 {
                let (mut unit, mut column) = ([0.0; 4], [0.0; 4]);
                unit[j] = 1.0;
                matrix.mul(&unit, &mut column);
                assert_eq!(column, dense.map(|row| row[j]));
            }
        }
    }
}
