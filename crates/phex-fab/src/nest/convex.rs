//! Convex pieces of polygons, and where one piece can't be for another (the no-fit polygon: their
//! Minkowski difference).

use phex_mesh::Vec2;
use phex_mesh::ear_clip;
use phex_mesh::polygon::orientation;

/// Convex pieces that cover a simple counter-clockwise polygon: its triangles by ear clipping,
/// joined where the union is convex.
pub fn convex_pieces(polygon: &[Vec2]) -> Vec<Vec<Vec2>> {
    let triangles = ear_clip(polygon).unwrap_or_default();
    let mut pieces: Vec<Vec<usize>> = triangles.iter().map(|t| t.to_vec()).collect();
    let mut first = 0;
    while first < pieces.len() {
        let join = (first + 1..pieces.len())
            .find_map(|k| Some((k, joined(polygon, &pieces[first], &pieces[k])?)));
        match join {
            Some((k, piece)) => {
                pieces.swap_remove(k);
                pieces[first] = piece;
            }
            None => first += 1,
        }
    }
    pieces
        .iter()
        .map(|piece| piece.iter().map(|&i| polygon[i]).collect())
        .collect()
}

/// The union of two pieces across a common edge, if it is convex.
fn joined(polygon: &[Vec2], a: &[usize], b: &[usize]) -> Option<Vec<usize>> {
    let (n, m) = (a.len(), b.len());
    let shared = |i: usize, j: usize| a[i] == b[(j + 1) % m] && a[(i + 1) % n] == b[j];
    let (i, j) = (0..n)
        .flat_map(|i| (0..m).map(move |j| (i, j)))
        .find(|&(i, j)| shared(i, j))?;
    let mut union: Vec<usize> = (1..=n).map(|k| a[(i + k) % n]).collect();
    union.extend((2..m).map(|k| b[(j + k) % m]));
    let k = union.len();
    let corner = |t: usize| [t, t + 1, t + 2].map(|s| polygon[union[s % k]]);
    (0..k)
        .all(|t| {
            let [p, q, r] = corner(t);
            orientation(p, q, r) >= 0.0
        })
        .then_some(union)
}

/// All translations that make a convex piece touch or meet another: `{ p - q }` for `p` of `fixed`
/// and `q` of `moving`; convex and counter-clockwise.
pub fn no_fit(fixed: &[Vec2], moving: &[Vec2]) -> Vec<Vec2> {
    let negative: Vec<Vec2> = moving.iter().map(|p| -p).collect();
    let edges = |polygon: &[Vec2]| -> Vec<Vec2> {
        let (start, n) = (lowest(polygon), polygon.len());
        (start..start + n)
            .map(|i| polygon[(i + 1) % n] - polygon[i % n])
            .collect()
    };
    let (a, b) = (edges(fixed), edges(&negative));
    let mut at = fixed[lowest(fixed)] + negative[lowest(&negative)];
    let (mut i, mut j) = (0, 0);
    let mut sum = Vec::with_capacity(a.len() + b.len());
    while i < a.len() || j < b.len() {
        sum.push(at);
        let first = j == b.len() || (i < a.len() && !before(&b[j], &a[i]));
        if first {
            at += a[i];
            i += 1;
        } else {
            at += b[j];
            j += 1;
        }
    }
    sum
}

/// Whether one direction comes before another, counted counter-clockwise from that of x.
fn before(a: &Vec2, b: &Vec2) -> bool {
    let lower = |d: &Vec2| d.y < 0.0 || (d.y == 0.0 && d.x < 0.0);
    match (lower(a), lower(b)) {
        (false, true) => true,
        (true, false) => false,
        _ => a.perp(b) > 0.0,
    }
}

/// Number of the lowest corner, the leftmost of equals.
fn lowest(polygon: &[Vec2]) -> usize {
    let below = |a: &usize, b: &usize| {
        let (p, q) = (polygon[*a], polygon[*b]);
        p.y.total_cmp(&q.y).then(p.x.total_cmp(&q.x))
    };
    (0..polygon.len()).min_by(below).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outline::convex_hull;
    use phex_mesh::polygon::signed_area;
    use proptest::prelude::*;

    fn polygon(corners: &[[f64; 2]]) -> Vec<Vec2> {
        corners.iter().map(|&[x, y]| Vec2::new(x, y)).collect()
    }

    #[test]
    fn pieces_are_convex_and_cover_the_polygon_once() {
        let bow_tie = polygon(&[
            [0.0, 0.0],
            [4.0, 0.0],
            [3.0, 1.5],
            [4.0, 3.0],
            [0.0, 3.0],
            [1.0, 1.5],
        ]);
        let hexagon = polygon(&[
            [1.0, 0.0],
            [2.0, 0.0],
            [3.0, 1.0],
            [2.0, 2.0],
            [1.0, 2.0],
            [0.0, 1.0],
        ]);
        for (shape, count) in [(&bow_tie, 2), (&hexagon, 1)] {
            let pieces = convex_pieces(shape);
            assert_eq!(pieces.len(), count);
            let area: f64 = pieces.iter().map(|p| signed_area(p)).sum();
            assert!((area - signed_area(shape)).abs() < 1e-14);
            assert!(pieces.iter().all(|p| convex_hull(p).len() == p.len()));
        }
    }

    proptest! {
        #[test]
        fn the_no_fit_polygon_is_the_hull_of_all_differences(
            a in prop::collection::vec((-8i32..8, -8i32..8), 3..9), b in prop::collection::vec((-8i32..8, -8i32..8), 3..9)
        ) {
            let hull = |points: &[(i32, i32)]| {
                convex_hull(&points.iter().map(|&(x, y)| Vec2::new(x.into(), y.into())).collect::<Vec<_>>())
            };
            let (a, b) = (hull(&a), hull(&b));
            if a.len() > 2 && b.len() > 2 {
                let all: Vec<Vec2> = a.iter().flat_map(|p| b.iter().map(move |q| p - q)).collect();
                prop_assert_eq!(convex_hull(&no_fit(&a, &b)), convex_hull(&all));
                prop_assert_eq!(signed_area(&no_fit(&a, &b)), signed_area(&convex_hull(&all)));
            }
        }
    }
}
