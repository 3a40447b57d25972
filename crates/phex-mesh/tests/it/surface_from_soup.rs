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
fn a_body_whose_normals_point_inwards_is_told() {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let outwards = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    let bodies = |faces: Vec<Vec<u32>>| {
        let positions = corners.map(|p| Vec3::from(p) + Vec3::repeat(1e6)).to_vec();
        let parts = TriangleSurface::from_soup(&PolygonSoup { positions, faces }).unwrap();
        parts.notes.inward_bodies
    };
    let inwards = outwards.map(|[a, b, c]| vec![a, c, b]).to_vec();
    assert_eq!(bodies(outwards.map(Vec::from).to_vec()), 0);
    assert_eq!(bodies(inwards.clone()), 1);
    // An open surface has no inside.
    assert_eq!(bodies(inwards[..3].to_vec()), 0);
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
fn triangles_without_area_are_taken_out_at_any_scale_and_place() {
    for scale in [1e-3, 1.0, 1e4] {
        for shift in [0.0, 10.0] {
            // Vertex 1 lies on the side from 0 to 2 of the last face.
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
            let parts = build(&soup);
            let [part] = &parts.components[..] else {
                panic!("scale {scale} shift {shift}: one component")
            };
            assert_eq!(parts.notes.dropped_faces, 1);
            assert_eq!(part.original_faces, [0, 2, 3, 3]);
            let topology = part.surface.topology();
            assert_eq!((topology.n_vertices(), topology.n_faces()), (5, 4));
            assert_eq!(topology.boundary_loops().len(), 1);
            assert!(parts.notes.sentences()[1].contains("1 face without area"));
        }
    }
}

/// A triangle without area whose neighbour has none, either.
#[test]
fn triangles_without_area_that_can_not_be_taken_out_are_named() {
    let points = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.4, 0.0, 0.0],
        [0.6, 0.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    let soup = soup(&points, &[&[0, 1, 2], &[1, 0, 3], &[0, 2, 4]]);
    let error = error(&soup);
    assert_eq!(
        error,
        SurfaceError::ZeroArea {
            faces: faces(&[0, 1])
        }
    );
    assert!(error.to_string().contains("2 faces are without area: 0, 1"));
}

/// A sphere as CAD programs write it: a grid whose first and last rows lie in the poles, and whose
/// first and last columns lie on one another.
#[test]
fn poles_and_the_seam_of_a_sphere_close() {
    let (rows, columns) = (9, 16);
    let at = |i: usize| {
        let (u, v) = ((i / (columns + 1)) as f64, (i % (columns + 1)) as f64);
        let (polar, round) = (
            std::f64::consts::PI * u / rows as f64,
            std::f64::consts::TAU * v / columns as f64,
        );
        Vec3::new(
            polar.sin() * round.cos(),
            polar.sin() * round.sin(),
            polar.cos(),
        )
    };
    let n = columns as u32 + 1;
    let quad = |k: u32| {
        let (i, j) = (k / (n - 1), k % (n - 1));
        let a = i * n + j;
        [[a, a + n, a + n + 1], [a, a + n + 1, a + 1]].map(|f| f.to_vec())
    };
    let soup = PolygonSoup {
        positions: (0..(rows + 1) * (columns + 1)).map(at).collect(),
        faces: (0..(rows * columns) as u32).flat_map(quad).collect(),
    };
    let parts = build(&soup);
    assert_eq!(parts.components.len(), 1);
    let topology = parts.components[0].surface.topology();
    assert_eq!(topology.euler_characteristic(), 2);
    assert!(topology.boundary_loops().is_empty());
    assert_eq!(topology.n_vertices(), (rows - 1) * columns + 2);
    assert_eq!(parts.notes.dropped_faces, 2 * columns);
    assert_eq!(parts.notes.sewn_edges, 2 * (rows - 2) + 4);
    assert!(parts.notes.widest_gap < 1e-15);
}

/// A patch of a curved surface over a rectangle, with so many quads, moved and scaled.
fn patch(from: [f64; 2], to: [f64; 2], quads: [usize; 2], shift: f64, scale: f64) -> PolygonSoup {
    let [m, n] = quads;
    let at = |k: usize| {
        let part = [
            (k / (n + 1)) as f64 / m as f64,
            (k % (n + 1)) as f64 / n as f64,
        ];
        let [x, y] = [0, 1].map(|i| from[i] + (to[i] - from[i]) * part[i]);
        let z = 2.0 * (x / 6.0).sin() * (y / 7.0).cos();
        Vec3::new(x + shift, y, z) * scale
    };
    let quad = |k: usize| {
        let a = (k / n * (n + 1) + k % n) as u32;
        let b = a + n as u32 + 1;
        vec![a, b, b + 1, a + 1]
    };
    PolygonSoup {
        positions: (0..(m + 1) * (n + 1)).map(at).collect(),
        faces: (0..m * n).map(quad).collect(),
    }
}

fn together(parts: &[PolygonSoup]) -> PolygonSoup {
    let mut whole = PolygonSoup {
        positions: Vec::new(),
        faces: Vec::new(),
    };
    for part in parts {
        let first = whole.positions.len() as u32;
        whole.positions.extend(&part.positions);
        let moved = part.faces.iter();
        whole
            .faces
            .extend(moved.map(|f| f.iter().map(|v| v + first).collect::<Vec<_>>()));
    }
    whole
}

/// Patches of a CAD model: along their seams each has vertices of its own.
#[test]
fn patches_are_sewn_whatever_their_vertices_and_their_unit() {
    let mut faces = Vec::new();
    for scale in [-10, 0, 20].map(|power| 2f64.powi(power)) {
        let soup = together(&[
            patch([0.0, 0.0], [10.0, 8.0], [20, 16], 0.0, scale),
            patch([10.0, 0.0], [20.0, 8.0], [32, 24], 1e-3, scale),
            patch([0.0, 8.0], [10.0, 15.0], [26, 22], 0.0, scale),
            patch([10.0, 8.0], [20.0, 15.0], [39, 30], 1e-3, scale),
        ]);
        let parts = build(&soup);
        assert_eq!(parts.components.len(), 1, "scale {scale}");
        let surface = &parts.components[0].surface;
        let topology = surface.topology();
        assert_eq!(topology.euler_characteristic(), 1);
        assert_eq!(topology.boundary_loops().len(), 1);
        let flat = |p: &PolygonSoup| build(p).whole().area();
        let whole = flat(&patch([0.0, 0.0], [20.0, 15.0], [200, 150], 0.0, scale));
        assert!((surface.area() / whole - 1.0).abs() < 2e-3);
        let gap = parts.notes.widest_gap / scale;
        assert!((1e-3..2e-2).contains(&gap), "gap {gap}");
        faces.push(topology.face_lists());
    }
    assert!(faces.iter().all(|f| *f == faces[0]));
}

#[test]
fn faces_that_share_no_vertices_are_sewn() {
    let grid = patch([0.0, 0.0], [10.0, 8.0], [12, 9], 0.0, 1.0);
    let apart: Vec<PolygonSoup> = (grid.faces.iter())
        .map(|face| PolygonSoup {
            positions: face.iter().map(|&v| grid.positions[v as usize]).collect(),
            faces: vec![(0..face.len() as u32).collect()],
        })
        .collect();
    let parts = build(&together(&apart));
    assert_eq!(parts.components.len(), 1);
    let [sewn, whole] = [parts.whole(), build(&grid).whole()];
    let counts = |s: &TriangleSurface| (s.topology().n_vertices(), s.topology().n_faces());
    assert_eq!(counts(&sewn), counts(&whole));
    assert_eq!(parts.notes.sewn_edges, 2 * (11 * 9 + 12 * 8));
}

#[test]
fn what_touches_in_a_point_or_runs_apart_is_not_sewn() {
    let square = |x: f64, y: f64| patch([x, y], [x + 1.0, y + 1.0], [4, 4], 0.0, 1.0);
    let corner = together(&[square(0.0, 0.0), square(1.0, 1.0)]);
    // A gap of a thousandth is more than a ten-thousandth of the diagonal.
    let slit = together(&[square(0.0, 0.0), square(1.01, 0.0)]);
    for soup in [corner, slit] {
        let parts = build(&soup);
        assert_eq!((parts.components.len(), parts.notes.sewn_edges), (2, 0));
    }
    // A strip much narrower than its edges are long is no seam.
    let strip = patch([0.0, 0.0], [10.0, 1e-3], [12, 1], 0.0, 1.0);
    let parts = build(&strip);
    assert_eq!((parts.components.len(), parts.notes.sewn_edges), (1, 0));
}

/// Three sheets at an edge are no surface however they are sewn: they stay as they are.
#[test]
fn three_sheets_at_an_edge_stay_apart() {
    let floor = patch([0.0, 0.0], [4.0, 2.0], [8, 4], 0.0, 1.0);
    let other = patch([0.0, -2.0], [4.0, 0.0], [8, 4], 0.0, 1.0);
    let mut wall = floor.clone();
    wall.positions
        .iter_mut()
        .for_each(|p| (p.y, p.z) = (0.0, p.z + p.y));
    for (k, p) in wall
        .positions
        .iter_mut()
        .enumerate()
        .filter(|(k, _)| k % 5 == 0)
    {
        *p = floor.positions[k];
    }
    let parts = build(&together(&[floor, other, wall]));
    assert_eq!((parts.components.len(), parts.notes.sewn_edges), (3, 0));
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
        topology(with(&[&[1, 2, 3], &[3, 4, 5, 3, 6]])),
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
fn faces_that_are_there_twice_are_left_out() {
    let once = ring(6, false);
    let surface = build(&once).whole().to_soup();
    let n = once.positions.len() as u32;
    let copy = |face: &Vec<u32>| face.iter().map(|v| v + n).collect::<Vec<u32>>();
    // The same faces again; turned round; with vertices of their own, as pasted objects have; two.
    let mut variants = [
        once.faces.clone(),
        once.faces
            .iter()
            .map(|f| f.iter().rev().copied().collect())
            .collect(),
        once.faces.iter().map(copy).collect(),
        once.faces[2..4].to_vec(),
    ];
    for (k, again) in variants.iter_mut().enumerate() {
        again.iter_mut().for_each(|f| f.rotate_left(k));
        let positions = [&once.positions[..], &once.positions[..]].concat();
        let twice = PolygonSoup {
            positions: positions[..if k == 2 { 2 } else { 1 } * n as usize].to_vec(),
            faces: [&once.faces[..], &again[..]].concat(),
        };
        let parts = build(&twice);
        assert_eq!(parts.whole().to_soup(), surface, "{k}");
        assert_eq!(parts.notes.repeated_faces, again.len());
        let told = parts.notes.sentences().join("; ");
        assert!(
            told.contains("faces are there twice and were left out"),
            "{told}"
        );
    }
    assert_eq!(build(&once).notes.repeated_faces, 0);
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

#[test]
fn quadrilaterals_that_share_three_vertices_are_cut_along_different_diagonals() {
    let mut positions = Vec::new();
    for y in [0.0, 1.0, 2.0] {
        positions.extend([0.0, 2.0, 4.0].map(|x| [x, y, 0.0]));
    }
    positions[4] = [2.0, 1.2, 0.5];
    positions.push([2.0, 1.2, -0.5]);
    let above: [&[u32]; 4] = [&[0, 1, 4, 3], &[1, 2, 5, 4], &[3, 4, 7, 6], &[4, 5, 8, 7]];
    let below: [&[u32]; 4] = [&[3, 9, 1, 0], &[9, 5, 2, 1], &[6, 7, 9, 3], &[7, 8, 5, 9]];
    let cushion = build(&soup(&positions, &[above, below].concat()));
    let surface = &cushion.components[0].surface;
    assert_eq!(cushion.components.len(), 1);
    assert_eq!(surface.topology().n_faces(), 16);
    assert!(surface.topology().boundary_loops().is_empty());
}
