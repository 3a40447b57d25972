//! Slivers that are left out.
//!
//! A sliver so narrow that its inner corners lie next to the boundary leaves no gap that counts:
//! where nothing else helps it goes, and the corners, now the ends of edges inside, are brought to
//! the boundary curve with all others.

use super::curve::{Curve, distance_to_segment};
use super::grow::inner_chain;
use super::{Trimmed, compact};
use phex_mesh::{FaceId, PerFace, Vec3};

/// Largest distance between the boundary with a sliver and without it, diagonals.
const GAP: f64 = 3e-3;

/// The mesh without a sliver; `None` where that would show.
pub(super) fn without(trimmed: &Trimmed, sliver: FaceId, curve: &Curve) -> Option<Trimmed> {
    let mesh = &trimmed.mesh;
    let topology = mesh.topology();
    let chain = inner_chain(topology, sliver)?;
    let inner = chain[1..].iter().map(|h| topology.origin(*h));
    let inner: Vec<_> = inner.collect();
    let ends = [
        topology.origin(chain[0]),
        topology.target(chain[chain.len() - 1]),
    ];
    let path = [&ends[..1], &inner, &ends[1..]].concat();
    let path: Vec<Vec3> = path.into_iter().map(|v| mesh.position(v)).collect();
    let gap = GAP * curve.diagonal();
    let to_path = |p: Vec3| {
        let sides = path.windows(2).map(|w| distance_to_segment(p, w[0], w[1]));
        sides.fold(f64::INFINITY, f64::min)
    };
    let to_curve = |p: Vec3| (curve.at(curve.closest(p)) - p).norm();
    let narrow = inner.iter().all(|v| to_curve(mesh.position(*v)) <= gap)
        && mesh.corners(sliver).all(|p| to_path(p) <= gap);
    if !narrow {
        return None;
    }
    let kept: Vec<FaceId> = topology.faces().filter(|f| *f != sliver).collect();
    let lists = topology.face_lists();
    let faces: Vec<Vec<u32>> = kept.iter().map(|f| lists[f.index()].clone()).collect();
    Some(Trimmed {
        mesh: compact(mesh.positions.as_slice(), &faces).ok()?,
        parent: PerFace::from_vec(kept.iter().map(|f| trimmed.parent[*f]).collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::super::dissolve::tests::{square, with_triangle};
    use super::*;

    #[test]
    fn a_narrow_sliver_goes_and_a_deep_one_stays() {
        let curve = Curve::of(&square(), 0.7, 1e-3);
        let left =
            |height: f64| without(&with_triangle(0.2, height, |_| 0.0), FaceId::new(1), &curve);
        let after = left(0.012).unwrap();
        assert_eq!(after.mesh.topology().n_faces(), 2);
        assert_eq!(after.parent.as_slice(), [FaceId::new(0), FaceId::new(2)]);
        assert_eq!(after.mesh.topology().boundary_loops().len(), 1);
        assert!(left(0.015).is_none());
    }
}
