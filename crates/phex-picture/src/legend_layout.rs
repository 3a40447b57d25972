//! Where the parts of a legend stand, for pixels and for vectors alike.

use super::paint::{Legend, LegendStrip};
use crate::maps::Rgb;
use crate::strokes::{self, HEIGHT};
use phex_mesh::Vec2;

/// Distance of two lines of the legend over the picture's height.
const LINE_REL: f64 = 0.027;
/// Distance of two lines that can be read, in pixels, and what it may be at most over the height of
/// a small picture.
const LEGIBLE: f64 = 24.0;
const MOST_REL: f64 = 0.042;
/// Unit of the alphabet over the distance of two lines.
const UNIT_REL: f64 = 0.07;
/// Length of a strip of colours in lines.
const STRIP_LENGTH: f64 = 15.0;
/// Height of the histogram on it in lines.
const HISTOGRAM_HEIGHT: f64 = 2.6;
/// Colour of the bars and marks.
const INK: Rgb = [0x40, 0x40, 0x46];

/// A part of a legend; lengths in pixels from the legend's upper left end.
#[derive(Clone, Debug)]
pub enum Item {
    /// A hexagon on its corner.
    Hexagon {
        /// Its centre.
        centre: Vec2,
        /// Distance of its corners from the centre.
        radius: f64,
        /// Its colour.
        colour: Rgb,
    },
    /// A rectangle.
    Rectangle {
        /// Upper left corner.
        low: Vec2,
        /// Lower right corner.
        high: Vec2,
        /// Its colour.
        colour: Rgb,
    },
    /// A line of text.
    Text {
        /// Left end of the baseline.
        start: Vec2,
        /// Pixels per unit of the alphabet.
        unit: f64,
        /// The text.
        text: String,
    },
}

/// A legend with every part in its place.
#[derive(Clone, Debug)]
pub struct LegendLayout {
    /// The parts.
    pub items: Vec<Item>,
    /// Width and height.
    size: Vec2,
    /// Distance from the picture's border.
    margin: f64,
}

impl LegendLayout {
    /// Lays a legend out for a picture of the given height in pixels.
    pub fn new(legend: &Legend, height: f64) -> Self {
        let step = (LINE_REL * height).max(LEGIBLE.min(MOST_REL * height));
        let (items, size) = match legend {
            Legend::Classes(lines) => classes(lines, step),
            Legend::LegendStrip(strip) => strip_items(strip, step),
        };
        Self {
            items,
            size,
            margin: step,
        }
    }

    /// Upper left end of the legend in the corner of the picture where it hides least.
    pub fn place(&self, picture: Vec2, hidden: impl Fn(Vec2, Vec2) -> usize) -> Vec2 {
        let places = self.places(picture).into_iter();
        let best = places.min_by_key(|[low, high]| hidden(*low, *high));
        best.map(|[low, _]| low).unwrap_or_default()
    }

    /// Where the legend may stand: upper left and lower right end in each corner of the picture.
    pub fn places(&self, picture: Vec2) -> [[Vec2; 2]; 4] {
        let near = Vec2::repeat(self.margin);
        let far = picture - self.size - near;
        let corners = [
            (near.x, far.y),
            (far.x, far.y),
            (near.x, near.y),
            (far.x, near.y),
        ];
        corners.map(|(x, y)| [Vec2::new(x, y), Vec2::new(x, y) + self.size])
    }

    /// Width and height with the distance from the picture's border.
    pub fn room(&self) -> Vec2 {
        self.size + Vec2::repeat(self.margin)
    }
}

fn classes(lines: &[(Rgb, String)], step: f64) -> (Vec<Item>, Vec2) {
    let mut items = Vec::new();
    for (k, (colour, label)) in lines.iter().enumerate() {
        let line = Vec2::new(0.5, 0.5 + k as f64) * step;
        items.push(Item::Hexagon {
            centre: line,
            radius: 0.36 * step,
            colour: *colour,
        });
        items.push(text(
            line + Vec2::new(0.8, 0.21) * step,
            UNIT_REL * step,
            label,
        ));
    }
    let widest = lines.iter().map(|(_, label)| text_width(label));
    let widest = widest.fold(0.0, f64::max);
    let size = Vec2::new(1.3 + UNIT_REL * widest, lines.len() as f64) * step;
    (items, size)
}

/// Length of a text in units of the alphabet.
fn text_width(text: &str) -> f64 {
    strokes::advance(text, HEIGHT)
}

fn text(start: Vec2, unit: f64, text: &str) -> Item {
    Item::Text {
        start,
        unit,
        text: text.to_owned(),
    }
}

/// Caption, histogram, strip, marks with labels, from the top.
fn strip_items(strip: &LegendStrip, step: f64) -> (Vec<Item>, Vec2) {
    let unit = UNIT_REL * step;
    let length = (STRIP_LENGTH * step).max(unit * text_width(strip.caption));
    let top = (1.4 + HISTOGRAM_HEIGHT) * step;
    let mut items = vec![text(Vec2::new(0.0, 0.7 * step), unit, strip.caption)];
    items.extend(bars(strip, length, top, step));
    let cell = length / strip.colours.len() as f64;
    let cells = strip.colours.iter().enumerate();
    items.extend(cells.map(|(k, &colour)| Item::Rectangle {
        low: Vec2::new(k as f64 * cell, top),
        // Overlaps the next cell, which covers that part: no seam.
        high:
            Vec2::new((k as f64 + 1.6) * cell, top + 0.6 * step).inf(&Vec2::new(length, f64::MAX)),
        colour,
    }));
    items.extend(marks(strip, length, top, step));
    (items, Vec2::new(length, top + 2.0 * step))
}

fn bars(strip: &LegendStrip, length: f64, foot: f64, step: f64) -> Vec<Item> {
    let counts = &strip.histogram.counts;
    let most = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
    let width = length / counts.len() as f64;
    let bar = |(k, &n): (usize, &usize)| {
        // A bin with few elements must still be seen.
        let share = if n == 0 {
            0.0
        } else {
            (n as f64 / most).max(0.02)
        };
        let last = strip.colours.len() - 1;
        let at = (k as f64 + 0.5) / counts.len() as f64 * strip.colours.len() as f64;
        Item::Rectangle {
            low: Vec2::new(
                (k as f64 + 0.06) * width,
                foot - share * HISTOGRAM_HEIGHT * step - 0.08 * step,
            ),
            high: Vec2::new((k as f64 + 0.94) * width, foot - 0.08 * step),
            colour: darker(strip.colours[(at as usize).min(last)]),
        }
    };
    let filled = counts.iter().enumerate().filter(|(_, n)| **n > 0);
    filled.map(bar).collect()
}

/// A pale colour would be lost on the pale background.
fn darker(colour: Rgb) -> Rgb {
    colour.map(|c| (f64::from(c) * 0.86) as u8)
}

fn marks(strip: &LegendStrip, length: f64, top: f64, step: f64) -> Vec<Item> {
    let unit = 0.85 * UNIT_REL * step;
    let line = |at: f64, low: f64, high: f64| Item::Rectangle {
        low: Vec2::new(at - 0.03 * step, low),
        high: Vec2::new(at + 0.03 * step, high),
        colour: INK,
    };
    let mut items = Vec::new();
    for (place, label) in &strip.ticks {
        let at = place * length;
        let wide = unit * text_width(label);
        let start = (at - wide / 2.0).clamp(0.0, length - wide);
        items.push(line(at, top + 0.6 * step, top + 0.8 * step));
        items.push(text(Vec2::new(start, top + 1.45 * step), unit, label));
    }
    if let Some(limit) = strip.limit {
        items.push(line(limit * length, top - 0.9 * step, top + 0.6 * step));
    }
    items
}
