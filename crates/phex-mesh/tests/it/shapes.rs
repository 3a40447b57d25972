//! Every built-in shape: derivatives against differences, curvature against formulas,
//! triangulations.

use phex_mesh::shapes::{
    ParametricSurface, Region, Shape, Triangulation, TriangulationOptions, triangulate,
    triangulate_with_parameters,
};
use phex_mesh::{TriangleSurface, Vec3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{PI, TAU};

fn shape(name: &str) -> Shape {
    Shape::from_name(name, &[]).unwrap()
}

fn shapes() -> impl Iterator<Item = Shape> {
    Shape::all().iter().map(|info| shape(info.name))
}

fn options(triangles: usize, jitter: f64, seed: u64) -> TriangulationOptions {
    TriangulationOptions {
        triangles,
        jitter,
        seed,
    }
}

/// Random parameters inside the domain, away from poles.
fn random_parameters(surface: &Shape, count: usize) -> Vec<[f64; 2]> {
    let domain = surface.domain();
    let margin = if domain.region == Region::PoleToPole {
        0.05
    } else {
        0.0
    };
    let mut rng = ChaCha8Rng::seed_from_u64(17);
    let mut found = Vec::new();
    while found.len() < count {
        let fraction = margin + (1.0 - 2.0 * margin) * rng.random::<f64>();
        let uv = [domain.u.at(rng.random()), domain.v.at(fraction)];
        if domain.contains(uv) {
            found.push(uv);
        }
    }
    found
}

fn assert_near(name: &str, what: &str, computed: Vec3, exact: Vec3, tolerance: f64) {
    let error = (computed - exact).norm();
    assert!(
        error <= tolerance * (1.0 + exact.norm()),
        "{name}: {what}: {computed:?} against {exact:?}"
    );
}

/// Central differences by `u` and `v`, steps relative to the domain.
fn differences(surface: &Shape, [u, v]: [f64; 2], f: impl Fn(f64, f64) -> Vec3) -> [Vec3; 2] {
    let domain = surface.domain();
    let (hu, hv) = (1e-5 * domain.u.length(), 1e-5 * domain.v.length());
    [
        (f(u + hu, v) - f(u - hu, v)) / (2.0 * hu),
        (f(u, v + hv) - f(u, v - hv)) / (2.0 * hv),
    ]
}

#[test]
fn derivatives_agree_with_differences() {
    for surface in shapes() {
        let name = surface.info().name;
        for [u, v] in random_parameters(&surface, 50) {
            let jet = surface.jet(u, v);
            let check = |what, difference, exact| assert_near(name, what, difference, exact, 1e-7);
            let [by_u, by_v] = differences(&surface, [u, v], |u, v| surface.point(u, v));
            check("x_u", by_u, jet.du);
            check("x_v", by_v, jet.dv);
            let [by_u, by_v] = differences(&surface, [u, v], |u, v| surface.jet(u, v).du);
            check("x_uu", by_u, jet.duu);
            check("x_uv", by_v, jet.duv);
            let [by_u, by_v] = differences(&surface, [u, v], |u, v| surface.jet(u, v).dv);
            check("x_vu", by_u, jet.duv);
            check("x_vv", by_v, jet.dvv);
        }
    }
}

/// `II(a, b) = -dn(a) . x_b`: the second form from differences of the normal.
#[test]
fn fundamental_forms_agree_with_differences_of_point_and_normal() {
    for surface in shapes() {
        let name = surface.info().name;
        for [u, v] in random_parameters(&surface, 50) {
            let [xu, xv] = differences(&surface, [u, v], |u, v| surface.point(u, v));
            let [nu, nv] = differences(&surface, [u, v], |u, v| surface.normal(u, v));
            let first = surface.first_fundamental_form(u, v);
            let exact = Vec3::new(first.e, first.f, first.g);
            let computed = Vec3::new(xu.dot(&xu), xu.dot(&xv), xv.dot(&xv));
            assert_near(name, "E F G", computed, exact, 1e-7);
            let second = surface.second_fundamental_form(u, v);
            let exact = Vec3::new(second.l, second.m, second.n);
            let computed = -Vec3::new(nu.dot(&xu), nu.dot(&xv), nv.dot(&xv));
            assert_near(name, "L M N", computed, exact, 1e-7);
            let transposed = -Vec3::new(nu.dot(&xu), nv.dot(&xu), nv.dot(&xv));
            assert_near(name, "L M N", transposed, exact, 1e-7);
            assert!(
                surface.normal(u, v).dot(&xu.cross(&xv)) > 0.0,
                "{name}: orientation"
            );
        }
    }
}

/// `dn(t) = -k t` along both principal directions, which are perpendicular and tangent.
#[test]
fn principal_directions_are_eigenvectors_of_the_shape_operator() {
    for surface in shapes() {
        let name = surface.info().name;
        for [u, v] in random_parameters(&surface, 50) {
            let (k, normal) = (surface.principal_curvatures(u, v), surface.normal(u, v));
            assert!(k.max >= k.min, "{name}");
            let cross = k.max_direction.cross(&k.min_direction);
            assert_near(name, "frame", cross, normal, 1e-12);
            let form = surface.first_fundamental_form(u, v);
            let [xu, xv] = surface.first_derivatives(u, v);
            let [nu, nv] = differences(&surface, [u, v], |u, v| surface.normal(u, v));
            for (direction, curvature) in [(k.max_direction, k.max), (k.min_direction, k.min)] {
                // Components of the direction in the basis x_u, x_v.
                let (a, b) = (direction.dot(&xu), direction.dot(&xv));
                let du = (form.g * a - form.f * b) / form.determinant();
                let dv = (form.e * b - form.f * a) / form.determinant();
                let change = nu * du + nv * dv;
                assert_near(name, "dn", change, -direction * curvature, 1e-7);
            }
        }
    }
}

/// Gauss and mean curvature from the forms, the textbook formulas, agree with those from the
/// principal curvatures.
#[test]
fn curvatures_agree_with_the_formulas_in_the_forms() {
    for surface in shapes() {
        let name = surface.info().name;
        for [u, v] in random_parameters(&surface, 50) {
            let first = surface.first_fundamental_form(u, v);
            let second = surface.second_fundamental_form(u, v);
            let (area_squared, k) = (first.determinant(), surface.principal_curvatures(u, v));
            let gauss = (second.l * second.n - second.m * second.m) / area_squared;
            let trace = first.e * second.n - 2.0 * first.f * second.m + first.g * second.l;
            let mean = trace / (2.0 * area_squared);
            let scale = 1.0 + k.max.abs().max(k.min.abs()).powi(2);
            assert!(
                (gauss - surface.gauss_curvature(u, v)).abs() < 1e-11 * scale,
                "{name} K"
            );
            assert!(
                (mean - surface.mean_curvature(u, v)).abs() < 1e-11 * scale,
                "{name} H"
            );
        }
    }
}

fn assert_curvature(name: &str, exact: impl Fn(&Shape, f64, f64) -> (f64, f64)) {
    let surface = shape(name);
    for [u, v] in random_parameters(&surface, 100) {
        let (gauss, mean) = exact(&surface, u, v);
        let computed = (surface.gauss_curvature(u, v), surface.mean_curvature(u, v));
        assert!(
            (computed.0 - gauss).abs() < 1e-12 * (1.0 + gauss.abs()),
            "{name}: K {computed:?}, {gauss}"
        );
        assert!(
            (computed.1 - mean).abs() < 1e-12 * (1.0 + mean.abs()),
            "{name}: H {computed:?}, {mean}"
        );
    }
}

/// Known Gauss and mean curvature, with the sign of the documented convention.
#[test]
fn curvatures_agree_with_known_formulas() {
    assert_curvature("plane", |_, _, _| (0.0, 0.0));
    assert_curvature("sphere", |_, _, _| (1.0, -1.0));
    assert_curvature("cylinder", |_, _, _| (0.0, -0.5));
    assert_curvature("cone", |s, u, v| {
        let outward = 1.5 / 0.6f64.hypot(1.5);
        (0.0, -0.5 * outward / s.point(u, v).xy().norm())
    });
    assert_curvature("torus", |_, _, v| {
        let (meridian, parallel) = (-1.0 / 0.4, -v.cos() / (1.0 + 0.4 * v.cos()));
        (meridian * parallel, 0.5 * (meridian + parallel))
    });
    assert_curvature("catenoid", |_, _, v| {
        (-1.0 / (0.36 * v.cosh().powi(4)), 0.0)
    });
    assert_curvature("helicoid", |_, _, v| {
        let rise = 4.0 / TAU;
        (-(rise / (rise * rise + v * v)).powi(2), 0.0)
    });
    assert_curvature("enneper", |_, u, v| {
        (-4.0 / (1.0 + u * u + v * v).powi(4), 0.0)
    });
    assert_curvature("scherk", |_, u, v| {
        let (x, y) = (1.0 / u.cos().powi(2), 1.0 / v.cos().powi(2));
        (-x * y / (x + y - 1.0).powi(2), 0.0)
    });
}

fn gauss_curvatures(name: &str) -> Vec<f64> {
    let surface = shape(name);
    let parameters = random_parameters(&surface, 500);
    parameters
        .iter()
        .map(|&[u, v]| surface.gauss_curvature(u, v))
        .collect()
}

#[test]
fn gauss_curvature_has_the_known_sign() {
    for name in ["ellipsoid", "elliptic-paraboloid"] {
        assert!(gauss_curvatures(name).iter().all(|&k| k > 0.0), "{name}");
    }
    for name in ["hyperbolic-paraboloid", "hyperboloid", "monkey-saddle"] {
        assert!(gauss_curvatures(name).iter().all(|&k| k < 0.0), "{name}");
    }
    for name in ["wave", "torus", "b-spline", "roof"] {
        let positive = gauss_curvatures(name).iter().filter(|&&k| k > 0.0).count();
        assert!(
            (75..=425).contains(&positive),
            "{name}: K > 0 at {positive} of 500"
        );
    }
}

/// The integral of K over a closed surface is 2 pi chi.
#[test]
fn gauss_bonnet_holds_for_the_curvature() {
    for (name, chi) in [("sphere", 2.0), ("ellipsoid", 2.0), ("torus", 0.0)] {
        let surface = shape(name);
        let (domain, n) = (surface.domain(), 400);
        let fraction = |k: usize| (k as f64 + 0.5) / n as f64;
        let mut total = 0.0;
        for i in 0..n * n {
            let (u, v) = (domain.u.at(fraction(i % n)), domain.v.at(fraction(i / n)));
            let area = surface.first_fundamental_form(u, v).determinant().sqrt();
            total += surface.gauss_curvature(u, v) * area;
        }
        total *= domain.u.length() * domain.v.length() / (n * n) as f64;
        assert!((total - TAU * chi).abs() < 1e-4, "{name}: {total}");
    }
}

/// The value of the surface's implicit function, where it has one.
fn implicit(name: &str, p: Vec3) -> Option<f64> {
    let rho = p.xy().norm();
    match name {
        "plane" => Some(p.z),
        "sphere" => Some(p.norm() - 1.0),
        "ellipsoid" => Some((p.x / 1.5).powi(2) + p.y.powi(2) + (p.z / 0.7).powi(2) - 1.0),
        "cylinder" => Some(rho - 1.0),
        "cone" => Some(rho - 0.7 + 0.4 * p.z),
        "torus" => Some((rho - 1.0).hypot(p.z) - 0.4),
        "catenoid" => Some(rho - 0.6 * (p.z / 0.6).cosh()),
        "hyperboloid" => {
            let slope = 1.0 / ((1.1f64 / 0.7).powi(2) - 1.0).sqrt();
            Some((rho / 0.7).powi(2) - (p.z / slope).powi(2) - 1.0)
        }
        "helicoid" => {
            let (sin, cos) = (p.z * TAU / 4.0).sin_cos();
            Some(p.x * sin - p.y * cos)
        }
        "hyperbolic-paraboloid" => Some(p.z - 0.5 * (p.x * p.x - p.y * p.y)),
        "elliptic-paraboloid" => Some(p.z + 0.5 * (p.x * p.x / 1.2 + p.y * p.y / 1.8)),
        "monkey-saddle" => Some(p.z - 0.3 * p.x * (p.x * p.x - 3.0 * p.y * p.y)),
        "scherk" => Some(p.z - (p.y.cos() / p.x.cos()).ln()),
        "wave" => Some(p.z - 0.3 * p.x.sin() - 0.2 * p.y.sin()),
        _ => None,
    }
}

fn assert_on_surface(surface: &Shape, mesh: &Triangulation) {
    let name = surface.info().name;
    for (x, &[u, v]) in mesh.positions.iter().zip(&mesh.parameters) {
        assert!(
            surface.domain().contains([u, v]),
            "{name}: {u} {v} is outside the domain"
        );
        assert_eq!(*x, surface.point(u, v), "{name}");
        if let Some(residual) = implicit(name, *x) {
            assert!(residual.abs() < 1e-12, "{name}: {residual} at {x:?}");
        }
    }
}

/// Euler characteristic and number of boundary loops.
fn topology_of(name: &str) -> (i64, usize) {
    match name {
        "sphere" | "ellipsoid" => (2, 0),
        "torus" => (0, 0),
        "cylinder" | "cone" | "catenoid" | "hyperboloid" => (0, 2),
        _ => (1, 1),
    }
}

fn assert_topology(name: &str, mesh: &TriangleSurface) {
    let topology = mesh.topology();
    let found = (
        topology.euler_characteristic(),
        topology.boundary_loops().len(),
    );
    assert_eq!(found, topology_of(name), "{name}");
    assert_eq!(topology.components().1, 1, "{name}");
}

/// The least cosine between a triangle's normal and the surface's at its corners, and the least
/// interior angle in degrees.
fn quality(surface: &Shape, mesh: &Triangulation) -> (f64, f64) {
    let (mut agreement, mut angle) = (1.0f64, PI);
    for t in &mesh.triangles {
        let corners = t.map(|i| mesh.positions[i as usize]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        for i in 0..3 {
            let [u, v] = mesh.parameters[t[i] as usize];
            agreement = agreement.min(normal.normalize().dot(&surface.normal(u, v)));
            let to = |k: usize| corners[(i + k) % 3] - corners[i];
            angle = angle.min(to(1).angle(&to(2)));
        }
    }
    (agreement, angle.to_degrees())
}

#[test]
fn regular_triangulations_lie_on_the_surface_and_are_well_shaped() {
    for surface in shapes() {
        let name = surface.info().name;
        let mesh = triangulate_with_parameters(&surface, &options(6000, 0.0, 0)).unwrap();
        assert_on_surface(&surface, &mesh);
        let count = mesh.triangles.len();
        let (agreement, angle) = quality(&surface, &mesh);
        println!("{name}: {count} triangles, normals {agreement:.4}, least angle {angle:.1}");
        assert!((5400..=6600).contains(&count), "{name}: {count} triangles");
        assert!(agreement > 0.97, "{name}: normals agree to {agreement}");
        assert!(angle > 18.0, "{name}: smallest angle {angle}");
        let mesh = TriangleSurface::new(mesh.positions, &mesh.triangles).unwrap();
        assert_topology(name, &mesh);
    }
}

#[test]
fn jittered_triangulations_stay_manifold_and_face_the_right_way() {
    for surface in shapes() {
        let name = surface.info().name;
        for seed in 0..3 {
            let mesh = triangulate_with_parameters(&surface, &options(6000, 0.4, seed)).unwrap();
            assert_on_surface(&surface, &mesh);
            let (agreement, angle) = quality(&surface, &mesh);
            println!("{name}: normals {agreement:.4}, least angle {angle:.1}");
            assert!(agreement > 0.3, "{name}: normals agree to {agreement}");
            let mesh = TriangleSurface::new(mesh.positions, &mesh.triangles).unwrap();
            assert_topology(name, &mesh);
        }
    }
}

#[test]
fn coarse_and_fine_triangulations_keep_the_topology() {
    for surface in shapes() {
        for triangles in [100, 157, 1000, 50_000] {
            let mesh = triangulate(&surface, &options(triangles, 0.3, 5)).unwrap();
            assert_topology(surface.info().name, &mesh);
        }
    }
}

/// Every parameter at a third and three times its default, and at the ends of its range: what is
/// accepted is meshed, and no bigger than asked for.
#[test]
fn unusual_parameters_are_refused_or_meshed() {
    for info in Shape::all() {
        for parameter in info.parameters {
            let factors = [1.0 / 3.0, 3.0].map(|f| f * parameter.default);
            for value in factors.into_iter().chain([parameter.min, parameter.max]) {
                let Ok(shape) = Shape::from_name(info.name, &[(parameter.name, value)]) else {
                    continue;
                };
                let mesh = triangulate_with_parameters(&shape, &options(1000, 0.2, 1)).unwrap();
                let finite = |p: &Vec3| p.iter().all(|x| x.is_finite());
                assert!(mesh.positions.iter().all(finite), "{shape:?}");
                assert!((400..=1300).contains(&mesh.triangles.len()), "{shape:?}");
                let mesh = TriangleSurface::new(mesh.positions, &mesh.triangles).unwrap();
                assert_topology(info.name, &mesh);
            }
        }
    }
}

#[test]
fn jitter_moves_vertices_but_not_the_boundary_curve() {
    for surface in shapes() {
        let regular = triangulate_with_parameters(&surface, &options(1000, 0.0, 0)).unwrap();
        let jittered = triangulate_with_parameters(&surface, &options(1000, 0.3, 0)).unwrap();
        let mesh = triangulate(&surface, &options(1000, 0.0, 0)).unwrap();
        for v in mesh.topology().vertices() {
            let moved = regular.positions[v.index()] != jittered.positions[v.index()];
            let inside = !mesh.topology().is_boundary_vertex(v);
            assert_eq!(moved, inside, "{} {v}", surface.info().name);
        }
    }
}

#[test]
fn seed_and_options_decide_every_bit() {
    for surface in shapes() {
        let bits = |seed| {
            let mesh = triangulate_with_parameters(&surface, &options(2000, 0.25, seed)).unwrap();
            let coordinates = mesh.positions.iter().flat_map(|p| [p.x, p.y, p.z]);
            (
                coordinates.map(f64::to_bits).collect::<Vec<_>>(),
                mesh.triangles,
            )
        };
        assert_eq!(bits(1), bits(1));
        assert_ne!(bits(1).0, bits(2).0);
    }
}

/// Angle defects of the closed triangulations add up to 2 pi chi.
#[test]
fn gauss_bonnet_holds_for_the_triangulation() {
    for (name, chi) in [("sphere", 2.0), ("ellipsoid", 2.0), ("torus", 0.0)] {
        let mesh = triangulate(&shape(name), &options(5000, 0.3, 1)).unwrap();
        let mut defect = TAU * mesh.topology().n_vertices() as f64;
        for f in mesh.topology().faces() {
            let c = mesh.corners(f);
            let angle = |i: usize| (c[(i + 1) % 3] - c[i]).angle(&(c[(i + 2) % 3] - c[i]));
            defect -= (0..3).map(angle).sum::<f64>();
        }
        assert!((defect - TAU * chi).abs() < 1e-8, "{name}: {defect}");
    }
}

/// Areas against closed forms: every part of the surface is covered once, and the error is of
/// second order.
#[test]
fn areas_converge_to_the_surface() {
    let catenary = |t: f64| 0.5 * t + 0.25 * (2.0 * t).sinh();
    let r2: f64 = 1.44;
    let exact = [
        ("plane", 4.0),
        ("sphere", 4.0 * PI),
        ("cylinder", 4.0 * PI),
        ("cone", PI * 1.4 * 0.6f64.hypot(1.5)),
        ("torus", TAU * TAU * 0.4),
        ("catenoid", 2.0 * TAU * 0.36 * catenary(0.8 / 0.6)),
        ("enneper", PI * (r2 + r2 * r2 + r2.powi(3) / 3.0)),
    ];
    for (name, area) in exact {
        let error = |n| {
            let mesh = triangulate(&shape(name), &options(n, 0.0, 0)).unwrap();
            (mesh.area() / area - 1.0).abs()
        };
        let (coarse, fine) = (error(10_000), error(40_000));
        assert!(coarse < 2e-3, "{name}: {coarse}");
        assert!(fine < 0.3 * coarse + 1e-12, "{name}: {coarse}, then {fine}");
    }
}

/// `data/roof.obj` is the shape `roof` with 4000 triangles, rounded to 5 decimals.
#[test]
fn the_shipped_roof_is_the_shape_roof() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/roof.obj");
    let text = std::fs::read_to_string(path).unwrap();
    let numbers =
        |line: &str| -> Vec<f64> { line.split(' ').map(|t| t.parse().unwrap()).collect() };
    let lines = |tag: &str| -> Vec<Vec<f64>> {
        text.lines()
            .filter_map(|l| l.strip_prefix(tag))
            .map(numbers)
            .collect()
    };
    let (vertices, faces) = (lines("v "), lines("f "));
    let mesh = triangulate_with_parameters(&shape("roof"), &options(4000, 0.0, 0)).unwrap();
    assert_eq!(
        (vertices.len(), faces.len()),
        (mesh.positions.len(), mesh.triangles.len())
    );
    for (line, p) in vertices.iter().zip(&mesh.positions) {
        assert!(
            (Vec3::from_column_slice(line) - p).amax() < 5.1e-6,
            "{line:?} {p:?}"
        );
    }
    for (line, triangle) in faces.iter().zip(&mesh.triangles) {
        assert_eq!(*line, triangle.map(|i| f64::from(i + 1)));
    }
}
