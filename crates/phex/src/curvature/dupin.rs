//! Dupin's indicatrix, and how well panels are inscribed in it.
//!
//! In principal coordinates of the tangent plane the indicatrix is `k1 x^2 + k2 y^2 = +-1`: an
//! ellipse where `K > 0`, two hyperbolas where `K < 0`, parallel lines where one curvature
//! vanishes. Theorem 1 of W. Wang and Y. Liu, "A note on planar hexagonal meshes" (2010): in the
//! limit of small panels each is inscribed in a homothetic copy of the indicatrix at its centre.
//! Here this is measured: the conic
//!
//! `F = k1 x^2 + k2 y^2 + a x + b y + c = 0`
//!
//! has the shape of the indicatrix, moved and scaled; `a, b, c` are fitted to the corners, and a
//! corner is off by `|F| / |grad F|`, to first order.
//!
//! The theorem speaks of panels whose corners lie on the surface. Where the panel so inscribed
//! would have a very short edge, as between two parabolic curves of different families, panels are
//! held open instead and leave the indicatrix by a share that does not fall with their size.
//! [`free_panels`] are the others; for them the mean falls nearly at first order, for all panels
//! the median does.
//!
//! Guaranteed: 0 for corners on a homothetic copy, also after rotation, translation, scaling of the
//! model. Not defined where the surface is flat (`None`), and no test of anything for fewer than
//! five corners.

use super::{Curvature, Principal, large_curvature, principal};
use nalgebra::{DMatrix, DVector, Matrix3};
use phex_mesh::{
    FaceId, FacePlane, FlatFace, HexMesh, PerFace, SurfacePoint, TriangleSurface, Vec2, Vec3,
    VertexId,
};

/// Curvatures below one over this many radii of a panel are flat.
const FLAT: f64 = 1e-6;
/// Share of the surface's large curvatures below which a panel lies in a flat part, where
/// third-order terms decide its shape.
const FLAT_REL: f64 = 0.05;
/// Corners fewer than these always lie on a conic of the given shape, or nearly.
const LEAST_CORNERS: usize = 5;
/// Points of one branch of a drawn indicatrix.
const SAMPLES: usize = 48;

/// Dupin's indicatrix at a point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Indicatrix {
    /// The point.
    pub point: Vec3,
    /// Unit normal.
    pub normal: Vec3,
    /// Principal curvatures (1 / length, positive where convex from the side of the normal) and
    /// directions.
    pub principal: Principal,
}

impl Indicatrix {
    /// At a point of a surface whose curvature is known at its vertices.
    ///
    /// ```
    /// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
    /// # let options = TriangulationOptions { triangles: 2000, ..Default::default() };
    /// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
    /// use phex::curvature::Indicatrix;
    /// use phex::curvature::{CurvatureOptions, curvature};
    /// use phex_mesh::Vec3;
    ///
    /// let curvature = curvature(&sphere, 0.2, &CurvatureOptions::default());
    /// let point = sphere.closest_point(Vec3::new(0.0, 0.0, 2.0));
    /// // Where K > 0 it is one closed curve.
    /// assert_eq!(Indicatrix::at(&point, &sphere, &curvature).curves(0.1).len(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn at(point: &SurfacePoint, surface: &TriangleSurface, curvature: &Curvature) -> Self {
        let corners = surface.topology().face_vertices(point.triangle);
        let weights = || corners.iter().zip(point.barycentric);
        let normal: Vec3 = weights().map(|(v, b)| curvature.normal[*v] * b).sum();
        let normal = normal.try_normalize(1e-12).unwrap_or(point.normal);
        let tensor: Matrix3<f64> = weights().map(|(v, b)| curvature.tensor[*v] * b).sum();
        Self {
            point: point.position,
            normal,
            principal: principal(normal, &tensor),
        }
    }

    /// A homothetic copy as polylines in the tangent plane: an ellipse whose longer half-axis is
    /// `size`, or the branches of both hyperbolas or lines, whose vertices are `size / 3` away, as
    /// far as `size` from the point. Nothing where the surface is flat. The last point of a closed
    /// curve is its first.
    pub fn curves(&self, size: f64) -> Vec<Vec<Vec3>> {
        let p = &self.principal;
        let (small, large) = (p.small.abs(), p.large.abs());
        if large * size < FLAT {
            return Vec::new();
        }
        let place = |q: Vec2| self.point + p.small_direction * q.x + p.large_direction * q.y;
        let elliptic = p.small * p.large > 0.0 && small > 1e-3 * large;
        let branches = if elliptic {
            vec![ellipse(size, size * (small / large).sqrt())]
        } else {
            hyperbolas(size, (small / large).sqrt())
        };
        branches
            .into_iter()
            .map(|b| b.into_iter().map(place).collect())
            .collect()
    }
}

fn ellipse(a: f64, b: f64) -> Vec<Vec2> {
    let angle =
        |i: usize| std::f64::consts::TAU * (i % (2 * SAMPLES)) as f64 / (2 * SAMPLES) as f64;
    (0..=2 * SAMPLES)
        .map(|i| Vec2::new(a * angle(i).cos(), b * angle(i).sin()))
        .collect()
}

/// Branches of `(slope x)^2 - y^2 = +-c^2` within `size`, `c` a third of it; `slope` 0 is two
/// lines.
fn hyperbolas(size: f64, slope: f64) -> Vec<Vec<Vec2>> {
    let c = size / 3.0;
    let inside = |q: &Vec2| q.norm() <= size * (1.0 + 1e-9);
    let parameter = |i: usize| (2.0 * i as f64 / SAMPLES as f64 - 1.0) * size;
    let mut branches = Vec::new();
    for sign in [-1.0, 1.0] {
        let across = |x: f64| Vec2::new(x, sign * (c * c + (slope * x).powi(2)).sqrt());
        branches.push(
            (0..=SAMPLES)
                .map(|i| across(parameter(i)))
                .filter(inside)
                .collect(),
        );
        if slope > 1e-3 {
            let along = |y: f64| Vec2::new(sign * (c * c + y * y).sqrt() / slope, y);
            branches.push(
                (0..=SAMPLES)
                    .map(|i| along(parameter(i)))
                    .filter(inside)
                    .collect(),
            );
        }
    }
    branches.retain(|b: &Vec<Vec2>| b.len() > 1);
    branches
}

/// Distance of each inner panel's corners from the best homothetic copy of the indicatrix: root
/// mean square over the panel's radius (that of its corners about their mean). `None` for panels at
/// the boundary, with fewer than five corners, or where the surface is flat.
pub fn indicatrix_distances(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    curvature: &Curvature,
) -> PerFace<Option<f64>> {
    let topology = mesh.topology();
    let floor = FLAT_REL * large_curvature(&curvature.principal());
    let distance = |f: FaceId| {
        if topology.is_boundary_face(f) || topology.valence(f) < LEAST_CORNERS {
            return None;
        }
        let foot = surface.closest_point(mesh.centre(f));
        let indicatrix = Indicatrix::at(&foot, surface, curvature);
        let curved = indicatrix.principal.large.abs() >= floor;
        let corners: Vec<Vec3> = mesh.corners(f).collect();
        curved.then(|| inscribed_distance(&corners, &indicatrix))?
    };
    PerFace::from_fn(topology.n_faces(), distance)
}

/// Least distance between a corner and an edge that does not hold it, over the square root of a
/// panel's area, from which on nothing holds the panel open: a little more than the reach of the
/// optimiser's barrier.
const ROOM: f64 = 0.36;

/// Panels that are not held open, and have no corner in common with one that is.
pub fn free_panels(mesh: &HexMesh) -> PerFace<bool> {
    let topology = mesh.topology();
    let tight = FlatFace::all(mesh).map(|f| f.clearance().distance < ROOM * f.area().sqrt());
    let at_tight = |v: VertexId| topology.faces_at(v).any(|f| tight[f]);
    let free = |f: FaceId| !topology.face_vertices(f).iter().any(|v| at_tight(*v));
    PerFace::from_fn(topology.n_faces(), free)
}

/// The distance of one polygon in space, projected to the plane of its corners, as in
/// [`indicatrix_distances`].
pub(crate) fn inscribed_distance(corners: &[Vec3], indicatrix: &Indicatrix) -> Option<f64> {
    let local = Local::new(corners, indicatrix)?;
    let conic = local.conic()?;
    let squares = local.points.iter().map(|q| conic.distance(q).powi(2));
    Some((squares.sum::<f64>() / local.points.len() as f64).sqrt())
}

/// The homothetic copy of the indicatrix that fits a polygon's corners best, as polylines in the
/// polygon's plane, a little beyond the corners.
pub fn inscribing_curves(corners: &[Vec3], indicatrix: &Indicatrix) -> Vec<Vec<Vec3>> {
    let curves = || {
        let local = Local::new(corners, indicatrix)?;
        let branches = local.conic()?.curves();
        let place = |q: &Vec2| {
            local.plane.centre + (local.axes[0] * q.x + local.axes[1] * q.y) * local.radius
        };
        let placed = branches.iter().map(|b| b.iter().map(place).collect());
        Some(placed.collect())
    };
    curves().unwrap_or_default()
}

/// A polygon in its own plane, turned so that the axes are the principal directions, with radius 1.
struct Local {
    plane: FacePlane,
    axes: [Vec3; 2],
    radius: f64,
    points: Vec<Vec2>,
    /// Ratio of the curvatures along the axes; the second is taken to be 1.
    ratio: f64,
}

impl Local {
    /// `None` where the surface is flat or stands across the polygon's plane.
    fn new(corners: &[Vec3], indicatrix: &Indicatrix) -> Option<Self> {
        let plane = FacePlane::fit(corners);
        let p = &indicatrix.principal;
        let tangential = p.small_direction - plane.normal * plane.normal.dot(&p.small_direction);
        let along = tangential.try_normalize(1e-6)?;
        let axes = [along, plane.normal.cross(&along)];
        let local = |c: &Vec3| axes.map(|a| (c - plane.centre).dot(&a)).into();
        let points: Vec<Vec2> = corners.iter().map(local).collect();
        let mean_square =
            points.iter().map(|q| q.norm_squared()).sum::<f64>() / points.len() as f64;
        let radius = mean_square.sqrt();
        (p.large.abs() * radius >= FLAT).then(|| Self {
            plane,
            axes,
            radius,
            points: points.iter().map(|q| q / radius).collect(),
            ratio: p.small / p.large,
        })
    }

    /// The conic of the indicatrix's shape that fits the corners best.
    fn conic(&self) -> Option<Conic> {
        let points = &self.points;
        let rows = DMatrix::from_fn(points.len(), 3, |i, j| [points[i].x, points[i].y, 1.0][j]);
        let rhs = DVector::from_fn(points.len(), |i, _| {
            -(self.ratio * points[i].x.powi(2) + points[i].y.powi(2))
        });
        let solved = rows.svd(true, true).solve(&rhs, 1e-12).ok()?;
        let linear = Vec2::new(solved[0], solved[1]);
        Some(Conic {
            ratio: self.ratio,
            linear,
            constant: solved[2],
        })
    }
}

/// `ratio x^2 + y^2 + linear . (x, y) + constant = 0`.
struct Conic {
    ratio: f64,
    linear: Vec2,
    constant: f64,
}

impl Conic {
    fn value(&self, q: &Vec2) -> f64 {
        self.ratio * q.x * q.x + q.y * q.y + self.linear.dot(q) + self.constant
    }

    /// Distance of a point, to first order.
    fn distance(&self, q: &Vec2) -> f64 {
        let value = self.value(q).abs();
        let gradient = Vec2::new(2.0 * self.ratio * q.x, 2.0 * q.y) + self.linear;
        // Near the centre of the conic the gradient says nothing; there the curve is sqrt(F) away.
        value / gradient.norm().max(value.sqrt()).max(f64::MIN_POSITIVE)
    }

    /// The curve within 1.3 of the origin, as pieces of lines between the sides of a grid's cells.
    fn curves(&self) -> Vec<Vec<Vec2>> {
        const REACH: f64 = 1.3;
        const CELLS: usize = 96;
        let at = |i: usize| REACH * (2.0 * i as f64 / CELLS as f64 - 1.0);
        let corner = |i: usize, j: usize| Vec2::new(at(i), at(j));
        let zero = |p: Vec2, q: Vec2| {
            let (f, g) = (self.value(&p), self.value(&q));
            ((f < 0.0) != (g < 0.0)).then(|| p + (q - p) * (f / (f - g)))
        };
        let cell = |i: usize, j: usize| {
            let c = [
                corner(i, j),
                corner(i + 1, j),
                corner(i + 1, j + 1),
                corner(i, j + 1),
            ];
            let cuts: Vec<Vec2> = (0..4).filter_map(|k| zero(c[k], c[(k + 1) % 4])).collect();
            (cuts.len() == 2 && cuts.iter().all(|q| q.norm() < REACH)).then_some(cuts)
        };
        let cells = (0..CELLS).flat_map(|i| (0..CELLS).map(move |j| (i, j)));
        cells.filter_map(|(i, j)| cell(i, j)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::{CurvatureOptions, curvature};
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    fn at(small: f64, large: f64) -> Indicatrix {
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.8, 0.5);
        let principal = Principal {
            small,
            large,
            small_direction: turn * Vec3::x(),
            large_direction: turn * Vec3::y(),
        };
        Indicatrix {
            point: Vec3::new(1.0, 2.0, 3.0),
            normal: turn * Vec3::z(),
            principal,
        }
    }

    #[test]
    fn corners_on_a_homothetic_copy_are_inscribed() {
        for (small, large) in [(0.5, 1.0), (-0.4, 1.2), (0.0, -2.0)] {
            let indicatrix = at(small, large);
            let shift = indicatrix.principal.small_direction * 0.1
                + indicatrix.principal.large_direction * 0.2;
            let corners: Vec<Vec3> = indicatrix
                .curves(0.3)
                .iter()
                .flat_map(|c| c.iter().step_by(9).copied())
                .filter(|p| {
                    // One hyperbola of the pair.
                    let d = p - indicatrix.point;
                    let (x, y) = (
                        d.dot(&indicatrix.principal.small_direction),
                        d.dot(&indicatrix.principal.large_direction),
                    );
                    small >= 0.0 || small * x * x + large * y * y > 0.0
                })
                .map(|p| p + shift)
                .collect();
            assert!(corners.len() >= 6);
            let off = inscribed_distance(&corners, &indicatrix).unwrap();
            assert!(off < 1e-12, "{small} {large}: {off}");
            let mut moved = corners.clone();
            moved[2] += shift * 0.4;
            assert!(inscribed_distance(&moved, &indicatrix).unwrap() > 0.01);
        }
    }

    #[test]
    fn curves_are_where_they_should_be() {
        let value = |i: &Indicatrix, p: &Vec3| {
            let d = p - i.point;
            let (x, y) = (
                d.dot(&i.principal.small_direction),
                d.dot(&i.principal.large_direction),
            );
            i.principal.small * x * x + i.principal.large * y * y
        };
        for (small, large) in [(0.5, 1.0), (-0.4, 1.2), (0.0, -2.0)] {
            let indicatrix = at(small, large);
            let curves = indicatrix.curves(0.3);
            let first = value(&indicatrix, &curves[0][0]).abs();
            for p in curves.iter().flatten() {
                assert!((value(&indicatrix, p).abs() - first).abs() < 1e-12);
                assert!((p - indicatrix.point).norm() < 0.3 + 1e-9);
                assert!((p - indicatrix.point).dot(&indicatrix.normal).abs() < 1e-12);
            }
            let expected = if small > 0.0 {
                1
            } else if small < 0.0 {
                4
            } else {
                2
            };
            assert_eq!(curves.len(), expected);
        }
        assert!(at(0.0, 0.0).curves(1.0).is_empty());
    }

    #[test]
    fn inscribing_curves_pass_through_the_corners() {
        for (small, large) in [(0.6, 1.0), (-0.8, 1.2)] {
            let indicatrix = at(small, large);
            let p = indicatrix.principal;
            let on =
                |x: f64, y: f64| indicatrix.point + p.small_direction * x + p.large_direction * y;
            let y = |x: f64| ((1.0 - small * x * x) / large).sqrt();
            let corners: Vec<Vec3> = [-0.5, 0.1, 0.6]
                .map(|x| on(x, y(x)))
                .into_iter()
                .chain([0.5, -0.1, -0.6].map(|x| on(x, -y(x))))
                .collect();
            let curves = inscribing_curves(&corners, &indicatrix);
            let points = || curves.iter().flatten();
            for c in &corners {
                let nearest = points().map(|q| (q - c).norm()).fold(f64::MAX, f64::min);
                assert!(nearest < 0.02, "{nearest}");
            }
            assert!(points().count() > 100);
        }
    }

    #[test]
    fn of_a_sphere_are_circles() {
        let options = TriangulationOptions {
            triangles: 2000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name("sphere", &[]).unwrap(), &options).unwrap();
        let curvature = curvature(&surface, 0.3, &CurvatureOptions::default());
        let foot = surface.closest_point(Vec3::new(0.3, 2.0, -0.5));
        let indicatrix = Indicatrix::at(&foot, &surface, &curvature);
        assert!((indicatrix.principal.small - 1.0).abs() < 0.02);
        for p in &indicatrix.curves(0.2)[0] {
            assert!(((p - foot.position).norm() - 0.2).abs() < 0.01);
        }
    }
}
