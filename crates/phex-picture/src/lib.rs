//! A shaded picture of a panelling, drawn without a display or a graphics card.
//!
//! Perspective view from above, two-sided light, contact shadow, panel edges. Every sample of the
//! picture holds the panel that is nearest there, so panels of any shape (concave ones too) and
//! hidden lines come out right without a depth bias: a line is drawn on the samples of its own two
//! panels, and on others only where it is nearer.
//!
//! The picture is computed in bands of rows, in parallel; its bytes do not depend on the number of
//! threads.

mod camera;
mod contact;
mod covering;
mod curves;
mod framing;
mod legend;
mod legend_layout;
mod light;
pub mod maps;
mod occlusion;
mod paint;
mod picture;
mod raster;
mod scan;
mod srgb;
pub mod strokes;
mod vector;

pub use contact::{ContactTile, common_azimuth, contact_sheet};
pub use picture::{Picture, write_png};

use crate::light::Shading;
use crate::maps::ColourMap;
use crate::occlusion::occlusion;
use crate::paint::Paint;
use crate::raster::{LinearImage, PanelRaster};
use phex_mesh::{HexMesh, Vec3};
use serde::{Deserialize, Serialize};

/// What the picture shows, and from where.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, rename_all = "kebab-case", deny_unknown_fields)]
pub struct PictureOptions {
    /// Width in pixels (16 to 16384).
    pub width: usize,
    /// Height in pixels (16 to 16384).
    pub height: usize,
    /// Samples per pixel and direction (1 to 8); 3 gives clean thin lines.
    pub supersampling: usize,
    /// Direction from which the model is seen, degrees counter-clockwise from +x; `None` chooses
    /// the view that shows most.
    pub azimuth: Option<f64>,
    /// Height of the eye above the horizon, degrees (-90 to 90); 35 is the isometric view's, 90
    /// looks straight down.
    pub elevation: f64,
    /// Whether the edges of the panels are drawn; without them a fine triangle mesh looks like the
    /// surface that it stands for.
    pub edges: bool,
    /// Whether it is said what the colours mean.
    pub legend: bool,
    /// Whether the model stands on a ground, with shadows where panels are close, or evenly lit
    /// before plain white.
    pub ground: bool,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self {
            width: 1600,
            height: 1200,
            supersampling: 3,
            azimuth: None,
            elevation: 35.0,
            edges: true,
            legend: true,
            ground: true,
        }
    }
}

impl PictureOptions {
    /// The same options with every value inside its range.
    fn clamped(&self) -> Self {
        Self {
            width: self.width.clamp(16, 16384),
            height: self.height.clamp(16, 16384),
            supersampling: self.supersampling.clamp(1, 8),
            elevation: self.elevation.clamp(-90.0, 90.0),
            ..self.clone()
        }
    }
}

/// Draws a mesh in the colours of its panels' kinds; options outside their ranges are moved to the
/// nearest end.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex_picture::{PictureOptions, draw};
///
/// let options = PictureOptions { width: 80, height: 60, ..Default::default() };
/// let picture = draw(&cube, &options);
/// assert_eq!(picture.rgba.len(), 4 * 80 * 60);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn draw(mesh: &HexMesh, options: &PictureOptions) -> Picture {
    draw_paint(mesh, &Paint::kinds(mesh), &[], options)
}

/// As [`draw_map`], with polylines over the panels.
///
/// # Panics
/// If the map is of another mesh.
pub fn draw_with_curves(
    mesh: &HexMesh,
    map: &ColourMap,
    curves: &[Vec<Vec3>],
    options: &PictureOptions,
) -> Picture {
    draw_paint(mesh, &Paint::map(mesh, map), curves, options)
}

/// Draws a mesh in the colours of a map of it, with the map's histogram in the legend.
///
/// # Panics
/// If the map is of another mesh.
pub fn draw_map(mesh: &HexMesh, map: &ColourMap, options: &PictureOptions) -> Picture {
    draw_paint(mesh, &Paint::map(mesh, map), &[], options)
}

/// As [`draw_map`], as vectors: an SVG drawing with one path per visible panel. Hidden panels are
/// left out, and what is nearer is drawn later, so that the drawing needs no clipping.
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
/// use phex_picture::{PictureOptions, draw_svg};
///
/// let assessment = Assessment::new(&cube, References::default(), &Limits::default());
/// let subject = Subject { mesh: &cube, assessment: &assessment, surface: None };
/// let map = ColourMap::new(Map::Planarity, &subject).ok_or("planarity needs no surface")?;
/// let svg = draw_svg(&cube, &map, &PictureOptions::default());
/// // Three faces of the cube are seen, in a group that has a name, too.
/// assert_eq!(svg.matches(" id=\"p").count(), 3 + 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If the map is of another mesh.
pub fn draw_svg(mesh: &HexMesh, map: &ColourMap, options: &PictureOptions) -> String {
    vector::draw(mesh, &Paint::map(mesh, map), &options.clamped())
}

fn draw_paint(
    mesh: &HexMesh,
    paint: &Paint,
    curves: &[Vec<Vec3>],
    options: &PictureOptions,
) -> Picture {
    let options = options.clamped();
    let camera = framing::camera(mesh, paint, &options);
    let shading = Shading::new(mesh, &camera, paint, options.ground);
    let mut panels = PanelRaster::new(mesh, &camera, paint, options.supersampling);
    if !options.edges {
        panels = panels.without_edges();
    }
    let mut sheet = LinearImage::draw(&panels, &shading, &options);
    if options.ground {
        sheet.darken(&occlusion(&shading, &sheet, &camera));
    }
    curves::draw(&mut sheet, &camera, curves);
    if options.legend {
        legend::draw(&mut sheet, &paint.legend);
    }
    sheet.into_picture(options.ground)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: (usize, usize) = (160, 120);

    fn options() -> PictureOptions {
        let (width, height) = SMALL;
        PictureOptions {
            width,
            height,
            legend: false,
            ..Default::default()
        }
    }

    /// A flat panel at height 0 whose re-entrant corner lies at the middle of the view.
    fn chevron() -> HexMesh {
        let corners = [
            (-2.0, -2.0),
            (0.0, -0.5),
            (2.0, -2.0),
            (2.0, 2.0),
            (-2.0, 2.0),
        ];
        let positions = corners.iter().map(|&(x, y)| Vec3::new(x, y, 0.0)).collect();
        HexMesh::new(positions, &[[0, 1, 2, 3, 4]]).unwrap()
    }

    fn pixel(picture: &Picture, x: usize, y: usize) -> [u8; 3] {
        let at = 4 * (y * picture.width + x);
        [picture.rgba[at], picture.rgba[at + 1], picture.rgba[at + 2]]
    }

    #[test]
    fn edges_are_drawn_or_left_out() {
        let least_blue = |edges: bool| {
            let options = PictureOptions { edges, ..options() };
            let picture = draw(&chevron(), &options);
            picture.rgba.chunks(4).map(|p| p[2]).min()
        };
        assert!(least_blue(true) < least_blue(false));
    }

    #[test]
    fn concave_panel_leaves_its_notch_free() {
        let above = PictureOptions {
            azimuth: Some(-90.0),
            elevation: 89.0,
            ..options()
        };
        let picture = draw(&chevron(), &above);
        let (w, h) = SMALL;
        let inside = pixel(&picture, w / 2, h / 4);
        let notch = pixel(&picture, w / 2, h * 4 / 5);
        assert!(
            inside[2] > inside[0] + 30,
            "a pentagon is blue, got {inside:?}"
        );
        assert!(
            notch[2] <= notch[0].saturating_add(30),
            "the notch shows the ground, got {notch:?}"
        );
    }

    #[test]
    fn a_curve_is_seen_on_a_panel_and_hidden_behind_one() {
        let above = PictureOptions {
            azimuth: Some(-90.0),
            elevation: 89.0,
            ..options()
        };
        let mesh = chevron();
        let assessment =
            phex::quality::Assessment::new(&mesh, Default::default(), &Default::default());
        let subject = crate::maps::Subject {
            mesh: &mesh,
            assessment: &assessment,
            surface: None,
        };
        let map = ColourMap::new(crate::maps::Map::Valence, &subject).unwrap();
        let red = |z: f64| {
            let curve = vec![Vec3::new(-1.0, 1.0, z), Vec3::new(1.0, 1.0, z)];
            let picture = draw_with_curves(&mesh, &map, &[curve], &above);
            let all = picture.rgba.chunks_exact(4);
            all.filter(|p| p[0] > 150 && p[1] < 90).count()
        };
        assert!(red(0.0) > 20, "{}", red(0.0));
        assert_eq!(red(-1.0), 0);
    }

    #[test]
    fn nearer_panel_hides_the_farther_one_and_its_edges() {
        let square =
            |z: f64, s: f64| [(-s, -s), (s, -s), (s, s), (-s, s)].map(|(x, y)| Vec3::new(x, y, z));
        let mut positions = square(1.0, 2.0).to_vec();
        positions.extend(square(0.0, 1.0));
        let both = HexMesh::new(positions.clone(), &[[0, 1, 2, 3], [4, 5, 6, 7]]).unwrap();
        let above = PictureOptions {
            azimuth: Some(0.0),
            elevation: 89.0,
            ..options()
        };
        let upper = HexMesh::new(positions[..4].to_vec(), &[[0, 1, 2, 3]]).unwrap();
        let (a, b) = (draw(&both, &above), draw(&upper, &above));
        let middle =
            |p: &Picture| -> Vec<[u8; 3]> { (60..100).map(|x| pixel(p, x, SMALL.1 / 2)).collect() };
        let flat = middle(&a)
            .windows(2)
            .all(|w| w[0].iter().zip(&w[1]).all(|(p, q)| p.abs_diff(*q) <= 2));
        assert!(flat, "no edge of the lower square may shine through");
        assert!(
            middle(&b)
                .iter()
                .zip(middle(&a))
                .all(|(p, q)| p[0].abs_diff(q[0]) < 12)
        );
    }

    #[test]
    fn bytes_do_not_depend_on_the_number_of_threads() {
        let with = |n| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(n)
                .build()
                .unwrap()
                .install(|| draw(&chevron(), &options()))
        };
        assert_eq!(with(1), with(2));
    }

    #[test]
    fn degenerate_meshes_are_drawn_without_a_panic() {
        let point = HexMesh::new(vec![Vec3::zeros(); 3], &[[0, 1, 2]]).unwrap();
        assert_eq!(draw(&point, &options()).rgba.len(), 4 * SMALL.0 * SMALL.1);
        let far = HexMesh::new(
            vec![Vec3::repeat(1e300), Vec3::repeat(-1e300), Vec3::x()],
            &[[0, 1, 2]],
        )
        .unwrap();
        draw(
            &far,
            &PictureOptions {
                width: 0,
                height: 0,
                supersampling: 0,
                elevation: 400.0,
                ..options()
            },
        );
    }
}
