//! Wavefront OBJ: vertices (`v`) and faces (`f`); groups, materials, texture, normals, points and
//! lines are skipped (`other_elements` counts those that might be meant).

use super::error::{FilePlace, ReadCause, ReadError};
use super::text::{decode, integer, out_of_range, point, without_comment};
use crate::{OtherElements, PolygonSoup};
use std::borrow::Cow;
use std::fmt::Write;

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<PolygonSoup, ReadError> {
    let text = decode(bytes);
    let mut file = ObjFile::default();
    for (number, line) in logical_lines(&text) {
        file.read_line(FilePlace::Line(number), &line)?;
    }
    file.finish()
}

/// Counts elements that are no faces.
pub(super) fn other_elements(bytes: &[u8]) -> OtherElements {
    let mut found = OtherElements::default();
    for (_, line) in logical_lines(&decode(bytes)) {
        match line.split_whitespace().next() {
            Some("surf") => found.surfaces += 1,
            Some("curv") => found.curves += 1,
            Some("l") => found.polylines += 1,
            Some("p") => found.points += 1,
            _ => {}
        }
    }
    found
}

#[derive(Default)]
struct ObjFile {
    soup: PolygonSoup,
    /// Where each face stands: a face may name vertices that follow it, so the range is checked at
    /// the end.
    face_places: Vec<FilePlace>,
}

impl ObjFile {
    fn read_line(&mut self, place: FilePlace, line: &str) -> Result<(), ReadError> {
        let mut tokens = line.split_whitespace();
        match tokens.next() {
            Some("v") => self.soup.positions.push(point(tokens, place)?),
            Some("f") => {
                let corners: Result<_, ReadCause> = tokens.map(|t| self.corner(t)).collect();
                let corners: Vec<u32> = corners.map_err(|cause| cause.at(place))?;
                if corners.len() < 3 {
                    let corners = corners.len();
                    return Err(ReadCause::TooFewCorners { corners }.at(place));
                }
                self.soup.faces.push(corners);
                self.face_places.push(place);
            }
            _ => (),
        }
        Ok(())
    }

    /// The vertex number, from 0, of a corner `v`, `v/t`, `v//n` or `v/t/n`.
    fn corner(&self, token: &str) -> Result<u32, ReadCause> {
        let index = integer(token.split('/').next().unwrap_or_default())?;
        let so_far = self.soup.positions.len();
        let number = match index {
            0 => return Err(ReadCause::IndexZero),
            1.. => Some(index - 1),
            _ => index.checked_add(so_far as i64).filter(|&v| v >= 0),
        };
        number
            .and_then(|v| u32::try_from(v).ok())
            .ok_or_else(|| out_of_range(index, so_far, 1))
    }

    fn finish(self) -> Result<PolygonSoup, ReadError> {
        let vertices = self.soup.positions.len();
        if vertices >= u32::MAX as usize {
            return Err(ReadCause::TooManyVertices.into());
        }
        if vertices == 0 {
            return Err(ReadCause::NoVertices.into());
        }
        for (corners, &place) in self.soup.faces.iter().zip(&self.face_places) {
            if let Some(&v) = corners.iter().find(|&&v| v as usize >= vertices) {
                return Err(out_of_range(i64::from(v) + 1, vertices, 1).at(place));
            }
        }
        Ok(self.soup)
    }
}

/// Lines of an OBJ file without comments, joined where one ends in a backslash, with the number of
/// their first line.
pub fn logical_lines(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().map(without_comment).enumerate();
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let mut line = Cow::Borrowed(first);
        // Appended in place: a new text for each part would cost the square of the length.
        while let Some(head) = line.trim_end().strip_suffix('\\').map(str::len) {
            let (_, rest) = lines.next().unwrap_or_default();
            let whole = line.to_mut();
            whole.truncate(head);
            whole.push(' ');
            whole.push_str(rest);
        }
        Some((number + 1, line))
    })
}

/// The file of a mesh.
pub(super) fn encode(soup: &PolygonSoup) -> Vec<u8> {
    let mut text = String::new();
    push(&mut text, soup, 0);
    text.into_bytes()
}

/// An OBJ file of several named objects (`o`), in their order; blanks in names become `_`.
pub fn obj_of_objects(objects: &[(String, PolygonSoup)]) -> Vec<u8> {
    let mut text = String::new();
    let mut before = 0;
    for (name, soup) in objects {
        let name: Vec<&str> = name.split_whitespace().collect();
        let _ = writeln!(text, "o {}", name.join("_"));
        push(&mut text, soup, before);
        before += soup.positions.len() as u64;
    }
    text.into_bytes()
}

/// Adds a soup to a text that holds `before` vertices.
fn push(text: &mut String, soup: &PolygonSoup, before: u64) {
    for p in &soup.positions {
        let _ = writeln!(text, "v {:?} {:?} {:?}", p.x, p.y, p.z);
    }
    for face in &soup.faces {
        text.push('f');
        for &v in face {
            let _ = write!(text, " {}", before + u64::from(v) + 1);
        }
        text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;

    fn faces(text: &str) -> Vec<Vec<u32>> {
        parse(text.as_bytes()).unwrap().faces
    }

    fn error(text: &str) -> (FilePlace, ReadCause) {
        let error = parse(text.as_bytes()).unwrap_err();
        (error.place, error.cause)
    }

    #[test]
    fn elements_beside_faces_are_counted() {
        let text =
            b"v 0 0 0\nf 1 2 3\nl 1 2 \\\n 3\np 1\np 2 # l 1 2\ncurv 0 1 1 2\nsurf 0 1 0 1 1\n";
        let told = other_elements(text).told().unwrap();
        let expected =
            "1 free-form surface, 1 free-form curve, 1 polyline, 2 point elements were left out";
        assert!(told.starts_with(expected), "{told}");
        assert_eq!(other_elements(b"v 0 0 0\nf 1 2 3\n").told(), None);
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn all_corner_forms() {
        let corners = "vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1 4//1\nf 1/1/1 2/1/1 3/1/1\nf -4 -3 -2";
        let expected = vec![
            vec![0, 1, 2],
            vec![0, 1, 2],
            vec![0, 1, 2, 3],
            vec![0, 1, 2],
            vec![0, 1, 2],
        ];
        assert_eq!(faces(&format!("{SQUARE}{corners}")), expected);
    }

    #[test]
    fn comments_continuation_crlf_groups_colours_and_late_vertices() {
        let text = "# head\r\no roof\r\nf 1 2 \\\r\n  3 4 # quad\r\ng a\r\nl 1 2\r\np 1\r\nv 0 0 0 1\r\n\
                    v 1 0 0 0.5 0.5 0.5\r\nv\t1 1 \\\r\n 0\r\nv 0 1 0";
        let soup = parse(text.as_bytes()).unwrap();
        assert_eq!(soup.faces, vec![vec![0, 1, 2, 3]]);
        assert_eq!(soup.positions[2], Vec3::new(1.0, 1.0, 0.0));
        assert_eq!(soup.positions.len(), 4);
    }

    #[test]
    fn negative_numbers_count_from_the_line_they_stand_in() {
        let text = format!("{SQUARE}f -4 -3 -2\nv 2 2 2\nf -1 -2 -3");
        assert_eq!(faces(&text), vec![vec![0, 1, 2], vec![4, 3, 2]]);
    }

    #[test]
    fn bad_lines_are_named() {
        let with = |line: &str| error(&format!("{SQUARE}{line}\n"));
        assert!(matches!(
            with("f 0 1 2"),
            (FilePlace::Line(5), ReadCause::IndexZero)
        ));
        assert!(matches!(
            with("f 1 2"),
            (FilePlace::Line(5), ReadCause::TooFewCorners { corners: 2 })
        ));
        assert!(matches!(
            with("f 1 2 x"),
            (FilePlace::Line(5), ReadCause::NotANumber { .. })
        ));
        for index in [
            "-5",
            "5",
            "4294967296",
            "99999999999999999999",
            "-99999999999999999999",
        ] {
            let (place, cause) = with(&format!("f 1 2 {index}"));
            assert!(
                matches!(
                    cause,
                    ReadCause::IndexOutOfRange {
                        vertices: 4,
                        first: 1,
                        ..
                    }
                ),
                "{index}: {cause}"
            );
            assert_eq!(place, FilePlace::Line(5));
        }
        for x in ["nan", "inf", "-Infinity", "1e999"] {
            let (place, cause) = with(&format!("v 0 {x} 0"));
            assert!(matches!(cause, ReadCause::NonFinite { .. }), "{x}: {cause}");
            assert_eq!(place, FilePlace::Line(5));
        }
        assert!(matches!(
            with("v 0 0,5 0"),
            (FilePlace::Line(5), ReadCause::NotANumber { .. })
        ));
        assert!(matches!(
            with("v 0 0"),
            (
                FilePlace::Line(5),
                ReadCause::TooFewCoordinates { found: 2 }
            )
        ));
    }

    #[test]
    fn objects_count_their_vertices_together() {
        let triangle = PolygonSoup {
            positions: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            faces: vec![vec![0, 1, 2]],
        };
        let bytes = obj_of_objects(&[("A 1".into(), triangle.clone()), ("B".into(), triangle)]);
        assert!(bytes.starts_with(b"o A_1\n"));
        assert_eq!(parse(&bytes).unwrap().faces, [[0, 1, 2], [3, 4, 5]]);
    }

    #[test]
    fn text_that_is_no_mesh() {
        assert!(matches!(
            error("dear reader,\nthis is a letter"),
            (FilePlace::File, ReadCause::NoVertices)
        ));
    }
}
