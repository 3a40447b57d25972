//! The command line of the tools by planes, poles and indicatrices.

use crate::exit::EXIT_CODES;
use crate::shared_arguments::{Extras, Talk, ToleranceArguments};
use clap::{Args, ValueEnum};
use phex_job::positive;
use phex_job::{finite, ten, three};
use std::path::PathBuf;

/// Arguments of `phex dual`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct DualCommand {
    /// Mesh with planar faces, triangles or polygons: OBJ, PLY or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Mesh to write: a vertex for each face, a face for each vertex inside
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
    /// Centre of the sphere [default: away from all faces' planes]; with the same one the dual of
    /// the dual is the mesh, if it is closed
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    pub centre: Option<[f64; 3]>,
    /// Radius of the sphere, model units
    #[arg(long, allow_negative_numbers = true, value_name = "R", default_value_t = 1.0, value_parser = positive)]
    pub radius: f64,
    /// Any other quadric: the ten numbers of the upper triangle of its symmetric matrix Q, row by
    /// row
    #[arg(long, value_name = "Q", value_parser = ten, allow_hyphen_values = true, conflicts_with_all = ["centre", "radius"])]
    pub quadric: Option<[f64; 10]>,
    /// Report and picture.
    #[command(flatten)]
    pub extras: Extras,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Rules of subdivision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum SubdivideRule {
    /// Every edge becomes a panel, then all are made planar and brought to the surface; for any
    /// surface
    #[default]
    Robust,
    /// Loop's rule for the dual; exact planes, no surface
    Loop,
    /// The butterfly rule for the dual; old panels keep their planes
    Butterfly,
}

/// Arguments of `phex subdivide`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct SubdivideCommand {
    /// Mesh with planar faces, three at each vertex inside: OBJ, PLY or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Mesh to write
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
    /// How to subdivide
    #[arg(long, value_enum, default_value_t)]
    pub rule: SubdivideRule,
    /// Number of levels; each has four times as many panels (1 to 5)
    #[arg(short, long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=5))]
    pub levels: u8,
    /// Go on with `loop` or `butterfly` where the mesh's Gauss curvature changes its sign, to see
    /// what becomes of it
    #[arg(long)]
    pub any_domain: bool,
    /// Surface to stay close to, for `robust` [default: a smooth one through the mesh's own faces]
    #[arg(long, value_name = "SURFACE")]
    pub surface: Option<PathBuf>,
    /// Limits.
    #[command(flatten)]
    pub limits: ToleranceArguments,
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

/// Arguments of `phex power-diagram`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct PowerCommand {
    /// Class of a Goldberg polyhedron: 10 (m^2 + m n + n^2) + 2 panels, 12 of them pentagons
    #[arg(long, value_name = "M,N", value_parser = two, required_unless_present = "sites")]
    pub goldberg: Option<[u32; 2]>,
    /// Text file with a site of the plane in each line: `x y` or `x y weight`
    #[arg(long, value_name = "FILE", conflicts_with = "goldberg")]
    pub sites: Option<PathBuf>,
    /// Height of the plane that closes the cells without bounds, for sites; 1 touches the sphere's
    /// north pole
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "Z",
        default_value_t = 0.98,
        requires = "sites"
    )]
    pub cap: f64,
    /// Semi-axes of the ellipsoid
    #[arg(long, value_name = "A,B,C", value_parser = three, default_value = "1,1,1")]
    pub axes: [f64; 3],
    /// Any affine map of the sphere: the nine numbers of a 3x3 matrix, row by row, or the twelve of
    /// a 3x4 matrix, whose last column is the centre
    #[arg(long, value_name = "A", value_parser = affine, allow_hyphen_values = true, conflicts_with = "axes")]
    pub affine: Option<[f64; 12]>,
    /// Mesh to write
    #[arg(short, long, value_name = "MESH")]
    pub output: PathBuf,
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

/// Arguments of `phex dupin`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct DupinCommand {
    /// Surface: OBJ, PLY, STL or OFF
    #[arg(value_name = "SURFACE")]
    pub input: PathBuf,
    /// OBJ file to write: one group of polylines for each indicatrix
    #[arg(short, long, value_name = "CURVES.OBJ")]
    pub output: PathBuf,
    /// A point; the indicatrix is that of the closest point of the surface. May be repeated
    #[arg(long, value_name = "X,Y,Z", value_parser = three, allow_hyphen_values = true)]
    pub at: Vec<[f64; 3]>,
    /// The copies that fit the corners of this mesh's inner panels best; with `--at`, of the panels
    /// nearest to those points
    #[arg(long, value_name = "MESH")]
    pub panels: Option<PathBuf>,
    /// Of these panels only such as have no corner in common, so that every curve can be told from
    /// the next
    #[arg(long, requires = "panels", conflicts_with = "at")]
    pub apart: bool,
    /// Number of points spread over the surface, where no others are given
    #[arg(short = 'n', long, allow_negative_numbers = true, value_name = "N", default_value_t = 100, conflicts_with_all = ["at", "panels"])]
    pub points: usize,
    /// Size of the curves over the distance at which points are spread
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "X",
        default_value_t = 0.4,
        conflicts_with = "panels"
    )]
    pub size: f64,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

fn two(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split(',').map(|n| n.trim().parse());
    let numbers: Result<Vec<u32>, _> = numbers.collect();
    let pair = numbers.ok().and_then(|n| n.try_into().ok());
    pair.ok_or_else(|| "write M,N".to_owned())
}

/// A 3x4 matrix; a 3x3 one gets a last column of zeros.
fn affine(text: &str) -> Result<[f64; 12], String> {
    let form = "the nine numbers of a 3x3 matrix or the twelve of a 3x4 matrix, row by row";
    if text.split(',').count() == 9 {
        let m = finite::<9>(text, form)?;
        return Ok(std::array::from_fn(|i| {
            if i % 4 == 3 {
                0.0
            } else {
                m[i / 4 * 3 + i % 4]
            }
        }));
    }
    finite(text, form)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn affine_maps_with_and_without_a_centre() {
        let square = affine("1,2,3, 4,5,6, 7,8,9").unwrap();
        let wanted = [1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0].map(f64::from);
        assert_eq!(square, wanted);
        assert_eq!(affine("1,2,3,-1,4,5,6,-2,7,8,9,-3").unwrap()[11], -3.0);
        assert!(affine("1,2,3").is_err() && affine("1,2,3,4,5,6,7,8,inf").is_err());
    }
}
