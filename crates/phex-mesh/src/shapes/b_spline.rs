//! A bicubic B-spline height field with random control heights over uniform knots.
//!
//! With uniform knots the control points at equal steps reproduce `x` and `y` exactly, so the patch
//! is a graph.

use super::graph::{HeightField, HeightJet};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub(super) struct BSplineHeights {
    /// Side of the square plan, centred on the origin.
    side: f64,
    /// Polynomial pieces along one side.
    spans: usize,
    /// `(spans + 3)^2` control heights, `x` running fastest.
    heights: Vec<f64>,
}

impl BSplineHeights {
    /// Control heights uniform in `[-amplitude, amplitude]`.
    pub(super) fn random(side: f64, spans: usize, amplitude: f64, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let count = (spans + 3) * (spans + 3);
        let heights = (0..count)
            .map(|_| amplitude * (2.0 * rng.random::<f64>() - 1.0))
            .collect();
        Self {
            side,
            spans,
            heights,
        }
    }

    /// Number of the span that holds a coordinate, and the basis functions there.
    fn basis(&self, coordinate: f64) -> (usize, [[f64; 4]; 3]) {
        let per_unit = self.spans as f64 / self.side;
        let knot = (coordinate + 0.5 * self.side) * per_unit;
        let span = knot.floor().clamp(0.0, (self.spans - 1) as f64);
        (span as usize, cubic_basis(knot - span, per_unit))
    }
}

impl HeightField for BSplineHeights {
    fn height(&self, x: f64, y: f64) -> HeightJet {
        let (column, bx) = self.basis(x);
        let (row, by) = self.basis(y);
        let mix = |dx: usize, dy: usize| -> f64 {
            (0..16)
                .map(|k| {
                    let (i, j) = (k % 4, k / 4);
                    let control = (row + j) * (self.spans + 3) + column + i;
                    bx[dx][i] * by[dy][j] * self.heights[control]
                })
                .sum()
        };
        HeightJet {
            z: mix(0, 0),
            x: mix(1, 0),
            y: mix(0, 1),
            xx: mix(2, 0),
            xy: mix(1, 1),
            yy: mix(0, 2),
        }
    }
}

/// The four uniform cubic basis functions at `t` in a span (0 to 1) and their first two derivatives
/// by the coordinate, of which one unit holds `per_unit` spans.
fn cubic_basis(t: f64, per_unit: f64) -> [[f64; 4]; 3] {
    let r = 1.0 - t;
    let inner = |t: f64| (4.0 + t * t * (3.0 * t - 6.0)) / 6.0;
    let inner_slope = |t: f64| t * (1.5 * t - 2.0);
    let squared = per_unit * per_unit;
    [
        [r * r * r / 6.0, inner(t), inner(r), t * t * t / 6.0],
        [-0.5 * r * r, inner_slope(t), -inner_slope(r), 0.5 * t * t].map(|d| d * per_unit),
        [r, 3.0 * t - 2.0, 3.0 * r - 2.0, t].map(|d| d * squared),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn basis_sums_to_one_and_reproduces_lines() {
        for t in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let [value, first, second] = cubic_basis(t, 1.0);
            let moment = |b: [f64; 4]| (0..4).map(|i| b[i] * (i as f64 - 1.0)).sum::<f64>();
            assert!(
                (value.iter().sum::<f64>() - 1.0).abs() < 1e-15
                    && (moment(value) - t).abs() < 1e-15
            );
            assert!(first.iter().sum::<f64>().abs() < 1e-15 && (moment(first) - 1.0).abs() < 1e-15);
            assert!(second.iter().sum::<f64>().abs() < 1e-15 && moment(second).abs() < 1e-15);
        }
    }

    #[test]
    fn second_derivatives_are_continuous_across_knots() {
        let field = BSplineHeights::random(4.0, 4, 0.5, 7);
        let (left, right) = (
            field.height(1.0 - 1e-12, 0.3),
            field.height(1.0 + 1e-12, 0.3),
        );
        assert!((left.xx - right.xx).abs() < 1e-10 && (left.xy - right.xy).abs() < 1e-10);
    }

    #[test]
    fn seed_decides_the_heights() {
        let heights = |seed| BSplineHeights::random(1.0, 3, 1.0, seed).heights;
        assert_eq!(heights(3), heights(3));
        assert_ne!(heights(3), heights(4));
    }
}
