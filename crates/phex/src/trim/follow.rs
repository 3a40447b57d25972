//! Corners that panels get where the boundary curve stands off from their edges along it.
//!
//! They lie in the plane of their panel, over the curve, so the panel stays planar. An edge gets
//! those of them with which its panel stays simple and keeps some clearance.

use super::curve::OutlineLoops;
use phex_mesh::{FacePlane, HalfEdgeId, HexMesh, TriangleSurface, Vec3, polygon};

/// Largest distance between the curve and an edge along it, over the largest that is allowed.
const OF_LIMIT: f64 = 0.5;

/// Clearance, mean edges, that panels keep which get corners.
const ROOM: f64 = 0.06;

/// Largest share of the distance between curve and edge that a new corner leaves.
const GAIN: f64 = 0.7;

/// The mesh with more corners along the boundary of `surface`; vertices where that turns by more
/// than `corner_angle`, radians, become corners of a panel where they are not yet. Edges are to
/// stay within `limit` diagonals of it.
pub(crate) fn followed(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    corner_angle: f64,
    limit: f64,
) -> Option<HexMesh> {
    let topology = mesh.topology();
    let curve = OutlineLoops::of(surface, corner_angle, OF_LIMIT * limit);
    let room = ROOM * mesh.mean_edge();
    let mut positions = mesh.positions.as_slice().to_vec();
    let mut faces = topology.face_lists();
    let rim = topology
        .half_edges()
        .filter(|h| topology.twin(*h).is_none());
    for h in rim.collect::<Vec<HalfEdgeId>>() {
        let [from, to] = [topology.origin(h), topology.target(h)];
        let (begin, end) = (mesh.position(from), mesh.position(to));
        let way = curve.between(curve.closest(begin), curve.closest(end), begin, end);
        if way.is_empty() {
            continue;
        }
        let f = topology.face(h);
        let plane = FacePlane::of(mesh, f);
        // Where the curve leaves the plane, corners in the plane bring nothing.
        let gains = |p: &Vec3| {
            plane.height(*p).abs() < GAIN * polygon::point_segment_distance(*p, begin, end)
        };
        let first = positions.len();
        let over = way.into_iter().filter(gains);
        let mut new: Vec<Vec3> = over.map(|p| p - plane.normal * plane.height(p)).collect();
        let face = &faces[f.index()];
        let at = face.iter().position(|v| *v == from.index() as u32)?;
        let outline: Vec<Vec3> = face.iter().map(|v| positions[*v as usize]).collect();
        keep_sound(&outline, at, &mut new, &plane, room);
        let numbers = first as u32..(first + new.len()) as u32;
        positions.extend(new);
        faces[f.index()].splice(at + 1..at + 1, numbers);
    }
    let grown = positions.len() > mesh.positions.len();
    grown
        .then(|| HexMesh::new(positions, &faces).ok())
        .flatten()
}

/// Takes out of new corners after the `at`-th of an outline those without which the panel is simple
/// and keeps a clearance: that of the closest pair of a corner and an edge each time.
fn keep_sound(outline: &[Vec3], at: usize, new: &mut Vec<Vec3>, plane: &FacePlane, room: f64) {
    let flat = |points: &[Vec3]| -> Vec<_> { points.iter().map(|p| plane.project(*p)).collect() };
    let least = room.min(polygon::clearance(&flat(outline)));
    while !new.is_empty() {
        let longer = [&outline[..=at], new, &outline[at + 1..]].concat();
        let points = flat(&longer);
        let closest = polygon::closest_corner_and_edge(&points);
        let tight = closest.filter(|c| c.distance < least);
        let sound = polygon::is_simple(&points) && polygon::signed_area(&points) > 0.0;
        if tight.is_none() && sound {
            return;
        }
        let n = points.len();
        let pair = tight
            .into_iter()
            .flat_map(|c| [c.corner, c.edge, (c.edge + 1) % n]);
        let among = |k: &usize| (at + 1..=at + new.len()).contains(k);
        match pair.into_iter().find(among) {
            Some(k) => drop(new.remove(k - at - 1)),
            None => new.clear(),
        }
    }
}

/// Whether a face is simple and wound the right way in a plane.
pub(super) fn is_simple(face: &[u32], positions: &[Vec3], plane: &FacePlane) -> bool {
    let points: Vec<_> = face
        .iter()
        .map(|v| plane.project(positions[*v as usize]))
        .collect();
    face.len() >= 3 && polygon::is_simple(&points) && polygon::signed_area(&points) > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::boundary_fit;
    use std::f64::consts::TAU;

    /// A disc of radius 1 and four panels in it with their outer corners on the circle.
    fn disc() -> (HexMesh, TriangleSurface) {
        let n = 64;
        let at = |i: usize, of: usize| {
            let (s, c) = (TAU * i as f64 / of as f64).sin_cos();
            Vec3::new(c, s, 0.0)
        };
        let fan = |n: usize| (0..n).map(move |i| [0, 1 + i as u32, 1 + ((i + 1) % n) as u32]);
        let points = |n: usize| std::iter::once(Vec3::zeros()).chain((0..n).map(move |i| at(i, n)));
        let surface = TriangleSurface::new(points(n).collect(), &fan(n).collect::<Vec<_>>());
        let mesh = HexMesh::new(points(4).collect(), &fan(4).collect::<Vec<_>>());
        (mesh.unwrap(), surface.unwrap())
    }

    #[test]
    fn corners_that_leave_no_room_are_left_out_and_others_stay() {
        let p = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let square = [p(0.0, 0.0), p(1.0, 0.0), p(1.0, 1.0), p(0.0, 1.0)];
        let plane = FacePlane::fit(&square);
        let kept = |mut new: Vec<Vec3>| {
            keep_sound(&square, 0, &mut new, &plane, 0.06);
            new
        };
        let beside = [p(0.2, -0.1), p(0.8, -0.1)];
        let with = |middle: Vec3| kept(vec![beside[0], middle, beside[1]]);
        assert_eq!(with(p(0.5, 0.97)), beside);
        assert_eq!(with(p(0.5, 0.9)).len(), 3);
        // A way back and forth over the edge crosses itself.
        assert!(kept(vec![p(0.9, -0.3), p(0.1, -0.3), p(0.5, 0.5)]).is_empty());
    }

    #[test]
    fn edges_that_cut_off_a_curve_get_corners_on_it() {
        let (mesh, surface) = disc();
        let before = boundary_fit(&mesh, &surface).unwrap();
        assert!(before.distance_max() > 0.1);
        let followed = followed(&mesh, &surface, 0.7, 5e-3).unwrap();
        assert_eq!(followed.topology().n_faces(), 4);
        let after = boundary_fit(&followed, &surface).unwrap();
        assert!(after.distance_max() <= OF_LIMIT * 5e-3 && after.vertices_max < 1e-12);
        assert!(super::followed(&followed, &surface, 0.7, 5e-3).is_none());
        let nearer = super::followed(&mesh, &surface, 0.7, 2e-3).unwrap();
        assert!(boundary_fit(&nearer, &surface).unwrap().distance_max() <= OF_LIMIT * 2e-3);
    }
}
