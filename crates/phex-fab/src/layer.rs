//! Lines of drawings, and the layers that they are on.

use phex_mesh::Vec2;

/// A layer of a drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Cut through.
    Cut,
    /// Engraved.
    Engrave,
    /// To be read only.
    Label,
    /// The sheet itself.
    Sheet,
}

impl Layer {
    /// All layers.
    pub const ALL: [Self; 4] = [Self::Cut, Self::Engrave, Self::Label, Self::Sheet];

    /// Name in the files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cut => "CUT",
            Self::Engrave => "ENGRAVE",
            Self::Label => "LABEL",
            Self::Sheet => "SHEET",
        }
    }

    /// AutoCAD colour number, and the same colour for SVG.
    pub(crate) fn colour(self) -> (u8, &'static str) {
        match self {
            Self::Cut => (1, "#d00000"),
            Self::Engrave => (5, "#0030c0"),
            Self::Label => (3, "#008040"),
            Self::Sheet => (8, "#808080"),
        }
    }
}

/// A polyline on a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The layer.
    pub layer: Layer,
    /// Its points, in mm.
    pub points: Vec<Vec2>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}
