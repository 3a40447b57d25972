//! A polygon mesh in arrays.

use crate::arrays::{PackedArray, numbers, points};
use phex_mesh::ear_clip::ear_clip_corners;
use phex_mesh::{PolygonSoup, Topology, Vec3, polygon};
use serde::Serialize;
use std::collections::BTreeMap;

/// The number of the missing face beside a boundary edge.
const NO_FACE: u32 = u32::MAX;

/// A polygon mesh in arrays.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct MeshData {
    positions: PackedArray,
    face_start: PackedArray,
    corners: PackedArray,
    triangles: PackedArray,
    triangle_face: PackedArray,
    edges: PackedArray,
    edge_faces: PackedArray,
}

impl MeshData {
    /// Packs polygons, relative to `origin`; their edges are the sides between neighbouring
    /// corners, in the order in which they are met.
    pub fn new(soup: &PolygonSoup, origin: Vec3) -> Self {
        Self::with_edges(soup, &sides(soup), origin)
    }

    /// Packs a mesh with the edges of its topology, in the order of their ids.
    pub fn of_topology(positions: &[Vec3], topology: &Topology, origin: Vec3) -> Self {
        let soup = PolygonSoup {
            positions: positions.to_vec(),
            faces: topology.face_lists(),
        };
        let number = |f: phex_mesh::FaceId| f.index() as u32;
        let edges = topology.edges().map(|e| {
            let h = topology.edge_half_edge(e);
            let other = topology.across(h).map(number);
            EdgeSides {
                ends: topology.edge_vertices(e).map(|v| v.index() as u32),
                faces: [number(topology.face(h)), other.unwrap_or(NO_FACE)],
            }
        });
        Self::with_edges(&soup, &edges.collect::<Vec<_>>(), origin)
    }

    fn with_edges(soup: &PolygonSoup, edges: &[EdgeSides], origin: Vec3) -> Self {
        let mut start = vec![0];
        for face in &soup.faces {
            start.push(start[start.len() - 1] + face.len() as u32);
        }
        let (mut triangles, mut owner) = (Vec::new(), Vec::new());
        for (f, face) in soup.faces.iter().enumerate() {
            for triangle in triangulated(soup, face) {
                triangles.extend(triangle.map(|k| face[k as usize]));
                owner.push(f as u32);
            }
        }
        Self {
            positions: points(&soup.positions, origin),
            face_start: numbers(start),
            corners: numbers(soup.faces.iter().flatten().copied()),
            triangles: numbers(triangles),
            triangle_face: numbers(owner),
            edges: numbers(edges.iter().flat_map(|s| s.ends)),
            edge_faces: numbers(edges.iter().flat_map(|s| s.faces)),
        }
    }
}

/// An edge with the faces on its two sides.
struct EdgeSides {
    ends: [u32; 2],
    faces: [u32; 2],
}

fn sides(soup: &PolygonSoup) -> Vec<EdgeSides> {
    let mut found: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let mut sides: Vec<EdgeSides> = Vec::new();
    for (f, face) in soup.faces.iter().enumerate() {
        for [a, b] in polygon::sides(face) {
            let at = *found.entry([a.min(b), a.max(b)]).or_insert(sides.len());
            match sides.get_mut(at) {
                Some(side) => side.faces[1] = f as u32,
                None => sides.push(EdgeSides {
                    ends: [a, b],
                    faces: [f as u32, NO_FACE],
                }),
            }
        }
    }
    sides
}

/// Corner numbers of a face's triangles; a face that crosses itself is fanned, since it still has
/// to be seen.
fn triangulated(soup: &PolygonSoup, face: &[u32]) -> Vec<[u32; 3]> {
    let corners: Vec<Vec3> = face.iter().map(|&v| soup.positions[v as usize]).collect();
    ear_clip_corners(&corners).unwrap_or_else(|_| {
        let last = corners.len() as u32 - 1;
        (1..last).map(|k| [0, k, k + 1]).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares side by side.
    fn squares() -> PolygonSoup {
        let at = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        PolygonSoup {
            positions: vec![
                at(0.0, 0.0),
                at(1.0, 0.0),
                at(2.0, 0.0),
                at(2.0, 1.0),
                at(1.0, 1.0),
                at(0.0, 1.0),
            ],
            faces: vec![vec![0, 1, 4, 5], vec![1, 2, 3, 4]],
        }
    }

    #[test]
    fn arrays_come_back_as_they_were() {
        let data = MeshData::new(&squares(), Vec3::new(1.0, 0.0, 0.0));
        assert_eq!(data.face_start.words(), [0, 4, 8]);
        assert_eq!(data.corners.words(), [0, 1, 4, 5, 1, 2, 3, 4]);
        let positions = data.positions.words();
        assert_eq!(f32::from_bits(positions[0]), -1.0);
        assert_eq!(f32::from_bits(positions[6]), 1.0);
    }

    #[test]
    fn edges_are_the_sides_and_no_diagonals() {
        let data = MeshData::new(&squares(), Vec3::zeros());
        let edges = data.edges.words();
        assert_eq!(edges.len(), 2 * 7);
        let inner = data.edge_faces.words();
        assert_eq!(inner.chunks_exact(2).filter(|f| f[1] != NO_FACE).count(), 1);
        assert_eq!(data.triangles.words().len(), 3 * 4);
    }

    #[test]
    fn a_mesh_keeps_the_numbers_of_its_edges() {
        let soup = squares();
        let mesh = phex_mesh::HexMesh::from_soup(&soup).unwrap();
        let topology = mesh.topology();
        let data = MeshData::of_topology(&soup.positions, topology, Vec3::zeros());
        let ends = topology.edges().flat_map(|e| topology.edge_vertices(e));
        let ends: Vec<u32> = ends.map(|v| v.index() as u32).collect();
        assert_eq!(data.edges.words(), ends);
    }
}
