//! Colours of the panel kinds.

use crate::report::maps::{Class, Rgb};
use phex_mesh::{FaceId, FacePlane, HexMesh, PerFace, Vec2, Vec3};

/// What a panel is, for its colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PanelKind {
    /// Six corners, all turning the same way.
    ConvexHexagon,
    /// Six corners, some re-entrant (as the surface demands where its Gaussian curvature is negative).
    ConcaveHexagon,
    /// Five corners.
    Pentagon,
    /// Seven corners.
    Heptagon,
    /// Three or four corners.
    Smaller,
    /// A triangle or quad of a mesh that holds nothing else: no panelling, so nothing is remarkable about it.
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

/// Colour of a panel (linear light); at the boundary, where panels are cut and not chosen, it is paler.
pub fn panel_colour(mesh: &HexMesh, f: FaceId, kind: PanelKind) -> Vec3 {
    let [plain, own] = [PanelKind::ConvexHexagon, kind].map(|k| linear_bytes(k.colour()));
    let strength = if mesh.topology().is_boundary_face(f) {
        0.45
    } else {
        1.0
    };
    plain + (own - plain) * strength
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
    let n = flat.len();
    (0..n).all(|i| {
        let (a, b) = (
            flat[(i + 1) % n] - flat[i],
            flat[(i + 2) % n] - flat[(i + 1) % n],
        );
        a.perp(&b) >= -1e-9 * a.norm() * b.norm()
    })
}

/// Linear light of an sRGB colour.
pub fn linear(srgb: [f64; 3]) -> Vec3 {
    Vec3::from(srgb).map(|c| {
        if c <= 0.04045 {
            c / 12.92
        } else {
            ((c + 0.055) / 1.055).powf(2.4)
        }
    })
}

/// Linear light of an sRGB colour in bytes.
pub fn linear_bytes(srgb: Rgb) -> Vec3 {
    linear(srgb.map(|c| f64::from(c) / 255.0))
}

/// sRGB byte of linear light; `round_up` (0 to 1, 0.5 for the nearest byte) tells from which fraction on it is rounded up.
pub fn srgb_byte(light: f64, round_up: f64) -> u8 {
    let c = light.clamp(0.0, 1.0);
    let s = if c <= 0.003_130_8 {
        12.92 * c
    } else {
        1.055 * c.powf(1.0 / 2.4) - 0.055
    };
    (s * 255.0 + 1.0 - round_up).floor().clamp(0.0, 255.0) as u8
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

    #[test]
    fn colours_survive_the_way_to_bytes() {
        for byte in [0u8, 1, 10, 128, 254, 255] {
            assert_eq!(srgb_byte(linear([f64::from(byte) / 255.0; 3]).x, 0.5), byte);
        }
    }
}
