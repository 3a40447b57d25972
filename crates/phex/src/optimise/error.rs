//! Errors of the optimiser.

use crate::ranges::BadOption;
use phex_mesh::{FaceId, VertexId};

/// Mean edges that a vertex is moved at the most to a fixed point.
pub(super) const MOST_MOVE: f64 = 1.5;

/// Why nothing could be optimised.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptimiseError {
    /// A coordinate is not a number or infinite.
    #[error("vertex {vertex} has a coordinate that is not finite")]
    NotFinite {
        /// The vertex.
        vertex: VertexId,
    },
    /// A normal of the layout is not a finite vector.
    #[error("the surface normal at face {face} is not a unit vector")]
    BadNormal {
        /// The face.
        face: FaceId,
    },
    /// A map of the layout has not as many values as the mesh has elements.
    #[error("the layout has {found} {what} for {expected} elements")]
    WrongCount {
        /// Which map.
        what: &'static str,
        /// Number of values.
        found: usize,
        /// Number of elements.
        expected: usize,
    },
    /// All vertices lie at one point.
    #[error("the mesh has no extent")]
    NoExtent,
    /// An option has a value without meaning.
    #[error(transparent)]
    BadOption(#[from] BadOption),
    /// The mesh can't be held as is asked for.
    #[error(transparent)]
    Steering(#[from] SteeringError),
    /// The systems of equations can't be set up.
    #[error(transparent)]
    Numeric(#[from] phex_numeric::NumericError),
}

/// Why a mesh can't be held as is asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SteeringError {
    /// There is no such vertex.
    #[error("vertex {vertex} is to be fixed, but the mesh has {count} vertices (numbered from 0)")]
    NoSuchVertex {
        /// The number.
        vertex: u32,
        /// How many there are.
        count: usize,
    },
    /// A number is not finite, or out of its range.
    #[error("{what} {index} can't be used: {reason}")]
    Unusable {
        /// What is wrong.
        what: &'static str,
        /// Which of them, from 0.
        index: usize,
        /// Why.
        reason: &'static str,
    },
    /// No vertex is near a fixed point.
    #[error(
        "fixed point {index} is {distance:.2} mean edges from the nearest vertex, {vertex}; at most {MOST_MOVE} can be bridged"
    )]
    TooFar {
        /// Which of them, from 0.
        index: usize,
        /// The vertex that is nearest.
        vertex: VertexId,
        /// How far it is, in mean edges.
        distance: f64,
    },
    /// Two demands concern one vertex.
    #[error("{what} {index} needs vertex {vertex}, which another one holds already")]
    Taken {
        /// What is demanded.
        what: &'static str,
        /// Which of them, from 0.
        index: usize,
        /// The vertex.
        vertex: VertexId,
    },
    /// A curve or plane is to hold the boundary of a closed surface.
    #[error("the surface is closed: it has no boundary that {what} could hold")]
    NoBoundary {
        /// Curve or plane.
        what: &'static str,
    },
    /// A curve or plane holds nothing.
    #[error("no vertex of the boundary lies within {reach} mean edges of {what}")]
    NothingNear {
        /// Curve or plane.
        what: &'static str,
        /// How near it would have to be.
        reach: f64,
    },
    /// Moving vertices to their places breaks a panel.
    #[error("face {face} crosses itself when held vertices are moved to their places")]
    Crossed {
        /// The face.
        face: FaceId,
    },
    /// A face is held so that it can't be planar.
    #[error(
        "face {face} can't become planar: {count} of its corners are fixed, and lie up to {distance:.1e} mean edges off a plane"
    )]
    OverConstrained {
        /// The face.
        face: FaceId,
        /// Its fixed corners.
        count: usize,
        /// Their largest distance to their best plane, mean edges.
        distance: f64,
    },
}
