//! What can be wrong with a system of equations.

/// Why a system could not be built or factorised.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum NumericError {
    /// A pivot of the factorisation is not positive: the matrix is indefinite or singular.
    #[error("the matrix is not positive definite (pivot {pivot})")]
    NotPositiveDefinite {
        /// Number of the pivot, in the order of elimination.
        pivot: usize,
    },
    /// A row or column number is not below the dimension.
    #[error("entry ({row}, {column}) lies outside a matrix of dimension {dimension}")]
    IndexOutOfRange {
        /// Row of the entry.
        row: u32,
        /// Column of the entry.
        column: u32,
        /// Dimension of the matrix.
        dimension: usize,
    },
    /// A matrix with another sparsity pattern was given to a factorisation that reuses its symbolic
    /// part.
    #[error("the sparsity pattern differs from the one that was analysed")]
    PatternChanged,
    /// The factor does not fit into memory, or its indices do not fit their type.
    #[error("the factor is too large: {reason}")]
    TooLarge {
        /// What overflowed.
        reason: String,
    },
}
