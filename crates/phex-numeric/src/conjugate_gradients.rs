//! Conjugate gradients for `A x = b` with `A` symmetric or Hermitian and positive definite, with
//! the Jacobi or any other preconditioner, in single or double precision.

use crate::outcome::Status;
use crate::symmetric::Scalar;
use faer::traits::ext::ComplexFieldExt;
use num_traits::{Float, One, ToPrimitive, Zero};

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConjugateGradientOptions {
    /// Residual over right-hand side, in the Euclidean norm, that counts as solved.
    pub tolerance: f64,
    /// Iterations at the most.
    pub max_iterations: usize,
}

impl Default for ConjugateGradientOptions {
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            max_iterations: 1000,
        }
    }
}

/// How conjugate gradients ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConjugateGradientResult {
    /// Why it ended; `NumericalBreakdown` if `A` showed itself to be indefinite.
    pub status: Status,
    /// Number of iterations, each one product with `A`.
    pub iterations: usize,
    /// Last residual over right-hand side.
    pub residual: f64,
}

/// Solves `A x = b` from the given `x`; `apply(p, y)` writes `A p` into `y`, `diagonal` is that of
/// `A`.
///
/// ```
/// # use phex_numeric::SymmetricMatrix;
/// # let entries = [(0, 0, 4.0), (1, 0, 1.0), (1, 1, 3.0)];
/// # let matrix = SymmetricMatrix::from_triplets(2, entries.into_iter())?;
/// use phex_numeric::{ConjugateGradientOptions, Status, conjugate_gradients};
///
/// let diagonal: Vec<f64> = matrix.diagonal().collect();
/// let mut x = [0.0; 2];
/// let options = ConjugateGradientOptions::default();
/// let apply = |p: &[f64], y: &mut [f64]| matrix.mul(p, y);
/// let result = conjugate_gradients(apply, &diagonal, &[6.0, 7.0], &mut x, &options);
/// assert_eq!(result.status, Status::Converged);
/// assert!((x[1] - 2.0).abs() < 1e-9);
/// # Ok::<(), phex_numeric::NumericError>(())
/// ```
///
/// # Panics
/// If the lengths differ.
pub fn conjugate_gradients<T: Scalar>(
    apply: impl FnMut(&[T], &mut [T]),
    diagonal: &[T::Real],
    b: &[T],
    x: &mut [T],
    options: &ConjugateGradientOptions,
) -> ConjugateGradientResult {
    assert_eq!(diagonal.len(), b.len(), "equal lengths");
    let inverse = |d: &T::Real| match *d > Zero::zero() {
        true => Float::recip(*d),
        false => One::one(),
    };
    let inverse: Vec<T::Real> = diagonal.iter().map(inverse).collect();
    let jacobi = |r: &[T], z: &mut [T]| {
        let pairs = r.iter().zip(&inverse);
        z.iter_mut()
            .zip(pairs)
            .for_each(|(z, (r, i))| *z = r.mul_real(*i));
    };
    preconditioned_conjugate_gradients(apply, jacobi, b, x, options)
}

/// As [`conjugate_gradients`], with `precondition(r, z)`, which writes an approximate solution of
/// `A z = r`, symmetric positive definite in `r` (the factorisation of a matrix near `A`, say).
///
/// # Panics
/// If the lengths differ.
pub fn preconditioned_conjugate_gradients<T: Scalar>(
    mut apply: impl FnMut(&[T], &mut [T]),
    precondition: impl Fn(&[T], &mut [T]),
    b: &[T],
    x: &mut [T],
    options: &ConjugateGradientOptions,
) -> ConjugateGradientResult {
    assert_eq!(x.len(), b.len(), "equal lengths");
    let size = norm(b);
    let goal = options.tolerance * size;
    let mut product = vec![T::zero(); b.len()];
    apply(x, &mut product);
    let mut residual: Vec<T> = b.iter().zip(&product).map(|(b, y)| *b - *y).collect();
    let mut z = vec![T::zero(); b.len()];
    precondition(&residual, &mut z);
    let mut direction = z.clone();
    let mut rz = dot(&residual, &z);
    let result = |status, iterations, residual: &[T]| ConjugateGradientResult {
        status,
        iterations,
        residual: norm(residual) / size.max(f64::MIN_POSITIVE),
    };
    for iteration in 0..options.max_iterations {
        if norm(&residual) <= goal {
            return result(Status::Converged, iteration, &residual);
        }
        apply(&direction, &mut product);
        let curvature = dot(&direction, &product);
        if curvature.is_nan() || curvature <= Zero::zero() {
            return result(Status::NumericalBreakdown, iteration, &residual);
        }
        let alpha = rz / curvature;
        add_scaled(x, alpha, &direction);
        add_scaled(&mut residual, -alpha, &product);
        precondition(&residual, &mut z);
        let next = dot(&residual, &z);
        let beta = next / rz;
        rz = next;
        direction
            .iter_mut()
            .zip(&z)
            .for_each(|(p, z)| *p = *z + p.mul_real(beta));
    }
    let solved = norm(&residual) <= goal;
    let status = if solved {
        Status::Converged
    } else {
        Status::IterationLimit
    };
    result(status, options.max_iterations, &residual)
}

/// Sums that run side by side in [`dot`].
const LANES: usize = 8;

/// Real part of the scalar product; several sums side by side, so that none waits for the one
/// before.
pub(crate) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T::Real {
    let product = |a: &T, b: &T| (a.conj() * *b).real();
    let mut sums = [<T::Real as Zero>::zero(); LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest = rest.fold(<T::Real as Zero>::zero(), |sum, (a, b)| sum + product(a, b));
    for (a, b) in a.zip(b) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += product(a, b);
        }
    }
    sums.iter()
        .fold(<T::Real as Zero>::zero(), |sum, s| sum + *s)
        + rest
}

/// Euclidean norm.
fn norm<T: Scalar>(a: &[T]) -> f64 {
    Float::sqrt(dot(a, a)).to_f64().unwrap_or(f64::NAN)
}

pub(crate) fn add_scaled<T: Scalar>(y: &mut [T], factor: T::Real, x: &[T]) {
    let pairs = y.iter_mut().zip(x);
    pairs.for_each(|(y, x)| *y += x.mul_real(factor));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cholesky, SymmetricMatrix};

    fn grid_laplacian(side: u32) -> SymmetricMatrix {
        let at = |i: u32, j: u32| i * side + j;
        let mut entries = Vec::new();
        for i in 0..side {
            for j in 0..side {
                entries.push((at(i, j), at(i, j), 4.1 + f64::from(i * j % 3)));
                if i > 0 {
                    entries.push((at(i, j), at(i - 1, j), -1.0));
                }
                if j > 0 {
                    entries.push((at(i, j), at(i, j - 1), -1.0));
                }
            }
        }
        SymmetricMatrix::from_triplets((side * side) as usize, entries.into_iter()).unwrap()
    }

    #[test]
    fn agrees_with_cholesky() {
        let a = grid_laplacian(40);
        let b: Vec<f64> = (0..1600).map(|k| (k as f64 * 0.7).sin()).collect();
        let mut expected = b.clone();
        Cholesky::new(&a).unwrap().solve(&mut expected);
        let diagonal: Vec<f64> = a.diagonal().collect();
        let mut x = vec![0.0; 1600];
        let options = ConjugateGradientOptions {
            tolerance: 1e-13,
            max_iterations: 400,
        };
        let result = conjugate_gradients(|p, y| a.mul(p, y), &diagonal, &b, &mut x, &options);
        assert_eq!(result.status, Status::Converged);
        assert!(x.iter().zip(&expected).all(|(x, e)| (x - e).abs() < 1e-12));
    }

    #[test]
    fn tells_of_the_limit_and_of_indefinite_matrices() {
        let a = grid_laplacian(20);
        let (b, diagonal) = (vec![1.0; 400], vec![1.0; 400]);
        let options = ConjugateGradientOptions {
            tolerance: 1e-13,
            max_iterations: 2,
        };
        let run = |sign: f64| {
            let apply = |p: &[f64], y: &mut [f64]| {
                a.mul(p, y);
                y.iter_mut().for_each(|y| *y *= sign);
            };
            conjugate_gradients(apply, &diagonal, &b, &mut vec![0.0; 400], &options).status
        };
        assert_eq!(run(1.0), Status::IterationLimit);
        assert_eq!(run(-1.0), Status::NumericalBreakdown);
    }
}
