//! A surface with fewer triangles, for looking at.

use phex_mesh::{PolygonSoup, TriangleSurface, Vec3};
use std::collections::HashMap;

/// Most triangles of a surface in a report.
const MOST: usize = 40_000;

/// The triangles of a surface; of a finer one, those that are left when vertices that share a cube
/// of a grid become one.
pub fn thinned(surface: &TriangleSurface) -> PolygonSoup {
    let all = surface.to_soup();
    let mut cell = (surface.area() / MOST as f64).sqrt();
    let mut soup = all.clone();
    while soup.faces.len() > MOST {
        soup = clustered(&all, cell);
        cell *= 1.25;
    }
    soup
}

fn clustered(soup: &PolygonSoup, cell: f64) -> PolygonSoup {
    let mut number: HashMap<[i64; 3], u32> = HashMap::new();
    let mut sums: Vec<(Vec3, f64)> = Vec::new();
    let mut of_vertex = Vec::with_capacity(soup.positions.len());
    for p in &soup.positions {
        let key = [p.x, p.y, p.z].map(|c| (c / cell).floor() as i64);
        let at = *number.entry(key).or_insert(sums.len() as u32);
        if at as usize == sums.len() {
            sums.push((Vec3::zeros(), 0.0));
        }
        sums[at as usize].0 += p;
        sums[at as usize].1 += 1.0;
        of_vertex.push(at);
    }
    let moved =
        |face: &Vec<u32>| -> Vec<u32> { face.iter().map(|&v| of_vertex[v as usize]).collect() };
    let has_area = |f: &Vec<u32>| f[0] != f[1] && f[1] != f[2] && f[2] != f[0];
    PolygonSoup {
        positions: sums.into_iter().map(|(sum, n)| sum / n).collect(),
        faces: soup.faces.iter().map(moved).filter(has_area).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    #[test]
    fn a_fine_surface_keeps_its_shape_with_fewer_triangles() {
        let options = TriangulationOptions {
            triangles: 150_000,
            ..Default::default()
        };
        let sphere = triangulate(&Shape::from_name("sphere", &[]).unwrap(), &options).unwrap();
        let thin = thinned(&sphere);
        assert!(thin.faces.len() <= MOST && thin.faces.len() > MOST / 4);
        let radius = sphere.positions().iter().map(Vec3::norm).sum::<f64>()
            / sphere.positions().len() as f64;
        assert!(
            thin.positions
                .iter()
                .all(|p| (p.norm() / radius - 1.0).abs() < 1e-3)
        );
        assert!(
            thin.faces
                .iter()
                .flatten()
                .all(|&v| (v as usize) < thin.positions.len())
        );
    }
}
