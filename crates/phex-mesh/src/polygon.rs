//! Predicates and measures of a polygon in a plane, given by its corners in order.
//!
//! | quantity | meaning | exact? |
//! |---|---|---|
//! | [`is_simple`] | no self-intersection, no touching, no fold | exact on the given coordinates |
//! | [`interior_angles`] | angle inside each corner, in (0, 2 pi) for a counter-clockwise simple polygon | rounded |
//! | [`signed_area`] | positive if counter-clockwise | rounded |
//! | [`clearance`] | least distance of a corner to an edge that does not hold it | rounded |
//!
//! Nothing here allocates. Side `i` runs from corner `i` to corner `i + 1`, cyclically.

use crate::Vec2;
use nalgebra::SVector;
use robust::{Coord, orient2d};
use std::f64::consts::TAU;

/// Positive if `a, b, c` turn to the left, negative if to the right, zero if and only if they are
/// exactly collinear.
pub fn orientation(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    let coord = |p: Vec2| Coord { x: p.x, y: p.y };
    orient2d(coord(a), coord(b), coord(c))
}

/// Whether the polygon is free of self-intersection: at least three corners, all finite; no edge of
/// length zero; no corner folded back on itself (interior angle 0 or 2 pi); no two edges that are
/// not neighbours touch. A corner of exactly 180 degrees is allowed. Decided exactly for the given
/// coordinates, for either winding.
pub fn is_simple(polygon: &[Vec2]) -> bool {
    let n = polygon.len();
    n >= 3
        && polygon.iter().all(|p| p.x.is_finite() && p.y.is_finite())
        && sides(polygon).all(|[a, b]| a != b)
        && corner_triples(polygon).all(|[a, b, c]| !is_folded(a, b, c))
        && (0..n).all(|i| edge_is_clear(polygon, i))
}

/// Whether edge `i` touches none of the later edges that are not its neighbours.
fn edge_is_clear(polygon: &[Vec2], i: usize) -> bool {
    let n = polygon.len();
    let end = if i == 0 { n - 1 } else { n };
    let (a, b) = (polygon[i], polygon[(i + 1) % n]);
    (i + 2..end).all(|j| !segments_touch(a, b, polygon[j], polygon[(j + 1) % n]))
}

/// Whether the closed segments `ab` and `cd`, neither of length zero, share a point (exact).
pub fn segments_touch(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let same_side = |s: f64, t: f64| (s > 0.0 && t > 0.0) || (s < 0.0 && t < 0.0);
    // Collinear segments touch if and only if their boxes do.
    boxes_touch(a, b, c, d)
        && !same_side(orientation(a, b, c), orientation(a, b, d))
        && !same_side(orientation(c, d, a), orientation(c, d, b))
}

fn boxes_touch(a: Vec2, b: Vec2, c: Vec2, d: Vec2) -> bool {
    let overlap = |a: f64, b: f64, c: f64, d: f64| a.min(b) <= c.max(d) && c.min(d) <= a.max(b);
    overlap(a.x, b.x, c.x, d.x) && overlap(a.y, b.y, c.y, d.y)
}

/// Whether the edges `ba` and `bc` point in exactly the same direction: an interior angle of 0 or 2
/// pi.
pub fn is_folded(a: Vec2, b: Vec2, c: Vec2) -> bool {
    // Differences of floating-point numbers have an exact sign.
    let together = |a: f64, b: f64, c: f64| (a > b && c > b) || (a < b && c < b);
    (together(a.x, b.x, c.x) || together(a.y, b.y, c.y)) && orientation(a, b, c) == 0.0
}

/// The sides of a closed polygon, from each corner to the next; corners may be points or numbers.
pub fn sides<T: Copy>(polygon: &[T]) -> impl ExactSizeIterator<Item = [T; 2]> + '_ {
    let n = polygon.len();
    (0..n).map(move |i| [polygon[i], polygon[(i + 1) % n]])
}

/// Previous corner, corner and next corner, for each corner in order.
pub fn corner_triples(polygon: &[Vec2]) -> impl ExactSizeIterator<Item = [Vec2; 3]> + '_ {
    let n = polygon.len();
    (0..n).map(move |i| [polygon[(i + n - 1) % n], polygon[i], polygon[(i + 1) % n]])
}

/// Angle in radians, in `[0, 2 pi)`, from the edge `bc` counter-clockwise to the edge `ba`: the
/// interior angle at `b` of a counter-clockwise polygon `.. a, b, c ..`.
pub fn interior_angle(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    let (to_next, to_previous) = (c - b, a - b);
    let angle = f64::atan2(to_next.perp(&to_previous), to_next.dot(&to_previous));
    if angle < 0.0 { angle + TAU } else { angle }
}

/// Interior angle at each corner, in radians; the polygon runs counter-clockwise.
pub fn interior_angles(polygon: &[Vec2]) -> impl ExactSizeIterator<Item = f64> + '_ {
    corner_triples(polygon).map(|[a, b, c]| interior_angle(a, b, c))
}

/// Area, positive if the polygon runs counter-clockwise, in squared units of the coordinates.
pub fn signed_area(polygon: &[Vec2]) -> f64 {
    let Some(&origin) = polygon.first() else {
        return 0.0;
    };
    let triangle = |w: &[Vec2]| (w[0] - origin).perp(&(w[1] - origin));
    0.5 * polygon.windows(2).map(triangle).sum::<f64>()
}

/// Whether a point lies in a polygon, whichever way that runs: a ray crosses it an odd number of
/// times. On the outline itself either answer may come.
///
/// ```
/// use phex_mesh::{Vec2, polygon};
/// let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec2::new(x, y));
/// assert!(polygon::contains(&square, Vec2::new(0.4, 0.7)));
/// assert!(!polygon::contains(&square, Vec2::new(1.4, 0.7)));
/// ```
pub fn contains(polygon: &[Vec2], p: Vec2) -> bool {
    let crosses = |[a, b]: &[Vec2; 2]| {
        (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)
    };
    sides(polygon).filter(crosses).count() % 2 == 1
}

/// Area of a regular hexagon over the square of its edge.
pub const HEXAGON: f64 = 2.598_076_211_353_316;

/// Distance of the point `p` to the closed segment `ab`, in the plane or in space.
pub fn point_segment_distance<const D: usize>(
    p: SVector<f64, D>,
    a: SVector<f64, D>,
    b: SVector<f64, D>,
) -> f64 {
    let (edge, d) = (b - a, p - a);
    let length_squared = edge.norm_squared();
    if length_squared == 0.0 {
        return d.norm();
    }
    let t = (d.dot(&edge) / length_squared).clamp(0.0, 1.0);
    (d - edge * t).norm()
}

/// A corner of a polygon, an edge that does not hold it, and their distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clearance {
    /// Number of the corner.
    pub corner: usize,
    /// Number of the edge.
    pub edge: usize,
    /// Their distance, in units of the coordinates.
    pub distance: f64,
}

/// The closest pair of a corner and an edge that does not hold it; `None` for fewer than three
/// corners.
pub fn closest_corner_and_edge(polygon: &[Vec2]) -> Option<Clearance> {
    let n = polygon.len();
    let mut closest: Option<Clearance> = None;
    for corner in 0..n {
        // The edges that hold the corner are `corner - 1` and `corner`.
        for edge in (1..n.saturating_sub(1)).map(|k| (corner + k) % n) {
            let (a, b) = (polygon[edge], polygon[(edge + 1) % n]);
            let distance = point_segment_distance(polygon[corner], a, b);
            if closest.is_none_or(|c| distance < c.distance) {
                closest = Some(Clearance {
                    corner,
                    edge,
                    distance,
                });
            }
        }
    }
    closest
}

/// Least distance of a corner to an edge that does not hold it; infinite for fewer than three
/// corners.
pub fn clearance(polygon: &[Vec2]) -> f64 {
    closest_corner_and_edge(polygon).map_or(f64::INFINITY, |c| c.distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn polygon<const N: usize>(corners: [[f64; 2]; N]) -> Vec<Vec2> {
        corners.map(|[x, y]| Vec2::new(x, y)).to_vec()
    }

    fn regular(n: usize) -> Vec<Vec2> {
        (0..n)
            .map(|k| TAU * k as f64 / n as f64)
            .map(|t| Vec2::new(t.cos(), t.sin()))
            .collect()
    }

    const L: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    const ARROWHEAD: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [1.0, 1.0], [0.0, 4.0]];
    const BOW_TIE: [[f64; 2]; 6] = [
        [0.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [0.5, -1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];

    #[test]
    fn convex_and_concave_polygons_are_simple() {
        for simple in [regular(6), regular(11), polygon(L), polygon(ARROWHEAD)] {
            assert!(is_simple(&simple));
            assert!(is_simple(&simple.into_iter().rev().collect::<Vec<_>>()));
        }
    }

    #[test]
    fn corner_of_180_degrees_is_simple() {
        assert!(is_simple(&polygon([
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [0.0, 1.0]
        ])));
    }

    #[test]
    fn crossing_touching_folded_and_collapsed_polygons_are_not_simple() {
        assert!(!is_simple(&polygon(BOW_TIE)));
        let touching = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 0.0], [0.0, 3.0]];
        assert!(!is_simple(&polygon(touching)), "a corner on another edge");
        let pinched = [
            [0.0, 0.0],
            [1.0, 1.0],
            [2.0, 0.0],
            [2.0, 2.0],
            [1.0, 1.0],
            [0.0, 2.0],
        ];
        assert!(!is_simple(&polygon(pinched)), "two corners at one point");
        let spike = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 0.5], [0.0, 2.0]];
        assert!(!is_simple(&polygon(spike)), "interior angle 2 pi");
        let collapsed = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        assert!(!is_simple(&polygon(collapsed)), "an edge of length zero");
        assert!(
            !is_simple(&polygon([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])),
            "collinear corners"
        );
        assert!(!is_simple(&polygon([
            [0.0, 0.0],
            [1.0, f64::NAN],
            [0.0, 1.0]
        ])));
        assert!(!is_simple(&polygon([[0.0, 0.0], [1.0, 0.0]])));
    }

    #[test]
    fn touching_is_decided_beyond_rounding() {
        // The corner (0.5, 0.5) is on the diagonal; one unit in the last place decides. A naive
        // determinant misses it.
        let chain = |y: f64| {
            polygon([
                [12.0, 12.0],
                [24.0, 24.0],
                [0.0, 24.0],
                [0.5, y],
                [-5.0, 0.0],
                [0.5, 0.5],
            ])
        };
        assert!(!is_simple(&chain(0.5)));
        let up = f64::from_bits(0.5f64.to_bits() + 1);
        let (a, b) = (Vec2::new(12.0, 12.0), Vec2::new(24.0, 24.0));
        assert!(orientation(a, b, Vec2::new(0.5, up)) > 0.0);
        assert!(is_simple(&chain(up)));
    }

    #[test]
    fn angles_of_the_l_shape() {
        let expected = [
            FRAC_PI_2,
            FRAC_PI_2,
            FRAC_PI_2,
            3.0 * FRAC_PI_2,
            FRAC_PI_2,
            FRAC_PI_2,
        ];
        for (angle, expected) in interior_angles(&polygon(L)).zip(expected) {
            assert!((angle - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn areas_have_the_sign_of_the_winding() {
        assert_eq!(signed_area(&polygon(L)), 4.0);
        assert_eq!(
            signed_area(&polygon(L).into_iter().rev().collect::<Vec<_>>()),
            -4.0
        );
        assert_eq!(signed_area(&[]), 0.0);
    }

    #[test]
    fn distances_to_a_segment() {
        let (a, b) = (Vec2::new(0.0, 0.0), Vec2::new(4.0, 0.0));
        assert_eq!(point_segment_distance(Vec2::new(1.0, 2.0), a, b), 2.0);
        assert_eq!(point_segment_distance(Vec2::new(7.0, 4.0), a, b), 5.0);
        assert_eq!(point_segment_distance(Vec2::new(3.0, 4.0), a, a), 5.0);
    }

    #[test]
    fn clearance_names_corner_and_edge() {
        let notch = polygon([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 0.25], [0.0, 3.0]]);
        let closest = closest_corner_and_edge(&notch).unwrap();
        assert_eq!(
            (closest.corner, closest.edge, closest.distance),
            (3, 0, 0.25)
        );
        assert!(
            (clearance(&regular(6)) - 1.0).abs() < 1e-15,
            "the next but one corner's edge is no closer"
        );
        assert!((clearance(&regular(3)) - 1.5).abs() < 1e-15);
        assert_eq!(clearance(&regular(2)), f64::INFINITY);
    }

    fn random_polygon() -> impl Strategy<Value = Vec<Vec2>> {
        let corner = (-1.0..1.0, -1.0..1.0).prop_map(|(x, y)| Vec2::new(x, y));
        prop::collection::vec(corner, 3..9)
    }

    proptest! {
        #[test]
        fn a_simple_polygon_turns_once(corners in random_polygon()) {
            if is_simple(&corners) {
                let ccw = if signed_area(&corners) > 0.0 { corners } else { corners.into_iter().rev().collect() };
                let sum: f64 = interior_angles(&ccw).sum();
                prop_assert!((sum - PI * (ccw.len() - 2) as f64).abs() < 1e-9);
            }
        }

        #[test]
        fn simplicity_depends_on_neither_start_nor_winding(corners in random_polygon(), shift in 0usize..8) {
            let mut other: Vec<Vec2> = corners.iter().rev().copied().collect();
            let n = other.len();
            other.rotate_left(shift % n);
            prop_assert_eq!(is_simple(&corners), is_simple(&other));
        }

        #[test]
        fn a_perturbation_below_the_clearance_keeps_a_polygon_simple(corners in random_polygon(), turn in 0.0..TAU) {
            if is_simple(&corners) {
                let step = 0.99 * clearance(&corners);
                let mut moved = corners;
                moved[0] += Vec2::new(turn.cos(), turn.sin()) * step;
                prop_assert!(is_simple(&moved));
            }
        }
    }
}
