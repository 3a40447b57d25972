//! The map from the user's coordinates to those in which all stages work, and back.

use nalgebra::{Matrix3, SymmetricEigen};
use phex_mesh::{TriangleSurface, Vec3};

/// Slope, height over length, that a shallow surface is brought to: lengths on it then differ by
/// at most half a hundredth from those on the surface itself, and the optimiser holds its shape.
const STEEP: f64 = 0.1;
/// Share of a surface's area that is no steeper than its slope; slivers of tessellations may be.
const USUAL: f64 = 0.99;
/// Largest factor of heights: what is flatter than a hundredth is flat up to noise as often as not.
const MOST: f64 = 10.0;
/// Sine of the angle up to which an axis is taken for that of a coordinate, so that mirror planes
/// of a surface that stands upright remain mirror planes to the last bit.
const UPRIGHT: f64 = 2e-3;
/// Sine of the angle within which an isometry leaves the axis where it is: rounding.
const ALONG: f64 = 1e-14;

/// Affinity from model coordinates to normalised ones: `(p - centre) / scale`, with heights along
/// an axis `factor` times as large.
///
/// Planes stay planes, and so a planar mesh of the surface with raised heights is one of the
/// surface. On a surface that is nearly flat the optimiser would else give up its shape: a camber
/// of a tenth of an edge costs less than panels that are a little uneven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affinity {
    /// Centre of the bounding box, model units.
    pub centre: Vec3,
    /// Diagonal of the bounding box, model units.
    pub scale: f64,
    /// Direction of the heights, a unit vector.
    pub axis: Vec3,
    /// What heights are multiplied by, at least 1.
    pub factor: f64,
}

impl Affinity {
    /// The similarity that gives a surface diagonal 1 and its box centre at the origin.
    pub fn normalising(surface: &TriangleSurface) -> Self {
        let (low, high) = surface.bounding_box();
        Self {
            centre: (low + high) * 0.5,
            scale: (high - low).norm(),
            axis: Vec3::z(),
            factor: 1.0,
        }
    }

    /// The same map with heights raised where `normalised`, the surface in normalised coordinates,
    /// is shallow: seen from one side, with hardly a triangle steeper than 1 to 10.
    pub(super) fn raising(self, normalised: &TriangleSurface) -> Self {
        let axis = mean_direction(normalised);
        let factor = STEEP / usual_slope(normalised, axis);
        match factor > 1.0 {
            true => Self {
                axis,
                factor: crate::ranges::without_unit(factor.min(MOST)),
                ..self
            },
            false => self,
        }
    }

    /// Model to normalised coordinates.
    pub fn normalise(&self, p: Vec3) -> Vec3 {
        self.raised((p - self.centre) / self.scale)
    }

    /// Normalised to model coordinates.
    pub fn restore(&self, p: Vec3) -> Vec3 {
        self.restore_vector(p) + self.centre
    }

    /// A vector between two places in normalised coordinates, in model coordinates.
    pub fn restore_vector(&self, v: Vec3) -> Vec3 {
        along(v, self.axis, 1.0 / self.factor) * self.scale
    }

    /// Whether the images of a plane mesh under an isometry of normalised coordinates, of which
    /// this is the linear part, are images of it in the model, too.
    pub(crate) fn keeps(&self, map: &Matrix3<f64>) -> bool {
        self.factor == 1.0 || (map * self.axis).cross(&self.axis).norm() < ALONG
    }

    /// A place in normalised coordinates whose height is still as the model's.
    pub(super) fn raised(&self, p: Vec3) -> Vec3 {
        along(p, self.axis, self.factor)
    }
}

/// A vector with its part along an axis multiplied by a factor.
fn along(v: Vec3, axis: Vec3, factor: f64) -> Vec3 {
    match factor == 1.0 {
        true => v,
        false => v + axis * ((factor - 1.0) * axis.dot(&v)),
    }
}

/// The direction that a surface's normals are closest to: the axis of largest inertia of the
/// normals, weighted by area, on the side to which most of them point.
fn mean_direction(surface: &TriangleSurface) -> Vec3 {
    let faces = || surface.topology().faces().map(|f| surface.area_vector(f));
    let mut inertia = Matrix3::zeros();
    for area in faces().filter(|a| a.norm() > 0.0) {
        inertia += area * area.transpose() / area.norm();
    }
    let eigen = SymmetricEigen::new(inertia);
    let axis: Vec3 = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into();
    let upwards = axis.dot(&faces().sum::<Vec3>()).signum();
    let axis = axis.normalize() * upwards;
    let along = axis.iamax();
    let upright = Vec3::ith(along, axis[along].signum());
    match (axis - upright).norm() < UPRIGHT {
        true => upright,
        false => axis,
    }
}

/// The slope that nearly all of a surface keeps to, seen from the side to which an axis points;
/// infinite where more of it is seen from the other side.
fn usual_slope(surface: &TriangleSurface, axis: Vec3) -> f64 {
    let slope = |area: Vec3| {
        let height = area.dot(&axis);
        match height > 0.0 {
            true => (area - axis * height).norm() / height,
            false => f64::INFINITY,
        }
    };
    let areas = surface.topology().faces().map(|f| surface.area_vector(f));
    let mut slopes: Vec<(f64, f64)> = areas.map(|a| (slope(a), a.norm())).collect();
    slopes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let usual = USUAL * slopes.iter().map(|s| s.1).sum::<f64>();
    let mut below = 0.0;
    let steepest = slopes.iter().find(|(_, area)| {
        below += area;
        below >= usual
    });
    steepest.map_or(f64::INFINITY, |s| s.0)
}

#[cfg(test)]
mod tests {
    use super::super::Normalised;
    use super::*;

    /// A roof of 30 by 20 with a camber, turned by an angle about the first axis.
    fn roof(camber: f64, angle: f64) -> TriangleSurface {
        let turn = nalgebra::Rotation3::from_axis_angle(&Vec3::x_axis(), angle);
        let at = |i: u32, j: u32| {
            let [u, v] = [i, j].map(|k| f64::from(k) / 20.0);
            let pi = std::f64::consts::PI;
            turn * Vec3::new(30.0 * u, 20.0 * v, camber * (pi * u).sin() * (pi * v).sin())
        };
        let places = (0..21 * 21).map(|k| at(k % 21, k / 21)).collect();
        let cells = (0..20 * 20).map(|k| k / 20 * 21 + k % 20);
        let halves = cells.flat_map(|k| [[k, k + 1, k + 22], [k, k + 22, k + 21]]);
        TriangleSurface::new(places, &halves.collect::<Vec<[u32; 3]>>()).unwrap()
    }

    #[test]
    fn heights_of_shallow_surfaces_are_raised_along_their_axis() {
        let factor = |camber: f64| Normalised::raised(&roof(camber, 0.0)).affinity.factor;
        let steepest = std::f64::consts::PI * 0.1 / 20.0;
        assert!((factor(0.1) * steepest / STEEP - 1.0).abs() < 0.1);
        assert_eq!([factor(2.0), factor(0.001)], [1.0, MOST]);
        let turned = Normalised::raised(&roof(0.1, 0.7)).affinity;
        let axis = Vec3::new(0.0, -(0.7_f64.sin()), 0.7_f64.cos());
        assert!((turned.axis - axis).norm() < 1e-9 && (turned.factor - factor(0.1)).abs() < 1e-6);
        assert_eq!(Normalised::raised(&roof(0.1, 0.0)).affinity.axis, Vec3::z());
    }

    #[test]
    fn a_raised_place_comes_back() {
        let surface = roof(0.1, 0.7);
        let model = Normalised::raised(&surface);
        let there = model.surface.positions().iter();
        for (p, q) in surface.positions().iter().zip(there) {
            assert!((model.affinity.restore(*q) - p).norm() < 1e-7);
            assert!((model.affinity.normalise(*p) - q).norm() < 1e-8);
        }
    }

    #[test]
    fn two_sides_are_no_heights() {
        let thin = |p: &Vec3| Vec3::new(p.x, p.y, 1e-4 * p.z);
        let shape = phex_mesh::shapes::Shape::from_name("sphere", &[]).unwrap();
        let sphere = phex_mesh::shapes::triangulate(&shape, &Default::default()).unwrap();
        assert_eq!(
            Normalised::raised(&sphere.mapped(thin)).affinity.factor,
            1.0
        );
    }
}
