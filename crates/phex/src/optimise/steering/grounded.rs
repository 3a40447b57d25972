//! Vertices that lie on the boundary of the surface and that the user keeps in a plane: they keep
//! to both, as far as panels can.

use crate::optimise::holds::{Hold, Holds, in_plane};
use phex_mesh::{BoundaryCurve, HexMesh, Vec3, VertexId};
use std::collections::BTreeMap;

/// Keeps vertices on the boundary as well, in the planes that hold them: corners at corners, others
/// along the curve. Whatever else the user holds comes first.
pub(in crate::optimise) fn keep_rim(
    holds: &mut Holds,
    mesh: &HexMesh,
    held: &BTreeMap<u32, Hold>,
    curves: &BoundaryCurve,
) {
    let both = |(&v, &hold): (&u32, &Hold)| match holds.held.get(&v) {
        None => (v, hold),
        Some(&Hold::InPlane { point, normal }) => {
            let (v_id, plane) = (VertexId::new(v), (point, normal));
            let kept = match spans(holds, mesh, v_id) {
                false => within(hold, mesh.position(v_id), plane, curves),
                true => over(hold, plane),
            };
            (v, kept)
        }
        Some(own) => (v, *own),
    };
    let both: Vec<(u32, Hold)> = held.iter().map(both).collect();
    holds.held.extend(both);
    holds.rim = Some(curves.clone());
}

/// Whether a vertex is the corner of a single panel, between two others in the plane: with all
/// three of them in it the panel would lie flat, or have them in a line.
fn spans(holds: &Holds, mesh: &HexMesh, v: VertexId) -> bool {
    let stands = |n: &VertexId| {
        matches!(
            holds.held.get(&(n.index() as u32)),
            Some(Hold::InPlane { .. })
        )
    };
    mesh.topology().face_degree(v) == 1 && mesh.topology().neighbours(v).iter().all(stands)
}

/// Over a corner of the boundary, as high as its panel wants it; others stay in the plane.
fn over(hold: Hold, (point, normal): (Vec3, Vec3)) -> Hold {
    match hold {
        Hold::At(point) | Hold::OnLine { point, .. } => Hold::OnLine {
            point,
            direction: normal,
        },
        _ => Hold::InPlane { point, normal },
    }
}

/// What holds a vertex at `p` on the boundary, in a plane.
fn within(hold: Hold, p: Vec3, (point, normal): (Vec3, Vec3), curves: &BoundaryCurve) -> Hold {
    let place = in_plane(p, point, normal);
    let tangent = curves.closest_point(p).tangent;
    let along = (tangent - normal * normal.dot(&tangent)).try_normalize(f64::MIN_POSITIVE);
    match (hold, along) {
        (Hold::OnRim, Some(direction)) => Hold::OnLine {
            point: place,
            direction,
        },
        _ => Hold::At(place),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    /// Four squares on the square `[0, 2]^2`, in the plane `z = 0.1`.
    fn squares() -> (HexMesh, BoundaryCurve) {
        let at = |v: u32| Vec3::new(f64::from(v % 3), f64::from(v / 3), 0.1);
        let faces = [0, 1, 3, 4].map(|a| [a, a + 1, a + 4, a + 3]);
        let outline = [0, 2, 8, 6, 0].map(at).to_vec();
        let mesh = HexMesh::new((0..9).map(at).collect(), &faces).unwrap();
        (mesh, BoundaryCurve::of_polylines(&[outline]).unwrap())
    }

    #[test]
    fn corners_of_single_panels_stay_over_their_corners_and_others_on_the_boundary() {
        let (mesh, curves) = squares();
        let (point, normal) = (Vec3::zeros(), Vec3::z());
        let stands = |v: u32| (v, Hold::InPlane { point, normal });
        // All but one vertex in the middle of a side stand on the ground.
        let mut holds = Holds {
            held: [0, 1, 2, 3, 6, 7, 8].map(stands).into(),
            ..Holds::default()
        };
        let at = |v: u32| (v, Hold::At(mesh.position(VertexId::new(v))));
        let mut held: BTreeMap<u32, Hold> = [0, 2, 6, 8].map(at).into();
        held.extend([1, 3, 5, 7].map(|v| (v, Hold::OnRim)));
        keep_rim(&mut holds, &mesh, &held, &curves);
        let over = Hold::OnLine {
            point: Vec3::new(0.0, 0.0, 0.1),
            direction: normal,
        };
        assert_eq!(holds.held[&0], over);
        assert_eq!(holds.held[&2], Hold::At(Vec3::new(2.0, 0.0, 0.0)));
        let along = Hold::OnLine {
            point: Vec3::new(1.0, 0.0, 0.0),
            direction: Vec3::x(),
        };
        assert_eq!(holds.held[&1], along);
        assert_eq!(holds.held[&5], Hold::OnRim);
    }
}
