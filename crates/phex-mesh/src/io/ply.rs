//! Stanford PLY: elements `vertex` (`x`, `y`, `z`) and `face` (`vertex_indices` or `vertex_index`),
//! of any numeric type; other elements and properties are skipped.
//!
//! `ply_rs_bw` reads header and elements. Before each element, the number that the header announces
//! is held against the bytes that remain, so that a short file can ask for no more than its own
//! length.

use super::error::{FilePlace, ReadCause, ReadError};
use super::text::{shown, vertex_number};
use crate::{PolygonSoup, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

/// Reads a whole file.
pub(super) fn parse(bytes: &[u8]) -> Result<PolygonSoup, ReadError> {
    if !bytes.starts_with(b"ply") {
        let start = bytes.split(|&b| b == b'\n').next().unwrap_or_default();
        return Err(ReadCause::WrongStart {
            format: "PLY",
            found: shown(String::from_utf8_lossy(start).trim()),
        }
        .into());
    }
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader);
    let header = header.map_err(|error| malformed(&error, true))?;
    let head = &bytes[..bytes.len() - reader.get_ref().len()];
    check_names(&header, head)?;
    read_elements(&mut reader, &header)
}

fn read_elements(reader: &mut Reader<&[u8]>, header: &Header) -> Result<PolygonSoup, ReadError> {
    let (mut positions, mut faces): (Option<Vec<_>>, Option<Vec<_>>) = (None, None);
    for element in header.elements.values() {
        check_announced(element, header, reader.get_ref().len())?;
        match element.name.as_str() {
            "vertex" => positions = Some(read_rows::<VertexRow>(reader, element, header)?),
            "face" => faces = Some(read_rows::<FaceRow>(reader, element, header)?),
            _ => drop(read_rows::<Skipped>(reader, element, header)?),
        }
        if positions.is_some() && faces.is_some() {
            break;
        }
    }
    soup(
        positions.ok_or(ReadCause::NoVertices)?,
        faces.ok_or(ReadCause::NoFaces)?,
    )
}

fn read_rows<E: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> Result<Vec<E>, ReadError> {
    let text = header.encoding == Encoding::Ascii;
    if element.properties.is_empty() && !text {
        return Ok(Vec::new());
    }
    Parser::new()
        .read_payload_for_element(reader, element, header)
        .map_err(|error| malformed(&error, text))
}

fn soup(positions: Vec<VertexRow>, faces: Vec<FaceRow>) -> Result<PolygonSoup, ReadError> {
    for (i, VertexRow(p)) in positions.iter().enumerate() {
        if let Some(x) = p.iter().find(|x| !x.is_finite()) {
            let token = x.to_string();
            return Err(ReadCause::NonFinite { token }.at(FilePlace::Vertex(i)));
        }
    }
    let vertices = positions.len();
    let faces = faces.iter().enumerate().map(|(i, FaceRow(corners))| {
        face(corners, vertices).map_err(|cause| cause.at(FilePlace::Face(i)))
    });
    Ok(PolygonSoup {
        faces: faces.collect::<Result<_, _>>()?,
        positions: positions.into_iter().map(|VertexRow(p)| p).collect(),
    })
}

fn face(corners: &[i64], vertices: usize) -> Result<Vec<u32>, ReadCause> {
    if corners.len() < 3 {
        let corners = corners.len();
        return Err(ReadCause::TooFewCorners { corners });
    }
    corners
        .iter()
        .map(|&v| vertex_number(v, vertices))
        .collect()
}

/// The library keeps one element or property of a name and forgets an earlier one, which would
/// shift all that follows.
fn check_names(header: &Header, head: &[u8]) -> Result<(), ReadError> {
    let lines = |word: &[u8]| {
        head.split(|&b| b == b'\n')
            .filter(|l| l.starts_with(word))
            .count()
    };
    let properties: usize = header.elements.values().map(|e| e.properties.len()).sum();
    if lines(b"element ") != header.elements.len() || lines(b"property ") != properties {
        return Err(ReadCause::Malformed("the header declares a name twice".into()).into());
    }
    let missing = |element: &str, names: &[&str]| {
        let declared = header.elements.get(element);
        declared.is_some_and(|e| !names.iter().any(|&n| e.properties.contains_key(n)))
    };
    for name in ["x", "y", "z"] {
        if missing("vertex", &[name]) {
            return Err(ReadCause::Malformed(format!("vertices have no property `{name}`")).into());
        }
    }
    if missing("face", &CORNER_NAMES) {
        return Err(ReadCause::Malformed("faces have no property `vertex_indices`".into()).into());
    }
    Ok(())
}

fn check_announced(
    element: &ElementDef,
    header: &Header,
    remaining: usize,
) -> Result<(), ReadError> {
    let (least, remaining) = match header.encoding {
        // A digit and a separator for each property; the last line may lack its end.
        Encoding::Ascii => (2 * element.properties.len().max(1), remaining + 1),
        _ => (least_bytes(element), remaining),
    };
    if least > 0 && element.count > remaining / least {
        return Err(ReadCause::Truncated {
            what: format!("elements `{}`", shown(&element.name)),
            announced: element.count as u64,
            found: (remaining / least) as u64,
        }
        .into());
    }
    Ok(())
}

/// Bytes of a binary element whose lists are all empty.
fn least_bytes(element: &ElementDef) -> usize {
    let of_property = |kind: &PropertyType| match kind {
        PropertyType::Scalar(scalar) | PropertyType::List(scalar, _) => bytes_of(scalar),
    };
    let properties = element.properties.values();
    properties.map(|p| of_property(&p.data_type)).sum()
}

fn bytes_of(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The library's message in one line; its line numbers mean something only where the file is text.
fn malformed(error: &ParseError, text: bool) -> ReadError {
    let message = error.to_string();
    let message = match error.line() {
        Some(line) => message.trim_start_matches(&format!("Line {line}: ")),
        None => &message,
    };
    let words: Vec<&str> = message.split_whitespace().collect();
    let message: String = words.join(" ").chars().take(200).collect();
    let place = error
        .line()
        .filter(|_| text)
        .map_or(FilePlace::File, FilePlace::Line);
    ReadCause::Malformed(message).at(place)
}

/// An element of no interest.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

struct VertexRow(Vec3);

impl PropertyAccess for VertexRow {
    fn new() -> Self {
        Self(Vec3::zeros())
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        let Some(x) = number(&value) else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0[axis] = x;
        PropertyAccessResult::Set
    }
}

const CORNER_NAMES: [&str; 2] = ["vertex_indices", "vertex_index"];

struct FaceRow(Vec<i64>);

impl PropertyAccess for FaceRow {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !CORNER_NAMES.contains(&name) {
            return PropertyAccessResult::Ignored;
        }
        let Some(corners) = whole_numbers(value) else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0 = corners;
        PropertyAccessResult::Set
    }
}

fn number(value: &Property) -> Option<f64> {
    match *value {
        Property::Char(x) => Some(x.into()),
        Property::UChar(x) => Some(x.into()),
        Property::Short(x) => Some(x.into()),
        Property::UShort(x) => Some(x.into()),
        Property::Int(x) => Some(x.into()),
        Property::UInt(x) => Some(x.into()),
        Property::Float(x) => Some(x.into()),
        Property::Double(x) => Some(x),
        _ => None,
    }
}

fn whole_numbers(value: Property) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(list: Vec<T>) -> Option<Vec<i64>> {
        Some(list.into_iter().map(Into::into).collect())
    }
    match value {
        Property::ListChar(list) => wide(list),
        Property::ListUChar(list) => wide(list),
        Property::ListShort(list) => wide(list),
        Property::ListUShort(list) => wide(list),
        Property::ListInt(list) => wide(list),
        Property::ListUInt(list) => wide(list),
        _ => None,
    }
}

/// The file of a mesh: binary little endian, 64-bit coordinates.
pub(super) fn encode(soup: &PolygonSoup) -> Vec<u8> {
    let short_lists = soup
        .faces
        .iter()
        .all(|face| face.len() <= usize::from(u8::MAX));
    let count_type = if short_lists { "uchar" } else { "uint" };
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty double y\n\
         property double z\nelement face {}\nproperty list {count_type} uint vertex_indices\nend_header\n",
        soup.positions.len(),
        soup.faces.len()
    )
    .into_bytes();
    for x in soup.positions.iter().flatten() {
        bytes.extend(x.to_le_bytes());
    }
    for face in &soup.faces {
        let count = (face.len() as u32).to_le_bytes();
        bytes.extend(&count[..if short_lists { 1 } else { 4 }]);
        bytes.extend(face.iter().flat_map(|v| v.to_le_bytes()));
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    const ASCII: &str = "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement camera 1\r\nproperty float fov\r\n\
        element vertex 4\r\nproperty uchar red\r\nproperty double x\r\nproperty int y\r\nproperty float z\r\n\
        element face 1\r\nproperty list uchar int vertex_index\r\nproperty float quality\r\nelement edge 9\r\n\
        property int a\r\nend_header\r\n1.5\r\n9 0.1 0 0\r\n9 1e0 0 0\r\n9 1 1 -0.5\r\n9 0 1 0\r\n4 0 1 2 3 0.25\r\n";

    fn cause(bytes: &[u8]) -> ReadCause {
        parse(bytes).unwrap_err().cause
    }

    /// The same square with float coordinates, a colour and a list before the corners, in either
    /// byte order.
    fn binary(big: bool, announced_faces: u32) -> Vec<u8> {
        let order = if big { "big" } else { "little" };
        let mut bytes = format!(
            "ply\nformat binary_{order}_endian 1.0\nelement vertex 4\nproperty float x\nproperty short y\n\
             property double z\nproperty uchar red\nelement face {announced_faces}\nproperty list ushort float uv\n\
             property list int ushort vertex_indices\nend_header\n"
        )
        .into_bytes();
        let mut push = |le: &[u8]| {
            let mut le = le.to_vec();
            if big {
                le.reverse();
            }
            bytes.extend(le);
        };
        for [x, y] in [[0.5f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
            push(&x.to_le_bytes());
            push(&(y as i16).to_le_bytes());
            push(&0.1f64.to_le_bytes());
            push(&[7]);
        }
        push(&1u16.to_le_bytes());
        push(&3.25f32.to_le_bytes());
        push(&4i32.to_le_bytes());
        (0..4u16).for_each(|v| push(&v.to_le_bytes()));
        bytes
    }

    #[test]
    fn ascii_and_both_byte_orders() {
        let soup = parse(ASCII.as_bytes()).unwrap();
        assert_eq!(soup.faces, vec![vec![0, 1, 2, 3]]);
        assert_eq!(soup.positions[0], Vec3::new(0.1, 0.0, 0.0));
        assert_eq!(soup.positions[2], Vec3::new(1.0, 1.0, -0.5));
        let little = parse(&binary(false, 1)).unwrap();
        assert_eq!(little, parse(&binary(true, 1)).unwrap());
        assert_eq!(little.faces, soup.faces);
        assert_eq!(little.positions[0], Vec3::new(0.5, 0.0, 0.1));
    }

    #[test]
    fn four_billion_announced_faces_are_not_believed() {
        for big in [false, true] {
            let cause = cause(&binary(big, u32::MAX));
            assert!(
                matches!(
                    cause,
                    ReadCause::Truncated {
                        announced: 4_294_967_295,
                        ..
                    }
                ),
                "{cause}"
            );
        }
        let ascii = ASCII.replace("element face 1", "element face 4294967295");
        assert!(matches!(
            cause(ascii.as_bytes()),
            ReadCause::Truncated { .. }
        ));
        let empty = b"ply\nformat binary_little_endian 1.0\nelement nothing 18446744073709551615\nend_header\n";
        assert!(matches!(cause(empty), ReadCause::NoVertices));
    }

    #[test]
    fn a_cut_file_is_an_error() {
        let whole = binary(false, 1);
        for end in 3..whole.len() {
            assert!(parse(&whole[..end]).is_err(), "{end} bytes");
        }
    }

    #[test]
    fn bad_elements_are_named() {
        let change = |from: &str, to: &str| parse(ASCII.replace(from, to).as_bytes()).unwrap_err();
        let error = change("4 0 1 2 3 0.25", "4 0 1 2 -3 0.25");
        assert!(matches!(error.cause, ReadCause::IndexOutOfRange { .. }));
        assert_eq!(error.place, FilePlace::Face(0));
        assert!(matches!(
            change("4 0 1 2 3", "4 0 1 2 4").cause,
            ReadCause::IndexOutOfRange { .. }
        ));
        assert!(matches!(
            change("4 0 1 2 3", "2 0 1").cause,
            ReadCause::TooFewCorners { corners: 2 }
        ));
        let error = change("9 1e0 0 0", "9 nan 0 0");
        assert_eq!(error.place, FilePlace::Line(19));
        assert!(
            error.to_string().contains("nan") && !error.to_string().contains('\n'),
            "{error}"
        );
        let error = change("9 1e0 0 0", "9 1e999 0 0");
        assert!(matches!(error.cause, ReadCause::NonFinite { .. }));
        assert_eq!(error.place, FilePlace::Vertex(1));
    }

    #[test]
    fn a_binary_nan_is_refused() {
        let mut bytes = binary(false, 1);
        let start = bytes.len() - 3 * 15 - (2 + 4 + 4 + 8);
        bytes[start..start + 4].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = parse(&bytes).unwrap_err();
        assert!(
            matches!(error.cause, ReadCause::NonFinite { .. }),
            "{error}"
        );
        assert_eq!(error.place, FilePlace::Vertex(1));
    }

    #[test]
    fn bad_headers_are_refused() {
        let change = |from: &str, to: &str| cause(ASCII.replace(from, to).as_bytes()).to_string();
        assert!(change("property int y", "property int x").contains("twice"));
        assert!(change("element camera", "element vertex").contains("twice"));
        assert!(change("property int y", "property int w").contains("`y`"));
        assert!(change("vertex_index", "vertices").contains("vertex_indices"));
        assert!(
            change(
                "list uchar int vertex_index",
                "list uchar float vertex_index"
            )
            .contains("unsupported")
        );
        assert!(matches!(
            cause(b"dear reader\n"),
            ReadCause::WrongStart { format: "PLY", .. }
        ));
    }
}
