//! Stereolithography STL: triangles without shared vertices, in single precision.
//!
//! *Text or binary.* A file whose length is just that of the binary triangles it announces is
//! binary, whatever it starts with (many binary files start with `solid`). Any other file that
//! starts with `solid` and goes on with a `facet` or `endsolid` within its first kilobyte is text;
//! the rest is binary.
//!
//! *Welding.* Corners with equal coordinates become one vertex, then those whose coordinates all
//! agree within the larger of one unit in the last place of single precision at the largest
//! coordinate (`2^-23 max |x|`) and `1e-9` of the bounding box's diagonal: numbers of STL files are
//! rounded to the former. Vertices are numbered in the order of their first corner.
//!
//! `stl_io` reads and writes binary files. Text is read here: the library drops all but the first
//! solid, wants a space after `solid`, rounds to single precision and names no line.

use super::error::{FilePlace, ReadCause, ReadError, WriteCause};
use super::text::{decode, numbered_lines, point, shown};
use super::triangles::{of_face, single};
use super::weld::weld;
use crate::{LARGEST_COORDINATE, PolygonSoup, Vec3, bounds};
use std::io::Cursor;
use stl_io::{Triangle, Vector};

const HEADER_BYTES: usize = 80;
const START_BYTES: usize = HEADER_BYTES + 4;
const TRIANGLE_BYTES: usize = 50;

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<PolygonSoup, ReadError> {
    let (corners, faces) = if is_text(bytes) {
        parse_text(&decode(bytes))?
    } else {
        parse_binary(bytes)?
    };
    if corners.len() >= u32::MAX as usize {
        return Err(ReadCause::TooManyVertices.into());
    }
    let (positions, vertex_of) = weld(&corners, tolerance(&corners));
    let mut vertex_of = vertex_of.into_iter();
    let faces = faces
        .iter()
        .map(|&n| vertex_of.by_ref().take(n).collect())
        .collect();
    Ok(PolygonSoup { positions, faces })
}

/// Corners, and the number of corners of each face.
type StlCorners = (Vec<Vec3>, Vec<usize>);

fn is_text(bytes: &[u8]) -> bool {
    let solid = bytes
        .trim_ascii_start()
        .get(..5)
        .is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
    let start = bytes[..bytes.len().min(1024)].to_ascii_lowercase();
    let has = |word: &[u8]| start.windows(word.len()).any(|w| w == word);
    let binary_length = announced(bytes).map(|n| START_BYTES as u64 + n * TRIANGLE_BYTES as u64);
    solid && binary_length != Some(bytes.len() as u64) && (has(b"facet") || has(b"endsolid"))
}

fn announced(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER_BYTES..START_BYTES)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

fn parse_binary(bytes: &[u8]) -> Result<StlCorners, ReadError> {
    let Some(announced) = announced(bytes) else {
        let found = shown(String::from_utf8_lossy(bytes).trim());
        return Err(ReadCause::WrongStart {
            format: "STL",
            found,
        }
        .into());
    };
    let room = ((bytes.len() - START_BYTES) / TRIANGLE_BYTES) as u64;
    if announced > room {
        let what = "triangles".into();
        return Err(ReadCause::Truncated {
            what,
            announced,
            found: room,
        }
        .into());
    }
    // Fewer bytes than a triangle has are padding.
    if announced < room {
        let what = "triangles".into();
        return Err(ReadCause::Surplus {
            what,
            announced,
            found: room,
        }
        .into());
    }
    let mut bytes = bytes.to_vec();
    // The library takes all that starts with `solid ` for text.
    bytes[..HEADER_BYTES].fill(0);
    let mut cursor = Cursor::new(bytes);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(ReadCause::from)?;
    let mut corners = Vec::new();
    for (i, triangle) in triangles.enumerate() {
        for corner in triangle.map_err(ReadCause::from)?.vertices {
            corners.push(finite(corner).map_err(|cause| cause.at(FilePlace::Face(i)))?);
        }
    }
    let faces = vec![3; corners.len() / 3];
    Ok((corners, faces))
}

fn finite(corner: Vector<f32>) -> Result<Vec3, ReadCause> {
    match corner.0.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(ReadCause::NonFinite {
            token: x.to_string(),
        }),
        None => Ok(Vec3::from(corner.0.map(f64::from))),
    }
}

fn parse_text(text: &str) -> Result<StlCorners, ReadError> {
    let (mut corners, mut faces) = (Vec::new(), Vec::new());
    // Number of corners at the start of the facet that is open.
    let mut facet: Option<usize> = None;
    let mut solid_open = false;
    for (number, line) in numbered_lines(text) {
        let place = FilePlace::Line(number);
        let mut tokens = line.split_whitespace();
        match (
            tokens
                .next()
                .unwrap_or_default()
                .to_ascii_lowercase()
                .as_str(),
            facet,
        ) {
            ("solid", None) => solid_open = true,
            ("endsolid", None) => solid_open = false,
            ("facet", None) if solid_open => facet = Some(corners.len()),
            ("vertex", Some(_)) => {
                let corner = weldable(point(tokens, place)?);
                corners.push(corner.map_err(|cause| cause.at(place))?);
            }
            ("outer" | "endloop", Some(_)) => (),
            ("endfacet", Some(start)) => {
                faces.push(corner_count(corners.len() - start).map_err(|cause| cause.at(place))?);
                facet = None;
            }
            _ => return Err(unexpected(line).at(place)),
        }
    }
    if solid_open || facet.is_some() {
        return Err(ReadCause::Malformed("the file ends before `endsolid`".into()).into());
    }
    Ok((corners, faces))
}

/// A corner that can be welded: differences of coordinates must not overflow.
fn weldable(corner: Vec3) -> Result<Vec3, ReadCause> {
    let coordinate = corner.amax();
    match coordinate <= LARGEST_COORDINATE {
        true => Ok(corner),
        false => Err(ReadCause::TooLarge { coordinate }),
    }
}

fn corner_count(corners: usize) -> Result<usize, ReadCause> {
    if corners < 3 {
        return Err(ReadCause::TooFewCorners { corners });
    }
    Ok(corners)
}

fn unexpected(line: &str) -> ReadCause {
    ReadCause::Malformed(format!("`{}` is out of place", shown(line)))
}

fn tolerance(corners: &[Vec3]) -> f64 {
    if corners.is_empty() {
        return 0.0;
    }
    let [low, high] = bounds(corners);
    let largest = low.amax().max(high.amax());
    (1e-9 * (high - low).norm()).max(largest * f64::from(f32::EPSILON))
}

/// Rounding over the diagonal that a model bears: far below what panels may be off.
const BORNE: f64 = 1e-5;

/// Refuses positions that single precision would ruin, being far from the origin.
///
/// # Errors
/// With the rounding.
pub fn fits_stl(positions: &[Vec3]) -> Result<(), WriteCause> {
    let [low, high] = bounds(positions);
    // What is too large altogether is told by its vertex.
    let single = |x: &f64| f64::from(*x as f32);
    let rounded = positions.iter().flatten().map(|x| (x - single(x)).abs());
    let rounding = rounded.filter(|r| r.is_finite()).fold(0.0, f64::max);
    match rounding > BORNE * (high - low).norm() && rounding > f64::from(f32::MIN_POSITIVE) {
        false => Ok(()),
        true => Err(WriteCause::TooFar {
            largest: low.amax().max(high.amax()),
            rounding,
        }),
    }
}

/// The file of a mesh: binary, faces cut into triangles.
pub(super) fn encode(soup: &PolygonSoup) -> Result<Vec<u8>, WriteCause> {
    fits_stl(&soup.positions)?;
    let mut triangles = Vec::with_capacity(soup.faces.len());
    for face in 0..soup.faces.len() {
        for triangle in of_face(soup, face)? {
            let mut vertices = [Vector::new([0.0; 3]); 3];
            for (slot, &v) in vertices.iter_mut().zip(&triangle) {
                *slot = Vector::new(single(soup, v, Vec3::zeros())?);
            }
            triangles.push(Triangle {
                normal: normal(triangle.map(|v| soup.positions[v as usize])),
                vertices,
            });
        }
    }
    if u32::try_from(triangles.len()).is_err() {
        return Err(WriteCause::TooManyTriangles {
            triangles: triangles.len(),
        });
    }
    let mut bytes = Vec::with_capacity(START_BYTES + TRIANGLE_BYTES * triangles.len());
    stl_io::write_stl(&mut bytes, triangles.iter())?;
    Ok(bytes)
}

/// Unit normal, zero where there is none (readers then use the corners).
fn normal([a, b, c]: [Vec3; 3]) -> Vector<f32> {
    let normal = (b - a)
        .cross(&(c - a))
        .try_normalize(0.0)
        .unwrap_or_default();
    Vector::new([normal.x as f32, normal.y as f32, normal.z as f32])
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "solid two words\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n\
        vertex 1 1 0\n  endloop\n endfacet\nendsolid two words\nSOLID\n FACET NORMAL 0 0 1\n  OUTER LOOP\n\
        VERTEX 0 0 0\n   VERTEX 1 1 0\n   VERTEX 0 1 0.1\n  ENDLOOP\n ENDFACET\nENDSOLID\n";

    fn cube_corner() -> PolygonSoup {
        PolygonSoup {
            positions: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
            faces: vec![vec![0, 2, 1], vec![0, 1, 3], vec![1, 2, 3], vec![2, 0, 3]],
        }
    }

    #[test]
    fn text_with_two_solids_is_welded() {
        let soup = parse(TEXT.as_bytes()).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(soup.positions[3], Vec3::new(0.0, 1.0, 0.1));
    }

    #[test]
    fn what_far_coordinates_would_ruin_is_refused() {
        let at = |distance: f64| {
            let mut corner = cube_corner();
            corner
                .positions
                .iter_mut()
                .for_each(|p| *p = *p * 0.3 + Vec3::repeat(distance));
            encode(&corner).map(|_| ())
        };
        assert!(at(0.0).is_ok() && at(10.0).is_ok());
        let told = at(5_200_000.0).unwrap_err().to_string();
        assert!(
            told.contains("5200000") && told.contains("move the model"),
            "{told}"
        );
    }

    #[test]
    fn binary_that_starts_with_solid() {
        let mut bytes = encode(&cube_corner()).unwrap();
        bytes[..13].copy_from_slice(b"solid facet x");
        let soup = parse(&bytes).unwrap();
        assert_eq!(soup.faces, [[0, 1, 2], [0, 2, 3], [2, 1, 3], [1, 0, 3]]);
        bytes[..13].copy_from_slice(b"solid       x");
        bytes.extend(b"trailing bytes");
        assert_eq!(parse(&bytes).unwrap(), soup);
    }

    #[test]
    fn a_concave_polygon_is_not_cut_as_a_fan() {
        let dart = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]];
        let positions = dart.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        for start in 0..4u32 {
            let face = (0..4).map(|i| (start + i) % 4).collect();
            let soup = PolygonSoup {
                positions: positions.clone(),
                faces: vec![face],
            };
            let read = parse(&encode(&soup).unwrap()).unwrap();
            let areas = read.faces.iter().map(|f| {
                let [a, b, c] = [0, 1, 2].map(|i| read.positions[f[i] as usize]);
                0.5 * (b - a).cross(&(c - a)).z
            });
            let areas: Vec<f64> = areas.collect();
            assert!(
                areas.iter().all(|&a| a > 0.0) && (areas.iter().sum::<f64>() - 4.0).abs() < 1e-6,
                "{areas:?}"
            );
        }
    }

    #[test]
    fn announced_sizes_are_not_believed() {
        let mut bytes = encode(&cube_corner()).unwrap();
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        for header in [b"solid", b"\0\0\0\0\0"] {
            bytes[..5].copy_from_slice(header);
            let cause = parse(&bytes).unwrap_err().cause;
            assert!(
                matches!(
                    cause,
                    ReadCause::Truncated {
                        announced: 4_294_967_295,
                        found: 4,
                        ..
                    }
                ),
                "{cause}"
            );
        }
    }

    #[test]
    fn triangles_beyond_the_announced_ones_are_refused() {
        let mut bytes = encode(&cube_corner()).unwrap();
        for announced in [0u8, 3] {
            bytes[80] = announced;
            let told = parse(&bytes).unwrap_err().to_string();
            let expected = format!("{announced} triangles are announced, but the file holds 4");
            assert!(told.starts_with(&expected), "{told}");
        }
    }

    #[test]
    fn bad_text_is_named() {
        let change =
            |from: &str, to: &str| parse(TEXT.replacen(from, to, 1).as_bytes()).unwrap_err();
        let error = change("vertex 1 0 0", "vertex 1 nan 0");
        assert!(matches!(error.cause, ReadCause::NonFinite { .. }));
        assert_eq!(error.place, FilePlace::Line(5));
        assert!(matches!(
            change("vertex 1 0 0\n", "\n").cause,
            ReadCause::TooFewCorners { corners: 2 }
        ));
        assert!(
            change("endfacet", "")
                .to_string()
                .contains("line 9: `endsolid two words` is out of place")
        );
        let cut = TEXT.len() - "ENDSOLID\n".len();
        assert!(
            parse(&TEXT.as_bytes()[..cut])
                .unwrap_err()
                .to_string()
                .contains("endsolid")
        );
        let letter = parse(b"dear reader").unwrap_err().cause;
        assert!(matches!(
            letter,
            ReadCause::WrongStart { format: "STL", .. }
        ));
    }

    #[test]
    fn binary_nan_and_too_large_coordinates() {
        let mut bytes = encode(&cube_corner()).unwrap();
        let second = START_BYTES + TRIANGLE_BYTES + 12;
        bytes[second..second + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
        let error = parse(&bytes).unwrap_err();
        assert!(matches!(error.cause, ReadCause::NonFinite { .. }));
        assert_eq!(error.place, FilePlace::Face(1));
        let mut soup = cube_corner();
        soup.positions[3].z = 1e39;
        assert!(matches!(
            encode(&soup),
            Err(WriteCause::TooLarge { vertex: 3 })
        ));
    }

    #[test]
    fn rounding_differences_are_welded() {
        let mut soup = cube_corner();
        soup.positions
            .iter_mut()
            .for_each(|p| *p += Vec3::new(100.0, 0.0, 0.0));
        let mut bytes = encode(&soup).unwrap();
        let x = START_BYTES + TRIANGLE_BYTES + 12;
        bytes[x..x + 4].copy_from_slice(&100.0f32.next_up().to_le_bytes());
        assert_eq!(parse(&bytes).unwrap().positions.len(), 4);
    }
}
