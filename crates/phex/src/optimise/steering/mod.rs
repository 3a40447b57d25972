//! A mesh led where somebody wants it: what the user holds on to, the boundary exactly on its
//! curve, edges drawn to other lengths.

mod components;
pub(super) mod grounded;
pub(super) mod lengthened;
pub(super) mod on_boundary;
pub(super) mod wishes;
