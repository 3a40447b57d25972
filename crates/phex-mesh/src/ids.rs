//! Typed indices of mesh elements.
//!
//! Every id is a `u32` newtype, so that a vertex number can never be used where a face number is
//! meant.

use serde::{Deserialize, Serialize};
use std::fmt;

/// A typed index that can address a [`PerElement`](crate::PerElement) map.
pub trait ElementId: Copy + Eq + Ord + std::hash::Hash + fmt::Debug {
    /// The id of element number `index`.
    ///
    /// # Panics
    /// If `index` does not fit in a `u32`; meshes that large are refused when they are built.
    fn from_index(index: usize) -> Self;
    /// The element's number, counted from 0.
    fn index(self) -> usize;
}

macro_rules! element_id {
    ($name:ident, $prefix:literal, $doc:literal) => {
        #[doc = $doc]
        #[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(transparent)]
        pub struct $name(u32);

        impl $name {
            /// The id of element number `index`.
            #[inline]
            pub const fn new(index: u32) -> Self {
                Self(index)
            }
            /// The element's number, counted from 0.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl ElementId for $name {
            #[inline]
            fn from_index(index: usize) -> Self {
                Self(u32::try_from(index).expect("element index exceeds u32"))
            }
            #[inline]
            fn index(self) -> usize {
                self.0 as usize
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($prefix, "{}"), self.0)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{}", self.0)
            }
        }
    };
}

element_id!(VertexId, "v", "A vertex of a mesh.");
element_id!(
    HalfEdgeId,
    "h",
    "A half-edge: one side of an edge, directed counter-clockwise round its face."
);
element_id!(EdgeId, "e", "An undirected edge.");
element_id!(FaceId, "f", "A face.");
