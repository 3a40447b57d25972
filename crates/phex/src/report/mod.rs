//! Report: what a run reached, in numbers and as a picture.
//!
//! [`RunReport`] is the JSON file of a run around what [`crate::quality`] says of its mesh: inputs with their hashes, settings, times, outputs.
//! [`maps`] says which colour each panel and edge has, [`picture`] draws the mesh in them.
//!
//! Guaranteed: pure functions of their arguments; no clock, no file. The deviation to the smooth target and the one to the
//! original facets are always kept apart, since on coarse inputs the facets' own error is the larger of the two.

pub mod maps;
pub mod picture;
mod run_report;

pub use run_report::{InputFile, OutputFile, RunReport, SCHEMA_VERSION, StageTime, Tool};
