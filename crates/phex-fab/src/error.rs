//! Why workshop files can't be made.

use phex::parallel_mesh::OffsetError;
use phex_mesh::Invalid;
use std::path::PathBuf;
use thiserror::Error;

/// Why workshop files can't be made; panels are named as in the files.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FabError {
    /// A number is out of range.
    #[error("{name} must be {range}, not {value}")]
    Option {
        /// What it is.
        name: &'static str,
        /// What it may be.
        range: &'static str,
        /// What it is.
        value: f64,
    },
    /// The mesh is not valid.
    #[error("{}{cause}", named(.panels))]
    Invalid {
        /// Panels of the first violation.
        panels: Vec<String>,
        /// What is wrong.
        cause: Invalid,
    },
    /// There are no such solids.
    #[error("{}{cause}{}", named(.panels), largest(.safe))]
    Offset {
        /// Panels where it fails.
        panels: Vec<String>,
        /// Largest safe thickness on that side, in model units, where it is known.
        safe: Option<f64>,
        /// What fails.
        cause: OffsetError,
    },
    /// A panel does not fit on a sheet.
    #[error(
        "panel {panel} ({:.0} x {:.0} mm) does not fit on a sheet of {:.0} x {:.0} mm with {spacing} mm around it{}",
        .size[0], .size[1], .sheet[0], .sheet[1], more(.others)
    )]
    TooLarge {
        /// The panel.
        panel: String,
        /// Its least bounding rectangle, in mm.
        size: [f64; 2],
        /// The sheet, in mm.
        sheet: [f64; 2],
        /// The spacing, in mm.
        spacing: f64,
        /// Further panels that do not fit.
        others: usize,
    },
    /// The nesting library refuses a shape.
    #[error("panel {panel} can't be placed on sheets: {cause}")]
    Nest {
        /// The panel.
        panel: String,
        /// What it says.
        cause: String,
    },
    /// The caller wanted the run to end.
    #[error("cancelled")]
    Cancelled,
    /// A file's content can't be made.
    #[error("{name}: {cause}")]
    Content {
        /// The file.
        name: String,
        /// What is wrong.
        cause: String,
    },
    /// The folder can't be used.
    #[error("{}: {cause}", .path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What is wrong.
        cause: String,
    },
}

fn named(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => format!("panel {one}: "),
        many => format!("panels {}: ", many.join(", ")),
    }
}

fn largest(distance: &Option<f64>) -> String {
    distance.map_or(String::new(), |d| {
        format!("; the largest safe thickness on this side is {d:.6}")
    })
}

fn more(count: &usize) -> String {
    match count {
        0 => String::new(),
        n => format!(", and {n} more do not"),
    }
}
