//! The boundary loops as polylines with places on them.

use crate::smooth_surface::boundary_corners;
use phex_mesh::polygon::point_segment_distance;
use phex_mesh::{TriangleSurface, Vec3, VertexId};
use std::collections::BTreeSet;

/// Vertices nearer than this to the ends of a stretch are left out, diagonals.
const SPACING: f64 = 2e-3;

/// A place on the boundary: a loop, a segment of it, and how far along that (0 to 1).
#[derive(Clone, Copy, Debug)]
pub(super) struct LoopPoint {
    of: usize,
    segment: usize,
    along: f64,
}

/// The boundary loops, each with the surface on its left.
pub(super) struct OutlineLoops {
    loops: Vec<Vec<Vec3>>,
    corners: Vec<Vec<bool>>,
    diagonal: f64,
    /// Largest distance between the curve and the vertices that stand for it.
    tolerance: f64,
}

impl OutlineLoops {
    /// The boundary of a surface; vertices where it turns by more than `corner_angle` are always
    /// kept unless they are teeth, others where what stands for the curve would be farther from it
    /// than `tolerance`, in diagonals.
    pub fn of(surface: &TriangleSurface, corner_angle: f64, tolerance: f64) -> Self {
        let diagonal = surface.diagonal();
        let sharp: BTreeSet<VertexId> = boundary_corners(surface, corner_angle)
            .into_iter()
            .collect();
        let outlines = surface.boundary_loops();
        let points = |l: &Vec<VertexId>| l.iter().map(|&v| surface.positions()[v]).collect();
        let corners = |l: &Vec<VertexId>| l.iter().map(|v| sharp.contains(v)).collect();
        Self {
            loops: outlines.iter().map(points).collect(),
            corners: outlines.iter().map(corners).collect(),
            diagonal,
            tolerance: tolerance * diagonal,
        }
    }

    /// The place closest to a point.
    pub fn closest(&self, p: Vec3) -> LoopPoint {
        let mut best = (
            f64::INFINITY,
            LoopPoint {
                of: 0,
                segment: 0,
                along: 0.0,
            },
        );
        for (of, points) in self.loops.iter().enumerate() {
            for (segment, a) in points.iter().enumerate() {
                let d = points[(segment + 1) % points.len()] - a;
                let along =
                    ((p - a).dot(&d) / d.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                let distance = (a + d * along - p).norm_squared();
                if distance < best.0 {
                    best = (distance, LoopPoint { of, segment, along });
                }
            }
        }
        best.1
    }

    /// The point of a place.
    pub fn at(&self, place: LoopPoint) -> Vec3 {
        let points = &self.loops[place.of];
        let (a, b) = (
            points[place.segment],
            points[(place.segment + 1) % points.len()],
        );
        a + (b - a) * place.along
    }

    /// Segments from one place forward to another; infinite on different loops.
    pub fn ahead(&self, from: LoopPoint, to: LoopPoint) -> f64 {
        if from.of != to.of {
            return f64::INFINITY;
        }
        let n = self.loops[from.of].len() as f64;
        let position = |p: LoopPoint| p.segment as f64 + p.along;
        (position(to) - position(from)).rem_euclid(n)
    }

    /// Vertices that stand for the curve between two places, without the places; none if the way is
    /// a long detour.
    pub fn between(&self, from: LoopPoint, to: LoopPoint, begin: Vec3, end: Vec3) -> Vec<Vec3> {
        let ahead = self.ahead(from, to);
        let points = &self.loops[from.of];
        // Rounding may put the end a little before the beginning: that is no way round the whole
        // loop.
        if !ahead.is_finite() || ahead > 0.9 * points.len() as f64 {
            return Vec::new();
        }
        let count = (from.along + ahead).floor() as usize;
        let path: Vec<usize> = (1..=count)
            .map(|k| (from.segment + k) % points.len())
            .collect();
        let far = |i: &usize| {
            let p = points[*i];
            let least = SPACING * self.diagonal;
            (p - begin).norm() > least && (p - end).norm() > least
        };
        let path: Vec<usize> = path.into_iter().filter(far).collect();
        let mut kept = Vec::new();
        self.simplify(from.of, &path, begin, end, &mut kept);
        kept
    }

    /// Douglas and Peucker's simplification that keeps corners.
    fn simplify(&self, of: usize, path: &[usize], begin: Vec3, end: Vec3, kept: &mut Vec<Vec3>) {
        let points = &self.loops[of];
        let distance = |i: usize| {
            let bonus = f64::from(u8::from(self.corners[of][path[i]])) * self.diagonal;
            point_segment_distance(points[path[i]], begin, end) + bonus
        };
        let farthest = (0..path.len()).max_by(|&i, &k| distance(i).total_cmp(&distance(k)));
        let Some(i) = farthest.filter(|&i| distance(i) > self.tolerance) else {
            return;
        };
        let middle = points[path[i]];
        self.simplify(of, &path[..i], begin, middle, kept);
        kept.push(middle);
        self.simplify(of, &path[i + 1..], middle, end, kept);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::smooth_surface::teeth::tests::rhomb;

    #[test]
    fn teeth_within_the_tolerance_are_left_out_and_corners_are_not() {
        let toothed = rhomb(true);
        let kept = |tolerance: f64, [from, to]: [Vec3; 2]| {
            let outline = OutlineLoops::of(&toothed, 0.7, tolerance);
            let places = [from, to].map(|p| outline.closest(p));
            let [begin, end] = places.map(|place| outline.at(place));
            outline.between(places[0], places[1], begin, end).len()
        };
        let [left, right] = [Vec3::new(2.0, 4.0, 0.0), Vec3::new(10.0, 4.0, 0.0)];
        // The toothed edge is below, the one with two corners above.
        let [below, above] = [[left, right], [right, left]];
        assert!(kept(1e-3, below) > 5);
        assert_eq!((kept(0.5, below), kept(0.5, above)), (0, 2));
    }
}
