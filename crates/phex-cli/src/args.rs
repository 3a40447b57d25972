//! The command line: what can be typed. What it means is said by the commands.

use crate::dual_arguments::{DualCommand, DupinCommand, PowerCommand, SubdivideCommand};
use crate::exit::EXIT_CODES;
use crate::fab_arguments::FabCommand;
use crate::html;
use crate::offset_arguments::OffsetCommand;
use crate::parallel_arguments::ParallelCommand;
use crate::picture_arguments::{RenderCommand, ReportCommand};
use crate::shared_arguments::{CriteriaArguments, Extras, Talk, ToleranceArguments};
use crate::sweep_arguments::SweepCommand;
use crate::terms::TERMS;
use clap::builder::PossibleValuesParser;
use clap::{Args, Parser, Subcommand, ValueEnum};
use phex_job::SteeringSettings;
use phex_job::number;
use phex_job::three;
use phex_job::{LastStage, MeshSettings, Quantity, Unit};
use phex_mesh::shapes::Shape;
use std::path::PathBuf;
use std::time::Duration;

/// Planar hexagonal meshes of free-form surfaces
#[derive(Debug, Parser)]
#[command(name = "phex", version, long_version = html::long_version(), after_help = EXIT_CODES, max_term_width = 110)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Cover a surface with planar hexagonal panels
    Mesh(Box<MeshCommand>),
    /// Write a conjugate curve network of a surface, for drawing
    Network(Box<NetworkCommand>),
    /// Make the faces of a polygon mesh planar (three faces at each interior vertex)
    Planarize(PlanarizeCommand),
    /// Offset a planar mesh: layers, solid panels, beams, Gauss image
    Offset(Box<OffsetCommand>),
    /// Write workshop files: flat labelled panels on sheets (DXF, SVG), schedules (CSV, XLSX),
    /// solids (STL, OBJ)
    Fab(Box<FabCommand>),
    /// Judge any polygon mesh: planar, simple, sound, close to a surface; lists offenders by id
    Check(CheckCommand),
    /// Write the report of a mesh as one HTML file: interactive view, colour maps, checks
    Report(ReportCommand),
    /// Draw a mesh in the colours of a map, as PNG or SVG
    Render(RenderCommand),
    /// Say what is in a surface or mesh file, and what is wrong with it
    Info(InfoCommand),
    /// Convert between OBJ, PLY, OFF and STL, or write COMPAS JSON, glTF (.glb), DXF and 3MF
    Convert(ConvertCommand),
    /// Write a built-in surface
    Shape(ShapeCommand),
    /// Make the convex mesh with a given graph whose edges all touch the unit sphere
    Koebe(KoebeCommand),
    /// Make meshes that have the edge directions of a given one: closest to a surface, or with edge
    /// lengths as wished; measure their space
    Parallel(ParallelCommand),
    /// Dualise a mesh: faces become vertices, vertices faces; twice gives a closed mesh back, an
    /// open one without its outer ring
    Dual(DualCommand),
    /// Refine a mesh with planar faces, four panels for one
    Subdivide(SubdivideCommand),
    /// Make geodesic domes and other polyhedra about spheres and ellipsoids from sites in the plane
    PowerDiagram(PowerCommand),
    /// Write Dupin's indicatrices of a surface, for drawing
    Dupin(DupinCommand),
    /// Solve every variant of a study, each in its folder; `collect`: a table and a page of all
    Sweep(SweepCommand),
    /// Open a page in the browser on which a surface becomes panels; served on this machine alone
    #[cfg(feature = "studio")]
    Studio(StudioCommand),
    /// Say what the words of the tables mean
    #[command(long_about = TERMS)]
    Terms(TermsCommand),
    /// Say what this program and this machine have, and try them with a small run
    Doctor(DoctorCommand),
    /// Write the reference of commands, manual pages or completions of shells, for packages
    #[command(hide = true)]
    Generate(GenerateCommand),
}

impl Command {
    /// How the command talks.
    pub fn talk(&self) -> &Talk {
        match self {
            Self::Mesh(c) => &c.talk,
            Self::Network(c) => &c.talk,
            Self::Planarize(c) => &c.talk,
            Self::Offset(c) => &c.talk,
            Self::Fab(c) => &c.talk,
            Self::Check(c) => &c.talk,
            Self::Report(c) => &c.talk,
            Self::Render(c) => &c.talk,
            Self::Info(c) => &c.talk,
            Self::Convert(c) => &c.talk,
            Self::Shape(c) => &c.talk,
            Self::Koebe(c) => &c.talk,
            Self::Parallel(c) => &c.talk,
            Self::Dual(c) => &c.talk,
            Self::Subdivide(c) => &c.talk,
            Self::PowerDiagram(c) => &c.talk,
            Self::Dupin(c) => &c.talk,
            Self::Sweep(c) => c.talk(),
            #[cfg(feature = "studio")]
            Self::Studio(c) => &c.talk,
            Self::Terms(c) => &c.talk,
            Self::Doctor(c) => &c.talk,
            Self::Generate(c) => &c.talk,
        }
    }
}

/// Arguments of `phex mesh`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct MeshCommand {
    /// Surface: OBJ, PLY, STL or OFF, triangles or polygons
    #[arg(value_name = "SURFACE")]
    pub input: PathBuf,
    /// Mesh to write: OBJ, PLY, OFF, COMPAS JSON and DXF keep the panels; GLB, STL and 3MF hold
    /// triangles
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
    /// What is wanted.
    #[command(flatten)]
    pub settings: MeshSettings,
    /// Read settings from a TOML file (the names of these options); the command line comes first
    #[arg(long, value_name = "JOB.TOML")]
    pub config: Option<PathBuf>,
    /// Go on from an earlier mesh of the surface instead of laying out panels: after a change of
    /// weights, surface or what is held
    #[arg(long, value_name = "MESH")]
    pub start: Option<PathBuf>,
    /// End after a stage: `layout` writes the panels as they are laid out, neither planar nor
    /// checked, to look at
    #[arg(long, value_enum, value_name = "STAGE", conflicts_with_all = ["start", "write_target", "keep_invalid", "keep_best"])]
    pub until: Option<LastStage>,
    /// Write the smooth surface through the input's vertices that the panels were fitted to
    #[arg(long, value_name = "SURFACE", help_heading = "Files")]
    pub write_target: Option<PathBuf>,
    /// Draw the result and all ways that were tried side by side, with their figures: PNG or HTML
    /// (with `--effort best` there are most of them)
    #[arg(long, value_name = "SHEET", value_parser = crate::contact::sheet_path, conflicts_with_all = ["start", "until"], help_heading = "Files")]
    pub contact_sheet: Option<PathBuf>,
    /// Write the mesh even if it is not valid (the exit code is still 5)
    #[arg(long, help_heading = "Files")]
    pub keep_invalid: bool,
    /// On Ctrl-C, end with the best mesh so far: it is judged and written as ever (a second Ctrl-C
    /// ends at once)
    #[arg(long, help_heading = "Time")]
    pub keep_best: bool,
    /// End after a time, `90s`, `5min` or `1h`, with the best mesh so far: it is judged and written
    /// as ever
    #[arg(long, value_name = "TIME", value_parser = phex_job::time_limit, help_heading = "Time")]
    pub time_limit: Option<Duration>,
    /// Report and picture.
    #[command(flatten)]
    pub extras: Extras,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex network`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct NetworkCommand {
    /// Surface: OBJ, PLY, STL or OFF, triangles or polygons
    #[arg(value_name = "SURFACE")]
    pub input: PathBuf,
    /// OBJ file to write: polylines in the groups `rows` and `columns`
    #[arg(short, long, value_name = "NETWORK.OBJ")]
    pub output: PathBuf,
    /// Number of panels, about, that a brick wall on the curves would have
    #[arg(
        short = 'n',
        long,
        allow_negative_numbers = true,
        value_name = "N",
        default_value_t = 500
    )]
    pub panels: u64,
    /// Let columns follow a direction, e.g. `0,0,1`, with rows conjugate to them, instead of the
    /// lines of curvature
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    pub columns_along: Option<[f64; 3]>,
    /// Number of threads; the result does not depend on it
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex planarize`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct PlanarizeCommand {
    /// Polygon mesh: OBJ, PLY or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Mesh to write
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
    /// Surface to stay close to; without it, the mesh stays close to where it is
    #[arg(long, value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Limits.
    #[command(flatten)]
    pub limits: ToleranceArguments,
    /// What is held, and the dials.
    #[command(flatten)]
    pub steering: SteeringSettings,
    /// Optimise the whole way even if the mesh is planar already: a warm start; a dial implies it
    #[arg(long)]
    pub refit: bool,
    /// Read `[steering]` and `[stages.optimise]` from a job file of `phex mesh`; the command line
    /// comes first
    #[arg(long, value_name = "JOB.TOML")]
    pub config: Option<PathBuf>,
    /// Number of threads; the result does not depend on it
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Write the mesh even if it is not valid (the exit code is still 5)
    #[arg(long, help_heading = "Files")]
    pub keep_invalid: bool,
    /// Report and picture.
    #[command(flatten)]
    pub extras: Extras,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex check`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct CheckCommand {
    /// Polygon mesh: OBJ, PLY, STL or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Surface and limits.
    #[command(flatten)]
    pub judged_by: CriteriaArguments,
    /// Print the report (JSON) instead of the table
    #[arg(long)]
    pub json: bool,
    /// Pack mesh, surface, job, reports and versions into one file, to be sent with a complaint
    #[arg(long, value_name = "FILE.ZIP", help_heading = "Files")]
    pub bundle: Option<PathBuf>,
    /// Report and picture.
    #[command(flatten)]
    pub extras: Extras,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex info`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct InfoCommand {
    /// Surface or polygon mesh: OBJ, PLY, STL or OFF
    #[arg(value_name = "FILE")]
    pub input: PathBuf,
    /// Say how many panels have edges of about this length, and how far off they would be
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        help_heading = "Panels"
    )]
    pub edge_length: Option<Quantity>,
    /// Say how many panels would be about this near to the surface: `20mm`, `0.5%` of the diagonal
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        help_heading = "Panels"
    )]
    pub max_deviation: Option<Quantity>,
    /// Unit of the model's coordinates
    #[arg(long, value_enum, default_value_t)]
    pub unit: Unit,
    /// Print JSON instead of the table
    #[arg(long)]
    pub json: bool,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex convert`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct ConvertCommand {
    /// File to read: OBJ, PLY, STL or OFF
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// File to write; the extension decides the format
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Unit of the coordinates: GLB and 3MF are written in metres [default: m]
    #[arg(long, value_enum)]
    pub unit: Option<Unit>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex shape`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct ShapeCommand {
    /// Name of the surface
    #[arg(
        required_unless_present = "list",
        hide_possible_values = true,
        value_parser = PossibleValuesParser::new(Shape::all().iter().map(|shape| shape.name))
    )]
    pub name: Option<String>,
    /// Surface to write: OBJ, PLY, STL or OFF
    #[arg(short, long, value_name = "SURFACE", required_unless_present = "list")]
    pub output: Option<PathBuf>,
    /// List the surfaces and their parameters
    #[arg(long)]
    pub list: bool,
    /// Number of triangles, about
    #[arg(long, allow_negative_numbers = true, default_value_t = 8000)]
    pub triangles: usize,
    /// Move vertices at random by up to this share of an edge (0 to 0.4)
    #[arg(long, allow_negative_numbers = true, default_value_t = 0.0)]
    pub jitter: f64,
    /// Seed of the random moves
    #[arg(
        long,
        allow_negative_numbers = true,
        default_value_t = 0,
        requires = "jitter"
    )]
    pub seed: u64,
    /// Set a parameter of the surface, e.g. `--set minor=0.3`; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = parameter)]
    pub parameters: Vec<(String, f64)>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex studio`.
#[cfg(feature = "studio")]
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct StudioCommand {
    /// Surface to begin with: OBJ, PLY, STL or OFF
    #[arg(value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Port to listen to, on 127.0.0.1 only [default: any that is free]
    #[arg(long, value_name = "N", default_value_t = 0, hide_default_value = true)]
    pub port: u16,
    /// Print the address and open no browser
    #[arg(long)]
    pub no_open: bool,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex terms`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct TermsCommand {
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Arguments of `phex doctor`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct DoctorCommand {
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// What packages hold besides the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Generated {
    /// All commands with their options, as Markdown
    Reference,
    /// Manual pages
    Man,
    /// Completions of all shells
    Completions,
}

/// Arguments of `phex generate`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct GenerateCommand {
    /// What to write
    #[arg(value_enum)]
    pub what: Generated,
    /// Folder to write to; the reference goes to standard output
    #[arg(
        short,
        long,
        value_name = "FOLDER",
        required_if_eq_any = [("what", "man"), ("what", "completions")]
    )]
    pub output: Option<PathBuf>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// What is given at the boundary of a Koebe patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum KoebeBoundary {
    /// Circles of one size at all boundary vertices
    #[default]
    EqualRadii,
    /// Circles as large as the input's normals turn
    GaussImage,
    /// Angles as the input has them
    Angles,
}

/// Arguments of `phex koebe`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct KoebeCommand {
    /// Polygon mesh, closed or with one boundary; its connectivity counts, its shape only turns the
    /// result
    #[arg(value_name = "GRAPH")]
    pub input: PathBuf,
    /// Mesh to write: OBJ, PLY or OFF
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
    /// What is given at the boundary of an open mesh [default: equal-radii]
    #[arg(long, value_enum)]
    pub boundary: Option<KoebeBoundary>,
    /// Angle in degrees between the middle of an open mesh and its boundary, seen from the centre
    /// (0 to 180) [default: 60]
    #[arg(long, allow_negative_numbers = true, value_name = "DEGREES")]
    pub opening: Option<f64>,
    /// Write the mesh even if it is not valid (the exit code is still 5)
    #[arg(long, help_heading = "Files")]
    pub keep_invalid: bool,
    /// Report and picture.
    #[command(flatten)]
    pub extras: Extras,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

fn parameter(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("write NAME=VALUE")?;
    Ok((name.trim().to_owned(), number(value.trim())?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn every_command_s_help_lists_the_exit_codes() {
        for command in Arguments::command().get_subcommands() {
            assert_eq!(
                command.get_after_help().map(ToString::to_string).as_deref(),
                Some(EXIT_CODES)
            );
        }
    }
}
