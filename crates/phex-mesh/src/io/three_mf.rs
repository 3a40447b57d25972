//! 3MF: triangles with shared vertices in double precision, one object; for closed solids that go
//! to a printer.
//!
//! The standard finds the model by its relation, but many readers by the name `3D/3dmodel.model`,
//! so it is given that name.
//!
//! The format wants a unit. A plain mesh has none, and metres are written; who knows of another one
//! brings coordinates to metres first.

use super::error::WriteCause;
use super::triangles::of_face;
use crate::PolygonSoup;
use std::io::{self, Cursor, Read, Write};
use threemf::model::{
    Build, Item, Mesh, Model, Object, Resources, Triangle, Triangles, Unit, Vertex, Vertices,
};

/// The part that says which part is the model.
const RELATIONS: &str = "_rels/.rels";
/// The name that the library gives to the model.
const WRITTEN: &str = "3D/model.model";
/// The name that readers look for.
const USUAL: &str = "3D/3dmodel.model";

/// The file of a mesh.
pub(super) fn encode(soup: &PolygonSoup) -> Result<Vec<u8>, WriteCause> {
    let mut triangle = Vec::new();
    for face in 0..soup.faces.len() {
        for corners in of_face(soup, face)? {
            let [v1, v2, v3] = corners.map(|v| v as usize);
            triangle.push(Triangle { v1, v2, v3 });
        }
    }
    let vertex = soup.positions.iter().map(|p| Vertex {
        x: p.x,
        y: p.y,
        z: p.z,
    });
    let mesh = Mesh {
        vertices: Vertices {
            vertex: vertex.collect(),
        },
        triangles: Triangles { triangle },
    };
    let mut out = Cursor::new(Vec::new());
    threemf::write(&mut out, model(mesh)).map_err(|e| WriteCause::Io(io::Error::other(e)))?;
    renamed(out).map_err(|e| WriteCause::Io(io::Error::other(e)))
}

/// The package with its model under the usual name.
fn renamed(package: Cursor<Vec<u8>>) -> Result<Vec<u8>, zip::result::ZipError> {
    let mut from = zip::ZipArchive::new(package)?;
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for k in 0..from.len() {
        let mut part = from.by_index(k)?;
        match part.name()?.into_owned().as_str() {
            RELATIONS => {
                let mut text = String::new();
                part.read_to_string(&mut text)?;
                to.start_file(RELATIONS, zip::write::SimpleFileOptions::default())?;
                to.write_all(text.replace(WRITTEN, USUAL).as_bytes())?;
            }
            WRITTEN => to.raw_copy_file_rename(part, USUAL)?,
            _ => to.raw_copy_file(part)?,
        }
    }
    Ok(to.finish()?.into_inner())
}

fn model(mesh: Mesh) -> Model {
    let object = Object {
        id: 1,
        mesh: Some(mesh),
        ..Object::default()
    };
    let item = Item {
        objectid: 1,
        transform: None,
        partnumber: None,
    };
    Model {
        resources: Resources {
            object: vec![object],
            basematerials: None,
        },
        build: Build { item: vec![item] },
        unit: Unit::Meter,
        ..Model::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;

    #[test]
    fn it_reads_back_bit_by_bit_and_is_the_same_every_time() {
        let soup = PolygonSoup {
            positions: vec![
                Vec3::zeros(),
                Vec3::x() * 0.1,
                Vec3::new(1.0 / 3.0, 1.0, 1e-9),
                Vec3::y(),
            ],
            faces: vec![vec![0, 1, 2, 3]],
        };
        let bytes = encode(&soup).unwrap();
        assert_eq!(bytes, encode(&soup).unwrap());
        let mut package = zip::ZipArchive::new(Cursor::new(bytes.clone())).unwrap();
        assert!(package.by_name(USUAL).is_ok() && package.by_name(WRITTEN).is_err());
        let models = threemf::read(Cursor::new(bytes)).unwrap();
        let mesh = models[0].resources.object[0].mesh.as_ref().unwrap();
        assert_eq!(mesh.triangles.triangle.len(), 2);
        let back: Vec<Vec3> = mesh
            .vertices
            .vertex
            .iter()
            .map(|v| Vec3::new(v.x, v.y, v.z))
            .collect();
        assert_eq!(back, soup.positions);
    }
}
