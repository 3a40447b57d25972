//! Report: what a run reached, in numbers.
//!
//! [`Assessment`] measures a mesh, compares it with the surfaces that it stands for and says what holds: each
//! [`Check`] is a figure, a limit, the elements that exceed it, and the worst place; all of them together give the [`Verdict`]. What could not be
//! checked is told ([`Omitted`]).
//! [`RunReport`] is the JSON file of a run around it: inputs with their hashes, settings, times, outputs.
//! [`FeatureSizes`] tells whether panels are small enough for the surface.
//!
//! | verdict | when |
//! |---|---|
//! | pass | every check holds |
//! | outside tolerance | a figure is outside a limit: planarity, deviation, edge length, clearance, folds, topology, boundary, covered area |
//! | invalid | the mesh is no panelling: a face not simple, folded back or flipped, a vertex covered twice or of wrong degree, an edge through a face |
//!
//! Guaranteed: pure functions of their arguments; no clock, no file. The deviation to the smooth target and the one to the
//! original facets are always kept apart, since on coarse inputs the facets' own error is the larger of the two.

mod assessment;
mod check;
mod feature_size;
mod run_report;

pub use assessment::{Assessment, Omitted, Reason, References, Tolerances, Verdict};
pub use check::{Check, ElementKind, Reading, Scale};
pub use feature_size::FeatureSizes;
pub use run_report::{InputFile, OutputFile, RunReport, SCHEMA_VERSION, StageTime, Tool};
