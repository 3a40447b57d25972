//! Arrays as the viewer reads them: little-endian numbers, as base64 in the text of a page, or as
//! they are, behind the text that names their places.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use phex_mesh::Vec3;
use serde::{Serialize, Serializer};
use serde_json::ser::Formatter;
use std::io::{Result, Write};

/// Numbers of four bytes, little-endian.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PackedArray(Vec<u8>);

impl Serialize for PackedArray {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_bytes(&self.0)
    }
}

/// Numbers in single precision: the viewer draws and shows a few digits.
pub fn floats(values: impl IntoIterator<Item = f64>) -> PackedArray {
    let bytes = values.into_iter().flat_map(|v| (v as f32).to_le_bytes());
    PackedArray(bytes.collect())
}

/// Whole numbers.
pub fn numbers(values: impl IntoIterator<Item = u32>) -> PackedArray {
    PackedArray(values.into_iter().flat_map(u32::to_le_bytes).collect())
}

/// Points relative to `origin`, which keeps their digits far from the model's own origin.
pub fn points<'a>(points: impl IntoIterator<Item = &'a Vec3>, origin: Vec3) -> PackedArray {
    floats(points.into_iter().flat_map(|p| {
        let q = p - origin;
        [q.x, q.y, q.z]
    }))
}

/// Arrays stand in the text, as base64.
struct InText;

impl Formatter for InText {
    fn write_byte_array<W: ?Sized + Write>(&mut self, out: &mut W, bytes: &[u8]) -> Result<()> {
        write!(out, "\"{}\"", STANDARD.encode(bytes))
    }
}

/// Arrays stand behind the text, which says where.
#[derive(Default)]
struct Behind(Vec<u8>);

impl Formatter for &mut Behind {
    fn write_byte_array<W: ?Sized + Write>(&mut self, out: &mut W, bytes: &[u8]) -> Result<()> {
        write!(out, "{{\"$\":[{},{}]}}", self.0.len(), bytes.len())?;
        self.0.extend_from_slice(bytes);
        Ok(())
    }
}

/// A value as JSON in which arrays are base64.
///
/// # Errors
/// If the value has no place in JSON.
pub fn in_text(value: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut text = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(
        &mut text, InText,
    ))?;
    Ok(text)
}

/// A value as JSON, and its arrays one after the other: each stands in the JSON as
/// `{"$":[start, length]}`, in bytes.
///
/// # Errors
/// If the value has no place in JSON.
///
/// ```
/// let surface = phex_mesh::PolygonSoup::default();
/// let data = phex_html::MeshData::new(&surface, phex_mesh::Vec3::zeros());
/// let (json, arrays) = phex_html::with_arrays(&data)?;
/// assert!(json.starts_with(b"{\"positions\":{\"$\":[0,0]}"));
/// assert_eq!(arrays, [0; 4], "where the first face would begin");
/// # Ok::<(), serde_json::Error>(())
/// ```
pub fn with_arrays(value: &impl Serialize) -> serde_json::Result<(Vec<u8>, Vec<u8>)> {
    let (mut text, mut arrays) = (Vec::new(), Behind::default());
    value.serialize(&mut serde_json::Serializer::with_formatter(
        &mut text,
        &mut arrays,
    ))?;
    Ok((text, arrays.0))
}

#[cfg(test)]
impl PackedArray {
    /// The whole numbers.
    pub fn words(&self) -> Vec<u32> {
        let words = self.0.chunks_exact(4);
        words
            .map(|b| u32::from_le_bytes(b.try_into().unwrap()))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_in_the_text_and_behind_it_are_the_same_bytes() {
        let value = [numbers([7, 1 << 20]), floats([0.5])];
        let text = in_text(&value).unwrap();
        let parsed: [String; 2] = serde_json::from_slice(&text).unwrap();
        let (json, arrays) = with_arrays(&value).unwrap();
        assert_eq!(json, br#"[{"$":[0,8]},{"$":[8,4]}]"#);
        assert_eq!(STANDARD.decode(&parsed[0]).unwrap(), arrays[..8]);
        assert_eq!(STANDARD.decode(&parsed[1]).unwrap(), arrays[8..]);
        assert_eq!(value[0].words(), [7, 1 << 20]);
    }
}
