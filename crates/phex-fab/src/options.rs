//! What the workshop asks for.

use phex_mesh::{PanelLimits, ValidateOptions};
use serde::{Deserialize, Serialize};

/// Where the given mesh lies in the thick panels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The mesh is the outer face (on the side of the normals), the thickness goes inwards.
    #[default]
    Inside,
    /// The mesh is the inner face, the thickness goes outwards.
    Outside,
    /// Half of the thickness on either side.
    Centre,
}

impl Side {
    /// Signed distances of the lower and the upper face from the mesh, positive along the normals.
    pub fn layers(self, thickness: f64) -> [f64; 2] {
        match self {
            Self::Inside => [-thickness, 0.0],
            Self::Outside => [0.0, thickness],
            Self::Centre => [-0.5 * thickness, 0.5 * thickness],
        }
    }
}

/// How panels may be turned on a sheet.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rotations {
    /// Any angle.
    #[default]
    Free,
    /// These angles only, in degrees, from the upright position of the panel's text.
    Degrees(Vec<f64>),
}

impl Rotations {
    /// The angles that are allowed, in degrees, where not all are.
    pub fn limited(&self) -> Option<&[f64]> {
        match self {
            Self::Free => None,
            Self::Degrees(angles) => Some(angles),
        }
    }
}

/// Options of [`fabricate`](crate::fabricate).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FabOptions {
    /// Thickness of the panels, in model units; above 0.
    pub thickness: f64,
    /// Width of the joints between panels, in the planes of their faces, in model units; at
    /// least 0.
    pub gap: f64,
    /// Where the mesh lies in the thickness.
    pub side: Side,
    /// Millimetres in a model unit. Default 1000: the model is in metres.
    pub unit_mm: f64,
    /// Length along x and along y of a sheet, in mm. Default 2500 x 1250.
    pub sheet_mm: [f64; 2],
    /// Least distance of panels from one another and from the sheet's border, in mm. Default 5:
    /// room for a saw or cutter.
    pub spacing_mm: f64,
    /// How panels may be turned.
    pub rotations: Rotations,
    /// How many rounds of exchanges make each sheet fuller, fewer in proportion where more than 20
    /// panels are on it; time grows in proportion, the sheets' use slowly. 0: none. Default 60.
    pub nest_effort: u32,
    /// Largest distance of corners up to which panels are congruent, and largest spread of one
    /// length of edges, in mm. Default 1.
    pub tolerance_mm: f64,
    /// Largest spread of one angle, in radians, at most 10 degrees; in files degrees. Default 0.1
    /// degrees.
    #[serde(with = "degrees")]
    pub angle_tolerance: f64,
    /// Largest height of engraved text, in mm. Default 25; it is smaller where a panel is.
    pub text_mm: f64,
    /// What panels are to keep to, lengths in model units: the schedule of panels has a column for
    /// each limit that is set. Nothing is refused.
    pub limits: PanelLimits,
    /// What is asked of the layers.
    pub validity: ValidateOptions,
}

/// Angles as files have them.
mod degrees {
    use serde::{Deserialize, Deserializer, Serializer};

    /// Parts of a degree that are kept: what radians round is less.
    const DIGITS: f64 = 1e9;

    pub fn serialize<S: Serializer>(radians: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64((radians.to_degrees() * DIGITS).round() / DIGITS)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        f64::deserialize(deserializer).map(f64::to_radians)
    }
}

impl Default for FabOptions {
    fn default() -> Self {
        Self {
            thickness: 0.05,
            gap: 0.0,
            side: Side::default(),
            unit_mm: 1000.0,
            sheet_mm: [2500.0, 1250.0],
            spacing_mm: 5.0,
            rotations: Rotations::default(),
            nest_effort: 60,
            tolerance_mm: 1.0,
            angle_tolerance: 0.1_f64.to_radians(),
            text_mm: 25.0,
            limits: PanelLimits::default(),
            validity: ValidateOptions::default(),
        }
    }
}
