//! Whole panels: those that lie mostly inside.

use super::{Domain, TrimError, Trimmed, compact, near_boundary};
use phex_mesh::{FaceId, FlatFace, HexMesh, PerFace, Vec3, ear_clip};
use rayon::prelude::*;

/// A panel is kept if at least this share of it lies inside.
const KEEP: f64 = 0.5;
/// Share of the surface that is covered at least; where it is not, panels that lie inside less are kept too.
const COVERAGE: f64 = 0.975;
/// Each triangle of a panel is sampled at the square of this number of points.
const SAMPLES: usize = 5;

/// The panels that are kept whole.
pub(super) fn whole_panels(mesh: &HexMesh, domain: &Domain<'_>) -> Result<Trimmed, TrimError> {
    let near = near_boundary(mesh, domain.original);
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    // Area and share inside.
    let shares: Vec<(f64, f64)> = faces
        .par_iter()
        .map(|&f| share_inside(mesh, domain, f, near[f.index()]))
        .collect();
    let threshold = threshold(&shares);
    let kept: Vec<FaceId> = faces
        .into_iter()
        .filter(|f| shares[f.index()].1 >= threshold)
        .collect();
    let lists = mesh.topology().face_lists();
    let lists: Vec<Vec<u32>> = kept.iter().map(|f| lists[f.index()].clone()).collect();
    Ok(Trimmed {
        mesh: compact(mesh.positions.as_slice(), &lists)?,
        parent: PerFace::from_vec(kept),
    })
}

/// Least share inside of a panel that is kept.
fn threshold(shares: &[(f64, f64)]) -> f64 {
    let total: f64 = shares.iter().map(|(area, share)| area * share).sum();
    let mut sorted = shares.to_vec();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut covered = 0.0;
    for (area, share) in sorted {
        covered += area * share;
        if covered >= COVERAGE * total {
            return share.clamp(1e-9, KEEP);
        }
    }
    KEEP
}

fn share_inside(mesh: &HexMesh, domain: &Domain<'_>, f: FaceId, near: bool) -> (f64, f64) {
    let corners: Vec<Vec3> = mesh.corners(f).collect();
    let flat = FlatFace::new(&corners);
    if !near {
        let inside = domain.contains(mesh.centre(f));
        return (flat.area(), f64::from(u8::from(inside)));
    }
    let (mut inside, mut total) = (0.0, 0.0);
    for [a, b, c] in ear_clip(&flat.polygon).unwrap_or_default() {
        let [a, b, c] = [corners[a], corners[b], corners[c]];
        let area = (b - a).cross(&(c - a)).norm();
        let points = samples();
        let hits = points
            .iter()
            .filter(|[u, v]| domain.contains(a + (b - a) * *u + (c - a) * *v));
        inside += area * hits.count() as f64 / points.len() as f64;
        total += area;
    }
    (flat.area(), if total > 0.0 { inside / total } else { 0.0 })
}

/// Centroids of the triangles into which a triangle is divided.
fn samples() -> Vec<[f64; 2]> {
    let n = SAMPLES;
    let mut points = Vec::with_capacity(n * n);
    for i in 0..n {
        for j in 0..n - i {
            let at = |shift: f64| [i, j].map(|k| (k as f64 + shift) / n as f64);
            points.push(at(1.0 / 3.0));
            if i + j + 1 < n {
                points.push(at(2.0 / 3.0));
            }
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_triangle() {
        let points = samples();
        assert_eq!(points.len(), SAMPLES * SAMPLES);
        assert!(
            points
                .iter()
                .all(|[u, v]| *u > 0.0 && *v > 0.0 && u + v < 1.0)
        );
        for k in 0..2 {
            let mean = points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
            assert!((mean - 1.0 / 3.0).abs() < 1e-12);
        }
    }

    #[test]
    fn threshold_falls_until_enough_is_covered() {
        let inside = (1.0, 1.0);
        assert_eq!(threshold(&[inside; 100]), KEEP);
        // A quarter of what there is lies in panels that are inside by 0.3 only.
        let shares: Vec<(f64, f64)> = (0..90).map(|_| inside).chain([(1.0, 0.3); 100]).collect();
        assert_eq!(threshold(&shares), 0.3);
    }
}
