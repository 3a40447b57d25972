//! Sparse symmetric matrices, Hermitian ones where entries are complex: the lower triangle, stored
//! by columns.

use crate::NumericError;
use faer::traits::ComplexField;
use faer::traits::ext::ComplexFieldExt;
use num_traits::{Float, NumAssign};
use std::sync::Arc;

/// Entries of matrices and vectors: real or complex numbers.
pub trait Scalar: ComplexField<Real: Float> + NumAssign + Copy {}

impl<T: ComplexField<Real: Float> + NumAssign + Copy> Scalar for T {}

/// Where the entries of a sparse symmetric matrix stand: compressed columns of the lower triangle,
/// rows ascending, every diagonal entry present.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pattern {
    column_start: Vec<u32>,
    row: Vec<u32>,
}

impl Pattern {
    /// The pattern that holds the diagonal and the positions of the lower triangle that `each`
    /// visits, row first, as often as it is called; in any order, repeats allowed.
    pub(crate) fn visited(dimension: usize, each: impl Fn(&mut dyn FnMut(u32, u32))) -> Self {
        let mut column_start = vec![0u32; dimension + 2];
        let counts = &mut column_start[2..];
        counts.fill(1);
        each(&mut |_, column| counts[column as usize] += 1);
        (2..dimension + 2).for_each(|j| column_start[j] += column_start[j - 1]);
        let mut row = vec![0; column_start[dimension + 1] as usize];
        let mut put = |i: u32, j: u32| {
            let place = &mut column_start[j as usize + 1];
            row[*place as usize] = i;
            *place += 1;
        };
        (0..dimension as u32).for_each(|j| put(j, j));
        each(&mut put);
        column_start.pop();
        let mut pattern = Self { column_start, row };
        pattern.sort_columns();
        pattern
    }

    /// Sorts the rows of each column, of repeats only one.
    fn sort_columns(&mut self) {
        let (mut first, mut end) = (0, 0);
        for next in &mut self.column_start[1..] {
            let last = *next as usize;
            self.row[first..last].sort_unstable();
            let start = end;
            for k in first..last {
                if end == start || self.row[end - 1] != self.row[k] {
                    self.row[end] = self.row[k];
                    end += 1;
                }
            }
            (first, *next) = (last, end as u32);
        }
        self.row.truncate(end);
        self.row.shrink_to_fit();
    }

    /// Number of rows, and of columns.
    pub fn dimension(&self) -> usize {
        self.column_start.len() - 1
    }

    /// Number of stored entries (lower triangle).
    pub fn n_entries(&self) -> usize {
        self.row.len()
    }

    /// Index of the first entry of each column, and one past the last entry.
    pub fn column_start(&self) -> &[u32] {
        &self.column_start
    }

    /// Row of each entry.
    pub fn rows(&self) -> &[u32] {
        &self.row
    }

    /// Indices of the entries of a column; the first one is the diagonal.
    pub fn column(&self, j: usize) -> std::ops::Range<usize> {
        self.column_start[j] as usize..self.column_start[j + 1] as usize
    }

    /// Index of entry `(row, column)`, `row >= column`, if it is stored.
    pub fn position(&self, row: u32, column: u32) -> Option<usize> {
        let range = self.column(column as usize);
        let offset = self.row[range.clone()].binary_search(&row).ok()?;
        Some(range.start + offset)
    }
}

/// A sparse symmetric matrix; with complex entries one that is Hermitian, whose diagonal is real.
/// Matrices that share a pattern share one copy of it.
#[derive(Clone, Debug)]
pub struct SymmetricMatrix<T = f64> {
    pattern: Arc<Pattern>,
    values: Vec<T>,
}

impl<T: Scalar<Real = f64>> SymmetricMatrix<T> {
    /// The matrix of dimension `n` whose lower triangle is the sum of `(row, column, value)`
    /// triplets.
    ///
    /// Triplets with `row < column` are ignored, so that both triangles, or only the lower one, may
    /// be given. Several triplets at one place are added in the order in which they come.
    ///
    /// ```
    /// use phex_numeric::SymmetricMatrix;
    ///
    /// let entries = [(0, 0, 4.0), (1, 0, 1.0), (1, 1, 3.0)];
    /// let matrix = SymmetricMatrix::from_triplets(2, entries.into_iter())?;
    /// let mut product = [0.0; 2];
    /// matrix.mul(&[1.0, 2.0], &mut product);
    /// assert_eq!(product, [6.0, 7.0]);
    /// # Ok::<(), phex_numeric::NumericError>(())
    /// ```
    ///
    /// # Errors
    /// [`NumericError::IndexOutOfRange`] if a row or a column is not below `n`.
    pub fn from_triplets(
        n: usize,
        triplets: impl Iterator<Item = (u32, u32, T)>,
    ) -> Result<Self, NumericError> {
        let mut outside = None;
        let lower = triplets.filter(|&(row, column, _)| {
            if row.max(column) as usize >= n {
                outside.get_or_insert((row, column));
            }
            row >= column
        });
        let lower: Vec<(u32, u32, T)> = lower.collect();
        if let Some((row, column)) = outside {
            return Err(NumericError::IndexOutOfRange {
                row,
                column,
                dimension: n,
            });
        }
        let pattern = Pattern::visited(n, |visit| {
            lower
                .iter()
                .for_each(|(row, column, _)| visit(*row, *column));
        });
        let mut values = vec![T::zero(); pattern.n_entries()];
        for (row, column, value) in lower {
            if let Some(at) = pattern.position(row, column) {
                values[at] += value;
            }
        }
        Ok(Self {
            pattern: Arc::new(pattern),
            values,
        })
    }

    /// The zero matrix on a pattern.
    pub fn zeros(pattern: Arc<Pattern>) -> Self {
        let values = vec![T::zero(); pattern.n_entries()];
        Self { pattern, values }
    }

    /// Number of rows, and of columns.
    pub fn dimension(&self) -> usize {
        self.pattern.dimension()
    }

    /// Where the entries stand.
    pub fn pattern(&self) -> &Arc<Pattern> {
        &self.pattern
    }

    /// Values of the lower triangle, in the order of the pattern.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// Values of the lower triangle, mutable.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The diagonal.
    pub fn diagonal(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        let starts = &self.pattern.column_start()[..self.dimension()];
        starts.iter().map(|&at| self.values[at as usize].real())
    }

    /// Adds `shift` to every diagonal entry.
    pub fn shift_diagonal(&mut self, shift: f64) {
        for j in 0..self.dimension() {
            self.values[self.pattern.column_start[j] as usize] += T::from_f64_impl(shift);
        }
    }

    /// `y = A x`.
    ///
    /// # Panics
    /// If a length is not the dimension.
    pub fn mul(&self, x: &[T], y: &mut [T]) {
        assert_eq!(
            (x.len(), y.len()),
            (self.dimension(), self.dimension()),
            "lengths"
        );
        y.fill(T::zero());
        for j in 0..self.dimension() {
            let column = self.pattern.column(j);
            y[j] += self.values[column.start] * x[j];
            let mut sum = T::zero();
            for at in column.start + 1..column.end {
                let i = self.pattern.row[at] as usize;
                y[i] += self.values[at] * x[j];
                sum += self.values[at].conj() * x[i];
            }
            y[j] += sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn duplicates_are_summed_and_the_upper_triangle_is_ignored() {
        let triplets = [
            (0, 0, 1.0),
            (1, 0, 2.0),
            (0, 1, 99.0),
            (1, 0, 0.5),
            (2, 2, 3.0),
            (0, 0, 1.0),
        ];
        let a = SymmetricMatrix::from_triplets(3, triplets.into_iter()).unwrap();
        let mut y = [0.0; 3];
        a.mul(&[1.0, 10.0, 100.0], &mut y);
        assert_eq!(y, [2.0 + 25.0, 2.5, 300.0]);
        assert_eq!(a.diagonal().collect::<Vec<_>>(), [2.0, 0.0, 3.0]);
    }

    #[test]
    fn out_of_range_is_refused() {
        let error = SymmetricMatrix::from_triplets(2, [(2, 0, 1.0)].into_iter()).unwrap_err();
        assert_eq!(
            error,
            NumericError::IndexOutOfRange {
                row: 2,
                column: 0,
                dimension: 2
            }
        );
    }
}
