//! Each kind of damage is found, at its place, and nothing else is.
use crate::common::*;
use nalgebra::Rotation3;
use phex_mesh::validate::{FlipReference, planarity_floor};
use phex_mesh::{
    FaceId, HexMesh, TopologyError, TriangleSurface, ValidateOptions, Vec3, VertexId, Violation,
    add_flips, validate, violations,
};
use proptest::prelude::*;

fn check(mesh: &HexMesh) -> Vec<Violation> {
    violations(mesh, None, &ValidateOptions::default())
}

fn of_kind<'a>(found: &'a [Violation], kind: &str) -> Vec<&'a Violation> {
    found.iter().filter(|v| v.kind() == kind).collect()
}

fn faces_of(mesh: &HexMesh, found: &[Violation], kind: &str) -> Vec<FaceId> {
    let mut faces: Vec<FaceId> = of_kind(found, kind)
        .iter()
        .flat_map(|v| v.faces(mesh.topology()))
        .collect();
    faces.sort();
    faces
}

#[test]
fn planar_meshes_are_valid() {
    for mesh in [honeycomb(5, 4), dodecahedron(), truncated_icosahedron()] {
        assert_eq!(check(&mesh), []);
        let valid = validate(mesh.clone(), None, &ValidateOptions::default()).unwrap();
        assert_eq!(valid.mean_edge(), mesh.mean_edge());
        assert_eq!(valid.into_inner(), mesh);
    }
}

#[test]
fn corners_of_180_degrees_are_valid_in_any_position() {
    // An edge starts on the border of a third face up to rounding: no crossing. Which triangles
    // that face is clipped into depends on rounding and on where its list starts.
    for (start, k) in (0..6).flat_map(|start| (0..20).map(move |k| (start, k))) {
        let rotation = Rotation3::new(Vec3::new(0.1, 0.37, -0.23) * f64::from(k));
        let prism = mapped(&brick_prism(7, 5, start), |p| rotation * p * 3.7);
        assert_eq!(check(&prism), [], "{start} {k}");
    }
}

#[test]
fn raised_vertex_is_located() {
    let flat = honeycomb(4, 4);
    let v = flat.topology().face_vertices(cell(4, 1, 1))[0];
    let mesh = moved(&flat, v, Vec3::z() * 1e-6);
    let found = check(&mesh);
    assert!(found.iter().all(|v| v.kind() == "not_planar"));
    let mut around: Vec<FaceId> = flat.topology().faces_at(v).collect();
    around.sort();
    assert_eq!(faces_of(&mesh, &found, "not_planar"), around);
    for violation in &found {
        let Violation::NotPlanar { planarity, .. } = violation else {
            unreachable!()
        };
        assert!(
            (planarity - 0.5e-6).abs() < 1e-12,
            "half of the height, to first order"
        );
    }
    let loose = ValidateOptions {
        planarity: Some(0.6e-6),
        ..Default::default()
    };
    assert_eq!(violations(&mesh, None, &loose), []);
}

#[test]
fn invalid_mesh_comes_back_with_its_violations() {
    let mesh = moved(&honeycomb(4, 4), VertexId::new(0), Vec3::z());
    let invalid = validate(mesh.clone(), None, &ValidateOptions::default()).unwrap_err();
    assert_eq!(*invalid.mesh, mesh);
    assert_eq!(invalid.violations, check(&mesh));
    assert!(
        invalid
            .to_string()
            .starts_with("the mesh is not planar: face 0 is not planar"),
        "{invalid}"
    );
}

#[test]
fn what_is_outside_a_tolerance_is_valid() {
    let flat = honeycomb(4, 4);
    let tight = ValidateOptions {
        edge_length_rel: 1.5,
        clearance: 1.5,
        ..Default::default()
    };
    let found = violations(&flat, None, &tight);
    assert!(found.iter().any(|v| v.kind() == "small_clearance"));
    assert!(found.iter().any(|v| v.kind() == "collapsed_edge"));
    assert!(found.iter().all(|v| !v.is_decisive()));
    assert!(validate(flat.clone(), None, &tight).is_ok());
    let corners = flat.topology().face_vertices(cell(4, 1, 1));
    let (a, b) = (corners[2], corners[3]);
    let mut swapped = positions(&flat);
    (swapped[a], swapped[b]) = (flat.position(b), flat.position(a));
    let refused = validate(flat.with_positions(swapped), None, &tight).unwrap_err();
    assert!(refused.violations[0].is_decisive(), "{refused}");
    assert!(!refused.violations.last().unwrap().is_decisive());
    assert!(refused.to_string().starts_with("the mesh is not valid: "));
}

#[test]
fn swapped_corners_cross_in_the_two_faces_of_their_edge() {
    let flat = honeycomb(4, 4);
    let corners = flat.topology().face_vertices(cell(4, 1, 1));
    let (a, b) = (corners[2], corners[3]);
    let mut swapped = positions(&flat);
    (swapped[a], swapped[b]) = (flat.position(b), flat.position(a));
    let mesh = flat.with_positions(swapped);
    let found = check(&mesh);
    let expected: Vec<FaceId> = flat
        .topology()
        .faces()
        .filter(|&f| {
            let v = flat.topology().face_vertices(f);
            v.contains(&a) && v.contains(&b)
        })
        .collect();
    assert_eq!(expected.len(), 2);
    assert_eq!(faces_of(&mesh, &found, "not_simple"), expected);
    assert!(found.contains(&Violation::NotSimple {
        face: cell(4, 1, 1)
    }));
}

#[test]
fn face_wound_the_other_way_cannot_be_built() {
    let mesh = honeycomb(3, 3);
    let mut faces = mesh.topology().face_lists();
    faces[4].reverse();
    let error = HexMesh::new(mesh.positions.as_slice().to_vec(), &faces).unwrap_err();
    assert!(matches!(
        error,
        TopologyError::InconsistentOrientation { .. }
    ));
}

#[test]
fn short_edge_and_narrow_clearance_are_located() {
    let flat = honeycomb(4, 4);
    let corners = flat.topology().face_vertices(cell(4, 1, 1));
    let (a, b) = (corners[0], corners[1]);
    let mesh = moved(&flat, a, (flat.position(b) - flat.position(a)) * 0.98);
    let found = check(&mesh);
    let short = of_kind(&found, "collapsed_edge");
    assert_eq!(short.len(), 1);
    let &&Violation::CollapsedEdge {
        vertices,
        length_rel,
        limit,
        ..
    } = &short[0]
    else {
        unreachable!()
    };
    assert!(vertices.contains(&a) && vertices.contains(&b) && limit == 0.05);
    assert!((length_rel * mesh.mean_edge() - 0.02).abs() < 1e-12);
    assert!(!of_kind(&found, "small_clearance").is_empty());
    assert!(of_kind(&found, "not_simple").is_empty());
}

#[test]
fn clearance_names_face_vertex_and_edge() {
    let notch = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 0.1], [0.0, 4.0]];
    let mesh = single(&notch.map(|[x, y]| [x, y, 0.0]));
    let found = check(&mesh);
    let [
        Violation::SmallClearance {
            face,
            vertex,
            edge,
            clearance,
            ..
        },
    ] = found[..]
    else {
        panic!("{found:?}")
    };
    assert_eq!((face.index(), vertex.index(), edge.index()), (0, 3, 0));
    assert!((clearance * mesh.mean_edge() - 0.1).abs() < 1e-14);
}

#[test]
fn folded_corner_is_located() {
    let spike = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [4.0, 1.0], [0.0, 3.0]];
    let found = check(&single(&spike.map(|[x, y]| [x, y, 0.0])));
    let folded = of_kind(&found, "folded_corner");
    assert!(matches!(folded[..], [Violation::FoldedCorner { vertex, .. }] if vertex.index() == 2));
}

#[test]
fn folded_edge_is_located() {
    // Two squares with an angle of 45 degrees between them.
    let (s, points) = (
        0.5f64.sqrt(),
        [
            [0.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [-1.0, 1.0, 0.0],
            [-1.0, 0.0, 0.0],
        ],
    );
    let mut points: Vec<Vec3> = points.map(Vec3::from).to_vec();
    points.extend([Vec3::new(-s, 0.0, s), Vec3::new(-s, 1.0, s)]);
    let mesh = HexMesh::new(points, &[[0, 1, 2, 3], [1, 0, 4, 5]]).unwrap();
    let found = check(&mesh);
    let folds = of_kind(&found, "fold");
    let [Violation::Fold { edge, angle, .. }] = folds[..] else {
        panic!("{found:?}")
    };
    assert_eq!(
        mesh.topology().edge_vertices(*edge),
        [VertexId::new(0), VertexId::new(1)]
    );
    assert!((angle.to_degrees() - 135.0).abs() < 1e-12);
    assert!(
        found
            .iter()
            .any(|v| v.to_string().contains("differ by 135.0 degrees"))
    );
}

/// A cube has right angles, however it is turned.
#[test]
fn cubes_do_not_fold() {
    let faces = [
        [0u32, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    for k in 0..50 {
        let turn = nalgebra::Rotation3::from_euler_angles(0.1 * k as f64, 0.7, 0.3 * k as f64);
        let corner = |i: u32| turn * Vec3::from_fn(|axis, _| f64::from(i >> axis & 1) - 0.3);
        let cube = HexMesh::new((0..8).map(corner).collect(), &faces).unwrap();
        assert_eq!(check(&cube), [], "turn {k}");
    }
}

/// Three faces round the origin, each with a corner of `corner` degrees there, in the plane z = 0.
fn fan(corner: f64) -> HexMesh {
    let at = |degrees: f64, radius: f64| {
        let angle = degrees.to_radians();
        Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    };
    let mut points = vec![Vec3::zeros()];
    let mut faces = Vec::new();
    points.extend((0..3).map(|k| at(corner * f64::from(k), 1.0)));
    for k in 0..3u32 {
        let start = corner * f64::from(k);
        let first = points.len() as u32;
        points.extend([0.25, 0.5, 0.75].map(|t| at(start + t * corner, 2.0)));
        faces.push([0, 1 + k, first, first + 1, first + 2, 1 + (k + 1) % 3]);
    }
    HexMesh::new(points, &faces).unwrap()
}

#[test]
fn double_cover_at_a_vertex_is_located() {
    assert_eq!(check(&fan(120.0)), []);
    let found = check(&fan(240.0));
    let fans = of_kind(&found, "wrong_fan");
    let [Violation::WrongFan { vertex, turns, .. }] = fans[..] else {
        panic!("{found:?}")
    };
    assert!(*vertex == VertexId::new(0) && (turns - 2.0).abs() < 1e-12);
    assert!(fans[0].to_string().contains("2.00 times"));
    // Its faces lie over each other.
    assert_eq!(of_kind(&found, "crossing").len() + 1, found.len());
}

/// Two faces at a vertex of the boundary, at which each has the same angle, degrees.
fn pair(corner: f64) -> HexMesh {
    let at = |degrees: f64, radius: f64| {
        let angle = degrees.to_radians();
        Vec3::new(radius * angle.cos(), radius * angle.sin(), 0.0)
    };
    let mut points = vec![Vec3::zeros()];
    points.extend((0..3).map(|k| at(corner * f64::from(k), 1.0)));
    let mut faces = Vec::new();
    for k in 0..2u32 {
        let first = points.len() as u32;
        let around = [0.25, 0.5, 0.75].map(|t| at((f64::from(k) + t) * corner, 2.0));
        points.extend(around);
        faces.push([0, 1 + k, first, first + 1, first + 2, 2 + k]);
    }
    HexMesh::new(points, &faces).unwrap()
}

#[test]
fn faces_that_overlap_at_a_vertex_of_the_boundary_are_located() {
    assert_eq!(check(&pair(120.0)), []);
    assert_eq!(check(&pair(170.0)), []);
    let found = check(&pair(190.0));
    let fans = of_kind(&found, "wrong_fan");
    let [
        Violation::WrongFan {
            vertex,
            faces,
            turns,
        },
    ] = &fans[..]
    else {
        panic!("{found:?}")
    };
    assert!(*vertex == VertexId::new(0) && faces.len() == 2 && (turns - 2.0).abs() < 1e-12);
    let said = fans[0].to_string();
    assert!(
        said.starts_with("faces 0 and 1 go round vertex 0 2.00 times"),
        "{said}"
    );
}

/// A face whose tip lies over its neighbour, or ends before it, in one plane.
#[test]
fn a_tip_over_a_neighbour_overlaps_it() {
    let with_tip = |height: f64| {
        let outline = [
            [0.0, 0.0],
            [0.0, 1.0],
            [-1.0, 1.0],
            [-1.0, 0.0],
            [2.0, 0.0],
            [2.0, 3.0],
            [-1.0, 3.0],
            [-0.5, height],
            [-0.4, 2.0],
        ];
        let points = outline.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        let faces: [&[u32]; 2] = [&[0, 1, 2, 3], &[0, 4, 5, 6, 7, 8, 1]];
        HexMesh::new(points, &faces).unwrap()
    };
    assert_eq!(check(&with_tip(1.2)), []);
    let found = check(&with_tip(0.7));
    assert_eq!(of_kind(&found, "crossing").len(), found.len(), "{found:?}");
    // Two edges of the tip over the neighbour, and one of the neighbour under the tip.
    let faces = found.iter().map(|v| match v {
        Violation::Crossing { face, .. } => face.index(),
        other => panic!("{other}"),
    });
    assert_eq!(faces.collect::<Vec<_>>(), [1, 0, 0]);
}

#[test]
fn mirrored_face_is_flipped_against_its_neighbours() {
    let flat = honeycomb(5, 5);
    let centre = flat.centre(cell(5, 2, 2));
    let mut mirrored = positions(&flat);
    for &v in flat.topology().face_vertices(cell(5, 2, 2)) {
        // A little smaller, so that the neighbours keep their normals.
        let d = flat.position(v) - centre;
        mirrored[v] = centre + Vec3::new(-d.x, d.y, 0.0) * 0.1;
    }
    let found = check(&flat.with_positions(mirrored));
    let flipped = of_kind(&found, "flipped_face");
    let expected = Violation::FlippedFace {
        face: cell(5, 2, 2),
        against: FlipReference::Neighbours,
    };
    assert_eq!(flipped, [&expected]);
    assert_eq!(of_kind(&found, "fold").len(), 6);
}

#[test]
fn face_is_flipped_against_the_surface_but_not_all_of_them() {
    let surface: TriangleSurface = square_surface(4, 20.0);
    let part = |k: f64| mapped(&honeycomb(1, 1), |p| p + Vec3::x() * 3.0 * k);
    let turned = |k: f64| mapped(&honeycomb(1, 1), |p| Vec3::new(p.x + 3.0 * k, -p.y, 0.0));
    let judge =
        |parts: &[HexMesh]| violations(&union(parts), Some(&surface), &ValidateOptions::default());
    let expected = [Violation::FlippedFace {
        face: FaceId::new(1),
        against: FlipReference::Surface,
    }];
    assert_eq!(judge(&[part(0.0), turned(1.0), part(2.0)]), expected);
    assert_eq!(judge(&[turned(0.0), part(1.0), turned(2.0)]), expected);
    assert_eq!(judge(&[turned(0.0), turned(1.0)]), []);
    // Against another surface they are added once.
    let mesh = union(&[part(0.0), turned(1.0), part(2.0)]);
    let mut found = check(&mesh);
    assert_eq!(found, []);
    for _ in 0..2 {
        add_flips(&mut found, &mesh, &surface);
        assert_eq!(found, expected);
    }
}

#[test]
fn interpenetrating_pieces_cross() {
    let hexagon = honeycomb(1, 1);
    let wall = |x: f64| {
        single(&[
            [-x, 0.0, -1.0],
            [x, 0.0, -1.0],
            [x, 0.0, 1.0],
            [-x, 0.0, 1.0],
        ])
    };
    // The uprights of the wall pass through the hexagon if it is narrow enough.
    for (x, crossings) in [(0.25, 2), (0.5, 2), (2.0, 0)] {
        let mesh = union(&[hexagon.clone(), wall(x)]);
        for rotation in [Vec3::zeros(), Vec3::new(0.3, -1.1, 0.7)].map(Rotation3::new) {
            let mesh = mapped(&mesh, |p| rotation * p);
            let found = check(&mesh);
            let uprights = of_kind(&found, "crossing")
                .into_iter()
                .filter(|c| matches!(c, Violation::Crossing { face, .. } if face.index() == 0));
            assert_eq!(uprights.count(), crossings, "{x}: {found:?}");
        }
    }
    // A wider wall is cut by two edges of the hexagon instead.
    let found = check(&union(&[hexagon, wall(2.0)]));
    assert_eq!(of_kind(&found, "crossing").len(), 2);
}

#[test]
fn pieces_that_lie_over_each_other_in_one_plane_cross() {
    let square = |at: f64, size: f64| {
        let corner = |x: f64, y: f64| [at + x * size, y * size, 0.0];
        let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        single(&corners.map(|(x, y)| corner(x, y)))
    };
    // Beside each other; half over each other, which edges tell; one inside the other; twice the
    // same one, which no edge tells.
    for (at, size, is_over) in [
        (1.0, 1.0, false),
        (0.5, 1.0, true),
        (0.25, 0.5, true),
        (0.0, 1.0, true),
    ] {
        let mesh = union(&[square(0.0, 1.0), square(at, size)]);
        for rotation in [Vec3::zeros(), Vec3::new(0.3, -1.1, 0.7)].map(Rotation3::new) {
            let found = check(&mapped(&mesh, |p| rotation * p * 40.0));
            assert_eq!(of_kind(&found, "crossing").len(), found.len(), "{found:?}");
            assert_eq!(!found.is_empty(), is_over, "{at}: {found:?}");
        }
    }
}

#[test]
fn edge_through_a_diagonal_is_found() {
    // A square and an upright through its very centre: on the diagonal of either triangulation.
    let square = single(&[
        [-1.0, -1.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, 1.0, 0.0],
        [-1.0, 1.0, 0.0],
    ]);
    let wall = single(&[
        [0.0, 0.0, -1.0],
        [3.0, 0.0, -1.0],
        [3.0, 0.0, 1.0],
        [0.0, 0.0, 1.0],
    ]);
    let found = check(&union(&[square, wall]));
    let crossings = of_kind(&found, "crossing");
    assert_eq!(
        crossings.len(),
        2,
        "the upright through the square, the square's side through the wall"
    );
}

#[test]
fn wrong_degree_is_located() {
    let found = check(&square_grid(3, 1.0, 0.0));
    let vertices: Vec<usize> = found
        .iter()
        .map(|v| match v {
            Violation::WrongDegree { vertex, degree: 4 } => vertex.index(),
            other => panic!("{other}"),
        })
        .collect();
    assert_eq!(vertices, [5, 6, 9, 10]);
}

#[test]
fn infinite_coordinates_are_located_and_all_else_is_left() {
    let mesh = moved(&honeycomb(3, 3), VertexId::new(7), Vec3::x() * f64::NAN);
    assert_eq!(
        check(&mesh),
        [Violation::NotFinite {
            vertex: VertexId::new(7)
        }]
    );
}

#[test]
fn mesh_in_one_point_is_invalid_and_does_not_panic() {
    let found = check(&mapped(&honeycomb(3, 3), |_| Vec3::x()));
    for kind in [
        "not_simple",
        "not_planar",
        "collapsed_edge",
        "small_clearance",
    ] {
        assert!(!of_kind(&found, kind).is_empty(), "{kind}");
    }
}

#[test]
fn planarity_floor_grows_with_the_extent() {
    let small = planarity_floor(&honeycomb(2, 2));
    let far = planarity_floor(&mapped(&honeycomb(2, 2), |p| p + Vec3::x() * 1e6));
    assert!(small < 1e-14 && (far - 4.0 * f64::EPSILON * 1e6).abs() < 1e-14);
}

proptest! {
    #[test]
    fn verdict_does_not_depend_on_the_frame(
        axis in prop::array::uniform3(-3.0..3.0), exponent in -6.0..6.0, damage in 0usize..4,
    ) {
        let mesh = match damage {
            0 => truncated_icosahedron(),
            1 => moved(&dodecahedron(), VertexId::new(3), Vec3::new(0.1, 0.2, -0.1)),
            2 => union(&[dodecahedron(), mapped(&dodecahedron(), |p| p * 0.7 + Vec3::new(1.0, 0.31, 0.17))]),
            _ => moved(&truncated_icosahedron(), VertexId::new(3), Vec3::new(-4.0, 0.3, 0.1)),
        };
        let (rotation, scale) = (Rotation3::new(Vec3::from(axis)), f64::powf(10.0, exponent));
        let other = mapped(&mesh, |p| rotation * p * scale);
        let located = |m: &HexMesh| -> Vec<_> {
            check(m).iter().map(|v| (v.kind(), v.faces(m.topology()))).collect()
        };
        prop_assert_eq!(located(&mesh), located(&other));
        prop_assert_eq!(check(&mesh).is_empty(), damage == 0);
    }
}

#[test]
fn a_face_above_the_ridge_of_a_pleat_is_against_the_surface_on_either_side_of_it() {
    // A sheet that is folded back below itself along x = 1. The last of three faces has its middle
    // beyond the ridge, where both sheets are equally near.
    let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut places = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
    places.push(Vec3::new(0.5, 0.5, -0.1));
    let row = |x: f64| [Vec3::new(x, 0.2, 0.0), Vec3::new(x, 0.8, 0.0)];
    let positions = [0.1, 0.4, 0.7, 1.5].into_iter().flat_map(row).collect();
    let faces = [[0, 2, 3, 1], [2, 4, 5, 3], [4, 6, 7, 5]];
    let mesh = HexMesh::new(positions, &faces).unwrap();
    for triangles in [
        [[0, 1, 2], [0, 2, 3], [2, 1, 4]],
        [[2, 1, 4], [0, 1, 2], [0, 2, 3]],
    ] {
        let pleat = TriangleSurface::new(places.clone(), &triangles).unwrap();
        let mut found = Vec::new();
        add_flips(&mut found, &mesh, &pleat);
        assert_eq!(faces_of(&mesh, &found, "flipped_face"), [FaceId::new(2)]);
    }
}
