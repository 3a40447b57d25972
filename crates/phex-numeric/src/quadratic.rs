//! Convex quadratic programs with sparse linear constraints, by interior points.
//!
//! Source of the method: Goulart, Chen, "Clarabel: an interior-point solver for conic programs with
//! quadratic objectives" (2024).

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT,
};

/// Row, column and value of an entry.
pub type Triplet = (usize, usize, f64);

/// `A x = b` in the first rows and `A x <= b` in the rest.
#[derive(Clone, Debug)]
pub struct LinearConstraints {
    matrix: CscMatrix<f64>,
    bounds: Vec<f64>,
    n_equalities: usize,
}

impl LinearConstraints {
    /// Constraints on `n` unknowns: entries of `A` in any order, those at one place added, the
    /// bounds `b` of its rows, and how many of these are equalities.
    ///
    /// # Panics
    /// If an entry lies outside.
    pub fn new(n: usize, entries: Vec<Triplet>, bounds: Vec<f64>, n_equalities: usize) -> Self {
        assert!(n_equalities <= bounds.len(), "equalities are rows");
        Self {
            matrix: compressed(bounds.len(), n, entries),
            bounds,
            n_equalities,
        }
    }
}

/// The `x` with the least `x^T H x / 2 + g^T x` under the constraints; `None` if there is none, or
/// the solver gives up. Of `H`, positive semidefinite, only the upper triangle is given, entries in
/// any order, those at one place added.
///
/// ```
/// use phex_numeric::{LinearConstraints, minimise};
///
/// // The point closest to (2, 0) with x + y = 1 and x <= 1.
/// let entries = vec![(0, 0, 1.0), (0, 1, 1.0), (1, 0, 1.0)];
/// let constraints = LinearConstraints::new(2, entries, vec![1.0, 1.0], 1);
/// let x = minimise(vec![(0, 0, 1.0), (1, 1, 1.0)], &[-2.0, 0.0], &constraints);
/// assert!(x.is_some_and(|x| (x[0] - 1.0).abs() < 1e-6 && x[1].abs() < 1e-6));
/// ```
///
/// # Panics
/// If an entry lies outside, or the gradient has not one number for each unknown.
pub fn minimise(
    hessian: Vec<Triplet>,
    gradient: &[f64],
    constraints: &LinearConstraints,
) -> Option<Vec<f64>> {
    let n = gradient.len();
    assert_eq!(n, constraints.matrix.n, "one number for each unknown");
    let hessian = compressed(n, n, hessian);
    let LinearConstraints {
        matrix,
        bounds,
        n_equalities,
    } = constraints;
    let cones = [
        ZeroConeT(*n_equalities),
        NonnegativeConeT(bounds.len() - n_equalities),
    ];
    let settings = DefaultSettings {
        verbose: false,
        max_threads: 1,
        ..DefaultSettings::default()
    };
    let mut solver =
        DefaultSolver::new(&hessian, gradient, matrix, bounds, &cones, settings).ok()?;
    solver.solve();
    let solution = solver.solution;
    let usable = matches!(
        solution.status,
        SolverStatus::Solved | SolverStatus::AlmostSolved
    );
    (usable && solution.x.iter().all(|x| x.is_finite())).then_some(solution.x)
}

/// A matrix by columns.
fn compressed(n_rows: usize, n_columns: usize, mut triplets: Vec<Triplet>) -> CscMatrix<f64> {
    assert!(triplets.iter().all(|t| t.0 < n_rows && t.1 < n_columns));
    triplets.sort_by_key(|&(i, j, _)| (j, i));
    triplets.dedup_by(|next, kept| {
        let same = (next.0, next.1) == (kept.0, kept.1);
        kept.2 += if same { next.2 } else { 0.0 };
        same
    });
    let mut column_start = vec![0; n_columns + 1];
    triplets.iter().for_each(|t| column_start[t.1 + 1] += 1);
    (0..n_columns).for_each(|j| column_start[j + 1] += column_start[j]);
    let rows = triplets.iter().map(|t| t.0).collect();
    let values = triplets.iter().map(|t| t.2).collect();
    CscMatrix::new(n_rows, n_columns, column_start, rows, values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_at_one_place_are_added() {
        let constraints = LinearConstraints::new(1, vec![(0, 0, 0.5), (0, 0, 0.5)], vec![3.0], 1);
        let x = minimise(vec![(0, 0, 1.0)], &[0.0], &constraints).unwrap();
        approx::assert_relative_eq!(x[0], 3.0, max_relative = 1e-7);
    }

    #[test]
    fn what_contradicts_itself_has_no_solution() {
        let rows = vec![(0, 0, 1.0), (1, 0, 1.0)];
        let constraints = LinearConstraints::new(1, rows, vec![1.0, 0.0], 1);
        assert!(minimise(vec![(0, 0, 1.0)], &[0.0], &constraints).is_none());
    }
}
