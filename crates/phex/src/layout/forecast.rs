//! Forecast: which panels of a layout will cross themselves when they are made planar, from the
//! sign of `II` along its edges.
//!
//! With touching points `p_i` and the quadratic form `q(e) = II(e, e)`, the vertex of a triangle of
//! touching points is its circumcentre in `q`, to second order: with `Q_i` of the edge opposite to
//! `p_i`, the point with the barycentric weights `Q_i (Q_j + Q_k - Q_i)`. In a lattice a panel
//! whose corners are these points is simple
//!
//! * where `K > 0` if and only if `Q_i <= Q_j + Q_k` in its triangles (else: if the triangulation
//!   is Delaunay in `q`),
//! * where `K < 0` if and only if the values `Q` of each of its triangles do not all have the same
//!   sign: the edges lie on both sides of the asymptotic cone;
//!
//! in general, and where triangles with `K` of both signs meet in a panel, its outline is tested.
//! `Q` of an edge is the difference of the normals at its ends along it.
//!
//! The difference of the normals is the mean of two one-sided values, twice the height of each end
//! over the plane of the other, which differ by terms of third order. Where a panel crosses itself
//! with one of them but not with the mean, it is *in doubt*: so it is near parabolic curves, where
//! planes meet badly.
//!
//! Guaranteed: exact and without doubt for lattices on a quadratic surface, leading order in the
//! size of the panels else; panels at the boundary, which have no triangle of touching points at
//! some vertices, are not forecast.

use super::Layout;
use crate::curvature::tangent_frame;
use phex_mesh::polygon::{is_simple, signed_area};
use phex_mesh::{FaceId, Vec2, Vec3, VertexId};

/// Panels that will cross themselves, and panels that may, each in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Forecast {
    /// Panels that the sign rule says will cross themselves.
    pub crossing: Vec<FaceId>,
    /// Panels of which it says they will not, but where terms of third order may decide otherwise.
    pub in_doubt: Vec<FaceId>,
}

/// The forecast for a layout whose panels get the tangent planes at their points.
pub(crate) fn forecast(layout: &Layout) -> Forecast {
    let topology = layout.mesh.topology();
    let corners: Vec<Option<ForecastCorner>> =
        topology.vertices().map(|v| corner(layout, v)).collect();
    let mut told = Forecast::default();
    for f in topology.faces() {
        let around = topology.face_vertices(f).iter();
        let around: Option<Vec<&ForecastCorner>> =
            around.map(|v| corners[v.index()].as_ref()).collect();
        let Some(around) = around else { continue };
        let simple = |outline: &[Vec3]| is_simple_along(outline, layout.face_normal[f]);
        let outline: Vec<Vec3> = around.iter().map(|c| c.place).collect();
        if !simple(&outline) {
            told.crossing.push(f);
        } else if !with_one_other(outline, &around).all(|o| simple(&o)) {
            told.in_doubt.push(f);
        }
    }
    told
}

/// The outline with each of its corners in each of its other places.
fn with_one_other<'a>(
    outline: Vec<Vec3>,
    corners: &'a [&ForecastCorner],
) -> impl Iterator<Item = Vec<Vec3>> + 'a {
    let each = corners.iter().enumerate();
    each.flat_map(|(i, c)| c.others.iter().map(move |p| (i, *p)))
        .map(move |(i, p)| {
            let mut moved = outline.clone();
            moved[i] = p;
            moved
        })
}

/// Where the panels at an inner vertex will meet.
struct ForecastCorner {
    /// To second order.
    place: Vec3,
    /// With one-sided values of `Q`, as seen from each of the panels.
    others: [Vec3; 3],
}

/// The circumcentre, in `q`, of the touching points of the panels at an inner vertex.
fn corner(layout: &Layout, v: VertexId) -> Option<ForecastCorner> {
    let topology = layout.mesh.topology();
    if topology.is_boundary_vertex(v) {
        return None;
    }
    let faces: Vec<FaceId> = topology.faces_at(v).collect();
    let faces: [FaceId; 3] = faces.try_into().ok()?;
    let points = faces.map(|f| layout.face_point[f]);
    // Twice the height of each end under the plane of the other, and the mean for the panel
    // opposite.
    let seen_from = |panel: usize, [i, j]: [usize; 2]| {
        let along = points[j] - points[i];
        let [from_i, from_j] = [j, i].map(|k| along.dot(&layout.face_normal[faces[k]]));
        match panel {
            k if k == i => 2.0 * from_i,
            k if k == j => -2.0 * from_j,
            _ => from_i - from_j,
        }
    };
    let forms = |panel: usize| EDGES.map(|e| seen_from(panel, e));
    Some(ForecastCorner {
        place: circumcentre(points, forms(NOBODY)),
        others: [0, 1, 2].map(|k| circumcentre(points, forms(k))),
    })
}

/// Sees an edge from neither end.
const NOBODY: usize = 3;
/// Edges of a triangle, each opposite to its corner.
const EDGES: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// The circumcentre of a triangle by the forms of its edges, each opposite to its corner.
fn circumcentre(points: [Vec3; 3], q: [f64; 3]) -> Vec3 {
    let weight = |i: usize| q[i] * (q[(i + 1) % 3] + q[(i + 2) % 3] - q[i]);
    let weights = [0, 1, 2].map(weight);
    let sum: Vec3 = (0..3).map(|i| points[i] * weights[i]).sum();
    sum / weights.iter().sum::<f64>()
}

/// Whether a polygon is simple and counter-clockwise, seen from the tip of a direction; one with a
/// corner at infinity is not.
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
