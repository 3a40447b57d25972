//! Edge-distance offsets of given meshes.

use super::fixtures::*;
use crate::koebe::{KoebeOptions, koebe, touching_points};
use crate::offset::*;
use crate::optimise::tests::fixtures::planar_paraboloid;
use crate::progress::Silent;
use crate::test_meshes::{dual, flipped_icosphere, graph, hexagon_patch, largest_turn};
use phex_mesh::{EdgeId, HexMesh, PerFace, PerVertex, Vec3, VertexId, measure};

fn koebe_of(mesh: &HexMesh) -> HexMesh {
    koebe(mesh, &KoebeOptions::default(), &Silent).unwrap().mesh
}

fn options() -> OffsetOptions {
    OffsetOptions::default()
}

/// Moves the planes of the faces, each by its own distance: a mesh parallel to a closed one.
fn shifted(mesh: &HexMesh, shift: impl Fn(usize) -> f64) -> HexMesh {
    let n = mesh.topology().n_faces();
    let distances = PerFace::from_vec((0..n).map(shift).collect());
    face_offset(mesh, &distances, &options())
        .unwrap()
        .apply(mesh)
}

fn check(name: &str, mesh: &HexMesh, koebe: &HexMesh) {
    let found = edge_gauss_image(mesh, &options()).unwrap();
    assert!(found.defect < 1e-11, "{name}: {:e}", found.defect);
    assert!(found.facing > 0.0, "{name}: {}", found.facing);
    let image = found.image.mesh(mesh);
    let miss = distance(&image, koebe);
    assert!(miss < 1e-10, "{name}: off the Koebe mesh by {miss:e}");
    for p in touching_points(&image).iter() {
        assert!((p.norm() - 1.0).abs() < 1e-12, "{name}: {:e}", p.norm());
    }
    for d in [0.1, -0.03] {
        let moved = found.image.offset(mesh, d);
        let error = distance_error(mesh, &moved, OffsetKind::Edge, d).unwrap();
        assert!(error < 1e-12, "{name}: {error:e}");
        assert!(largest_turn(mesh, &moved) < 1e-10, "{name}");
    }
}

#[test]
fn the_koebe_mesh_is_found_again() {
    let random = koebe_of(&dual(&graph(&flipped_icosphere(150, 150, 3))));
    let patch = koebe_of(&hexagon_patch(4));
    for (name, koebe) in [
        ("cube", koebe_of(&cuboid(1.0, 1.0, 1.0))),
        ("dodecahedron", koebe_of(&dodecahedron())),
        ("random", random),
        ("patch", patch),
    ] {
        let moved = mapped(&koebe, |p| 3.0 * p + Vec3::new(5.0, 1.0, -2.0));
        check(name, &koebe, &koebe);
        check(name, &moved, &koebe);
    }
}

#[test]
fn parallel_meshes_have_it_too() {
    let koebe = koebe_of(&dual(&graph(&flipped_icosphere(40, 40, 5))));
    check(
        "shifted",
        &shifted(&koebe, |f| 0.03 * (f % 3) as f64),
        &koebe,
    );
    let dodecahedron = koebe_of(&dodecahedron());
    // A face beyond the apex of its neighbours: its edges have turned round and touch to the other
    // side.
    let spiked = shifted(&dodecahedron, |f| if f == 0 { 1.3 } else { 0.0 });
    let found = edge_gauss_image(&spiked, &options()).unwrap();
    assert!(found.defect < 1e-12);
    assert!(largest_turn(&spiked, &found.image.mesh(&spiked)) < 1e-12);
}

#[test]
fn a_face_alone_has_an_inscribed_circle() {
    let triangle = mesh(
        &[[0.0, 0.0, 2.0], [3.0, 0.0, 2.0], [0.0, 4.0, 2.0]],
        &[&[0, 1, 2]],
    );
    let found = edge_gauss_image(&triangle, &options()).unwrap();
    assert!(found.defect < 1e-14);
    let moved = found.image.offset(&triangle, 0.1);
    let error = distance_error(&triangle, &moved, OffsetKind::Edge, 0.1).unwrap();
    assert!(error < 1e-14);
}

#[test]
fn other_meshes_are_refused_by_edge() {
    for mesh in [polar_dual(&spread_points(40)), planar_paraboloid(12, 6)] {
        let refused = edge_gauss_image(&mesh, &options()).unwrap_err();
        let OffsetError::NotParallelToKoebe {
            edge,
            vertices,
            defect,
        } = refused
        else {
            panic!("{refused}");
        };
        assert_eq!(mesh.topology().edge_vertices(edge), vertices);
        assert!(defect > 1e-6);
    }
}

/// Every box is parallel to the cube.
#[test]
fn a_cuboid_has_edge_offsets() {
    let koebe = koebe_of(&cuboid(1.0, 1.0, 1.0));
    check("cuboid", &cuboid(1.0, 2.0, 3.0), &koebe);
}

/// A Koebe patch without its outermost corners' outsides: every panel of the rim is cut at random.
fn cut(mesh: &HexMesh) -> HexMesh {
    let t = mesh.topology();
    let positions = PerVertex::from_fn(t.n_vertices(), |v| {
        let x = mesh.position(v);
        let [f] = t.faces_at(v).collect::<Vec<_>>()[..] else {
            return slid(mesh, v);
        };
        // A corner of one panel goes anywhere in its plane.
        x.lerp(&mesh.centre(f), 0.1 + 0.05 * (v.index() % 4) as f64)
    });
    mesh.with_positions(positions)
}

/// A vertex of the rim with one inner edge, somewhere else on that.
fn slid(mesh: &HexMesh, v: VertexId) -> Vec3 {
    let t = mesh.topology();
    let inner = t.outgoing(v).find(|h| !t.is_boundary_edge(t.edge(*h)));
    match inner {
        Some(h) if t.is_boundary_vertex(v) => {
            let share = 0.1 + 0.1 * (v.index() % 3) as f64;
            mesh.position(v).lerp(&mesh.position(t.target(h)), share)
        }
        _ => mesh.position(v),
    }
}

#[test]
fn a_cut_mesh_has_offsets_of_its_inner_edges() {
    let koebe = koebe_of(&hexagon_patch(4));
    let mesh = cut(&koebe);
    let found = edge_gauss_image(&mesh, &options()).unwrap();
    let t = mesh.topology();
    let rim: Vec<EdgeId> = t.boundary_edges().collect();
    assert_eq!(found.free_edges, rim);
    assert!(
        found.defect < 1e-12 && found.facing > 0.5,
        "{}",
        found.facing
    );
    for v in t.inner_vertices() {
        let miss = (found.image.positions[v] - koebe.position(v)).norm();
        assert!(miss < 1e-12, "the Koebe mesh is found again: {miss:e}");
    }
    for d in [0.05, -0.03] {
        let moved = found.image.offset(&mesh, d);
        assert!(found.distance_error(&mesh, &moved, d) < 1e-13);
        let own = distance_error(&mesh, &moved, OffsetKind::Edge, d).unwrap();
        assert!(own > 1e-3 * d.abs(), "edges of the cut have no distance");
        assert!(measure(&moved).planarity.max < 1e-12);
    }
}
