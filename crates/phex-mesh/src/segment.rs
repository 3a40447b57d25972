//! Segments: their boxes, whether they pass through a triangle, by exact signs, and whether they
//! lie over it in its plane.

use crate::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use robust::{Coord3D, orient3d};

/// Relative to the length of the segment and the heights of the triangle. At a corner of 180
/// degrees an edge starts on the border of a face up to rounding, so that exact signs alone would
/// see crossings in valid meshes.
pub(crate) const TOUCHING: f64 = 1e-9;

/// Relative to the length of a segment: what is no farther from a triangle's plane lies in it, and
/// what is no farther inside of its sides only touches.
pub(crate) const COVERING: f64 = 1e-6;

/// A point for the hierarchies.
pub(crate) fn to_parry(p: Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
}

/// A point of the hierarchies.
pub(crate) fn from_parry(p: Vector) -> Vec3 {
    Vec3::new(p.x, p.y, p.z)
}

/// The box round a segment.
pub(crate) fn segment_box(from: Vec3, to: Vec3) -> Aabb {
    Aabb::new(to_parry(from.inf(&to)), to_parry(from.sup(&to)))
}

/// Whether the segment passes through the inside of a triangle; all signs are exact. Sides that are
/// diagonals of the face belong to its inside, but not their ends. What passes within [`TOUCHING`]
/// of an end of the segment or of a side that is no diagonal only touches.
pub(crate) fn passes_through(
    from: Vec3,
    to: Vec3,
    triangle: [Vec3; 3],
    diagonal: [bool; 3],
) -> bool {
    let [a, b, c] = triangle;
    let along = shares([volume(a, b, c, from), -volume(a, b, c, to)]);
    if !along.iter().all(|&share| share > TOUCHING) {
        return false;
    }
    let across = shares([
        volume(from, to, a, b),
        volume(from, to, b, c),
        volume(from, to, c, a),
    ]);
    let on_diagonal = (0..3).find(|&k| diagonal[k] && across[k] == 0.0);
    (0..3).all(|k| {
        let least = if diagonal[k] { 0.0 } else { TOUCHING };
        across[k] > least || on_diagonal == Some(k)
    })
}

/// Whether a piece of the segment lies over a triangle, in its plane.
pub(crate) fn lies_over(from: Vec3, to: Vec3, triangle: [Vec3; 3]) -> bool {
    let margin = COVERING * (to - from).norm();
    let [a, b, c] = triangle;
    let normal = (b - a).cross(&(c - a)).normalize();
    // The negation also keeps out triangles without area, which have no normal.
    let is_level = |p: Vec3| normal.dot(&(p - a)).abs() <= margin;
    if !(is_level(from) && is_level(to)) {
        return false;
    }
    // The piece between the two shares of the way is on the inner side of the sides seen so far.
    let (mut first, mut last) = (0.0_f64, 1.0_f64);
    for (p, q) in [(a, b), (b, c), (c, a)] {
        let inward = normal.cross(&(q - p)).normalize();
        let [start, end] = [from, to].map(|x| inward.dot(&(x - p)) - margin);
        match (start > 0.0, end > 0.0) {
            (true, true) => {}
            (true, false) => last = last.min(start / (start - end)),
            (false, true) => first = first.max(start / (start - end)),
            (false, false) => return false,
        }
    }
    first < last
}

/// Each value over their sum; all are positive if and only if the values have the same sign.
pub(crate) fn shares<const N: usize>(values: [f64; N]) -> [f64; N] {
    let total: f64 = values.iter().sum();
    values.map(|x| x / total)
}

/// Six times the volume of a tetrahedron, cubic model units, with its exact sign: positive if `d`
/// lies behind the triangle `abc`, whose front is where it runs counter-clockwise.
pub fn volume(a: Vec3, b: Vec3, c: Vec3, d: Vec3) -> f64 {
    let coord = |p: Vec3| Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    };
    orient3d(coord(a), coord(b), coord(c), coord(d))
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn passes(from: [f64; 3], to: [f64; 3], diagonal: [bool; 3]) -> bool {
        passes_through(from.into(), to.into(), TRIANGLE.map(Vec3::from), diagonal)
    }

    #[test]
    fn inside_outside_and_one_side() {
        assert!(passes([1.0, 1.0, 1.0], [1.0, 1.0, -1.0], [false; 3]));
        assert!(passes([1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [false; 3]));
        assert!(
            !passes([3.0, 3.0, 1.0], [3.0, 3.0, -1.0], [false; 3]),
            "beside"
        );
        assert!(
            !passes([1.0, 1.0, 1.0], [1.0, 1.0, 0.5], [false; 3]),
            "above"
        );
        assert!(
            !passes([1.0, 1.0, 1.0], [1.0, 1.0, 0.0], [false; 3]),
            "touching with an end"
        );
        assert!(
            !passes([-1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [false; 3]),
            "in the plane"
        );
    }

    #[test]
    fn within_rounding_of_an_end_or_a_border_is_touching() {
        let upright = |x: f64, low: f64| passes([x, 1.0, 1.0], [x, 1.0, low], [false; 3]);
        assert!(upright(1e-6, -1.0) && !upright(1e-12, -1.0));
        assert!(upright(1.0, -1e-6) && !upright(1.0, -1e-12));
        assert!(passes(
            [1e-12, 1.0, 1.0],
            [1e-12, 1.0, -1.0],
            [false, false, true]
        ));
    }

    #[test]
    fn a_segment_in_the_plane_lies_over_what_it_enters() {
        let lies = |from: [f64; 3], to: [f64; 3]| {
            let turned = [1, 2, 0].map(|k| TRIANGLE.map(Vec3::from)[k]);
            let [there, back] = [(from, to), (to, from)]
                .map(|(p, q)| lies_over(Vec3::from(p), Vec3::from(q), turned));
            assert_eq!(there, back);
            there
        };
        assert!(lies([-1.0, 1.0, 0.0], [5.0, 1.0, 0.0]), "across");
        assert!(lies([1.0, 1.0, 0.0], [1.5, 1.0, 0.0]), "within");
        assert!(lies([1.0, 1.0, 0.0], [9.0, 9.0, 0.0]), "out of it");
        assert!(!lies([0.0, 0.0, 0.0], [4.0, 0.0, 0.0]), "along a side");
        assert!(
            !lies([5.0, -1.0, 0.0], [-1.0, 5.0, 0.0]),
            "along the longest"
        );
        assert!(!lies([4.0, -1.0, 0.0], [4.0, 5.0, 0.0]), "past a corner");
        assert!(!lies([0.0, -2.0, 0.0], [0.0, 0.0, 0.0]), "up to a corner");
        assert!(!lies([-1.0, 1.0, 1e-3], [5.0, 1.0, 1e-3]), "above");
        assert!(!lies([-1.0, 1.0, -1.0], [5.0, 1.0, 1.0]), "through");
        let flat = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]].map(Vec3::from);
        assert!(!lies_over(flat[0], flat[2], flat), "no area");
    }

    #[test]
    fn a_diagonal_is_inside_and_a_border_is_not() {
        let hypotenuse = ([2.0, 2.0, 1.0], [2.0, 2.0, -1.0]);
        assert!(!passes(hypotenuse.0, hypotenuse.1, [false; 3]));
        assert!(passes(hypotenuse.0, hypotenuse.1, [false, true, false]));
        assert!(
            !passes([4.0, 0.0, 1.0], [4.0, 0.0, -1.0], [true; 3]),
            "a vertex is never inside"
        );
    }
}
