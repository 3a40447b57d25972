//! The null space of a sparse matrix: projection onto it, and its dimension.
//!
//! `P = I - A^T (A A^T)^+ A`. Rows may depend on each other: `A A^T` is factorised with a small
//! shift, and the projection is repeated until `A x` is at the floor of rounding. The number of
//! dependent rows is that of the singular values of `A^T` that vanish; they are found by inverse
//! iteration on a growing block and measured as `|A^T u|`, not as roots of eigenvalues, so that
//! they are exact to rounding.

use nalgebra::DMatrix;
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix, max_abs};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Shift of `A A^T`, whose diagonal is about 1 or larger.
const SHIFT: f64 = 1e-12;

/// Repetitions of a projection at the most.
const MAX_PROJECTIONS: usize = 30;

/// Inverse iterations on each block.
const INVERSE_ITERATIONS: usize = 4;

/// Vectors of the first block.
const FIRST_BLOCK: usize = 8;

/// A sparse matrix by rows.
#[derive(Clone, Debug)]
pub(super) struct Rows {
    start: Vec<usize>,
    entries: Vec<(u32, f64)>,
    n_columns: usize,
}

impl Rows {
    pub fn new(n_columns: usize) -> Self {
        Self {
            start: vec![0],
            entries: Vec::new(),
            n_columns,
        }
    }

    /// Appends a row; entries at one place are added.
    pub fn push(&mut self, row: impl IntoIterator<Item = (usize, f64)>) {
        let mut row: Vec<(u32, f64)> = row
            .into_iter()
            .map(|(column, a)| (column as u32, a))
            .collect();
        row.sort_by_key(|entry| entry.0);
        row.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
        self.entries
            .extend(row.into_iter().filter(|entry| entry.1 != 0.0));
        self.start.push(self.entries.len());
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.start.len() - 1
    }

    pub(crate) fn n_columns(&self) -> usize {
        self.n_columns
    }

    pub fn row(&self, i: usize) -> &[(u32, f64)] {
        &self.entries[self.start[i]..self.start[i + 1]]
    }

    /// `A x`.
    pub fn mul(&self, x: &[f64]) -> Vec<f64> {
        let product = |i| self.row(i).iter().map(|&(j, a)| a * x[j as usize]).sum();
        (0..self.n_rows()).map(product).collect()
    }

    /// `A^T y`.
    pub(crate) fn mul_transposed(&self, y: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.n_columns];
        for (i, y) in y.iter().enumerate() {
            for &(j, a) in self.row(i) {
                product[j as usize] += a * y;
            }
        }
        product
    }

    /// Row and value of the entries of each column.
    pub fn columns(&self) -> Vec<Vec<(u32, f64)>> {
        let mut columns = vec![Vec::new(); self.n_columns];
        for i in 0..self.n_rows() {
            for &(j, a) in self.row(i) {
                columns[j as usize].push((i as u32, a));
            }
        }
        columns
    }

    fn gram(&self) -> Result<SymmetricMatrix, NumericError> {
        let mut triplets = Vec::new();
        for column in self.columns() {
            for (n, &(i, a)) in column.iter().enumerate() {
                triplets.extend(column[..=n].iter().map(|&(k, b)| (i, k, a * b)));
            }
        }
        SymmetricMatrix::from_triplets(self.n_rows(), triplets.into_iter())
    }
}

/// The rank of a matrix, and how clear it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rank {
    /// Number of independent rows.
    pub rank: usize,
    /// Largest singular value that counts as zero (0 if none does).
    pub largest_zero: f64,
    /// Smallest singular value that does not (infinite if all count as zero).
    pub smallest_nonzero: f64,
}

/// The null space of `rows`, ready for projections.
#[derive(Debug)]
pub(super) struct NullSpace {
    pub rows: Rows,
    /// Factor of `A A^T + shift I`; none if there is no row.
    cholesky: Option<Cholesky>,
}

impl NullSpace {
    pub fn new(rows: Rows) -> Result<Self, NumericError> {
        if rows.n_rows() == 0 {
            return Ok(Self {
                rows,
                cholesky: None,
            });
        }
        let gram = rows.gram()?;
        let mut cholesky = Cholesky::analyse(gram.pattern(), 1)?;
        let tried = cholesky.refactor_shifted(&gram, SHIFT);
        tried.or_else(|_| cholesky.refactor_shifted(&gram, 1e3 * SHIFT))?;
        Ok(Self {
            rows,
            cholesky: Some(cholesky),
        })
    }

    /// Moves `x` to the closest point of the null space.
    pub fn project(&self, x: &mut [f64]) {
        let Some(cholesky) = &self.cholesky else {
            return;
        };
        let mut defect = self.rows.mul(x);
        for _ in 0..MAX_PROJECTIONS {
            let before = max_abs(&defect);
            let mut multiplier = defect;
            cholesky.solve(&mut multiplier);
            let step = self.rows.mul_transposed(&multiplier);
            let moved: Vec<f64> = x.iter().zip(&step).map(|(x, d)| x - d).collect();
            defect = self.rows.mul(&moved);
            let after = max_abs(&defect);
            if after.is_nan() || after >= before {
                return;
            }
            x.copy_from_slice(&moved);
            if after > 0.5 * before {
                return;
            }
        }
    }

    /// Rank of the matrix; singular values up to `tolerance` count as zero.
    pub fn rank(&self, tolerance: f64) -> Rank {
        let n = self.rows.n_rows();
        let mut rank = Rank {
            rank: n,
            largest_zero: 0.0,
            smallest_nonzero: f64::INFINITY,
        };
        let Some(cholesky) = &self.cholesky else {
            return rank;
        };
        let mut block = FIRST_BLOCK.min(n);
        loop {
            let values = self.smallest_singular_values(cholesky, block);
            let (zeros, others): (Vec<f64>, Vec<f64>) =
                values.iter().partition(|&&v| v <= tolerance);
            if others.is_empty() && block < n {
                block = (4 * block).min(n);
                continue;
            }
            rank.rank = n - zeros.len();
            rank.largest_zero = zeros.into_iter().fold(0.0, f64::max);
            rank.smallest_nonzero = others.into_iter().fold(f64::INFINITY, f64::min);
            return rank;
        }
    }

    fn smallest_singular_values(&self, cholesky: &Cholesky, block: usize) -> Vec<f64> {
        let n = self.rows.n_rows();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let mut vectors = DMatrix::from_fn(n, block, |_, _| rng.random_range(-1.0..1.0));
        for _ in 0..INVERSE_ITERATIONS {
            let mut columns: Vec<Vec<f64>> = vectors
                .column_iter()
                .map(|c| c.iter().copied().collect())
                .collect();
            cholesky.solve_many(&mut columns);
            vectors = DMatrix::from_fn(n, block, |i, j| columns[j][i]).qr().q();
        }
        let images: Vec<Vec<f64>> = vectors
            .column_iter()
            .map(|c| self.rows.mul_transposed(c.into_owned().as_slice()))
            .collect();
        let images = DMatrix::from_fn(self.rows.n_columns(), block, |i, j| images[j][i]);
        let small = if images.nrows() > images.ncols() {
            images.qr().r()
        } else {
            images
        };
        let mut values: Vec<f64> = small.singular_values().iter().copied().collect();
        // More rows than columns: the rest is zero.
        values.resize(block, 0.0);
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random_rows(n: usize, m: usize, dependent: usize) -> Rows {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut rows = Rows::new(m);
        let mut dense: Vec<Vec<f64>> = Vec::new();
        for i in 0..n {
            let row: Vec<f64> = if i + dependent < n {
                (0..m)
                    .map(|j| {
                        if (i + j) % 3 == 0 {
                            rng.random_range(-1.0..1.0)
                        } else {
                            0.0
                        }
                    })
                    .collect()
            } else {
                let (a, b) = (
                    &dense[i % (n - dependent)],
                    &dense[(i + 1) % (n - dependent)],
                );
                a.iter().zip(b).map(|(a, b)| a - 2.0 * b).collect()
            };
            rows.push(row.iter().copied().enumerate());
            dense.push(row);
        }
        rows
    }

    #[test]
    fn dependent_rows_are_counted_beyond_the_first_block() {
        for dependent in [0, 1, 3, 11, 40] {
            let space = NullSpace::new(random_rows(60, 90, dependent)).unwrap();
            let rank = space.rank(1e-9);
            assert_eq!(rank.rank, 60 - dependent, "{rank:?}");
            assert!(
                rank.largest_zero < 1e-14 && rank.smallest_nonzero > 1e-3,
                "{rank:?}"
            );
        }
    }

    #[test]
    fn projection_is_onto_orthogonal_and_idempotent() {
        let space = NullSpace::new(random_rows(60, 90, 11)).unwrap();
        let wish: Vec<f64> = (0..90).map(|i| (i as f64).sin()).collect();
        let mut x = wish.clone();
        space.project(&mut x);
        assert!(max_abs(&space.rows.mul(&x)) < 1e-14);
        let again = {
            let mut y = x.clone();
            space.project(&mut y);
            y
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let moved: Vec<f64> = wish.iter().zip(&x).map(|(w, x)| w - x).collect();
        assert!(dot(&moved, &x).abs() < 1e-12);
        assert!(x.iter().zip(&again).all(|(a, b)| (a - b).abs() < 1e-13));
    }
}
