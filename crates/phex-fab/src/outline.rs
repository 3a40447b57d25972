//! Polygons whose sides move outwards.

use phex_mesh::polygon::{contains, is_simple, orientation, point_segment_distance, sides};
use phex_mesh::{Vec2, bounds};

/// Sine of a corner's turn below which its two sides count as one line.
const STRAIGHT: f64 = 1e-6;
/// Cosine of the turn of a corner (150 degrees) from which on its spike is cut off.
const SPIKE: f64 = -0.866;

/// Unit normal of a side, to the right of its direction: out of a counter-clockwise polygon.
pub fn outward(a: Vec2, b: Vec2) -> Vec2 {
    let d = (b - a).normalize();
    Vec2::new(d.y, -d.x)
}

/// A polygon with side `i` moved outwards by `distances[i]` (at least 0). Holds all points within
/// these distances of the polygon. Sharp corners get blunt instead of long; where sides would
/// cross, it is the convex hull that grows.
pub fn grown(polygon: &[Vec2], distances: &[f64]) -> Vec<Vec2> {
    let moved = moved(polygon, distances);
    if is_simple(&moved) {
        return moved;
    }
    let hull = convex_hull(polygon);
    let most = distances.iter().copied().fold(0.0, f64::max);
    self::moved(&hull, &vec![most; hull.len()])
}

/// A simple polygon that holds two polygons with parallel sides, of which the second reaches beyond
/// side `i` of the first by at most `distances[i]` (at least 0): the first with its sides moved, or
/// the convex hull of both where that fails.
pub fn enclosing(first: &[Vec2], second: &[Vec2], distances: &[f64]) -> Vec<Vec2> {
    let normals: Vec<Vec2> = sides(first).map(|[a, b]| outward(a, b)).collect();
    let n = first.len();
    let side = |k: usize| (normals[k], distances[k]);
    let corner = |i: usize| {
        let ((m, r), (o, s)) = (side((i + n - 1) % n), side(i));
        let straight = m.perp(&o).abs() < STRAIGHT;
        first[i]
            + if straight {
                o * r.max(s)
            } else {
                meet((m, r), (o, s))
            }
    };
    let around: Vec<Vec2> = (0..n).map(corner).collect();
    let slack = 1e-9
        * bounds(first)
            .map(|p| p.amax())
            .into_iter()
            .fold(0.0, f64::max);
    let inside = |p: &Vec2| {
        contains(&around, *p)
            || sides(&around).any(|[a, b]| point_segment_distance(*p, a, b) <= slack)
    };
    if is_simple(&around) && first.iter().chain(second).all(inside) {
        return around;
    }
    convex_hull(&[first, second].concat())
}

fn moved(polygon: &[Vec2], distances: &[f64]) -> Vec<Vec2> {
    let n = polygon.len();
    let normals: Vec<Vec2> = sides(polygon).map(|[a, b]| outward(a, b)).collect();
    let mut corners = Vec::with_capacity(n);
    for (i, &at) in polygon.iter().enumerate() {
        let before = (i + n - 1) % n;
        let side = |k: usize| (normals[k], distances[k]);
        push_corner(&mut corners, at, side(before), side(i));
    }
    corners
}

/// The corner where two moved sides meet; two corners where that would be far away.
fn push_corner(corners: &mut Vec<Vec2>, at: Vec2, (m, r): (Vec2, f64), (n, s): (Vec2, f64)) {
    let (sine, cosine) = (m.perp(&n), m.dot(&n));
    if sine.abs() < STRAIGHT && cosine > 0.0 {
        corners.push(at + (m + n).normalize() * r.max(s));
    } else if sine > 0.0 && cosine < SPIKE {
        // Cut at right angles to the corner's bisector, at the larger distance.
        let bisector = Vec2::new(n.y - m.y, m.x - n.x).normalize();
        let far = r.max(s);
        corners.push(at + meet((m, r), (bisector, far)));
        corners.push(at + meet((bisector, far), (n, s)));
    } else {
        corners.push(at + meet((m, r), (n, s)));
    }
}

/// The point at given distances from the origin along two unit vectors.
fn meet((m, r): (Vec2, f64), (n, s): (Vec2, f64)) -> Vec2 {
    let (sine, cosine) = (m.perp(&n), m.dot(&n));
    (m * (r - s * cosine) + n * (s - r * cosine)) / (sine * sine)
}

/// Convex hull, counter-clockwise, without straight corners (monotone chain).
pub fn convex_hull(points: &[Vec2]) -> Vec<Vec2> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let chain = |points: &mut dyn Iterator<Item = Vec2>| {
        let mut hull: Vec<Vec2> = Vec::new();
        for p in points {
            while hull.len() > 1
                && orientation(hull[hull.len() - 2], hull[hull.len() - 1], p) <= 0.0
            {
                hull.pop();
            }
            hull.push(p);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut sorted.iter().copied());
    hull.extend(chain(&mut sorted.iter().rev().copied()));
    hull
}

/// Sizes of the bounding rectangle of least area, the longer first.
pub fn least_rectangle(points: &[Vec2]) -> [f64; 2] {
    let hull = convex_hull(points);
    let sizes = sides(&hull).map(|[a, b]| {
        let out = outward(a, b);
        let along = Vec2::new(-out.y, out.x);
        let width = |d: Vec2| {
            let [low, high] = hull
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], p| {
                    [l.min(p.dot(&d)), h.max(p.dot(&d))]
                });
            high - low
        };
        [width(along), width(out)]
    });
    let best = sizes.min_by(|a, b| (a[0] * a[1]).total_cmp(&(b[0] * b[1])));
    let [a, b] = best.unwrap_or_default();
    [a.max(b), a.min(b)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::polygon::signed_area;
    use proptest::prelude::*;

    fn polygon(corners: &[[f64; 2]]) -> Vec<Vec2> {
        corners.iter().map(|&[x, y]| Vec2::new(x, y)).collect()
    }

    #[test]
    fn every_side_moves_by_its_own_distance() {
        let l = polygon(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ]);
        let out = grown(&l, &[0.1, 0.2, 0.3, 0.4, 0.5, 0.6]);
        let expected = [
            [-0.6, -0.1],
            [3.2, -0.1],
            [3.2, 1.3],
            [1.4, 1.3],
            [1.4, 2.5],
            [-0.6, 2.5],
        ];
        for (p, q) in out.iter().zip(polygon(&expected)) {
            assert!((p - q).norm() < 1e-14);
        }
    }

    #[test]
    fn sharp_corners_get_blunt_and_straight_ones_stay() {
        let needle = polygon(&[[0.0, 0.0], [10.0, -0.1], [20.0, 0.0], [10.0, 0.1]]);
        let out = grown(&needle, &[1.0; 4]);
        assert_eq!(out.len(), 6);
        let [low, high] = bounds(&out);
        assert!((low.x + 1.0).abs() < 1e-9 && (high.x - 21.0).abs() < 1e-9);
        let brick = polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
        assert!((grown(&brick, &[0.5; 5])[1] - Vec2::new(1.0, -0.5)).norm() < 1e-14);
    }

    #[test]
    fn a_narrow_notch_is_closed() {
        let notched = polygon(&[
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 3.0],
            [2.1, 3.0],
            [2.0, 0.5],
            [1.9, 3.0],
            [0.0, 3.0],
        ]);
        assert!(
            (signed_area(&grown(&notched, &[1.0; 7])) - 30.0).abs() < 1e-9,
            "the hull grows to 6 x 5"
        );
    }

    #[test]
    fn least_rectangle_of_a_turned_one() {
        let turned = polygon(&[[0.0, 0.0], [3.0, 3.0], [2.0, 4.0], [-1.0, 1.0]]);
        let [a, b] = least_rectangle(&turned);
        assert!((a - 18f64.sqrt()).abs() < 1e-14 && (b - 2f64.sqrt()).abs() < 1e-14);
    }

    proptest! {
        #[test]
        fn all_points_near_a_polygon_are_inside(
            radii in prop::collection::vec(0.3..1.0, 4..9), distance in 0.01..0.5, turn in 0.0..std::f64::consts::TAU
        ) {
            let n = radii.len() as f64;
            let corner = |(i, r): (usize, &f64)| {
                let (s, c) = (std::f64::consts::TAU * i as f64 / n).sin_cos();
                Vec2::new(c, s) * *r
            };
            let star: Vec<Vec2> = radii.iter().enumerate().map(corner).collect();
            let out = grown(&star, &vec![distance; star.len()]);
            prop_assert!(is_simple(&out));
            let (s, c) = f64::sin_cos(turn);
            for p in star {
                let q = p + Vec2::new(c, s) * (distance * (1.0 - 1e-9));
                let inside = contains(&out, q) || sides(&out).any(|[a, b]| point_segment_distance(q, a, b) < 1e-9);
                prop_assert!(inside, "{q}");
            }
        }
    }
}
