//! A hexagonal lattice that is regular on the Gauss sphere, for a patch: the conformal image of one
//! in the plane.
//!
//! In the plane `w` of a stereographic projection, which is conformal, `dz = exp(g(w)) dw` with a
//! polynomial `g` maps the Gauss image to the plane `z` of a regular lattice. `Re g` is the size
//! and `Im g` the rotation; both are harmonic and belong together. `g` is the least-squares fit of
//!
//! ```text
//! Re g = log(lambda / sqrt |K|)     panels of one area on the surface, lambda = 2 / (1 + |w|^2)
//! Im g = -psi                       an edge of every panel along the principal direction at psi
//! ```
//!
//! where the second counts more the more the curvatures differ: where `K < 0` a panel is best with
//! an edge along a principal direction, and has edges without length 30 degrees off.
//!
//! *Guaranteed*: hexagons only. *Fails* where the Gauss image winds round a hole, or no panel lies
//! in it.

use crate::curvature::{Curvature, turn_to_pole};
use crate::layout::LayoutError;
use nalgebra::{Complex, DMatrix, DVector, Rotation3};
use phex_mesh::polygon::HEXAGON;
use phex_mesh::{HexMesh, PerVertex, TriangleSurface, Vec3, VertexId};
use std::collections::{BTreeMap, BTreeSet, BinaryHeap, VecDeque};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI};

/// Degree of `g`.
const DEGREE: usize = 6;
/// Weight of sizes over that of directions.
const SIZES: f64 = 0.1;
/// Weight of each coefficient of `g`, so that few vertices are no trouble.
const RIDGE: f64 = 1e-6;

type PlanePoint = Complex<f64>;

/// Panels of a lattice about a patch: hexagons on the unit sphere, counter-clockwise from outside.
///
/// `panels` of them have their centres in the Gauss image; those next to them are there, too.
///
/// # Errors
/// If none has.
pub(crate) fn gauss_lattice(
    surface: &TriangleSurface,
    curvature: &Curvature,
    panels: usize,
    rotate: f64,
) -> Result<HexMesh, LayoutError> {
    let image = GaussPlane::new(surface, curvature);
    let map = ConformalMap::fit(&image, rotate);
    // Newton's method may lose or gain a panel at the rim: the count is met by another scale.
    let mut edge = (image.lattice_area(&map) / (panels as f64 * HEXAGON)).sqrt();
    let mut made = Grown::new(&image, &map, edge);
    for _ in 0..COUNT_TRIES {
        edge *= (made.inside.max(1) as f64 / panels as f64).sqrt();
        made = Grown::new(&image, &map, edge);
    }
    made.mesh(&image)
}

/// Lattices tried for the number of panels.
const COUNT_TRIES: usize = 2;

/// The Gauss image of a surface in the plane.
struct GaussPlane {
    turn: Rotation3<f64>,
    /// The image of each vertex.
    point: PerVertex<PlanePoint>,
    /// The image as a surface in the plane `z = 0`.
    region: TriangleSurface,
    /// Area of each vertex on the surface.
    area: PerVertex<f64>,
    /// Wished `Re g`.
    size: PerVertex<f64>,
    /// Wished `-Im g`, and how much it counts.
    angle: PerVertex<(f64, f64)>,
}

impl GaussPlane {
    fn new(surface: &TriangleSurface, curvature: &Curvature) -> Self {
        let normals = &curvature.normal;
        let mean: Vec3 = normals.iter().sum();
        let turn = turn_to_pole(&mean).to_rotation_matrix();
        let point = normals.map(|n| projected(turn * n));
        let region = surface.with_positions(point.map(|w| Vec3::new(w.re, w.im, 0.0)));
        let principal = curvature.principal();
        let size = PerVertex::from_fn(point.len(), |v| {
            let p = &principal[v];
            let k = (p.small * p.large).abs().max(1e-12);
            (2.0 / (1.0 + point[v].norm_sqr())).ln() - 0.5 * k.ln()
        });
        let topology = surface.topology();
        let area = PerVertex::from_fn(point.len(), |v| {
            let around = topology.faces_at(v);
            around.map(|f| surface.area_vector(f).norm()).sum()
        });
        let raw = PerVertex::from_fn(point.len(), |v| {
            let p = &principal[v];
            // The image of a principal direction is parallel to it.
            let ahead = projected(turn * (normals[v] + p.small_direction * STEP).normalize());
            let back = projected(turn * (normals[v] - p.small_direction * STEP).normalize());
            let ratio = p.small / p.large.abs().max(f64::MIN_POSITIVE) * p.large.signum();
            ((ahead - back).arg(), 1.0 - ratio)
        });
        let angle = unwrapped(surface, &raw, &area);
        Self {
            turn,
            point,
            region,
            area,
            size,
            angle,
        }
    }

    /// The normal of a point of the plane.
    fn normal(&self, w: PlanePoint) -> Vec3 {
        let s = 1.0 + w.norm_sqr();
        self.turn.inverse() * Vec3::new(2.0 * w.re / s, 2.0 * w.im / s, 2.0 / s - 1.0)
    }

    fn holds(&self, w: PlanePoint) -> bool {
        let p = Vec3::new(w.re, w.im, 0.0);
        (self.region.closest_point(p).position - p).norm() < 1e-9
    }

    /// Area of the Gauss image in the plane of the lattice.
    fn lattice_area(&self, map: &ConformalMap) -> f64 {
        let t = self.region.topology();
        let area = |f| {
            let corners = t.face_vertices(f).iter();
            let scale: f64 = corners
                .map(|v| map.derivative(self.point[*v]).norm_sqr())
                .sum();
            self.region.face_area(f) * scale / 3.0
        };
        t.faces().map(area).sum()
    }

    /// The vertex that is nearest to the middle of all.
    fn middle(&self) -> PlanePoint {
        let sum: f64 = self.area.iter().sum();
        let pairs = self.point.iter().zip(&self.area);
        let mean: PlanePoint =
            pairs.map(|(w, a)| w * *a).sum::<PlanePoint>() / PlanePoint::from(sum);
        let near =
            |a: &&PlanePoint, b: &&PlanePoint| (*a - mean).norm().total_cmp(&(*b - mean).norm());
        self.point.iter().min_by(near).copied().unwrap_or(mean)
    }
}

/// Step along the sphere by which directions are mapped.
const STEP: f64 = 1e-4;

/// Stereographic projection from the pole at `-z`.
fn projected(n: Vec3) -> PlanePoint {
    PlanePoint::new(n.x, n.y) / (1.0 + n.z).max(1e-9)
}

/// Angles of one family of principal directions all over the surface, without jumps, with their
/// weights; those that tell directions most clearly come first. The family is that of the smaller
/// curvature where that matters.
fn unwrapped(
    surface: &TriangleSurface,
    raw: &PerVertex<(f64, f64)>,
    area: &PerVertex<f64>,
) -> PerVertex<(f64, f64)> {
    let t = surface.topology();
    let mut angle: PerVertex<Option<f64>> = PerVertex::filled(raw.len(), None);
    let mut heap = BinaryHeap::new();
    let order = |v: VertexId| ((raw[v].1 * 1e9) as i64, std::cmp::Reverse(v));
    let first = t
        .vertices()
        .max_by_key(|v| order(*v))
        .unwrap_or(VertexId::new(0));
    heap.push((order(first), first, first));
    let mut swapped = 0.0;
    while let Some((_, v, from)) = heap.pop() {
        if angle[v].is_some() {
            continue;
        }
        let near = angle[from].unwrap_or(raw[v].0);
        let quarters = ((near - raw[v].0) / FRAC_PI_2).round();
        // Nothing where both curvatures are of one size.
        let matters = 1.0 - (1.0 - raw[v].1).powi(2);
        let kept = quarters as i64 % 2 == 0;
        swapped += area[v] * if kept { matters } else { -matters };
        let own = raw[v].0 + quarters * FRAC_PI_2;
        angle[v] = Some(own);
        for w in t.neighbours(v).into_iter().filter(|w| angle[*w].is_none()) {
            heap.push((order(w), w, v));
        }
    }
    // On minimal surfaces neither family is better, and rounding must not choose.
    let all: f64 = area.iter().sum();
    let turn = if swapped < -1e-6 * all {
        FRAC_PI_2
    } else {
        0.0
    };
    PerVertex::from_fn(raw.len(), |v| {
        (angle[v].unwrap_or(raw[v].0) + turn, raw[v].1.powi(2))
    })
}

/// `dz = exp(g(w)) dw`.
struct ConformalMap {
    origin: PlanePoint,
    /// Unit of the polynomial's variable.
    unit: f64,
    coefficients: [PlanePoint; DEGREE + 1],
}

impl ConformalMap {
    fn fit(image: &GaussPlane, rotate: f64) -> Self {
        let origin = image.middle();
        let far = image
            .point
            .iter()
            .map(|w| (w - origin).norm())
            .fold(0.0, f64::max);
        let unit = far.max(f64::MIN_POSITIVE);
        let n = 2 * (DEGREE + 1);
        let (mut matrix, mut right) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let total: f64 = image.area.iter().sum();
        let mut add = |row: DVector<f64>, wish: f64, weight: f64| {
            matrix.ger(weight, &row, &row, 1.0);
            right.axpy(weight * wish, &row, 1.0);
        };
        for (v, w) in image.point.enumerate() {
            let u = (w - origin) / PlanePoint::from(unit);
            let powers = powers(u);
            let share = image.area[v] / total;
            // g = sum (a_k + i b_k) u^k.
            let real = |k: usize| {
                if k.is_multiple_of(2) {
                    powers[k / 2].re
                } else {
                    -powers[k / 2].im
                }
            };
            let imaginary = |k: usize| {
                if k.is_multiple_of(2) {
                    powers[k / 2].im
                } else {
                    powers[k / 2].re
                }
            };
            add(
                DVector::from_fn(n, |k, _| real(k)),
                image.size[v],
                SIZES * share,
            );
            let (angle, weight) = image.angle[v];
            add(
                DVector::from_fn(n, |k, _| imaginary(k)),
                rotate - angle,
                weight * share,
            );
        }
        (0..n).for_each(|k| matrix[(k, k)] += RIDGE);
        let solved = matrix.cholesky().map(|c| c.solve(&right));
        let solved = solved.unwrap_or_else(|| DVector::zeros(n));
        Self {
            origin,
            unit,
            coefficients: std::array::from_fn(|k| {
                PlanePoint::new(solved[2 * k], solved[2 * k + 1])
            }),
        }
    }

    /// `dz / dw`.
    fn derivative(&self, w: PlanePoint) -> PlanePoint {
        let powers = powers((w - self.origin) / PlanePoint::from(self.unit));
        let terms = self.coefficients.iter().zip(powers);
        terms.map(|(c, u)| c * u).sum::<PlanePoint>().exp()
    }

    /// The point of `w` that lies `step` away from `from` in the plane of the lattice.
    fn moved(&self, from: PlanePoint, step: PlanePoint) -> Option<PlanePoint> {
        let mut to = from + step / self.derivative(from);
        for _ in 0..NEWTON {
            let miss = step - self.way(from, to);
            to += miss / self.derivative(to);
            if miss.norm() <= 1e-13 * step.norm() {
                break;
            }
        }
        let there = (self.way(from, to) - step).norm() <= 1e-9 * step.norm();
        (there && to.re.is_finite()).then_some(to)
    }

    /// The integral of `dz` on a straight way, by the rule of Gauss with five points on each half.
    fn way(&self, from: PlanePoint, to: PlanePoint) -> PlanePoint {
        let half = |a: PlanePoint, b: PlanePoint| {
            let (middle, reach) = (
                (a + b) / PlanePoint::from(2.0),
                (b - a) / PlanePoint::from(2.0),
            );
            let term = |&(x, weight): &(f64, f64)| {
                self.derivative(middle + reach * PlanePoint::from(x)) * PlanePoint::from(weight)
            };
            GAUSS.iter().map(term).sum::<PlanePoint>() * reach
        };
        let middle = (from + to) / PlanePoint::from(2.0);
        half(from, middle) + half(middle, to)
    }
}

/// Steps of Newton's method at the most.
const NEWTON: usize = 12;
/// Points and weights of the rule of Gauss on the interval from -1 to 1.
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

fn powers(u: PlanePoint) -> [PlanePoint; DEGREE + 1] {
    let mut power = PlanePoint::from(1.0);
    std::array::from_fn(|k| {
        if k > 0 {
            power *= u;
        }
        power
    })
}

/// Hexagons of the lattice, grown from the middle.
struct Grown {
    /// Centres in the plane `w`, and whether they lie inside.
    centre: BTreeMap<(i32, i32), (PlanePoint, bool)>,
    /// Corners, by their places in the lattice in thirds of its basis.
    corner: BTreeMap<(i32, i32), PlanePoint>,
    inside: usize,
}

/// The neighbours of a hexagon, counter-clockwise, at 30, 90, ... degrees.
const NEIGHBOURS: [(i32, i32); 6] = [(1, 0), (0, 1), (-1, 1), (-1, 0), (0, -1), (1, -1)];

impl Grown {
    fn new(image: &GaussPlane, map: &ConformalMap, edge: f64) -> Self {
        let mut centre = BTreeMap::from([((0, 0), (map.origin, true))]);
        let mut queue = VecDeque::from([(0, 0)]);
        while let Some(at) = queue.pop_front() {
            let (w, inside) = centre[&at];
            // Those next to the inside end the lattice.
            for (k, (q, r)) in NEIGHBOURS.iter().enumerate().filter(|_| inside) {
                let next = (at.0 + q, at.1 + r);
                let step =
                    PlanePoint::from_polar(3f64.sqrt() * edge, PI / 6.0 + FRAC_PI_3 * k as f64);
                if centre.contains_key(&next) || centre.len() > MOST {
                    continue;
                }
                if let Some(there) = map.moved(w, step) {
                    centre.insert(next, (there, image.holds(there)));
                    queue.push_back(next);
                }
            }
        }
        let mut corner = BTreeMap::new();
        for (at, (w, _)) in &centre {
            for (k, place) in corners(*at).into_iter().enumerate() {
                let step = PlanePoint::from_polar(edge, FRAC_PI_3 * k as f64);
                if let Some(there) = map.moved(*w, step) {
                    corner.entry(place).or_insert(there);
                }
            }
        }
        let inside = centre.values().filter(|c| c.1).count();
        Self {
            centre,
            corner,
            inside,
        }
    }

    /// The hexagons as a mesh on the unit sphere.
    fn mesh(&self, image: &GaussPlane) -> Result<HexMesh, LayoutError> {
        let cells = self.centre.keys().map(|at| corners(*at));
        let whole = |c: &[(i32, i32); 6]| c.iter().all(|p| self.corner.contains_key(p));
        let cells: Vec<[(i32, i32); 6]> = cells.filter(whole).collect();
        let used: BTreeSet<(i32, i32)> = cells.iter().flatten().copied().collect();
        let number: BTreeMap<_, u32> = used.iter().copied().zip(0..).collect();
        let positions = used.iter().map(|p| image.normal(self.corner[p])).collect();
        let faces: Vec<[u32; 6]> = cells.iter().map(|c| c.map(|p| number[&p])).collect();
        HexMesh::new(positions, &faces)
            .map_err(|e| LayoutError::topology(format!("the lattice on the Gauss sphere: {e}")))
    }
}

/// Hexagons at the most: more are a map gone wrong.
const MOST: usize = 1_000_000;

/// Corners of a hexagon at 0, 60, ... degrees, in thirds of the lattice's basis: the mean of its
/// place and those of two neighbours.
fn corners((q, r): (i32, i32)) -> [(i32, i32); 6] {
    std::array::from_fn(|k| {
        let (a, b) = (NEIGHBOURS[(k + 5) % 6], NEIGHBOURS[k]);
        (3 * q + a.0 + b.0, 3 * r + a.1 + b.1)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_way_is_found_back() {
        let map = ConformalMap {
            origin: PlanePoint::new(0.1, -0.2),
            unit: 0.7,
            coefficients: std::array::from_fn(|k| PlanePoint::new(0.3, -0.2) / (k + 1) as f64),
        };
        let from = PlanePoint::new(0.3, 0.1);
        let step = PlanePoint::new(-0.05, 0.08);
        let there = map.moved(from, step).unwrap();
        let back = map.moved(there, -step).unwrap();
        assert!((back - from).norm() < 1e-12, "{back}");
        let slope =
            (map.way(from, from + PlanePoint::from(1e-5)) / 1e-5 - map.derivative(from)).norm();
        assert!(slope < 1e-4, "{slope}");
    }

    #[test]
    fn neighbouring_hexagons_share_two_corners() {
        let own: BTreeSet<_> = corners((2, -1)).into_iter().collect();
        assert_eq!(own.len(), 6);
        for (q, r) in NEIGHBOURS {
            let other = corners((2 + q, -1 + r));
            assert_eq!(other.iter().filter(|c| own.contains(c)).count(), 2);
        }
    }
}
