//! Vertex-distance offsets.

use super::fixtures::*;
use crate::offset::*;
use crate::optimise::tests::fixtures::planar_paraboloid;
use crate::optimise::{AngleOptimised, AngleOptions, satisfy_angle_condition};
use crate::progress::Silent;
use phex_mesh::{FaceId, FlatFace, HexMesh, ValidateOptions, Vec3, VertexId, violations};
use std::f64::consts::{PI, TAU};

fn torus(u: f64, v: f64) -> Vec3 {
    let r = 1.0 + 0.4 * v.cos();
    Vec3::new(r * u.cos(), r * u.sin(), 0.4 * v.sin())
}

fn between(from: f64, to: f64, t: f64) -> f64 {
    from + (to - from) * t
}

fn torus_patch(v: [f64; 2], kink: f64) -> HexMesh {
    patch(25, 9, kink, |s, t| torus(1.2 * s, between(v[0], v[1], t)))
}

/// Open patches of hexagons of every curvature; the last one is exactly planar before.
fn patches() -> Vec<(&'static str, HexMesh)> {
    let wave = patch(25, 9, 0.0, |s, t| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        Vec3::new(x, y, 0.3 * x.sin() + 0.2 * y.cos())
    });
    let saddle = patch(19, 9, -0.1, |s, t| {
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        Vec3::new(x, y, 0.3 * (x * x - y * y))
    });
    vec![
        ("torus, K > 0", torus_patch([-1.0, 1.0], 0.1)),
        ("torus, K < 0", torus_patch([2.3, 4.0], -0.1)),
        ("torus, K = 0 crossed", torus_patch([0.7, 2.4], 0.0)),
        ("wave", wave),
        ("saddle", saddle),
        ("paraboloid", planar_paraboloid(24, 12)),
    ]
}

fn optimised(mesh: &HexMesh) -> AngleOptimised {
    satisfy_angle_condition(mesh, None, &AngleOptions::default(), &Silent).unwrap()
}

/// Everything that a vertex-distance offset promises, at a distance.
fn check_offset(name: &str, mesh: &HexMesh, spherical: &SphericalMesh, d: f64) {
    let gauss = spherical.image.mesh(mesh);
    for p in &gauss.positions {
        assert!((p.norm() - 1.0).abs() <= 1e-13, "{name}: off the sphere");
    }
    let moved = spherical.image.offset(mesh, d);
    for (p, q) in mesh.positions.iter().zip(&moved.positions) {
        let error = ((q - p).norm() - d.abs()).abs();
        assert!(error <= 1e-12, "{name}: a vertex misses {d} by {error:e}");
    }
    let (to_gauss, to_moved) = (parallelism(mesh, &gauss), parallelism(mesh, &moved));
    assert!(
        to_gauss <= 1e-10 && to_moved <= 1e-10,
        "{name}: {to_gauss:e}"
    );
    for face in FlatFace::all(&moved).iter() {
        assert!(face.planarity_length <= 1e-12 * moved.mean_edge(), "{name}");
    }
    let normals = face_offset::face_normals(mesh).unwrap();
    let side: f64 = mesh
        .topology()
        .faces()
        .map(|f| gauss.centre(f).dot(&normals[f]))
        .sum();
    assert!(side > 0.0, "{name}: the spherical mesh faces the normals");
}

#[test]
fn open_patches_of_every_curvature_have_vertex_offsets() {
    for (name, mesh) in patches() {
        let result = optimised(&mesh);
        let unit = result.quality.mean_edge;
        assert!(result.is_converged(), "{name}: {:?}", result.outcome.status);
        assert!(result.angle_defect[1] <= 1e-13, "{name}");
        assert!(
            result.deviation[1] <= 0.02 * unit,
            "{name}: {}",
            result.deviation[1] / unit
        );
        let options = ValidateOptions::default();
        assert_eq!(violations(&result.mesh, None, &options), [], "{name}");
        let spherical = vertex_gauss_image(&result.mesh, &OffsetOptions::default()).unwrap();
        assert!(spherical.holonomy.defect < 1e-12, "{name}");
        assert!(spherical.facing > 0.9, "{name}: {}", spherical.facing);
        assert_eq!(
            (spherical.holonomy.loops, spherical.holonomy.starts),
            (0, 3),
            "{name}"
        );
        for d in [0.1 * unit, -0.1 * unit] {
            check_offset(name, &result.mesh, &spherical, d);
            assert!(
                layer(&result.mesh, &spherical.image, d, &OffsetOptions::default()).is_ok(),
                "{name}"
            );
        }
    }
}

/// Round an odd number of edges reflections make a rotation and a reflection, unless the mesh is
/// made for it.
#[test]
fn a_loop_of_an_odd_number_of_edges_closes() {
    let n = 5u32;
    let ring = |radius: f64, z: f64| {
        (0..n).map(move |k| {
            let t = TAU * k as f64 / n as f64;
            let bump = 0.08 * (2.0 * t + 3.0 * z).sin();
            Vec3::new(radius * t.cos(), radius * t.sin() + bump, z + 1.5 * bump)
        })
    };
    let faces: Vec<[u32; 4]> = (0..n)
        .map(|k| [k, (k + 1) % n, n + (k + 1) % n, n + k])
        .collect();
    let frustum = HexMesh::new(ring(1.0, 0.0).chain(ring(0.7, 0.8)).collect(), &faces).unwrap();
    let result = optimised(&frustum);
    assert!(
        result.closing_defect[0] > 1e-3,
        "it closes before: {:?}",
        result.closing_defect
    );
    assert!(result.is_converged() && result.closing_defect[1] < 1e-12);
    let spherical = vertex_gauss_image(&result.mesh, &OffsetOptions::default()).unwrap();
    assert_eq!(spherical.holonomy.loops, 1);
    check_offset("odd ring", &result.mesh, &spherical, 0.1);
}

/// An exactly planar mesh that satisfies the condition is not touched.
#[test]
fn what_is_right_stays_as_it_is() {
    let mesh = planar_paraboloid(16, 8);
    let result = optimised(&mesh);
    assert!(result.is_converged() && result.mesh == mesh);
    assert_eq!(result.outcome.iterations, 0);
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let mesh = torus_patch([0.7, 2.4], 0.0);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| optimised(&mesh).mesh)
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn the_vertex_offset_has_the_same_gauss_image() {
    let mesh = planar_paraboloid(16, 8);
    let options = OffsetOptions::default();
    let before = vertex_gauss_image(&mesh, &options).unwrap();
    let moved = before.image.offset(&mesh, 0.05);
    let after = vertex_gauss_image(&moved, &options).unwrap();
    // The start is free on a disc, but the mesh it is chosen for has the same normals.
    let error = distance(&before.image.mesh(&mesh), &after.image.mesh(&mesh));
    assert!(error < 1e-11, "{error:e}");
    let back = after.image.offset(&moved, -0.05);
    assert!(distance(&mesh, &back) < 1e-12);
}

fn one_face(corners: &[[f64; 2]]) -> HexMesh {
    let points: Vec<[f64; 3]> = corners.iter().map(|&[x, y]| [x, y, 0.0]).collect();
    let face: Vec<u32> = (0..points.len() as u32).collect();
    mesh(&points, &[&face])
}

fn on_circle(degrees: &[f64]) -> Vec<[f64; 2]> {
    let point = |t: &f64| [t.to_radians().cos(), t.to_radians().sin()];
    degrees.iter().map(point).collect()
}

/// Moves the edges of a polygon along themselves: the parallel polygon with other edge lengths.
fn sheared(corners: &[[f64; 2]], i: usize, by: f64) -> Vec<[f64; 2]> {
    // Moving edge i parallel to itself slides its ends along the neighbouring edges.
    let n = corners.len();
    let mut moved = corners.to_vec();
    let (a, b) = (i, (i + 1) % n);
    let (before, after) = ((i + n - 1) % n, (i + 2) % n);
    let unit = |p: [f64; 2], q: [f64; 2]| {
        let d = [q[0] - p[0], q[1] - p[1]];
        let edge = [corners[b][0] - corners[a][0], corners[b][1] - corners[a][1]];
        let height = (edge[0] * d[1] - edge[1] * d[0]) / edge[0].hypot(edge[1]);
        [d[0] / height, d[1] / height]
    };
    let (s, t) = (
        unit(corners[a], corners[before]),
        unit(corners[b], corners[after]),
    );
    for k in 0..2 {
        moved[a][k] += by * s[k];
        moved[b][k] += by * t[k];
    }
    moved
}

/// Inscribed hexagons, and what is parallel to them, satisfy the condition; the branch tells how
/// they are wound.
#[test]
fn the_condition_holds_for_what_is_parallel_to_inscribed_polygons() {
    let defect = |corners: &[[f64; 2]]| AngleCondition::of(&one_face(corners), FaceId::new(0));
    let hexagon = on_circle(&[0.0, 50.0, 130.0, 170.0, 250.0, 300.0]);
    let square = on_circle(&[0.0, 70.0, 200.0, 300.0]);
    let octagon = on_circle(&[0.0, 30.0, 80.0, 130.0, 200.0, 230.0, 290.0, 330.0]);
    for inscribed in [&hexagon, &square, &octagon] {
        for corners in [inscribed.clone(), sheared(inscribed, 1, 0.1)] {
            let condition = defect(&corners).unwrap();
            assert!(condition.defect.abs() < 1e-14, "{condition:?}");
            assert_eq!(condition.branch, condition.paper_branch);
        }
    }
    // Centrally symmetric and concave: the paper's branch too.
    let waist = [
        [2.0, -1.0],
        [1.0, 0.2],
        [2.0, 1.0],
        [-2.0, 1.0],
        [-1.0, -0.2],
        [-2.0, -1.0],
    ];
    let condition = defect(&waist).unwrap();
    assert!(condition.defect.abs() < 1e-14 && condition.branch == 2);
    // Parallel to an inscribed hexagon that crosses itself: another branch.
    let mut bent = hexagon.clone();
    bent[3] = [0.1, 0.3];
    let off = defect(&bent).unwrap();
    assert!(off.defect.abs() > 1e-2);
    assert!(
        defect(&on_circle(&[0.0, 60.0, 130.0, 200.0, 290.0])).is_none(),
        "odd"
    );
}

/// The condition on another branch than the paper's still gives an inscribed parallel polygon.
#[test]
fn other_branches_close_as_well() {
    // Sum of every other angle is pi: two of them are small, the third is 100 degrees.
    let mut corners = vec![[0.0, 0.0]];
    let interior = [40.0f64, 200.0, 40.0, 220.0, 100.0, 120.0];
    let mut heading = 0.0f64;
    // The last two lengths close the polygon.
    let mut directions = Vec::new();
    for angle in &interior {
        directions.push([heading.cos(), heading.sin()]);
        heading += PI - angle.to_radians();
    }
    let lengths = closing_lengths(&directions, &[2.0, 1.0, 2.0, 1.0]);
    for (d, l) in directions.iter().zip(&lengths).take(5) {
        let last = corners[corners.len() - 1];
        corners.push([last[0] + d[0] * l, last[1] + d[1] * l]);
    }
    let face = one_face(&corners);
    let sums = AngleCondition::of(&face, FaceId::new(0)).unwrap();
    assert!(sums.defect.abs() < 1e-13, "{sums:?}");
    let spherical = spherical_mesh(&face).unwrap();
    assert!(spherical.holonomy.defect < 1e-13);
    assert!(parallelism(&face, &spherical.image.mesh(&face)) < 1e-10);
}

/// Lengths of all edges with given directions, the first ones given, that close.
fn closing_lengths(directions: &[[f64; 2]], first: &[f64]) -> Vec<f64> {
    let n = first.len();
    let gap = |k: usize| -> f64 { -(0..n).map(|i| first[i] * directions[i][k]).sum::<f64>() };
    let (p, q) = (directions[n], directions[n + 1]);
    let det = p[0] * q[1] - p[1] * q[0];
    let (x, y) = (gap(0), gap(1));
    let last = [(x * q[1] - y * q[0]) / det, (p[0] * y - p[1] * x) / det];
    first.iter().copied().chain(last).collect()
}

#[test]
fn a_mesh_without_the_condition_is_refused_with_the_face() {
    let mesh = patch(9, 4, 0.1, |s, t| Vec3::new(s, t, 0.0));
    let mut bent = mesh.clone();
    let inner = bent
        .topology()
        .vertices()
        .find(|&v| !bent.topology().is_boundary_vertex(v))
        .unwrap();
    bent.positions[inner].x += 0.02;
    let options = OffsetOptions::default();
    assert!(vertex_gauss_image(&mesh, &options).is_ok());
    let refused = vertex_gauss_image(&bent, &options).unwrap_err();
    let OffsetError::AngleCondition {
        face,
        defect,
        count,
    } = refused
    else {
        panic!("{refused}");
    };
    assert!(bent.topology().face_vertices(face).contains(&inner));
    assert!(defect.abs() > 1e-3 && (1..=3).contains(&count));
}

/// Round an annulus the reflections amount to a rotation, and only its axis closes: it is made to
/// face the normals.
#[test]
fn an_annulus_closes_from_one_start() {
    let columns = 24;
    let faces = annulus_faces(columns, 4);
    let place = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        let (u, v) = (TAU * i as f64 / columns as f64, -0.5 + 0.25 * j as f64);
        // Not round, so that no symmetry closes it.
        let r = v.cosh() * (1.0 + 0.15 * (2.0 * u).cos());
        Vec3::new(r * u.cos(), r * u.sin(), v + 0.05 * (u + 0.3).sin())
    };
    let points = (0..5 * columns).map(place).collect();
    let result = optimised(&HexMesh::new(points, &faces).unwrap());
    let spherical = closed(&result);
    assert_eq!(spherical.holonomy.loops, 1);
    check_offset("annulus", &result.mesh, &spherical, 0.1);
}

/// The rotations round two holes have two axes; what fails to close is measured, located and
/// refused, until one axis is made of both.
#[test]
fn two_holes_have_a_holonomy() {
    let (_, whole) = patches().swap_remove(3);
    let faces = whole.topology().face_lists();
    let kept = faces
        .into_iter()
        .enumerate()
        .filter(|(f, _)| ![40, 64].contains(f));
    let faces: Vec<Vec<u32>> = kept.map(|(_, face)| face).collect();
    let holed = HexMesh::new(whole.positions.as_slice().to_vec(), &faces).unwrap();
    let holonomy = spherical_mesh(&holed).unwrap().holonomy;
    assert_eq!((holonomy.loops, holonomy.odd_faces), (2, 0));
    assert!(
        holonomy.defect > 1e-6 && holonomy.defect < 0.5,
        "{holonomy:?}"
    );
    let mut loose = OffsetOptions {
        angle: 1.0,
        ..OffsetOptions::default()
    };
    loose.validity.planarity = Some(1.0);
    let refused = vertex_gauss_image(&holed, &loose).unwrap_err();
    let OffsetError::Holonomy {
        defect,
        loops: 2,
        odd_faces: 0,
        ..
    } = refused
    else {
        panic!("{refused}");
    };
    assert_eq!(defect, holonomy.defect);
    let result = optimised(&holed);
    check_offset("two holes", &result.mesh, &closed(&result), 0.1);
}

/// The spherical mesh of a result, which must close and face the normals.
fn closed(result: &AngleOptimised) -> SphericalMesh {
    assert!(result.is_converged(), "{:?}", result.outcome.status);
    assert!(result.offenders.is_empty() && result.closing_defect[1] < 1e-12);
    let spherical = vertex_gauss_image(&result.mesh, &OffsetOptions::default()).unwrap();
    assert!(spherical.holonomy.defect < 1e-12);
    assert!(spherical.facing > 0.9, "{}", spherical.facing);
    spherical
}

/// Each odd face inside allows only a circle of starts; the mesh is moved until all of them meet,
/// on a closed mesh too.
#[test]
fn odd_faces_inside_are_made_to_close() {
    let sphere = polar_dual(&spread_points(60));
    let before = spherical_mesh(&sphere).unwrap().holonomy;
    assert!(before.odd_faces >= 12 && before.defect > 1e-3, "{before:?}");
    let egg = mapped(&sphere, |p| Vec3::new(1.5 * p.x, p.y, 0.8 * p.z));
    for (name, mesh) in [("sphere", sphere), ("egg", egg)] {
        let result = optimised(&mesh);
        assert!(result.closing_defect[0] > 1e-6, "{name}");
        let spherical = closed(&result);
        check_offset(name, &result.mesh, &spherical, 0.05);
        check_offset(name, &result.mesh, &spherical, -0.05);
        assert!(
            result.deviation[1] < 0.4 * result.quality.mean_edge,
            "{name}"
        );
    }
}

fn annulus_faces(columns: usize, rows: usize) -> Vec<Vec<u32>> {
    let at = |i: usize, j: usize| (j * columns + i % columns) as u32;
    let brick = |(i, j): (usize, usize)| {
        let lower = [at(i, j), at(i + 1, j), at(i + 2, j)];
        [lower, [at(i + 2, j + 1), at(i + 1, j + 1), at(i, j + 1)]].concat()
    };
    let starts = (0..rows).flat_map(|j| (0..columns).step_by(2).map(move |i| (i + j % 2, j)));
    starts.map(brick).collect()
}

/// Inscribed solids close although nothing is free to choose: odd faces allow only the solid
/// itself.
#[test]
fn a_dodecahedron_is_its_own_spherical_mesh() {
    let mesh = dodecahedron();
    let spherical = vertex_gauss_image(&mesh, &OffsetOptions::default()).unwrap();
    assert_eq!(
        (spherical.holonomy.loops, spherical.holonomy.odd_faces),
        (0, 12)
    );
    assert!(spherical.holonomy.starts < 3);
    let radius = mesh.position(VertexId::new(0)).norm();
    let same = mapped(&mesh, |p| p / radius);
    assert!(distance(&same, &spherical.image.mesh(&mesh)) < 1e-12);
}

#[test]
fn two_components_are_refused() {
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let far = square.map(|[x, y, z]| [x + 3.0, y, z]);
    let mesh = mesh(&[square, far].concat(), &[&[0, 1, 2, 3], &[4, 5, 6, 7]]);
    let refused = spherical_mesh(&mesh).unwrap_err();
    assert_eq!(refused, OffsetError::Components { components: 2 });
}

/// An odd panel at the rim leaves one of its rim edges free, and everything else parallel.
#[test]
fn odd_faces_at_the_rim_leave_an_edge_free() {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
        [2.2, 0.1, 0.0],
        [2.6, 0.6, 0.0],
        [2.0, 1.2, 0.0],
    ];
    let mesh = mesh(&points, &[&[0, 1, 2, 3], &[1, 4, 5, 6, 2]]);
    let spherical = spherical_mesh(&mesh).unwrap();
    assert_eq!(spherical.free_edges.len(), 1);
    let moved = spherical.image.offset(&mesh, 0.1);
    let topology = mesh.topology();
    for e in topology
        .edges()
        .filter(|e| !spherical.free_edges.contains(e))
    {
        let [a, b] = topology.edge_vertices(e);
        let (p, q) = (
            mesh.position(b) - mesh.position(a),
            moved.position(b) - moved.position(a),
        );
        assert!(p.cross(&q).norm() < 1e-13, "{e}");
    }
    let face = FlatFace::of(&moved, FaceId::new(1));
    assert!(face.planarity_length < 1e-14);
}
