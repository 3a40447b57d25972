//! Report: what a run reached, in numbers.
//!
//! [`RunReport`] is the JSON file of a run around what [`crate::quality`] says of its mesh: inputs
//! with their hashes, settings, times, outputs. [`FeatureSizes`] tells whether panels are small
//! enough for the surface.
//!
//! Guaranteed: pure functions of their arguments; no clock, no file. The deviation to the smooth
//! target and the one to the original facets are always kept apart, since on coarse inputs the
//! facets' own error is the larger of the two.

mod feature_size;
mod run_report;

pub use feature_size::FeatureSizes;
pub use run_report::{InputFile, OutputFile, RunReport, SCHEMA_VERSION, StageTime, Tool};
