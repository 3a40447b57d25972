//! Building triangle surfaces from faces as they stand in a file: what is repaired, and what is
//! refused by name.

use phex_mesh::{
    FaceId, HexMesh, PolygonSoup, SurfaceError, SurfaceParts, TopologyError, TriangleSurface, Vec3,
    VertexId,
};

fn soup(positions: &[[f64; 3]], faces: &[&[u32]]) -> PolygonSoup {
    PolygonSoup {
        positions: positions.iter().map(|&p| Vec3::from(p)).collect(),
        faces: faces.iter().map(|f| f.to_vec()).collect(),
    }
}

fn build(soup: &PolygonSoup) -> SurfaceParts {
    TriangleSurface::from_soup(soup).unwrap()
}

fn error(soup: &PolygonSoup) -> SurfaceError {
    match TriangleSurface::from_soup(soup) {
        Ok(_) => panic!("a surface was built"),
        Err(error) => error,
    }
}

fn faces(numbers: &[u32]) -> Vec<FaceId> {
    numbers.iter().map(|&f| FaceId::new(f)).collect()
}

fn v(number: u32) -> VertexId {
    VertexId::new(number)
}

const TETRAHEDRON: [[f64; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
];

fn tetrahedron() -> PolygonSoup {
    soup(
        &TETRAHEDRON,
        &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]],
    )
}

/// A strip of `n` quads closed to a ring with or without a half twist.
fn ring(n: u32, twisted: bool) -> PolygonSoup {
    let positions = (0..n).flat_map(|i| {
        let angle = std::f64::consts::TAU * f64::from(i) / f64::from(n);
        let half = if twisted { 0.5 * angle } else { 0.0 };
        [-0.3, 0.3].map(|s| {
            let radius = 1.0 + s * half.cos();
            Vec3::new(radius * angle.cos(), radius * angle.sin(), s * half.sin())
        })
    });
    let quad = |i: u32| match (i + 1 == n, twisted) {
        (true, true) => vec![2 * i, 1, 0, 2 * i + 1],
        (last, _) => {
            let next = if last { 0 } else { 2 * i + 2 };
            vec![2 * i, next, next + 1, 2 * i + 1]
        }
    };
    PolygonSoup {
        positions: positions.collect(),
        faces: (0..n).map(quad).collect(),
    }
}

#[test]
fn a_sound_mesh_is_taken_as_it_is() {
    let parts = build(&tetrahedron());
    assert_eq!(parts.notes, Default::default());
    let [part] = &parts.components[..] else {
        panic!("one component")
    };
    assert_eq!(part.surface.topology().face_lists(), tetrahedron().faces);
    assert_eq!(part.surface.positions().as_slice(), tetrahedron().positions);
    assert_eq!(
        (&part.original_vertices[..], &part.original_faces[..]),
        (&[0, 1, 2, 3][..], &[0, 1, 2, 3][..])
    );
}

#[test]
fn unused_vertices_are_dropped_and_counted() {
    let mut soup = tetrahedron();
    soup.positions.insert(1, Vec3::repeat(1e60));
    soup.faces
        .iter_mut()
        .flatten()
        .filter(|v| **v > 0)
        .for_each(|v| *v += 1);
    let parts = build(&soup);
    assert_eq!(parts.notes.unused_vertices, 1);
    assert_eq!(parts.components[0].original_vertices, [0, 2, 3, 4]);
    assert_eq!(
        parts.components[0].surface.topology().face_lists(),
        tetrahedron().faces
    );
}

#[test]
fn the_fewer_faces_are_turned() {
    for wrong in [vec![0], vec![2], vec![0, 1, 3]] {
        let mut soup = tetrahedron();
        wrong.iter().for_each(|&f: &usize| soup.faces[f].reverse());
        let parts = build(&soup);
        assert_eq!(parts.notes.turned_faces, 1, "{wrong:?}");
        let volume: f64 = {
            let s = &parts.components[0].surface;
            s.topology()
                .faces()
                .map(|f| s.corners(f))
                .map(|[a, b, c]| a.cross(&b).dot(&c) / 6.0)
                .sum()
        };
        let sign = if wrong.len() == 3 { -1.0 } else { 1.0 };
        assert!((volume - sign / 6.0).abs() < 1e-15, "{wrong:?} {volume}");
    }
}

#[test]
fn an_inside_out_solid_stays_inside_out() {
    let mut soup = tetrahedron();
    soup.faces.iter_mut().for_each(|f| f.reverse());
    let parts = build(&soup);
    assert_eq!(parts.notes.turned_faces, 0);
    assert_eq!(
        parts.components[0].surface.topology().face_lists(),
        soup.faces
    );
}

#[test]
fn a_ring_is_oriented_and_a_moebius_strip_refused() {
    let mut flat = ring(12, false);
    for f in [1, 4, 5] {
        flat.faces[f].reverse();
    }
    let parts = build(&flat);
    assert_eq!(
        (parts.notes.turned_faces, parts.notes.cut_polygons),
        (3, 12)
    );
    assert_eq!(parts.components[0].surface.boundary_loops().len(), 2);

    let error = error(&ring(12, true));
    let SurfaceError::NotOrientable {
        from,
        to,
        first,
        second,
    } = error
    else {
        panic!("{error}")
    };
    let on = |f: FaceId| ring(12, true).faces[f.index()].clone();
    for face in [on(first), on(second)] {
        assert!(face.contains(&(from.index() as u32)) && face.contains(&(to.index() as u32)));
    }
    assert!(error.to_string().contains("Moebius"));
}

#[test]
fn components_come_in_the_order_of_their_first_faces() {
    let mut soup = tetrahedron();
    let n = soup.positions.len() as u32;
    soup.positions
        .extend(TETRAHEDRON.map(|p| Vec3::from(p) + Vec3::x() * 5.0));
    let far: Vec<Vec<u32>> = soup
        .faces
        .iter()
        .map(|f| f.iter().map(|v| v + n).collect())
        .collect();
    // Faces of the second tetrahedron first, then alternating.
    soup.faces = far
        .into_iter()
        .zip(soup.faces)
        .flat_map(|(far, near)| [far, near])
        .collect();
    let parts = build(&soup);
    assert_eq!(parts.components.len(), 2);
    assert_eq!(parts.components[0].original_vertices, [4, 5, 6, 7]);
    assert_eq!(parts.components[0].original_faces, [0, 2, 4, 6]);
    assert_eq!(parts.components[1].original_vertices, [0, 1, 2, 3]);
    assert_eq!(parts.components[1].original_faces, [1, 3, 5, 7]);
    assert!(parts.components[0].surface.bounding_box().0.x == 5.0);
}

#[test]
fn polygons_keep_their_area_and_their_concave_corners() {
    // An L with a straight corner in its long side, and a square at its right side, turned.
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [2.0, 1.0, 0.0],
        [1.0, 1.0, 0.0],
        [1.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
        [3.0, 0.0, 0.0],
        [3.0, 1.0, 0.0],
    ];
    for start in 0..7 {
        let mut l: Vec<u32> = (0..7).collect();
        l.rotate_left(start);
        let parts = build(&soup(&points, &[&l, &[2, 3, 8, 7]]));
        let surface = &parts.components[0].surface;
        assert_eq!(surface.topology().n_faces(), 5 + 2);
        assert!(
            (surface.area() - 4.0).abs() < 1e-14,
            "start {start}: {}",
            surface.area()
        );
        assert!(
            surface
                .topology()
                .faces()
                .all(|f| surface.area_vector(f).z > 0.1),
            "start {start}"
        );
        assert_eq!(parts.components[0].original_faces, [0, 0, 0, 0, 0, 1, 1]);
        assert_eq!((parts.notes.turned_faces, parts.notes.cut_polygons), (1, 2));
    }
}

#[test]
fn crossing_and_flat_polygons_are_named() {
    let crossing = soup(
        &[
            [0.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.2, 0.0],
        ],
        &[&[0, 1, 2, 3]],
    );
    assert_eq!(
        error(&crossing),
        SurfaceError::NotSimple { faces: faces(&[0]) }
    );
    let flat = soup(
        &[
            [0.0, 0.0, 0.0],
            [0.1, 0.2, 0.3],
            [0.3, 0.6, 0.9],
            [0.2, 0.4, 0.6],
        ],
        &[&[0, 1, 2, 3]],
    );
    assert_eq!(error(&flat), SurfaceError::ZeroArea { faces: faces(&[0]) });
}

#[test]
fn triangles_without_area_are_named_at_any_scale_and_place() {
    for scale in [1e-3, 1.0, 1e4] {
        for shift in [0.0, 10.0] {
            let collinear = [
                [0.1, 0.2, 0.3],
                [0.2, 0.4, 0.6],
                [0.3, 0.6, 0.9],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 1.0],
            ];
            let at = |p: [f64; 3]| p.map(|x| (x + shift) * scale);
            let soup = soup(
                &collinear.map(at),
                &[&[0, 1, 3], &[0, 2, 1], &[1, 2, 3], &[2, 0, 4]],
            );
            assert_eq!(
                error(&soup),
                SurfaceError::ZeroArea { faces: faces(&[1]) },
                "scale {scale} shift {shift}"
            );
            assert!(
                error(&soup)
                    .to_string()
                    .contains("one face is without area: 1")
            );
        }
    }
}

#[test]
fn needles_are_kept_at_any_scale() {
    for scale in [1e-3, 1.0, 1e4] {
        let soup = soup(
            &[
                [0.0, 0.0, 0.0],
                [scale, 0.0, 0.0],
                [0.5 * scale, 1e-9 * scale, 0.0],
                [0.5 * scale, -scale, 0.0],
            ],
            &[&[0, 1, 2], &[1, 0, 3]],
        );
        assert_eq!(build(&soup).components[0].surface.topology().n_faces(), 2);
    }
}

#[test]
fn bad_elements_are_named_by_their_numbers_in_the_input() {
    // An unused vertex in front: messages must not use the numbers after it is dropped.
    let with = |faces: &[&[u32]]| {
        let mut positions = vec![[9.0, 9.0, 9.0]];
        positions.extend(TETRAHEDRON);
        positions.extend([[1.0, 1.0, 1.0], [2.0, 1.0, 0.0]]);
        error(&soup(&positions, faces))
    };
    let topology = |e: SurfaceError| match e {
        SurfaceError::Topology(e) => e,
        other => panic!("{other}"),
    };
    assert_eq!(
        topology(with(&[&[1, 2, 3], &[2, 1, 4], &[1, 2, 5]])),
        TopologyError::NonManifoldEdge {
            from: v(1),
            to: v(2),
            faces: faces(&[0, 1, 2])
        }
    );
    assert_eq!(
        topology(with(&[&[1, 2, 3], &[1, 4, 5]])),
        TopologyError::BowTieVertex { vertex: v(1) }
    );
    assert_eq!(
        topology(with(&[&[1, 2, 3], &[3, 4, 3]])),
        TopologyError::RepeatedVertex {
            face: FaceId::new(1),
            vertex: v(3)
        }
    );
    assert_eq!(
        topology(with(&[&[1, 2, 3], &[1, 2, u32::MAX]])),
        TopologyError::IndexOutOfRange {
            face: FaceId::new(1),
            vertex: u32::MAX,
            vertices: 7
        }
    );
    assert_eq!(
        topology(with(&[&[1, 2, 3], &[1, 2]])),
        TopologyError::TooFewCorners {
            face: FaceId::new(1),
            corners: 2
        }
    );
    assert_eq!(topology(with(&[])), TopologyError::Empty);
}

#[test]
fn closed_fans_that_touch_in_a_vertex_are_refused() {
    let mut soup = tetrahedron();
    soup.positions.extend([-Vec3::x(), -Vec3::y(), -Vec3::z()]);
    let second = tetrahedron().faces.into_iter();
    soup.faces
        .extend(second.map(|f| f.iter().map(|&v| if v == 0 { 0 } else { v + 3 }).collect()));
    assert_eq!(
        error(&soup),
        TopologyError::BowTieVertex { vertex: v(0) }.into()
    );
}

#[test]
fn diagonals_that_clash_are_named_by_the_input() {
    // Two quads back to back: both are cut along the same diagonal or enclose nothing.
    let points = [
        [5.0, 5.0, 5.0],
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.3, 1.3, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let soup = soup(&points, &[&[1, 2, 3, 4], &[4, 3, 2, 1]]);
    let SurfaceError::Topology(TopologyError::NonManifoldEdge {
        from,
        to,
        faces: found,
    }) = error(&soup)
    else {
        panic!("{}", error(&soup))
    };
    assert_eq!(found, faces(&[0, 0, 1, 1]));
    assert!([(v(2), v(4)), (v(4), v(2)), (v(1), v(3)), (v(3), v(1))].contains(&(from, to)));
}

#[test]
fn coordinates_that_can_not_be_computed_with() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut soup = tetrahedron();
        soup.positions[2].y = x;
        assert_eq!(error(&soup), SurfaceError::NonFinite { vertex: v(2) });
    }
    for scale in [0.0, 1e-60, 1e60] {
        let mut soup = tetrahedron();
        soup.positions.iter_mut().for_each(|p| *p *= scale);
        assert!(
            matches!(error(&soup), SurfaceError::Extent { .. }),
            "{scale}"
        );
    }
}

#[test]
fn hex_mesh_from_a_soup_welds_and_turns_nothing() {
    let quads = ring(6, false);
    let mesh = HexMesh::from_soup(&quads).unwrap();
    assert_eq!(mesh.to_soup(), quads);
    let mut turned = ring(6, false);
    turned.faces[2].reverse();
    let message = HexMesh::from_soup(&turned).unwrap_err().to_string();
    assert!(
        message.contains("faces 1 and 2") || message.contains("faces 2 and 3"),
        "{message}"
    );
    let mut infinite = ring(6, false);
    infinite.positions[4].x = f64::INFINITY;
    assert!(
        HexMesh::from_soup(&infinite)
            .unwrap_err()
            .to_string()
            .contains("vertex 4")
    );
}
