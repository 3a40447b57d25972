//! Equations: sparse symmetric systems, factorisations, damped descent, projection onto constraints.
//! This crate knows no mesh.
//!
//! | module | what it solves |
//! |---|---|
//! | [`symmetric`] | sparse symmetric matrices, built from triplets |
//! | [`cholesky`] | `A = L L^T` with the symbolic part reused, residual refined |
//! | [`error`] | what can be wrong with a system |

pub mod cholesky;
pub mod error;
pub mod symmetric;

pub use cholesky::Cholesky;
pub use error::NumericError;
pub use symmetric::SymmetricMatrix;
