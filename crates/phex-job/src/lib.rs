//! A job of phex: what is wanted of a mesh, in words that people type, and one function that does
//! it. The program, the Python package and whatever else takes jobs call [`run`], so that a job
//! file means the same in all of them.
//!
//! | module | what it knows |
//! |---|---|
//! | `settings`, `steering`, `guides`, `panel_limits` | what is wanted, by the names of options and job files |
//! | `command_line` | a job as it is typed |
//! | `units`, `sheet`, `number_lists` | lengths, areas and lists of numbers as they are typed |
//! | `input`, `toml_text`, `given` | what files hold, or a caller's memory |
//! | `file_info` | what is in a file, and what is wrong with it |
//! | `suggestion` | what kind of surface one is, and how many panels suit it |
//! | `effects`, `panel_size`, `hexagon`, `size_field` | whether that makes sense |
//! | `run`, `crumbs`, `join`, `engine`, `deadline`, `threads` | the computation |
//! | `output`, `output_paths` | in which unit files hold meshes; whether files can be written |
//! | `limits`, `wishes`, `portfolio`, `ways` | what was reached, measured by what was wanted |
//! | `whole_run` | how much is done |
//!
//! Nothing here writes a file, prints, or ends a program; a computation uses the threads of the
//! pool that it is called in.

mod command_line;
mod crumbs;
mod deadline;
mod effects;
mod engine;
mod error;
mod file_info;
mod given;
mod guides;
mod hexagon;
mod input;
mod join;
mod limits;
mod number_lists;
mod output;
mod output_paths;
mod panel_limits;
mod panel_size;
mod portfolio;
mod run;
mod settings;
mod sheet;
mod size_field;
mod steering;
mod suggestion;
mod threads;
mod toml_text;
mod units;
mod ways;
mod whole_run;
mod wishes;

pub use command_line::{options_of, quoted};
pub use crumbs::without_crumbs;
pub use deadline::{TimeLimit, time_limit};
pub use engine::{Computed, Planarization, network, planarize, subdivide};
pub use error::{JobError, chain};
pub use file_info::{ComponentInfo, FileInfo, ProblemPlace};
pub use given::Given;
pub use guides::GuideSettings;
pub use input::{
    MeshFile, NumberLine, edges_by_vertices, number, read_numbers, read_polylines, read_text,
    sha256,
};
pub use limits::{TypedLimits, check_distances};
pub use number_lists::{finite, ten, three};
pub use output::in_file;
pub use output_paths::{Content, OutputPaths};
pub use panel_limits::LimitSettings;
pub use panel_size::panels;
pub use portfolio::members;
pub use run::{JobResult, LAYOUT_ALONE, LastStage, MeshJob, add_features, lay_out, run, sessions};
pub use settings::{
    AtBoundary, CloseTo, DEFAULT_DEVIATION, LayoutMethod, MeshSettings, TypedPanelSize,
};
pub use sheet::{NoSheet, NoWorkshopLength, SheetSize, WorkshopLength};
pub use steering::{SteeringSettings, TypedPlane, TypedSolver, positive};
pub use suggestion::{Suggestion, SurfaceKind};
pub use threads::thread_count;
pub use toml_text::{LONGEST_TOML, from_json, from_toml};
pub use units::{Area, NoQuantity, NoSize, Quantity, Rectangle, Unit, four_digits};
pub use ways::{WayShown, ways};
pub use whole_run::{WholeProgress, WholeRun};
