//! Meshes whose edges run against those of their Gauss image.

use crate::koebe::{KoebeOptions, koebe};
use crate::offset::signs::{length_ratio, seen_all_round, waists_of};
use crate::offset::*;
use crate::progress::Silent;
use crate::test_meshes::hexagon_patch;
use nalgebra::{DMatrix, Matrix3};
use phex_mesh::polygon::is_simple;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{EdgeId, FaceId, FlatFace, HexMesh, PerEdge, TriangleSurface, Vec2, Vec3, measure};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_3;

fn koebe_patch(rings: i64, opening: f64) -> HexMesh {
    let options = KoebeOptions {
        opening,
        ..KoebeOptions::default()
    };
    koebe(&hexagon_patch(rings), &options, &Silent)
        .unwrap()
        .mesh
}

/// The edges that are parallel to the x axis in the plane.
fn family(rings: i64) -> Vec<EdgeId> {
    let flat = hexagon_patch(rings);
    let t = flat.topology();
    let level = |e: &EdgeId| {
        let [a, b] = t.edge_vertices(*e);
        (flat.position(b) - flat.position(a)).y.abs() < 1e-9
    };
    t.edges().filter(level).collect()
}

/// The mesh whose edges are nearest to 1 and (those of a family) -2 times those of a Koebe mesh.
fn saddle(rings: i64) -> (HexMesh, HexMesh) {
    let image = koebe_patch(rings, 50.0);
    let space = ParallelSpace::new(&image).unwrap();
    let mut wish = space.lengths(&image);
    for e in family(rings) {
        wish[e] *= -2.0;
    }
    (space.mesh_with_lengths(&wish), image)
}

fn saddle_surface() -> TriangleSurface {
    let shape = Shape::from_name("hyperbolic-paraboloid", &[]).unwrap();
    let options = TriangulationOptions {
        triangles: 8000,
        ..Default::default()
    };
    triangulate(&shape, &options).unwrap()
}

/// Distance and direction of each pair of corresponding edges, from coordinates alone.
fn worst_of_edges(mesh: &HexMesh, moved: &HexMesh, distance: f64) -> f64 {
    let t = mesh.topology();
    let mut worst: f64 = 0.0;
    for e in t.edges() {
        let [a, b] = t.edge_vertices(e);
        let [u, w] = [mesh, moved].map(|m| (m.position(b) - m.position(a)).normalize());
        let off = moved.position(a) - mesh.position(a);
        let away = (off - u * off.dot(&u)).norm();
        worst = worst
            .max((away - distance.abs()).abs())
            .max(u.cross(&w).norm());
    }
    worst
}

#[test]
fn a_reversed_family_makes_a_saddle_with_offsets_on_both_sides() {
    let (mesh, image) = saddle(5);
    let measures = measure(&mesh);
    let faces = mesh.topology().n_faces();
    assert_eq!(
        (measures.faces_not_simple, measures.faces_concave),
        (0, faces)
    );
    assert!(measures.clearance.min > 0.3, "{}", measures.clearance.min);
    for distance in [0.05, 0.02, -0.02, -0.05] {
        let moved = edge_offset(&mesh, &image, distance);
        assert!(worst_of_edges(&mesh, &moved, distance) < 1e-12);
    }
}

#[test]
fn the_koebe_mesh_of_a_saddle_is_recognised() {
    for rings in [1, 4] {
        let (mesh, image) = saddle(rings);
        // Faces look to the other side than those of the image.
        for mesh in [mesh.turned_over(), mesh] {
            let found = edge_gauss_image(&mesh, &OffsetOptions::default()).unwrap();
            assert!(
                found.defect < 1e-10 && found.facing > 0.8,
                "{rings}: {}",
                found.facing
            );
            for distance in [0.03, -0.03] {
                let moved = found.image.offset(&mesh, distance);
                assert!(worst_of_edges(&mesh, &moved, distance) < 1e-11, "{rings}");
            }
            let same = |sign: f64| {
                let pairs = found.image.positions.iter().zip(&image.positions);
                pairs
                    .map(|(a, b)| (a - b * sign).norm())
                    .fold(0.0, f64::max)
            };
            assert!(same(1.0).min(same(-1.0)) < 1e-9, "{rings}");
        }
    }
}

#[test]
fn a_concave_face_alone_has_an_image() {
    let mesh = as_mesh(&hexagon([-2.0, 1.0, 1.0]));
    let found = edge_gauss_image(&mesh, &OffsetOptions::default()).unwrap();
    assert!(found.defect < 1e-12 && found.facing > 0.0);
    let moved = found.image.offset(&mesh, 0.1);
    assert!(worst_of_edges(&mesh, &moved, 0.1) < 1e-12);
}

#[test]
fn layers_solids_and_beams_of_a_saddle() {
    let options = OffsetOptions::default();
    let mesh = saddle(4).0.turned_over();
    let found = edge_gauss_image(&mesh, &options).unwrap();
    let thickness = 0.2 * mesh.mean_edge();
    let [lower, upper] =
        [-0.5, 0.5].map(|s| layer(&mesh, &found.image, s * thickness, &options).unwrap());
    let beams = beam_axes(&lower, &upper).unwrap();
    assert!(
        beams.iter().all(|b| b.torsion < 1e-10),
        "beams without torsion"
    );
    let solids = panel_solids(&lower, &upper, 0.0).unwrap();
    assert_eq!(solids.len(), mesh.topology().n_faces());
    // Face and vertex offsets do not ask for signs.
    let faces = face_gauss_image(&mesh, &options).unwrap();
    let moved = layer(&mesh, &faces, thickness, &options).unwrap();
    assert!(distance_error(&mesh, &moved, OffsetKind::Face, thickness).unwrap() < 1e-12);
    assert_eq!(angle_conditions(&mesh).len(), mesh.topology().n_faces());
}

#[test]
fn the_space_of_a_saddle_is_that_of_its_koebe_mesh() {
    let (mesh, image) = saddle(2);
    let t = image.topology();
    let directions = ParallelSpace::new(&image).unwrap();
    let mut closure = DMatrix::zeros(3 * t.n_faces(), t.n_edges());
    for h in t.half_edges() {
        let forward = t.edge_vertices(t.edge(h))[0] == t.origin(h);
        let along = directions.direction(t.edge(h)) * if forward { 1.0 } else { -1.0 };
        for k in 0..3 {
            closure[(3 * t.face(h).index() + k, t.edge(h).index())] = along[k];
        }
    }
    let rank = closure
        .singular_values()
        .iter()
        .filter(|s| **s > 1e-9)
        .count();
    let dimension = t.n_edges() - rank;
    assert_eq!(directions.dimension(), dimension);
    let space = ParallelSpace::new(&mesh).unwrap();
    assert_eq!(
        (space.dimension(), space.basis().len()),
        (dimension, dimension)
    );
}

#[test]
fn a_signed_fit_comes_close_to_a_saddle() {
    let image = saddle_image();
    let surface = saddle_surface();
    for signs in [
        EdgeSigns::SignRule,
        EdgeSigns::Reversed(ruled_edges(&image, &surface)),
    ] {
        let options = FitOptions {
            signs,
            ..FitOptions::default()
        };
        let fitted = fit_parallel(&image, &surface, &options, &Silent).unwrap();
        assert!(fitted.crossed_faces.is_empty() && !fitted.reversed_edges.is_empty());
        let rms = fitted.rms_distance / surface.diagonal();
        assert!(rms < 1e-3, "{rms}");
        let measures = measure(&fitted.mesh);
        assert_eq!(measures.faces_concave, image.topology().n_faces());
        for distance in [0.04, -0.04] {
            let moved = edge_offset(&fitted.mesh, &image, distance);
            assert!(worst_of_edges(&fitted.mesh, &moved, distance) < 1e-12);
        }
    }
}

#[test]
fn a_minimal_saddle_has_mean_curvature_zero() {
    let (image, surface) = (saddle_image(), saddle_surface());
    let options = FitOptions {
        signs: EdgeSigns::SignRule,
        minimal: true,
        ..FitOptions::default()
    };
    let fitted = fit_parallel(&image, &surface, &options, &Silent).unwrap();
    let sphere = 2.0 * 3f64.sqrt() / surface.diagonal();
    for c in face_curvatures(&fitted.mesh, &image).iter() {
        assert!(c.mean.abs() < 1e-3 * sphere && c.gauss < 0.0, "{c:?}");
    }
}

#[test]
fn signs_without_simple_panels_are_refused_by_face() {
    let (image, surface) = (saddle_image(), saddle_surface());
    let refused = |edges: Vec<EdgeId>| {
        let signs = EdgeSigns::Reversed(edges);
        let options = FitOptions {
            signs,
            ..FitOptions::default()
        };
        fit_parallel(&image, &surface, &options, &Silent).unwrap_err()
    };
    let error = refused(vec![EdgeId::new(3)]);
    assert!(
        matches!(
            error,
            FitError::Signs(SignError::Turning { reversed: 1, .. })
        ),
        "{error}"
    );
    let error = refused(vec![EdgeId::new(99_999)]);
    assert!(
        matches!(error, FitError::Signs(SignError::NoSuchEdge { .. })),
        "{error}"
    );
    let flat = Shape::from_name("plane", &[]).unwrap();
    let flat = triangulate(&flat, &TriangulationOptions::default()).unwrap();
    let options = FitOptions {
        signs: EdgeSigns::SignRule,
        ..FitOptions::default()
    };
    let error = fit_parallel(&image, &flat, &options, &Silent).unwrap_err();
    assert!(
        matches!(error, FitError::Signs(SignError::Flat { .. })),
        "{error}"
    );
}

/// A Koebe patch that faces upwards, a family of edges along the saddle's axis.
fn saddle_image() -> HexMesh {
    koebe_patch(4, 30.0)
}

fn ruled_edges(image: &HexMesh, surface: &TriangleSurface) -> Vec<EdgeId> {
    let options = FitOptions {
        signs: EdgeSigns::SignRule,
        ..FitOptions::default()
    };
    fit_parallel(image, surface, &options, &Silent)
        .unwrap()
        .reversed_edges
}

/// A hexagon with edges of 0, 60 and 120 degrees of some signed lengths.
fn hexagon(lengths: [f64; 3]) -> Vec<Vec2> {
    let mut at = Vec2::zeros();
    let step = |k: usize| {
        let angle = FRAC_PI_3 * k as f64;
        at += Vec2::new(angle.cos(), angle.sin()) * lengths[k % 3];
        at
    };
    (0..6).map(step).collect()
}

fn as_mesh(polygon: &[Vec2]) -> HexMesh {
    let lifted = polygon.iter().map(|p| Vec3::new(p.x, p.y, 1.0)).collect();
    HexMesh::new(lifted, &[[0u32, 1, 2, 3, 4, 5]]).unwrap()
}

/// The least of the four distances that keep the waist open; infinite for a convex panel.
fn waist(lengths: [f64; 3]) -> f64 {
    let space = ParallelSpace::new(&as_mesh(&hexagon([1.0; 3]))).unwrap();
    let mesh = as_mesh(&hexagon(lengths));
    let signed = space.lengths(&mesh);
    let waists = waists_of(&space, FaceId::new(0), &signed).unwrap();
    let open = waists
        .iter()
        .map(|w| w.inward.dot(&(mesh.position(w.to) - mesh.position(w.from))));
    open.fold(f64::INFINITY, f64::min)
}

proptest! {
    /// Nothing else than an open waist makes a hexagon simple whose two families that keep their
    /// direction are of one length.
    #[test]
    fn a_hexagon_is_simple_exactly_when_its_waist_is_open(b in 0.05f64..4.0, a in 0.05f64..4.0) {
        prop_assume!((b / a - 1.0).abs() > 1e-6);
        let lengths = [-b, a, a];
        prop_assert_eq!(is_simple(&hexagon(lengths)), waist(lengths) > 0.0);
        prop_assert_eq!(waist(lengths) > 0.0, b > a);
    }

    /// With three lengths an open waist is enough.
    #[test]
    fn an_open_waist_makes_a_hexagon_simple(
        b in 0.05f64..4.0, a in 0.05f64..4.0, c in 0.05f64..4.0
    ) {
        let lengths = [-b, a, c];
        if waist(lengths) > 1e-9 {
            prop_assert!(is_simple(&hexagon(lengths)));
        }
        // And the sign rule of a lattice: the three sums of two lengths not all of one sign.
        prop_assume!((b - a.min(c)).abs() > 1e-9);
        prop_assert_eq!(is_simple(&hexagon(lengths)), b > a.min(c));
    }

    /// Planes that touch a quadric in a small lattice, regular on the Gauss sphere, meet as the
    /// sign rule says.
    #[test]
    fn signs_are_those_of_tangent_planes(
        k1 in 0.2f64..2.0, k2 in 0.2f64..2.0, saddle in any::<bool>(), turn in 0.0f64..6.3
    ) {
        let k2 = if saddle { -k2 } else { k2 };
        let step = 1e-4;
        // Normal (p, q, 1) at (p / k1, q / k2): the plane there, through the apex it is seen from.
        let at = |k: usize| {
            let angle = turn + FRAC_PI_3 * k as f64;
            Vec2::new(angle.cos(), angle.sin()) * step
        };
        // The surface is z = -(k1 x^2 + k2 y^2) / 2: n . x = h with h = (p^2 / k1 + q^2 / k2) / 2.
        let plane = |n: Vec2| (Vec3::new(n.x, n.y, 1.0), 0.5 * (n.x * n.x / k1 + n.y * n.y / k2));
        let corner = |k: usize| {
            let planes = [plane(Vec2::zeros()), plane(at(k)), plane(at(k + 1))];
            let rows = planes.map(|p| p.0.transpose());
            let heights = Vec3::new(planes[0].1, planes[1].1, planes[2].1);
            Matrix3::from_rows(&rows).lu().solve(&heights).unwrap()
        };
        let second = Matrix3::from_diagonal(&Vec3::new(k1, k2, 0.0));
        for k in 0..6 {
            // The edge between the panel in the middle and the one at `k`, and its image.
            let along = Vec3::new(-at(k).y, at(k).x, 0.0) / step;
            let length = (corner(k) - corner(k + 5)).dot(&along);
            let image = step / 3f64.sqrt();
            let ratio = length_ratio(&second, &Vec3::z(), &along);
            let short = 0.1 / (k1 * k2).abs().sqrt();
            if !saddle && length / image < short {
                prop_assert!((ratio - short).abs() < 1e-9, "convex panels only");
                continue;
            }
            prop_assert!((length / image - ratio).abs() < 1e-5 * (1.0 / k1 + 1.0 / k2.abs()));
        }
    }
}

/// Lengths of a Koebe mesh with one family reversed, and what is left of them.
#[test]
fn lengths_tell_which_edges_run_against_their_image() {
    let (mesh, image) = saddle(3);
    let lengths: PerEdge<f64> = ParallelSpace::new(&image).unwrap().lengths(&mesh);
    let reversed: Vec<EdgeId> = image
        .topology()
        .edges()
        .filter(|e| lengths[*e] < 0.0)
        .collect();
    assert_eq!(reversed, family(3));
    let flat = FlatFace::all(&mesh);
    assert!(flat.iter().all(|f| is_simple(&f.polygon)));
}

/// At the rim of a sphere of uneven triangles estimates of curvature had the wrong sign, and a part
/// of a sphere was refused as one whose curvature changes its sign.
#[test]
fn curvature_is_taken_a_panel_inside_where_there_is_an_inside() {
    let triangulation = TriangulationOptions {
        triangles: 1000,
        ..Default::default()
    };
    let shape = |name| triangulate(&Shape::from_name(name, &[]).unwrap(), &triangulation).unwrap();
    let dome = shape("elliptic-paraboloid");
    let boundary = phex_mesh::BoundaryCurve::of(&dome).unwrap();
    let size = 0.2 * dome.area().sqrt();
    let inside = seen_all_round(&dome, size);
    let far = |v| !boundary.is_within(dome.positions()[v], size);
    assert!(!inside.is_empty() && inside.iter().all(|v| far(*v)));
    assert_eq!(
        inside.len(),
        dome.topology().vertices().filter(|v| far(*v)).count()
    );
    let all = dome.topology().n_vertices();
    assert_eq!(seen_all_round(&dome, 9.0 * dome.diagonal()).len(), all);
    let ball = shape("sphere");
    assert_eq!(
        seen_all_round(&ball, size).len(),
        ball.topology().n_vertices()
    );
}
