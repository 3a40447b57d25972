//! The method `koebe`: panels with offsets at constant edge distance, on patches of both signs of
//! the Gauss curvature, and on closed convex surfaces.

mod common;

use phex::layout::{DomainError, LayoutError};
use phex::offset::{OffsetOptions, edge_gauss_image, face_curvatures};
use phex::pipeline::Method;
use phex::{Boundary, MeshOptions, MeshRun, PanelSize, PipelineError, Silent, mesh_surface};
use phex_mesh::measure::deviation;
use phex_mesh::{HexMesh, TriangleSurface, Vec3, measure};

/// A patch over a square of parameters.
fn patch(size: f64, point: impl Fn(f64, f64) -> [f64; 3]) -> TriangleSurface {
    const N: u32 = 60;
    let at = |k: u32| (2.0 * f64::from(k) / f64::from(N) - 1.0) * size;
    let positions = (0..=N).flat_map(|i| (0..=N).map(move |j| (i, j)));
    let positions = positions
        .map(|(i, j)| Vec3::from(point(at(i), at(j))))
        .collect();
    let number = |i: u32, j: u32| i * (N + 1) + j;
    let cells = (0..N).flat_map(|i| (0..N).map(move |j| (i, j)));
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|(i, j)| {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| number(i, j));
            [[a, b, c], [a, c, d]]
        })
        .collect();
    TriangleSurface::new(positions, &triangles).unwrap()
}

fn hyperbolic_paraboloid() -> TriangleSurface {
    patch(0.8, |u, v| [u, v, 0.5 * (u * u - v * v)])
}

fn elliptic_paraboloid() -> TriangleSurface {
    patch(0.8, |u, v| [u, v, -0.5 * (u * u / 1.2 + v * v / 1.8)])
}

fn catenoid() -> TriangleSurface {
    patch(0.9, |u, v| [u.cosh() * v.cos(), u.cosh() * v.sin(), u])
}

fn enneper() -> TriangleSurface {
    patch(0.6, |u, v| {
        [
            u - u.powi(3) / 3.0 + u * v * v,
            -v + v.powi(3) / 3.0 - v * u * u,
            u * u - v * v,
        ]
    })
}

fn helicoid() -> TriangleSurface {
    patch(0.8, |u, v| [u.sinh() * v.cos(), u.sinh() * v.sin(), v])
}

fn hyperboloid() -> TriangleSurface {
    patch(0.6, |u, v| {
        [u.cosh() * v.cos(), u.cosh() * v.sin(), 1.2 * u.sinh()]
    })
}

/// The inner part of a torus, off its parabolic curves.
fn inner_torus() -> TriangleSurface {
    patch(0.9, |u, v| {
        let r = 1.0 - 0.4 * u.cos();
        [r * v.cos(), r * v.sin(), -0.4 * u.sin()]
    })
}

fn options(panels: usize) -> MeshOptions {
    MeshOptions {
        size: PanelSize::Panels(panels),
        method: Method::Koebe,
        boundary: Boundary::Whole,
        ..Default::default()
    }
}

fn run(surface: &TriangleSurface, options: &MeshOptions) -> MeshRun {
    mesh_surface(surface, options, &Silent).unwrap()
}

/// Distance and direction of each pair of corresponding edges, from coordinates alone; over the
/// diagonal.
fn worst_of_edges(mesh: &HexMesh, moved: &HexMesh, distance: f64) -> f64 {
    let t = mesh.topology();
    let worst = t.edges().map(|e| {
        let [a, b] = t.edge_vertices(e);
        let [u, w] = [mesh, moved].map(|m| (m.position(b) - m.position(a)).normalize());
        let off = moved.position(a) - mesh.position(a);
        let away = (off - u * off.dot(&u)).norm();
        (away - distance.abs())
            .abs()
            .max(u.cross(&w).norm() * mesh.mean_edge())
    });
    worst.fold(0.0, f64::max) / mesh.diagonal()
}

fn assert_edge_offsets(name: &str, mesh: &HexMesh) {
    let found = edge_gauss_image(mesh, &OffsetOptions::default()).unwrap();
    for share in [0.01, 0.003, -0.003, -0.01] {
        let distance = share * mesh.diagonal();
        let error = worst_of_edges(mesh, &found.image.offset(mesh, distance), distance);
        assert!(error < 1e-12, "{name}: {error:e} at {share}");
    }
}

fn assert_hexagons(name: &str, mesh: &HexMesh) {
    let t = mesh.topology();
    assert!(
        t.faces().all(|f| t.valence(f) == 6),
        "{name}: hexagons only"
    );
}

#[test]
fn patches_of_both_signs_have_edge_offsets_on_both_sides() {
    let cases = [
        ("elliptic paraboloid", elliptic_paraboloid(), false),
        ("hyperbolic paraboloid", hyperbolic_paraboloid(), true),
        ("catenoid", catenoid(), true),
        ("enneper", enneper(), true),
        ("helicoid", helicoid(), true),
        ("hyperboloid", hyperboloid(), true),
        ("inner torus", inner_torus(), true),
    ];
    for (name, surface, saddle) in cases {
        let run = run(&surface, &options(120));
        assert!(run.is_sound(), "{name}: {:?}", run.violations.first());
        assert_hexagons(name, &run.mesh);
        let measures = measure(&run.mesh);
        assert!(
            measures.planarity.max < 1e-12,
            "{name}: {}",
            measures.planarity.max
        );
        assert!(
            measures.clearance.min > 0.1,
            "{name}: {}",
            measures.clearance.min
        );
        let concave = if saddle { measures.faces } else { 0 };
        assert_eq!(measures.faces_concave_simple, concave, "{name}");
        let off = deviation(&run.mesh, &surface);
        let beyond = run.beyond.as_ref().map(|b| deviation(&run.mesh, &b.smooth));
        let most = beyond.map_or(off.deviation_max, |b| b.deviation_max);
        assert!(most < 5e-3, "{name}: {most}");
        let told = run.statistics.classical.unwrap();
        assert_eq!(told.reversed_edges.unwrap() > 0, saddle, "{name}");
        assert_edge_offsets(name, &run.mesh);
    }
}

#[test]
fn a_closed_convex_surface_has_twelve_pentagons_and_edge_offsets() {
    let surface = common::shape_with("ellipsoid", &[("a", 1.2), ("b", 1.0), ("c", 0.9)], 4000);
    let run = run(&surface, &options(150));
    assert!(run.is_sound(), "{:?}", run.violations.first());
    let t = run.mesh.topology();
    let pentagons = t.faces().filter(|f| t.valence(*f) == 5).count();
    let hexagons = t.faces().filter(|f| t.valence(*f) == 6).count();
    assert!(pentagons >= 12 && pentagons + hexagons + 12 >= t.n_faces());
    assert_edge_offsets("ellipsoid", &run.mesh);
}

#[test]
fn minimal_surfaces_have_mean_curvature_zero_by_steiner() {
    for (name, surface) in [("catenoid", catenoid()), ("enneper", enneper())] {
        let mut options = options(120);
        options.dual.minimal = true;
        let run = run(&surface, &options);
        assert!(run.is_sound(), "{name}: {:?}", run.violations.first());
        let found = edge_gauss_image(&run.mesh, &OffsetOptions::default()).unwrap();
        let image = found.image.mesh(&run.mesh);
        let curvatures = face_curvatures(&run.mesh, &image);
        let square: f64 = curvatures.iter().map(|c| c.mean.powi(2)).sum();
        let rms = (square / curvatures.len() as f64).sqrt() * surface.diagonal();
        assert!(rms < 1e-3 * 12f64.sqrt(), "{name}: {rms}");
        assert_edge_offsets(name, &run.mesh);
    }
}

#[test]
fn panels_are_closer_where_they_are_smaller() {
    let surface = catenoid();
    let rms = |panels| {
        let run = run(&surface, &options(panels));
        let beyond = run.beyond.unwrap();
        deviation(&run.mesh, &beyond.smooth).deviation_rms
    };
    let ratio = rms(60) / rms(240);
    assert!(
        ratio > 2.0,
        "four times as many panels, {ratio} times as close"
    );
}

#[test]
fn other_surfaces_are_refused_with_a_vertex() {
    let refused = |surface: &TriangleSurface| match mesh_surface(surface, &options(120), &Silent) {
        Err(PipelineError::Layout(LayoutError::Domain(error))) => error,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("not refused"),
    };
    let plane = refused(&common::shape("plane", 3000));
    assert!(matches!(plane, DomainError::Developable { .. }), "{plane}");
    assert!(plane.to_string().contains("vertex"), "{plane}");
    let cylinder = refused(&common::shape("cylinder", 3000));
    assert!(
        matches!(cylinder, DomainError::Developable { .. }),
        "{cylinder}"
    );
    let torus = refused(&common::shape("torus", 3000));
    assert!(
        matches!(torus, DomainError::MixedCurvature { .. }),
        "{torus}"
    );
    let catenoid = refused(&common::shape("catenoid", 3000));
    assert!(
        matches!(catenoid, DomainError::Holes { loops: 2, .. }),
        "{catenoid}"
    );
    // More than a turn of a helicoid: normals come back.
    let turns = patch(1.0, |u, v| {
        [u * (5.0 * v).cos(), u * (5.0 * v).sin(), 2.0 * v]
    });
    let overlapping = refused(&turns);
    assert!(
        matches!(overlapping, DomainError::ManyToOne { .. }),
        "{overlapping}"
    );
}

#[test]
fn vertices_are_not_moved_to_the_boundary() {
    let snap = MeshOptions {
        boundary: Boundary::Snap,
        ..options(120)
    };
    let Err(error) = mesh_surface(&catenoid(), &snap, &Silent) else {
        panic!("not refused");
    };
    assert!(matches!(error, PipelineError::Snap { .. }), "{error}");
}
