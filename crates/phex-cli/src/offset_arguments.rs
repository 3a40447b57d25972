//! What can be typed after `phex offset`.

use crate::exit::EXIT_CODES;
use crate::shared_arguments::Talk;
use clap::{Args, ValueEnum};
use phex::offset::OffsetKind;
use phex_job::DEFAULT_DEVIATION;
use phex_job::{Quantity, Unit};
use phex_mesh::io::shown;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Arguments of `phex offset`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct OffsetCommand {
    /// Mesh with planar faces, three at each interior vertex: OBJ, PLY or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Folder to write the layers into; only files that an earlier run wrote are written over
    #[arg(
        short,
        long,
        value_name = "FOLDER",
        required_unless_present = "max_distance"
    )]
    pub output: Option<PathBuf>,
    /// What keeps its distance
    #[arg(long, value_enum, default_value_t)]
    pub kind: Kind,
    /// Distances of the layers, e.g. `0.05,-20mm,1%`; positive on the side of the face normals
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub distance: Vec<SignedLength>,
    /// One layer with a distance for each face: a text file with a number (model units) a line
    #[arg(long, value_name = "FILE", conflicts_with = "distance")]
    pub face_distances: Option<PathBuf>,
    /// Print the largest distances to both sides that give a valid mesh
    #[arg(long)]
    pub max_distance: bool,
    /// Move the vertices first so that the angle condition of a vertex offset holds
    #[arg(long)]
    pub optimise: bool,
    /// Surface to stay close to when optimising
    #[arg(long, value_name = "SURFACE", requires = "optimise")]
    pub surface: Option<PathBuf>,
    /// Largest distance of the moved vertices and of panel centres to that surface, or to the given
    /// mesh
    #[arg(
        long, allow_hyphen_values = true,
        value_name = "LENGTH",
        default_value_t = DEFAULT_DEVIATION,
        requires = "optimise",
        help_heading = "Tolerances"
    )]
    pub max_deviation: Quantity,
    /// Also write closed panels with mitred sides between successive layers (one layer: between the
    /// mesh and it)
    #[arg(long, help_heading = "Files")]
    pub solids: bool,
    /// Width of the joints between solid panels, in the planes of their faces
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        requires = "solids",
        help_heading = "Files"
    )]
    pub gap: Option<Quantity>,
    /// Also write the axes of beams and nodes between successive layers (CSV)
    #[arg(long, help_heading = "Files")]
    pub beams: bool,
    /// Also write the Gauss image, a parallel mesh that touches the unit sphere
    #[arg(long, conflicts_with = "face_distances", help_heading = "Files")]
    pub gauss_image: bool,
    /// Format of the meshes
    #[arg(long, value_enum, default_value_t, help_heading = "Files")]
    pub format: MeshFormat,
    /// Write what was done and measured (JSON)
    #[arg(long, value_name = "RUN.JSON", help_heading = "Files")]
    pub report: Option<PathBuf>,
    /// Largest distance of a corner to its face's plane: a number is mean edges, `0.1mm` a length
    /// [default: 1e-12, or rounding]
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "X",
        help_heading = "Tolerances"
    )]
    pub planarity: Option<Quantity>,
    /// Unit of the model's coordinates
    #[arg(long, value_enum, default_value_t)]
    pub unit: Unit,
    /// Number of threads; the result does not depend on it
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// What keeps its distance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Planes of faces: every mesh has it.
    #[default]
    Face,
    /// Edges: the mesh must be parallel to one whose edges touch a sphere (see `phex koebe`, `phex
    /// parallel`).
    Edge,
    /// Vertices: faces must satisfy an angle condition (see `--optimise`).
    Vertex,
}

impl From<Kind> for OffsetKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Face => Self::Face,
            Kind::Edge => Self::Edge,
            Kind::Vertex => Self::Vertex,
        }
    }
}

/// Formats that keep polygons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    #[default]
    Obj,
    /// Stanford PLY.
    Ply,
    /// Object File Format.
    Off,
}

impl MeshFormat {
    /// The file name's extension.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Off => "off",
        }
    }
}

/// A length with a sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedLength {
    negative: bool,
    size: Quantity,
}

impl SignedLength {
    /// The length in model units; a percentage refers to `whole`.
    pub fn length(self, model_unit: Unit, whole: f64) -> f64 {
        let size = self.size.length(model_unit, whole);
        if self.negative { -size } else { size }
    }
}

impl FromStr for SignedLength {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let bare = text.strip_prefix('-');
        let size = bare.unwrap_or(text).parse();
        Ok(Self {
            negative: bare.is_some(),
            size: size.map_err(|_| {
                format!(
                    "`{}` is no distance: give a number, negative on the side that face normals point away from, with \
                     mm, cm, m, in, ft, % or nothing after it",
                    shown(text)
                )
            })?,
        })
    }
}

impl fmt::Display for SignedLength {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.negative { "-" } else { "" };
        write!(f, "{sign}{}", self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signed_lengths() {
        let length = |text: &str| {
            text.parse::<SignedLength>()
                .map(|l| l.length(Unit::M, 50.0))
        };
        assert_eq!(length("0.05").unwrap(), 0.05);
        assert_eq!(length("-20mm").unwrap(), -0.02);
        assert_eq!(length("-1%").unwrap(), -0.5);
        assert!(length("--1").is_err() && length("-").is_err() && length("x").is_err());
        let told = length("nan").unwrap_err();
        assert!(
            told.contains("nan") && told.contains("a number, negative"),
            "{told}"
        );
    }
}
