//! Why workshop files can't be made.

use crate::options::Rotations;
use phex::offset::{OffsetError, rounded_down};
use phex_mesh::{Invalid, Violation};
use std::fmt;
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
    #[error("{}{cause}{}", named(.panels), flat(.cause))]
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
    /// No panel fits on a sheet, however small it is.
    #[error("a sheet of {} x {} mm has no room for a panel with {spacing} mm around it", sheet[0], sheet[1])]
    NoRoom {
        /// The sheet, in mm.
        sheet: [f64; 2],
        /// The spacing, in mm.
        spacing: f64,
    },
    /// Panels do not fit on a sheet.
    #[error("{0}")]
    TooLarge(Box<TooLarge>),
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
}

fn named(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => format!("panel {one}: "),
        many => format!("panels {}: ", first_of(many)),
    }
}

/// Most panels that a message names.
const NAMED: usize = 10;
/// Side of a sheet beyond which the unit of the model is in doubt, in mm.
const NO_SHEET: f64 = 2e4;

/// The first of some names, and how many more there are.
fn first_of(names: &[String]) -> String {
    let first = names[..names.len().min(NAMED)].join(", ");
    match names.len().saturating_sub(NAMED) {
        0 => first,
        more => format!("{first} and {more} more"),
    }
}

/// What helps where only planarity is missed.
fn flat(cause: &Invalid) -> &'static str {
    let decisive = cause.violations.first().is_some_and(Violation::is_decisive);
    if decisive {
        ""
    } else {
        "; plates are flat: make the panels planar first"
    }
}

fn largest(distance: &Option<f64>) -> String {
    distance.map_or(String::new(), |d| {
        let told = rounded_down(d);
        format!("; the largest safe thickness on this side is {told} (model units)")
    })
}

/// Panels that do not fit on a sheet, and the sheets that would do.
#[derive(Clone, Debug, PartialEq)]
pub struct TooLarge {
    /// All of them; at least one.
    pub panels: Vec<String>,
    /// Length along and across the sheet that the first one needs in the rotations that are
    /// allowed, in mm.
    pub size: [f64; 2],
    /// The sheet, in mm.
    pub sheet: [f64; 2],
    /// The spacing, in mm.
    pub spacing: f64,
    /// How panels may be turned.
    pub rotations: Rotations,
    /// The smallest sheet that holds any of the panels of the mesh, in mm.
    pub smallest: [f64; 2],
    /// The same if panels could be turned freely, where they can't.
    pub smallest_free: Option<[f64; 2]>,
}

impl fmt::Display for TooLarge {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([length, width], [long, wide]) = (self.size, self.sheet);
        write!(
            f,
            "panel {} ({length:.1} x {width:.1} mm) does not fit on a sheet of {long} x {wide} mm with {} mm around it",
            self.panels[0], self.spacing
        )?;
        match self.panels.as_slice() {
            [] | [_] => {}
            [_, other] => write!(f, ", nor does {other}")?,
            [_, others @ ..] => {
                write!(f, ", nor do {} more: {}", others.len(), first_of(others))?;
            }
        }
        if let Some(angles) = self.rotations.limited() {
            let angles: Vec<String> = angles.iter().map(f64::to_string).collect();
            let angles = angles.join(", ");
            write!(f, "; panels may be turned by {angles} degrees only")?;
        }
        let [a, b] = self.smallest;
        write!(f, "; the smallest sheet for all panels is {a} x {b} mm")?;
        if let Some([a, b]) = self.smallest_free {
            write!(f, ", and {a} x {b} mm if they may be turned freely")?;
        }
        if a.max(b) > NO_SHEET {
            write!(f, ": is the unit of the model right?")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(panels: usize, side: f64) -> String {
        let error = TooLarge {
            panels: (1..=panels).map(|k| format!("P{k}")).collect(),
            size: [side, side],
            sheet: [2500.0, 1250.0],
            spacing: 5.0,
            rotations: Rotations::default(),
            smallest: [side, side],
            smallest_free: None,
        };
        error.to_string()
    }

    #[test]
    fn many_panels_are_counted_and_the_unit_is_doubted() {
        assert!(!told(1, 3000.0).contains("nor"));
        assert!(told(2, 3000.0).contains(", nor does P2; "));
        assert!(told(3, 3000.0).contains(", nor do 2 more: P2, P3; "));
        let many = told(793, 1e6);
        assert!(many.contains(", nor do 792 more: P2, "), "{many}");
        assert!(many.contains("P11 and 782 more; "), "{many}");
        assert!(!many.contains("P12"), "{many}");
        assert!(many.ends_with("is the unit of the model right?"), "{many}");
        assert!(!told(793, 3000.0).contains("unit"));
    }
}
