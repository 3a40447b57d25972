//! Newton's method on the tangency and planarity of a nearly finished Koebe mesh, in space.
//!
//! Unknowns are the vertices `x_v` and the poles `y_f` of the face planes; the equations are
//!
//! ```text
//! x_v . y_f = 1                                   the vertex lies in the plane
//! x_a . x_b + sqrt(|x_a|^2 - 1) sqrt(|x_b|^2 - 1) = 1   the edge touches the sphere
//! ```
//!
//! as many as there are unknowns but for the (six, on a closed mesh) directions of Moebius
//! transformations; a step is that of least squares, nearly of minimum norm. Unknowns are scaled by
//! the size of their circle along the sphere.

use nalgebra::{Matrix3, SVector};
use phex_mesh::{PerFace, PerVertex, Topology, Vec3};
use phex_numeric::assembly::packed;
use phex_numeric::{
    Assembly, Cholesky, NumericError, Outcome, Record, Status, SymmetricMatrix, largest,
};

/// Shifts of the normal equations, whose diagonal is about 1, until they factorise. They decide the
/// Moebius directions and, where circles are so small that rounding decides, the tangential ones.
const SHIFTS: [f64; 3] = [1e-13, 1e-11, 1e-9];

/// Residual at which nothing can be gained any more.
const FLOOR: f64 = 1e-15;

/// Residual that counts as converged.
const GOAL: f64 = 1e-13;

/// Inverse of the size of circles that begin to be held back.
const HOLD: f64 = 1e4;

type Block = SVector<f64, 6>;

/// Vertices and face poles.
#[derive(Clone)]
pub(super) struct Poles {
    pub vertices: PerVertex<Vec3>,
    pub faces: PerFace<Vec3>,
}

struct Equation {
    /// Numbers of the two points that it joins, vertices first.
    ends: [usize; 2],
    touches: bool,
}

/// Polishes in place, with at most `max_iterations` factorisations.
pub(super) fn polish(
    topology: &Topology,
    poles: &mut Poles,
    max_iterations: usize,
    report: &impl Fn(usize, &Record) -> bool,
) -> Result<Outcome, NumericError> {
    let equations = equations(topology);
    let unknowns: Vec<Vec<u32>> = equations.iter().map(|e| unknowns(e.ends)).collect();
    let mut points: Vec<Vec3> = poles
        .vertices
        .iter()
        .chain(poles.faces.iter())
        .copied()
        .collect();
    let assembly = Assembly::new(3 * points.len(), &unknowns);
    let mut matrix = SymmetricMatrix::zeros(assembly.pattern().clone());
    let mut cholesky = Cholesky::analyse(assembly.pattern(), 3)?;
    let mut outcome = Outcome::empty(Status::IterationLimit);
    let mut residual = largest_residual(&equations, &points);
    while residual > FLOOR && outcome.iterations < max_iterations {
        let frames: Vec<Matrix3<f64>> = points.iter().map(scaled_frame).collect();
        let rows: Vec<Block> = equations.iter().map(|e| row(e, &points, &frames)).collect();
        assembly.assemble(&blocks(&rows), &mut matrix);
        if !factorise(&mut cholesky, &matrix) {
            outcome.status = Status::NumericalBreakdown;
            break;
        }
        let mut step = right_side(&equations, &points, &rows, matrix.dimension());
        cholesky.solve(&mut step);
        let moved = moved(&points, &frames, &step);
        let reached = largest_residual(&equations, &moved);
        outcome.iterations += 1;
        if reached.is_nan() || reached >= residual {
            outcome.status = Status::Stalled;
            break;
        }
        let record = record(reached, &points, &moved);
        outcome.history.push(record);
        let at_floor = reached <= GOAL && reached > 0.1 * residual;
        (points, residual) = (moved, reached);
        if at_floor {
            break;
        }
        if !report(outcome.iterations, &record) {
            outcome.status = Status::Cancelled;
            break;
        }
    }
    outcome.factorisations = cholesky.factorisations();
    if residual <= GOAL && outcome.status != Status::Cancelled {
        outcome.status = Status::Converged;
    }
    let n = poles.vertices.len();
    poles.vertices = PerVertex::from_vec(points[..n].to_vec());
    poles.faces = PerFace::from_vec(points[n..].to_vec());
    Ok(outcome)
}

fn factorise(cholesky: &mut Cholesky, matrix: &SymmetricMatrix) -> bool {
    SHIFTS
        .iter()
        .any(|&shift| cholesky.refactor_shifted(matrix, shift).is_ok())
}

fn record(residual: f64, before: &[Vec3], after: &[Vec3]) -> Record {
    let moves = before.iter().zip(after).map(|(a, b)| (a - b).norm());
    Record {
        phase: 1.0,
        energy: f64::NAN,
        residual,
        step: moves.fold(0.0, f64::max),
        fraction: 1.0,
        damping: 0.0,
    }
}

fn equations(t: &Topology) -> Vec<Equation> {
    let incidence = t.half_edges().map(|h| Equation {
        ends: [t.origin(h).index(), t.n_vertices() + t.face(h).index()],
        touches: false,
    });
    let tangency = t.edges().map(|e| Equation {
        ends: t.edge_vertices(e).map(|v| v.index()),
        touches: true,
    });
    incidence.chain(tangency).collect()
}

fn unknowns(ends: [usize; 2]) -> Vec<u32> {
    ends.iter()
        .flat_map(|&p| (0..3).map(move |k| (3 * p + k) as u32))
        .collect()
}

/// Length of the tangents from a point to the unit sphere.
pub(super) fn tangent_length(x: &Vec3) -> f64 {
    (x.norm_squared() - 1.0).max(0.0).sqrt()
}

fn floored_length(x: &Vec3) -> f64 {
    tangent_length(x).max(1e-9)
}

/// Weight with which the equation of tangency is about twice the distance of the edge to the
/// sphere.
fn weight(ta: f64, tb: f64) -> f64 {
    4.0 * ta * tb / (ta + tb).powi(2)
}

fn value(e: &Equation, points: &[Vec3]) -> f64 {
    let [mut a, mut b] = e.ends.map(|p| points[p]);
    if b.norm_squared() > a.norm_squared() {
        std::mem::swap(&mut a, &mut b);
    }
    // `(a - b) . b + (|b|^2 - 1)` keeps the digits of short edges.
    let dot = (a - b).dot(&b) + (b.norm_squared() - 1.0);
    if !e.touches {
        return dot;
    }
    let (ta, tb) = (floored_length(&a), floored_length(&b));
    weight(ta, tb) * (dot + ta * tb)
}

fn largest_residual(equations: &[Equation], points: &[Vec3]) -> f64 {
    largest(equations.iter().map(|e| value(e, points).abs()))
}

/// Axes along which a unit step changes the equations by about 1: the radius, and longer ones along
/// the sphere. Circles so small that rounding of the positions moves them are held back.
fn scaled_frame(x: &Vec3) -> Matrix3<f64> {
    let radial = x / x.norm();
    let radial = radial * radial.transpose();
    let size = tangent_length(x);
    let along = (1.0 / size.clamp(0.1, 1.0)).min(HOLD * floored_length(x));
    radial + (Matrix3::identity() - radial) * along
}

fn row(e: &Equation, points: &[Vec3], frames: &[Matrix3<f64>]) -> Block {
    let [a, b] = e.ends.map(|p| points[p]);
    let (mut by_a, mut by_b) = (b, a);
    if e.touches {
        let (ta, tb) = (floored_length(&a), floored_length(&b));
        by_a = (by_a + a * (tb / ta)) * weight(ta, tb);
        by_b = (by_b + b * (ta / tb)) * weight(ta, tb);
    }
    let (by_a, by_b) = (frames[e.ends[0]] * by_a, frames[e.ends[1]] * by_b);
    Block::new(by_a.x, by_a.y, by_a.z, by_b.x, by_b.y, by_b.z)
}

fn blocks(rows: &[Block]) -> Vec<f64> {
    let mut blocks = Vec::with_capacity(rows.len() * packed(6, 0));
    for row in rows {
        for a in 0..6 {
            blocks.extend((0..=a).map(|b| row[a] * row[b]));
        }
    }
    blocks
}

fn right_side(equations: &[Equation], points: &[Vec3], rows: &[Block], n: usize) -> Vec<f64> {
    let mut rhs = vec![0.0; n];
    for (e, row) in equations.iter().zip(rows) {
        let defect = -value(e, points);
        for (k, u) in unknowns(e.ends).into_iter().enumerate() {
            rhs[u as usize] += row[k] * defect;
        }
    }
    rhs
}

fn moved(points: &[Vec3], frames: &[Matrix3<f64>], step: &[f64]) -> Vec<Vec3> {
    let shift = |(i, x): (usize, &Vec3)| {
        x + frames[i] * Vec3::new(step[3 * i], step[3 * i + 1], step[3 * i + 2])
    };
    points.iter().enumerate().map(shift).collect()
}
