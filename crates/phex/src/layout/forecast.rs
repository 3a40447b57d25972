//! Forecast: which panels of a layout will cross themselves when they are made planar, from the sign of `II` along its edges.
//!
//! With touching points `p_i` and the quadratic form `q(e) = II(e, e)`, the vertex of a triangle of touching points is its circumcentre in `q`, to
//! second order, and the edge dual to `e` has signed length proportional to the sum over its two triangles of `w = (Q_j + Q_k - Q_i) / A`,
//! `A^2 = 2 (Q_1 Q_2 + Q_2 Q_3 + Q_3 Q_1) - Q_1^2 - Q_2^2 - Q_3^2` (four times the area in `q`, twice). So a panel is simple
//!
//! * where `K > 0` if and only if no dual edge of it has negative length: the triangulation is Delaunay in `q`,
//! * where `K < 0` if the values `Q` of each of its triangles do not all have the same sign: the edges lie on both sides of the asymptotic cone.
//!
//! Guaranteed: exact for lattices on a quadratic surface, leading order in the size of the panels else; panels at the boundary, which have no triangle of
//! touching points at some vertices, are not forecast.

use super::Layout;
use crate::curvature::{Curvature, tangent_frame};
use nalgebra::{Matrix2, Matrix3, Vector2};
use phex_mesh::{EdgeId, FaceId, HalfEdgeId, PerFace, TriangleSurface, VertexId};
use std::collections::BTreeSet;

/// Panels that will cross themselves, in order.
pub fn crossing_panels(
    layout: &Layout,
    surface: &TriangleSurface,
    curvature: &Curvature,
) -> Vec<FaceId> {
    let form = forms(layout, surface, curvature);
    let topology = layout.mesh.topology();
    let rim = |f: FaceId| {
        let mut corners = topology.face_vertices(f).iter();
        corners.any(|v| topology.is_boundary_vertex(*v))
    };
    let mut crossing: BTreeSet<FaceId> = BTreeSet::new();
    for e in topology.edges().filter(|&e| is_reversed(layout, &form, e)) {
        let h = topology.edge_half_edge(e);
        crossing.extend(
            [Some(h), topology.twin(h)]
                .into_iter()
                .flatten()
                .map(|h| topology.face(h)),
        );
    }
    for v in topology
        .vertices()
        .filter(|&v| is_one_sided(layout, &form, v))
    {
        crossing.extend(topology.outgoing(v).map(|h| topology.face(h)));
    }
    crossing.into_iter().filter(|&f| !rim(f)).collect()
}

/// The second fundamental form at each touching point.
fn forms(
    layout: &Layout,
    surface: &TriangleSurface,
    curvature: &Curvature,
) -> PerFace<Matrix3<f64>> {
    let feet = surface.closest_points(layout.face_point.as_slice());
    let at = |p: &phex_mesh::SurfacePoint| {
        let corners = surface.topology().face_vertices(p.triangle);
        let terms = corners.iter().zip(p.barycentric);
        terms.map(|(v, b)| curvature.tensor[*v] * b).sum()
    };
    PerFace::from_vec(feet.iter().map(at).collect())
}

/// `Q_1, Q_2, Q_3` of the triangle at an inner vertex, each of the edge between two panels, the first opposite to the panel of the first outgoing half-edge.
struct TriangleForm {
    faces: [FaceId; 3],
    values: [f64; 3],
    elliptic: bool,
}

fn triangle(layout: &Layout, form: &PerFace<Matrix3<f64>>, v: VertexId) -> Option<TriangleForm> {
    let topology = layout.mesh.topology();
    if topology.is_boundary_vertex(v) {
        return None;
    }
    let faces: Vec<FaceId> = topology.outgoing(v).map(|h| topology.face(h)).collect();
    let faces: [FaceId; 3] = faces.try_into().ok()?;
    let mean = faces.iter().map(|f| form[*f]).sum::<Matrix3<f64>>() / 3.0;
    let normal = faces
        .iter()
        .map(|f| layout.face_normal[*f])
        .sum::<phex_mesh::Vec3>();
    let [s, t] = tangent_frame(normal.normalize());
    let entry = |a: phex_mesh::Vec3, b: phex_mesh::Vec3| a.dot(&(mean * b));
    let flat = Matrix2::new(entry(s, s), entry(s, t), entry(t, s), entry(t, t));
    let value = |i: usize| {
        let d = layout.face_point[faces[(i + 2) % 3]] - layout.face_point[faces[(i + 1) % 3]];
        let d = Vector2::new(d.dot(&s), d.dot(&t));
        d.dot(&(flat * d))
    };
    let elliptic = flat.determinant() > 0.0;
    // What counts is the shape of the indicatrix, not on which side the surface bends.
    let sign = if elliptic && flat.trace() < 0.0 {
        -1.0
    } else {
        1.0
    };
    Some(TriangleForm {
        faces,
        values: [0, 1, 2].map(|i| sign * value(i)),
        elliptic,
    })
}

/// Whether all edges of a hyperbolic triangle lie on one side of the asymptotic cone.
fn is_one_sided(layout: &Layout, form: &PerFace<Matrix3<f64>>, v: VertexId) -> bool {
    triangle(layout, form, v).is_some_and(|t| {
        !t.elliptic && (t.values.iter().all(|q| *q > 0.0) || t.values.iter().all(|q| *q < 0.0))
    })
}

/// Whether the dual edge has negative length between two elliptic triangles.
fn is_reversed(layout: &Layout, form: &PerFace<Matrix3<f64>>, e: EdgeId) -> bool {
    let topology = layout.mesh.topology();
    let h: HalfEdgeId = topology.edge_half_edge(e);
    let Some(twin) = topology.twin(h) else {
        return false;
    };
    let sides = [topology.face(h), topology.face(twin)];
    let cotangent = |v: VertexId| {
        let t = triangle(layout, form, v).filter(|t| t.elliptic)?;
        let i = t.faces.iter().position(|f| !sides.contains(f))?;
        let [a, b, c] = [0, 1, 2].map(|k| t.values[(i + k) % 3]);
        let area = 2.0 * (a * b + b * c + c * a) - a * a - b * b - c * c;
        (area > 0.0).then(|| (b + c - a) / area.sqrt())
    };
    let [p, q] = topology.edge_vertices(e).map(cotangent);
    matches!((p, q), (Some(p), Some(q)) if p + q < 0.0)
}
