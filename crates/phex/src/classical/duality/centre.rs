//! A centre for the polarity, away from all tangent planes.

use super::OrientedPlane;
use phex_mesh::{Vec3, bounds};

/// Candidates along each side of the box that is searched.
const GRID: i32 = 6;
/// How far beyond the planes' points the search goes, in diagonals of their bounding box: farther
/// away the dual only gets flatter.
const REACH: f64 = 1.0;
/// Halvings of the step of the final search.
const HALVINGS: usize = 12;

/// A point that sees the given planes, which touch near `points`, at distances as even as possible,
/// and the least of these distances over the largest: 1 for the centre of a sphere, 0 or less where
/// every point lies in one of the planes. The sign of a distance counts: poles of planes seen from
/// different sides are joined through infinity.
///
/// # Panics
/// If there are no points.
pub(crate) fn clear_centre(planes: &[OrientedPlane], points: &[Vec3]) -> (Vec3, f64) {
    let [low, high] = bounds(points);
    let (middle, diagonal) = ((low + high) * 0.5, (high - low).norm());
    let clearness = |c: Vec3| clearness(planes.iter().map(|p| p.height(c)));
    let step = diagonal * (0.5 + REACH) / f64::from(GRID);
    let mut best = (middle, clearness(middle));
    for c in grid().map(|g| middle + g * step) {
        best = better(best, (c, clearness(c)));
    }
    for halving in 0..HALVINGS {
        let step = step * 0.5f64.powi(halving as i32);
        let from = best.0;
        for c in directions().map(|d| from + d * step) {
            best = better(best, (c, clearness(c)));
        }
    }
    best
}

fn grid() -> impl Iterator<Item = Vec3> {
    let range = || -GRID..=GRID;
    range().flat_map(move |i| {
        range().flat_map(move |j| {
            range().map(move |k| Vec3::new(f64::from(i), f64::from(j), f64::from(k)))
        })
    })
}

fn directions() -> impl Iterator<Item = Vec3> {
    let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
    axes.into_iter().flat_map(|a| [a, -a])
}

/// The least of signed distances over the largest, with the sign of most of them.
pub(crate) fn clearness(heights: impl Iterator<Item = f64>) -> f64 {
    let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    let (least, largest) = if low + high > 0.0 {
        (low, high)
    } else {
        (-high, -low)
    };
    least / largest.max(f64::MIN_POSITIVE)
}

/// Ties go to the first, so that the middle of a symmetric surface stays its centre.
fn better(best: (Vec3, f64), other: (Vec3, f64)) -> (Vec3, f64) {
    if other.1 > best.1 + 1e-9 { other } else { best }
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn of(name: &str) -> (Vec3, f64) {
        let options = TriangulationOptions {
            triangles: 1000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap();
        let pairs = surface.positions().iter().zip(surface.normals());
        let planes: Vec<OrientedPlane> =
            pairs.map(|(p, n)| OrientedPlane::through(*p, *n)).collect();
        clear_centre(&planes, surface.positions().as_slice())
    }

    #[test]
    fn middle_of_a_sphere_below_a_dome_and_nowhere_for_a_torus() {
        let (centre, clear) = of("sphere");
        assert!(centre.norm() < 0.01 && clear > 0.99, "{centre:?} {clear}");
        assert!(of("elliptic-paraboloid").1 > 0.2);
        assert!(of("hyperbolic-paraboloid").1 > 0.05);
        assert!(of("torus").1 < 0.0);
    }
}
