//! The colours of a picture, and the legend that explains them.

use crate::maps::{ColourMap, ColourScale, Coloured, PanelKind, Rgb, ValueCounts, panel_kinds};
use crate::srgb::{linear, linear_bytes};
use phex_mesh::{EdgeId, FaceId, HexMesh, PerEdge, PerFace, Vec3};

/// Colour of panels whose edges carry the colours.
const PLAIN: Rgb = [0xEE, 0xEC, 0xE8];

/// Colours of everything that is drawn.
#[derive(Clone, Debug)]
pub struct Paint {
    /// Colour of each panel, linear light.
    pub panels: PerFace<Vec3>,
    /// Colour of each edge, where edges carry the colours.
    pub edges: Option<PerEdge<Vec3>>,
    /// How strongly light and shade change the panels' colours, 0 to 1: colours that are to be read
    /// off must not be lost.
    pub relief: f64,
    /// What the colours mean.
    pub legend: Legend,
}

/// What the colours of a picture mean.
#[derive(Clone, Debug)]
pub enum Legend {
    /// A line for each class that occurs: colour (sRGB) and text.
    Classes(Vec<(Rgb, String)>),
    /// A strip of colours with a histogram on it.
    LegendStrip(LegendStrip),
}

/// The legend of a continuous map.
#[derive(Clone, Debug)]
pub struct LegendStrip {
    /// What the values are.
    pub caption: &'static str,
    /// Colours at equal distances.
    pub colours: Vec<Rgb>,
    /// Places (0 to 1) with labels.
    pub ticks: Vec<(f64, String)>,
    /// Place of the largest accepted value.
    pub limit: Option<f64>,
    /// Number of elements along the strip.
    pub histogram: ValueCounts,
}

/// Relief of maps.
const RELIEF: f64 = 0.6;
/// Steps in which the legend shows a continuous map.
const STEPS: usize = 56;

impl Paint {
    /// Panels by kind, paler at the boundary where they are cut.
    pub fn kinds(mesh: &HexMesh) -> Self {
        let kinds = panel_kinds(mesh);
        let panels = kinds.enumerate();
        let colours = panels.map(|(f, kind)| panel_colour(mesh, f, *kind));
        let count = |kind| kinds.iter().filter(|&&k| k == kind).count();
        let lines = PanelKind::ALL.map(|kind| (kind, count(kind)));
        let line = |(kind, n): (PanelKind, usize)| (kind.colour(), format!("{n} {}", kind.label()));
        Self {
            panels: PerFace::from_vec(colours.collect()),
            edges: None,
            relief: 1.0,
            legend: Legend::Classes(lines.into_iter().filter(|l| l.1 > 0).map(line).collect()),
        }
    }

    /// Colour of the line along an edge, linear light.
    pub fn ink(&self, e: EdgeId) -> Vec3 {
        self.edges.as_ref().map_or_else(ink, |edges| edges[e])
    }

    /// Panels or edges by a map's values.
    ///
    /// # Panics
    /// If the map is of another mesh.
    pub fn map(mesh: &HexMesh, map: &ColourMap) -> Self {
        let topology = mesh.topology();
        let colour = |element: usize| linear_bytes(map.colour(element));
        let plain = linear_bytes(PLAIN);
        let (panels, edges) = match map.element {
            Coloured::Face => {
                let panels = PerFace::from_fn(topology.n_faces(), |f| colour(f.index()));
                (panels, None)
            }
            Coloured::Edge => {
                let edges = PerEdge::from_fn(topology.n_edges(), |e| colour(e.index()));
                (PerFace::filled(topology.n_faces(), plain), Some(edges))
            }
        };
        Self {
            panels,
            edges,
            relief: RELIEF,
            legend: Legend::of(map),
        }
    }
}

/// Colour of a panel (linear light); at the boundary, where panels are cut and not chosen, it is
/// paler.
fn panel_colour(mesh: &HexMesh, f: FaceId, kind: PanelKind) -> Vec3 {
    let [plain, own] = [PanelKind::ConvexHexagon, kind].map(|k| linear_bytes(k.colour()));
    let strength = if mesh.topology().is_boundary_face(f) {
        0.45
    } else {
        1.0
    };
    plain + (own - plain) * strength
}

/// Colour of lines that carry no value, linear light.
fn ink() -> Vec3 {
    linear([0.10, 0.10, 0.12])
}

impl Legend {
    fn of(map: &ColourMap) -> Self {
        let histogram = map.histogram();
        match &map.scale {
            ColourScale::Classes(classes) => {
                let counted = classes.iter().zip(&histogram.counts);
                let lines = counted.filter(|(_, n)| **n > 0);
                Self::Classes(
                    lines
                        .map(|(class, n)| (class.colour, format!("{n} {}", class.label)))
                        .collect(),
                )
            }
            ColourScale::Continuous(scale) => {
                let middle = |k: usize| scale.at((k as f64 + 0.5) / STEPS as f64);
                let limit = scale.limit.map(|l| scale.place(l));
                Self::LegendStrip(LegendStrip {
                    caption: map.map.caption(),
                    colours: (0..STEPS).map(|k| map.scale.colour(middle(k))).collect(),
                    ticks: scale.ticks(),
                    limit: limit.filter(|t| *t > 0.0 && *t < 1.0),
                    histogram,
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn only_kinds_that_occur_are_in_the_legend() {
        let corner = |k: usize, n: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / n as f64).sin_cos();
            Vec3::new(cos, sin, 0.0)
        };
        let positions = (0..7).map(|k| corner(k, 7)).collect();
        let mesh = HexMesh::new(positions, &[[0, 1, 2, 3, 4, 5, 6]]).unwrap();
        let Legend::Classes(lines) = Paint::kinds(&mesh).legend else {
            panic!("kinds are classes");
        };
        assert_eq!(
            lines,
            [(PanelKind::Heptagon.colour(), "1 heptagons".to_owned())]
        );
    }
}
