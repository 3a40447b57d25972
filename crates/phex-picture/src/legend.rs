//! The legend in pixels: swatches with the number and name of each class, or a strip of colours
//! with its histogram.

use super::legend_layout::{Item, LegendLayout};
use super::paint::Legend;
use super::raster::LinearImage;
use crate::srgb::{linear, linear_bytes};
use crate::strokes::{HEIGHT, strokes};
use phex_mesh::{Vec2, Vec3};

/// Colour of texts, sRGB.
pub const INK: [f64; 3] = [0.22, 0.22, 0.25];

/// Draws the legend in the corner where it hides least of the model, at best the lower left.
pub fn draw(sheet: &mut LinearImage, legend: &Legend) {
    let size = Vec2::new(sheet.width as f64, sheet.height as f64);
    let layout = LegendLayout::new(legend, size.y);
    let corner = layout.place(size, |low, high| {
        let hidden = pixels_around([low, high], 0.0);
        hidden
            .filter(|&(x, y)| sheet.panel_at(x as f64, y as f64).is_some())
            .count()
    });
    for item in &layout.items {
        draw_item(sheet, corner, item);
    }
}

fn draw_item(sheet: &mut LinearImage, corner: Vec2, item: &Item) {
    match item {
        Item::Hexagon {
            centre,
            radius,
            colour,
        } => hexagon(sheet, corner + centre, *radius, linear_bytes(*colour)),
        Item::Rectangle { low, high, colour } => {
            rectangle(sheet, [corner + low, corner + high], linear_bytes(*colour));
        }
        Item::Text { start, unit, text } => {
            let ink = linear(INK);
            write(corner + start, *unit, text, |x, y, opacity| {
                sheet.blend(x, y, ink, opacity);
            });
        }
    }
}

fn hexagon(sheet: &mut LinearImage, centre: Vec2, radius: f64, colour: Vec3) {
    let ink = linear([0.25, 0.25, 0.28]);
    for (x, y) in pixels_around([centre; 2], radius + 1.0) {
        let offset = Vec2::new(x as f64 + 0.5, y as f64 + 0.5) - centre;
        let outside = hexagon_distance(offset, radius);
        sheet.blend(x, y, colour, (0.5 - outside).clamp(0.0, 1.0));
        sheet.blend(x, y, ink, (1.0 - outside.abs()).clamp(0.0, 1.0) * 0.8);
    }
}

/// Signed distance to the border of a hexagon that stands on a corner, negative inside.
fn hexagon_distance(p: Vec2, radius: f64) -> f64 {
    let half_sqrt3 = 0.75_f64.sqrt();
    p.x.abs().max(p.x.abs() / 2.0 + p.y.abs() * half_sqrt3) - radius * half_sqrt3
}

/// Fills a rectangle; pixels that it covers in part take as much of the colour.
fn rectangle(sheet: &mut LinearImage, [low, high]: [Vec2; 2], colour: Vec3) {
    let share = |x: usize, low: f64, high: f64| {
        let x = x as f64;
        ((x + 1.0).min(high) - x.max(low)).clamp(0.0, 1.0)
    };
    for (x, y) in pixels_around([low, high], 0.0) {
        let covered = share(x, low.x, high.x) * share(y, low.y, high.y);
        sheet.blend(x, y, colour, covered);
    }
}

/// Writes text with its baseline at `start`, `unit` pixels per unit of the alphabet; `blend` has
/// pixels with their share of ink.
pub fn write(start: Vec2, unit: f64, text: &str, mut blend: impl FnMut(usize, usize, f64)) {
    let radius = (0.32 * unit).max(0.5);
    let place = |p: Vec2| start + Vec2::new(p.x, -p.y) * unit;
    let written = strokes(text, HEIGHT);
    let pairs = written.iter().flat_map(|line| line.windows(2));
    let lines: Vec<[Vec2; 2]> = pairs.map(|ends| [place(ends[0]), place(ends[1])]).collect();
    let Some((low, high)) = bounds(&lines) else {
        return;
    };
    // Every pixel once, by its nearest stroke: crossings must not be darker.
    for (x, y) in pixels_around([low, high], radius + 1.0) {
        let p = Vec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let distance = lines
            .iter()
            .map(|l| segment_distance(p, l))
            .fold(f64::MAX, f64::min);
        blend(x, y, (radius + 0.5 - distance).clamp(0.0, 1.0));
    }
}

fn bounds(lines: &[[Vec2; 2]]) -> Option<(Vec2, Vec2)> {
    (!lines.is_empty()).then(|| phex_mesh::bounds(lines.as_flattened()).into())
}

fn segment_distance(p: Vec2, [a, b]: &[Vec2; 2]) -> f64 {
    let along = b - a;
    let t = ((p - a).dot(&along) / along.norm_squared().max(1e-12)).clamp(0.0, 1.0);
    (p - a - along * t).norm()
}

/// Pixels within `margin` of the box between two points.
fn pixels_around([low, high]: [Vec2; 2], margin: f64) -> impl Iterator<Item = (usize, usize)> {
    let columns = (low.x - margin).max(0.0) as usize..(high.x + margin).ceil().max(0.0) as usize;
    let rows = (low.y - margin).max(0.0) as usize..(high.y + margin).ceil().max(0.0) as usize;
    rows.flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexagon_has_corners_above_and_sides_left() {
        assert!(hexagon_distance(Vec2::new(0.0, 0.0), 1.0) < 0.0);
        assert!(hexagon_distance(Vec2::new(0.0, 1.0), 1.0).abs() < 1e-12);
        assert!(hexagon_distance(Vec2::new(0.75_f64.sqrt(), 0.0), 1.0).abs() < 1e-12);
    }
}
