//! A judge of panels that shares no code with the project, so that the two can disagree.
//!
//! Lengths are in mean edges of the mesh unless something else is said. A panel is planar if its
//! corners are at most 1e-12 from its plane of least squares, or what rounding of the coordinates
//! allows; simple if edges that are not neighbours keep clear of one another; a mesh is sound if no
//! panel is flipped against its neighbours, folded onto one, or passed through by an edge of
//! another, and the corners at each inner vertex go round it once.

// Comparisons are written so that a NaN is a fault.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

use crate::raw_mesh::{RawMesh, RawPoint};
use crate::shapes::{cross, difference, dot, length, scaled, sum, unit};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::f64::consts::TAU;

/// Largest distance of a corner to its panel's plane.
const PLANARITY: f64 = 1e-12;
/// Smallest length of an edge, and smallest distance of a corner to another edge of its panel.
const CLEARANCE: f64 = 0.05;
/// What two ways to compute a figure may differ by.
const SLACK: f64 = 1e-9;

type InPlane = [f64; 2];

/// A panel in its plane.
struct JudgedPanel {
    centre: RawPoint,
    normal: RawPoint,
    corners: Vec<InPlane>,
    /// Largest distance of a corner to the plane, model units.
    offset: f64,
}

/// Figures of a mesh that hold without limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceClass {
    /// Vertices less edges, and faces.
    pub euler_characteristic: i64,
    /// Closed curves that the boundary consists of.
    pub boundary_loops: usize,
}

/// Everything that is wrong with panels, in words; nothing for a mesh that is right.
pub fn faults(mesh: &RawMesh) -> Vec<String> {
    let mut found = torn(mesh);
    if !found.is_empty() {
        return found;
    }
    let sides = sides(mesh);
    let mean = mean_edge(mesh, &sides);
    let panels: Vec<JudgedPanel> = mesh.faces.iter().map(|f| panel(mesh, f)).collect();
    let limit = PLANARITY.max(rounding(mesh) / mean);
    for (k, panel) in panels.iter().enumerate() {
        found.extend(wrong_panel(panel, mean, limit).map(|what| format!("face {k}: {what}")));
    }
    found.extend(wrong_vertices(mesh, &sides, &panels));
    found.extend(wrong_neighbours(mesh, &sides, &panels));
    found.extend(crossings(mesh, &sides, &panels));
    found
}

/// Why the faces of a mesh are no oriented manifold; nothing if they are one.
pub fn torn(mesh: &RawMesh) -> Vec<String> {
    let broken = broken_elements(mesh);
    if broken.is_empty() {
        not_manifold(mesh, &sides(mesh))
    } else {
        broken
    }
}

/// The kind of surface that the faces of a mesh are, by counting.
pub fn kind(mesh: &RawMesh) -> SurfaceClass {
    let sides = sides(mesh);
    let edges: BTreeSet<[usize; 2]> = sides.keys().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    let used: BTreeSet<usize> = mesh.faces.iter().flatten().copied().collect();
    let open = sides.keys().filter(|&&[a, b]| !sides.contains_key(&[b, a]));
    let mut next: BTreeMap<usize, usize> = open.map(|&[a, b]| (a, b)).collect();
    let mut boundary_loops = 0;
    while let Some((_, mut at)) = next.pop_first() {
        boundary_loops += 1;
        while let Some(after) = next.remove(&at) {
            at = after;
        }
    }
    SurfaceClass {
        euler_characteristic: used.len() as i64 - edges.len() as i64 + mesh.faces.len() as i64,
        boundary_loops,
    }
}

/// The largest distance of vertices and centres of faces to a surface of triangles, over the
/// diagonal of the surface's bounding box. Points beyond its boundary are left out: how far panels
/// may go there depends on what was asked for.
pub fn deviation(mesh: &RawMesh, surface: &RawMesh) -> f64 {
    let centres = mesh.faces.iter().map(|f| panel(mesh, f).centre);
    let points = mesh.points.iter().copied().chain(centres);
    let sides = sides(surface);
    let open = sides.keys().filter(|&&[a, b]| !sides.contains_key(&[b, a]));
    let rim: Vec<[RawPoint; 2]> = open.map(|s| s.map(|v| surface.points[v])).collect();
    let to = |p: RawPoint| {
        let triangles = surface.faces.iter().flat_map(|f| fan(f));
        let distances = triangles.map(|t| to_triangle(p, t.map(|v| surface.points[v])));
        let least = distances.fold(f64::INFINITY, f64::min);
        let beyond = rim.iter().any(|s| to_side(p, *s) <= least * (1.0 + SLACK));
        if beyond { 0.0 } else { least }
    };
    points.map(to).fold(0.0, f64::max) / diagonal(surface)
}

/// Diagonal of the bounding box.
pub fn diagonal(mesh: &RawMesh) -> f64 {
    let used: BTreeSet<usize> = mesh.faces.iter().flatten().copied().collect();
    let extent = |k: usize| {
        let x = used.iter().map(|&v| mesh.points[v][k]);
        let (low, high) = x.fold((f64::INFINITY, -f64::INFINITY), |(l, h), x| {
            (l.min(x), h.max(x))
        });
        high - low
    };
    length([extent(0), extent(1), extent(2)])
}

fn fan(face: &[usize]) -> Vec<[usize; 3]> {
    let sides = face.windows(2).skip(1);
    sides.map(|s| [face[0], s[0], s[1]]).collect()
}

fn broken_elements(mesh: &RawMesh) -> Vec<String> {
    let mut found = Vec::new();
    if mesh.faces.is_empty() {
        found.push("no faces".to_owned());
    }
    for (k, p) in mesh.points.iter().enumerate() {
        if !p.iter().all(|x| x.is_finite()) {
            found.push(format!("vertex {k} is not finite"));
        }
    }
    for (k, face) in mesh.faces.iter().enumerate() {
        let different: BTreeSet<_> = face.iter().collect();
        if face.len() < 3 || different.len() < face.len() {
            found.push(format!("face {k} has corners {face:?}"));
        }
    }
    let used: BTreeSet<usize> = mesh.faces.iter().flatten().copied().collect();
    if used.len() < mesh.points.len() {
        found.push(format!(
            "{} vertices without faces",
            mesh.points.len() - used.len()
        ));
    }
    found
}

/// The face on the left of each directed side; one of them where there are more.
fn sides(mesh: &RawMesh) -> HashMap<[usize; 2], usize> {
    let of_face = |(k, f): (usize, &Vec<usize>)| {
        let next = f.iter().cycle().skip(1);
        let pairs: Vec<_> = f.iter().zip(next).map(|(&a, &b)| ([a, b], k)).collect();
        pairs
    };
    mesh.faces.iter().enumerate().flat_map(of_face).collect()
}

/// Sides that two faces have in the same direction, and vertices whose faces do not form one fan.
fn not_manifold(mesh: &RawMesh, sides: &HashMap<[usize; 2], usize>) -> Vec<String> {
    let corners: usize = mesh.faces.iter().map(Vec::len).sum();
    if sides.len() < corners {
        return vec![format!("{} sides are used twice", corners - sides.len())];
    }
    let mut fans = vec![0; mesh.points.len()];
    let mut turned: HashMap<usize, BTreeMap<usize, usize>> = HashMap::new();
    for face in &mesh.faces {
        for k in 0..face.len() {
            let (before, after) = (
                face[(k + face.len() - 1) % face.len()],
                face[(k + 1) % face.len()],
            );
            turned.entry(face[k]).or_default().insert(after, before);
        }
    }
    for (v, mut steps) in turned {
        while let Some(start) = first_of_fan(&steps) {
            fans[v] += 1;
            let mut at = start;
            while let Some(next) = steps.remove(&at) {
                at = next;
            }
        }
    }
    let torn = fans.iter().enumerate().filter(|(_, n)| **n > 1);
    torn.map(|(v, n)| format!("vertex {v} joins {n} fans"))
        .collect()
}

/// Where a fan begins: at a side that none ends with, else anywhere.
fn first_of_fan(steps: &BTreeMap<usize, usize>) -> Option<usize> {
    let ends: BTreeSet<&usize> = steps.values().collect();
    let open = steps.keys().find(|k| !ends.contains(k));
    open.or_else(|| steps.keys().next()).copied()
}

fn mean_edge(mesh: &RawMesh, sides: &HashMap<[usize; 2], usize>) -> f64 {
    let edges: BTreeSet<[usize; 2]> = sides.keys().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    let lengths = edges
        .iter()
        .map(|&[a, b]| length(difference(mesh.points[a], mesh.points[b])));
    lengths.sum::<f64>() / edges.len() as f64
}

/// What rounding of coordinates may move a corner by, model units.
fn rounding(mesh: &RawMesh) -> f64 {
    let largest = mesh
        .points
        .iter()
        .flatten()
        .fold(0.0, |m: f64, x| m.max(x.abs()));
    4.0 * f64::EPSILON * diagonal(mesh).max(largest)
}

/// A face in its plane of least squares: the plane of its area vector, tilted once by the linear
/// regression of the heights above it, which is exact for a face that is nearly planar.
fn panel(mesh: &RawMesh, face: &[usize]) -> JudgedPanel {
    let first = mesh.points[face[0]];
    let local: Vec<RawPoint> = face
        .iter()
        .map(|&v| difference(mesh.points[v], first))
        .collect();
    let size = local
        .iter()
        .map(|&p| length(p))
        .fold(f64::MIN_POSITIVE, f64::max);
    let local: Vec<RawPoint> = local.iter().map(|&p| scaled(p, 1.0 / size)).collect();
    let total = local.iter().fold([0.0; 3], |s, &p| sum(s, p));
    let middle = scaled(total, 1.0 / face.len() as f64);
    let centred: Vec<RawPoint> = local.iter().map(|&p| difference(p, middle)).collect();
    let next = centred.iter().cycle().skip(1);
    let pairs = centred.iter().zip(next);
    let area = pairs.fold([0.0; 3], |s, (&a, &b)| sum(s, cross(a, b)));
    let normal = (0..2).fold(upright(area), |n, _| tilted(n, &centred));
    let [a, b] = axes(normal);
    let height = |p: &RawPoint| dot(*p, normal).abs();
    JudgedPanel {
        centre: sum(first, scaled(middle, size)),
        normal,
        corners: centred
            .iter()
            .map(|&p| [size * dot(p, a), size * dot(p, b)])
            .collect(),
        offset: size * centred.iter().map(height).fold(0.0, f64::max),
    }
}

fn upright(area: RawPoint) -> RawPoint {
    if length(area) > 0.0 {
        unit(area)
    } else {
        [0.0, 0.0, 1.0]
    }
}

/// The normal of the plane through the origin that fits points best, from one close to it.
fn tilted(normal: RawPoint, points: &[RawPoint]) -> RawPoint {
    let [a, b] = axes(normal);
    let mut sums = [0.0; 5];
    for &p in points {
        let (x, y, z) = (dot(p, a), dot(p, b), dot(p, normal));
        for (total, term) in sums.iter_mut().zip([x * x, x * y, y * y, x * z, y * z]) {
            *total += term;
        }
    }
    let [xx, xy, yy, xz, yz] = sums;
    let determinant = xx * yy - xy * xy;
    if determinant <= 1e-14 * (xx + yy).powi(2) {
        return normal;
    }
    let slopes = [
        (yy * xz - xy * yz) / determinant,
        (xx * yz - xy * xz) / determinant,
    ];
    let tilt = sum(scaled(a, slopes[0]), scaled(b, slopes[1]));
    unit(difference(normal, tilt))
}

/// Two unit vectors across a normal that make a right-handed frame with it.
fn axes(normal: RawPoint) -> [RawPoint; 2] {
    let away = if normal[0].abs() < 0.8 {
        [1.0, 0.0, 0.0]
    } else {
        [0.0, 1.0, 0.0]
    };
    let a = unit(cross(normal, away));
    [a, cross(normal, a)]
}

fn wrong_panel(panel: &JudgedPanel, mean: f64, planarity: f64) -> Option<String> {
    let offset = panel.offset / mean;
    if !(offset <= planarity * (1.0 + SLACK)) {
        return Some(format!("planarity {offset:.2e}, at most {planarity:.2e}"));
    }
    let n = panel.corners.len();
    let side = |k: usize| [panel.corners[k], panel.corners[(k + 1) % n]];
    let apart = |i: usize, j: usize| (i + 1) % n != j && (j + 1) % n != i && i != j;
    let limit = CLEARANCE * mean * (1.0 - SLACK);
    for i in 0..n {
        let [a, b] = side(i);
        if !(gap(a, b) >= limit) {
            return Some(format!("side {i} has length {:.3}", gap(a, b) / mean));
        }
        if (0..i).any(|j| apart(i, j) && touch(side(i), side(j))) {
            return Some(format!("it is not simple at side {i}"));
        }
        let others = (0..n).filter(|&j| j != i && (j + 1) % n != i);
        let clearance = others
            .map(|j| to_segment(a, side(j)))
            .fold(f64::INFINITY, f64::min);
        if !(clearance >= limit) {
            return Some(format!("corner {i} has clearance {:.3}", clearance / mean));
        }
    }
    None
}

fn gap(a: InPlane, b: InPlane) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Twice the signed area of a triangle; 0 where rounding decides about its sign.
fn turn(a: InPlane, b: InPlane, c: InPlane) -> f64 {
    let left = (b[0] - a[0]) * (c[1] - a[1]);
    let right = (b[1] - a[1]) * (c[0] - a[0]);
    let bound = 4.0 * f64::EPSILON * (left.abs() + right.abs());
    if (left - right).abs() <= bound {
        0.0
    } else {
        left - right
    }
}

/// Whether two segments have a point in common, or rounding allows that they do.
fn touch([a, b]: [InPlane; 2], [c, d]: [InPlane; 2]) -> bool {
    let overlap =
        (0..2).all(|k| a[k].max(b[k]) >= c[k].min(d[k]) && c[k].max(d[k]) >= a[k].min(b[k]));
    let crosses = |p, q, r, s| {
        turn(p, q, r).signum() * turn(p, q, s).signum() <= 0.0
            || turn(p, q, r) == 0.0
            || turn(p, q, s) == 0.0
    };
    overlap && crosses(a, b, c, d) && crosses(c, d, a, b)
}

fn to_segment(p: InPlane, [a, b]: [InPlane; 2]) -> f64 {
    let (d, e) = ([p[0] - a[0], p[1] - a[1]], [b[0] - a[0], b[1] - a[1]]);
    let t = (d[0] * e[0] + d[1] * e[1]) / (e[0] * e[0] + e[1] * e[1]);
    let t = t.clamp(0.0, 1.0);
    gap(p, [a[0] + t * e[0], a[1] + t * e[1]])
}

/// Inner vertices without three faces, or with faces that do not go round them once, and vertices
/// of the boundary round which two faces go more than once.
fn wrong_vertices(
    mesh: &RawMesh,
    sides: &HashMap<[usize; 2], usize>,
    panels: &[JudgedPanel],
) -> Vec<String> {
    let open = sides.keys().filter(|&&[a, b]| !sides.contains_key(&[b, a]));
    let boundary: BTreeSet<usize> = open.flatten().copied().collect();
    let mut corners: BTreeMap<usize, Vec<[usize; 3]>> = BTreeMap::new();
    for (k, f) in mesh.faces.iter().enumerate() {
        for i in 0..f.len() {
            let (before, after) = (f[(i + f.len() - 1) % f.len()], f[(i + 1) % f.len()]);
            corners.entry(f[i]).or_default().push([k, after, before]);
        }
    }
    let fault = |(&v, around): (&usize, &Vec<[usize; 3]>)| {
        let inside = !boundary.contains(&v);
        if inside && around.len() != 3 {
            return Some(format!("vertex {v} has {} faces", around.len()));
        }
        let turns = turns(mesh, panels, v, around);
        let wrong = match inside {
            true => !((turns - 1.0).abs() <= 1e-6),
            false => around.len() == 2 && !(turns <= 1.0 + 1e-9),
        };
        wrong.then(|| format!("the corners at vertex {v} go round it {turns:.3} times"))
    };
    corners.iter().filter_map(fault).collect()
}

fn turns(mesh: &RawMesh, panels: &[JudgedPanel], v: usize, around: &[[usize; 3]]) -> f64 {
    let normal = around
        .iter()
        .fold([0.0; 3], |s, c| sum(s, panels[c[0]].normal));
    let [a, b] = axes(upright(normal));
    let direction = |w: usize| {
        let d = difference(mesh.points[w], mesh.points[v]);
        dot(d, b).atan2(dot(d, a))
    };
    let angle = |c: &[usize; 3]| (direction(c[2]) - direction(c[1])).rem_euclid(TAU);
    around.iter().map(angle).sum::<f64>() / TAU
}

/// Faces against the mean of their neighbours, and edges across which normals turn by more than a
/// right angle.
fn wrong_neighbours(
    mesh: &RawMesh,
    sides: &HashMap<[usize; 2], usize>,
    panels: &[JudgedPanel],
) -> Vec<String> {
    let mut found = Vec::new();
    for (k, f) in mesh.faces.iter().enumerate() {
        let next = f.iter().cycle().skip(1);
        let others = f.iter().zip(next).filter_map(|(&a, &b)| sides.get(&[b, a]));
        let others: Vec<usize> = others.copied().collect();
        let mean = others
            .iter()
            .fold([0.0; 3], |s, &g| sum(s, panels[g].normal));
        if dot(mean, panels[k].normal) < -SLACK {
            found.push(format!("face {k} is flipped against its neighbours"));
        }
        let folded = others.iter().filter(|&&g| g > k);
        let folded = folded.filter(|&&g| dot(panels[g].normal, panels[k].normal) < -SLACK);
        found.extend(folded.map(|g| format!("faces {k} and {g} are folded onto each other")));
    }
    found
}

/// Edges that pass through a face of which they have no vertex.
fn crossings(
    mesh: &RawMesh,
    sides: &HashMap<[usize; 2], usize>,
    panels: &[JudgedPanel],
) -> Vec<String> {
    let edges: BTreeSet<[usize; 2]> = sides.keys().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
    let mut found = Vec::new();
    for &[a, b] in &edges {
        for (k, face) in mesh.faces.iter().enumerate() {
            let apart = !face.contains(&a) && !face.contains(&b);
            if apart && passes([mesh.points[a], mesh.points[b]], &panels[k]) {
                found.push(format!("the edge {a} {b} passes through face {k}"));
            }
        }
    }
    found
}

/// Whether a segment passes through the inside of a planar polygon, away from its rim.
fn passes(segment: [RawPoint; 2], panel: &JudgedPanel) -> bool {
    let [p, q] = segment.map(|p| difference(p, panel.centre));
    let (below, above) = (dot(p, panel.normal), dot(q, panel.normal));
    let near = SLACK * (length(p) + length(q)) + 2.0 * panel.offset;
    if below * above >= 0.0 || below.abs() < near || above.abs() < near {
        return false;
    }
    let t = below / (below - above);
    let meet = sum(p, scaled(difference(q, p), t));
    let [x, y] = axes(panel.normal);
    let at = [dot(meet, x), dot(meet, y)];
    let n = panel.corners.len();
    let side = |k: usize| [panel.corners[k], panel.corners[(k + 1) % n]];
    let rim = (0..n)
        .map(|k| to_segment(at, side(k)))
        .fold(f64::INFINITY, f64::min);
    rim > near && (0..n).filter(|&k| is_left_of(at, side(k))).count() % 2 == 1
}

/// Whether a ray to the right meets a segment.
fn is_left_of(p: InPlane, [a, b]: [InPlane; 2]) -> bool {
    let spans = (a[1] > p[1]) != (b[1] > p[1]);
    spans && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
}

/// Distance of a point to a triangle in space.
fn to_triangle(p: RawPoint, [a, b, c]: [RawPoint; 3]) -> f64 {
    let normal = cross(difference(b, a), difference(c, a));
    let side = |from: RawPoint, to: RawPoint| {
        dot(cross(difference(to, from), difference(p, from)), normal)
    };
    let inside =
        length(normal) > 0.0 && side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0;
    if inside {
        return dot(difference(p, a), unit(normal)).abs();
    }
    let to = |p, a, b| to_side(p, [a, b]);
    to(p, a, b).min(to(p, b, c)).min(to(p, c, a))
}

/// Distance of a point to a segment in space.
fn to_side(p: RawPoint, [from, to]: [RawPoint; 2]) -> f64 {
    let along = difference(to, from);
    let t = dot(difference(p, from), along) / dot(along, along).max(f64::MIN_POSITIVE);
    length(difference(p, sum(from, scaled(along, t.clamp(0.0, 1.0)))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{grid, octahedron, sphere, torus};

    /// A prism with six sides, whose vertices all have three faces.
    fn prism() -> RawMesh {
        let ring = |z: f64| {
            (0..6).map(move |k| {
                let (sin, cos) = (TAU * f64::from(k) / 6.0).sin_cos();
                [cos, sin, z]
            })
        };
        let side = |k: usize| vec![k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k];
        let mut faces: Vec<Vec<usize>> = (0..6).map(side).collect();
        faces.push((0..6).rev().collect());
        faces.push((6..12).collect());
        RawMesh {
            points: ring(0.0).chain(ring(1.3)).collect(),
            faces,
        }
    }

    fn faults_of(change: impl FnOnce(&mut RawMesh)) -> String {
        let mut mesh = prism();
        change(&mut mesh);
        faults(&mesh).join("; ")
    }

    #[test]
    fn right_meshes_have_no_faults() {
        assert_eq!(faults(&prism()), [""; 0]);
        let moved = prism().mapped(|p| p.map(|x| 3e5 * x + 1e6));
        assert_eq!(faults(&moved), [""; 0]);
    }

    #[test]
    fn each_fault_is_found() {
        assert!(faults_of(|m| m.points[0][0] += 1e-9).contains("planarity"));
        assert!(faults_of(|m| m.points[0][0] = f64::NAN).contains("finite"));
        assert!(faults_of(|m| m.faces[0].reverse()).contains("used twice"));
        assert!(faults_of(|m| m.faces[0].push(0)).contains("corners"));
        assert!(faults_of(|m| m.points.push([0.0; 3])).contains("without faces"));
        assert!(
            faults_of(|m| m.points.iter_mut().for_each(|p| p[2] *= 0.01)).contains("clearance")
        );
        let octahedron = faults(&octahedron()).join("; ");
        assert!(octahedron.contains("has 4 faces"), "{octahedron}");
    }

    /// Two corners of both hexagons change places: they stay planar and cross themselves.
    #[test]
    fn a_polygon_that_crosses_itself_is_found() {
        let found = faults_of(|m| {
            m.points.swap(1, 2);
            m.points.swap(7, 8);
        });
        assert!(found.contains("not simple"), "{found}");
    }

    #[test]
    fn a_vertex_with_two_fans_is_found() {
        let touching = prism().beside(&prism().mapped(|p| [p[0] + 2.0, p[1], p[2]]));
        let mut joined = touching;
        joined.faces.iter_mut().flatten().for_each(|v| {
            if *v == 15 {
                *v = 0
            }
        });
        let joined = joined.without_unused();
        assert!(faults(&joined).join("; ").contains("joins 2 fans"));
    }

    #[test]
    fn a_spike_through_another_panel_is_found() {
        let small = prism().mapped(|p| [0.3 * p[0], 0.3 * p[1], 5.0 * p[2] - 2.0]);
        let found = faults(&prism().beside(&small)).join("; ");
        assert!(found.contains("passes through face"), "{found}");
    }

    #[test]
    fn kinds_of_surfaces_are_counted() {
        let of = |m: &RawMesh| (kind(m).euler_characteristic, kind(m).boundary_loops);
        assert_eq!(of(&sphere(2)), (2, 0));
        assert_eq!(of(&torus([8, 6], 2.0, 1.0)), (0, 0));
        let pipe = grid([6, 3], [true, false], |u, v| [u, v, 0.0]);
        assert_eq!(of(&pipe), (0, 2));
    }

    #[test]
    fn distances_to_triangles_are_those_to_the_nearest_point() {
        let surface = RawMesh::triangles(
            vec![[0.0; 3], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]],
            &[[0, 1, 2]],
        );
        let lone = |p: RawPoint| RawMesh {
            points: vec![p],
            faces: Vec::new(),
        };
        let far = |p| 5.0 * deviation(&lone(p), &surface);
        assert!((far([1.0, 1.0, 2.0]) - 2.0).abs() < 1e-12);
        // Below the corner, but beyond the boundary.
        assert_eq!(far([-3.0, -4.0, 0.1]), 0.0);
    }
}
