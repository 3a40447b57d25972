//! Sides of the boundary that run along a family of curves.

use phex_mesh::{FaceId, HalfEdgeId, TriangleSurface, Vec3, VertexId};

/// Turning angle, degrees, at which a side ends.
const CORNER: f64 = 40.0;
/// Angle between boundary and curves, degrees, up to which an edge follows them.
const SLANT: f64 = 12.0;
/// Share of a side's length that must follow them.
const SHARE: f64 = 0.9;

/// Half-edges of all sides that follow the directions `level`.
pub(super) fn followed(
    surface: &TriangleSurface,
    level: impl Fn(FaceId) -> Vec3,
) -> Vec<HalfEdgeId> {
    let topology = surface.topology();
    let edge = |h: HalfEdgeId| {
        surface.positions()[topology.target(h)] - surface.positions()[topology.origin(h)]
    };
    let follows = |h: &&HalfEdgeId| {
        let along = edge(**h).normalize().dot(&level(topology.face(**h)));
        along.abs() > SLANT.to_radians().cos()
    };
    let length =
        |side: &mut dyn Iterator<Item = &HalfEdgeId>| side.map(|&h| edge(h).norm()).sum::<f64>();
    let mut held = Vec::new();
    for side in topology
        .boundary_loops()
        .iter()
        .flat_map(|l| sides(surface, l))
    {
        let following = length(&mut side.iter().filter(follows));
        if following >= SHARE * length(&mut side.iter()) {
            held.extend(side);
        }
    }
    held
}

/// A boundary loop, cut at its corners.
fn sides(surface: &TriangleSurface, boundary: &[VertexId]) -> Vec<Vec<HalfEdgeId>> {
    let topology = surface.topology();
    let n = boundary.len();
    let at = |i: usize| surface.positions()[boundary[i % n]];
    let is_corner = |i: usize| {
        let turning = (at(i + n) - at(i + n - 1)).angle(&(at(i + 1) - at(i)));
        turning > CORNER.to_radians()
    };
    let first = (0..n).find(|&i| is_corner(i)).unwrap_or(0);
    let mut sides: Vec<Vec<HalfEdgeId>> = Vec::new();
    for k in 0..n {
        let i = (first + k) % n;
        if k == 0 || is_corner(i) {
            sides.push(Vec::new());
        }
        // The first half-edge that leaves a boundary vertex lies on the boundary.
        let along = topology.outgoing(boundary[i]).next();
        if let Some(side) = sides.last_mut() {
            side.extend(along);
        }
    }
    sides
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn share_followed(name: &str, level: Vec3) -> f64 {
        let shape = Shape::from_name(name, &[]).unwrap();
        let surface = triangulate(&shape, &TriangulationOptions::default()).unwrap();
        let topology = surface.topology();
        let boundary = topology.boundary_edges();
        followed(&surface, |_| level).len() as f64 / boundary.count() as f64
    }

    #[test]
    fn two_sides_of_a_square_follow_an_axis_and_no_disc_does() {
        assert!((share_followed("plane", Vec3::x()) - 0.5).abs() < 0.1);
        assert_eq!(
            share_followed("plane", Vec3::new(1.0, 1.0, 0.0).normalize()),
            0.0
        );
        assert_eq!(share_followed("elliptic-paraboloid", Vec3::x()), 0.0);
    }
}
