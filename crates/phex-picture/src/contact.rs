//! A contact sheet: several meshes side by side, seen from the same side, with what is said of
//! each.

use crate::camera::Camera;
use crate::legend::{INK, write};
use crate::strokes::{HEIGHT, advance};
use crate::{Picture, PictureOptions, draw};
use phex_mesh::{HexMesh, Vec2};

/// Width and height of each picture, pixels.
const TILE: [usize; 2] = [640, 460];
/// Tiles in a row at the most.
const COLUMNS: usize = 3;
/// Space around tiles and texts, pixels.
const GAP: usize = 24;
/// Distance of two lines, pixels.
const LINE: usize = 26;
/// Height of capitals of texts and titles, pixels.
const TEXT: f64 = 11.0;
const TITLE: f64 = 14.0;

/// A mesh on a contact sheet, and what is said of it.
#[derive(Clone, Copy, Debug)]
pub struct ContactTile<'a> {
    /// The panels.
    pub mesh: &'a HexMesh,
    /// What it is.
    pub title: &'a str,
    /// What is told of it.
    pub lines: &'a [String],
}

impl ContactTile<'_> {
    /// Its picture, from a side in degrees; `None` for the one that shows most.
    pub fn picture(&self, azimuth: Option<f64>) -> Picture {
        let options = PictureOptions {
            width: TILE[0],
            height: TILE[1],
            azimuth,
            ground: false,
            ..PictureOptions::default()
        };
        draw(self.mesh, &options)
    }
}

/// The side that shows most of the first of some meshes, degrees; all are seen from it.
pub fn common_azimuth(tiles: &[ContactTile<'_>]) -> Option<f64> {
    let options = PictureOptions::default();
    let first = tiles.first()?;
    Some(Camera::azimuth(first.mesh, &options))
}

/// Draws meshes side by side under a heading.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()].to_vec();
/// # let mesh = HexMesh::new(corners, &[[0, 1, 2]])?;
/// use phex_picture::{ContactTile, contact_sheet};
///
/// let lines = ["1 panel".to_owned()];
/// let tile = ContactTile { mesh: &mesh, title: "A triangle", lines: &lines };
/// let sheet = contact_sheet("Two of them", &[tile, tile]);
/// assert!(sheet.width > 1000 && sheet.height > 400);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn contact_sheet(heading: &str, tiles: &[ContactTile<'_>]) -> Picture {
    let columns = tiles.len().clamp(1, COLUMNS);
    let width = GAP + columns * (TILE[0] + GAP);
    let heading = wrapped(heading, TEXT, width - 2 * GAP);
    let texts: Vec<Vec<String>> = tiles.iter().map(text_of).collect();
    let heights: Vec<usize> = (texts.chunks(columns))
        .map(|row| {
            let most = row.iter().map(Vec::len).max().unwrap_or(0);
            TILE[1] + LINE * (2 + most) + GAP
        })
        .collect();
    let top = GAP + LINE * heading.len() + GAP;
    let mut sheet = Canvas::new(width, top + heights.iter().sum::<usize>());
    sheet.write_lines([GAP, GAP], TEXT, &heading);
    let azimuth = common_azimuth(tiles);
    for (k, (tile, text)) in tiles.iter().zip(&texts).enumerate() {
        let x = GAP + k % columns * (TILE[0] + GAP);
        let y = top + heights[..k / columns].iter().sum::<usize>();
        sheet.paste([x, y], &tile.picture(azimuth));
        sheet.write_lines([x, y + TILE[1]], TITLE, &[tile.title.to_owned()]);
        sheet.write_lines([x, y + TILE[1] + LINE], TEXT, text);
    }
    sheet.0
}

/// The lines of a tile, none wider than its picture.
fn text_of(tile: &ContactTile<'_>) -> Vec<String> {
    let lines = tile.lines.iter();
    lines
        .flat_map(|line| wrapped(line, TEXT, TILE[0]))
        .collect()
}

/// A text in lines of a width in pixels at the most, where its words allow it.
fn wrapped(text: &str, height: f64, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if advance(&format!("{line} {word}"), height) <= width as f64 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// A white picture on which others are put, and texts.
struct Canvas(Picture);

impl Canvas {
    fn new(width: usize, height: usize) -> Self {
        let rgba = vec![255; 4 * width * height];
        Self(Picture {
            width,
            height,
            rgba,
        })
    }

    fn paste(&mut self, [x, y]: [usize; 2], picture: &Picture) {
        let rows = picture.rgba.chunks_exact(4 * picture.width);
        for (k, row) in rows.enumerate() {
            let start = 4 * ((y + k) * self.0.width + x);
            self.0.rgba[start..start + row.len()].copy_from_slice(row);
        }
    }

    /// Writes lines below a place, which is their upper left end.
    fn write_lines(&mut self, [x, y]: [usize; 2], height: f64, lines: &[String]) {
        let Picture { width, rgba, .. } = &mut self.0;
        let limit = *width;
        for (k, line) in lines.iter().enumerate() {
            let base = Vec2::new(x as f64, (y + (k + 1) * LINE) as f64 - 6.0);
            write(base, height / HEIGHT, line, |x, y, opacity| {
                let at = 4 * (y * limit + x);
                let inside = x < limit && at + 3 < rgba.len();
                for (value, ink) in rgba.iter_mut().skip(at).zip(INK).filter(|_| inside) {
                    let ink = 255.0 * ink;
                    *value = (f64::from(*value) * (1.0 - opacity) + ink * opacity).round() as u8;
                }
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn lines_are_no_wider_than_their_tile_and_lose_no_word() {
        let text = "not chosen: areas are less even and three panels are irregular without need";
        let lines = wrapped(text, TEXT, 200);
        assert!(lines.len() > 2);
        assert!(lines.iter().all(|line| advance(line, TEXT) <= 200.0));
        assert_eq!(lines.join(" "), text);
        assert!(wrapped("", TEXT, 10).is_empty());
        assert_eq!(wrapped("unbreakable", TEXT, 3).len(), 1);
    }

    #[test]
    fn every_tile_has_its_picture_and_its_text() {
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let places = corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
        let mesh = HexMesh::new(places, &[[0, 1, 2, 3]]).unwrap();
        let lines = ["one".to_owned(), "two".to_owned()];
        let tile = ContactTile {
            mesh: &mesh,
            title: "Square",
            lines: &lines,
        };
        let sheet = contact_sheet("Four", &[tile; 4]);
        assert_eq!(sheet.width, GAP + 3 * (TILE[0] + GAP));
        let inked = |x: usize, y: usize, w: usize, h: usize| {
            let rows = y..y + h;
            let row = |y: usize| {
                let start = 4 * (y * sheet.width + x);
                sheet.rgba[start..start + 4 * w]
                    .chunks(4)
                    .filter(|p| p[0] < 200)
                    .count()
            };
            rows.map(row).sum::<usize>()
        };
        let top = GAP + LINE + GAP;
        let row = TILE[1] + LINE * 4 + GAP;
        for (k, y) in [(0, top), (1, top), (2, top), (0, top + row)] {
            let x = GAP + k * (TILE[0] + GAP);
            assert!(inked(x, y, TILE[0], TILE[1]) > 1000);
            assert!(inked(x, y + TILE[1], TILE[0], 4 * LINE) > 50);
        }
        assert_eq!(inked(GAP + TILE[0] + GAP, top + row, TILE[0], row), 0);
    }
}
