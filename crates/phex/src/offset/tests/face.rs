//! Face-distance offsets.

use super::fixtures::*;
use crate::offset::face_offset::face_normals;
use crate::offset::*;
use crate::optimise::tests::fixtures::planar_paraboloid;
use phex_mesh::{FlatFace, HexMesh, PerFace, Vec3, VertexId, Violation};

fn image(mesh: &HexMesh) -> GaussImage {
    face_gauss_image(mesh, &OffsetOptions::default()).unwrap()
}

/// Closed and open, convex and concave, flat vertices included.
fn meshes() -> Vec<(&'static str, HexMesh)> {
    let paraboloid = planar_paraboloid(16, 8);
    let flat = mapped(&paraboloid, |p| Vec3::new(p.x, p.y, 1e-9 * p.z));
    let plane = mapped(&paraboloid, |p| Vec3::new(p.x, p.y, 0.0));
    vec![
        ("cuboid", cuboid(1.0, 2.0, 3.0)),
        ("L", l_prism()),
        ("dodecahedron", dodecahedron()),
        ("40 tangent planes", polar_dual(&spread_points(40))),
        ("paraboloid", paraboloid),
        ("flat paraboloid", flat),
        ("plane", plane),
    ]
}

#[test]
fn every_face_moves_by_the_distance_and_stays_planar() {
    for (name, mesh) in meshes() {
        let (normals, size) = (face_normals(&mesh).unwrap(), mesh.diagonal());
        for d in [0.01, -0.02] {
            let moved = image(&mesh).offset(&mesh, d);
            let faces = FlatFace::all(&moved);
            for f in mesh.topology().faces() {
                for (p, q) in mesh.corners(f).zip(moved.corners(f)) {
                    let error = ((q - p).dot(&normals[f]) - d).abs();
                    assert!(error <= 1e-12 * size, "{name}: {f} misses {d} by {error:e}");
                }
                assert!(
                    faces[f].planarity_length <= 1e-12 * moved.mean_edge(),
                    "{name}: {f}"
                );
                assert!(
                    (faces[f].normal() - normals[f]).norm() < 1e-12,
                    "{name}: {f}"
                );
            }
        }
    }
}

#[test]
fn inner_edges_stay_parallel() {
    for (name, mesh) in meshes() {
        let moved = image(&mesh).offset(&mesh, 0.01);
        let topology = mesh.topology();
        for e in topology.inner_edges() {
            let [a, b] = topology.edge_vertices(e);
            let (p, q) = (
                mesh.position(b) - mesh.position(a),
                moved.position(b) - moved.position(a),
            );
            let sine = p.cross(&q).norm() / (p.norm() * q.norm());
            assert!(sine < 1e-10, "{name}: {e} turns by {sine:e}");
        }
    }
}

/// Which edges turn at the boundary, and how far, is told as it is measured on the coordinates of a
/// layer.
#[test]
fn turned_edges_are_those_at_the_rim_that_are_not_parallel() {
    for (name, mesh) in meshes() {
        let (image, topology) = (image(&mesh), mesh.topology());
        let turned = image.turned_edges(&mesh);
        let is_rim = |e| topology.is_boundary_edge(e);
        assert!(turned.iter().all(|t| is_rim(t.edge)), "{name}");
        if !name.contains("paraboloid") {
            assert!(turned.is_empty(), "{name}");
        }
        for d in [0.1 * mesh.mean_edge(), -0.05 * mesh.mean_edge()] {
            let moved = image.offset(&mesh, d);
            for e in topology.edges() {
                let [a, b] = topology.edge_vertices(e);
                let along = |m: &HexMesh| m.position(b) - m.position(a);
                let measured = along(&mesh).angle(&along(&moved));
                let told = turned.iter().find(|t| t.edge == e);
                let told = told.map_or(0.0, |t| t.angle(d));
                assert!((measured - told).abs() < 1e-7, "{name}: {e} at {d}");
            }
            let most = turned.iter().map(|t| t.angle(d)).fold(0.0, f64::max);
            assert_eq!(most > 1e-4, name == "paraboloid", "{name}: {most}");
        }
    }
}

/// A mesh flattened to a slope of 1e-10 moves straight up, to all digits.
#[test]
fn nearly_flat_vertices_do_not_drift() {
    let steep = planar_paraboloid(16, 8);
    let mesh = mapped(&steep, |p| Vec3::new(p.x, p.y, 1e-9 * p.z));
    for (v, p) in image(&mesh).positions.enumerate() {
        let slope = 2e-9 * steep.position(v).xy().norm();
        assert!(p.xy().norm() <= 2.0 * slope + 1e-14, "{v} drifts: {p:?}");
        assert!((p.z - 1.0).abs() < 1e-14);
    }
}

#[test]
fn there_and_back_is_the_identity() {
    for (name, mesh) in meshes() {
        let away = image(&mesh).offset(&mesh, 0.02);
        let back = image(&away).offset(&away, -0.02);
        // What rounding has done to flat faces may turn them by their rounding over their size.
        assert!(
            distance(&mesh, &back) < 1e-12 * mesh.diagonal(),
            "{name}: {:e}",
            distance(&mesh, &back)
        );
    }
}

#[test]
fn the_offset_of_the_scaled_mesh_is_the_scaled_offset() {
    for (name, mesh) in meshes() {
        let offset = image(&mesh).offset(&mesh, 0.02);
        for scale in [1e-3, 37.0, 1e6] {
            let scaled = mapped(&mesh, |p| p * scale);
            let moved = image(&scaled).offset(&scaled, 0.02 * scale);
            let error = distance(&moved, &mapped(&offset, |p| p * scale));
            assert!(error < 1e-12 * scale * mesh.diagonal(), "{name}: {error:e}");
        }
    }
}

#[test]
fn the_offset_has_the_same_gauss_image() {
    for (name, mesh) in meshes() {
        let before = image(&mesh);
        let after = image(&before.offset(&mesh, 0.02));
        let error = distance(&before.mesh(&mesh), &after.mesh(&mesh));
        assert!(error < 1e-11, "{name}: {error:e}");
    }
}

/// The faces of the Gauss image touch the unit sphere, each at its normal.
#[test]
fn faces_of_the_gauss_image_touch_the_sphere() {
    for (name, mesh) in meshes() {
        let normals = face_normals(&mesh).unwrap();
        let gauss = image(&mesh).mesh(&mesh);
        for f in mesh.topology().faces() {
            for p in gauss.corners(f) {
                assert!((p.dot(&normals[f]) - 1.0).abs() < 1e-13, "{name}: {f}");
            }
        }
    }
}

/// `M + d M'` is what plane by plane comes out.
#[test]
fn the_sum_is_the_plane_by_plane_offset() {
    for mesh in [cuboid(1.0, 2.0, 3.0), l_prism(), dodecahedron()] {
        let (d, normals) = (0.03, face_normals(&mesh).unwrap());
        let moved = image(&mesh).offset(&mesh, d);
        for v in mesh.topology().vertices() {
            let faces: Vec<_> = mesh.topology().outgoing(v).collect();
            let n = [0, 1, 2].map(|k| normals[mesh.topology().face(faces[k])]);
            let rows = nalgebra::Matrix3::from_columns(&n).transpose();
            let heights = rows * mesh.position(v) + Vec3::repeat(d);
            let meeting = rows.lu().solve(&heights).unwrap();
            assert!((meeting - moved.position(v)).norm() < 1e-13);
        }
    }
}

fn area(mesh: &HexMesh) -> f64 {
    FlatFace::all(mesh).iter().map(FlatFace::area).sum()
}

/// Steiner: `A + 2 H d + A' d^2` and `V + A d + H d^2 + A'/3 d^3` with `H = sum l tan(theta / 2)`
/// and the Gauss image's `A'`.
#[test]
fn areas_and_volumes_follow_steiner() {
    for mesh in [
        cuboid(1.0, 2.0, 3.0),
        dodecahedron(),
        polar_dual(&spread_points(30)),
        l_prism(),
    ] {
        let normals = face_normals(&mesh).unwrap();
        let topology = mesh.topology();
        let bend = |e| {
            let h = topology.edge_half_edge(e);
            let [n, m] = topology.faces_beside(e).unwrap().map(|f| normals[f]);
            let along = mesh.position(topology.target(h)) - mesh.position(topology.origin(h));
            // tan of half the angle between the normals, negative at a concave edge.
            n.cross(&m).dot(&along) / (1.0 + n.dot(&m))
        };
        let h: f64 = topology.edges().map(bend).sum();
        let (a, v) = (area(&mesh), mesh.to_soup().volume());
        let gauss = image(&mesh);
        // Faces of the Gauss image count with their orientation.
        let turned = 3.0 * gauss.mesh(&mesh).to_soup().volume();
        for d in [0.05, 0.3, -0.04] {
            let moved = gauss.offset(&mesh, d);
            let expected = a + 2.0 * h * d + turned * d * d;
            assert!((area(&moved) - expected).abs() < 1e-12 * a, "area at {d}");
            let expected = v + a * d + h * d * d + turned * d.powi(3) / 3.0;
            let found = moved.to_soup().volume();
            assert!((found - expected).abs() < 1e-12 * v, "volume at {d}");
        }
    }
}

#[test]
fn faces_may_have_distances_of_their_own() {
    let mesh = polar_dual(&spread_points(25));
    let d = PerFace::from_fn(25, |f: phex_mesh::FaceId| 0.01 * (f.index() as f64).sin());
    let offset = face_offset(&mesh, &d, &OffsetOptions::default()).unwrap();
    let moved = offset.apply(&mesh);
    for f in mesh.topology().faces() {
        for p in moved.corners(f) {
            let error = p.dot(&offset.normals[f]) - 1.0 - d[f];
            assert!(error.abs() < 1e-13, "{f}: {error:e}");
        }
    }
    assert!(offset.worst().1 < 1e-12);
}

#[test]
fn coplanar_faces_can_not_part() {
    let mesh = mapped(&planar_paraboloid(8, 4), |p| Vec3::new(p.x, p.y, 0.0));
    let n = mesh.topology().n_faces();
    let mut d = PerFace::filled(n, 0.1);
    assert!(face_offset(&mesh, &d, &OffsetOptions::default()).is_ok());
    d[phex_mesh::FaceId::new(3)] = 0.2;
    let refused = face_offset(&mesh, &d, &OffsetOptions::default()).unwrap_err();
    let OffsetError::Incompatible { vertex, residual } = refused else {
        panic!("{refused}");
    };
    let holders = mesh.topology().outgoing(vertex);
    assert!(
        holders
            .map(|h| mesh.topology().face(h).index())
            .any(|f| f == 3)
    );
    assert!(residual > 0.02 && residual < 0.1);
}

/// Inwards the shortest side of a cuboid vanishes at half its length, less what validity asks of
/// edges.
#[test]
fn the_safe_distance_of_a_cuboid() {
    let mesh = cuboid(1.0, 2.0, 3.0);
    let options = OffsetOptions::default();
    let safe = safe_distances(&mesh, &image(&mesh), &options);
    // The edge 1 - 2d is at its limit, 0.05 of the mean edge 2 - 2d (and the clearance is the
    // same).
    let expected = (1.0 - 0.05 * 2.0) / (2.0 - 0.05 * 2.0);
    assert!((safe.inward.distance - expected).abs() < 1e-6, "{safe:?}");
    assert!(matches!(
        safe.inward.limit,
        Some(Violation::CollapsedEdge { .. } | Violation::SmallClearance { .. })
    ));
    // Outwards the mean edge grows as fast as the edges, so nothing ends it.
    assert_eq!(safe.outward.distance, f64::INFINITY);
    // Where only small distances matter the way ends a little behind them.
    let near = safe_distances_up_to(0.1, &mesh, &image(&mesh), &options);
    for side in [&near.inward, &near.outward] {
        assert!(
            (0.1..=0.2).contains(&side.distance) && side.limit.is_none(),
            "{side:?}"
        );
    }
    let all = safe_distances_up_to(10.0, &mesh, &image(&mesh), &options);
    assert_eq!(all.inward, safe.inward);
    assert!(layer(&mesh, &image(&mesh), -0.99 * expected, &options).is_ok());
    let refused = layer(&mesh, &image(&mesh), -1.01 * expected, &options).unwrap_err();
    assert!(matches!(refused, OffsetError::NotValid { .. }));
}

/// Turned inside out, a cuboid looks valid again, face by face; its edges tell.
#[test]
fn a_mesh_turned_inside_out_is_refused() {
    let mesh = cuboid(1.0, 2.0, 3.0);
    let options = OffsetOptions::default();
    let refused = layer(&mesh, &image(&mesh), -4.0, &options).unwrap_err();
    let OffsetError::NotValid { first, count, .. } = refused else {
        panic!("{refused}");
    };
    assert!(matches!(*first, Violation::CollapsedEdge { length_rel, .. } if length_rel < 0.0));
    assert_eq!(count, 12);
}

/// Sheets that are far apart along the mesh meet before any edge vanishes.
#[test]
fn sheets_that_meet_are_found() {
    // A deep notch: outwards its walls, 0.2 apart, meet at 0.1.
    let notched = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 3.0],
        [2.1, 3.0],
        [2.1, 1.0],
        [1.9, 1.0],
        [1.9, 3.0],
        [0.0, 3.0],
    ];
    let mesh = prism(&notched, 1.0);
    let safe = safe_distances(&mesh, &image(&mesh), &OffsetOptions::default());
    assert!(
        safe.outward.distance > 0.0 && safe.outward.distance < 0.1,
        "{safe:?}"
    );
}

#[test]
fn wrong_input_is_refused_with_the_element() {
    let mesh = cuboid(1.0, 2.0, 3.0);
    let mut bent = mesh.clone();
    bent.positions[VertexId::new(6)].x += 0.01;
    let refused = face_gauss_image(&bent, &OffsetOptions::default()).unwrap_err();
    assert!(matches!(refused, OffsetError::NotPlanar { planarity, .. } if planarity > 1e-4));

    let mut broken = mesh.clone();
    broken.positions[VertexId::new(2)].y = f64::NAN;
    let vertex = VertexId::new(2);
    let refused = face_gauss_image(&broken, &OffsetOptions::default()).unwrap_err();
    assert_eq!(refused, OffsetError::NotFinite { vertex });

    let pyramid: [&[u32]; 5] = [
        &[3, 2, 1, 0],
        &[0, 1, 4],
        &[1, 2, 4],
        &[2, 3, 4],
        &[3, 0, 4],
    ];
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.5, 0.5, 1.0],
    ];
    let (vertex, degree) = (VertexId::new(4), 4);
    let refused =
        face_gauss_image(&self::mesh(&points, &pyramid), &OffsetOptions::default()).unwrap_err();
    assert_eq!(refused, OffsetError::WrongDegree { vertex, degree });
    assert!(refused.to_string().contains("vertex 4"));

    let (found, expected) = (5, 6);
    let refused =
        face_offset(&mesh, &PerFace::filled(5, 1.0), &OffsetOptions::default()).unwrap_err();
    assert_eq!(refused, OffsetError::DistanceCount { found, expected });
    let infinite = PerFace::filled(6, f64::INFINITY);
    assert!(matches!(
        face_offset(&mesh, &infinite, &OffsetOptions::default()),
        Err(OffsetError::Distance { .. })
    ));
}
