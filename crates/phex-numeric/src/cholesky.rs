//! Sparse Cholesky factorisation `P A P^T = L L^T` (`L L^H` of a Hermitian matrix) with the
//! symbolic part reused.
//!
//! The ordering is approximate minimum degree, on request of the quotient graph of small blocks
//! (the three coordinates of a vertex, say). The factorisation is sequential, so that its result is
//! the same for any number of threads. Every solution is refined with the residual of the matrix
//! itself until the residual no longer falls.

use crate::NumericError;
use crate::symmetric::{Pattern, Scalar, SymmetricMatrix};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{LltError as PivotError, LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::amd;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::ext::ComplexFieldExt;
use faer::{Conj, MatMut, Par, Side, Spec, c64};
use std::sync::Arc;

/// Refinements of a solution at the most.
const MAX_REFINEMENTS: usize = 3;

/// A solution is refined while its residual exceeds this multiple of the size of `A x` and `b`.
const RESIDUAL_GOAL: f64 = 8.0 * f64::EPSILON;

/// Factorisation of a sparse symmetric, or Hermitian, positive definite matrix.
pub struct Cholesky<T = f64> {
    symbolic: SymbolicCholesky<u32>,
    matrix: SymmetricMatrix<T>,
    factor: Vec<T>,
    scratch: MemBuffer,
    factorisations: usize,
}

impl<T: CholeskyNumber> Cholesky<T> {
    /// Analyses and factorises `matrix`.
    ///
    /// ```
    /// # use phex_numeric::SymmetricMatrix;
    /// # let entries = [(0, 0, 4.0), (1, 0, 1.0), (1, 1, 3.0)];
    /// # let matrix = SymmetricMatrix::from_triplets(2, entries.into_iter())?;
    /// use phex_numeric::Cholesky;
    ///
    /// let mut x: [f64; 2] = [6.0, 7.0];
    /// Cholesky::new(&matrix)?.solve(&mut x);
    /// assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
    /// # Ok::<(), phex_numeric::NumericError>(())
    /// ```
    ///
    /// # Errors
    /// [`NumericError::NotPositiveDefinite`], or [`NumericError::TooLarge`] if the factor does not
    /// fit.
    pub fn new(matrix: &SymmetricMatrix<T>) -> Result<Self, NumericError> {
        let mut cholesky = Self::analyse(matrix.pattern(), 1)?;
        cholesky.refactor(matrix)?;
        Ok(cholesky)
    }

    /// Factorises `matrix`; if its pattern is that of `earlier`, with that one's analysis and in
    /// its place. Blocks as in [`analyse`](Self::analyse).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn again(
        earlier: Option<Self>,
        matrix: &SymmetricMatrix<T>,
        block: usize,
    ) -> Result<Self, NumericError> {
        let mut cholesky = match earlier {
            Some(earlier) if earlier.matrix.pattern() == matrix.pattern() => earlier,
            _ => Self::analyse(matrix.pattern(), block)?,
        };
        cholesky.refactor(matrix)?;
        Ok(cholesky)
    }

    /// Analyses a pattern; [`refactor`](Self::refactor) must follow before anything is solved.
    /// If `block` consecutive unknowns always stand together, the ordering is found block by block.
    ///
    /// # Errors
    /// [`NumericError::TooLarge`] if the factor does not fit.
    pub fn analyse(pattern: &Arc<Pattern>, block: usize) -> Result<Self, NumericError> {
        let symbolic = analyse(pattern, block)?;
        let request = symbolic.factorize_numeric_llt_scratch::<T>(Par::Seq, Spec::default());
        let scratch = MemBuffer::try_new(request).map_err(|_| too_large("scratch memory"))?;
        Ok(Self {
            factor: vec![T::nan(); symbolic.len_val()],
            symbolic,
            matrix: SymmetricMatrix::zeros(pattern.clone()),
            scratch,
            factorisations: 0,
        })
    }

    /// Factorises another matrix on the pattern that was analysed.
    ///
    /// # Errors
    /// [`NumericError::PatternChanged`], or [`NumericError::NotPositiveDefinite`]. After an error
    /// solutions are `NaN` until a factorisation succeeds.
    pub fn refactor(&mut self, matrix: &SymmetricMatrix<T>) -> Result<(), NumericError> {
        self.refactor_shifted(matrix, 0.0)
    }

    /// Factorises `matrix + shift I`; solutions are those of the shifted matrix.
    ///
    /// # Errors
    /// As [`refactor`](Self::refactor).
    pub fn refactor_shifted(
        &mut self,
        matrix: &SymmetricMatrix<T>,
        shift: f64,
    ) -> Result<(), NumericError> {
        if !Arc::ptr_eq(matrix.pattern(), self.matrix.pattern())
            && matrix.pattern() != self.matrix.pattern()
        {
            self.factor.fill(T::nan());
            return Err(NumericError::PatternChanged);
        }
        self.matrix.values_mut().copy_from_slice(matrix.values());
        self.matrix.shift_diagonal(shift);
        self.factorisations += 1;
        let result = self.factorise();
        if result.is_err() {
            self.factor.fill(T::nan());
        }
        result
    }

    fn factorise(&mut self) -> Result<(), NumericError> {
        if let Some(pivot) = self.matrix.diagonal().position(|d| d.is_nan() || d <= 0.0) {
            return Err(NumericError::NotPositiveDefinite { pivot });
        }
        let (factor, scratch) = (&mut self.factor, MemStack::new(&mut self.scratch));
        T::factorise(&self.symbolic, &self.matrix, factor, scratch)
            .map_err(|pivot| NumericError::NotPositiveDefinite { pivot })
    }

    /// Solves `A x = b` in place: `rhs` holds `b` before and `x` after.
    ///
    /// # Panics
    /// If the length of `rhs` is not the dimension.
    pub fn solve(&self, rhs: &mut [T]) {
        let b = rhs.to_vec();
        self.solve_unrefined(rhs, 1);
        self.refine(&b, rhs);
    }

    /// Solves `A x = b` without refinement, as a preconditioner does.
    ///
    /// # Panics
    /// If a length is not the dimension.
    pub fn precondition(&self, b: &[T], x: &mut [T]) {
        x.copy_from_slice(b);
        self.solve_unrefined(x, 1);
    }

    /// Solves for many right-hand sides in place; the same solutions as one by one, but faster.
    ///
    /// # Panics
    /// If a length is not the dimension.
    pub fn solve_many(&self, rhs: &mut [Vec<T>]) {
        let n = self.dimension();
        assert!(rhs.iter().all(|b| b.len() == n), "lengths");
        let mut columns = rhs.concat();
        self.solve_unrefined(&mut columns, rhs.len());
        for (b, x) in rhs.iter_mut().zip(columns.chunks_exact_mut(n.max(1))) {
            self.refine(b, x);
            b.copy_from_slice(x);
        }
    }

    fn solve_unrefined(&self, columns: &mut [T], count: usize) {
        let columns = MatMut::from_column_major_slice_mut(columns, self.dimension(), count);
        T::solve(&self.symbolic, &self.factor, columns);
    }

    fn refine(&self, b: &[T], x: &mut [T]) {
        let mut residual = vec![T::zero(); b.len()];
        let mut size = self.residual(b, x, &mut residual);
        for _ in 0..MAX_REFINEMENTS {
            if size <= RESIDUAL_GOAL * max_abs(b) || !size.is_finite() {
                return;
            }
            let mut better = residual.clone();
            self.solve_unrefined(&mut better, 1);
            better.iter_mut().zip(&*x).for_each(|(d, x)| *d += *x);
            let new_size = self.residual(b, &better, &mut residual);
            if new_size.is_nan() || new_size >= size {
                return;
            }
            x.copy_from_slice(&better);
            if new_size > 0.5 * size {
                return;
            }
            size = new_size;
        }
    }

    /// `b - A x`, and its largest component.
    fn residual(&self, b: &[T], x: &[T], residual: &mut [T]) -> f64 {
        self.matrix.mul(x, residual);
        residual.iter_mut().zip(b).for_each(|(r, b)| *r = *b - *r);
        max_abs(residual)
    }

    /// Number of rows, and of columns.
    pub fn dimension(&self) -> usize {
        self.matrix.dimension()
    }

    /// How often a matrix has been factorised, failures included.
    pub fn factorisations(&self) -> usize {
        self.factorisations
    }

    /// Number of stored entries of `L`.
    pub fn n_factor_entries(&self) -> usize {
        self.factor.len()
    }
}

/// Numbers whose factorisation is compiled here, and not again in every crate that uses it.
pub trait CholeskyNumber: Scalar<Real = f64> {
    /// Writes the factor of a positive definite matrix, or names the pivot that is not positive.
    #[doc(hidden)]
    fn factorise(
        symbolic: &SymbolicCholesky<u32>,
        matrix: &SymmetricMatrix<Self>,
        factor: &mut [Self],
        scratch: &mut MemStack,
    ) -> Result<(), usize>;

    /// Solves for all columns in place.
    #[doc(hidden)]
    fn solve(symbolic: &SymbolicCholesky<u32>, factor: &[Self], columns: MatMut<'_, Self>);
}

macro_rules! factor {
    ($($number:ty),*) => {$(
        impl CholeskyNumber for $number {
            fn factorise(
                symbolic: &SymbolicCholesky<u32>,
                matrix: &SymmetricMatrix<Self>,
                factor: &mut [Self],
                scratch: &mut MemStack,
            ) -> Result<(), usize> {
                let matrix = SparseColMatRef::new(columns(matrix.pattern()), matrix.values());
                let (side, regular) = (Side::Lower, LltRegularization::default());
                symbolic
                    .factorize_numeric_llt(
                        factor, matrix, side, regular, Par::Seq, scratch, Spec::default(),
                    )
                    .map(|_| ())
                    .map_err(|PivotError::NonPositivePivot { index }| index)
            }

            fn solve(
                symbolic: &SymbolicCholesky<u32>,
                factor: &[Self],
                columns: MatMut<'_, Self>,
            ) {
                let request = symbolic.solve_in_place_scratch::<Self>(columns.ncols(), Par::Seq);
                let mut scratch = MemBuffer::new(request);
                let factor = LltRef::new(symbolic, factor);
                let stack = MemStack::new(&mut scratch);
                factor.solve_in_place_with_conj(Conj::No, columns, Par::Seq, stack);
            }
        }
    )*};
}

factor!(f64, c64);

impl<T: CholeskyNumber> std::fmt::Debug for Cholesky<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cholesky")
            .field("dimension", &self.dimension())
            .field("n_factor_entries", &self.n_factor_entries())
            .field("factorisations", &self.factorisations)
            .finish()
    }
}

/// Largest absolute value; NaN if one is.
pub fn max_abs<T: Scalar<Real = f64>>(values: &[T]) -> f64 {
    largest(values.iter().map(|v| v.abs()))
}

/// Largest of numbers that are not negative, 0 of none; NaN if one is.
pub fn largest(values: impl Iterator<Item = f64>) -> f64 {
    // `f64::max` would drop a NaN.
    values.fold(0.0, |m, v| if v > m || v.is_nan() { v } else { m })
}

fn too_large(reason: impl std::fmt::Display) -> NumericError {
    NumericError::TooLarge {
        reason: reason.to_string(),
    }
}

impl From<FaerError> for NumericError {
    fn from(error: FaerError) -> Self {
        too_large(error)
    }
}

fn columns(pattern: &Pattern) -> SymbolicSparseColMatRef<'_, u32> {
    let n = pattern.dimension();
    SymbolicSparseColMatRef::new_checked(n, n, pattern.column_start(), None, pattern.rows())
}

fn analyse(pattern: &Pattern, block: usize) -> Result<SymbolicCholesky<u32>, NumericError> {
    let params = CholeskySymbolicParams::default();
    if block <= 1 || !pattern.dimension().is_multiple_of(block) {
        let ordering = SymmetricOrdering::Amd;
        return Ok(factorize_symbolic_cholesky(
            columns(pattern),
            Side::Lower,
            ordering,
            params,
        )?);
    }
    let (forward, inverse) = block_ordering(pattern, block)?;
    let permutation = PermRef::new_checked(&forward, &inverse, pattern.dimension());
    let ordering = SymmetricOrdering::Custom(permutation);
    Ok(factorize_symbolic_cholesky(
        columns(pattern),
        Side::Lower,
        ordering,
        params,
    )?)
}

/// Minimum-degree permutation (and its inverse) of the blocks, spelled out for the single unknowns.
fn block_ordering(pattern: &Pattern, block: usize) -> Result<(Vec<u32>, Vec<u32>), NumericError> {
    let quotient = quotient(pattern, block);
    let n = quotient.dimension();
    let (mut forward, mut inverse) = (vec![0u32; n], vec![0u32; n]);
    let request = amd::order_scratch::<u32>(n, quotient.n_entries());
    let mut scratch = MemBuffer::try_new(request).map_err(|_| too_large("scratch memory"))?;
    let control = amd::Control::default();
    let stack = MemStack::new(&mut scratch);
    amd::order(
        &mut forward,
        &mut inverse,
        columns(&quotient),
        control,
        stack,
    )?;
    Ok((spell_out(&forward, block), spell_out(&inverse, block)))
}

fn spell_out(blocks: &[u32], block: usize) -> Vec<u32> {
    let single = |&b: &u32| (0..block as u32).map(move |k| b * block as u32 + k);
    blocks.iter().flat_map(single).collect()
}

fn quotient(pattern: &Pattern, block: usize) -> Pattern {
    Pattern::visited(pattern.dimension() / block, |visit| {
        for j in 0..pattern.dimension() {
            let rows = &pattern.rows()[pattern.column(j)];
            let column = (j / block) as u32;
            rows.iter().for_each(|i| visit(i / block as u32, column));
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ConjugateGradientOptions, conjugate_gradients};
    use proptest::prelude::*;

    /// Dense Gaussian elimination, the other method.
    fn dense_solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
        let n = b.len();
        for k in 0..n {
            for i in k + 1..n {
                let factor = a[i][k] / a[k][k];
                let (above, below) = a.split_at_mut(i);
                let pairs = below[0].iter_mut().zip(&above[k]).skip(k);
                pairs.for_each(|(x, pivot)| *x -= factor * pivot);
                b[i] -= factor * b[k];
            }
        }
        for k in (0..n).rev() {
            b[k] = (b[k] - (k + 1..n).map(|j| a[k][j] * b[j]).sum::<f64>()) / a[k][k];
        }
        b
    }

    /// A sparse diagonally dominant matrix, sparse and dense.
    fn random_system(
        n: usize,
        entries: &[(usize, usize, f64)],
    ) -> (SymmetricMatrix, Vec<Vec<f64>>) {
        let mut dense = vec![vec![0.0; n]; n];
        for &(i, j, v) in entries {
            let (i, j) = (i % n, j % n);
            for (r, c) in [(i, j), (j, i)] {
                dense[r][c] += v;
            }
        }
        for (i, row) in dense.iter_mut().enumerate() {
            row[i] = 1.0 + row.iter().map(|v| v.abs()).sum::<f64>();
        }
        (sparse(&dense), dense)
    }

    fn sparse(dense: &[Vec<f64>]) -> SymmetricMatrix {
        let n = dense.len();
        let entry = |k: usize| ((k / n) as u32, (k % n) as u32, dense[k / n][k % n]);
        SymmetricMatrix::from_triplets(n, (0..n * n).map(entry).filter(|e| e.2 != 0.0)).unwrap()
    }

    proptest! {
        #[test]
        fn agrees_with_dense_elimination(
            n in 1usize..40,
            entries in prop::collection::vec((0usize..40, 0usize..40, -1.0..1.0f64), 0..120),
            seed in prop::collection::vec(-1.0..1.0f64, 40),
        ) {
            let (matrix, dense) = random_system(n, &entries);
            let expected = dense_solve(dense, seed[..n].to_vec());
            let mut x = seed[..n].to_vec();
            let cholesky = Cholesky::new(&matrix).unwrap();
            cholesky.solve(&mut x);
            let mut many = vec![seed[..n].to_vec(); 3];
            cholesky.solve_many(&mut many);
            for i in 0..n {
                prop_assert!((x[i] - expected[i]).abs() < 1e-13);
                prop_assert!((many[2][i] - expected[i]).abs() < 1e-13);
            }
        }
    }

    /// `[[a, -b], [b, a]]` for each entry `a + b i`.
    fn real_form(matrix: &[(u32, u32, c64)], n: usize) -> Vec<Vec<f64>> {
        let mut dense = vec![vec![0.0; 2 * n]; 2 * n];
        for &(row, column, z) in matrix {
            for (row, column, z) in [(row, column, z), (column, row, z.conj())] {
                let (r, c) = (2 * row as usize, 2 * column as usize);
                (dense[r][c], dense[r][c + 1]) = (z.re, -z.im);
                (dense[r + 1][c], dense[r + 1][c + 1]) = (z.im, z.re);
            }
        }
        dense
    }

    #[test]
    fn a_hermitian_matrix_agrees_with_its_real_form() {
        let n = 40;
        let link = |i: u32, j: u32| {
            let angle = f64::from(3 * i + 7 * j);
            (i, j, c64::from_polar(1.0, angle))
        };
        let chain = (1..n as u32).map(|i| link(i, i - 1));
        let across = (5..n as u32).map(|i| link(i, i / 3));
        let own = (0..n as u32).map(|i| (i, i, c64::from(40.0 + f64::from(i))));
        let entries: Vec<_> = chain.chain(across).chain(own).collect();
        let matrix = SymmetricMatrix::from_triplets(n, entries.iter().copied()).unwrap();
        let right = |k: usize| c64::new((k as f64).sin(), (2.0 * k as f64).cos());
        let b: Vec<c64> = (0..n).map(right).collect();
        let reals = |z: &[c64]| z.iter().flat_map(|z| [z.re, z.im]).collect();
        let expected = dense_solve(real_form(&entries, n), reals(&b));
        let cholesky = Cholesky::new(&matrix).unwrap();
        let (mut solved, mut rough) = (b.clone(), b.clone());
        cholesky.solve(&mut solved);
        cholesky.precondition(&b, &mut rough);
        let diagonal: Vec<f64> = matrix.diagonal().collect();
        let mut iterated = vec![c64::new(0.0, 0.0); n];
        let options = ConjugateGradientOptions {
            tolerance: 1e-14,
            max_iterations: 200,
        };
        let apply = |x: &[c64], y: &mut [c64]| matrix.mul(x, y);
        conjugate_gradients(apply, &diagonal, &b, &mut iterated, &options);
        for found in [solved, rough, iterated] {
            let found: Vec<f64> = reals(&found);
            let near = |(x, e): (&f64, &f64)| (x - e).abs() < 1e-14;
            assert!(found.iter().zip(&expected).all(near));
        }
    }

    #[test]
    fn refactoring_reuses_the_pattern_and_the_block_ordering() {
        let n = 30;
        let entries: Vec<_> = (0..90)
            .map(|k| (k * 7, k * 11 + 3, 0.1 + 0.01 * k as f64))
            .collect();
        let (mut matrix, mut dense) = random_system(n, &entries);
        let mut cholesky = Cholesky::analyse(matrix.pattern(), 3).unwrap();
        for round in 0..3 {
            matrix.shift_diagonal(1.0);
            (0..n).for_each(|i| dense[i][i] += 1.0);
            cholesky.refactor(&matrix).unwrap();
            let b: Vec<f64> = (0..n).map(|i| (i as f64 + round as f64).sin()).collect();
            let mut x = b.clone();
            cholesky.solve(&mut x);
            for (x, e) in x.iter().zip(dense_solve(dense.clone(), b)) {
                assert!((x - e).abs() < 1e-14);
            }
        }
        assert_eq!(cholesky.factorisations(), 3);
        let other = SymmetricMatrix::from_triplets(n, [(0, 0, 1.0)].into_iter()).unwrap();
        assert_eq!(cholesky.refactor(&other), Err(NumericError::PatternChanged));
    }

    #[test]
    fn an_analysis_is_kept_while_the_pattern_stays() {
        let (matrix, dense) = random_system(12, &[(0, 5, 1.0), (3, 7, -2.0), (8, 11, 0.5)]);
        let (other, other_dense) = random_system(12, &[(0, 5, 3.0), (3, 7, 1.0), (8, 11, 2.0)]);
        let (wider, wider_dense) = random_system(12, &[(0, 5, 1.0), (2, 9, 1.0)]);
        let first = Cholesky::again(None, &matrix, 2).unwrap();
        let second = Cholesky::again(Some(first), &other, 2).unwrap();
        assert_eq!(second.factorisations(), 2);
        let third = Cholesky::again(Some(Cholesky::new(&matrix).unwrap()), &wider, 2).unwrap();
        assert_eq!(third.factorisations(), 1);
        for (cholesky, dense) in [
            (Cholesky::new(&matrix).unwrap(), dense),
            (second, other_dense),
            (third, wider_dense),
        ] {
            let b: Vec<f64> = (0..12).map(f64::from).collect();
            let mut x = b.clone();
            cholesky.solve(&mut x);
            for (x, e) in x.iter().zip(dense_solve(dense, b)) {
                assert!((x - e).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn indefinite_is_refused_and_a_shift_cures_it() {
        let dense = vec![
            vec![1.0, 3.0, 0.0],
            vec![3.0, 1.0, 0.5],
            vec![0.0, 0.5, 2.0],
        ];
        let matrix = sparse(&dense);
        let refused = Cholesky::new(&matrix).unwrap_err();
        assert!(matches!(refused, NumericError::NotPositiveDefinite { .. }));
        let mut cholesky = Cholesky::analyse(matrix.pattern(), 1).unwrap();
        assert!(cholesky.refactor_shifted(&matrix, 1.9).is_err());
        let mut x = [1.0, 2.0, 3.0];
        cholesky.solve(&mut x);
        assert!(
            x.iter().all(|x| x.is_nan()),
            "no solution from a failed factorisation"
        );
        cholesky.refactor_shifted(&matrix, 3.0).unwrap();
        let mut x = [1.0, 2.0, 3.0];
        cholesky.solve(&mut x);
        let shifted = vec![
            vec![4.0, 3.0, 0.0],
            vec![3.0, 4.0, 0.5],
            vec![0.0, 0.5, 5.0],
        ];
        for (x, e) in x.iter().zip(dense_solve(shifted, vec![1.0, 2.0, 3.0])) {
            assert!((x - e).abs() < 1e-15);
        }
    }

    #[test]
    fn a_nan_is_refused() {
        let matrix = SymmetricMatrix::from_triplets(1, [(0, 0, f64::NAN)].into_iter()).unwrap();
        assert!(Cholesky::new(&matrix).is_err());
    }

    #[test]
    fn refinement_rescues_an_ill_conditioned_chain() {
        // A path Laplacian with stiff and soft springs, held at one end.
        let n = 200;
        let stiffness = |k: usize| if k.is_multiple_of(7) { 1e9 } else { 1.0 };
        let springs = (0..n as u32 - 1).flat_map(|k| {
            let s = stiffness(k as usize);
            [(k, k, s), (k + 1, k + 1, s), (k + 1, k, -s)]
        });
        let matrix = SymmetricMatrix::from_triplets(n, springs.chain([(0, 0, 1.0)])).unwrap();
        let exact: Vec<f64> = (0..n).map(|k| f64::from(k as u32 % 16)).collect();
        let mut x = vec![0.0; n];
        matrix.mul(&exact, &mut x);
        let b = x.clone();
        Cholesky::new(&matrix).unwrap().solve(&mut x);
        let mut residual = vec![0.0; n];
        matrix.mul(&x, &mut residual);
        let worst = residual
            .iter()
            .zip(&b)
            .map(|(r, b)| (r - b).abs())
            .fold(0.0, f64::max);
        assert!(worst <= 1e-15 * max_abs(&b) * 4.0, "{worst:e}");
    }
}
