//! Panels and their edges to samples, samples to pixels.

use super::camera::{Camera, Seen, panel_plane};
use super::light::Shading;
use super::paint::Paint;
use super::scan::{column, scan_polygon};
use super::{Picture, PictureOptions};
use crate::srgb::srgb_byte;
use phex_mesh::{EdgeId, ElementId, FaceId, HexMesh, Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

pub(super) const NO_PANEL: u32 = u32::MAX;
const NO_LINE: u32 = u32::MAX;
/// Rows of pixels that are drawn together.
pub(super) const BAND: usize = 32;
/// Width of a line over the mean length of an edge in the picture.
const LINE_REL: f64 = 0.055;
/// Thinnest and widest line, pixels at a picture height of 1200.
const LINE_WIDTH: (f64, f64) = (0.30, 1.7);
/// How much wider the boundary is drawn.
const BOUNDARY_WIDTH: f64 = 1.7;
/// How much wider lines are drawn that carry colours.
const COLOURED_WIDTH: f64 = 3.0;
/// How opaque a line is.
const LINE_OPACITY: f64 = 0.85;

/// A panel as it is drawn; lengths in samples.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    pub(super) outline: Vec<Vec2>,
    /// Nearness as `[0] x + [1] y + [2]`, within the range of the corners.
    nearness: [f64; 3],
    range: (f64, f64),
}

impl Panel {
    pub(super) fn nearness_at(&self, x: f64, y: f64) -> f32 {
        let plane = self.nearness[0] * x + self.nearness[1] * y + self.nearness[2];
        plane.max(self.range.0).min(self.range.1) as f32
    }
}

/// An edge as it is drawn; lengths in samples.
#[derive(Clone, Debug)]
struct Line {
    ends: [Seen; 2],
    radius: f64,
    panels: [u32; 2],
    /// Colour, linear light.
    ink: Vec3,
}

impl Line {
    fn rows(&self) -> (f64, f64) {
        let [a, b] = &self.ends;
        (a.y.min(b.y) - self.radius, a.y.max(b.y) + self.radius)
    }

    /// Nearness of the line's point that is closest to a sample, if that is within the line's
    /// radius.
    fn covers(&self, x: f64, y: f64) -> Option<f32> {
        let [a, b] = &self.ends;
        let (along, offset) = (Vec2::new(b.x - a.x, b.y - a.y), Vec2::new(x - a.x, y - a.y));
        let t = (offset.dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        let inside = (offset - along * t).norm_squared() <= self.radius * self.radius;
        inside.then_some((a.nearness + (b.nearness - a.nearness) * t) as f32)
    }
}

/// Everything that is drawn, projected, at the resolution of the samples.
#[derive(Clone, Debug)]
pub struct PanelRaster {
    pub(super) panels: Vec<Panel>,
    lines: Vec<Line>,
    samples: usize,
}

impl PanelRaster {
    /// Projects the panels and edges of a mesh.
    pub fn new(mesh: &HexMesh, camera: &Camera, paint: &Paint, samples: usize) -> Self {
        let see = |p: Vec3| scaled(camera.see(camera.normalised(p)), samples as f64);
        let panels = mesh
            .topology()
            .faces()
            .map(|f| panel(mesh, camera, f, samples as f64))
            .collect();
        let mut lines: Vec<Line> = mesh
            .topology()
            .edges()
            .map(|e| line(mesh, e, paint, &see))
            .collect();
        let mean = lines.iter().map(pixels_long).sum::<f64>() / lines.len() as f64 / samples as f64;
        let unit = camera.focal / camera.eye().norm() / 400.0;
        let bold = if paint.edges.is_some() {
            COLOURED_WIDTH
        } else {
            1.0
        };
        let width = bold * (LINE_REL * mean).clamp(LINE_WIDTH.0 * unit, LINE_WIDTH.1 * unit);
        for line in &mut lines {
            let wider = if line.panels[1] == NO_PANEL && paint.edges.is_none() {
                BOUNDARY_WIDTH
            } else {
                1.0
            };
            line.radius = 0.5 * width * wider * samples as f64;
        }
        Self {
            panels,
            lines,
            samples,
        }
    }

    /// The panels alone.
    pub fn without_edges(mut self) -> Self {
        self.lines.clear();
        self
    }
}

fn scaled(seen: Seen, samples: f64) -> Seen {
    Seen {
        x: seen.x * samples,
        y: seen.y * samples,
        ..seen
    }
}

fn pixels_long(line: &Line) -> f64 {
    let [a, b] = &line.ends;
    (a.x - b.x).hypot(a.y - b.y)
}

fn line(mesh: &HexMesh, e: EdgeId, paint: &Paint, see: &impl Fn(Vec3) -> Seen) -> Line {
    let topology = mesh.topology();
    let half_edge = topology.edge_half_edge(e);
    let number = |f: FaceId| f.index() as u32;
    let other = topology.across(half_edge).map(number);
    Line {
        ends: topology.edge_vertices(e).map(|v| see(mesh.position(v))),
        radius: 0.0,
        panels: [number(topology.face(half_edge)), other.unwrap_or(NO_PANEL)],
        ink: paint.ink(e),
    }
}

fn panel(mesh: &HexMesh, camera: &Camera, f: FaceId, samples: f64) -> Panel {
    let seen: Vec<Seen> = mesh
        .corners(f)
        .map(|p| scaled(camera.see(camera.normalised(p)), samples))
        .collect();
    let range = seen.iter().fold((f64::MAX, f64::MIN), |(lo, hi), s| {
        (lo.min(s.nearness), hi.max(s.nearness))
    });
    Panel {
        outline: seen.iter().map(|s| Vec2::new(s.x, s.y)).collect(),
        nearness: nearness_plane(mesh, camera, f, samples),
        range,
    }
}

/// Coefficients of the nearness of a panel's plane. With the eye at the origin and the ray `r`
/// through a sample, the plane `n . p = k` is met at the distance `k / (n . r)`, so that the
/// nearness `(n . r) / k` is affine.
fn nearness_plane(mesh: &HexMesh, camera: &Camera, f: FaceId, samples: f64) -> [f64; 3] {
    let plane = panel_plane(mesh, camera, f);
    let k = plane.normal.dot(&(plane.centre - camera.eye()));
    let k = if k.abs() < 1e-9 { 1e-9 } else { k };
    let at = |x: f64, y: f64| plane.normal.dot(&camera.ray(x, y)) / k;
    let origin = at(0.0, 0.0);
    [
        (at(1.0, 0.0) - origin) / samples,
        (at(0.0, 1.0) - origin) / samples,
        origin,
    ]
}

/// Samples of a band of rows.
struct Band {
    rows: Range<usize>,
    width: usize,
    panel: Vec<u32>,
    nearness: Vec<f32>,
    /// Number of the line that is drawn on a sample.
    line: Vec<u32>,
}

impl Band {
    fn draw(raster: &PanelRaster, rows: Range<usize>, width: usize) -> Self {
        let count = rows.len() * width;
        let mut band = Self {
            rows,
            width,
            panel: vec![NO_PANEL; count],
            nearness: vec![0.0; count],
            line: vec![NO_LINE; count],
        };
        for (number, panel) in raster.panels.iter().enumerate() {
            band.draw_panel(number as u32, panel);
        }
        for (number, line) in raster.lines.iter().enumerate() {
            band.draw_line(number as u32, line);
        }
        band
    }

    fn draw_panel(&mut self, number: u32, panel: &Panel) {
        let (first_row, width) = (self.rows.start, self.width);
        scan_polygon(&panel.outline, self.rows.clone(), width, |row, columns| {
            for x in columns {
                let at = (row - first_row) * width + x;
                let nearness = panel.nearness_at(x as f64 + 0.5, row as f64 + 0.5);
                if nearness > self.nearness[at] {
                    self.nearness[at] = nearness;
                    self.panel[at] = number;
                }
            }
        });
    }

    fn draw_line(&mut self, number: u32, line: &Line) {
        let (top, bottom) = line.rows();
        let [a, b] = &line.ends;
        let left = column(a.x.min(b.x) - line.radius, self.width);
        let right = column(a.x.max(b.x) + line.radius, self.width);
        for row in column(top, self.rows.end).max(self.rows.start)..column(bottom, self.rows.end) {
            for x in left..right {
                let Some(nearness) = line.covers(x as f64 + 0.5, row as f64 + 0.5) else {
                    continue;
                };
                let at = (row - self.rows.start) * self.width + x;
                if line.panels.contains(&self.panel[at]) || nearness > self.nearness[at] {
                    self.line[at] = number;
                }
            }
        }
    }
}

/// The picture in linear light, with the panel that lies at the middle of each pixel.
#[derive(Clone, Debug)]
pub struct LinearImage {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    light: Vec<Vec3>,
    panel: Vec<u32>,
    nearness: Vec<f32>,
    /// Share of the pixel that panels cover.
    covered: Vec<f32>,
}

/// One pixel of a [`LinearImage`].
struct Pixel {
    light: Vec3,
    panel: u32,
    nearness: f32,
    covered: f32,
}

impl LinearImage {
    /// Draws panels, edges and background.
    pub fn draw(raster: &PanelRaster, shading: &Shading, options: &PictureOptions) -> Self {
        let (width, height, s) = (options.width, options.height, raster.samples);
        let band = |b: usize| {
            let rows = b * BAND..((b + 1) * BAND).min(height);
            let band = Band::draw(raster, rows.start * s..rows.end * s, width * s);
            rows.flat_map(|y| (0..width).map(move |x| (x, y)))
                .map(|(x, y)| resolve(raster, &band, [x, y], shading, height))
                .collect::<Vec<Pixel>>()
        };
        let bands: Vec<Vec<Pixel>> = (0..height.div_ceil(BAND))
            .into_par_iter()
            .map(band)
            .collect();
        let pixels = || bands.iter().flatten();
        Self {
            width,
            height,
            light: pixels().map(|p| p.light).collect(),
            panel: pixels().map(|p| p.panel).collect(),
            nearness: pixels().map(|p| p.nearness).collect(),
            covered: pixels().map(|p| p.covered).collect(),
        }
    }

    /// The panel at a point of the picture, and its nearness.
    pub fn panel_at(&self, x: f64, y: f64) -> Option<(FaceId, f64)> {
        if !(x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64) {
            return None;
        }
        let at = y as usize * self.width + x as usize;
        let number = self.panel[at];
        (number != NO_PANEL).then(|| {
            (
                FaceId::from_index(number as usize),
                f64::from(self.nearness[at]),
            )
        })
    }

    /// Multiplies the light of each pixel, as far as panels cover it.
    pub fn darken(&mut self, keep: &[f32]) {
        for (at, light) in self.light.iter_mut().enumerate() {
            *light *= f64::from(1.0 - self.covered[at] * (1.0 - keep[at]));
        }
    }

    /// Lays a colour over a pixel.
    pub fn blend(&mut self, x: usize, y: usize, colour: Vec3, opacity: f64) {
        if x < self.width && y < self.height {
            let light = &mut self.light[y * self.width + x];
            *light += (colour - *light) * opacity;
        }
    }

    /// The picture in bytes; slow gradients need a dither, plain ones pack better without.
    pub fn into_picture(self, dithered: bool) -> Picture {
        let bytes = |(at, light): (usize, &Vec3)| {
            let threshold = if dithered {
                dither(at % self.width, at / self.width)
            } else {
                0.5
            };
            [
                srgb_byte(light.x, threshold),
                srgb_byte(light.y, threshold),
                srgb_byte(light.z, threshold),
                255,
            ]
        };
        Picture {
            width: self.width,
            height: self.height,
            rgba: self
                .light
                .par_iter()
                .enumerate()
                .flat_map_iter(bytes)
                .collect(),
        }
    }
}

/// Ordered 4 x 4 dither (Bayer), without which the background's slow gradient would show steps.
fn dither(x: usize, y: usize) -> f64 {
    const ORDER: [[u8; 4]; 4] = [[0, 8, 2, 10], [12, 4, 14, 6], [3, 11, 1, 9], [15, 7, 13, 5]];
    (f64::from(ORDER[y % 4][x % 4]) + 0.5) / 16.0
}

/// Mean of a pixel's samples.
fn resolve(
    raster: &PanelRaster,
    band: &Band,
    [x, y]: [usize; 2],
    shading: &Shading,
    height: usize,
) -> Pixel {
    let samples = raster.samples;
    let background = shading.background(x as f64 + 0.5, y as f64 + 0.5, height);
    let (mut light, mut covered) = (Vec3::zeros(), 0);
    let first_row = y * samples - band.rows.start;
    for k in 0..samples * samples {
        let at = (first_row + k / samples) * band.width + x * samples + k % samples;
        let panel = band.panel[at];
        let plain = if panel == NO_PANEL {
            background
        } else {
            shading.panels[FaceId::new(panel)]
        };
        light += match raster.lines.get(band.line[at] as usize) {
            Some(line) => plain + (line.ink - plain) * LINE_OPACITY,
            None => plain,
        };
        covered += usize::from(panel != NO_PANEL);
    }
    let middle = (first_row + samples / 2) * band.width + x * samples + samples / 2;
    let count = (samples * samples) as f64;
    Pixel {
        light: light / count,
        panel: band.panel[middle],
        nearness: band.nearness[middle],
        covered: (covered as f64 / count) as f32,
    }
}
