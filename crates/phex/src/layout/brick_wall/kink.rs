//! Kinks: how far the lines between rows are bent so that bricks are planar.
//!
//! A brick of length `a` and height `b` on a quadric with conjugate `u, v` is planar with corners
//! `(+-a/2, +-(b/2 - d))` and `(0, +-(b/2 + d))`, `d = a^2 q_uu / (8 b q_vv)`. As a share of half a
//! row that is `rho = 2 d / b = II(x_u, x_u) / (4 II(x_v, x_v))` with the tangents of the brick
//! coordinates. The brick is simple if and only if `|rho| < 1`; `rho = 1/3` is the affine image of
//! a regular hexagon, 0 a rectangle.

use super::grid::BrickGrid;
use crate::curvature::Curvature;
use crate::directions::network::function::hat_gradients;
use phex_mesh::{FaceId, PerVertex, TriangleSurface, Vec3};

/// `II` along the two tangents of the brick coordinates at every vertex, and the area that one unit
/// of them has.
#[derive(Clone, Debug)]
pub(crate) struct BrickForms {
    /// `II(x_u, x_u)`.
    pub along: PerVertex<f64>,
    /// `II(x_v, x_v)`.
    pub across: PerVertex<f64>,
    /// `|x_u|` and `|x_v|`: length and height of a brick.
    pub size: PerVertex<[f64; 2]>,
    /// Area of the surface in bricks.
    pub bricks: f64,
    flat: f64,
}

/// Largest normal curvature, over its 90 % quantile, across rows that counts as none.
const FLAT: f64 = 0.02;

impl BrickForms {
    /// Measures the coordinates.
    pub fn new(surface: &TriangleSurface, curvature: &Curvature, grid: &BrickGrid) -> Self {
        let n = surface.topology().n_vertices();
        let mut sum = PerVertex::filled(n, [Vec3::zeros(); 2]);
        let mut weight = PerVertex::filled(n, 0.0);
        let mut bricks = 0.0;
        for f in surface.topology().faces() {
            let area = surface.face_area(f);
            let Some((tangents, density)) = tangents(surface, grid, f) else {
                continue;
            };
            bricks += area * density;
            for &v in surface.topology().face_vertices(f) {
                weight[v] += area;
                sum[v][0] += tangents[0] * area;
                sum[v][1] += tangents[1] * area;
            }
        }
        let mean = PerVertex::from_fn(n, |v| sum[v].map(|t| t / weight[v].max(f64::MIN_POSITIVE)));
        let form = |k: usize| {
            PerVertex::from_fn(n, |v| mean[v][k].dot(&(curvature.tensor[v] * mean[v][k])))
        };
        let across = form(1);
        Self {
            along: form(0),
            flat: FLAT * quantile(across.iter().map(|q| q.abs()), 0.9),
            across,
            size: mean.map(|t| t.map(|t| t.norm())),
            bricks,
        }
    }

    /// `rho` at a vertex for unit scales; 0 where the surface is flat.
    pub fn kink(&self, v: phex_mesh::VertexId) -> f64 {
        ratio(self.along[v], self.across[v], self.flat)
    }

    /// `rho` in a triangle.
    pub(crate) fn face_kink(&self, corners: &[phex_mesh::VertexId], barycentric: [f64; 3]) -> f64 {
        let mix = |q: &PerVertex<f64>| -> f64 {
            corners
                .iter()
                .zip(barycentric)
                .map(|(&v, b)| q[v] * b)
                .sum()
        };
        ratio(mix(&self.along), mix(&self.across), self.flat)
    }

    /// Quantile of `|rho|` over the vertices.
    pub(crate) fn kink_quantile(&self, share: f64) -> f64 {
        quantile(self.along.ids().map(|v| self.kink(v).abs()), share)
    }

    /// Median ratio of length to height.
    pub fn ratio(&self) -> f64 {
        quantile(self.size.iter().map(|[a, b]| a / b), 0.5)
    }
}

/// `along / (4 across)`, regularised where `across` vanishes.
fn ratio(along: f64, across: f64, flat: f64) -> f64 {
    let size = across * across + flat * flat;
    if size == 0.0 {
        return 0.0;
    }
    0.25 * along * across / size
}

/// Tangents `x_u, x_v` in a triangle and the bricks per area; `None` where the coordinates fold
/// over.
fn tangents(surface: &TriangleSurface, grid: &BrickGrid, f: FaceId) -> Option<([Vec3; 2], f64)> {
    let hats = hat_gradients(surface, f);
    let chart = grid.chart(surface.topology(), f);
    let gradient = |k: usize| hats[0] * chart[0][k] + hats[1] * chart[1][k] + hats[2] * chart[2][k];
    let (u, v) = (gradient(0), gradient(1));
    let normal = surface.area_vector(f).try_normalize(0.0)?;
    let density = u.cross(&v).dot(&normal);
    (density > 0.0).then(|| {
        (
            [v.cross(&normal) / density, normal.cross(&u) / density],
            density,
        )
    })
}

/// Quantile of finite values; 0 if there are none.
pub(crate) fn quantile(values: impl Iterator<Item = f64>, share: f64) -> f64 {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let last = sorted.len().saturating_sub(1);
    let at = (share * last as f64).round() as usize;
    sorted.get(at.min(last)).copied().unwrap_or(0.0)
}
