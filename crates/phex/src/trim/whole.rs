//! Whole panels: those that lie mostly inside, with a calm outline.
//!
//! Kept panels `S` have a small sum of what they cover outside, what they leave bare inside, and
//! `lambda` times the length of their outline,
//!
//! ```text
//! E(S) = sum_{p in S} 2 t_p A_p - sum_{p in S} 2 s_p A_p + lambda |outline(S)|,     s the share inside, t its threshold (1/2),
//! ```
//!
//! so that a panel that sticks out alone goes and one that is missing in a notch comes (a Potts
//! model, Boykov, Veksler, Zabih 2001; minimised by single changes, the best first: Besag's
//! iterated conditional modes, 1986). Where too little is covered, the threshold falls.

use super::{Domain, TrimError, Trimmed, compact, near_boundary};
use phex_mesh::{FaceId, FlatFace, HexMesh, PerFace, Vec3, ear_clip};
use rayon::prelude::*;

/// A panel is kept if at least this share of it lies inside.
const KEEP: f64 = 0.5;
/// Share of the surface that is covered at least; where it is not, panels that lie inside less are
/// kept too.
const COVERAGE: f64 = 0.975;
/// Weight of the outline's length, roots of the mean panel area.
const OUTLINE: f64 = 0.25;
/// Step by which the threshold falls while too little is covered.
const THRESHOLD_STEP: f64 = 0.05;
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
    let keep = calm_outline(mesh, &shares, &near);
    let kept: Vec<FaceId> = faces.into_iter().filter(|f| keep[f.index()]).collect();
    let lists = mesh.topology().face_lists();
    let lists: Vec<Vec<u32>> = kept.iter().map(|f| lists[f.index()].clone()).collect();
    Ok(Trimmed {
        mesh: compact(mesh.positions.as_slice(), &lists)?,
        parent: PerFace::from_vec(kept),
    })
}

/// Which panels are kept.
fn calm_outline(mesh: &HexMesh, shares: &[(f64, f64)], near: &[bool]) -> Vec<bool> {
    let total = covered(shares, |_| true);
    let mut threshold = threshold(shares);
    loop {
        let keep = least_energy(mesh, shares, near, threshold);
        let enough = covered(shares, |i| keep[i]) >= COVERAGE * total;
        if enough || threshold <= THRESHOLD_STEP {
            return keep;
        }
        threshold -= THRESHOLD_STEP;
    }
}

/// Area inside of some of the panels.
fn covered(shares: &[(f64, f64)], some: impl Fn(usize) -> bool) -> f64 {
    let inside = shares.iter().enumerate().filter(|(i, _)| some(*i));
    inside.map(|(_, (area, share))| area * share).sum()
}

/// The panels above the threshold, changed one by one as long as that lowers the energy; only those
/// near the boundary may change.
fn least_energy(mesh: &HexMesh, shares: &[(f64, f64)], near: &[bool], threshold: f64) -> Vec<bool> {
    let topology = mesh.topology();
    let mean = shares.iter().map(|s| s.0).sum::<f64>() / shares.len() as f64;
    let lambda = OUTLINE * mean.sqrt();
    let mut keep: Vec<bool> = shares.iter().map(|s| s.1 >= threshold).collect();
    // What a panel's joining or leaving adds to the energy.
    let change = |keep: &[bool], f: FaceId| {
        let (area, share) = shares[f.index()];
        let outline = |h| {
            let [a, b] = [topology.origin(h), topology.target(h)].map(|v| mesh.positions[v]);
            let beside = topology.twin(h).map(|t| topology.face(t));
            let shared = beside.is_some_and(|g| keep[g.index()]);
            (b - a).norm() * if shared { -1.0 } else { 1.0 }
        };
        let longer: f64 = topology.face_half_edges(f).map(outline).sum();
        let join = 2.0 * area * (threshold - share) + lambda * longer;
        if keep[f.index()] { -join } else { join }
    };
    let loose: Vec<FaceId> = topology.faces().filter(|f| near[f.index()]).collect();
    let least = -1e-9 * mean;
    // Each change lowers the energy, so this ends.
    loop {
        let changes = loose.iter().map(|f| (change(&keep, *f), *f));
        match changes.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((by, f)) if by < least => keep[f.index()] = !keep[f.index()],
            _ => return keep,
        }
    }
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

    /// Hexagons of a patch that reach beyond a straight boundary: the lower rows lie inside, the
    /// middle one by half. A tooth goes, a notch is filled.
    #[test]
    fn a_tooth_goes_and_a_notch_is_filled() {
        let mesh = crate::layout::tests::lattice_patch(9).mesh;
        let near = vec![true; 81];
        let share = |tooth: f64, notch: f64| -> Vec<(f64, f64)> {
            let of = |i: usize| match (i / 9, i % 9) {
                (4, 4) => tooth,
                (3, 4) => notch,
                (row, _) => f64::from(u8::from(row < 4)),
            };
            (0..81).map(|i| (0.866, of(i))).collect()
        };
        let kept = |shares: &[(f64, f64)]| {
            let keep = least_energy(&mesh, shares, &near, KEEP);
            (keep[4 * 9 + 4], keep[3 * 9 + 4])
        };
        assert_eq!(kept(&share(0.55, 1.0)), (false, true));
        assert_eq!(kept(&share(0.0, 0.45)), (false, true));
        // What is mostly inside stays, and what is mostly outside is left out.
        assert_eq!(kept(&share(0.9, 1.0)), (true, true));
        assert_eq!(kept(&share(0.0, 0.1)), (false, false));
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
