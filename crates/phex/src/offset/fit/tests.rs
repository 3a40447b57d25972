use super::*;
use crate::koebe::{BoundaryCondition, KoebeOptions, koebe};
use crate::offset::edge_offset::{edge_distances, edge_offset, face_curvatures};
use crate::progress::Silent;
use crate::test_meshes::*;
use phex_mesh::measure;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn surface(name: &str, parameters: &[(&str, f64)]) -> TriangleSurface {
    let shape = Shape::from_name(name, parameters).unwrap();
    let options = TriangulationOptions {
        triangles: 20_000,
        ..TriangulationOptions::default()
    };
    triangulate(&shape, &options).unwrap()
}

fn koebe_of(mesh: &HexMesh, options: &KoebeOptions) -> HexMesh {
    koebe(mesh, options, &Silent).unwrap().mesh
}

fn fit(mesh: &HexMesh, surface: &TriangleSurface, options: &FitOptions) -> Fitted {
    let fitted = fit_parallel(mesh, surface, options, &Silent).unwrap();
    assert_eq!(measure(&fitted.mesh).faces_not_simple, 0);
    fitted
}

fn assert_offsets(mesh: &HexMesh, gauss_image: &HexMesh) {
    assert!(largest_turn(mesh, gauss_image) < 1e-10);
    for distance in [-0.05, 0.02, 0.3] {
        let offset = edge_offset(mesh, gauss_image, distance);
        let error = |d: &f64| (d - distance.abs()).abs();
        let worst = edge_distances(mesh, &offset)
            .iter()
            .map(error)
            .fold(0.0, f64::max);
        assert!(worst < 1e-12, "{worst:e}");
    }
}

#[test]
fn ellipsoid_gets_edge_offsets() {
    let target = surface("ellipsoid", &[("a", 1.2), ("b", 1.0), ("c", 0.9)]);
    let graph = dual(&graph(&flipped_icosphere(150, 0, 1)));
    let gauss_image = koebe_of(&graph, &KoebeOptions::default());
    let fitted = fit(&gauss_image, &target, &FitOptions::default());
    assert_eq!(
        (fitted.status, fitted.edges_at_bound),
        (Status::Converged, 0)
    );
    assert!(
        fitted.rms_distance < 1e-3 * target.diagonal(),
        "{}",
        fitted.rms_distance
    );
    assert_offsets(&fitted.mesh, &gauss_image);
}

#[test]
fn sphere_gets_the_koebe_mesh_itself() {
    let target = surface("sphere", &[]);
    let gauss_image = koebe_of(&dual(&graph(&icosahedron())), &KoebeOptions::default());
    let fitted = fit(&gauss_image, &target, &FitOptions::default());
    let first = VertexId::new(0);
    let size = fitted.mesh.position(first).norm() / gauss_image.position(first).norm();
    for (p, k) in fitted.mesh.positions.iter().zip(&gauss_image.positions) {
        assert!((p - k * size).norm() < 1e-2, "{p} {k}");
    }
    for c in &face_curvatures(&fitted.mesh, &gauss_image) {
        assert!((c.mean * size + 1.0).abs() < 1e-2 && (c.gauss * size * size - 1.0).abs() < 1e-2);
    }
}

#[test]
fn dome_of_constant_mean_curvature() {
    // As in figure 1 of the paper: hexagons, constant mean curvature, two layers at constant edge
    // distance.
    let target = surface("elliptic-paraboloid", &[]);
    let koebe_options = KoebeOptions {
        opening: 30.0,
        ..KoebeOptions::default()
    };
    let gauss_image = koebe_of(&hexagon_patch(5), &koebe_options);
    let plain = fit(&gauss_image, &target, &FitOptions::default());
    let options = FitOptions {
        constant_mean_curvature: 100.0,
        ..FitOptions::default()
    };
    let dome = fit(&gauss_image, &target, &options);
    assert!(
        plain.mean_curvature_spread > 0.02,
        "{}",
        plain.mean_curvature_spread
    );
    assert!(
        dome.mean_curvature_spread < 1e-3,
        "{}",
        dome.mean_curvature_spread
    );
    assert!(dome.rms_distance < 0.01 * target.diagonal());
    assert_offsets(&dome.mesh, &gauss_image);
}

#[test]
fn koebe_patch_of_a_gauss_image_fits_where_the_mesh_was() {
    let target = surface("elliptic-paraboloid", &[]);
    let flat = hexagon_patch(5);
    let lifted = flat.positions.map(|p| {
        let q = p * 0.08;
        Vec3::new(q.x, q.y, -0.5 * (q.x * q.x / 1.2 + q.y * q.y / 1.8))
    });
    let boundary = BoundaryCondition::GaussImage;
    let options = KoebeOptions {
        boundary,
        ..KoebeOptions::default()
    };
    let gauss_image = koebe_of(&flat.with_positions(lifted.clone()), &options);
    let fitted = fit(&gauss_image, &target, &FitOptions::default());
    assert!(
        fitted.rms_distance < 1e-3 * target.diagonal(),
        "{}",
        fitted.rms_distance
    );
    for (p, q) in fitted.mesh.positions.iter().zip(&lifted) {
        let off = (p - q).norm();
        assert!(off < 0.25, "{off}");
    }
}

#[test]
fn positive_lengths_hold_where_the_surface_would_rather_not() {
    // Radii of curvature differ by up to 4.6: too much for regular hexagons of any orientation.
    let target = surface("ellipsoid", &[]);
    let graph = dual(&graph(&flipped_icosphere(150, 0, 1)));
    let gauss_image = koebe_of(&graph, &KoebeOptions::default());
    let options = FitOptions {
        least_edge: 0.1,
        max_rounds: 5,
        ..FitOptions::default()
    };
    let fitted = fit(&gauss_image, &target, &options);
    let lengths = ParallelSpace::new(&gauss_image)
        .unwrap()
        .lengths(&fitted.mesh);
    assert!(fitted.edges_at_bound > 10, "{}", fitted.edges_at_bound);
    assert!(lengths.iter().all(|&l| l > 0.0));
    assert_offsets(&fitted.mesh, &gauss_image);
}

#[test]
fn scale_and_place_of_the_surface_change_nothing_else() {
    let target = surface("elliptic-paraboloid", &[]);
    let similarity = |p: Vec3| p * 40.0 + Vec3::new(100.0, -50.0, 7.0);
    let positions = target.positions().iter().map(|&p| similarity(p)).collect();
    let faces = target.topology().face_lists();
    let faces: Vec<[u32; 3]> = faces.iter().map(|f| [f[0], f[1], f[2]]).collect();
    let moved = TriangleSurface::new(positions, &faces).unwrap();
    let koebe_options = KoebeOptions {
        opening: 30.0,
        ..KoebeOptions::default()
    };
    let gauss_image = koebe_of(&hexagon_patch(3), &koebe_options);
    let options = FitOptions {
        max_rounds: 3,
        ..FitOptions::default()
    };
    let (a, b) = (
        fit(&gauss_image, &target, &options),
        fit(&gauss_image, &moved, &options),
    );
    for (p, q) in a.mesh.positions.iter().zip(&b.mesh.positions) {
        assert!((similarity(*p) - q).norm() < 1e-3, "{p} {q}");
    }
}

#[test]
fn unusable_input_is_refused() {
    let target = surface("sphere", &[]);
    let mesh = prism(5);
    let refuse = |mesh: &HexMesh, options: &FitOptions| {
        fit_parallel(mesh, &target, options, &Silent).unwrap_err()
    };
    let mut bent = mesh.clone();
    bent.positions[VertexId::new(0)].z += 0.3;
    let error = refuse(&bent, &FitOptions::default());
    assert!(
        matches!(error, FitError::Parallel(ParallelError::NotPlanar { .. })),
        "{error}"
    );
    for least_edge in [f64::NAN, 0.0, 1.0] {
        let error = refuse(
            &mesh,
            &FitOptions {
                least_edge,
                ..FitOptions::default()
            },
        );
        assert!(
            matches!(
                error,
                FitError::Option {
                    option: "least_edge",
                    ..
                }
            ),
            "{error}"
        );
    }
    let error = refuse(&hexagon_patch(2), &FitOptions::default());
    assert!(matches!(error, FitError::OneFootPoint { .. }), "{error}");
}
