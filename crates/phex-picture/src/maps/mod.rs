//! What colours say: one value per panel or edge, a range, and the colours and histogram that
//! belong to it.
//!
//! A range is that of the mesh's own values, with round ends ([`Range::Automatic`]): in a range
//! that does for every mesh, a good one is blank. [`Range::Fixed`] is the one of the table, in
//! which two pictures can be laid side by side; values outside take the colour of the nearest end.
//! All colours keep apart under the common colour deficiencies: sequential maps by lightness,
//! diverging ones blue to orange.
//!
//! | map | element | value | fixed range |
//! |---|---|---|---|
//! | [`Map::Planarity`] | face | largest distance of a corner to the plane, mean edges | 1e-12 to 0.1, logarithmic |
//! | [`Map::Deviation`] | face | largest distance of a corner or the centre to the surface, % of its diagonal | 0 to 0.5 |
//! | [`Map::EdgeLength`] | edge | over the mean edge | 1/4 to 4, logarithmic |
//! | [`Map::Dihedral`] | edge | angle between the panels, degrees; less than 180 is convex | 160 to 200 |
//! | [`Map::Curvature`] | face | `k1 / k2` with `abs(k1) <= abs(k2)`: has the sign of `K`, 0 is parabolic | -1 to 1 |
//! | [`Map::FeatureSize`] | face | distance of two corners times the curvature under it in that direction, the largest ([`FeatureSizes`]) | 0 to 2 |
//! | [`Map::PanelArea`] | face | over the mean area | 1/4 to 4, logarithmic |
//! | [`Map::PanelAspect`] | face | length over width ([`phex_mesh::measure::aspect`]) | 1 to 4 |
//! | [`Map::Valence`] | face | number of corners, hexagons convex or concave | classes |
//! | [`Map::Validity`] | face | what holds of the panel | classes |
//! | [`Map::MaxPanel`] and the other limits of a workshop | face | the panel's worst figure over the limit, or the limit over it where it is a smallest one: beyond 1 it is outside | 0 to 2 |

mod panel_kinds;
mod ramps;
mod scale;
mod values;

pub(crate) use panel_kinds::{PanelKind, kinds as panel_kinds};
pub use scale::{Class, ColourScale, Continuous, Range, Rgb, ValueCounts};
pub use values::{Subject, principal_at_panels};

use phex::report::FeatureSizes;
use serde::{Deserialize, Serialize};

/// What a picture's colours show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Map {
    /// How far corners are from their panel's plane.
    Planarity,
    /// How far panels are from the surface.
    Deviation,
    /// Lengths of edges.
    EdgeLength,
    /// Angles between neighbouring panels.
    Dihedral,
    /// Sign of the Gauss curvature, with the band where it is nearly 0.
    Curvature,
    /// Size of the panels over that of the surface's features.
    FeatureSize,
    /// Areas of panels.
    PanelArea,
    /// Lengths of panels over their widths.
    PanelAspect,
    /// Numbers of corners.
    #[default]
    Valence,
    /// Which panels hold all checks.
    Validity,
    /// The rectangle that each panel is to fit against the limit.
    MaxPanel,
    /// Shortest edges against the limit.
    MinEdge,
    /// Longest edges against the limit.
    MaxEdge,
    /// Sharpest corners against the limit.
    MinAngle,
    /// Areas against the limit.
    MaxArea,
    /// Lengths over widths against the limit.
    MaxAspect,
    /// Sharpest joints with neighbours against the limit.
    MinDihedral,
    /// Flattest joints with neighbours against the limit.
    MaxDihedral,
}

impl Map {
    /// All maps of any mesh, in the order in which they are offered.
    pub const ALL: [Self; 10] = [
        Self::Valence,
        Self::Validity,
        Self::Planarity,
        Self::Deviation,
        Self::PanelArea,
        Self::PanelAspect,
        Self::EdgeLength,
        Self::Dihedral,
        Self::Curvature,
        Self::FeatureSize,
    ];

    /// The maps of a workshop's limits: those that were set have one.
    pub const LIMITS: [Self; 8] = [
        Self::MaxPanel,
        Self::MinEdge,
        Self::MaxEdge,
        Self::MinAngle,
        Self::MaxArea,
        Self::MaxAspect,
        Self::MinDihedral,
        Self::MaxDihedral,
    ];

    /// Name as it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Planarity => "planarity",
            Self::Deviation => "deviation",
            Self::EdgeLength => "edge-length",
            Self::Dihedral => "dihedral",
            Self::Curvature => "curvature",
            Self::FeatureSize => "feature-size",
            Self::PanelArea => "panel-area",
            Self::PanelAspect => "panel-aspect",
            Self::Valence => "valence",
            Self::Validity => "validity",
            Self::MaxPanel => "max-panel",
            Self::MinEdge => "min-edge",
            Self::MaxEdge => "max-edge",
            Self::MinAngle => "min-angle",
            Self::MaxArea => "max-area",
            Self::MaxAspect => "max-aspect",
            Self::MinDihedral => "min-dihedral",
            Self::MaxDihedral => "max-dihedral",
        }
    }

    /// Name as it is read.
    pub fn title(self) -> &'static str {
        match self {
            Self::Planarity => "Planarity",
            Self::Deviation => "Deviation",
            Self::EdgeLength => "Edge length",
            Self::Dihedral => "Dihedral angle",
            Self::Curvature => "Sign of curvature",
            Self::FeatureSize => "Feature size",
            Self::PanelArea => "Panel area",
            Self::PanelAspect => "Panel shape",
            Self::Valence => "Valence",
            Self::Validity => "Pass or fail",
            Self::MaxPanel => "Sheet",
            Self::MinEdge => "Shortest edge",
            Self::MaxEdge => "Longest edge",
            Self::MinAngle => "Sharpest corner",
            Self::MaxArea => "Largest area",
            Self::MaxAspect => "Aspect",
            Self::MinDihedral => "Sharpest joint",
            Self::MaxDihedral => "Flattest joint",
        }
    }

    /// What the values are, with their unit, in small letters.
    pub fn caption(self) -> &'static str {
        match self {
            Self::Planarity => "planarity, mean edges",
            Self::Deviation => "distance to the surface, % of its diagonal",
            Self::EdgeLength => "edge length, mean edges",
            Self::Dihedral => "dihedral angle, degrees",
            Self::Curvature => "k1 / k2, saddles below 0, parabolic band at 0",
            Self::FeatureSize => "panel length times largest curvature",
            Self::PanelArea => "area, mean areas",
            Self::PanelAspect => "length over width",
            Self::Valence => "number of corners",
            Self::Validity => "what the checks say of each panel",
            _ => "how near to the limit, 1 is at it, more is outside",
        }
    }

    /// The limit of a workshop that it shows, by the name of its check.
    fn limit(self) -> Option<String> {
        (Self::LIMITS.contains(&self)).then(|| self.name().replace('-', "_"))
    }
}

/// The kind of element that a map has values of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coloured {
    /// A value per face.
    Face,
    /// A value per edge.
    Edge,
}

/// Values with the colours that show them.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourMap {
    /// What is shown.
    pub map: Map,
    /// What has a value each.
    pub element: Coloured,
    /// The values by element id; NaN where an element has none (an edge of the boundary has no
    /// dihedral angle).
    pub values: Vec<f64>,
    /// How values become colours.
    pub scale: ColourScale,
}

impl ColourMap {
    /// The map of a mesh, over the range of its own values; `None` if it needs a surface, or a
    /// limit, and there is none.
    ///
    /// ```
    /// # use phex_mesh::{HexMesh, Vec3};
    /// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
    /// # let faces = [
    /// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
    /// # ];
    /// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
    /// use phex::quality::{Assessment, Limits, References};
    /// use phex_picture::maps::{ColourMap, Map, Subject};
    ///
    /// let assessment = Assessment::new(&cube, References::default(), &Limits::default());
    /// let subject = Subject { mesh: &cube, assessment: &assessment, surface: None };
    /// let lengths = ColourMap::new(Map::EdgeLength, &subject).ok_or("lengths need no surface")?;
    /// assert!(lengths.values.iter().all(|length| *length == 1.0));
    /// assert!(ColourMap::new(Map::Deviation, &subject).is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(map: Map, subject: &Subject<'_>) -> Option<Self> {
        Self::over(map, subject, Range::Automatic)
    }

    /// As [`ColourMap::new`], over a range of one's choice; classes have none.
    pub fn over(map: Map, subject: &Subject<'_>, range: Range) -> Option<Self> {
        let (element, values) = values::values(map, subject)?;
        let scale = match scale(map, subject) {
            ColourScale::Continuous(fixed) => ColourScale::Continuous(fixed.over(range, &values)),
            classes => classes,
        };
        Some(Self {
            map,
            element,
            values,
            scale,
        })
    }

    /// Colour (sRGB) of an element; elements without a value are grey.
    pub fn colour(&self, element: usize) -> Rgb {
        self.scale.colour(self.values[element])
    }

    /// Number of elements by value.
    pub fn histogram(&self) -> ValueCounts {
        self.scale.histogram(&self.values)
    }
}

fn scale(map: Map, subject: &Subject<'_>) -> ColourScale {
    let limit = |name: &str, factor: f64| {
        let checks = &subject.assessment.checks;
        let check = checks.iter().find(|c| c.name == name);
        check.map(|c| c.limit * factor)
    };
    let continuous = |low, high, logarithmic, ramp| Continuous {
        low,
        high,
        logarithmic,
        ramp,
        limit: None,
        band: None,
        middle: None,
    };
    let about = |middle, continuous| Continuous {
        middle: Some(middle),
        ..continuous
    };
    match map {
        Map::Planarity => ColourScale::Continuous(Continuous {
            limit: limit("planarity", 1.0),
            ..continuous(1e-12, 0.1, true, ramps::SEQUENTIAL)
        }),
        Map::Deviation => ColourScale::Continuous(Continuous {
            limit: limit("deviation", 100.0),
            ..continuous(0.0, 0.5, false, ramps::SEQUENTIAL)
        }),
        Map::EdgeLength => {
            let lengths = continuous(0.25, 4.0, true, ramps::DIVERGING_LINES);
            ColourScale::Continuous(about(1.0, lengths))
        }
        Map::Dihedral => {
            let angles = continuous(160.0, 200.0, false, ramps::DIVERGING_LINES);
            ColourScale::Continuous(about(180.0, angles))
        }
        Map::Curvature => ColourScale::Continuous(Continuous {
            band: Some((PARABOLIC, ramps::PARABOLIC)),
            ..continuous(-1.0, 1.0, false, ramps::DIVERGING)
        }),
        Map::FeatureSize => ColourScale::Continuous(Continuous {
            limit: Some(FeatureSizes::BOUND),
            ..continuous(0.0, 2.0, false, ramps::SEQUENTIAL)
        }),
        Map::PanelArea => {
            let areas = continuous(0.25, 4.0, true, ramps::DIVERGING);
            ColourScale::Continuous(about(1.0, areas))
        }
        Map::PanelAspect => ColourScale::Continuous(continuous(1.0, 4.0, false, ramps::SEQUENTIAL)),
        Map::Valence => ColourScale::Classes(panel_kinds::classes()),
        Map::Validity => ColourScale::Classes(values::VALIDITY.to_vec()),
        _ => ColourScale::Continuous(Continuous {
            limit: Some(1.0),
            ..continuous(0.0, 2.0, false, ramps::SEQUENTIAL)
        }),
    }
}

/// Half the width of the parabolic band, as a ratio of principal curvatures.
const PARABOLIC: f64 = 0.1;

#[cfg(test)]
pub(crate) mod tests;
