//! Kinds of panels, and their colours.

use super::{Class, Rgb};
use phex_mesh::polygon::corner_triples;
use phex_mesh::{FaceId, FacePlane, HexMesh, PerFace, Vec2, Vec3};

/// What a panel is, for its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PanelKind {
    /// Six corners, all turning the same way.
    ConvexHexagon,
    /// Six corners, some re-entrant (as the surface demands where its Gaussian curvature is
    /// negative).
    ConcaveHexagon,
    /// Five corners.
    Pentagon,
    /// Seven corners.
    Heptagon,
    /// Three or four corners.
    Smaller,
    /// A triangle or quad of a mesh that holds nothing else: no panelling, so nothing is remarkable
    /// about it.
    Facet,
    /// Eight corners or more.
    Larger,
}

impl PanelKind {
    /// All kinds, in the order of the legend.
    pub const ALL: [Self; 7] = [
        Self::ConvexHexagon,
        Self::ConcaveHexagon,
        Self::Pentagon,
        Self::Heptagon,
        Self::Smaller,
        Self::Larger,
        Self::Facet,
    ];

    /// Name in the legend.
    pub fn label(self) -> &'static str {
        match self {
            Self::ConvexHexagon => "hexagons, convex",
            Self::ConcaveHexagon => "hexagons, concave",
            Self::Pentagon => "pentagons",
            Self::Heptagon => "heptagons",
            Self::Smaller => "triangles, quads",
            Self::Larger => "octagons, larger",
            Self::Facet => "facets",
        }
    }

    /// Colour of the panel (sRGB).
    pub fn colour(self) -> Rgb {
        match self {
            Self::ConvexHexagon | Self::Facet => [0xF0, 0xE9, 0xE0],
            Self::ConcaveHexagon => [0xBD, 0xDE, 0xBF],
            Self::Pentagon => [0x5C, 0x9C, 0xE6],
            Self::Heptagon => [0xF2, 0xA6, 0x59],
            Self::Smaller => [0x8C, 0x66, 0xBF],
            Self::Larger => [0xD9, 0x59, 0x4D],
        }
    }
}

/// The kinds as classes of a colour map, in the order of [`PanelKind::ALL`].
pub fn classes() -> Vec<Class> {
    let class = |kind: PanelKind| Class {
        label: kind.label(),
        colour: kind.colour(),
    };
    PanelKind::ALL.map(class).to_vec()
}

/// Number of each panel's class in [`classes`].
pub fn class_numbers(mesh: &HexMesh) -> Vec<f64> {
    let number = |kind: &PanelKind| PanelKind::ALL.iter().position(|k| k == kind);
    let kinds = kinds(mesh);
    let numbers = kinds.iter().map(|kind| number(kind).unwrap_or(0));
    numbers.map(|n| n as f64).collect()
}

/// Kind of each panel.
pub fn kinds(mesh: &HexMesh) -> PerFace<PanelKind> {
    let topology = mesh.topology();
    if topology.faces().all(|f| topology.valence(f) <= 4) {
        return PerFace::filled(topology.n_faces(), PanelKind::Facet);
    }
    PerFace::from_fn(topology.n_faces(), |f| kind(mesh, f))
}

fn kind(mesh: &HexMesh, f: FaceId) -> PanelKind {
    match mesh.topology().valence(f) {
        ..=4 => PanelKind::Smaller,
        5 => PanelKind::Pentagon,
        6 if is_convex(mesh, f) => PanelKind::ConvexHexagon,
        6 => PanelKind::ConcaveHexagon,
        7 => PanelKind::Heptagon,
        _ => PanelKind::Larger,
    }
}

/// Whether every corner turns left in the panel's plane.
fn is_convex(mesh: &HexMesh, f: FaceId) -> bool {
    let corners: Vec<Vec3> = mesh.corners(f).collect();
    let plane = FacePlane::fit(&corners);
    let flat: Vec<Vec2> = corners.iter().map(|&p| plane.project(p)).collect();
    corner_triples(&flat).all(|[p, q, r]| {
        let (a, b) = (q - p, r - q);
        a.perp(&b) >= -1e-9 * a.norm() * b.norm()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hexagon(dent: f64) -> HexMesh {
        let mut positions: Vec<Vec3> = (0..6)
            .map(|k| std::f64::consts::FRAC_PI_3 * k as f64)
            .map(|a| Vec3::new(a.cos(), a.sin(), 0.2 * a.cos()))
            .collect();
        positions[0] *= dent;
        HexMesh::new(positions, &[[0, 1, 2, 3, 4, 5]]).unwrap()
    }

    #[test]
    fn concave_hexagon_is_told_from_a_convex_one() {
        assert_eq!(
            kind(&hexagon(1.0), FaceId::new(0)),
            PanelKind::ConvexHexagon
        );
        assert_eq!(
            kind(&hexagon(0.2), FaceId::new(0)),
            PanelKind::ConcaveHexagon
        );
    }
}
