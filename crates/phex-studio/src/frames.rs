//! What the page is told: frames of JSON with arrays behind it, one after the other.
//!
//! A frame is two lengths in bytes (`u32`, little-endian), the JSON, the arrays. In the JSON an
//! array stands as `{"$":[start, length]}`.

use axum::body::Bytes;
use phex_html::with_arrays;
use serde::Serialize;

/// A frame.
pub fn frame(value: &impl Serialize) -> Bytes {
    // What is sent are numbers, names and texts, which always become JSON.
    let (json, arrays) = with_arrays(value).unwrap_or_default();
    let mut bytes = Vec::with_capacity(8 + json.len() + arrays.len());
    bytes.extend((json.len() as u32).to_le_bytes());
    bytes.extend((arrays.len() as u32).to_le_bytes());
    bytes.extend(json);
    bytes.extend(arrays);
    bytes.into()
}
