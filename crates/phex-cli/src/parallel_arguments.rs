//! What can be typed after `phex parallel`.

use crate::exit::EXIT_CODES;
use crate::shared_arguments::{Extras, Talk, ToleranceArguments};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// Where the fit of a parallel mesh begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ParallelStart {
    /// Where the surface has the mesh's normals
    #[default]
    Normals,
    /// Where the surface is closest to the mesh
    Positions,
}

/// Arguments of `phex parallel`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct ParallelCommand {
    /// Mesh with planar faces: OBJ, PLY or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Surface to come close to
    #[arg(long, value_name = "SURFACE", requires = "output")]
    pub surface: Option<PathBuf>,
    /// Edge lengths to come close to: lines of `from to length` with the numbers of two vertices,
    /// counted from 0; other edges keep theirs
    #[arg(
        long,
        value_name = "LENGTHS.TXT",
        requires = "output",
        conflicts_with = "surface"
    )]
    pub lengths: Option<PathBuf>,
    /// Mesh to write
    #[arg(short, long, value_name = "MESH")]
    pub output: Option<PathBuf>,
    /// Write a sparse basis of the space of parallel meshes: changes of edge lengths after which
    /// every face still closes (1000 panels take about a second)
    #[arg(long, value_name = "BASIS.CSV", help_heading = "Files")]
    pub basis: Option<PathBuf>,
    /// Edges that run against those of the given mesh, as they do where the surface is
    /// saddle-shaped: `rule` (the sign rule of the surface's normal curvatures), or a file with
    /// lines of `from to`, the numbers of two vertices, counted from 0 [default: none]
    #[arg(long, value_name = "rule|EDGES.TXT", requires = "surface")]
    pub signs: Option<PathBuf>,
    /// Give all panels the mean curvature 0, with the given mesh as Gauss image
    #[arg(long, requires = "surface")]
    pub minimal: bool,
    /// Where the fit begins
    #[arg(long, value_enum, default_value_t, requires = "surface")]
    pub start: ParallelStart,
    /// Shortest edge allowed, over the mean edge (0 to 1)
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "X",
        default_value_t = 0.05,
        requires = "surface"
    )]
    pub least_edge: f64,
    /// Weight of edge lengths in proportion to the input's, or with --signs those of the sign rule,
    /// over that of closeness [default: 0.001, with --signs 0.03]
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "X",
        requires = "surface"
    )]
    pub fairness: Option<f64>,
    /// Weight of one mean curvature for all faces, over that of closeness
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "X",
        default_value_t = 0.0,
        requires = "surface"
    )]
    pub constant_mean_curvature: f64,
    /// Limits.
    #[command(flatten)]
    pub limits: ToleranceArguments,
    /// Write the mesh even if it is not valid (the exit code is still 5)
    #[arg(long, help_heading = "Files", requires = "output")]
    pub keep_invalid: bool,
    /// Report and picture.
    #[command(flatten)]
    pub extras: Extras,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}
