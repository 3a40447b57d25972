//! Circles of the sphere as vectors of Lorentz space, and the Moebius transformation that balances
//! their touching points.
//!
//! The circle in which the plane `N . X = d` cuts the unit sphere is `(N, d)`; the cap inside is `N
//! . X > d`, the pole `N / d`. A point `X` of the sphere is `(X, 1)`. Moebius transformations are
//! linear: they are the Lorentz transformations.

use super::layout::{PlaneCircle, PlaneLayout};
use super::polish::Poles;
use super::touching_points;
use nalgebra::{Matrix3, Matrix4, Vector4};
use phex_mesh::{HexMesh, PerEdge, Vec2, Vec3};

/// Newton steps of the normalisation at the most.
const MAX_STEPS: usize = 100;

/// Largest step of the normalisation; 1 would be infinitely far.
const LARGEST_STEP: f64 = 0.8;

/// Circles and touching points on the sphere.
#[derive(Clone, Debug)]
pub(super) struct SphereCircles {
    /// Lorentz vector of each circle.
    pub circles: Vec<Vector4<f64>>,
    /// Lorentz vector of each touching point, last coordinate 1.
    pub touching: PerEdge<Vector4<f64>>,
}

impl SphereCircles {
    /// Inverse stereographic projection of `factor (z - origin)` (a product of complex numbers),
    /// the origin to the north pole, angles keeping their sense as seen from outside.
    pub fn project(layout: &PlaneLayout, origin: Vec2, factor: Vec2) -> Self {
        let turn = |z: Vec2| {
            Vec2::new(
                factor.x * z.x - factor.y * z.y,
                factor.x * z.y + factor.y * z.x,
            )
        };
        let scale = factor.norm();
        let lift = |circle: &PlaneCircle| match *circle {
            PlaneCircle::Circle { centre, radius } => {
                lift_circle(turn(centre - origin), radius * scale)
            }
            PlaneCircle::HalfPlane { normal, offset } => {
                let offset = (offset - normal.dot(&origin)) * scale;
                let normal = turn(normal) / scale;
                Vector4::new(normal.x, normal.y, -offset, offset)
            }
        };
        let point = |z: &Option<Vec2>| match z {
            Some(z) => lift_point(turn(z - origin)),
            None => Vector4::new(0.0, 0.0, -1.0, 1.0),
        };
        Self {
            circles: layout.circles.iter().map(lift).collect(),
            touching: layout.touching.map(point),
        }
    }

    /// Applies the Moebius transformation that brings the mean of the touching points to the
    /// centre.
    pub fn normalise(&mut self) {
        let transformation = balancing(self.touching.as_slice());
        self.circles
            .iter_mut()
            .for_each(|c| *c = transformation * *c);
    }

    /// Pole of a circle: the tip of the cone that touches the sphere along it.
    pub fn pole(&self, node: usize) -> Vec3 {
        self.circles[node].xyz() / self.circles[node].w
    }
}

/// Brings the mean of the touching points to the centre.
pub(super) fn balance(poles: &mut Poles, input: &HexMesh) {
    let mesh = input.with_positions(poles.vertices.clone());
    let touching: Vec<Vector4<f64>> = touching_points(&mesh)
        .iter()
        .map(|p| homogeneous(&p.normalize()))
        .collect();
    let transformation = balancing(&touching);
    let moved = |p: &Vec3| unit(&(transformation * homogeneous(p)));
    poles.vertices = poles.vertices.map(moved);
    poles.faces = poles.faces.map(moved);
}

fn homogeneous(p: &Vec3) -> Vector4<f64> {
    p.push(1.0)
}

/// The Moebius transformation that brings the mean of points of the sphere to the centre.
fn balancing(touching: &[Vector4<f64>]) -> Matrix4<f64> {
    let mut transformation = Matrix4::identity();
    let points =
        |t: &Matrix4<f64>| -> Vec<Vec3> { touching.iter().map(|p| unit(&(t * p))).collect() };
    let mut current = points(&transformation);
    for _ in 0..MAX_STEPS {
        let Some(velocity) = balancing_step(&current) else {
            break;
        };
        let next = boost(velocity) * transformation;
        let moved = points(&next);
        if mean(&moved).norm() >= mean(&current).norm() && velocity.norm() < 1e-6 {
            break;
        }
        (transformation, current) = (next, moved);
    }
    transformation
}

fn lift_circle(c: Vec2, r: f64) -> Vector4<f64> {
    let power = c.norm_squared() - r * r;
    Vector4::new(2.0 * c.x, 2.0 * c.y, 1.0 - power, 1.0 + power)
}

fn lift_point(z: Vec2) -> Vector4<f64> {
    lift_circle(z, 0.0) / (1.0 + z.norm_squared())
}

fn unit(p: &Vector4<f64>) -> Vec3 {
    p.xyz() / p.w
}

fn mean(points: &[Vec3]) -> Vec3 {
    points.iter().sum::<Vec3>() / points.len().max(1) as f64
}

/// Damped Newton step for the minimum of `sum_p log (1 - p . a) - log(1 - |a|^2) / 2` at `a = 0`
/// (Springborn 2005); `None` if no step lowers it.
fn balancing_step(points: &[Vec3]) -> Option<Vec3> {
    let sum: Vec3 = points.iter().sum();
    let hessian: Matrix3<f64> = points
        .iter()
        .map(|p| Matrix3::identity() - p * p.transpose())
        .sum();
    let mut step = hessian.try_inverse()? * sum;
    if step.norm() > LARGEST_STEP {
        step *= LARGEST_STEP / step.norm();
    }
    while step.norm() > f64::EPSILON {
        let energy = |a: Vec3| -> f64 {
            let cone: f64 = points.iter().map(|p| (-p.dot(&a)).ln_1p()).sum();
            cone - 0.5 * points.len() as f64 * (-a.norm_squared()).ln_1p()
        };
        if step.norm() < 1e-4 || energy(step) < 0.0 {
            return Some(step);
        }
        step *= 0.5;
    }
    None
}

/// The Lorentz transformation that brings the point `velocity` of the ball to its centre.
fn boost(velocity: Vec3) -> Matrix4<f64> {
    let square = velocity.norm_squared();
    let gamma = 1.0 / (1.0 - square).sqrt();
    // `(gamma - 1) / square` without cancellation.
    let stretch = gamma * gamma / (gamma + 1.0);
    let mut matrix = Matrix4::identity();
    let block = Matrix3::identity() + velocity * velocity.transpose() * stretch;
    matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&block);
    matrix
        .fixed_view_mut::<3, 1>(0, 3)
        .copy_from(&(-velocity * gamma));
    matrix
        .fixed_view_mut::<1, 3>(3, 0)
        .copy_from(&(-velocity.transpose() * gamma));
    matrix[(3, 3)] = gamma;
    matrix
}
