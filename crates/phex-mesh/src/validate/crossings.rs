//! Edges that pass through faces they do not belong to or lie over them, and faces that overlap at
//! the boundary.

use super::violation::Violation;
use crate::clipped::ClippedMesh;
use crate::segment::{COVERING, TOUCHING, lies_over, passes_through, segment_box, shares};
use crate::{EdgeId, FaceId, FlatFace, HexMesh, PerFace, Topology, Vec3};
use parry3d_f64::bounding_volume::BoundingVolume;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Height, in mean edges, up to which a face that lies over another one overlaps it.
const OVERLAP_HEIGHT: f64 = 0.25;

/// An edge and a face that does not hold it.
type CrossedFace = (EdgeId, FaceId);

/// All crossings, by edge and then by face.
pub(super) fn crossings(mesh: &HexMesh, faces: &PerFace<FlatFace>) -> Vec<Violation> {
    let clipped = ClippedMesh::new(mesh, faces);
    let all = [
        passages(mesh, &clipped),
        covers(mesh, &clipped),
        overlaps(mesh, faces),
    ];
    let all: BTreeSet<CrossedFace> = all.into_iter().flatten().collect();
    let violation = |(edge, face)| Violation::Crossing {
        edge,
        vertices: mesh.topology().edge_vertices(edge),
        face,
    };
    all.into_iter().map(violation).collect()
}

/// Faces that overlap beside the boundary: edges of it that cross, seen along the mean normal of
/// their faces, which are neighbours or have one in common. Nothing else tells them from faces that
/// end side by side, since they lie in one plane, nearly.
fn overlaps(mesh: &HexMesh, faces: &PerFace<FlatFace>) -> Vec<CrossedFace> {
    let topology = mesh.topology();
    let height = OVERLAP_HEIGHT * mesh.mean_edge();
    let of_face = |f: FaceId| topology.face_half_edges(f).map(|h| topology.edge(h));
    let at_boundary = |e: &EdgeId| topology.is_boundary_edge(*e);
    let rim: Vec<EdgeId> = topology.boundary_edges().collect();
    let crossed = |&edge: &EdgeId| {
        let own = topology.face(topology.edge_half_edge(edge));
        let others = beside(topology, &beside(topology, &BTreeSet::from([own])));
        let crosses = |g: &FaceId| {
            let edges = of_face(*g).filter(at_boundary);
            let normals = [own, *g].map(|f| faces[f].normal());
            *g != own
                && edges
                    .into_iter()
                    .any(|other| cross(mesh, [edge, other], normals, height))
        };
        let found: Vec<FaceId> = others.into_iter().filter(crosses).collect();
        found.into_iter().map(move |face| (edge, face))
    };
    rim.par_iter().flat_map_iter(crossed).collect()
}

/// Faces, and those that share a vertex with them.
fn beside(topology: &Topology, faces: &BTreeSet<FaceId>) -> BTreeSet<FaceId> {
    let vertices = faces.iter().flat_map(|f| topology.face_vertices(*f));
    vertices.flat_map(|v| topology.faces_at(*v)).collect()
}

/// Whether two edges cross, seen along the mean of two normals, at most a height apart.
fn cross(mesh: &HexMesh, edges: [EdgeId; 2], normals: [Vec3; 2], height: f64) -> bool {
    let [first, second] = edges.map(|e| mesh.topology().edge_vertices(e));
    if first.iter().any(|v| second.contains(v)) || normals[0].dot(&normals[1]) <= 0.0 {
        return false;
    }
    let axis = (normals[0] + normals[1]).normalize();
    let [a, b] = first.map(|v| mesh.position(v));
    let [c, d] = second.map(|v| mesh.position(v));
    let touching = TOUCHING * (b - a).norm().max((d - c).norm());
    // Where the ends of a segment lie beside the line through two points, as it is seen: shares of
    // the way from one side to the other.
    let sides = |p: Vec3, q: Vec3, ends: [Vec3; 2]| {
        let across = axis.cross(&(q - p)).normalize();
        let [near, far] = ends.map(|end| across.dot(&(end - p)));
        let crosses = near.abs() > touching && far.abs() > touching && near * far < 0.0;
        crosses.then(|| shares([near, -far]))
    };
    let between = |p: Vec3, q: Vec3, [near, far]: [f64; 2]| p * far + q * near;
    let (Some(along), Some(other)) = (sides(c, d, [a, b]), sides(a, b, [c, d])) else {
        return false;
    };
    axis.dot(&(between(a, b, along) - between(c, d, other)))
        .abs()
        < height
}

/// Edges that pass through faces or lie over them, in their planes.
///
/// A face counts as its ear-clipped triangles. Triangles with a vertex of the edge, and all
/// triangles of the edge's own faces, are left out. Touching (an end on a face, an edge on an edge)
/// is no crossing.
fn passages(mesh: &HexMesh, clipped: &ClippedMesh) -> Vec<CrossedFace> {
    let edges = 0..mesh.topology().n_edges() as u32;
    let found = edges
        .into_par_iter()
        .flat_map_iter(|e| edge_crossings(mesh, clipped, EdgeId::new(e)));
    found.collect()
}

/// Faces whose middle lies on another one, by their first edges: no edge tells of two that
/// coincide.
fn covers(mesh: &HexMesh, clipped: &ClippedMesh) -> Vec<CrossedFace> {
    let near = COVERING * mesh.mean_edge();
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let both = faces.into_par_iter().zip(clipped.middles());
    let found = both.filter_map(|(own, middle)| {
        let face = clipped.other_at(middle, near, own)?;
        let half_edge = mesh.topology().face_half_edges(own).next()?;
        Some((mesh.topology().edge(half_edge), face))
    });
    found.collect()
}

fn edge_crossings(mesh: &HexMesh, clipped: &ClippedMesh, edge: EdgeId) -> Vec<CrossedFace> {
    let topology = mesh.topology();
    let vertices = topology.edge_vertices(edge);
    let own: Vec<FaceId> = topology.edge_faces(edge).collect();
    let [from, to] = vertices.map(|v| mesh.position(v));
    let numbers = vertices.map(|v| v.index() as u32);
    let crosses = |t: usize| {
        let corners = clipped.corners(t);
        !own.contains(&clipped.owner[t])
            && !numbers
                .iter()
                .any(|v| clipped.hierarchy.indices()[t].contains(v))
            && (passes_through(from, to, corners, clipped.diagonal[t])
                || lies_over(from, to, corners))
    };
    let near = segment_box(from, to).loosened(COVERING * (to - from).norm());
    let candidates = clipped
        .hierarchy
        .bvh()
        .intersect_aabb(&near)
        .map(|t| t as usize);
    candidates
        .filter(|&t| crosses(t))
        .map(|t| (edge, clipped.owner[t]))
        .collect()
}
