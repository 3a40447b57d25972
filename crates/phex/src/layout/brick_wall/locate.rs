//! From brick coordinates back to points of the surface.

use super::grid::{BrickGrid, Chart};
use phex_mesh::{FaceId, TriangleSurface, Vec3};

/// A point in a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    /// The triangle.
    pub face: FaceId,
    /// The chart in which the point was found.
    pub chart: Chart,
    /// Barycentric coordinates.
    pub barycentric: [f64; 3],
}

/// Triangles that one search walks through at the most.
const MAX_STEPS: usize = 2000;

/// Walks from a triangle to the one that holds a point; `None` where the way leaves the surface or
/// the coordinates fold over.
pub(crate) fn locate(
    surface: &TriangleSurface,
    grid: &BrickGrid,
    start: (FaceId, Chart),
    target: [f64; 2],
) -> Option<Located> {
    let (mut face, mut chart) = start;
    for _ in 0..MAX_STEPS {
        let barycentric = barycentric(&chart, target)?;
        let opposite = (0..3).min_by(|&i, &j| barycentric[i].total_cmp(&barycentric[j]))?;
        if barycentric[opposite] >= -1e-9 {
            return Some(Located {
                face,
                chart,
                barycentric,
            });
        }
        (face, chart) = grid.across(surface.topology(), face, &chart, (opposite + 1) % 3)?;
    }
    None
}

fn barycentric(chart: &Chart, p: [f64; 2]) -> Option<[f64; 3]> {
    let turn = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let area = turn(chart[0], chart[1], chart[2]);
    (area > 0.0).then(|| {
        let part = |k: usize| turn(p, chart[(k + 1) % 3], chart[(k + 2) % 3]) / area;
        [part(0), part(1), part(2)]
    })
}

/// The point on the curved surface that the normals describe: half-way from the triangle to the
/// mean of the corners' tangent planes, exact for quadrics to the order of their curvature (after
/// Phong tessellation, T. Boubekeur and M. Alexa 2008, who take three quarters).
pub(crate) fn curved_point(surface: &TriangleSurface, face: FaceId, barycentric: [f64; 3]) -> Vec3 {
    let corners = surface.topology().face_vertices(face);
    let flat = surface.at(face, barycentric).position;
    let lift = |(&v, b): (&phex_mesh::VertexId, f64)| {
        let n = surface.normals()[v];
        n * (0.5 * b * n.dot(&(surface.positions()[v] - flat)))
    };
    flat + corners.iter().zip(barycentric).map(lift).sum::<Vec3>()
}
