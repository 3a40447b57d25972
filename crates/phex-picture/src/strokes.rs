//! A single-line font, for legends, engraving and plotting: each letter is a few straight strokes
//! and arcs.
//!
//! Units: capitals and digits are 6 high, small letters 4; descenders reach -2.

use phex_mesh::Vec2;

/// Height of capitals and digits in units of the font.
pub const HEIGHT: f64 = 6.0;
/// A zero with a stroke through it, which nobody takes for the letter.
pub const SLASHED_ZERO: char = '∅';

/// A part of a letter.
#[derive(Clone, Copy, Debug, PartialEq)]
enum GlyphStroke {
    /// From `(0, 1)` to `(2, 3)`.
    Line(f64, f64, f64, f64),
    /// Centre, radii, first and last angle in degrees counter-clockwise from the right.
    Arc(f64, f64, f64, f64, f64, f64),
}

use GlyphStroke::{Arc, Line};

const BOWL: GlyphStroke = Arc(2.0, 2.0, 2.0, 2.0, 0.0, 360.0);
const ZERO: GlyphStroke = Arc(1.9, 3.0, 1.9, 3.0, 0.0, 360.0);

/// Strokes and advance width of a character other than capitals; those without a form are blank.
fn glyph(c: char) -> (&'static [GlyphStroke], f64) {
    match c {
        'a'..='m' => first_half(c),
        'n'..='z' => second_half(c),
        '0'..='9' => digit(c),
        SLASHED_ZERO => (&[ZERO, Line(0.9, 1.5, 2.9, 4.5)], 5.2),
        ',' => (&[Line(0.3, 0.3, -0.3, -1.2)], 1.6),
        '.' => (&[Line(0.0, 0.0, 0.0, 0.2)], 1.6),
        '-' => (&[Line(0.0, 2.0, 2.4, 2.0)], 4.0),
        '+' => (&[Line(0.0, 2.0, 2.4, 2.0), Line(1.2, 0.8, 1.2, 3.2)], 4.0),
        ':' => (&[Line(0.0, 0.6, 0.0, 0.8), Line(0.0, 3.2, 0.0, 3.4)], 1.6),
        '_' => (&[Line(0.0, 0.0, 4.0, 0.0)], 5.6),
        '°' => (&[Arc(0.9, 5.1, 0.9, 0.9, 0.0, 360.0)], 3.4),
        '/' => (&[Line(0.0, -0.6, 2.6, 6.2)], 4.0),
        '%' => (
            &[
                Line(0.4, 0.0, 4.8, 6.0),
                Arc(1.1, 4.7, 1.1, 1.2, 0.0, 360.0),
                Arc(4.1, 1.3, 1.1, 1.2, 0.0, 360.0),
            ],
            6.8,
        ),
        _ => (&[], 3.0),
    }
}

/// Capitals on the grid: all have the same width.
fn capital(c: char) -> &'static str {
    match c {
        'A' => "0004264440 0242",
        'B' => "00063645443303 3342413000",
        'C' => "4536160501103041",
        'D' => "00063645413000",
        'E' => "46060040 0333",
        'F' => "460600 0333",
        'G' => "45361605011030414323",
        'H' => "0006 4046 0343",
        'I' => "1030 2026 1636",
        'J' => "4641301001",
        'K' => "0006 4602 1340",
        'L' => "060040",
        'M' => "0006234640",
        'N' => "00064046",
        'O' => "100105163645413010",
        'P' => "00063645443303",
        'Q' => "100105163645413010 2240",
        'R' => "00063645443303 2340",
        'S' => "453616050413334241301001",
        'T' => "0646 2620",
        'U' => "060110304146",
        'V' => "062046",
        'W' => "0610233046",
        'X' => "0640 0046",
        'Y' => "062346 2320",
        _ => "06460040",
    }
}

fn first_half(c: char) -> (&'static [GlyphStroke], f64) {
    match c {
        'a' => (&[BOWL, Line(4.0, 0.0, 4.0, 4.0)], 5.6),
        'b' => (&[BOWL, Line(0.0, 0.0, 0.0, 6.0)], 5.4),
        'c' => (&[Arc(2.0, 2.0, 2.0, 2.0, 45.0, 315.0)], 4.8),
        'd' => (&[BOWL, Line(4.0, 0.0, 4.0, 6.0)], 5.6),
        'e' => (
            &[
                Arc(2.0, 2.0, 2.0, 2.0, 0.0, 315.0),
                Line(0.0, 2.0, 4.0, 2.0),
            ],
            5.2,
        ),
        'f' => (
            &[
                Arc(2.2, 4.8, 1.2, 1.2, 70.0, 180.0),
                Line(1.0, 4.8, 1.0, 0.0),
                Line(0.0, 4.0, 2.4, 4.0),
            ],
            3.4,
        ),
        'g' => (
            &[
                BOWL,
                Line(4.0, 4.0, 4.0, -0.2),
                Arc(2.0, -0.2, 2.0, 1.8, 215.0, 360.0),
            ],
            5.6,
        ),
        'h' => (
            &[
                Line(0.0, 0.0, 0.0, 6.0),
                Arc(1.7, 2.3, 1.7, 1.7, 0.0, 180.0),
                Line(3.4, 2.3, 3.4, 0.0),
            ],
            5.0,
        ),
        'i' => (&[Line(0.0, 0.0, 0.0, 4.0), Line(0.0, 5.6, 0.0, 5.8)], 1.8),
        'j' => (
            &[
                Line(1.0, -0.8, 1.0, 4.0),
                Line(1.0, 5.6, 1.0, 5.8),
                Arc(0.0, -0.8, 1.0, 1.1, 270.0, 360.0),
            ],
            2.6,
        ),
        'k' => (
            &[
                Line(0.0, 0.0, 0.0, 6.0),
                Line(3.0, 4.0, 0.0, 1.6),
                Line(1.1, 2.4, 3.2, 0.0),
            ],
            4.4,
        ),
        'l' => (&[Line(0.0, 0.0, 0.0, 6.0)], 1.8),
        _ => (
            &[
                Line(0.0, 0.0, 0.0, 4.0),
                Arc(1.4, 2.6, 1.4, 1.4, 0.0, 180.0),
                Line(2.8, 2.6, 2.8, 0.0),
                Arc(4.2, 2.6, 1.4, 1.4, 0.0, 180.0),
                Line(5.6, 2.6, 5.6, 0.0),
            ],
            7.2,
        ),
    }
}

fn second_half(c: char) -> (&'static [GlyphStroke], f64) {
    match c {
        'n' => (
            &[
                Line(0.0, 0.0, 0.0, 4.0),
                Arc(1.7, 2.3, 1.7, 1.7, 0.0, 180.0),
                Line(3.4, 2.3, 3.4, 0.0),
            ],
            5.0,
        ),
        'o' => (&[BOWL], 5.4),
        'p' => (&[BOWL, Line(0.0, 4.0, 0.0, -2.0)], 5.4),
        'q' => (&[BOWL, Line(4.0, 4.0, 4.0, -2.0)], 5.6),
        'r' => (
            &[
                Line(0.0, 0.0, 0.0, 4.0),
                Arc(1.6, 2.4, 1.6, 1.6, 60.0, 180.0),
            ],
            3.4,
        ),
        's' => (
            &[
                Arc(1.45, 2.98, 1.2, 1.02, 35.0, 270.0),
                Arc(1.45, 0.98, 1.3, 0.98, -145.0, 90.0),
            ],
            4.2,
        ),
        't' => (
            &[
                Line(1.0, 5.4, 1.0, 0.9),
                Arc(1.9, 0.9, 0.9, 0.9, 180.0, 290.0),
                Line(0.0, 4.0, 2.3, 4.0),
            ],
            3.4,
        ),
        'u' => (
            &[
                Line(0.0, 4.0, 0.0, 1.7),
                Arc(1.7, 1.7, 1.7, 1.7, 180.0, 360.0),
                Line(3.4, 0.0, 3.4, 4.0),
            ],
            5.0,
        ),
        'v' => (&[Line(0.0, 4.0, 1.8, 0.0), Line(1.8, 0.0, 3.6, 4.0)], 4.8),
        'w' => (
            &[
                Line(0.0, 4.0, 1.4, 0.0),
                Line(1.4, 0.0, 2.8, 4.0),
                Line(2.8, 4.0, 4.2, 0.0),
                Line(4.2, 0.0, 5.6, 4.0),
            ],
            6.8,
        ),
        'x' => (&[Line(0.0, 0.0, 3.4, 4.0), Line(0.0, 4.0, 3.4, 0.0)], 4.6),
        'y' => (&[Line(0.0, 4.0, 1.8, 0.0), Line(3.6, 4.0, 0.9, -2.0)], 4.8),
        _ => (
            &[
                Line(0.0, 4.0, 3.2, 4.0),
                Line(3.2, 4.0, 0.0, 0.0),
                Line(0.0, 0.0, 3.2, 0.0),
            ],
            4.4,
        ),
    }
}

fn digit(c: char) -> (&'static [GlyphStroke], f64) {
    const WIDTH: f64 = 5.2;
    let strokes: &[GlyphStroke] = match c {
        '0' => &[ZERO],
        '1' => &[Line(0.6, 4.8, 2.2, 6.0), Line(2.2, 6.0, 2.2, 0.0)],
        '2' => &[
            Arc(1.9, 4.2, 1.8, 1.8, -25.0, 165.0),
            Line(3.53, 3.44, 0.1, 0.0),
            Line(0.1, 0.0, 3.8, 0.0),
        ],
        '3' => &[
            Arc(1.8, 4.5, 1.6, 1.5, -90.0, 150.0),
            Arc(1.8, 1.5, 1.8, 1.5, -150.0, 90.0),
        ],
        '4' => &[
            Line(2.8, 0.0, 2.8, 6.0),
            Line(2.8, 6.0, 0.0, 1.6),
            Line(0.0, 1.6, 3.9, 1.6),
        ],
        '5' => &[
            Line(3.4, 6.0, 0.8, 6.0),
            Line(0.8, 6.0, 0.5, 3.3),
            Arc(1.8, 1.95, 1.95, 1.95, -145.0, 132.0),
        ],
        '6' => &[
            Arc(1.9, 1.9, 1.9, 1.9, 0.0, 360.0),
            Line(0.3, 2.9, 2.6, 6.0),
        ],
        '7' => &[Line(0.1, 6.0, 3.7, 6.0), Line(3.7, 6.0, 1.2, 0.0)],
        '8' => &[
            Arc(1.9, 4.5, 1.6, 1.5, 0.0, 360.0),
            Arc(1.9, 1.5, 1.9, 1.5, 0.0, 360.0),
        ],
        _ => &[
            Arc(1.9, 4.1, 1.9, 1.9, 0.0, 360.0),
            Line(3.5, 3.1, 1.2, 0.0),
        ],
    };
    (strokes, WIDTH)
}

/// Whether the font has a character; a blank is none.
pub fn is_drawn(c: char) -> bool {
    c.is_ascii_uppercase() || !glyph(c).0.is_empty()
}

/// The polylines of a text whose base line starts at the origin and runs along x, and whose
/// capitals have the given height. Characters that the font does not have are blank.
///
/// ```
/// use phex_picture::strokes::{strokes, width};
///
/// let lines = strokes("L", 6.0);
/// let points: Vec<[f64; 2]> = lines[0].iter().map(|p| [p.x, p.y]).collect();
/// assert_eq!(points, [[0.0, 6.0], [0.0, 0.0], [4.0, 0.0]]);
/// assert_eq!(width("L", 6.0), 4.0);
/// ```
pub fn strokes(text: &str, height: f64) -> Vec<Vec<Vec2>> {
    let scale = height / HEIGHT;
    let (mut pen, mut out) = (0.0, Vec::new());
    for c in text.chars() {
        let place = |p: Vec2| (p + Vec2::new(pen, 0.0)) * scale;
        out.extend(
            lines(c)
                .into_iter()
                .map(|line| line.into_iter().map(place).collect()),
        );
        pen += advance_of(c);
    }
    out
}

/// From the start of a text to that of another one behind it.
pub fn advance(text: &str, height: f64) -> f64 {
    text.chars().map(advance_of).sum::<f64>() * height / HEIGHT
}

/// Width of what is drawn of a text.
pub fn width(text: &str, height: f64) -> f64 {
    let all = strokes(text, height).into_iter().flatten();
    all.map(|p| p.x).fold(0.0, f64::max)
}

fn advance_of(c: char) -> f64 {
    if c.is_ascii_uppercase() {
        6.0
    } else {
        glyph(c).1
    }
}

/// The polylines of a character.
fn lines(c: char) -> Vec<Vec<Vec2>> {
    if !c.is_ascii_uppercase() {
        return glyph(c).0.iter().map(|s| polyline(*s)).collect();
    }
    let digit = |byte: u8| f64::from(byte - b'0');
    let point = |pair: &[u8]| Vec2::new(digit(pair[0]), digit(pair[1]));
    let runs = capital(c).split(' ');
    runs.map(|run| run.as_bytes().chunks_exact(2).map(point).collect())
        .collect()
}

fn polyline(stroke: GlyphStroke) -> Vec<Vec2> {
    match stroke {
        Line(x0, y0, x1, y1) => vec![Vec2::new(x0, y0), Vec2::new(x1, y1)],
        Arc(x, y, rx, ry, from, to) => {
            let steps = ((to - from) / 20.0).ceil();
            let at = |k: usize| {
                let angle = from + (to - from) * k as f64 / steps;
                let (sin, cos) = angle.to_radians().sin_cos();
                Vec2::new(x + rx * cos, y + ry * sin)
            };
            (0..=steps as usize).map(at).collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_character_has_strokes_of_its_own_within_its_width() {
        let letters = ('A'..='Z').chain('a'..='z').chain('0'..='9');
        let all: Vec<char> = letters.chain(".,-+/:%°_∅".chars()).collect();
        for (i, &c) in all.iter().enumerate() {
            let shape = strokes(&c.to_string(), HEIGHT);
            assert!(is_drawn(c) && !shape.is_empty(), "{c}");
            assert!(shape.iter().all(|line| line.len() > 1), "{c}");
            for p in shape.iter().flatten() {
                let is_inside = (-0.4..advance_of(c)).contains(&p.x) && (-2.1..=6.3).contains(&p.y);
                assert!(is_inside, "{c}: {p}");
            }
            let same = |d: &&char| strokes(&d.to_string(), HEIGHT) == shape;
            assert_eq!(all[..i].iter().find(same), None, "{c}");
        }
    }

    #[test]
    fn texts_follow_one_another() {
        let both = strokes("H0 m.5", 3.0);
        let behind = Vec2::new(advance("H0 ", 3.0), 0.0);
        let second = strokes("m.5", 3.0).into_iter();
        let moved = second.map(|line| line.into_iter().map(|p| p + behind).collect());
        let apart: Vec<Vec<Vec2>> = strokes("H0 ", 3.0).into_iter().chain(moved).collect();
        assert_eq!(both.len(), apart.len());
        let pairs = both.iter().flatten().zip(apart.iter().flatten());
        assert!(pairs.into_iter().all(|(p, q)| (p - q).norm() < 1e-12));
        assert_eq!((width("", 3.0), width("H", 3.0)), (0.0, 2.0));
    }
}
