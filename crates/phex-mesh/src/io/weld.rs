//! Joins equal points of a triangle list into vertices.

use crate::Vec3;
use std::collections::HashMap;

/// Vertices, and the vertex of each point. Equal points become one vertex; then, in their order,
/// each vertex whose coordinates all lie within `tolerance` of an earlier vertex joins the first
/// such one. A joined vertex keeps the position of its first point. Coordinates are finite,
/// `tolerance` is at least `2^-40` of the largest.
pub(super) fn weld(points: &[Vec3], tolerance: f64) -> (Vec<Vec3>, Vec<u32>) {
    let (distinct, first) = join_equal(points);
    let (vertices, second) = join_near(&distinct, tolerance);
    let vertex_of = first.iter().map(|&v| second[v as usize]).collect();
    (vertices, vertex_of)
}

fn join_equal(points: &[Vec3]) -> (Vec<Vec3>, Vec<u32>) {
    let mut vertices = Vec::new();
    let mut known: HashMap<[u64; 3], u32> = HashMap::new();
    let vertex_of = points.iter().map(|p| {
        // Adding zero makes negative zero positive.
        let key = [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits());
        *known.entry(key).or_insert_with(|| {
            vertices.push(*p);
            vertices.len() as u32 - 1
        })
    });
    let vertex_of = vertex_of.collect();
    (vertices, vertex_of)
}

fn join_near(points: &[Vec3], tolerance: f64) -> (Vec<Vec3>, Vec<u32>) {
    if tolerance <= 0.0 {
        return (points.to_vec(), (0..points.len() as u32).collect());
    }
    // Cells much wider than the tolerance: most neighbourhoods lie within one.
    let cell = |x: f64| (x / (16.0 * tolerance)).floor() as i64;
    let mut vertices: Vec<Vec3> = Vec::new();
    let mut in_cell: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut vertex_of = Vec::with_capacity(points.len());
    for p in points {
        let low = p.map(|x| cell(x - tolerance));
        let high = p.map(|x| cell(x + tolerance));
        let near = cells(low, high).filter_map(|c| in_cell.get(&c)).flatten();
        let joined = near
            .copied()
            .filter(|&v| (vertices[v as usize] - p).amax() <= tolerance)
            .min();
        vertex_of.push(joined.unwrap_or_else(|| {
            let v = vertices.len() as u32;
            vertices.push(*p);
            in_cell
                .entry([p.x, p.y, p.z].map(cell))
                .or_default()
                .push(v);
            v
        }));
    }
    (vertices, vertex_of)
}

fn cells(
    low: nalgebra::Vector3<i64>,
    high: nalgebra::Vector3<i64>,
) -> impl Iterator<Item = [i64; 3]> {
    (low.x..=high.x).flat_map(move |x| {
        (low.y..=high.y).flat_map(move |y| (low.z..=high.z).map(move |z| [x, y, z]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_near_and_far_points() {
        let points = [
            Vec3::new(0.0, 0.0, 0.0),
            Vec3::new(-0.0, 0.0, 0.0),
            Vec3::new(1.0, 1.0, 1.0),
            Vec3::new(1.0 + 0.9e-6, 1.0, 1.0 - 0.9e-6),
            Vec3::new(1.0 + 1.1e-6, 1.0, 1.0),
            Vec3::new(-0.9e-6, 0.0, 0.0),
        ];
        let (vertices, vertex_of) = weld(&points, 1e-6);
        assert_eq!(vertex_of, [0, 0, 1, 1, 2, 0]);
        assert_eq!(vertices, [points[0], points[2], points[4]]);
    }

    #[test]
    fn same_joins_as_all_pairs() {
        use rand::{Rng, SeedableRng};
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(7);
        let mut near = |x: f64| x + 1e-4 * rng.random_range(-1.0..1.0);
        let points: Vec<Vec3> = (0..600)
            .map(|i| Vec3::new(near((i % 7) as f64), near((i % 5) as f64), near(0.0)))
            .collect();
        let tolerance = 6e-5;
        let mut expected: Vec<Vec3> = Vec::new();
        for p in &points {
            if !expected.iter().any(|q| (p - q).amax() <= tolerance) {
                expected.push(*p);
            }
        }
        assert!(expected.len() > 35 && expected.len() < 600);
        assert_eq!(weld(&points, tolerance).0, expected);
    }
}
