//! The surface continued beyond its boundary.
//!
//! From every vertex of the boundary a circular arc goes on in the direction of the outward
//! conormal, through two points of the surface further in (its tangent and normal curvature at the
//! boundary, at the scale of the arc). Directions and curvatures are averaged along the boundary;
//! at corners the arcs are longer by `1 / cos(turning / 2)`, a mitre. Where the boundary is
//! concave, as round a hole, arcs end before they could meet: no longer than `CLEAR` of the largest
//! circle that touches the boundary there and holds no other point of it.
//!
//! A hole in which there is no room for a wide strip stays as it is: what would be left of it is a
//! slit that no row of panels can go round.
//!
//! Teeth ([`super::teeth`]) are no corners: arcs begin on a line through them, and the strip joins
//! them to it.
//!
//! Guaranteed: the input's vertices and triangles come first and are unchanged; the topology is the
//! same. Fails where the input is not an embedded surface; the strip may then cross itself, as the
//! input does.

use super::teeth::{SHARP, line_through_teeth};
use phex_mesh::{FaceId, TriangleSurface, Vec3, VertexId};

/// Share of the radius of the largest empty circle that an arc may have as its length.
const CLEAR: f64 = 0.7;
/// Length of an arc, over how far a tooth stands out, at the least: it has to pass the tip.
const PAST: f64 = 2.0;
/// Longest mitre, in widths.
const MITRE: f64 = 1.6;
/// Passes of averaging along the boundary.
const SMOOTHING: usize = 6;
/// Largest angle of an arc, radians.
const MAX_ARC: f64 = 1.2;
/// Rows of triangles in the strip at the most.
const MAX_ROWS: usize = 6;

/// A surface with a strip beyond its boundary.
#[derive(Clone)]
pub struct Extension {
    /// The extended surface; its first vertices and triangles are those of the input.
    pub surface: TriangleSurface,
    /// Triangles of the input.
    pub n_original: usize,
    /// The input's vertex that each vertex is, or goes on from.
    pub origin: Vec<VertexId>,
}

impl Extension {
    /// Whether a triangle lies on the input's part of the surface, after `levels` subdivisions into
    /// four.
    pub fn is_given(&self, triangle: FaceId, levels: usize) -> bool {
        triangle.index() >> (2 * levels) < self.n_original
    }
}

/// Continues a surface by a strip of a width, beyond its longest boundary curve and each other one
/// where a strip of the width `room` would have its place; `None` where that changes nothing.
pub fn extend(surface: &TriangleSurface, width: f64, room: f64) -> Option<Extension> {
    let loops = surface.boundary_loops();
    let lines = loops
        .iter()
        .map(|boundary| line_through_teeth(surface, boundary).0);
    let mut rim: Vec<Vec3> = lines.flatten().collect();
    let axis = longest_axis(&rim);
    rim.sort_by(|p, q| p[axis].total_cmp(&q[axis]));
    let longest = loops
        .iter()
        .map(|l| surface.length_round(l))
        .fold(0.0, f64::max);
    let mut strip = Strip::new(surface);
    for boundary in &loops {
        let shortened = |width: f64| {
            let mut arcs = arcs(surface, boundary, width);
            shorten(&mut arcs, (&rim, axis), width);
            arcs
        };
        let is_hole = surface.length_round(boundary) < longest;
        if width > 0.0 && (!is_hole || has_room(&shortened(room), room)) {
            strip.add(boundary, &shortened(width), width);
        }
    }
    if strip.triangles.len() == strip.n_original {
        return None;
    }
    let surface = TriangleSurface::new(strip.positions, &strip.triangles).ok()?;
    Some(Extension {
        surface,
        n_original: strip.n_original,
        origin: strip.origin,
    })
}

/// A circular arc that leaves a vertex of the boundary.
#[derive(Clone, Copy)]
struct Arc {
    start: Vec3,
    /// From the start to the vertex, if that is a tooth.
    tooth: Vec3,
    /// Unit tangent at the start, outwards.
    direction: Vec3,
    /// Curvature vector at the start.
    curvature: Vec3,
    length: f64,
    corner: bool,
}

impl Arc {
    fn at(&self, s: f64) -> Vec3 {
        let left = 1.0 - s / self.length.max(f64::MIN_POSITIVE);
        self.on_arc(s) + self.tooth * left
    }

    fn on_arc(&self, s: f64) -> Vec3 {
        let bend = self.curvature - self.direction * self.direction.dot(&self.curvature);
        let k = bend
            .norm()
            .min(MAX_ARC / self.length.max(f64::MIN_POSITIVE));
        if k * s < 1e-9 {
            return self.start + self.direction * s;
        }
        let (sin, cos) = (k * s).sin_cos();
        self.start + self.direction * (sin / k) + bend.normalize() * ((1.0 - cos) / k)
    }
}

fn arcs(surface: &TriangleSurface, boundary: &[VertexId], width: f64) -> Vec<Arc> {
    let n = boundary.len();
    let (line, is_tooth) = line_through_teeth(surface, boundary);
    let at = |i: usize| line[i % n];
    let raw = (0..n).map(|i| {
        let here = at(i);
        // Vertices may lie on one another: the nearest one that does not tells the way.
        let elsewhere = |step: usize| (1..n).map(|k| at(i + k * step)).find(|p| *p != here);
        let way = |to: Vec3| to.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
        let a = way(here - elsewhere(n - 1).unwrap_or(here));
        let b = way(elsewhere(1).unwrap_or(here) - here);
        let normal = surface.normals()[boundary[i]];
        let conormal = (a + b).cross(&normal).try_normalize(1e-9);
        let outward = conormal.unwrap_or_else(|| way(b.cross(&normal)));
        let half = 0.5 * a.angle(&b);
        let mut arc = continued(surface, here, outward, 0.5 * width);
        let convex = a.cross(&b).dot(&normal) > 0.0;
        arc.length = width
            * if convex {
                (1.0 / half.cos()).min(MITRE)
            } else {
                1.0
            };
        arc.corner = half > SHARP && !is_tooth[i];
        arc.tooth = surface.positions()[boundary[i]] - here;
        arc
    });
    let mut arcs: Vec<Arc> = raw.collect();
    for _ in 0..SMOOTHING {
        arcs = smoothed(&arcs);
    }
    arcs
}

/// The arc through two points of the surface at distances `step` and `2 step` inwards.
fn continued(surface: &TriangleSurface, here: Vec3, outward: Vec3, step: f64) -> Arc {
    let mut arc = Arc {
        start: here,
        tooth: Vec3::zeros(),
        direction: outward,
        curvature: Vec3::zeros(),
        length: 0.0,
        corner: false,
    };
    let first = surface.closest_point(here - outward * step).position;
    let ahead = (first - here).try_normalize(0.0).unwrap_or(-outward);
    let second = surface.closest_point(first + ahead * step).position;
    let (d1, d2) = (first - here, second - here);
    let (s1, s2) = (d1.norm(), d1.norm() + (second - first).norm());
    // Near another boundary the points are too close to tell anything.
    if s1 < 0.5 * step || s2 < 1.5 * step || d1.dot(&outward) > -0.7 * s1 {
        return arc;
    }
    // The parabola through the three points, by arc length inwards: here + u s + c s^2 / 2.
    let (q1, q2) = (d1 / s1, d2 / s2);
    let curvature = (q2 - q1) * (2.0 / (s2 - s1));
    let inwards = q1 - curvature * (0.5 * s1);
    if let Some(direction) = (-inwards).try_normalize(1e-9) {
        arc.direction = direction;
        arc.curvature = curvature;
    }
    arc
}

/// Directions and curvatures averaged with those of the neighbours; corners keep their own.
fn smoothed(arcs: &[Arc]) -> Vec<Arc> {
    let n = arcs.len();
    let average = |i: usize| {
        let (before, here, after) = (&arcs[(i + n - 1) % n], arcs[i], &arcs[(i + 1) % n]);
        if here.corner {
            return here;
        }
        let own = |a: &Arc| if a.corner { here } else { *a };
        let (before, after) = (own(before), own(after));
        let direction = here.direction * 2.0 + before.direction + after.direction;
        Arc {
            direction: direction.try_normalize(0.0).unwrap_or(here.direction),
            curvature: (here.curvature * 2.0 + before.curvature + after.curvature) / 4.0,
            ..here
        }
    };
    (0..n).map(average).collect()
}

/// Whether most of a loop's arcs are as long as they are to be.
fn has_room(arcs: &[Arc], width: f64) -> bool {
    let long = arcs.iter().filter(|a| a.length >= width).count();
    2 * long > arcs.len()
}

/// The axis along which points spread most: few are near one another there.
fn longest_axis(points: &[Vec3]) -> usize {
    let lowest = points
        .iter()
        .fold(Vec3::repeat(f64::MAX), |low, p| low.inf(p));
    let highest = points
        .iter()
        .fold(Vec3::repeat(f64::MIN), |high, p| high.sup(p));
    (highest - lowest).imax()
}

/// Ends arcs before they could meet the continuation of another part of the boundary, whose points
/// come in the order of their coordinates along an axis.
fn shorten(arcs: &mut [Arc], (rim, axis): (&[Vec3], usize), width: f64) {
    let reach = 4.0 * width;
    for arc in arcs.iter_mut() {
        let at = arc.start[axis];
        let first = rim.partition_point(|p| p[axis] < at - reach);
        let near = rim[first..].iter();
        for p in near.take_while(|p| p[axis] <= at + reach) {
            let d = p - arc.start;
            let (distance2, ahead) = (d.norm_squared(), d.dot(&arc.direction));
            if ahead > 1e-3 * distance2.sqrt() && distance2 < reach * reach {
                arc.length = arc.length.min(CLEAR * 0.5 * distance2 / ahead);
            }
        }
    }
    // Neighbours' lengths differ by no more than half their distance, and no arc vanishes.
    let n = arcs.len();
    let forwards = (0..2 * n).map(|i| (i % n, (i + 1) % n));
    let backwards = (0..2 * n).rev().map(|i| (i % n, (i + n - 1) % n));
    for (i, j) in forwards.chain(backwards) {
        let distance = (arcs[i].start - arcs[j].start).norm();
        let least = 0.1 * distance.min(width);
        arcs[i].length = arcs[i].length.max(least);
        arcs[j].length = arcs[j]
            .length
            .min(arcs[i].length + 0.7 * distance)
            .max(least);
    }
    for arc in arcs {
        arc.length = arc.length.max(PAST * arc.tooth.dot(&arc.direction));
    }
}

/// The triangles that are added.
struct Strip {
    positions: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    origin: Vec<VertexId>,
    n_original: usize,
}

impl Strip {
    fn new(surface: &TriangleSurface) -> Self {
        let triangles: Vec<[u32; 3]> = surface.triangles().collect();
        Self {
            positions: surface.positions().as_slice().to_vec(),
            origin: surface.topology().vertices().collect(),
            n_original: triangles.len(),
            triangles,
        }
    }

    /// Rows of quads, split by their shorter diagonals.
    fn add(&mut self, boundary: &[VertexId], arcs: &[Arc], width: f64) {
        let n = boundary.len();
        let length = |i: usize| (arcs[i].start - arcs[(i + 1) % n].start).norm();
        let mean = (0..n).map(length).sum::<f64>() / n as f64;
        let rows = ((width / mean.max(f64::MIN_POSITIVE)).round() as usize).clamp(1, MAX_ROWS);
        let mut inner: Vec<u32> = boundary.iter().map(|v| v.index() as u32).collect();
        for row in 1..=rows {
            let first = self.positions.len() as u32;
            let share = row as f64 / rows as f64;
            self.positions
                .extend(arcs.iter().map(|a| a.at(a.length * share)));
            self.origin.extend(boundary);
            let outer: Vec<u32> = (first..first + n as u32).collect();
            for i in 0..n {
                let k = (i + 1) % n;
                self.add_quad([inner[i], outer[i], outer[k], inner[k]]);
            }
            inner = outer;
        }
    }

    fn add_quad(&mut self, [a, b, c, d]: [u32; 4]) {
        let distance =
            |p: u32, q: u32| (self.positions[p as usize] - self.positions[q as usize]).norm();
        let pair = if distance(a, c) <= distance(b, d) {
            [[a, b, c], [a, c, d]]
        } else {
            [[a, b, d], [b, c, d]]
        };
        self.triangles.extend(pair);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cap of the unit sphere down to the height `cos(angle)`, wound with normals outwards.
    fn cap(angle: f64, rings: usize, n: usize) -> TriangleSurface {
        let mut positions = vec![Vec3::z()];
        for r in 1..=rings {
            let t = angle * r as f64 / rings as f64;
            positions.extend((0..n).map(|k| {
                let f = std::f64::consts::TAU * k as f64 / n as f64;
                Vec3::new(t.sin() * f.cos(), t.sin() * f.sin(), t.cos())
            }));
        }
        let id = |r: usize, k: usize| (1 + (r - 1) * n + k % n) as u32;
        let mut triangles: Vec<[u32; 3]> = (0..n).map(|k| [0, id(1, k), id(1, k + 1)]).collect();
        for r in 1..rings {
            for k in 0..n {
                triangles.push([id(r, k), id(r + 1, k), id(r + 1, k + 1)]);
                triangles.push([id(r, k), id(r + 1, k + 1), id(r, k + 1)]);
            }
        }
        TriangleSurface::new(positions, &triangles).unwrap()
    }

    #[test]
    fn a_cap_goes_on_as_a_sphere() {
        let surface = cap(0.8, 24, 60);
        let extended = extend(&surface, 0.2, 0.2).unwrap();
        assert_eq!(extended.n_original, surface.topology().n_faces());
        let outer = extended.surface.positions().as_slice();
        let beyond = &outer[surface.positions().len()..];
        assert!(beyond.iter().all(|p| (p.norm() - 1.0).abs() < 4e-3));
        let lowest = beyond.iter().map(|p| p.z).fold(1.0, f64::min);
        assert!((lowest - 1.0f64.cos()).abs() < 0.01, "{lowest}");
        let (before, after) = (surface.topology(), extended.surface.topology());
        assert_eq!(before.euler_characteristic(), after.euler_characteristic());
        assert_eq!(before.boundary_loops().len(), after.boundary_loops().len());
    }

    /// `rings` rings of `n` cells round a hole, with their corners where `point` says.
    fn annulus(n: usize, rings: usize, point: impl Fn(usize, usize) -> Vec3) -> TriangleSurface {
        let corners = (0..=rings).flat_map(|r| (0..n).map(move |k| (r, k)));
        let positions = corners.map(|(r, k)| point(r, k)).collect();
        let id = |r: usize, k: usize| (r * n + k % n) as u32;
        let cells = (0..rings).flat_map(|r| (0..n).map(move |k| (r, k)));
        let triangles: Vec<[u32; 3]> = cells
            .flat_map(|(r, k)| {
                let [a, b, c, d] = [id(r, k), id(r + 1, k), id(r + 1, k + 1), id(r, k + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect();
        TriangleSurface::new(positions, &triangles).unwrap()
    }

    #[test]
    fn a_hole_without_room_stays() {
        // A flat annulus of radii 0.1 and 1; its normals point up.
        let (n, rings) = (40, 12);
        let radius = |r: usize| 0.1 + 0.9 * r as f64 / rings as f64;
        let angle = |k: usize| std::f64::consts::TAU * k as f64 / n as f64;
        let point = |r: usize, k: usize| Vec3::new(angle(k).cos(), angle(k).sin(), 0.0) * radius(r);
        let surface = annulus(n, rings, point);
        let extended = extend(&surface, 0.01, 0.3).unwrap().surface;
        assert!(
            extended
                .topology()
                .faces()
                .all(|f| extended.area_vector(f).z > 0.0)
        );
        let inner = extended
            .positions()
            .iter()
            .map(|p| p.norm())
            .fold(1.0, f64::min);
        assert_eq!(inner, 0.1);
        let outer = extended
            .positions()
            .iter()
            .map(|p| p.norm())
            .fold(0.0, f64::max);
        assert!((outer - 1.01).abs() < 1e-3, "{outer}");
    }

    #[test]
    fn a_closed_surface_has_nothing_to_extend() {
        let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let closed = TriangleSurface::new(corners, &faces).unwrap();
        assert!(extend(&closed, 0.1, 0.1).is_none());
    }

    /// The unit circle's arcs towards its middle end before they meet.
    #[test]
    fn arcs_in_a_hole_do_not_meet() {
        let point = |r: usize, k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / 40.0;
            Vec3::new(angle.cos(), angle.sin(), 0.0) * (1.0 + r as f64)
        };
        let surface = annulus(40, 2, point);
        let loops = surface.boundary_loops();
        let hole = (loops.iter()).find(|l| surface.positions()[l[0]].norm() < 1.5);
        let mut arcs = arcs(&surface, hole.unwrap(), 3.0);
        let rim: Vec<Vec3> = arcs.iter().map(|a| a.start).collect();
        shorten(&mut arcs, (&rim, 0), 3.0);
        assert!(!has_room(&arcs, 3.0));
        let longest = arcs.iter().map(|a| a.length).fold(0.0, f64::max);
        assert!((longest - CLEAR).abs() < 0.01, "{longest}");
    }

    /// Where a hole is smaller than the grid of normalised coordinates, vertices round it lie on
    /// one another.
    #[test]
    fn a_hole_whose_vertices_lie_on_one_another_is_continued() {
        let place = |r: usize, k: usize| {
            let angle = std::f64::consts::TAU * (if r == 0 { k / 3 } else { k }) as f64 / 12.0;
            let radius = [1e-9, 0.5, 1.0][r];
            Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
        };
        for shrunk in [1.0, 0.0] {
            let point = |r: usize, k: usize| place(r, k) * if r == 0 { shrunk } else { 1.0 };
            let surface = annulus(12, 2, point);
            let extended = extend(&surface, 0.1, 0.1).unwrap().surface;
            let mut coordinates = extended.positions().iter().flatten();
            assert!(coordinates.all(|x| x.is_finite()), "{shrunk}");
        }
    }

    /// Arcs of a row of tips would fan out and cross; on a line through the tips they do not.
    #[test]
    fn the_strip_of_a_toothed_boundary_does_not_fold() {
        let toothed = crate::smooth_surface::teeth::tests::rhomb(true);
        let extension = extend(&toothed, 3.0, 3.0).unwrap();
        let surface = &extension.surface;
        let normal = |f: FaceId| {
            let [a, b, c] = std::array::from_fn(|k| {
                surface.positions()[surface.topology().face_vertices(f)[k]]
            });
            (b - a).cross(&(c - a)).z
        };
        // Away from the corners of the rhomb.
        let beyond_teeth = |f: &FaceId| {
            let corners = surface.topology().face_vertices(*f).iter();
            let mut from = corners.map(|v| toothed.positions()[extension.origin[v.index()]]);
            from.all(|p| p.y < 1.5 && (2.0..7.0).contains(&p.x))
        };
        let added = surface.topology().faces().skip(extension.n_original);
        let added: Vec<FaceId> = added.filter(beyond_teeth).collect();
        assert!(added.len() > 20);
        let folded = added.iter().filter(|f| normal(**f) <= 0.0).count();
        assert_eq!(folded, 0);
    }
}
