//! Binary glTF 2.0 (`.glb`): faces as ear-clipped triangles with flat shading and a colour by their
//! number of corners, and their real edges as lines.
//!
//! Coordinates are single precision, relative to the centre of the bounding box, which the node's
//! translation adds again, so that a building far from the origin keeps its millimetres. glTF has y
//! up: the node turns z up to y up, as the specification asks; readers that apply node transforms
//! get `(x, z, -y)`.

use super::error::WriteCause;
use super::triangles::{of_face, single};
use crate::polygon::sides;
use crate::{FlatFace, PolygonSoup, Vec3};
use serde_json::{Value, json};
use std::collections::HashSet;

/// Component types and targets of the specification.
const UNSIGNED_BYTE: u32 = 5121;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// Linear colours of faces with 4, 5, 6, 7 and any other number of corners.
const COLOURS: [[u8; 4]; 5] = [
    [196, 160, 60, 255],
    [60, 130, 190, 255],
    [200, 205, 210, 255],
    [190, 90, 60, 255],
    [120, 70, 140, 255],
];

/// Bytes with the views and accessors that say what they are.
#[derive(Default)]
struct Blob {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Blob {
    /// Adds an accessor with a view of its own; its number.
    fn push(&mut self, bytes: &[u8], target: u32, mut accessor: Value) -> usize {
        self.views.push(json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len(), "target": target,
        }));
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        accessor["bufferView"] = json!(self.views.len() - 1);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    fn vectors(&mut self, vectors: &[[f32; 3]]) -> usize {
        let bound = |pick: fn(f32, f32) -> f32, start: f32| {
            let fold = |b: [f32; 3], p: &[f32; 3]| [0, 1, 2].map(|k| pick(b[k], p[k]));
            vectors.iter().fold([start; 3], fold)
        };
        let bytes: Vec<u8> = vectors
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let accessor = json!({
            "componentType": FLOAT, "count": vectors.len(), "type": "VEC3",
            "min": bound(f32::min, f32::INFINITY), "max": bound(f32::max, f32::NEG_INFINITY),
        });
        self.push(&bytes, ARRAY_BUFFER, accessor)
    }

    fn colours(&mut self, colours: &[[u8; 4]]) -> usize {
        let accessor = json!({
            "componentType": UNSIGNED_BYTE, "normalized": true, "count": colours.len(), "type": "VEC4",
        });
        self.push(&colours.concat(), ARRAY_BUFFER, accessor)
    }

    fn indices(&mut self, indices: &[u32]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let accessor =
            json!({ "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR" });
        self.push(&bytes, ELEMENT_ARRAY_BUFFER, accessor)
    }
}

/// The file of a mesh.
pub(super) fn encode(soup: &PolygonSoup) -> Result<Vec<u8>, WriteCause> {
    let centre = centre(soup);
    let mut blob = Blob::default();
    let panels = panels(soup, centre, &mut blob)?;
    let edges = edges(soup, centre, &mut blob)?;
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turned = [centre.x, centre.z, -centre.y];
    let material = |name: &str, colour: [f64; 4]| {
        json!({
            "name": name, "doubleSided": true,
            "pbrMetallicRoughness": { "baseColorFactor": colour, "metallicFactor": 0.0, "roughnessFactor": 0.9 },
        })
    };
    let document = json!({
        "asset": { "version": "2.0", "generator": concat!("phex ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "rotation": [-half, 0.0, 0.0, half], "translation": turned }],
        "meshes": [{ "name": "panels", "primitives": [panels, edges] }],
        "materials": [material("panels", [1.0; 4]), material("edges", [0.02, 0.02, 0.02, 1.0])],
        "buffers": [{ "byteLength": blob.bytes.len() }],
        "bufferViews": blob.views,
        "accessors": blob.accessors,
    });
    Ok(container(&document.to_string(), &blob.bytes))
}

fn centre(soup: &PolygonSoup) -> Vec3 {
    let bound =
        |pick: fn(&Vec3, &Vec3) -> Vec3| soup.positions.iter().copied().reduce(|a, b| pick(&a, &b));
    let corner = |p: Option<Vec3>| p.unwrap_or_default();
    (corner(bound(Vec3::inf)) + corner(bound(Vec3::sup))) * 0.5
}

/// The triangles; every face has vertices of its own, so that it is shaded flat.
fn panels(soup: &PolygonSoup, centre: Vec3, blob: &mut Blob) -> Result<Value, WriteCause> {
    let (mut points, mut normals, mut colours) = (Vec::new(), Vec::new(), Vec::new());
    let mut indices: Vec<u32> = Vec::new();
    for (k, corners) in soup.faces.iter().enumerate() {
        let first = points.len() as u32;
        let space: Vec<Vec3> = corners
            .iter()
            .map(|&v| soup.positions[v as usize])
            .collect();
        let normal = FlatFace::new(&space).normal();
        let place = |v: u32| corners.iter().position(|&c| c == v).unwrap_or(0) as u32 + first;
        indices.extend(of_face(soup, k)?.into_iter().flatten().map(place));
        for &v in corners {
            points.push(single(soup, v, centre)?);
            normals.push([normal.x as f32, normal.y as f32, normal.z as f32]);
            colours.push(COLOURS[corners.len().wrapping_sub(4).min(4)]);
        }
    }
    Ok(json!({
        "mode": 4, "material": 0,
        "attributes": {
            "POSITION": blob.vectors(&points), "NORMAL": blob.vectors(&normals), "COLOR_0": blob.colours(&colours),
        },
        "indices": blob.indices(&indices),
    }))
}

/// Every edge once.
fn edges(soup: &PolygonSoup, centre: Vec3, blob: &mut Blob) -> Result<Value, WriteCause> {
    let vertices = 0..soup.positions.len() as u32;
    let points: Result<Vec<_>, _> = vertices.map(|v| single(soup, v, centre)).collect();
    let mut seen = HashSet::new();
    let mut indices = Vec::new();
    for face in &soup.faces {
        for [a, b] in sides(face) {
            if seen.insert((a.min(b), a.max(b))) {
                indices.extend([a, b]);
            }
        }
    }
    Ok(json!({
        "mode": 1, "material": 1,
        "attributes": { "POSITION": blob.vectors(&points?) },
        "indices": blob.indices(&indices),
    }))
}

/// Header, JSON chunk, binary chunk.
fn container(json: &str, binary: &[u8]) -> Vec<u8> {
    let mut text = json.as_bytes().to_vec();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    let total = 12 + 8 + text.len() + 8 + binary.len();
    for word in [2, total as u32, text.len() as u32] {
        out.extend(word.to_le_bytes());
    }
    out.extend(b"JSON");
    out.extend(&text);
    out.extend((binary.len() as u32).to_le_bytes());
    out.extend(b"BIN\0");
    out.extend(binary);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_are_as_long_as_they_say_and_far_coordinates_keep_their_digits() {
        let far = Vec3::new(1e7, -2e7, 30.0);
        let soup = PolygonSoup {
            positions: [
                Vec3::zeros(),
                Vec3::x(),
                Vec3::new(1.0, 1.0, 0.0),
                Vec3::y(),
            ]
            .map(|p| p * 0.1 + far)
            .to_vec(),
            faces: vec![vec![0, 1, 2, 3]],
        };
        let bytes = encode(&soup).unwrap();
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((word(4), word(8)), (2, bytes.len()));
        let document: Value = serde_json::from_slice(&bytes[20..20 + word(12)]).unwrap();
        let close = |value: &Value, x: f64| (value.as_f64().unwrap() - x).abs() < 1e-8;
        assert!(close(&document["accessors"][0]["max"][0], 0.05));
        assert!(close(&document["nodes"][0]["translation"][2], 2e7 - 0.05));
        assert_eq!(document["accessors"][3]["count"], 6, "two triangles");
        assert_eq!(document["accessors"][5]["count"], 8, "four edges");
    }
}
