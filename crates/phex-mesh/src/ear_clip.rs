//! Triangles of a simple polygon by ear clipping, never by fans: concave faces keep their shape.
//!
//! The polygon is seen in its least-squares plane ([`FacePlane`]) and all decisions are exact for the projected
//! coordinates (predicates of Shewchuk). Of all ears the best shaped is cut, so that straight corners end as a proper
//! triangle's corner and not as a triangle without area.

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
    let mut quality: Vec<f64> = (0..rest.len())
        .map(|i| ear_quality(points, &rest, i))
        .collect();
    let mut triangles = Vec::with_capacity(points.len() - 2);
    while rest.len() > 3 {
        let best = (0..rest.len()).reduce(|a, b| if quality[b] > quality[a] { b } else { a });
        let i = best.filter(|&i| quality[i] > 0.0).ok_or(NotSimple)?;
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

fn ear(rest: &[u32], i: usize) -> [u32; 3] {
    let n = rest.len();
    [rest[(i + n - 1) % n], rest[i], rest[(i + 1) % n]]
}

/// Area by squared longest side of the ear at `rest[i]`; zero or less if there is none.
fn ear_quality(points: &[Vec2], rest: &[u32], i: usize) -> f64 {
    let corners = ear(rest, i);
    let [a, b, c] = corners.map(|v| points[v as usize]);
    if turn(a, b, c) <= 0.0 {
        return 0.0;
    }
    let mut others = rest
        .iter()
        .filter(|v| !corners.contains(v))
        .map(|&v| points[v as usize]);
    if others.any(|p| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0) {
        return 0.0;
    }
    let longest = (b - a)
        .norm_squared()
        .max((c - b).norm_squared())
        .max((a - c).norm_squared());
    // The smallest positive number stands for an ear too thin for the quotient.
    ((b - a).perp(&(c - b)) / longest).max(f64::MIN_POSITIVE)
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
