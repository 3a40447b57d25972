//! Thickness: the distance to the opposite sheet of the surface, through the body or across a gap.
//!
//! At a vertex with normal `n` a ball that touches the surface there shrinks until no other sheet
//! reaches into it: from the centre `c = x - r n` the closest point `q` of the surface gives the
//! next radius `r = |x - q|^2 / (2 n . (x - q))`, after Ma, Bae and Choi, "3D medial axis point
//! approximation using nearest neighbors and the normal field" (2012), section 3. The diameter of
//! the ball is the thickness, twice the local feature size of a plate.
//!
//! Only points count whose normal turns away from `n` by more than a right angle: where the ball
//! ends at others it is curvature that ends it, which has a rule of its own.

use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};
use rayon::prelude::*;

/// Steps of the shrinking ball at the most; a plate takes two.
const STEPS: usize = 12;
/// Shares of the radius by which a closer point must reach into the ball: at first, so that a
/// search passes by the triangles next to the vertex, and once it has met another sheet.
const INSIDE: [f64; 2] = [0.05, 1e-3];

/// Distance of each vertex to the nearest opposite sheet, on either side; at most `limit`.
pub fn thickness(surface: &TriangleSurface, limit: f64) -> PerVertex<f64> {
    let vertices = 0..surface.positions().len() as u32;
    let least = |v: u32| {
        let v = VertexId::new(v);
        let normal = surface.normals()[v];
        let sides = [normal, -normal].map(|n| ball(surface, v, n, 0.5 * limit));
        2.0 * sides[0].min(sides[1])
    };
    let all: Vec<f64> = vertices.into_par_iter().map(least).collect();
    PerVertex::from_vec(all)
}

/// Radius of the ball that touches the surface at a vertex from the side that `n` points away from,
/// up to the opposite sheet.
fn ball(surface: &TriangleSurface, v: VertexId, n: Vec3, most: f64) -> f64 {
    let (x, normal) = (surface.positions()[v], surface.normals()[v]);
    let (mut radius, mut found) = (most, most);
    for _ in 0..STEPS {
        let centre = x - n * radius;
        let inside = INSIDE[usize::from(found < most)];
        let Some(foot) = surface.closest_within(centre, (1.0 - inside) * radius) else {
            break;
        };
        let away = x - foot.position;
        let depth = n.dot(&away);
        if depth <= 0.0 {
            break;
        }
        radius = away.norm_squared() / (2.0 * depth);
        // In the end a small ball may touch the vertex's own triangles.
        if foot.normal.dot(&normal) < 0.0 {
            found = radius;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A closed box, its sides of `n` by `n` squares, scaled and with normals of its sides.
    fn plate(n: u32, half: Vec3) -> TriangleSurface {
        let mut index = std::collections::HashMap::new();
        let mut positions: Vec<Vec3> = Vec::new();
        let mut triangles = Vec::new();
        for (axis, side) in (0..3).flat_map(|a| [1.0, -1.0].map(|s| (a, s))) {
            let mut corner = |i: u32, j: u32| {
                let along = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
                let mut p = Vec3::zeros();
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, along(i), along(j));
                let key = [p.x, p.y, p.z].map(|c| (c * 1e6).round() as i64);
                *index.entry(key).or_insert_with(|| {
                    positions.push(p.component_mul(&half));
                    positions.len() as u32 - 1
                })
            };
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b] = [corner(i, j), corner(i + 1, j)];
                let [c, d] = [corner(i + 1, j + 1), corner(i, j + 1)];
                let both = match side > 0.0 {
                    true => [[a, b, c], [a, c, d]],
                    false => [[a, c, b], [a, d, c]],
                };
                triangles.extend(both);
            }
        }
        TriangleSurface::new(positions, &triangles).unwrap()
    }

    /// Inside a side of the box, away from its edges.
    fn is_inner(p: Vec3, half: Vec3) -> bool {
        let away = (0..3).filter(|&k| p[k].abs() < 0.7 * half[k]);
        away.count() == 2
    }

    #[test]
    fn plates_are_as_thick_as_they_are_at_any_scale() {
        for scale in [1e-3, 1.0, 1e3] {
            let half = Vec3::new(1.0, 1.0, 0.05) * scale;
            let surface = plate(12, half);
            let found = thickness(&surface, scale);
            let flat = surface.positions().enumerate();
            let flat = flat.filter(|(_, p)| is_inner(**p, half) && p.z.abs() == half.z);
            let mut count = 0;
            for (v, _) in flat {
                assert!(
                    (found[v] - 0.1 * scale).abs() < 1e-6 * scale,
                    "{}",
                    found[v]
                );
                count += 1;
            }
            assert!(count > 50);
        }
    }

    #[test]
    fn what_has_no_other_sheet_within_the_limit_is_as_thick_as_that() {
        let half = Vec3::new(1.0, 1.0, 1.0);
        let surface = plate(12, half);
        let found = thickness(&surface, 0.5);
        let inner = surface.positions().enumerate();
        let inner = inner.filter(|(_, p)| is_inner(**p, half));
        for (v, _) in inner {
            assert_eq!(found[v], 0.5);
        }
    }

    #[test]
    fn gaps_count_like_bodies() {
        let half = Vec3::new(1.0, 1.0, 0.3);
        let one = plate(8, half);
        // A second box over the first one, 0.08 away.
        let n = one.positions().len() as u32;
        let shifted = one.positions().iter().map(|p| p + Vec3::z() * 0.68);
        let positions = one.positions().iter().copied().chain(shifted).collect();
        let triangles: Vec<[u32; 3]> = (one.triangles())
            .flat_map(|t| [t, t.map(|v| v + n)])
            .collect();
        let both = TriangleSurface::new(positions, &triangles).unwrap();
        let found = thickness(&both, 0.5);
        for (v, p) in one
            .positions()
            .enumerate()
            .filter(|(_, p)| is_inner(**p, half))
        {
            let expected = if p.z == 0.3 { 0.08 } else { 0.5 };
            assert!((found[v] - expected).abs() < 1e-9, "{p} {}", found[v]);
        }
    }
}
