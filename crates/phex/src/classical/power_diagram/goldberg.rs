//! Goldberg polyhedra: hexagons and twelve pentagons in icosahedral symmetry.

use super::{PowerDiagram, PowerError, PowerSite, power_diagram};
use phex_mesh::{Vec2, Vec3};
use std::collections::HashMap;

/// Largest `m + n`: 10 (m + n)^2 panels are more than anyone asks for.
const LARGEST: u32 = 120;

/// The Goldberg polyhedron `(m, n)` about the unit sphere: `10 (m^2 + m n + n^2) + 2` panels that
/// touch it, 12 of them pentagons.
///
/// # Errors
/// If `m + n` is 0 or too large.
pub fn goldberg(m: u32, n: u32) -> Result<PowerDiagram, PowerError> {
    power_diagram(&goldberg_sites(m, n)?, 1.0)
}

/// Stereographic images of the points of the geodesic sphere `(m, n)`, but for the north pole,
/// where one of the pentagons lies.
///
/// # Errors
/// If `m + n` is 0 or too large.
pub(crate) fn goldberg_sites(m: u32, n: u32) -> Result<Vec<PowerSite>, PowerError> {
    let points = geodesic_points(m, n)?;
    let south = points.iter().filter(|p| p.z < 1.0 - 1e-9);
    Ok(south
        .map(|p| PowerSite {
            position: p.xy() / (1.0 - p.z),
            weight: 0.0,
        })
        .collect())
}

/// The classes with `m >= n` whose number of panels is at most `panels`, by that number.
pub(crate) fn goldberg_classes(panels: usize) -> Vec<(u32, u32, usize)> {
    let pairs = (1..=LARGEST).flat_map(|m| (0..=m.min(LARGEST - m)).map(move |n| (m, n)));
    let mut classes: Vec<(u32, u32, usize)> = pairs
        .map(|(m, n)| (m, n, 10 * (m * m + m * n + n * n) as usize + 2))
        .filter(|c| c.2 <= panels)
        .collect();
    classes.sort_by_key(|&(m, n, panels)| (panels, n, m));
    classes
}

/// The class whose number of panels is nearest to `panels`; of two the one with the smaller `n`.
pub(crate) fn nearest_goldberg(panels: usize) -> (u32, u32) {
    let ratio = |count: usize| (count as f64 / panels.max(1) as f64).ln().abs();
    let classes = goldberg_classes(2 * panels.max(12));
    let best = classes
        .iter()
        .min_by(|a, b| ratio(a.2).total_cmp(&ratio(b.2)));
    best.map_or((1, 0), |&(m, n, _)| (m, n))
}

/// Points of the triangular lattice of each face of the icosahedron, turned and scaled so that `m`
/// steps along one lattice direction and `n` along the next lead from corner to corner (Caspar and
/// Klug), projected to the sphere from its centre.
fn geodesic_points(m: u32, n: u32) -> Result<Vec<Vec3>, PowerError> {
    if !(1..=LARGEST).contains(&m.saturating_add(n)) {
        return Err(PowerError::Class {
            m,
            n,
            largest: LARGEST,
        });
    }
    let (m, n) = (i64::from(m), i64::from(n));
    let count = m * m + m * n + n * n;
    let (corners, faces) = icosahedron();
    let mut points: Vec<Vec3> = Vec::new();
    for face in faces {
        let [a, b, c] = face.map(|k| corners[k]);
        for i in -n..=m {
            for j in 0..=m + n {
                // Barycentric coordinates of the lattice point i + j w, times the count; the
                // triangle's corners are 0, m + n w and its turn by a sixth, -n + (m + n) w.
                let along = i * (m + n) + j * n;
                let across = j * m - i * n;
                let rest = count - along - across;
                if along >= 0 && across >= 0 && rest >= 0 {
                    let p = a * rest as f64 + b * along as f64 + c * across as f64;
                    points.push(p.normalize());
                }
            }
        }
    }
    Ok(distinct(points))
}

/// The points without repetitions, in their order.
fn distinct(points: Vec<Vec3>) -> Vec<Vec3> {
    const CELL: f64 = 1e-5;
    let cell = |p: Vec3| -> [i64; 3] { p.map(|x| (x / CELL).floor() as i64).into() };
    let mut taken: HashMap<[i64; 3], Vec3> = HashMap::new();
    let mut kept = Vec::new();
    for p in points {
        let corners = [-1e-7, 1e-7].map(|d| cell(p.add_scalar(d)));
        let near = (0..8).map(|k| std::array::from_fn(|i| corners[k >> i & 1][i]));
        let known = near.filter_map(|key: [i64; 3]| taken.get(&key));
        if known.into_iter().any(|q| (p - q).norm() < 1e-7) {
            continue;
        }
        taken.insert(cell(p), p);
        kept.push(p);
    }
    kept
}

/// Corners with one at the north pole, and faces counter-clockwise from outside.
fn icosahedron() -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let height = 1.0 / 5.0f64.sqrt();
    let ring = |k: usize, shift: f64, z: f64| {
        let angle = std::f64::consts::TAU * (k as f64 + shift) / 5.0;
        let flat = Vec2::new(angle.cos(), angle.sin()) * (1.0 - z * z).sqrt();
        flat.push(z)
    };
    let mut corners = vec![Vec3::z()];
    corners.extend((0..5).map(|k| ring(k, 0.0, height)));
    corners.extend((0..5).map(|k| ring(k, 0.5, -height)));
    corners.push(-Vec3::z());
    let faces = (0..5).flat_map(|k| {
        let (a, b) = (1 + k, 1 + (k + 1) % 5);
        let (c, d) = (6 + k, 6 + (k + 1) % 5);
        [[0, a, b], [a, c, b], [b, c, d], [11, d, c]]
    });
    (corners, faces.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::measure;

    #[test]
    fn twelve_pentagons_and_the_number_of_panels_for_every_class() {
        for (m, n) in [
            (1, 0),
            (1, 1),
            (2, 0),
            (2, 1),
            (1, 2),
            (3, 0),
            (2, 2),
            (3, 1),
            (5, 3),
            (8, 0),
        ] {
            let diagram = goldberg(m, n).unwrap();
            let measures = measure(&diagram.mesh);
            let panels = 10 * (m * m + m * n + n * n) as usize + 2;
            assert_eq!(measures.faces, panels, "({m}, {n})");
            assert_eq!(measures.face_sizes[&5], 12, "({m}, {n})");
            let hexagons = measures.face_sizes.get(&6).copied().unwrap_or(0);
            assert_eq!(
                hexagons,
                panels - 12,
                "({m}, {n}): nothing but hexagons else"
            );
            assert!(measures.planarity.max < 1e-12);
            assert_eq!((measures.faces_not_simple, measures.degree3), (0, 1.0));
            assert!(diagram.hidden.is_empty());
        }
    }

    #[test]
    fn chiral_classes_are_mirror_images() {
        let angle = |(m, n)| -> f64 {
            // The panel next to the cap that lies nearest to the meridian of a corner of the
            // icosahedron.
            let points = geodesic_points(m, n).unwrap();
            let near = points
                .iter()
                .filter(|p| p.z < 0.999 && p.x > 0.0 && p.z > 0.5);
            let closest =
                near.min_by(|a, b| b.z.total_cmp(&a.z).then(a.y.abs().total_cmp(&b.y.abs())));
            closest.map(|p| p.y.atan2(p.x)).unwrap()
        };
        assert!((angle((2, 1)) + angle((1, 2))).abs() < 1e-9);
        assert!(angle((2, 1)).abs() > 0.1);
    }

    #[test]
    fn classes_without_panels_are_refused() {
        assert!(matches!(goldberg(0, 0), Err(PowerError::Class { .. })));
        assert!(matches!(
            goldberg(u32::MAX, 1),
            Err(PowerError::Class { .. })
        ));
        assert_eq!(nearest_goldberg(490), (7, 0));
        assert_eq!(nearest_goldberg(1), (1, 0));
    }
}
