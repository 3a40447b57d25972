//! Triangulating a polygon by clipping its ears (Meisters' two-ears theorem), with exact predicates.

use crate::plane::FacePlane;
use crate::polygon::{is_simple, orientation, signed_area};
use crate::{Vec2, Vec3};
use thiserror::Error;

/// A polygon has fewer than three corners, or touches or crosses itself in its least-squares plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the polygon is not simple")]
pub struct NotSimple;

/// Triangles of a polygon of space, seen in its least-squares plane; a triangle is returned as it is.
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

/// Triangles of a simple polygon, as triples of corner numbers wound like the polygon; none is degenerate. Corners of
/// 180 degrees are allowed. `None` if clipping gets stuck, which happens only for a polygon that is not simple.
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
    let sign = signed_area(polygon).signum();
    let mut rest: Vec<usize> = (0..polygon.len()).collect();
    let mut triangles = Vec::with_capacity(polygon.len().saturating_sub(2));
    while rest.len() >= 3 {
        let Some(i) = (0..rest.len()).find(|&i| is_ear(polygon, &rest, i, sign)) else {
            return (triangles, rest);
        };
        triangles.push(triple(&rest, i));
        rest.remove(i);
    }
    (triangles, Vec::new())
}

fn triple(rest: &[usize], i: usize) -> [usize; 3] {
    let n = rest.len();
    [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]]
}

/// Whether the triangle at place `i` is convex and no other remaining corner lies in it or on its border.
fn is_ear(polygon: &[Vec2], rest: &[usize], i: usize, sign: f64) -> bool {
    let ear = triple(rest, i);
    let [a, b, c] = ear.map(|k| polygon[k]);
    let left = |a, b, q| sign * orientation(a, b, q);
    let holds = |q| left(a, b, q) >= 0.0 && left(b, c, q) >= 0.0 && left(c, a, q) >= 0.0;
    left(a, b, c) > 0.0 && !rest.iter().any(|k| !ear.contains(k) && holds(polygon[*k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::polygon::is_simple;
    use proptest::prelude::*;

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
}
