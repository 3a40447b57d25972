//! Offsets of meshes that the pipeline makes.

use phex::offset::face_normals;
use phex::offset::{
    OffsetError, OffsetOptions, PanelSolid, beam_axes, face_gauss_image, face_offset, layer,
    panel_solids, safe_distances, vertex_gauss_image,
};
use phex::optimise::{AngleOptions, SurfaceTarget, satisfy_angle_condition};
use phex::pipeline::Method;
use phex::trim::Boundary;
use phex::{MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{FlatFace, HexMesh, PerFace, Topology, measure};

fn panelled(shape: &str) -> HexMesh {
    let shape = Shape::from_name(shape, &[]).unwrap();
    let triangles = TriangulationOptions {
        triangles: 3000,
        ..Default::default()
    };
    let surface = triangulate(&shape, &triangles).unwrap();
    let options = MeshOptions {
        size: PanelSize::Panels(90),
        ..Default::default()
    };
    let run = mesh_surface(&surface, &options, &Silent).unwrap();
    assert!(run.is_sound(), "{:?}", run.violations());
    run.mesh
}

/// Faces at the distance, and planar, to 1e-12.
fn check_distance(name: &str, mesh: &HexMesh, d: f64) {
    let image = face_gauss_image(mesh, &OffsetOptions::default()).unwrap();
    let normals = face_normals(mesh).unwrap();
    let options = OffsetOptions::default();
    let moved = layer(mesh, &image, d, &options).unwrap();
    let (mut miss, mut bend) = (0.0f64, 0.0f64);
    for f in mesh.topology().faces() {
        for (p, q) in mesh.corners(f).zip(moved.corners(f)) {
            miss = miss.max(((q - p).dot(&normals[f]) - d).abs());
        }
        bend = bend.max(FlatFace::of(&moved, f).planarity_length);
    }
    let (miss, bend) = (miss / mesh.diagonal(), bend / moved.mean_edge());
    println!("{name} at {d:.3}: distances to {miss:.1e} diagonals, planarity {bend:.1e}");
    assert!(miss <= 1e-12, "{name}: {miss:e}");
    assert!(bend <= 1e-12, "{name}: {bend:e}");
}

fn check_solids(name: &str, mesh: &HexMesh, d: f64) {
    let image = face_gauss_image(mesh, &OffsetOptions::default()).unwrap();
    let upper = image.offset(mesh, d);
    let solids = panel_solids(mesh, &upper, 0.0).unwrap();
    for solid in &solids {
        let soup = solid.surface();
        let topology = Topology::from_faces(soup.positions.len(), &soup.faces).unwrap();
        assert!(topology.boundary_loops().is_empty(), "{name}: watertight");
    }
    if mesh.topology().boundary_loops().is_empty() {
        let shell = upper.to_soup().volume() - mesh.to_soup().volume();
        let sum: f64 = solids.iter().map(PanelSolid::volume).sum();
        assert!((sum - shell).abs() < 1e-11 * shell, "{name}: volumes");
    }
    let gap = 0.02 * mesh.mean_edge();
    assert!(panel_solids(mesh, &upper, gap).is_ok(), "{name}: gaps");
    let topology = mesh.topology();
    for beam in beam_axes(mesh, &upper).unwrap() {
        let inside = !topology.is_boundary_edge(beam.edge);
        assert!(!inside || beam.torsion < 1e-10, "{name}: {beam:?}");
    }
}

#[test]
fn meshes_of_the_pipeline() {
    for name in [
        "torus",
        "wave",
        "roof",
        "monkey-saddle",
        "ellipsoid",
        "catenoid",
    ] {
        let mesh = panelled(name);
        let image = face_gauss_image(&mesh, &OffsetOptions::default()).unwrap();
        let options = OffsetOptions::default();
        let safe = safe_distances(&mesh, &image, &options);
        let [outward, inward] = [&safe.outward, &safe.inward].map(|s| s.distance);
        println!("{name}: safe to {outward:.4} outward, {inward:.4} inward");
        let step = 0.05 * mesh.mean_edge();
        for far in [outward, inward] {
            assert!(far > step, "{name}: {safe:?}");
        }
        check_distance(name, &mesh, 0.5 * outward.min(mesh.mean_edge()));
        check_distance(name, &mesh, -0.5 * inward.min(mesh.mean_edge()));
        if inward.is_finite() {
            assert!(layer(&mesh, &image, -0.999 * inward, &options).is_ok());
            let past = layer(&mesh, &image, -1.001 * inward, &options).unwrap_err();
            assert!(
                matches!(past, OffsetError::NotValid { .. }),
                "{name}: {past}"
            );
        }
        check_solids(name, &mesh, step);
    }
}

/// Bricks that are kept whole at the boundary are hexagons, so angles can be made right and every
/// edge of the offset is parallel: on patches with K > 0, K < 0 and both.
#[test]
fn whole_bricks_have_vertex_offsets() {
    for name in ["elliptic-paraboloid", "hyperbolic-paraboloid", "wave"] {
        let shape = Shape::from_name(name, &[]).unwrap();
        let triangles = TriangulationOptions {
            triangles: 6000,
            ..Default::default()
        };
        let surface = triangulate(&shape, &triangles).unwrap();
        let options = MeshOptions {
            size: PanelSize::Panels(200),
            method: Method::BrickWall,
            boundary: Boundary::Whole,
            ..Default::default()
        };
        let bricks = mesh_surface(&surface, &options, &Silent).unwrap().mesh;
        let topology = bricks.topology();
        assert!(
            topology
                .faces()
                .all(|f| topology.valence(f).is_multiple_of(2)),
            "{name}"
        );
        let target = SurfaceTarget::new(&surface);
        let made =
            satisfy_angle_condition(&bricks, Some(&target), &AngleOptions::default(), &Silent)
                .unwrap();
        assert!(made.is_converged() && made.offenders.is_empty(), "{name}");
        assert!(made.angle_defect[1] <= 1e-12, "{name}");
        let spherical = vertex_gauss_image(&made.mesh, &OffsetOptions::default()).unwrap();
        assert!(spherical.free_edges.is_empty() && spherical.facing > 0.9);
        let d = 0.1 * made.mesh.mean_edge();
        let moved = layer(&made.mesh, &spherical.image, d, &OffsetOptions::default()).unwrap();
        for (p, q) in made.mesh.positions.iter().zip(&moved.positions) {
            assert!(((q - p).norm() - d).abs() <= 1e-12 * bricks.diagonal());
        }
        let along = |mesh: &HexMesh, [a, b]: [phex_mesh::VertexId; 2]| {
            (mesh.position(b) - mesh.position(a)).normalize()
        };
        for ends in topology.edges().map(|e| topology.edge_vertices(e)) {
            let turned = along(&made.mesh, ends).cross(&along(&moved, ends)).norm();
            assert!(turned <= 1e-10, "{name}: {turned:e}");
        }
        assert!(measure(&moved).planarity.max <= 1e-12, "{name}");
    }
}

/// Lattices of saddles start with angles that are off by up to a right one.
#[test]
fn lattices_of_saddles_have_vertex_offsets() {
    for name in ["monkey-saddle", "roof"] {
        let mesh = panelled(name);
        let made = satisfy_angle_condition(&mesh, None, &AngleOptions::default(), &Silent).unwrap();
        assert!(
            made.angle_defect[0] > 0.5,
            "{name}: {:?}",
            made.angle_defect
        );
        assert!(made.is_converged() && made.offenders.is_empty(), "{name}");
        let spherical = vertex_gauss_image(&made.mesh, &OffsetOptions::default()).unwrap();
        assert!(spherical.facing > 0.5, "{name}: {}", spherical.facing);
        let moved = spherical
            .image
            .offset(&made.mesh, 0.1 * made.mesh.mean_edge());
        assert!(measure(&moved).planarity.max <= 1e-12, "{name}");
    }
}

/// Distances of their own for all faces: where planes are not almost the same, every face is where
/// it should be.
#[test]
fn a_distance_for_each_face() {
    let mesh = panelled("ellipsoid");
    let n = mesh.topology().n_faces();
    let step = 0.01 * mesh.mean_edge();
    let wish = PerFace::from_fn(n, |f: phex_mesh::FaceId| {
        step * (1.0 + (f.index() % 3) as f64)
    });
    let offset = face_offset(&mesh, &wish, &OffsetOptions::default()).unwrap();
    let moved = offset.apply(&mesh);
    for f in mesh.topology().faces() {
        for (p, q) in mesh.corners(f).zip(moved.corners(f)) {
            let miss = (q - p).dot(&offset.normals[f]) - wish[f];
            assert!(miss.abs() <= 1e-12 * mesh.diagonal(), "{f}: {miss:e}");
        }
    }
}
