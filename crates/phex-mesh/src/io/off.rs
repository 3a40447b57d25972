//! Geomview OFF: counts, vertices, faces. Normals and colours (`COFF`, `NOFF`, `STOFF` and their
//! combinations, colours after a face) are skipped; vertices of four or n coordinates and binary
//! files are refused.

use super::error::{FilePlace, ReadCause, ReadError};
use super::text::{count, decode, integer, numbered_lines, point, shown, vertex_number};
use crate::{PolygonSoup, Vec3};
use std::fmt::Write;

/// Shortest lines of a vertex and a face: they bound what a file of given length can hold.
const SHORTEST_VERTEX: usize = "0 0 0\n".len();
const SHORTEST_FACE: usize = "3 0 0 0\n".len();

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<PolygonSoup, ReadError> {
    let text = decode(bytes);
    let mut lines = numbered_lines(&text);
    let (vertices, faces) = counts(&mut lines)?;
    if vertices >= u32::MAX as usize {
        return Err(ReadCause::TooManyVertices.into());
    }
    let mut soup = PolygonSoup {
        positions: Vec::with_capacity(vertices.min(bytes.len() / SHORTEST_VERTEX)),
        faces: Vec::with_capacity(faces.min(bytes.len() / SHORTEST_FACE)),
    };
    for found in 0..vertices {
        let (line, text) = lines
            .next()
            .ok_or_else(|| truncated("vertices", vertices, found))?;
        let position: Vec3 = point(text.split_whitespace(), FilePlace::Line(line))?;
        soup.positions.push(position);
    }
    for found in 0..faces {
        let (line, text) = lines
            .next()
            .ok_or_else(|| truncated("faces", faces, found))?;
        let corners = face(text, vertices).map_err(|cause| cause.at(FilePlace::Line(line)))?;
        soup.faces.push(corners);
    }
    let further = lines.filter(|(_, text)| face(text, vertices).is_ok());
    match further.count() {
        0 => Ok(soup),
        further => Err(ReadCause::Surplus {
            what: "faces".into(),
            announced: faces as u64,
            found: (faces + further) as u64,
        }
        .into()),
    }
}

/// Numbers of vertices and faces, on the header's line or the next one.
fn counts<'a>(
    lines: &mut impl Iterator<Item = (usize, &'a str)>,
) -> Result<(usize, usize), ReadError> {
    let (mut number, mut line) = lines.next().ok_or(ReadCause::Empty)?;
    let rest = after_keyword(line).map_err(|cause| cause.at(FilePlace::Line(number)))?;
    if rest.is_empty() {
        (number, line) = lines.next().ok_or(ReadCause::NoVertices)?;
    } else {
        line = rest;
    }
    let counts: Result<Vec<usize>, ReadCause> =
        line.split_whitespace().take(2).map(count).collect();
    match counts.map_err(|cause| cause.at(FilePlace::Line(number)))?[..] {
        [vertices, faces] => Ok((vertices, faces)),
        _ => Err(
            ReadCause::Malformed("the numbers of vertices and faces are missing".into())
                .at(FilePlace::Line(number)),
        ),
    }
}

/// What follows the keyword in the first line; the keyword may be missing where the counts stand
/// there.
fn after_keyword(line: &str) -> Result<&str, ReadCause> {
    let (first, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let Some(kind) = first.strip_suffix("OFF") else {
        let starts_with_count = first.bytes().all(|b| b.is_ascii_digit());
        return starts_with_count
            .then_some(line)
            .ok_or_else(|| ReadCause::WrongStart {
                format: "OFF",
                found: shown(line),
            });
    };
    if !kind.bytes().all(|b| b"STCN".contains(&b)) {
        return Err(ReadCause::Unsupported(format!(
            "the header `{}`",
            shown(first)
        )));
    }
    if rest.trim_start().starts_with("BINARY") {
        return Err(ReadCause::Unsupported("binary OFF".into()));
    }
    Ok(rest.trim())
}

fn face(line: &str, vertices: usize) -> Result<Vec<u32>, ReadCause> {
    let mut tokens = line.split_whitespace();
    let corners = count(tokens.next().unwrap_or_default())?;
    if corners < 3 {
        return Err(ReadCause::TooFewCorners { corners });
    }
    let numbers = tokens
        .take(corners)
        .map(|t| vertex_number(integer(t)?, vertices));
    let numbers: Vec<u32> = numbers.collect::<Result<_, _>>()?;
    if numbers.len() < corners {
        return Err(truncated("corners", corners, numbers.len()));
    }
    Ok(numbers)
}

fn truncated(what: &str, announced: usize, found: usize) -> ReadCause {
    ReadCause::Truncated {
        what: what.into(),
        announced: announced as u64,
        found: found as u64,
    }
}

/// The file of a mesh.
pub(super) fn encode(soup: &PolygonSoup) -> Vec<u8> {
    let mut text = format!("OFF\n{} {} 0\n", soup.positions.len(), soup.faces.len());
    for p in &soup.positions {
        let _ = writeln!(text, "{:?} {:?} {:?}", p.x, p.y, p.z);
    }
    for face in &soup.faces {
        let _ = write!(text, "{}", face.len());
        for v in face {
            let _ = write!(text, " {v}");
        }
        text.push('\n');
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> (FilePlace, ReadCause) {
        let error = parse(text.as_bytes()).unwrap_err();
        (error.place, error.cause)
    }

    const POINTS: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";

    #[test]
    fn header_forms() {
        for head in [
            "OFF\n4 1 0\n",
            "OFF 4 1 0\n",
            "# made by hand\n\nOFF # quad\n4 1\n",
            "4 1 4\n",
            "\u{feff}OFF\r\n4 1 0\r\n",
        ] {
            let soup = parse(format!("{head}{POINTS}4 0 1 2 3 255 0 0\n").as_bytes()).unwrap();
            assert_eq!(
                (soup.positions.len(), soup.faces),
                (4, vec![vec![0, 1, 2, 3]]),
                "{head}"
            );
        }
        let coloured =
            "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 255 0 0 255\n0 1 0 255 0 0 255\n3 0 1 2\n";
        assert_eq!(parse(coloured.as_bytes()).unwrap().positions[2], Vec3::y());
    }

    #[test]
    fn other_headers_are_refused() {
        assert!(matches!(
            error("4OFF\n1 1 1\n"),
            (FilePlace::Line(1), ReadCause::Unsupported(_))
        ));
        assert!(matches!(
            error("OFF BINARY\n\0\0"),
            (FilePlace::Line(1), ReadCause::Unsupported(_))
        ));
        assert!(matches!(
            error("dear reader\n"),
            (FilePlace::Line(1), ReadCause::WrongStart { .. })
        ));
        assert!(matches!(
            error("OFF\n8\n"),
            (FilePlace::Line(2), ReadCause::Malformed(_))
        ));
    }

    #[test]
    fn bad_lines_are_named() {
        let with = |face: &str| error(&format!("OFF\n4 1 0\n{POINTS}{face}"));
        for index in ["4", "-1", "4294967296", "99999999999999999999"] {
            let (place, cause) = with(&format!("3 0 1 {index}\n"));
            assert!(
                matches!(
                    cause,
                    ReadCause::IndexOutOfRange {
                        vertices: 4,
                        first: 0,
                        ..
                    }
                ),
                "{index}: {cause}"
            );
            assert_eq!(place, FilePlace::Line(7));
        }
        assert!(matches!(
            with("2 0 1\n"),
            (FilePlace::Line(7), ReadCause::TooFewCorners { corners: 2 })
        ));
        assert!(matches!(
            with("4 0 1 2\n"),
            (
                FilePlace::Line(7),
                ReadCause::Truncated {
                    announced: 4,
                    found: 3,
                    ..
                }
            )
        ));
        assert!(matches!(
            with(""),
            (
                FilePlace::File,
                ReadCause::Truncated {
                    announced: 1,
                    found: 0,
                    ..
                }
            )
        ));
        assert!(matches!(
            error("OFF\n1 0 0\n0 nan 0\n"),
            (FilePlace::Line(3), ReadCause::NonFinite { .. })
        ));
    }

    #[test]
    fn faces_beyond_the_announced_ones_are_refused() {
        let text = |faces| format!("OFF\n4 {faces} 0\n{POINTS}3 0 1 2\n3 0 2 3 255 0 0\n# end\n");
        assert_eq!(parse(text(2).as_bytes()).unwrap().faces.len(), 2);
        for announced in [0, 1] {
            let told = error(&text(announced)).1.to_string();
            let expected = format!("{announced} faces are announced, but the file holds 2");
            assert!(told.starts_with(&expected), "{told}");
        }
    }

    #[test]
    fn announced_sizes_are_not_believed() {
        let (_, cause) = error("OFF\n4000000000 4000000000 0\n0 0 0\n");
        assert!(matches!(
            cause,
            ReadCause::Truncated {
                announced: 4_000_000_000,
                found: 1,
                ..
            }
        ));
        let (_, cause) = error("OFF\n99999999999999999999 1 0\n0 0 0\n");
        assert!(matches!(cause, ReadCause::TooManyVertices));
        let (_, cause) = error(&format!("OFF\n4 1 0\n{POINTS}4000000000 0 1 2\n"));
        assert!(matches!(
            cause,
            ReadCause::Truncated {
                announced: 4_000_000_000,
                found: 3,
                ..
            }
        ));
    }
}
