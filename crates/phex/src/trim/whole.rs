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

use super::{Domain, TrimError, Trimmed, near_boundary, part};
use phex_mesh::{FaceId, FlatFace, HexMesh, PerFace, Vec3, ear_clip};
use rayon::prelude::*;

/// A panel is kept if at least this share of it lies inside.
const KEEP: f64 = 0.5;
/// Share of the surface that is covered at least; where it is not, panels that lie inside less are
/// kept too. It is more than the check `covered_area` asks for, since panels are still moved.
const COVERAGE: f64 = 0.975;
/// Weight of the outline's length, roots of the mean panel area.
const OUTLINE: f64 = 0.25;
/// Step by which the threshold falls while too little is covered.
const THRESHOLD_STEP: f64 = 0.05;
/// Each triangle of a panel is sampled at the square of this number of points.
const SAMPLES: usize = 5;

/// How a panel lies.
struct Lie {
    area: f64,
    /// Share of it that lies inside.
    inside: f64,
}

/// The panels that are kept whole.
pub(super) fn whole_panels(mesh: &HexMesh, domain: &Domain<'_>) -> Result<Trimmed, TrimError> {
    let near = near_boundary(mesh, domain.original);
    let faces: Vec<FaceId> = mesh.topology().faces().collect();
    let lies: Vec<Lie> = faces
        .par_iter()
        .map(|&f| lie(mesh, domain, f, near[f.index()]))
        .collect();
    let keep = calm_outline(mesh, &lies, &near);
    let kept: Vec<FaceId> = faces.into_iter().filter(|f| keep[f.index()]).collect();
    Ok(Trimmed {
        mesh: part(mesh, &kept)?,
        parent: PerFace::from_vec(kept),
    })
}

/// Which panels are kept, so that enough is covered.
fn calm_outline(mesh: &HexMesh, lies: &[Lie], near: &[bool]) -> Vec<bool> {
    let total = covered(lies, |_| true);
    let mut threshold = threshold(lies);
    loop {
        let keep = least_energy(mesh, lies, near, threshold);
        let enough = covered(lies, |i| keep[i]) >= COVERAGE * total;
        if enough || threshold <= THRESHOLD_STEP {
            return keep;
        }
        threshold -= THRESHOLD_STEP;
    }
}

/// Area inside of some of the panels.
fn covered(lies: &[Lie], some: impl Fn(usize) -> bool) -> f64 {
    let inside = lies.iter().enumerate().filter(|(i, _)| some(*i));
    inside.map(|(_, lie)| lie.area * lie.inside).sum()
}

/// The panels above the threshold, changed one by one as long as that lowers the energy; only those
/// near the boundary may change.
fn least_energy(mesh: &HexMesh, lies: &[Lie], near: &[bool], threshold: f64) -> Vec<bool> {
    let topology = mesh.topology();
    let mean = lies.iter().map(|l| l.area).sum::<f64>() / lies.len() as f64;
    let lambda = OUTLINE * mean.sqrt();
    let mut keep: Vec<bool> = lies.iter().map(|l| l.inside >= threshold).collect();
    // What a panel's joining or leaving adds to the energy.
    let change = |keep: &[bool], f: FaceId| {
        let Lie { area, inside } = lies[f.index()];
        let outline = |h| {
            let [a, b] = [topology.origin(h), topology.target(h)].map(|v| mesh.positions[v]);
            let shared = topology.across(h).is_some_and(|g| keep[g.index()]);
            (b - a).norm() * if shared { -1.0 } else { 1.0 }
        };
        let longer: f64 = topology.face_half_edges(f).map(outline).sum();
        let join = 2.0 * area * (threshold - inside) + lambda * longer;
        if keep[f.index()] { -join } else { join }
    };
    let loose = |f: &FaceId| near[f.index()];
    let mut changes = PerFace::filled(lies.len(), f64::INFINITY);
    for f in topology.faces().filter(loose) {
        changes[f] = change(&keep, f);
    }
    let least = -1e-9 * mean;
    // Each change lowers the energy, so this ends.
    loop {
        let best = changes.enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        let Some((f, _)) = best.filter(|(_, by)| **by < least) else {
            return keep;
        };
        keep[f.index()] = !keep[f.index()];
        for g in topology.adjacent_faces(f).chain([f]).filter(loose) {
            changes[g] = change(&keep, g);
        }
    }
}

/// Least share inside of a panel that is kept.
fn threshold(lies: &[Lie]) -> f64 {
    let total = covered(lies, |_| true);
    let mut sorted: Vec<&Lie> = lies.iter().collect();
    sorted.sort_by(|a, b| b.inside.total_cmp(&a.inside));
    let mut reached = 0.0;
    for lie in sorted {
        reached += lie.area * lie.inside;
        if reached >= COVERAGE * total {
            return lie.inside.clamp(1e-9, KEEP);
        }
    }
    KEEP
}

/// How a panel lies; `near` tells whether the boundary may cross it.
fn lie(mesh: &HexMesh, domain: &Domain<'_>, f: FaceId, near: bool) -> Lie {
    let corners: Vec<Vec3> = mesh.corners(f).collect();
    let flat = FlatFace::new(&corners);
    let (mut inside, mut total) = (0.0, 0.0);
    let samples = match near {
        true => samples_of(&flat, &corners),
        false => vec![(mesh.centre(f), 1.0)],
    };
    for (p, weight) in samples {
        total += weight;
        if domain.contains(p) {
            inside += weight;
        }
    }
    Lie {
        area: flat.area(),
        inside: if total > 0.0 { inside / total } else { 0.0 },
    }
}

/// Points spread evenly over a panel, each with the area that it stands for.
fn samples_of(flat: &FlatFace, corners: &[Vec3]) -> Vec<(Vec3, f64)> {
    let triangles = ear_clip(&flat.polygon).unwrap_or_default();
    let points = samples();
    let of_triangle = |t: &[usize; 3]| {
        let [a, b, c] = t.map(|i| corners[i]);
        let (u, v) = (b - a, c - a);
        let weight = u.cross(&v).norm() / points.len() as f64;
        let at = |[s, t]: &[f64; 2]| (a + u * *s + v * *t, weight);
        points.iter().map(at).collect::<Vec<(Vec3, f64)>>()
    };
    triangles.iter().flat_map(of_triangle).collect()
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

    fn panel(inside: f64) -> Lie {
        Lie {
            area: 0.866,
            inside,
        }
    }

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
        let share = |tooth: f64, notch: f64| -> Vec<Lie> {
            let of = |i: usize| match (i / 9, i % 9) {
                (4, 4) => tooth,
                (3, 4) => notch,
                (row, _) => f64::from(u8::from(row < 4)),
            };
            (0..81).map(|i| panel(of(i))).collect()
        };
        let kept = |lies: &[Lie]| {
            let keep = least_energy(&mesh, lies, &near, KEEP);
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
        let some = |n: usize, inside: f64| (0..n).map(move |_| panel(inside));
        assert_eq!(threshold(&some(100, 1.0).collect::<Vec<Lie>>()), KEEP);
        // A quarter of what there is lies in panels that are inside by 0.3 only.
        let lies: Vec<Lie> = some(90, 1.0).chain(some(100, 0.3)).collect();
        assert_eq!(threshold(&lies), 0.3);
    }
}
