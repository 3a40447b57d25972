//! Where a vertex goes when its faces move along their normals: the vector `x` with `x . N_i =
//! d_i`.
//!
//! Four ways, none of which is good everywhere:
//!
//! | way | formula | loses digits |
//! |---|---|---|
//! | [`TangentWeights`](NormalMethod::TangentWeights) | `sum (tan beta_i + tan gamma_i) N_i`, scaled to `x . N_i = 1` (the paper, section 4) | at nearly folded edges |
//! | [`ThreePlanes`](NormalMethod::ThreePlanes) | the 3 x 3 system | `1e-16 / slope` at nearly flat vertices |
//! | [`MitrePlanes`](NormalMethod::MitrePlanes) | `x` lies in the plane of each edge `e` and the sum of its two normals: two such planes meet in `x` | at nearly folded edges |
//! | [`MinimumNorm`](NormalMethod::MinimumNorm) | truncated singular values | nothing, but it applies only where planes coincide or are fewer than three |
//!
//! `beta_i = (t_i + t_(i+1) - t_(i-1)) / 2`, `gamma_i = (t_i + t_(i-1) - t_(i+1)) / 2` with the
//! interior angles `t_i` in (0, 2 pi). At a 90/90/180 corner two tangents are huge, yet nothing is
//! lost: both large weights share one of them.
//!
//! Where two faces lie in one plane, any point of a line will do; the mitre planes then choose the
//! one that keeps edges parallel, as it is the limit of faces that come to lie in one plane.
//!
//! Each way states what rounding may have done to its result, and the smallest such error decides;
//! so small residuals alone can't win, as they would for the 3 x 3 system at a flat vertex.

use nalgebra::{Matrix3, SVD};
use phex_mesh::Vec3;
use serde::Serialize;

/// Singular values below this, relative to the largest, are zero: the planes coincide.
const RANK: f64 = 1e-13;
/// Rounding errors of normals and right-hand sides, in machine epsilons.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Error of the best of the other ways above which the planes count as leaving a choice.
const HOPELESS: f64 = 1e-6;

/// How a displacement was computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NormalMethod {
    /// The paper's weights.
    TangentWeights,
    /// Intersection of three planes.
    ThreePlanes,
    /// Intersection of two planes that halve the angles at edges.
    MitrePlanes,
    /// The shortest vector, where the planes leave a choice.
    MinimumNorm,
}

/// A displacement with what is known of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Displacement {
    /// The vector `x`.
    pub vector: Vec3,
    /// How it was computed.
    pub method: NormalMethod,
    /// First-order estimate of its error over its length; infinite where nothing can be said.
    pub error: f64,
    /// Largest `|x . N_i - d_i|`.
    pub residual: f64,
}

impl Displacement {
    fn new(vector: Vec3, method: NormalMethod, error: f64, normals: &[Vec3], d: &[f64]) -> Self {
        let miss = |(n, d): (&Vec3, &f64)| (vector.dot(n) - d).abs();
        let residual = normals.iter().zip(d).map(miss).fold(0.0, f64::max);
        let known = vector.iter().all(|x| x.is_finite()) && error.is_finite();
        let missed = residual / vector.norm().max(f64::MIN_POSITIVE);
        Self {
            vector,
            method,
            error: if known {
                error.max(missed)
            } else {
                f64::INFINITY
            },
            residual,
        }
    }

    fn better(self, other: Self) -> Self {
        if other.error < self.error {
            other
        } else {
            self
        }
    }
}

/// An inner vertex of three faces: face `i` lies between edges `i` and `i + 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrivalentVertex {
    /// Unit normals of the faces, in cyclic order.
    pub normals: [Vec3; 3],
    /// Edges from the vertex to its neighbours, of any length, counter-clockwise.
    pub edges: [Vec3; 3],
}

impl TrivalentVertex {
    /// Interior angle of each face, in (0, 2 pi).
    pub fn angles(&self) -> [f64; 3] {
        let (e, n) = (&self.edges, &self.normals);
        std::array::from_fn(|i| angle_between(&e[i], &e[(i + 1) % 3], &n[i]))
    }
}

/// Angle in [0, 2 pi) from `a` counter-clockwise about the unit vector `normal` to `b`.
fn angle_between(a: &Vec3, b: &Vec3, normal: &Vec3) -> f64 {
    let angle = normal.dot(&a.cross(b)).atan2(a.dot(b));
    if angle < 0.0 {
        angle + std::f64::consts::TAU
    } else {
        angle
    }
}

/// The vector with `x . N_i = 1` at a vertex of three faces.
pub fn vertex_normal(vertex: &TrivalentVertex) -> Displacement {
    let normals = &vertex.normals;
    let best = three_planes(normals, &[1.0; 3])
        .better(tangent_weights(normals, &vertex.angles()))
        .better(mitre_planes(vertex));
    if best.error > HOPELESS {
        best.better(minimum_norm(normals, &[1.0; 3]))
    } else {
        best
    }
}

/// The vector with `x . N_i = d_i` at a vertex of three faces: the mean distance along the vertex
/// normal, and the rest.
pub(crate) fn three_face_displacement(vertex: &TrivalentVertex, d: &[f64; 3]) -> Displacement {
    let (normals, normal) = (&vertex.normals, vertex_normal(vertex));
    let mean = d.iter().sum::<f64>() / 3.0;
    let rest = d.map(|d| d - mean);
    let main = normal.vector * mean;
    if rest == [0.0; 3] {
        return Displacement::new(main, normal.method, normal.error, normals, d);
    }
    let tilt = three_planes(normals, &rest).better(minimum_norm(normals, &rest));
    let vector = main + tilt.vector;
    let error = normal.error * main.norm() + tilt.error * tilt.vector.norm();
    let error = error / vector.norm().max(f64::MIN_POSITIVE);
    Displacement::new(vector, tilt.method, error, normals, d)
}

/// The shortest vector with `x . N_i = d_i` for one, two or three faces; where planes coincide but
/// their distances differ it halves the difference, which the residual tells.
///
/// # Panics
/// If there are more than three faces, or not as many distances.
pub(crate) fn minimum_norm(normals: &[Vec3], d: &[f64]) -> Displacement {
    let method = NormalMethod::MinimumNorm;
    match (normals, d) {
        ([n], [d]) => Displacement::new(n * *d, method, ROUNDING, &[*n], &[*d]),
        ([n, m], [c, d]) => {
            let (vector, error) = shortest_for_two(*n, *m, *c, *d);
            Displacement::new(vector, method, error, normals, &[*c, *d])
        }
        ([_, _, _], [_, _, _]) => {
            let (vector, error) = truncated(normals, d);
            Displacement::new(vector, method, error, normals, d)
        }
        _ => panic!("one to three faces, with a distance each"),
    }
}

/// Sum and difference of two unit vectors are the singular directions of their 2 x 3 system.
fn shortest_for_two(n: Vec3, m: Vec3, c: f64, d: f64) -> (Vec3, f64) {
    let part = |direction: Vec3, value: f64| {
        let squared = direction.norm_squared();
        if squared.sqrt() > RANK {
            (direction * (value / squared), ROUNDING / squared.sqrt())
        } else {
            (Vec3::zeros(), 0.0)
        }
    };
    let (even, even_error) = part(n + m, c + d);
    let (odd, odd_error) = part(n - m, c - d);
    let vector = even + odd;
    let error = even_error * even.norm() + odd_error * odd.norm();
    (
        vector,
        ROUNDING + error / vector.norm().max(f64::MIN_POSITIVE),
    )
}

fn truncated(normals: &[Vec3], d: &[f64]) -> (Vec3, f64) {
    let svd = SVD::new(rows(normals), true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
        return (Vec3::zeros(), f64::INFINITY);
    };
    let b = u.transpose() * Vec3::from_column_slice(d);
    let cut = RANK * svd.singular_values.max();
    let mut vector = Vec3::zeros();
    let mut least = f64::INFINITY;
    for (k, &sigma) in svd.singular_values.iter().enumerate() {
        if sigma > cut {
            vector += v_t.row(k).transpose() * (b[k] / sigma);
            least = least.min(sigma);
        }
    }
    (vector, 2.0 * ROUNDING / least)
}

fn rows(normals: &[Vec3]) -> Matrix3<f64> {
    Matrix3::from_rows(&[
        normals[0].transpose(),
        normals[1].transpose(),
        normals[2].transpose(),
    ])
}

/// The 3 x 3 system, with the componentwise error bound of Skeel: it sees when small columns are
/// harmless.
fn three_planes(normals: &[Vec3; 3], d: &[f64; 3]) -> Displacement {
    let method = NormalMethod::ThreePlanes;
    let matrix = rows(normals);
    let rhs = Vec3::from_column_slice(d);
    let solved = matrix.lu().solve(&rhs);
    let (Some(x), Some(inverse)) = (solved, matrix.try_inverse()) else {
        return Displacement::new(Vec3::zeros(), method, f64::INFINITY, normals, d);
    };
    let spread = inverse.abs() * (matrix.abs() * x.abs() + rhs.abs());
    let error = ROUNDING * spread.norm() / x.norm().max(f64::MIN_POSITIVE);
    Displacement::new(x, method, error, normals, d)
}

/// The paper's weights.
fn tangent_weights(normals: &[Vec3; 3], angles: &[f64; 3]) -> Displacement {
    // gamma_i = beta_(i-1), so that tangent k weighs N_k + N_(k+1).
    let tangent = |k: usize| (0.5 * (angles[k] + angles[(k + 1) % 3] - angles[(k + 2) % 3])).tan();
    let tangents = [tangent(0), tangent(1), tangent(2)];
    let weight = |i: usize| tangents[i] + tangents[(i + 2) % 3];
    let sum: Vec3 = (0..3).map(|i| normals[i] * weight(i)).sum();
    let along: f64 = normals.iter().map(|n| n.dot(&sum)).sum();
    let vector = sum * (3.0 / along);
    let error = weight_error(normals, &tangents, sum, along);
    Displacement::new(
        vector,
        NormalMethod::TangentWeights,
        error,
        normals,
        &[1.0; 3],
    )
}

/// What rounding of the angles and of the normals does to the direction of the weighted sum.
fn weight_error(normals: &[Vec3; 3], tangents: &[f64; 3], sum: Vec3, along: f64) -> f64 {
    let length = sum.norm();
    let direction = sum / length;
    let mut error = 0.0;
    for (k, t) in tangents.iter().enumerate() {
        let pair = normals[k] + normals[(k + 1) % 3];
        let across = pair - direction * direction.dot(&pair);
        error += (1.0 + t * t) * across.norm() + 2.0 * t.abs();
    }
    let scale = 3.0 * length / along.abs();
    ROUNDING * (error / length).max(1.0) * scale.max(1.0)
}

/// The best of the three pairs of mitre planes.
fn mitre_planes(vertex: &TrivalentVertex) -> Displacement {
    let pair = |k: usize| mitre_pair(vertex, [k, (k + 1) % 3]);
    pair(0).better(pair(1)).better(pair(2))
}

/// Where the mitre planes of two edges meet.
fn mitre_pair(vertex: &TrivalentVertex, edges: [usize; 2]) -> Displacement {
    let normals = &vertex.normals;
    // Edge k lies between the faces k - 1 and k.
    let sums = edges.map(|k| normals[(k + 2) % 3] + normals[k]);
    let across = [0, 1].map(|i| {
        let across = sums[i].cross(&vertex.edges[edges[i]]);
        across.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
    });
    let line = across[0].cross(&across[1]);
    let along: f64 = normals.iter().map(|n| n.dot(&line)).sum();
    let vector = line * (3.0 / along);
    let sharpness = sums.iter().map(|s| 1.0 / s.norm()).sum::<f64>();
    let scale = (3.0 * line.norm() / along.abs()).max(1.0);
    let error = ROUNDING * (1.0 + sharpness / line.norm()) * scale;
    Displacement::new(vector, NormalMethod::MitrePlanes, error, normals, &[1.0; 3])
}
