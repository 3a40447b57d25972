//! What can be typed after several commands.

use crate::exit::Failure;
use clap::{Args, ValueEnum};
use phex_job::{Quantity, Unit};
use std::path::PathBuf;

/// How progress is shown, on standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ProgressMode {
    /// A bar on a terminal, else nothing.
    #[default]
    Auto,
    /// Nothing.
    None,
    /// One JSON object a line.
    Json,
}

/// How the program talks.
#[derive(Clone, Debug, Default, Args)]
pub struct Talk {
    /// Progress on standard error: a bar on a terminal, nothing, or a JSON object a line
    /// (`progress`: share done of the whole run, seconds left, about)
    #[arg(
        long,
        value_enum,
        default_value_t,
        value_name = "MODE",
        help_heading = "Messages"
    )]
    pub progress: ProgressMode,
    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Messages")]
    pub quiet: bool,
    /// Say more: each stage, what was repaired in the input, every check
    #[arg(short, long, help_heading = "Messages")]
    pub verbose: bool,
}

/// Files written besides the mesh.
#[derive(Clone, Debug, Default, Args)]
pub struct Extras {
    /// Write the run report (JSON): settings, times, figures, checks with the ids of the offenders
    #[arg(long, value_name = "RUN.JSON", help_heading = "Files")]
    pub report: Option<PathBuf>,
    /// Draw a shaded picture with the panel edges
    #[arg(long, value_name = "PICTURE.PNG", help_heading = "Files")]
    pub png: Option<PathBuf>,
    /// Write the report as one HTML file: interactive view, colour maps, checks; needs no network
    #[arg(long, value_name = "RUN.HTML", help_heading = "Files")]
    pub html: Option<PathBuf>,
}

/// Tolerances, and the unit that lengths refer to.
#[derive(Clone, Debug, Default, Args)]
pub struct ToleranceArguments {
    /// Largest distance of a corner to its panel's plane: a number is mean edges, `0.1mm` a length
    /// [default: 1e-12, or rounding]
    #[arg(long, value_name = "X", help_heading = "Tolerances")]
    pub planarity: Option<Quantity>,
    /// Largest distance to the surface: `20mm`, or `0.5%` of the bounding-box diagonal [default:
    /// 0.5%]
    #[arg(long, value_name = "LENGTH", help_heading = "Tolerances")]
    pub max_deviation: Option<Quantity>,
    /// Unit of the model's coordinates [default: that of the job or run whose limits hold, or m]
    #[arg(long, value_enum)]
    pub unit: Option<Unit>,
}

impl ToleranceArguments {
    /// Refuses a limit of the distance to a surface where there is no surface.
    ///
    /// # Errors
    /// If there is such a limit.
    pub fn check(&self, has_surface: bool) -> Result<(), Failure> {
        match self.max_deviation.filter(|_| !has_surface) {
            None => Ok(()),
            Some(limit) => Err(Failure::input(format!(
                "--max-deviation {limit} has no effect without a surface: give --surface"
            ))),
        }
    }
}
