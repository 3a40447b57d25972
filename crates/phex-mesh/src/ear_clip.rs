//! Triangles of a simple polygon by ear clipping (Meisters' two-ears theorem), never by fans:
//! concave faces keep their shape.
//!
//! Which corners are ears is decided exactly (predicates of Shewchuk). Of all ears the best is cut,
//! so that a straight corner becomes the corner of triangles with area, and not the tip of one
//! without.

use crate::plane::FacePlane;
use crate::polygon::{is_simple, orientation, point_segment_distance, signed_area};
use crate::{Vec2, Vec3};
use thiserror::Error;

/// A polygon has fewer than three corners, or touches or crosses itself in its least-squares plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the polygon is not simple")]
pub struct NotSimple;

/// Triangles of a polygon of space, seen in its least-squares plane; a triangle is returned as it
/// is.
///
/// # Errors
/// If the polygon is not simple in that plane (a polygon without area never is).
pub fn ear_clip_corners(corners: &[Vec3]) -> Result<Vec<[u32; 3]>, NotSimple> {
    if corners.len() == 3 {
        return Ok(vec![[0, 1, 2]]);
    }
    let plane = FacePlane::fit(corners);
    let polygon: Vec<Vec2> = corners.iter().map(|&p| plane.project(p)).collect();
    if !is_simple(&polygon) {
        return Err(NotSimple);
    }
    let triangles = ear_clip(&polygon).ok_or(NotSimple)?;
    Ok(triangles.into_iter().map(|t| t.map(|k| k as u32)).collect())
}

/// Triangles of a simple polygon, as triples of corner numbers wound like the polygon; none is
/// degenerate. Corners of 180 degrees are allowed. `None` if clipping gets stuck, which happens
/// only for a polygon that is not simple.
pub fn ear_clip(polygon: &[Vec2]) -> Option<Vec<[usize; 3]>> {
    let (triangles, rest) = clip(polygon);
    rest.is_empty().then_some(triangles)
}

/// As [`ear_clip`]; what is left of a polygon that is not simple is fanned.
pub(crate) fn ear_clip_or_fan(polygon: &[Vec2]) -> Vec<[usize; 3]> {
    let (mut triangles, rest) = clip(polygon);
    triangles.extend(rest.windows(2).skip(1).map(|w| [rest[0], w[0], w[1]]));
    triangles
}

/// The clipped triangles, and the corners that are left when no ear is found.
fn clip(polygon: &[Vec2]) -> (Vec<[usize; 3]>, Vec<usize>) {
    let mut clipper = Clipper::new(polygon);
    let mut triangles = Vec::with_capacity(polygon.len().saturating_sub(2));
    while clipper.rest.len() >= 3 {
        let Some(i) = clipper.best_ear() else {
            return (triangles, clipper.rest);
        };
        triangles.push(clipper.cut(i));
    }
    (triangles, Vec::new())
}

/// A polygon that is being clipped.
struct Clipper<'a> {
    polygon: &'a [Vec2],
    /// Sign of the polygon's area.
    sign: f64,
    /// Corners that are left.
    rest: Vec<usize>,
    /// Quality of the ear at each of them, zero where there is none; it may have risen since it was
    /// computed.
    quality: Vec<f64>,
}

impl<'a> Clipper<'a> {
    fn new(polygon: &'a [Vec2]) -> Self {
        let mut clipper = Self {
            polygon,
            sign: signed_area(polygon).signum(),
            rest: (0..polygon.len()).collect(),
            quality: Vec::new(),
        };
        clipper.measure_all();
        clipper
    }

    fn measure_all(&mut self) {
        self.quality = (0..self.rest.len()).map(|i| self.ear_quality(i)).collect();
    }

    /// Place of the best ear, the first of equals.
    fn best_ear(&mut self) -> Option<usize> {
        self.best_known_ear().or_else(|| {
            // A corner that was cut since may have been all that blocked an ear.
            self.measure_all();
            self.best_known_ear()
        })
    }

    fn best_known_ear(&self) -> Option<usize> {
        let better = |a: usize, b: usize| {
            if self.quality[b] > self.quality[a] {
                b
            } else {
                a
            }
        };
        let best = (0..self.rest.len()).reduce(better);
        best.filter(|&i| self.quality[i] > 0.0)
    }

    /// Cuts the ear at place `i` off.
    fn cut(&mut self, i: usize) -> [usize; 3] {
        let ear = self.triple(i);
        self.rest.remove(i);
        self.quality.remove(i);
        let n = self.rest.len();
        for j in [(i + n - 1) % n, i % n] {
            self.quality[j] = self.ear_quality(j);
        }
        ear
    }

    fn triple(&self, i: usize) -> [usize; 3] {
        let n = self.rest.len();
        [(i + n - 1) % n, i, (i + 1) % n].map(|k| self.rest[k])
    }

    /// Zero unless the triangle at place `i` is convex and no other remaining corner lies in it or
    /// on its border. Else its least height or, if less, the least distance of the other corners
    /// from its diagonal, by its longest side. The second keeps an ear from leaving a polygon
    /// without area, as where the others are straight corners of one side.
    fn ear_quality(&self, i: usize) -> f64 {
        let ear = self.triple(i);
        let [a, b, c] = ear.map(|k| self.polygon[k]);
        let left = |a, b, q| self.sign * orientation(a, b, q);
        if left(a, b, c) <= 0.0 {
            return 0.0;
        }
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let mut least = (b - a).perp(&(c - b)).abs() / longest;
        for &k in self.rest.iter().filter(|k| !ear.contains(k)) {
            let q = self.polygon[k];
            if left(a, b, q) >= 0.0 && left(b, c, q) >= 0.0 && left(c, a, q) >= 0.0 {
                return 0.0;
            }
            least = least.min(point_segment_distance(q, a, c));
        }
        // The smallest positive number stands for an ear too thin for the quotient.
        (least / longest).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::{is_simple, sides};
    use proptest::prelude::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn polygon(corners: &[[f64; 2]]) -> Vec<Vec2> {
        corners.iter().map(|&[x, y]| Vec2::new(x, y)).collect()
    }

    fn areas(polygon: &[Vec2], triangles: &[[usize; 3]]) -> Vec<f64> {
        let area = |t: &[usize; 3]| signed_area(&t.map(|k| polygon[k]));
        triangles.iter().map(area).collect()
    }

    #[test]
    fn concave_polygon_of_either_winding() {
        let l = polygon(&[
            [0.0, 0.0],
            [3.0, 0.0],
            [3.0, 1.0],
            [1.0, 1.0],
            [1.0, 2.0],
            [0.0, 2.0],
        ]);
        let triangles = ear_clip(&l).unwrap();
        assert_eq!(triangles.len(), 4);
        assert_eq!(areas(&l, &triangles).iter().sum::<f64>(), 4.0);
        let back: Vec<Vec2> = l.into_iter().rev().collect();
        let areas = areas(&back, &ear_clip(&back).unwrap());
        assert!(areas.iter().all(|&a| a < 0.0) && areas.iter().sum::<f64>() == -4.0);
    }

    #[test]
    fn corners_of_180_degrees_give_no_degenerate_triangle() {
        let brick = polygon(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 1.0],
            [0.0, 1.0],
        ]);
        let areas = areas(&brick, &ear_clip(&brick).unwrap());
        assert!(areas.iter().all(|&a| a > 0.0) && areas.iter().sum::<f64>() == 2.0);
    }

    #[test]
    fn stuck_polygon_is_refused_or_fanned() {
        let line = polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]]);
        assert_eq!(ear_clip(&line), None);
        assert_eq!(ear_clip_or_fan(&line), [[0, 1, 2], [0, 2, 3]]);
    }

    proptest! {
        #[test]
        fn a_simple_polygon_is_covered_once(grid in prop::collection::vec((0u8..6, 0u8..6), 4..8)) {
            // A coarse grid makes collinear corners common.
            let corners: Vec<Vec2> = grid.iter().map(|&(x, y)| Vec2::new(x.into(), y.into())).collect();
            if is_simple(&corners) {
                let triangles = ear_clip(&corners).expect("a simple polygon has ears");
                let area = signed_area(&corners);
                let areas = areas(&corners, &triangles);
                prop_assert_eq!(triangles.len(), corners.len() - 2);
                prop_assert!(areas.iter().all(|a| a * area > 0.0));
                prop_assert_eq!(areas.iter().sum::<f64>(), area);
            }
        }
    }

    /// Points of a tilted plane.
    fn lift(points: &[[f64; 2]]) -> Vec<Vec3> {
        let (u, v) = (
            Vec3::new(1.0, 2.0, 2.0) / 3.0,
            Vec3::new(2.0, 1.0, -2.0) / 3.0,
        );
        let place = |p: &[f64; 2]| Vec3::new(5.0, -3.0, 7.0) + u * p[0] + v * p[1];
        points.iter().map(place).collect()
    }

    fn areas_of_lifted(points: &[[f64; 2]], triangles: &[[u32; 3]]) -> Vec<f64> {
        let area = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| Vec2::from(points[i as usize]));
            0.5 * (b - a).perp(&(c - a))
        };
        triangles.iter().map(area).collect()
    }

    fn polygon_area(points: &[[f64; 2]]) -> f64 {
        let doubled = sides(points).map(|[p, q]| p[0] * q[1] - p[1] * q[0]);
        doubled.map(|area| 0.5 * area).sum()
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
                let triangles = ear_clip_corners(&lift(&points)).unwrap();
                let areas = areas_of_lifted(&points, &triangles);
                assert_eq!(areas.len(), points.len() - 2);
                assert!(areas.iter().all(|&a| a > 0.0));
                assert!((areas.iter().sum::<f64>() - polygon_area(&points)).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn straight_corners_get_triangles_with_area() {
        // A triangle with four corners on each side, and a comb whose teeth touch no diagonal's
        // side.
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
            let triangles = ear_clip_corners(&lift(points)).unwrap();
            let areas = areas_of_lifted(points, &triangles);
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
                let areas = areas_of_lifted(&points, &ear_clip_corners(&lift(&points)).unwrap());
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
            assert_eq!(ear_clip_corners(&corners), Err(NotSimple), "{points:?}");
        }
        assert_eq!(ear_clip_corners(&[Vec3::x(), Vec3::y()]), Err(NotSimple));
    }

    #[test]
    fn a_saddle_shaped_quad_keeps_its_direction() {
        let corners = [
            [0.0, 0.0, 0.3],
            [1.0, 0.0, -0.3],
            [1.0, 1.0, 0.3],
            [0.0, 1.0, -0.3],
        ];
        let triangles = ear_clip_corners(&corners.map(Vec3::from)).unwrap();
        let flat = corners.map(|p| [p[0], p[1]]);
        assert!(areas_of_lifted(&flat, &triangles).iter().all(|&a| a == 0.5));
    }
}
