//! How even the sizes and shapes of the inner panels are.
//!
//! Panels at the boundary are cut by it and left out: only faces without a boundary edge count. All
//! figures are ratios and have no unit.

use super::interior_faces;
use super::metric::quantile;
use crate::{FaceId, FlatFace, HexMesh, PerFace, Topology, Vec2};
use nalgebra::Matrix2;
use serde::Serialize;

/// Evenness of the inner faces of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Evenness {
    /// 5 % quantile of the faces' areas, over their mean.
    pub area_p05: f64,
    /// Median of the faces' areas, over their mean.
    pub area_p50: f64,
    /// 95 % quantile of the faces' areas, over their mean.
    pub area_p95: f64,
    /// 95 % over 5 % quantile of the areas: 1 where all faces are equally large.
    pub area_spread: f64,
    /// Longest edge of a face over the mean length of the faces' edges.
    pub longest_edge: f64,
    /// 95 % quantile of the faces' [aspects](aspect).
    pub aspect_p95: f64,
    /// The same of the areas over those that the faces are to have; `None` where that is not known.
    pub over_wished: Option<AreasOverWished>,
}

/// Areas of the inner faces of a mesh over the areas that they are to have, which differ on purpose
/// where a field of sizes or the curvature asks for it. Only the proportions of the wished areas
/// count: they are scaled to the sum that the faces have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AreasOverWished {
    /// Their 5 % quantile.
    pub p05: f64,
    /// Their median.
    pub p50: f64,
    /// Their 95 % quantile.
    pub p95: f64,
    /// 95 % over 5 % quantile: 1 where all faces are as large as they are to be.
    pub spread: f64,
}

impl AreasOverWished {
    /// Compares areas with those that are wished for, 0 where any will do; `None` if no face inside
    /// is to have one.
    pub fn of(topology: &Topology, areas: &PerFace<f64>, wished: &PerFace<f64>) -> Option<Self> {
        let inner = interior_faces(topology).filter(|f| wished[*f] > 0.0);
        let inner: Vec<FaceId> = inner.collect();
        if inner.is_empty() {
            return None;
        }
        let sum = |values: &PerFace<f64>| inner.iter().map(|f| values[*f]).sum::<f64>();
        let scale = sum(wished) / sum(areas);
        let ratios = sorted(inner.iter().map(|f| scale * areas[*f] / wished[*f]));
        let [p05, p50, p95] = [0.05, 0.5, 0.95].map(|q| quantile(&ratios, q));
        Some(Self {
            p05,
            p50,
            p95,
            spread: p95 / p05,
        })
    }
}

impl Evenness {
    /// Measures a mesh, given its faces in their planes; `None` if every face is at the boundary.
    pub fn of(mesh: &HexMesh, faces: &PerFace<FlatFace>) -> Option<Self> {
        let inner: Vec<FaceId> = interior_faces(mesh.topology()).collect();
        if inner.is_empty() {
            return None;
        }
        let areas = sorted(inner.iter().map(|&f| faces[f].area()));
        let aspects = sorted(inner.iter().map(|&f| aspect(&faces[f].polygon)));
        let lengths = sorted(inner.iter().flat_map(|&f| {
            let edges = mesh.topology().face_half_edges(f);
            edges.map(|h| mesh.edge_length(mesh.topology().edge(h)))
        }));
        let (mean_area, mean_length) = (mean(&areas), mean(&lengths));
        let area = |q| quantile(&areas, q);
        Some(Self {
            area_p05: area(0.05) / mean_area,
            area_p50: area(0.5) / mean_area,
            area_p95: area(0.95) / mean_area,
            area_spread: area(0.95) / area(0.05),
            longest_edge: quantile(&lengths, 1.0) / mean_length,
            aspect_p95: quantile(&aspects, 0.95),
            over_wished: None,
        })
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Length over width of a simple polygon: the square root of the ratio of the principal second
/// moments of its area about its centroid. 1 for a regular polygon, `a / b` for a rectangle of
/// sides `a >= b`, infinite for one without width.
pub fn aspect(polygon: &[Vec2]) -> f64 {
    let Some(&origin) = polygon.first() else {
        return f64::NAN;
    };
    // Moments of a polygon by its fan of signed triangles from the first corner, which keeps them
    // exact far from zero.
    let (mut area, mut first, mut second) = (0.0, Vec2::zeros(), Matrix2::zeros());
    for pair in polygon[1..].windows(2) {
        let (a, b) = (pair[0] - origin, pair[1] - origin);
        let twice = a.perp(&b);
        area += twice / 2.0;
        first += twice / 6.0 * (a + b);
        let mixed = a * b.transpose();
        let squares = a * a.transpose() + b * b.transpose();
        second += twice / 24.0 * (2.0 * squares + mixed + mixed.transpose());
    }
    let about_centroid = (second - first * first.transpose() / area) / area;
    let moments = about_centroid.symmetric_eigenvalues();
    // A polygon without area has moments that are no numbers.
    let width = moments.min().max(0.0);
    match area == 0.0 {
        true => f64::INFINITY,
        false => (moments.max() / width).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use approx::assert_relative_eq;

    fn rectangle(width: f64, height: f64) -> Vec<Vec2> {
        [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
            .map(|(x, y)| Vec2::new(x + 1e3, y - 1e3))
            .to_vec()
    }

    #[test]
    fn aspect_of_known_polygons() {
        let hexagon: Vec<Vec2> = (0..6)
            .map(|k| f64::from(k) * std::f64::consts::FRAC_PI_3)
            .map(|t| Vec2::new(t.cos(), t.sin()))
            .collect();
        assert_relative_eq!(aspect(&hexagon), 1.0, epsilon = 1e-12);
        let stretched: Vec<Vec2> = hexagon.iter().map(|p| Vec2::new(2.5 * p.x, p.y)).collect();
        assert_relative_eq!(aspect(&stretched), 2.5, epsilon = 1e-12);
        assert_relative_eq!(aspect(&rectangle(1.0, 3.0)), 3.0, epsilon = 1e-9);
        assert!(aspect(&rectangle(1.0, 0.0)) > 1e6);
    }

    /// Rows of rectangles; the middle row's widths are given, the ones at the rim are huge and must
    /// not count.
    fn bricks(widths: &[f64]) -> HexMesh {
        let mut ends = vec![-1e3, 0.0];
        ends.extend(widths.iter().scan(0.0, |end, w| {
            *end += w;
            Some(*end)
        }));
        ends.push(1e3);
        let point = |&x: &f64| [-1e3, 0.0, 1.0, 1e3].map(|y| Vec3::new(x, y, 0.0));
        let positions = ends.iter().flat_map(point).collect();
        let face = |(c, r): (u32, u32)| [4 * c + r, 4 * c + 4 + r, 4 * c + 5 + r, 4 * c + 1 + r];
        let columns = ends.len() as u32 - 1;
        let places = (0..columns).flat_map(|c| (0..3).map(move |r| (c, r)));
        let faces: Vec<[u32; 4]> = places.map(face).collect();
        HexMesh::new(positions, &faces).unwrap()
    }

    #[test]
    fn spread_is_that_of_inner_faces_alone() {
        let even = crate::measure(&bricks(&[1.0; 9])).evenness.unwrap();
        assert_relative_eq!(even.area_spread, 1.0, epsilon = 1e-12);
        assert_relative_eq!(even.longest_edge, 1.0, epsilon = 1e-12);
        let mut widths = [1.0; 41];
        (widths[3], widths[9], widths[20]) = (4.0, 4.0, 4.0);
        let uneven = crate::measure(&bricks(&widths)).evenness.unwrap();
        assert_relative_eq!(uneven.area_spread, 4.0, epsilon = 1e-9);
        assert_relative_eq!(uneven.aspect_p95, 4.0, epsilon = 1e-9);
        assert!(uneven.longest_edge > 3.0);
    }

    #[test]
    fn areas_as_they_are_wished_for_are_even() {
        let mut widths = [1.0; 41];
        (widths[3], widths[9], widths[20]) = (4.0, 4.0, 4.0);
        let mesh = bricks(&widths);
        let topology = mesh.topology();
        let areas = FlatFace::all(&mesh).map(FlatFace::area);
        let over = |wished: &PerFace<f64>| AreasOverWished::of(topology, &areas, wished);
        let even = over(&areas.map(|a| 7.0 * a)).unwrap();
        assert_relative_eq!(even.p05, 1.0, epsilon = 1e-12);
        assert_relative_eq!(even.spread, 1.0, epsilon = 1e-12);
        let any = PerFace::filled(topology.n_faces(), 0.0);
        assert_eq!(over(&any), None);
        let alike = over(&any.map(|_| 5.0)).unwrap();
        assert_relative_eq!(alike.spread, 4.0, epsilon = 1e-9);
        // Faces that may have any area do not count.
        let narrow = |a: &f64| if *a < 2.0 { 1.0 } else { 0.0 };
        assert_relative_eq!(
            over(&areas.map(narrow)).unwrap().spread,
            1.0,
            epsilon = 1e-9
        );
    }

    #[test]
    fn a_mesh_without_inner_faces_has_none() {
        let rim = HexMesh::new(
            vec![Vec3::zeros(), Vec3::x(), Vec3::x() + Vec3::y(), Vec3::y()],
            &[[0, 1, 2, 3]],
        );
        assert_eq!(crate::measure(&rim.unwrap()).evenness, None);
    }
}
