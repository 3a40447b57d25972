//! Equations: sparse symmetric systems, factorisations, damped descent, projection onto
//! constraints. This crate knows no mesh.
//!
//! | module | what it solves |
//! |---|---|
//! | [`symmetric`] | sparse symmetric and Hermitian matrices, built from triplets |
//! | [`cholesky`] | `A = L L^T` (`L L^H`) with the symbolic part reused, residual refined |
//! | [`assembly`] | sums of dense element blocks on a fixed pattern |
//! | [`mod@conjugate_gradients`] | `A x = b` from products with `A` alone |
//! | [`schur`] | sequential quadratic programming on the dual, factorisations reused |
//! | [`damped`] | descent whose damping follows the collision step |
//! | [`projection`] | minimum-norm projection onto constraints, guarded |
//! | [`lagrange`] | Newton's method on the Lagrangian, to the last digits |
//! | [`quadratic`] | convex quadratic programs, by interior points |
//! | [`outcome`] | how an iteration ended |
//! | [`error`] | what can be wrong with a system |

pub mod assembly;
pub mod cholesky;
pub mod conjugate_gradients;
pub mod damped;
pub mod error;
pub mod lagrange;
pub mod outcome;
pub mod projection;
pub mod quadratic;
pub mod schur;
pub mod symmetric;

pub use assembly::Assembly;
pub use cholesky::{Cholesky, CholeskyNumber, largest, max_abs};
pub use conjugate_gradients::{
    ConjugateGradientOptions, ConjugateGradientResult, conjugate_gradients,
    preconditioned_conjugate_gradients,
};
pub use damped::{DampedOptions, DampedProblem, DampedSolver, Damping};
pub use error::NumericError;
pub use lagrange::{LagrangeNewton, LagrangeOptions, LagrangeProblem};
pub use outcome::{Outcome, Record, Status};
pub use projection::{Constraints, MinimumNorm, ProjectionOptions};
pub use quadratic::{LinearConstraints, Triplet, minimise};
pub use schur::{LaggedCholesky, SchurOptions, SchurProblem, SchurSqp};
pub use symmetric::{Pattern, Scalar, SymmetricMatrix};
