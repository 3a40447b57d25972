//! Random moves of lattice vertices.

use super::TriangulationOptions;
use crate::Vec2;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Moves in the unit disc, scaled by the jitter.
pub(super) struct Jitter {
    rng: ChaCha8Rng,
    radius: f64,
}

impl Jitter {
    pub(super) fn new(options: &TriangulationOptions) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(options.seed),
            radius: options.jitter,
        }
    }

    /// Whether nothing moves.
    pub(super) fn is_none(&self) -> bool {
        self.radius == 0.0
    }

    /// The next move, uniform over the disc, for a lattice whose edges are `edge` long.
    pub(super) fn step(&mut self, edge: f64) -> Vec2 {
        let radius = self.radius * edge * self.rng.random::<f64>().sqrt();
        let (sin, cos) = (TAU * self.rng.random::<f64>()).sin_cos();
        Vec2::new(cos, sin) * radius
    }
}

/// For every vertex the edge of an equilateral triangle as high as the lowest triangle at the
/// vertex: moves relative to it cannot fold a triangle over.
pub(super) fn safe_edges<P: Copy>(
    points: &[P],
    triangles: &[[u32; 3]],
    distance: impl Fn(P, P) -> f64,
) -> Vec<f64> {
    let mut edges = vec![f64::INFINITY; points.len()];
    for triangle in triangles {
        let [a, b, c] = triangle.map(|i| points[i as usize]);
        let lengths = [distance(a, b), distance(b, c), distance(c, a)];
        let edge = lowest_altitude(lengths) * 2.0 / 3f64.sqrt();
        for &i in triangle {
            edges[i as usize] = edges[i as usize].min(edge);
        }
    }
    edges
}

/// Twice the area (Heron) over the longest side.
fn lowest_altitude([a, b, c]: [f64; 3]) -> f64 {
    let s = 0.5 * (a + b + c);
    let area = (s * (s - a) * (s - b) * (s - c)).max(0.0).sqrt();
    2.0 * area / a.max(b).max(c)
}
