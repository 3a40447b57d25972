//! COMPAS JSON: `compas.datastructures/Mesh` as `compas.json_load` reads it; faces stay whole.
//!
//! Each face carries attributes (`facedata`). For a plain mesh they are `id` (the face's number
//! from 0), `corners`, `area` and `planarity` (largest distance of a corner to the face's
//! least-squares plane), in model units. Vertices and faces keep their numbers, coordinates every
//! bit.

use crate::{FlatFace, PolygonSoup, Vec3};
use serde_json::{Map, Value, json};

/// Named values of one face.
pub type FaceAttributes = Map<String, Value>;

/// The file of a mesh whose faces carry the given attributes; `faces` beyond the list carry none.
pub fn compas_json(soup: &PolygonSoup, attributes: &[FaceAttributes]) -> Vec<u8> {
    let vertex = |p: &Vec3| json!({ "x": p.x, "y": p.y, "z": p.z });
    let vertices = numbered(soup.positions.iter().map(vertex));
    let faces = numbered(soup.faces.iter().map(|f| json!(f)));
    let data = numbered(attributes.iter().map(|a| Value::Object(a.clone())));
    let (max_vertex, max_face) = (last(soup.positions.len()), last(soup.faces.len()));
    format!(
        r#"{{"dtype":"compas.datastructures/Mesh","data":{{"attributes":{{}},
"default_vertex_attributes":{{"x":0.0,"y":0.0,"z":0.0}},"default_edge_attributes":{{}},"default_face_attributes":{{}},
"vertex":{vertices},
"face":{faces},
"facedata":{data},
"edgedata":{{}},"max_vertex":{max_vertex},"max_face":{max_face}}}}}
"#
    )
    .into_bytes()
}

/// COMPAS keeps the largest number in use, -1 where there is none.
fn last(count: usize) -> i64 {
    count as i64 - 1
}

/// An object with the numbers as keys, in their order (which readers keep).
fn numbered(values: impl Iterator<Item = Value>) -> String {
    let pairs: Vec<String> = values
        .enumerate()
        .map(|(k, value)| format!("\"{k}\":{value}"))
        .collect();
    format!("{{{}}}", pairs.join(","))
}

/// The file of a plain mesh.
pub(super) fn encode(soup: &PolygonSoup) -> Vec<u8> {
    let measured = |(k, face): (usize, &Vec<u32>)| {
        let corners: Vec<Vec3> = face.iter().map(|&v| soup.positions[v as usize]).collect();
        let flat = FlatFace::new(&corners);
        let value = json!({
            "id": k,
            "corners": corners.len(),
            "area": flat.area(),
            "planarity": flat.planarity_length,
        });
        value.as_object().cloned().unwrap_or_default()
    };
    let attributes: Vec<FaceAttributes> = soup.faces.iter().enumerate().map(measured).collect();
    compas_json(soup, &attributes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_faces_and_attributes_are_numbered_alike() {
        let soup = PolygonSoup {
            positions: vec![
                Vec3::zeros(),
                Vec3::x() * 2.0,
                Vec3::new(2.0, 0.1, 0.0),
                Vec3::y(),
            ],
            faces: vec![vec![0, 1, 3], vec![1, 2, 3]],
        };
        let read: Value = serde_json::from_slice(&encode(&soup)).unwrap();
        let data = &read["data"];
        assert_eq!(read["dtype"], "compas.datastructures/Mesh");
        assert_eq!(data["vertex"]["2"]["y"].as_f64(), Some(0.1));
        assert_eq!(data["face"]["1"], json!([1, 2, 3]));
        assert_eq!(data["facedata"]["1"]["id"], 1);
        let area = data["facedata"]["0"]["area"].as_f64().unwrap();
        assert!((area - 1.0).abs() < 1e-15);
        assert_eq!(
            (&data["max_vertex"], &data["max_face"]),
            (&json!(3), &json!(1))
        );
    }
}
