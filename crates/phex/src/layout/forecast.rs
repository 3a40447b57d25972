//! Forecast: which panels of a layout will cross themselves when they are made planar, from the sign of `II` along its edges.
//!
//! With touching points `p_i` and the quadratic form `q(e) = II(e, e)`, the vertex of a triangle of touching points is its circumcentre in `q`, to
//! second order: with `Q_i` of the edge opposite to `p_i`, the point with the barycentric weights `Q_i (Q_j + Q_k - Q_i)`. In a lattice a panel whose corners
//! are these points is simple
//!
//! * where `K > 0` if and only if `Q_i <= Q_j + Q_k` in its triangles (else: if the triangulation is Delaunay in `q`),
//! * where `K < 0` if and only if the values `Q` of each of its triangles do not all have the same sign: the edges lie on both sides of the asymptotic
//!   cone;
//!
//! in general, and where triangles with `K` of both signs meet in a panel, its outline is tested. `Q` of an edge is the difference of the normals at its ends
//! along it.
//!
//! Guaranteed: exact for lattices on a quadratic surface, leading order in the size of the panels else, so too low near parabolic curves, where planes
//! meet badly and terms of third order decide; panels at the boundary, which have no triangle of touching points at some vertices, are not forecast.

use super::Layout;
use crate::curvature::tangent_frame;
use phex_mesh::polygon::{is_simple, signed_area};
use phex_mesh::{FaceId, Vec2, Vec3, VertexId};

/// Panels that will cross themselves, in order.
pub fn crossing_panels(layout: &Layout) -> Vec<FaceId> {
    let topology = layout.mesh.topology();
    let crosses = |f: &FaceId| {
        let corners = topology.face_vertices(*f).iter();
        let corners: Option<Vec<Vec3>> = corners.map(|v| circumcentre(layout, *v)).collect();
        corners.is_some_and(|corners| !is_simple_along(&corners, layout.face_normal[*f]))
    };
    topology.faces().filter(crosses).collect()
}

/// The circumcentre, in `q`, of the touching points of the panels at an inner vertex.
fn circumcentre(layout: &Layout, v: VertexId) -> Option<Vec3> {
    let topology = layout.mesh.topology();
    if topology.is_boundary_vertex(v) {
        return None;
    }
    let faces: Vec<FaceId> = topology.outgoing(v).map(|h| topology.face(h)).collect();
    let faces: [FaceId; 3] = faces.try_into().ok()?;
    let form = |[f, g]: [FaceId; 2]| {
        let along = layout.face_point[g] - layout.face_point[f];
        along.dot(&(layout.face_normal[g] - layout.face_normal[f]))
    };
    let q = [[1, 2], [2, 0], [0, 1]].map(|ends| form(ends.map(|i| faces[i])));
    let weight = |i: usize| q[i] * (q[(i + 1) % 3] + q[(i + 2) % 3] - q[i]);
    let weights = [0, 1, 2].map(weight);
    let sum: Vec3 = (0..3)
        .map(|i| layout.face_point[faces[i]] * weights[i])
        .sum();
    Some(sum / weights.iter().sum::<f64>())
}

/// Whether a polygon is simple and counter-clockwise, seen from the tip of a direction; one with a corner at infinity is not.
fn is_simple_along(corners: &[Vec3], normal: Vec3) -> bool {
    let axes = tangent_frame(normal);
    let flat: Vec<Vec2> = corners
        .iter()
        .map(|c| axes.map(|a| (c - corners[0]).dot(&a)).into())
        .collect();
    flat.iter().all(|q| q.x.is_finite() && q.y.is_finite())
        && signed_area(&flat) > 0.0
        && is_simple(&flat)
}
