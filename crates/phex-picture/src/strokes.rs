//! A single-line alphabet: each letter is a few straight strokes and arcs.
//!
//! Units: small letters are 4 high and stand on height 0, ascenders and digits reach 6, descenders -2.

use phex_mesh::Vec2;

/// A part of a letter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stroke {
    /// From `(0, 1)` to `(2, 3)`.
    Line(f64, f64, f64, f64),
    /// Centre, radii, first and last angle in degrees counter-clockwise from the right.
    Arc(f64, f64, f64, f64, f64, f64),
}

use Stroke::{Arc, Line};

const BOWL: Stroke = Arc(2.0, 2.0, 2.0, 2.0, 0.0, 360.0);

/// Strokes and advance width of a character; those without a letter form are blank.
pub fn glyph(c: char) -> (&'static [Stroke], f64) {
    match c {
        'a'..='m' => first_half(c),
        'n'..='z' => second_half(c),
        '0'..='9' => digit(c),
        ',' => (&[Line(0.3, 0.3, -0.3, -1.2)], 1.6),
        '.' => (&[Line(0.0, 0.0, 0.0, 0.2)], 1.6),
        '-' => (&[Line(0.0, 2.0, 2.4, 2.0)], 4.0),
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

fn first_half(c: char) -> (&'static [Stroke], f64) {
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

fn second_half(c: char) -> (&'static [Stroke], f64) {
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

fn digit(c: char) -> (&'static [Stroke], f64) {
    const WIDTH: f64 = 5.2;
    let strokes: &[Stroke] = match c {
        '0' => &[Arc(1.9, 3.0, 1.9, 3.0, 0.0, 360.0)],
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

/// The segments of a text in its units, the baseline along x from the origin.
pub fn segments(text: &str) -> Vec<[Vec2; 2]> {
    let (mut pen, mut out) = (0.0, Vec::new());
    for c in text.chars() {
        let (strokes, advance) = glyph(c);
        let points = strokes.iter().flat_map(|s| polyline(*s));
        out.extend(points.map(|ends| ends.map(|p| p + Vec2::new(pen, 0.0))));
        pen += advance;
    }
    out
}

/// Length of a text in its units.
pub fn text_width(text: &str) -> f64 {
    text.chars().map(|c| glyph(c).1).sum()
}

fn polyline(stroke: Stroke) -> Vec<[Vec2; 2]> {
    match stroke {
        Line(x0, y0, x1, y1) => vec![[Vec2::new(x0, y0), Vec2::new(x1, y1)]],
        Arc(x, y, rx, ry, from, to) => {
            let steps = ((to - from) / 20.0).ceil();
            let at = |k: f64| {
                let (sin, cos) = (from + (to - from) * k / steps).to_radians().sin_cos();
                Vec2::new(x + rx * cos, y + ry * sin)
            };
            (0..steps as usize)
                .map(|k| [at(k as f64), at(k as f64 + 1.0)])
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_of_the_legend_has_a_form_within_its_width() {
        for c in "abcdefghijklmnopqrstuvwxyz0123456789/%".chars() {
            let (strokes, advance) = glyph(c);
            assert!(!strokes.is_empty(), "{c}");
            for p in segments(&c.to_string()).as_flattened() {
                assert!(
                    (-0.1..advance).contains(&p.x) && (-2.1..=6.2).contains(&p.y),
                    "{c}: {p}"
                );
            }
        }
    }
}
