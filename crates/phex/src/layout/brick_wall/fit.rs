//! Scale and phase of the pattern: where the boundary runs along rows or columns, it is laid on
//! them.

use super::grid::BrickGrid;
use crate::directions::network::{ConjugateNetwork, Function};
use nalgebra::Complex;
use phex_mesh::{EdgeId, TriangleSurface};
use std::f64::consts::TAU;

/// Largest stretch.
const MAX_STRETCH: f64 = 0.06;
/// Stretches tried to either side.
const STEPS: i32 = 40;
/// Slope against a family up to which a boundary edge follows it.
const ALONG: f64 = 0.2;
/// Share of the boundary that must follow a family for it to be fitted.
const MIN_SHARE: f64 = 0.2;

/// The pattern at about the given scale.
pub(crate) fn fitted_grid(
    surface: &TriangleSurface,
    network: &ConjugateNetwork,
    scale: [f64; 2],
) -> BrickGrid {
    let [u, v] = network.functions(surface, scale);
    // Columns are at half bricks, rows at whole rows.
    let along = fit(&followers(surface, &u, &v), 2.0);
    let across = fit(&followers(surface, &v, &u), 1.0);
    let fitted = [scale[0] * along.0, scale[1] * across.0];
    BrickGrid::new(surface, network, fitted, [along.1, across.1])
}

/// Values of `constant` in the middles of the boundary edges along which it hardly changes, and the
/// lengths of those edges; edges that follow neither family count with a length but no value.
fn followers(
    surface: &TriangleSurface,
    constant: &Function,
    other: &Function,
) -> Vec<(Option<f64>, f64)> {
    let topology = surface.topology();
    let value = |e: EdgeId| {
        let follows = constant.change[e].abs() < ALONG * other.change[e].abs();
        let middle = constant.value[topology.edge_vertices(e)[0]] + 0.5 * constant.change[e];
        (follows.then_some(middle), surface.edge_length(e))
    };
    let boundary = topology.boundary_edges();
    boundary.map(value).collect()
}

/// Stretch and shift that bring the values closest to multiples of `1 / per_unit`.
fn fit(values: &[(Option<f64>, f64)], per_unit: f64) -> (f64, f64) {
    let total: f64 = values.iter().map(|v| v.1).sum();
    let following: f64 = values.iter().filter(|v| v.0.is_some()).map(|v| v.1).sum();
    if following <= MIN_SHARE * total {
        return (1.0, 0.0);
    }
    let resultant = |stretch: f64| -> Complex<f64> {
        let term = |(value, length): &(Option<f64>, f64)| {
            let angle = value.map(|x| TAU * per_unit * stretch * x)?;
            Some(Complex::from_polar(*length, angle))
        };
        values.iter().filter_map(term).sum::<Complex<f64>>() / following
    };
    let candidates = (-STEPS..=STEPS).map(|k| 1.0 + MAX_STRETCH * f64::from(k) / f64::from(STEPS));
    let quality = |stretch: f64| resultant(stretch).norm() - (stretch - 1.0).abs();
    let best = candidates.max_by(|a, b| quality(*a).total_cmp(&quality(*b)));
    let stretch = best.unwrap_or(1.0);
    (stretch, -resultant(stretch).arg() / (TAU * per_unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_parallel_sides_come_to_lie_on_rows() {
        let sides = [(Some(0.3), 1.0), (Some(9.2), 1.0), (None, 0.5)];
        let (stretch, shift) = fit(&sides, 1.0);
        for value in [0.3, 9.2] {
            let row = value * stretch + shift;
            assert!((row - row.round()).abs() < 0.02, "{row}");
        }
        assert!((stretch - 1.0).abs() < 0.03);
    }

    #[test]
    fn a_boundary_that_follows_nothing_changes_nothing() {
        assert_eq!(fit(&[(Some(0.3), 0.1), (None, 1.0)], 1.0), (1.0, 0.0));
    }
}
