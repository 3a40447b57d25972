//! A single-line font: capital letters, digits and a few signs as open polylines, for engraving and plotting.
//!
//! Glyphs stand on a grid 4 wide and 6 high. Each stroke is a run of points, each point its x and y digit.

use phex_mesh::Vec2;

/// Height and width of a glyph, and the distance of the next one's start, in units of the grid.
const HEIGHT: f64 = 6.0;
const WIDTH: f64 = 4.0;
const ADVANCE: f64 = 6.0;

fn glyph(c: char) -> &'static str {
    match c.to_ascii_uppercase() {
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
        'Z' => "06460040",
        '0' => "100105163645413010 1135",
        '1' => "152620 1030",
        '2' => "05163645440040",
        '3' => "05163645443313 334241301001",
        '4' => "30360242",
        '5' => "460603334241301001",
        '6' => "4536160501103041423303",
        '7' => "064610",
        '8' => "13040516364544331302011030414233",
        '9' => "011030414536160504134344",
        '.' => "2021",
        '-' => "1333",
        '+' => "1333 2224",
        '/' => "0046",
        ':' => "2122 2425",
        '%' => "0046 0516 3041",
        '°' => "1526352415",
        '_' => "0040",
        _ => "",
    }
}

/// Whether the font has a character; a blank is none.
pub fn is_drawn(c: char) -> bool {
    !glyph(c).is_empty()
}

/// Width of a text of a given height.
pub fn width(text: &str, height: f64) -> f64 {
    let glyphs = text.chars().count();
    if glyphs == 0 {
        return 0.0;
    }
    (ADVANCE * (glyphs - 1) as f64 + WIDTH) * height / HEIGHT
}

/// The polylines of a text whose base line starts at the origin and runs along x. Characters that the font does not
/// have are blank; lower case is written as upper case.
pub fn strokes(text: &str, height: f64) -> Vec<Vec<Vec2>> {
    let scale = height / HEIGHT;
    let places = text.chars().enumerate();
    places
        .flat_map(|(k, c)| {
            let start = ADVANCE * k as f64;
            let point = move |d: &[u8]| {
                Vec2::new(start + f64::from(d[0] - b'0'), f64::from(d[1] - b'0')) * scale
            };
            let run = move |s: &str| s.as_bytes().chunks_exact(2).map(point).collect();
            glyph(c).split_whitespace().map(run)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sign_in_use_has_strokes_of_its_own_inside_its_cell() {
        let all: Vec<char> = ('A'..='Z')
            .chain('0'..='9')
            .chain(".-+/:%°_".chars())
            .collect();
        for (i, c) in all.iter().enumerate() {
            let shape = strokes(&c.to_string(), 6.0);
            assert!(
                !shape.is_empty() && shape.iter().all(|s| s.len() > 1),
                "{c}"
            );
            let inside = |p: &Vec2| (0.0..=WIDTH).contains(&p.x) && (0.0..=HEIGHT).contains(&p.y);
            assert!(shape.iter().flatten().all(inside), "{c}");
            assert!(
                all[..i]
                    .iter()
                    .all(|d| strokes(&d.to_string(), 6.0) != shape),
                "{c}"
            );
        }
    }

    #[test]
    fn texts_are_as_wide_as_they_say() {
        for text in ["H", "HH", "H0M"] {
            let widest = strokes(text, 3.0)
                .concat()
                .iter()
                .map(|p| p.x)
                .fold(0.0, f64::max);
            assert_eq!(widest, width(text, 3.0));
        }
        assert_eq!(width("", 3.0), 0.0);
    }
}
