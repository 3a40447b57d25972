//! What can be typed after `phex fab`.

use crate::exit::EXIT_CODES;
use crate::shared_arguments::Talk;
use clap::{Args, ValueEnum};
use phex_fab::{FabOptions, Rotations, Side};
use phex_job::{Quantity, SheetSize, Unit, WorkshopLength};
use std::path::PathBuf;

/// Arguments of `phex fab`.
#[derive(Debug, Args)]
#[command(after_help = EXIT_CODES)]
pub struct FabCommand {
    /// Valid mesh with planar faces, three at each interior vertex: OBJ, PLY or OFF
    #[arg(value_name = "MESH")]
    pub input: PathBuf,
    /// Folder to write: a new one, or that of an earlier run, in which only what that run wrote is
    /// replaced
    #[arg(short, long, value_name = "FOLDER")]
    pub output: PathBuf,
    /// Thickness of the panels, e.g. `0.05` (model units) or `50mm`
    #[arg(long, allow_hyphen_values = true, value_name = "LENGTH")]
    pub thickness: Quantity,
    /// Width of the joints between panels, in the planes of their faces [default: 0]
    #[arg(long, allow_hyphen_values = true, value_name = "LENGTH")]
    pub gap: Option<Quantity>,
    /// Where the thickness goes from the mesh; sheets show the panels' upper faces, on the side of
    /// the normals (layer CUT), beyond which the lower ones reach where a mitre is negative
    #[arg(long, value_enum, default_value_t)]
    pub side: PanelSide,
    /// Unit of the model's coordinates [default: that of `--limits`, or m]
    #[arg(long, value_enum)]
    pub unit: Option<Unit>,
    /// Size of a sheet: `1250x2500` in millimetres, or with a unit, `4x8ft`
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "WIDTHxLENGTH",
        default_value = "1250x2500",
        help_heading = "Sheets"
    )]
    pub sheet: SheetSize,
    /// Least distance of panels from one another and from the sheet's border; a plain number is in
    /// millimetres
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        default_value = "5mm",
        help_heading = "Sheets"
    )]
    pub spacing: WorkshopLength,
    /// How panels may be turned on a sheet: `free`, or angles in degrees, e.g. `0,180`
    #[arg(long, value_name = "LIST", default_value = "free", value_parser = rotations, allow_hyphen_values = true, help_heading = "Sheets")]
    pub rotations: Rotations,
    /// Rounds of exchanges that make each sheet fuller: more take longer, 0 is quickest
    #[arg(
        long, allow_negative_numbers = true,
        value_name = "N",
        default_value_t = FabOptions::default().nest_effort,
        help_heading = "Sheets"
    )]
    pub nest_effort: u32,
    /// Largest height of engraved text, 3.4mm or more; a plain number is in millimetres
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        default_value = "25mm",
        help_heading = "Sheets"
    )]
    pub text: WorkshopLength,
    /// Distance of corners up to which panels are the same, and spread of lengths that are the
    /// same; a plain number is in millimetres
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "LENGTH",
        default_value = "1mm",
        help_heading = "Groups"
    )]
    pub tolerance: WorkshopLength,
    /// Spread of angles that are the same, in degrees, 10 at the most
    #[arg(
        long,
        allow_negative_numbers = true,
        value_name = "DEGREES",
        default_value_t = 0.1,
        help_heading = "Groups"
    )]
    pub angle_tolerance: f64,
    /// Let panels keep the names that they have in this table of an earlier run
    #[arg(long, value_name = "PANELS.CSV", help_heading = "Groups")]
    pub keep_ids: Option<PathBuf>,
    /// Tell in the table of panels how near each is to the limits of this job file (`[limits]`)
    #[arg(long, value_name = "JOB.TOML", help_heading = "Tolerances")]
    pub limits: Option<PathBuf>,
    /// Largest distance of a corner to its panel's plane: a number is mean edges, `0.1mm` a length
    /// [default: 1e-12, or rounding]
    #[arg(
        long,
        allow_hyphen_values = true,
        value_name = "X",
        help_heading = "Tolerances"
    )]
    pub planarity: Option<Quantity>,
    /// Number of threads; the result does not depend on it
    #[arg(short, long, value_parser = clap::value_parser!(u16).range(1..))]
    pub threads: Option<u16>,
    /// Progress and messages.
    #[command(flatten)]
    pub talk: Talk,
}

/// Where the thickness goes from the mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum PanelSide {
    /// Inwards, against the normals: the mesh is the outer face
    #[default]
    Inside,
    /// Outwards, along the normals
    Outside,
    /// Half to either side
    Centre,
}

impl From<PanelSide> for Side {
    fn from(side: PanelSide) -> Self {
        match side {
            PanelSide::Inside => Self::Inside,
            PanelSide::Outside => Self::Outside,
            PanelSide::Centre => Self::Centre,
        }
    }
}

/// Degrees of a full turn.
const FULL_TURN: f64 = 360.0;

fn rotations(text: &str) -> Result<Rotations, String> {
    if text == "free" {
        return Ok(Rotations::Free);
    }
    let angle = |word: &str| match word.trim().parse::<f64>() {
        Ok(angle) if angle.abs() <= FULL_TURN => Ok(angle),
        Ok(_) => Err(format!(
            "`{word}` is more than a full turn: write degrees from -360 to 360"
        )),
        _ => Err(format!(
            "`{word}` is no angle; write `free` or degrees separated by commas"
        )),
    };
    text.split(',')
        .map(angle)
        .collect::<Result<_, _>>()
        .map(Rotations::Degrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_free_or_angles() {
        assert_eq!(rotations("free").unwrap(), Rotations::Free);
        assert_eq!(
            rotations("0, -90").unwrap(),
            Rotations::Degrees(vec![0.0, -90.0])
        );
        assert!(rotations("").is_err() && rotations("0,inf").is_err());
        assert!(rotations("0,400").unwrap_err().contains("full turn"));
    }
}
