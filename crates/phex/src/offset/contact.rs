//! The first contact of a face with itself while the vertices move on straight lines.

use super::gauss_image::GaussImage;
use phex_mesh::{FaceId, FlatFace, HexMesh, Vec2};

/// An edge whose least length is below this fraction of its first one vanishes.
const VANISHED: f64 = 1e-9;
/// How far beyond the ends of an edge a corner still hits it, over its length.
const SLACK: f64 = 1e-9;

/// Smallest `d > 0` at which, in `M + side d M'`, an edge vanishes or a corner of a face hits
/// another edge of it; infinite if there is none. `side` is 1 or -1.
pub(super) fn first_contact(mesh: &HexMesh, image: &GaussImage, side: f64) -> f64 {
    let faces = mesh.topology().faces();
    let contacts = faces.map(|f| face_contact(&MovingFace::new(mesh, image, f, side)));
    contacts.fold(f64::INFINITY, f64::min)
}

/// Corners of a face in its plane, with their velocities.
struct MovingFace {
    corners: Vec<(Vec2, Vec2)>,
}

impl MovingFace {
    fn new(mesh: &HexMesh, image: &GaussImage, face: FaceId, side: f64) -> Self {
        let flat = FlatFace::of(mesh, face);
        let vertices = mesh.topology().face_vertices(face).iter();
        let velocity = |v| flat.plane.project_vector(image.positions[v] * side);
        let corners = flat.polygon.iter().copied();
        Self {
            corners: corners.zip(vertices.map(|&v| velocity(v))).collect(),
        }
    }

    /// Vector from corner `i` to corner `j`, and its velocity.
    fn between(&self, i: usize, j: usize) -> (Vec2, Vec2) {
        let (a, b) = (self.corners[i], self.corners[j]);
        (b.0 - a.0, b.1 - a.1)
    }
}

fn face_contact(face: &MovingFace) -> f64 {
    let n = face.corners.len();
    let mut first = f64::INFINITY;
    for i in 0..n {
        let j = (i + 1) % n;
        first = first.min(vanishing(face.between(i, j)));
        for p in (0..n).filter(|&p| p != i && p != j) {
            first = first.min(hit(face.between(p, i), face.between(p, j)));
        }
    }
    first
}

/// When a vector that changes linearly vanishes.
fn vanishing((r, w): (Vec2, Vec2)) -> f64 {
    let d = -r.dot(&w) / w.norm_squared();
    let vanishes = d > 0.0 && (r + w * d).norm() <= VANISHED * r.norm();
    if vanishes { d } else { f64::INFINITY }
}

/// When the origin meets the segment between two moving points.
fn hit((a, u): (Vec2, Vec2), (b, w): (Vec2, Vec2)) -> f64 {
    let on_segment = |d: f64| {
        let (a, b) = (a + u * d, b + w * d);
        let (edge, slack) = (b - a, SLACK * (b - a).norm_squared());
        let along = -a.dot(&edge);
        along >= -slack && along <= edge.norm_squared() + slack
    };
    let roots = quadratic_roots(u.perp(&w), a.perp(&w) + u.perp(&b), a.perp(&b));
    let hits = roots.into_iter().filter(|&d| d > 0.0 && on_segment(d));
    hits.fold(f64::INFINITY, f64::min)
}

/// Real roots of `a d^2 + b d + c`; NaN where there is none.
fn quadratic_roots(a: f64, b: f64, c: f64) -> [f64; 2] {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    [q / a, c / q]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_keep_their_digits() {
        let [large, small] = quadratic_roots(1.0, -1e9, 1.0);
        assert!((large - 1e9).abs() < 1e-3 && (small - 1e-9).abs() < 1e-24);
        assert!(quadratic_roots(1.0, 0.0, 1.0).iter().all(|r| r.is_nan()));
        assert!(quadratic_roots(0.0, 2.0, -1.0).contains(&0.5), "linear");
    }

    #[test]
    fn a_corner_hits_an_edge_between_its_ends_only() {
        let still = Vec2::zeros();
        let towards = Vec2::new(0.0, -2.0);
        let ends = |left: f64, right: f64| [Vec2::new(left, 1.0), Vec2::new(right, 1.0)];
        let [a, b] = ends(-1.0, 1.0);
        assert!((hit((a, towards), (b, towards)) - 0.5).abs() < 1e-15);
        let [a, b] = ends(0.5, 1.0);
        assert_eq!(hit((a, towards), (b, towards)), f64::INFINITY);
        let [a, b] = ends(-1.0, 1.0);
        assert_eq!(hit((a, still), (b, still)), f64::INFINITY);
    }

    #[test]
    fn an_edge_vanishes_when_its_ends_meet() {
        let r = Vec2::new(2.0, 0.0);
        assert_eq!(vanishing((r, Vec2::new(-4.0, 0.0))), 0.5);
        assert_eq!(vanishing((r, Vec2::new(4.0, 0.0))), f64::INFINITY);
        assert_eq!(vanishing((r, Vec2::new(-4.0, 1.0))), f64::INFINITY);
    }
}
