//! Curvature against closed forms, with the order at which the error falls.
use crate::common::{mapped, noisy, rotation, shape_with};
use nalgebra::Matrix3;
use phex::curvature::{Curvature, CurvatureOptions, curvature};
use phex_mesh::shapes::{
    ParametricSurface, Shape, Triangulation, TriangulationOptions, triangulate_with_parameters,
};
use phex_mesh::{TriangleSurface, Vec3, VertexId};

/// A triangulated shape whose curvature is known at every vertex.
struct Known {
    shape: Shape,
    mesh: Triangulation,
    surface: TriangleSurface,
}

impl Known {
    fn new(name: &str, triangles: usize, jitter: f64) -> Self {
        let shape = Shape::from_name(name, &[]).unwrap();
        let options = TriangulationOptions {
            triangles,
            jitter,
            seed: 3,
        };
        let mesh = triangulate_with_parameters(&shape, &options).unwrap();
        let surface = TriangleSurface::new(mesh.positions.clone(), &mesh.triangles).unwrap();
        Self {
            shape,
            mesh,
            surface,
        }
    }

    /// The tensor of the stage's convention: shapes count curvature towards the normal, the stage
    /// away from it.
    fn tensor(&self, v: VertexId) -> Matrix3<f64> {
        let [a, b] = self.mesh.parameters[v.index()];
        let k = self.shape.principal_curvatures(a, b);
        let outer = |d: Vec3| d * d.transpose();
        -(outer(k.max_direction) * k.max + outer(k.min_direction) * k.min)
    }

    fn normal(&self, v: VertexId) -> Vec3 {
        let [a, b] = self.mesh.parameters[v.index()];
        self.shape.normal(a, b)
    }

    /// Vertices farther than `margin` from the boundary, where neighbourhoods are not one-sided.
    fn inner(&self, margin: f64) -> Vec<VertexId> {
        let topology = self.surface.topology();
        let rim: Vec<Vec3> = topology
            .boundary_vertices()
            .map(|v| self.surface.positions()[v])
            .collect();
        let far = |v: &VertexId| {
            let p = self.surface.positions()[*v];
            rim.iter().all(|q| (p - q).norm() > margin)
        };
        topology.vertices().filter(far).collect()
    }

    /// Root mean square error of the tensors over that of the tensors themselves.
    fn error(&self, estimate: &Curvature, vertices: &[VertexId]) -> f64 {
        let square = |m: Matrix3<f64>| m.norm_squared();
        let off = |v: &VertexId| square(estimate.tensor[*v] - self.tensor(*v));
        let wrong: f64 = vertices.iter().map(off).sum();
        let all: f64 = vertices.iter().map(|v| square(self.tensor(*v))).sum();
        (wrong / all).sqrt()
    }
}

/// Plain fits within `radius`, without smoothing.
fn fitted(surface: &TriangleSurface, radius: f64) -> Curvature {
    let options = CurvatureOptions {
        radius_rel: 1.0,
        smoothing: 0,
    };
    curvature(surface, radius, &options)
}

/// Edge of the equilateral triangles that a surface would have.
fn mean_edge(surface: &TriangleSurface) -> f64 {
    (4.0 * surface.area() / surface.topology().n_faces() as f64 / 3f64.sqrt()).sqrt()
}

/// Neighbourhoods of four edges on a coarse and on a fine triangulation: the radius halves, their
/// pattern stays. A wrong sign, factor or frame gives an error of order one, a fit of too low an
/// order one that falls too slowly.
#[test]
fn the_error_falls_at_second_order() {
    const RADIUS: f64 = 4.0;
    let shapes = [
        "torus",
        "ellipsoid",
        "wave",
        "monkey-saddle",
        "hyperboloid",
        "helicoid",
        "enneper",
    ];
    for name in shapes {
        let error = |triangles| {
            let known = Known::new(name, triangles, 0.0);
            let radius = RADIUS * mean_edge(&known.surface);
            let vertices = known.inner(2.5 * RADIUS * mean_edge(&known.surface));
            (
                radius,
                known.error(&fitted(&known.surface, radius), &vertices),
            )
        };
        let (coarse, fine) = (error(4000), error(16_000));
        let order = (coarse.1 / fine.1).ln() / (coarse.0 / fine.0).ln();
        let figures = format!("{name}: {:.2e} {:.2e}, order {order:.2}", coarse.1, fine.1);
        assert!(fine.1 < 0.05 && (1.7..2.4).contains(&order), "{figures}");
    }
}

#[test]
fn irregular_triangles_do_not_matter_much() {
    for name in ["torus", "wave", "ellipsoid"] {
        let known = Known::new(name, 12_000, 0.35);
        let radius = 0.06 * known.surface.diagonal();
        let vertices = known.inner(radius);
        let error = known.error(&fitted(&known.surface, radius), &vertices);
        assert!(error < 0.08, "{name}: {error:.2e}");
    }
}

#[test]
fn normals_are_those_of_the_surface() {
    let known = Known::new("torus", 12_000, 0.3);
    let estimate = fitted(&known.surface, 0.12);
    let sine = |v: VertexId| estimate.normal[v].cross(&known.normal(v)).norm();
    let worst = known.surface.topology().vertices().map(sine);
    assert!(worst.fold(0.0, f64::max) < 0.01);
    for v in known.surface.topology().vertices() {
        assert!(estimate.normal[v].dot(&known.normal(v)) > 0.0);
    }
}

/// The sign convention, by hand: a sphere with outward normals is convex, so positive.
#[test]
fn a_sphere_is_positively_curved() {
    let surface = shape_with("sphere", &[("radius", 2.5)], 5000);
    let estimate = curvature(&surface, 0.5, &CurvatureOptions::default());
    for p in &estimate.principal() {
        for k in [p.small, p.large] {
            assert!((k - 0.4).abs() < 0.01, "{k}");
        }
    }
    let inside_out = TriangleSurface::new(
        surface.positions().as_slice().to_vec(),
        &crate::common::triangles(&surface)
            .iter()
            .map(|t| [t[0], t[2], t[1]])
            .collect::<Vec<_>>(),
    );
    let estimate = curvature(&inside_out.unwrap(), 0.5, &CurvatureOptions::default());
    assert!(estimate.principal().iter().all(|p| p.large < -0.39));
}

#[test]
fn a_plane_is_flat() {
    let surface = mapped(&shape_with("plane", &[], 2000), |p| rotation() * p);
    let estimate = curvature(&surface, 0.2, &CurvatureOptions::default());
    assert!(estimate.tensor.iter().all(|t| t.norm() < 1e-12));
    assert!(
        estimate
            .confidence
            .iter()
            .all(|c| c.is_finite() && (0.0..=1.0).contains(c))
    );
    for v in surface.topology().vertices() {
        assert!((estimate.normal[v] - surface.normals()[v]).norm() < 1e-12);
    }
}

#[test]
fn tensors_are_symmetric_and_tangential() {
    let surface = shape_with("b-spline", &[], 3000);
    let estimate = curvature(&surface, 0.3, &CurvatureOptions::default());
    let scale = estimate.tensor.iter().map(|t| t.norm()).fold(0.0, f64::max);
    for v in surface.topology().vertices() {
        let (n, t) = (estimate.normal[v], estimate.tensor[v]);
        assert!((n.norm() - 1.0).abs() < 1e-12);
        assert!((t * n).norm() < 1e-12 * scale && (t - t.transpose()).norm() < 1e-12 * scale);
    }
}

#[test]
fn principal_values_diagonalise_the_tensor() {
    let surface = shape_with("wave", &[], 3000);
    let estimate = curvature(&surface, 0.4, &CurvatureOptions::default());
    let principal = estimate.principal();
    for v in surface.topology().vertices() {
        let (p, t, n) = (&principal[v], &estimate.tensor[v], &estimate.normal[v]);
        assert!(p.small.abs() <= p.large.abs());
        assert!((t * p.small_direction - p.small_direction * p.small).norm() < 1e-10);
        assert!((t * p.large_direction - p.large_direction * p.large).norm() < 1e-10);
        assert!(
            p.small_direction.dot(n).abs() + p.small_direction.dot(&p.large_direction).abs()
                < 1e-12
        );
    }
}

#[test]
fn moving_a_surface_moves_its_curvature() {
    let surface = shape_with("b-spline", &[], 2000);
    let shift = Vec3::new(10.0, -20.0, 5.0);
    let moved = mapped(&surface, |p| rotation() * p + shift);
    let options = CurvatureOptions::default();
    let (a, b) = (
        curvature(&surface, 0.4, &options),
        curvature(&moved, 0.4, &options),
    );
    let r = rotation().into_inner();
    for v in surface.topology().vertices() {
        assert!((r * a.tensor[v] * r.transpose() - b.tensor[v]).norm() < 1e-6);
        assert!((r * a.normal[v] - b.normal[v]).norm() < 1e-7);
        assert!((a.confidence[v] - b.confidence[v]).abs() < 1e-6);
    }
}

#[test]
fn curvature_is_one_over_length() {
    let surface = shape_with("torus", &[], 2000);
    let large = mapped(&surface, |p| p * 1e3);
    let options = CurvatureOptions::default();
    let (a, b) = (
        curvature(&surface, 0.3, &options),
        curvature(&large, 300.0, &options),
    );
    for v in surface.topology().vertices() {
        assert!((a.tensor[v] - b.tensor[v] * 1e3).norm() < 1e-9);
    }
}

/// Confidence that does not tell a smooth surface from noise would align panels with noise.
#[test]
fn confidence_is_high_on_smooth_surfaces_and_low_on_noise() {
    let (torus, plane) = (
        shape_with("torus", &[], 8000),
        shape_with("plane", &[], 8000),
    );
    let median = |surface: &TriangleSurface| {
        let mut c = fitted(surface, 3.0 * mean_edge(surface))
            .confidence
            .into_vec();
        c.sort_by(f64::total_cmp);
        c[c.len() / 2]
    };
    let (smooth, rough) = (
        median(&torus),
        median(&noisy(&plane, 0.1 * mean_edge(&plane))),
    );
    assert!(smooth > 0.99 && rough < 0.5, "{smooth} {rough}");
}

/// Noise of a tenth of an edge drowns curvature at the scale of triangles, not at that of panels.
#[test]
fn noise_disappears_at_the_scale_of_panels() {
    let known = Known::new("torus", 20_000, 0.0);
    let edge = mean_edge(&known.surface);
    let rough = noisy(&known.surface, 0.1 * edge);
    let vertices = known.inner(0.0);
    let error = |radius: f64| known.error(&fitted(&rough, radius), &vertices);
    let (near, far) = (error(2.0 * edge), error(4.5 * edge));
    assert!(far < 0.08 && near > 4.0 * far, "{near} {far}");
}

/// Refining an estimate gives the curvature of the finer surface.
#[test]
fn refined_curvature_is_that_of_the_finer_surface() {
    let surface = crate::common::normalised(&shape_with("torus", &[], 2000));
    let target = phex::smooth_surface::smooth_target(&surface, 4000, &Default::default());
    let [coarse, fine] = [0, 1].map(|i| fitted(&target.levels[i], 0.15));
    let refined = coarse.refined(&target.refinements[0]);
    let scale = fine.tensor.iter().map(|t| t.norm()).fold(0.0, f64::max);
    for v in target.levels[1].topology().vertices() {
        assert!((refined.normal[v] - fine.normal[v]).norm() < 0.01);
        let difference = (refined.tensor[v] - fine.tensor[v]).norm() / scale;
        assert!(difference < 0.1, "{v}: {difference}");
    }
}
