//! Triangles of a simple polygon by ear clipping, never by fans: concave faces keep their shape.
//!
//! The polygon is seen in its least-squares plane ([`FacePlane`]) and all decisions are exact for the projected
//! coordinates (predicates of Shewchuk). Of all ears the best is cut, so that a straight corner becomes the corner of
//! triangles with area, and not the tip of one without.

use crate::plane::FacePlane;
use crate::{Vec2, Vec3};
use robust::{Coord, orient2d};
use thiserror::Error;

/// A polygon has fewer than three corners, or touches or crosses itself in its least-squares plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the polygon is not simple")]
pub struct NotSimple;

/// Cuts a polygon into `corners.len() - 2` triangles, given as corner numbers in the polygon's direction. A triangle is
/// returned as it is.
///
/// # Errors
/// If the polygon is not simple in its least-squares plane (a polygon without area never is).
pub fn ear_clip(corners: &[Vec3]) -> Result<Vec<[u32; 3]>, NotSimple> {
    if corners.len() <= 3 {
        return if corners.len() == 3 {
            Ok(vec![[0, 1, 2]])
        } else {
            Err(NotSimple)
        };
    }
    let plane = FacePlane::fit(corners);
    let points: Vec<Vec2> = corners.iter().map(|&p| plane.project(p)).collect();
    if !is_simple(&points) {
        return Err(NotSimple);
    }
    cut_ears(&points)
}

fn cut_ears(points: &[Vec2]) -> Result<Vec<[u32; 3]>, NotSimple> {
    let mut rest: Vec<u32> = (0..points.len() as u32).collect();
    let mut quality = all_qualities(points, &rest);
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while rest.len() > 3 {
        let mut i = best(&quality);
        if quality[i] <= 0.0 {
            // A corner that was cut since may have been all that blocked an ear.
            quality = all_qualities(points, &rest);
            i = best(&quality);
        }
        if quality[i] <= 0.0 {
            return Err(NotSimple);
        }
        triangles.push(ear(&rest, i));
        rest.remove(i);
        quality.remove(i);
        for j in [(i + rest.len() - 1) % rest.len(), i % rest.len()] {
            quality[j] = ear_quality(points, &rest, j);
        }
    }
    triangles.push([rest[0], rest[1], rest[2]]);
    Ok(triangles)
}

fn all_qualities(points: &[Vec2], rest: &[u32]) -> Vec<f64> {
    (0..rest.len())
        .map(|i| ear_quality(points, rest, i))
        .collect()
}

/// The first place of the largest value.
fn best(quality: &[f64]) -> usize {
    (1..quality.len()).fold(0, |a, b| if quality[b] > quality[a] { b } else { a })
}

fn ear(rest: &[u32], i: usize) -> [u32; 3] {
    let n = rest.len();
    [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]]
}

/// How good the ear at `rest[i]` is, zero or less if there is none: the least height of its triangle or, if less, the
/// least distance of the other corners from its diagonal, by its longest side. The second keeps an ear from leaving a
/// polygon without area, as where the others are straight corners of one side.
fn ear_quality(points: &[Vec2], rest: &[u32], i: usize) -> f64 {
    let corners = ear(rest, i);
    let [a, b, c] = corners.map(|v| points[v as usize]);
    if turn(a, b, c) <= 0.0 {
        return 0.0;
    }
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    let mut least = (b - a).perp(&(c - b)) / longest;
    for &v in rest.iter().filter(|v| !corners.contains(v)) {
        let p = points[v as usize];
        if turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0 {
            return 0.0;
        }
        least = least.min(distance_to_segment(p, a, c));
    }
    // The smallest positive number stands for an ear too thin for the quotient.
    (least / longest).max(f64::MIN_POSITIVE)
}

fn distance_to_segment(p: Vec2, a: Vec2, b: Vec2) -> f64 {
    let along = (p - a).dot(&(b - a)) / (b - a).norm_squared();
    (a + (b - a) * along.clamp(0.0, 1.0) - p).norm()
}

/// Positive if `a`, `b`, `c` turn counter-clockwise, zero if they are collinear: exact.
fn turn(a: Vec2, b: Vec2, c: Vec2) -> f64 {
    let [a, b, c] = [a, b, c].map(|p| Coord { x: p.x, y: p.y });
    orient2d(a, b, c)
}

/// Whether no two sides meet but neighbours in their common corner.
fn is_simple(points: &[Vec2]) -> bool {
    let n = points.len();
    let side = |i: usize| [points[i], points[(i + 1) % n]];
    (0..n).all(|i| {
        let [a, b] = side(i);
        let folded = on_segment(a, b, points[(i + 2) % n]) || on_segment(b, points[(i + 2) % n], a);
        let last = if i == 0 { n - 1 } else { n };
        !folded && (i + 2..last).all(|j| !segments_meet(side(i), side(j)))
    })
}

fn segments_meet([a, b]: [Vec2; 2], [c, d]: [Vec2; 2]) -> bool {
    let opposite = |x: f64, y: f64| (x > 0.0 && y < 0.0) || (x < 0.0 && y > 0.0);
    let crossing = opposite(turn(a, b, c), turn(a, b, d)) && opposite(turn(c, d, a), turn(c, d, b));
    crossing
        || on_segment(a, b, c)
        || on_segment(a, b, d)
        || on_segment(c, d, a)
        || on_segment(c, d, b)
}

fn on_segment(a: Vec2, b: Vec2, p: Vec2) -> bool {
    let (low, high) = (a.inf(&b), a.sup(&b));
    let in_box = (0..2).all(|k| low[k] <= p[k] && p[k] <= high[k]);
    in_box && turn(a, b, p) == 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Points of a tilted plane.
    fn lift(points: &[[f64; 2]]) -> Vec<Vec3> {
        let (u, v) = (
            Vec3::new(1.0, 2.0, 2.0) / 3.0,
            Vec3::new(2.0, 1.0, -2.0) / 3.0,
        );
        let place = |p: &[f64; 2]| Vec3::new(5.0, -3.0, 7.0) + u * p[0] + v * p[1];
        points.iter().map(place).collect()
    }

    fn signed_areas(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> Vec<f64> {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| Vec2::from(points[i as usize]));
            0.5 * (b - a).perp(&(c - a))
        };
        triangles.iter().map(area).collect()
    }

    fn polygon_area(points: &[[f64; 2]]) -> f64 {
        let next = points.iter().cycle().skip(1);
        points
            .iter()
            .zip(next)
            .map(|(p, q)| 0.5 * (p[0] * q[1] - p[1] * q[0]))
            .sum()
    }

    #[test]
    fn random_star_polygons_are_covered_once() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for n in [4, 5, 6, 7, 12, 40, 300] {
            for _ in 0..20 {
                let points: Vec<[f64; 2]> = (0..n)
                    .map(|i| {
                        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
                        let radius = rng.random_range(0.2..1.0);
                        [radius * angle.cos(), radius * angle.sin()]
                    })
                    .collect();
                let triangles = ear_clip(&lift(&points)).unwrap();
                let areas = signed_areas(&points, &triangles);
                assert_eq!(areas.len(), points.len() - 2);
                assert!(areas.iter().all(|&a| a > 0.0));
                assert!((areas.iter().sum::<f64>() - polygon_area(&points)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn straight_corners_get_triangles_with_area() {
        // A triangle with four corners on each side, and a comb whose teeth touch no diagonal's side.
        let side = |a: [f64; 2], b: [f64; 2]| {
            (0..4).map(move |k| [0, 1].map(|i| a[i] + (b[i] - a[i]) * 0.25 * f64::from(k)))
        };
        let (a, b, c) = ([0.0, 0.0], [4.0, 0.0], [0.0, 4.0]);
        let triangle: Vec<[f64; 2]> = side(a, b).chain(side(b, c)).chain(side(c, a)).collect();
        let comb = [
            [0.0, 0.0],
            [5.0, 0.0],
            [5.0, 2.0],
            [4.0, 2.0],
            [4.0, 1.0],
            [3.0, 1.0],
            [3.0, 2.0],
            [2.0, 2.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ];
        for points in [&triangle[..], &comb[..]] {
            let triangles = ear_clip(&lift(points)).unwrap();
            let areas = signed_areas(points, &triangles);
            assert!(areas.iter().all(|&a| a > 0.1), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - polygon_area(points)).abs() < 1e-12);
        }
    }

    #[test]
    fn corners_that_are_straight_but_for_rounding() {
        for k in 1..200 {
            // The second corner lies between first and third, up to rounding to either side.
            let t = f64::from(k) / 200.0;
            let (a, b, c) = ([0.1, 0.2], [1.7, 0.9], [0.3, 1.9]);
            let middle = [0, 1].map(|i| a[i] + (b[i] - a[i]) * t);
            for points in [vec![a, middle, b, c], vec![c, a, middle, b]] {
                let areas = signed_areas(&points, &ear_clip(&lift(&points)).unwrap());
                assert!(areas.iter().all(|&a| a > 1e-3), "t {t}: {areas:?}");
            }
        }
    }

    #[test]
    fn polygons_that_touch_or_cross_themselves() {
        let bow = vec![[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 1.0]];
        let pentagram = (0..5)
            .map(|k| (f64::from(2 * k) * std::f64::consts::TAU / 5.0).sin_cos())
            .map(|(s, c)| [c, s])
            .collect();
        let touching = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0], [0.0, 2.0]];
        let twice = vec![
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 0.0],
            [-1.0, 0.0],
            [-1.0, -1.0],
        ];
        let spike = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [2.0, 1.0], [0.0, 1.0]];
        let line = vec![[0.0, 0.0], [1.0, 0.0], [3.0, 0.0], [2.0, 0.0]];
        for points in [bow, pentagram, touching, twice, spike, line] {
            // Not tilted: touching is exact only before rounding.
            let corners: Vec<Vec3> = points.iter().map(|p| Vec3::new(p[0], p[1], 0.0)).collect();
            assert_eq!(ear_clip(&corners), Err(NotSimple), "{points:?}");
        }
        assert_eq!(ear_clip(&[Vec3::x(), Vec3::y()]), Err(NotSimple));
    }

    #[test]
    fn a_saddle_shaped_quad_keeps_its_direction() {
        let corners = [
            [0.0, 0.0, 0.3],
            [1.0, 0.0, -0.3],
            [1.0, 1.0, 0.3],
            [0.0, 1.0, -0.3],
        ];
        let triangles = ear_clip(&corners.map(Vec3::from)).unwrap();
        let flat = corners.map(|p| [p[0], p[1]]);
        assert!(signed_areas(&flat, &triangles).iter().all(|&a| a == 0.5));
    }
}
