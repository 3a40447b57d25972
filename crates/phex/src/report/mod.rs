//! Report: what a run reached, in numbers and as a picture.

pub mod picture;
