//! Rectangular domains: rows of constant `v`, every second one shifted by half a step; periodic
//! sides are joined.

use super::jitter::Jitter;
use super::rows::{LatticeRow, stitch};
use super::{ParameterMesh, TriangulationOptions};
use crate::Vec2;
use crate::shapes::domain::{Interval, ParameterDomain};
use crate::shapes::parametric::ParametricSurface;

/// Height of an equilateral triangle over its side.
const ROW_HEIGHT: f64 = 0.866_025_403_784_438_6;
/// Steps for measuring lengths along a parameter line, and number of lines that are averaged.
const LENGTH_STEPS: usize = 256;
const LENGTH_LINES: usize = 24;

pub(super) fn mesh<S: ParametricSurface + ?Sized>(
    surface: &S,
    options: &TriangulationOptions,
) -> ParameterMesh {
    let domain = surface.domain();
    let along_u = LengthScale::new(domain.u, |u, fraction| {
        surface.jet(u, domain.v.at(fraction)).du.norm()
    });
    let along_v = LengthScale::new(domain.v, |v, fraction| {
        surface.jet(domain.u.at(fraction), v).dv.norm()
    });
    let lattice = UnitLattice::new(
        &domain,
        along_u.length(),
        along_v.length(),
        options.triangles,
    );
    let (mut points, triangles) = lattice.build();
    lattice.jitter(&mut points, Jitter::new(options));
    let parameters = points
        .iter()
        .map(|p| {
            let fraction = [p.x / lattice.columns as f64, p.y / lattice.height()];
            domain.wrap([
                along_u.parameter(fraction[0]),
                along_v.parameter(fraction[1]),
            ])
        })
        .collect();
    ParameterMesh {
        parameters,
        triangles,
    }
}

/// A rectangle of the lattice with unit edges.
struct UnitLattice {
    columns: usize,
    rows: usize,
    periodic_u: bool,
    periodic_v: bool,
}

impl UnitLattice {
    /// The division that comes closest to equilateral triangles and the number of them asked for.
    fn new(domain: &ParameterDomain, length_u: f64, length_v: f64, triangles: usize) -> Self {
        let edge = (2.0 * length_u * length_v / (ROW_HEIGHT * triangles as f64)).sqrt();
        // However long and thin the rectangle is, there are no more triangles than asked for.
        let count = |wanted: f64, fewest: f64| wanted.round().clamp(fewest, triangles as f64 / 8.0);
        let columns = count(length_u / edge, if domain.u.periodic { 3.0 } else { 2.0 });
        let rows = length_v / (edge * ROW_HEIGHT);
        // Rows alternate, so a closed strip needs an even number of them.
        let rows = if domain.v.periodic {
            2.0 * count(0.5 * rows, 2.0)
        } else {
            count(rows, 2.0)
        };
        Self {
            columns: columns as usize,
            rows: rows as usize,
            periodic_u: domain.u.periodic,
            periodic_v: domain.v.periodic,
        }
    }

    fn height(&self) -> f64 {
        self.rows as f64 * ROW_HEIGHT
    }

    fn build(&self) -> (Vec<Vec2>, Vec<[u32; 3]>) {
        let count = self.rows + usize::from(!self.periodic_v);
        let mut points = Vec::new();
        let mut rows: Vec<LatticeRow> = (0..count).map(|r| self.row(r, &mut points)).collect();
        if self.periodic_v {
            rows.push(rows[0].clone());
        }
        let mut triangles = Vec::new();
        for pair in rows.windows(2) {
            stitch(&pair[0], &pair[1], &mut triangles);
        }
        (points, triangles)
    }

    fn row(&self, r: usize, points: &mut Vec<Vec2>) -> LatticeRow {
        let first = points.len() as u32;
        let abscissae = self.abscissae(r % 2 == 1);
        points.extend(
            abscissae
                .iter()
                .map(|&x| Vec2::new(x, r as f64 * ROW_HEIGHT)),
        );
        let mut row: LatticeRow = abscissae.into_iter().zip(first..).collect();
        if self.periodic_u {
            row.push((row[0].0 + self.columns as f64, first));
        }
        row
    }

    fn abscissae(&self, shifted: bool) -> Vec<f64> {
        let n = self.columns;
        let halves = (0..n).map(|i| i as f64 + 0.5);
        match (shifted, self.periodic_u) {
            (false, true) => (0..n).map(|i| i as f64).collect(),
            (false, false) => (0..=n).map(|i| i as f64).collect(),
            (true, true) => halves.collect(),
            (true, false) => std::iter::once(0.0)
                .chain(halves)
                .chain([n as f64])
                .collect(),
        }
    }

    fn jitter(&self, points: &mut [Vec2], mut jitter: Jitter) {
        if jitter.is_none() {
            return;
        }
        let ends = |x: f64, end: f64, periodic: bool| !periodic && (x == 0.0 || x == end);
        let (width, height) = (self.columns as f64, self.height());
        for p in points {
            if ends(p.x, width, self.periodic_u) || ends(p.y, height, self.periodic_v) {
                continue;
            }
            *p += jitter.step(1.0);
            if self.periodic_u {
                p.x = p.x.rem_euclid(width);
            }
            if self.periodic_v {
                p.y = p.y.rem_euclid(height);
            }
        }
    }
}

/// Length along one parameter, averaged over lines of the other one.
struct LengthScale {
    interval: Interval,
    /// Length from the start to each of the equal steps of the parameter.
    cumulative: Vec<f64>,
}

impl LengthScale {
    /// `speed(parameter, fraction of the other parameter)` is the length per parameter.
    fn new(interval: Interval, speed: impl Fn(f64, f64) -> f64) -> Self {
        let step = interval.length() / LENGTH_STEPS as f64;
        let mut cumulative = vec![0.0];
        let mut total = 0.0;
        for k in 0..LENGTH_STEPS {
            let parameter = interval.start + (k as f64 + 0.5) * step;
            let lines = (0..LENGTH_LINES).map(|i| (i as f64 + 0.5) / LENGTH_LINES as f64);
            let sum: f64 = lines.map(|fraction| speed(parameter, fraction)).sum();
            total += sum / LENGTH_LINES as f64 * step;
            cumulative.push(total);
        }
        Self {
            interval,
            cumulative,
        }
    }

    fn length(&self) -> f64 {
        self.cumulative[LENGTH_STEPS]
    }

    /// The parameter below which a fraction (0 to 1) of the length lies.
    fn parameter(&self, fraction: f64) -> f64 {
        let wanted = fraction * self.length();
        let above = self.cumulative.partition_point(|&length| length <= wanted);
        let k = above.clamp(1, LENGTH_STEPS) - 1;
        let (low, high) = (self.cumulative[k], self.cumulative[k + 1]);
        let step = (k as f64 + (wanted - low) / (high - low)) / LENGTH_STEPS as f64;
        self.interval.at(step.clamp(0.0, 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn length_scale_inverts_the_length() {
        // Speed 2 t on [0, 1]: the length is t^2.
        let scale = LengthScale::new(Interval::open(0.0, 1.0), |t, _| 2.0 * t);
        assert!((scale.length() - 1.0).abs() < 1e-12);
        for fraction in [0.0, 0.1, 0.5, 0.9, 1.0] {
            assert!((scale.parameter(fraction) - f64::sqrt(fraction)).abs() < 1e-3);
        }
        assert_eq!((scale.parameter(0.0), scale.parameter(1.0)), (0.0, 1.0));
    }
}
