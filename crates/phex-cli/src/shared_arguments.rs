//! What can be typed after several commands.

use crate::exit::Failure;
use clap::{Args, ValueEnum};
use phex_job::{AtBoundary, Quantity, Unit};
use std::path::{Path, PathBuf};

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
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "X",
        help_heading = "Tolerances"
    )]
    pub planarity: Option<Quantity>,
    /// Largest distance to the surface: `20mm`, or `0.5%` of the bounding-box diagonal [default:
    /// 0.5%]
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        help_heading = "Tolerances"
    )]
    pub max_deviation: Option<Quantity>,
    /// Unit of the model's coordinates [default: that of a job or run that is given, or m]
    #[arg(long, value_enum)]
    pub unit: Option<Unit>,
}

/// What a mesh is judged by.
#[derive(Clone, Debug, Default, Args)]
pub struct CriteriaArguments {
    /// Surface that the mesh stands for
    #[arg(long, value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Report of the run that made the mesh: its limits, unit and surfaces hold where nothing else
    /// is given
    #[arg(long, value_name = "RUN.JSON")]
    pub report_of: Option<PathBuf>,
    /// Job file whose limits hold where nothing else is given: tolerances, unit, boundary, and the
    /// table `[limits]`
    #[arg(long, value_name = "JOB.TOML", conflicts_with = "report_of")]
    pub limits: Option<PathBuf>,
    /// What panels were to do at the boundary: judges that, too [default: what --report-of says]
    #[arg(long, value_enum, value_name = "HOW")]
    pub boundary: Option<AtBoundary>,
    /// Limits.
    #[command(flatten)]
    pub tolerances: ToleranceArguments,
}

impl CriteriaArguments {
    /// Refuses a limit that has no effect.
    ///
    /// # Errors
    /// If there is one.
    pub fn check(&self) -> Result<(), Failure> {
        self.tolerances
            .check(self.surface.is_some() || self.report_of.is_some())
    }

    /// The files that are named here, behind others that are read.
    pub fn inputs<'a>(&'a self, others: impl IntoIterator<Item = &'a Path>) -> Vec<&'a Path> {
        let here = [&self.surface, &self.report_of, &self.limits];
        let here = here.into_iter().flatten().map(PathBuf::as_path);
        others.into_iter().chain(here).collect()
    }
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
