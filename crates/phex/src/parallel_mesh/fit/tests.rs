use super::*;
use crate::parallel_mesh::edge_offset::{edge_distances, edge_offset, face_curvatures};
use crate::parallel_mesh::koebe::{BoundaryCondition, KoebeOptions, koebe};
use crate::parallel_mesh::test_meshes::*;
use crate::progress::Silent;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{FaceId, measure};

fn surface(name: &str, parameters: &[(&str, f64)]) -> TriangleSurface {
    let shape = Shape::from_name(name, parameters).unwrap();
    triangulate(
        &shape,
        &TriangulationOptions {
            triangles: 20_000,
            ..TriangulationOptions::default()
        },
    )
    .unwrap()
}

fn assert_offsets(mesh: &HexMesh, gauss_image: &HexMesh) {
    for distance in [-0.05, 0.02, 0.3] {
        let offset = edge_offset(mesh, gauss_image, distance);
        let worst = edge_distances(mesh, &offset)
            .iter()
            .map(|d| (d - distance.abs()).abs())
            .fold(0.0, f64::max);
        assert!(worst < 1e-12, "{worst:e}");
        assert!(largest_turn(mesh, gauss_image) < 1e-10);
    }
}

#[test]
fn ellipsoid_gets_edge_offsets() {
    let target = surface("ellipsoid", &[]);
    let graph = dual(&graph(&flipped_icosphere(600, 0, 1)));
    let gauss_image = koebe(&graph, &KoebeOptions::default(), &Silent)
        .unwrap()
        .mesh;
    let fitted = fit_parallel(&gauss_image, &target, &FitOptions::default(), &Silent).unwrap();
    println!(
        "{:?} {} {} {} {}",
        fitted.status,
        fitted.rounds,
        fitted.max_distance,
        fitted.rms_distance,
        fitted.edges_at_bound
    );
    println!("{:?}", target.diagonal());
    assert_offsets(&fitted.mesh, &gauss_image);
    assert!(fitted.rms_distance < 1e-2 * target.diagonal());
}
