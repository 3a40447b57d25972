//! Segments: their boxes, and whether they pass through a triangle, by exact signs.

use crate::Vec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use robust::{Coord3D, orient3d};

/// Relative to the length of the segment and the heights of the triangle. At a corner of 180
/// degrees an edge starts on the border of a face up to rounding, so that exact signs alone would
/// see crossings in valid meshes.
pub(crate) const TOUCHING: f64 = 1e-9;

/// A point for the hierarchies.
pub(crate) fn to_parry(p: Vec3) -> Vector {
    Vector::new(p.x, p.y, p.z)
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
