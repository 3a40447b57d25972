//! Drawings in DXF, release R12 (AC1009): polylines on layers, which every CAD program and cutter
//! reads.
//!
//! A mesh is written as one closed 3D polyline for each face, on the layer `PANELS`. The format has
//! no unit; numbers are model units, written so that they read back bit by bit.

use crate::{PolygonSoup, Vec2, Vec3};
use std::fmt::Write as _;

/// A drawing that is being made: polylines on layers that were named at its start.
#[derive(Clone, Debug)]
pub struct DxfDrawing {
    layers: Vec<(String, u8)>,
    entities: String,
    low: Vec3,
    high: Vec3,
}

/// What the flag of a polyline says (group code 70).
const CLOSED: u8 = 1;
const IN_SPACE: u8 = 8;
/// The same for its vertices.
const VERTEX_IN_SPACE: u8 = 32;

impl DxfDrawing {
    /// An empty drawing with layers, each with an AutoCAD colour number (1 to 255).
    ///
    /// # Panics
    /// If a layer's name holds anything but capital letters, digits, `-` and `_`, which R12 does
    /// not allow.
    pub fn new(layers: &[(&str, u8)]) -> Self {
        let allowed = |c: char| c.is_ascii_uppercase() || c.is_ascii_digit() || "-_".contains(c);
        assert!(layers.iter().all(|(name, _)| name.chars().all(allowed)));
        Self {
            layers: layers.iter().map(|&(n, c)| (n.to_owned(), c)).collect(),
            entities: String::new(),
            low: Vec3::repeat(f64::INFINITY),
            high: Vec3::repeat(f64::NEG_INFINITY),
        }
    }

    /// Adds a polyline of the plane.
    pub fn polyline(&mut self, layer: &str, points: &[Vec2], closed: bool) {
        let flat: Vec<Vec3> = points.iter().map(|p| Vec3::new(p.x, p.y, 0.0)).collect();
        self.add(layer, &flat, u8::from(closed) * CLOSED, 0);
    }

    /// Adds a polyline of space.
    pub fn polyline_3d(&mut self, layer: &str, points: &[Vec3], closed: bool) {
        let flag = IN_SPACE | (u8::from(closed) * CLOSED);
        self.add(layer, points, flag, VERTEX_IN_SPACE);
    }

    fn add(&mut self, layer: &str, points: &[Vec3], flag: u8, vertex_flag: u8) {
        let out = &mut self.entities;
        let _ = write!(
            out,
            "0\nPOLYLINE\n8\n{layer}\n66\n1\n70\n{flag}\n10\n0.0\n20\n0.0\n30\n0.0\n"
        );
        for p in points {
            let _ = write!(
                out,
                "0\nVERTEX\n8\n{layer}\n10\n{:?}\n20\n{:?}\n30\n{:?}\n70\n{vertex_flag}\n",
                p.x, p.y, p.z
            );
            self.low = self.low.inf(p);
            self.high = self.high.sup(p);
        }
        let _ = write!(out, "0\nSEQEND\n8\n{layer}\n");
    }

    /// The file.
    pub fn to_text(&self) -> String {
        let mut text = String::from("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n");
        if self.low.x <= self.high.x {
            for (name, p) in [("$EXTMIN", self.low), ("$EXTMAX", self.high)] {
                let _ = write!(
                    text,
                    "9\n{name}\n10\n{:?}\n20\n{:?}\n30\n{:?}\n",
                    p.x, p.y, p.z
                );
            }
        }
        text += "0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLTYPE\n70\n1\n\
                 0\nLTYPE\n2\nCONTINUOUS\n70\n0\n3\nSolid line\n72\n65\n73\n0\n40\n0.0\n0\nENDTAB\n";
        let _ = write!(text, "0\nTABLE\n2\nLAYER\n70\n{}\n", self.layers.len());
        for (name, colour) in &self.layers {
            let _ = write!(
                text,
                "0\nLAYER\n2\n{name}\n70\n0\n62\n{colour}\n6\nCONTINUOUS\n"
            );
        }
        text += "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
        text += &self.entities;
        text += "0\nENDSEC\n0\nEOF\n";
        text
    }
}

/// The file of a mesh.
pub(super) fn encode(soup: &PolygonSoup) -> Vec<u8> {
    const LAYER: &str = "PANELS";
    let mut drawing = DxfDrawing::new(&[(LAYER, 7)]);
    for face in &soup.faces {
        let corners: Vec<Vec3> = face.iter().map(|&v| soup.positions[v as usize]).collect();
        drawing.polyline_3d(LAYER, &corners, true);
    }
    drawing.to_text().into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_come_in_pairs_and_coordinates_bit_by_bit() {
        let soup = PolygonSoup {
            positions: vec![
                Vec3::zeros(),
                Vec3::x() * 0.1,
                Vec3::new(1e-17, 1.0 / 3.0, -2e9),
            ],
            faces: vec![vec![0, 1, 2]],
        };
        let text = String::from_utf8(encode(&soup)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(
            lines
                .chunks(2)
                .all(|pair| pair.len() == 2 && pair[0].parse::<u16>().is_ok())
        );
        let values = |code: &str| -> Vec<f64> {
            let entities = text.split("ENTITIES\n").nth(1).unwrap();
            let lines: Vec<&str> = entities.lines().collect();
            let found = lines.chunks(2).filter(|pair| pair[0] == code);
            found.map(|pair| pair[1].parse().unwrap()).collect()
        };
        assert_eq!(values("10"), [0.0, 0.0, 0.1, 1e-17]);
        assert_eq!(values("30"), [0.0, 0.0, 0.0, -2e9]);
        assert_eq!(text.matches("VERTEX\n").count(), 3);
    }
}
