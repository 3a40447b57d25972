//! Studies: many jobs of phex, a folder for each, and a table and a page of all of them.
//!
//! | module | what it knows |
//! |---|---|
//! | `study` | a study file: lists and ranges of settings, and every variant of them |
//! | `variant` | one job of a study, and the name of its folder |
//! | `limits` | time and memory that a variant may take |
//! | `solve` | one variant into its folder |
//! | `row` | what a table tells of a variant |
//! | `workshop` | what its panels mean to a workshop |
//! | `table` | all rows of a folder, CSV |
//! | `thumbnail`, `page` | all of it as one HTML page |
//!
//! The program and the Python package both call [`solve`], so that a variant has one folder, one
//! mesh and one row, whichever engine asked for it.
//!
//! Guaranteed: a folder's name is made of everything that its result depends on; `run.json` is
//! written last, whole, so that a folder with it is finished; a variant without a valid mesh is a
//! row that says why, and no error; equal variants give equal rows and equal meshes.

mod limits;
mod page;
mod row;
mod solve;
mod study;
mod table;
mod thumbnail;
mod variant;
mod workshop;

pub use limits::{VariantLimits, memory_limit};
pub use page::page;
pub use row::{Row, lost};
pub use solve::{RUN_FILE, SolveOptions, finished, solve};
pub use study::{Shard, StudyFile};
pub use table::{Collected, collect, csv};
pub use variant::{Variant, keys};
pub use workshop::Workshop;
