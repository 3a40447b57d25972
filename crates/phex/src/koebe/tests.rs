use super::*;
use crate::progress::Silent;
use crate::test_meshes::*;
use phex_mesh::measure;
use std::f64::consts::FRAC_1_SQRT_2;

/// The largest error that issue and text promise.
const PROMISED: f64 = 1e-12;

fn solve(mesh: &HexMesh) -> Koebe {
    let koebe = koebe(mesh, &KoebeOptions::default(), &Silent).unwrap();
    assert_sound(&koebe);
    koebe
}

fn assert_sound(koebe: &Koebe) {
    let KoebeDefects {
        tangency,
        planarity,
        untouched_edges,
        ..
    } = koebe.defects;
    assert_eq!(
        koebe.outcome.status,
        Status::Converged,
        "{:?}",
        koebe.outcome
    );
    assert!(
        tangency < PROMISED && planarity < PROMISED,
        "{:?}",
        koebe.defects
    );
    assert_eq!(untouched_edges, 0);
    assert!(
        koebe.outcome.factorisations <= 15,
        "{}",
        koebe.outcome.factorisations
    );
}

fn assert_closed_and_convex(koebe: &Koebe) {
    assert!(koebe.defects.imbalance < 1e-13, "{:?}", koebe.defects);
    let t = koebe.mesh.topology();
    for h in t.half_edges() {
        // Every face plane has the centre and the next vertex of each neighbour below it.
        let y = koebe.face_poles[t.face(h)];
        assert!((y.dot(&koebe.mesh.position(t.origin(h))) - 1.0).abs() < PROMISED);
    }
    let measures = measure(&koebe.mesh);
    assert_eq!((measures.faces_not_simple, measures.faces_concave), (0, 0));
    let outwards = |f| {
        phex_mesh::FacePlane::fit(&koebe.mesh.corners(f).collect::<Vec<_>>())
            .normal
            .dot(&koebe.face_poles[f])
            > 0.0
    };
    assert!(t.faces().all(outwards), "orientation");
}

fn radii_of_vertices(koebe: &Koebe) -> Vec<f64> {
    koebe.mesh.positions.iter().map(|x| x.norm()).collect()
}

fn all_near(values: &[f64], expected: f64) -> bool {
    values.iter().all(|v| (v - expected).abs() < 1e-14)
}

#[test]
fn platonic_solids_come_out_regular() {
    // Radius of the circumsphere over that of the midsphere.
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let icosahedron = graph(&icosahedron());
    let solids = [
        (
            graph(&[[0u32, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]),
            3f64.sqrt(),
        ),
        (prism(4), 1.5f64.sqrt()),
        (dual(&prism(4)), 2f64.sqrt()),
        (dual(&icosahedron), 3f64.sqrt() / golden),
        (icosahedron, (golden * 5f64.sqrt()).sqrt() / golden),
    ];
    for (mesh, expected) in solids {
        let koebe = solve(&mesh);
        assert_closed_and_convex(&koebe);
        assert!(
            all_near(&radii_of_vertices(&koebe), expected),
            "{expected}: {:?}",
            radii_of_vertices(&koebe)
        );
    }
}

#[test]
fn truncated_icosahedron_is_the_archimedean_one() {
    let koebe = solve(&truncated(&graph(&icosahedron())));
    assert_closed_and_convex(&koebe);
    let lengths: Vec<f64> = koebe
        .mesh
        .topology()
        .edges()
        .map(|e| koebe.mesh.edge_length(e))
        .collect();
    // Midradius of the Archimedean solid of edge 1: 3 (1 + sqrt 5) / 4.
    assert!(all_near(&lengths, 4.0 / (3.0 * (1.0 + 5f64.sqrt()))));
}

#[test]
fn prisms_and_pyramids_have_their_known_shape() {
    for n in [3, 5, 12, 200] {
        let koebe = solve(&prism(n));
        assert_closed_and_convex(&koebe);
        // By symmetry: an upright edge touches at its middle, a rim edge at height h and distance
        // r, r^2 + h^2 = 1, r / cos(pi / n) = 1.
        let r = (std::f64::consts::PI / f64::from(n)).cos();
        let circumradius = (1.0 + (1.0 - r * r)).sqrt();
        assert!(
            radii_of_vertices(&koebe)
                .iter()
                .all(|x| (x - circumradius).abs() < 1e-13)
        );
    }
    let n = 300;
    let mut pyramid: Vec<Vec<u32>> = (0..n).map(|i| vec![i, (i + 1) % n, n]).collect();
    pyramid.push((0..n).rev().collect());
    assert_closed_and_convex(&solve(&graph(&pyramid)));
}

#[test]
fn random_trivalent_graphs() {
    for (n, seed) in [(7, 1), (30, 2), (502, 3)] {
        assert_closed_and_convex(&solve(&dual(&graph(&random_triangulation(n, seed)))));
        assert_closed_and_convex(&solve(&graph(&random_triangulation(n, seed))));
    }
}

#[test]
fn ten_thousand_vertices() {
    for triangles in [
        flipped_icosphere(5000, 5000, 1),
        random_triangulation(5002, 2),
    ] {
        let mesh = dual(&graph(&triangles));
        assert!(mesh.topology().n_vertices() >= 10_000);
        assert_closed_and_convex(&solve(&mesh));
    }
}

#[test]
fn numbering_changes_nothing_but_the_rotation() {
    let mesh = dual(&graph(&random_triangulation(80, 4)));
    let koebe = solve(&mesh);
    for seed in 0..4 {
        let (other, new) = renumbered(&mesh, seed);
        let other = solve(&other);
        let t = koebe.mesh.topology();
        let at = |v: VertexId| other.mesh.positions.as_slice()[new[v.index()] as usize];
        for v in t.vertices() {
            assert!((at(v).norm() - koebe.mesh.position(v).norm()).abs() < 1e-11);
            // Far vertices too: the Gram matrix with vertex 0.
            let w = VertexId::new(0);
            let difference =
                at(v).dot(&at(w)) - koebe.mesh.position(v).dot(&koebe.mesh.position(w));
            assert!(difference.abs() < 1e-11);
        }
    }
}

#[test]
fn result_is_turned_like_the_input() {
    let first = solve(&dual(&graph(&random_triangulation(40, 6))));
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -1.2, 2.0);
    let input = first.mesh.with_positions(
        first
            .mesh
            .positions
            .map(|p| turn * p * 7.0 + Vec3::new(1.0, 2.0, 3.0)),
    );
    let again = solve(&input);
    for (p, q) in first.mesh.positions.iter().zip(&again.mesh.positions) {
        assert!((turn * p - q).norm() < 0.05, "{} {}", turn * p, q);
    }
    assert_eq!(solve(&input).mesh, again.mesh, "the same bytes again");
}

#[test]
fn mirror_image_of_the_graph_gives_the_mirror_image() {
    let mesh = dual(&graph(&random_triangulation(25, 8)));
    let mirrored: Vec<Vec<u32>> = mesh
        .topology()
        .face_lists()
        .into_iter()
        .map(|f| f.into_iter().rev().collect())
        .collect();
    let (a, b) = (solve(&mesh), solve(&graph(&mirrored)));
    let triple = |k: &Koebe| {
        let p = k.mesh.positions.as_slice();
        p[0].cross(&p[5]).dot(&p[9])
    };
    assert!((triple(&a) + triple(&b)).abs() < 1e-11 && triple(&a).abs() > 1e-6);
}

#[test]
fn flat_patch_of_hexagons_stays_regular() {
    let mesh = hexagon_patch(5);
    let koebe = solve(&mesh);
    // Equal radii on the boundary of the lattice: all radii are equal, the middle face is regular
    // and centred.
    let t = koebe.mesh.topology();
    let middle = t
        .faces()
        .min_by(|&f, &g| mesh.centre(f).norm().total_cmp(&mesh.centre(g).norm()))
        .unwrap();
    let heights: Vec<f64> = koebe.mesh.corners(middle).map(|p| p.z).collect();
    assert!(
        all_near(&heights, heights[0]) && heights[0] > 0.9,
        "{heights:?}"
    );
    let boundary = touching_points(&koebe.mesh);
    let angles: Vec<f64> = t
        .boundary_edges()
        .map(|e| boundary[e].z.acos().to_degrees())
        .collect();
    let mean = angles.iter().sum::<f64>() / angles.len() as f64;
    assert!((mean - 60.0).abs() < 1.0, "opening {mean}");
    // In-plane turn like the flat input.
    for v in t.vertices().filter(|&v| mesh.position(v).norm() > 5.0) {
        let (p, q) = (
            mesh.position(v).xy().normalize(),
            koebe.mesh.position(v).xy().normalize(),
        );
        assert!((p - q).norm() < 1e-9);
    }
}

#[test]
fn patches_of_every_boundary_condition_and_opening() {
    let flat = hexagon_patch(6);
    let bowl = flat.with_positions(
        flat.positions
            .map(|p| Vec3::new(p.x, p.y, -0.03 * p.x * p.x - 0.06 * p.y * p.y)),
    );
    for boundary in [
        BoundaryCondition::EqualRadii,
        BoundaryCondition::GaussImage,
        BoundaryCondition::Angles,
    ] {
        for opening in [5.0, 60.0, 150.0] {
            let options = KoebeOptions {
                boundary,
                opening,
                ..KoebeOptions::default()
            };
            let koebe = koebe(&bowl, &options, &Silent).unwrap();
            assert_sound(&koebe);
            let measures = measure(&koebe.mesh);
            assert_eq!(
                (measures.faces_not_simple, measures.faces_concave),
                (0, 0),
                "{boundary:?} {opening}"
            );
        }
    }
}

#[test]
fn gauss_image_is_met_at_the_boundary() {
    let flat = hexagon_patch(6);
    let bowl = flat.with_positions(
        flat.positions
            .map(|p| Vec3::new(p.x, p.y, -0.03 * (p.x * p.x + p.y * p.y))),
    );
    let options = KoebeOptions {
        boundary: BoundaryCondition::GaussImage,
        ..KoebeOptions::default()
    };
    let koebe = koebe(&bowl, &options, &Silent).unwrap();
    for v in bowl.topology().vertices() {
        let turn = koebe.mesh.position(v).angle(&bowl.mean_normal(v));
        assert!(turn < 0.1, "{turn}");
    }
    let refused = super::koebe(&flat, &options, &Silent).unwrap_err();
    assert!(
        matches!(refused, KoebeError::NoGaussImage { .. }),
        "{refused}"
    );
}

#[test]
fn graphs_that_have_no_koebe_mesh_are_refused_by_name() {
    let refuse = |mesh: &HexMesh| koebe(mesh, &KoebeOptions::default(), &Silent).unwrap_err();
    // Two tetrahedra glued at a triangle, and that edge drawn double as two faces: 2-connected.
    let faces: [Vec<u32>; 5] = [
        vec![0, 1, 2],
        vec![0, 2, 3],
        vec![0, 3, 4, 1],
        vec![1, 4, 3, 5],
        vec![1, 5, 3, 2],
    ];
    match refuse(&graph(&faces)) {
        KoebeError::SeparatingPair { vertices, .. } => {
            assert_eq!(vertices, [1, 3].map(VertexId::new))
        }
        KoebeError::LowDegree { vertex, degree } => {
            assert_eq!((vertex, degree), (VertexId::new(4), 2))
        }
        other => panic!("{other}"),
    }
    let pillow = graph(&[[0u32, 1, 2], [0, 2, 1]]);
    assert_eq!(
        refuse(&pillow),
        KoebeError::LowDegree {
            vertex: VertexId::new(0),
            degree: 2
        }
    );
    assert_eq!(refuse(&quad_torus(6, 5)), KoebeError::Genus { genus: 1 });
    let two = graph(&[
        [0u32, 2, 1],
        [0, 1, 3],
        [1, 2, 3],
        [2, 0, 3],
        [4, 6, 5],
        [4, 5, 7],
        [5, 6, 7],
        [6, 4, 7],
    ]);
    assert_eq!(refuse(&two), KoebeError::Components { components: 2 });
    let mut tube = prism(6).topology().face_lists();
    tube.truncate(6);
    assert_eq!(
        refuse(&graph(&tube)),
        KoebeError::BoundaryLoops { boundary_loops: 2 }
    );
    let options = KoebeOptions {
        opening: f64::NAN,
        ..KoebeOptions::default()
    };
    assert!(matches!(
        koebe(&pillow, &options, &Silent),
        Err(KoebeError::Option {
            option: "opening",
            ..
        })
    ));
}

#[test]
fn separating_pair_is_one() {
    // Two cubes joined along a pair of opposite edges of a ring: vertices of degree 3 everywhere.
    let faces: [[u32; 4]; 4] = [[0, 1, 2, 3], [0, 3, 4, 5], [0, 5, 6, 7], [0, 7, 8, 1]];
    let mut lists: Vec<Vec<u32>> = faces.iter().map(|f| f.to_vec()).collect();
    lists.push(vec![1, 8, 7, 6, 5, 4, 3, 2]);
    // Vertices 2, 4, 6, 8 have degree 2; the graph test names the first.
    let refused = koebe(&graph(&lists), &KoebeOptions::default(), &Silent).unwrap_err();
    assert_eq!(
        refused,
        KoebeError::LowDegree {
            vertex: VertexId::new(2),
            degree: 2
        }
    );
    // A ladder between two poles closed to a ring of two blocks: 0 and 1 separate {2, 3, 4} from
    // {5, 6, 7}.
    let block = |a: u32| -> Vec<Vec<u32>> {
        vec![
            vec![0, a, a + 1],
            vec![0, a + 1, a + 2],
            vec![a, 1, a + 1],
            vec![a + 1, 1, a + 2],
        ]
    };
    let mut lists = block(2);
    lists.extend(block(5));
    lists.extend([vec![0, 4, 1, 5], vec![0, 7, 1, 2]]);
    match koebe(&graph(&lists), &KoebeOptions::default(), &Silent).unwrap_err() {
        KoebeError::SeparatingPair { vertices, faces } => {
            assert_eq!(vertices, [0, 1].map(VertexId::new));
            assert_eq!(faces, [8, 9].map(FaceId::new));
        }
        other => panic!("{other}"),
    }
}

#[test]
fn defects_are_those_of_the_mesh() {
    let cube = solve(&prism(4));
    let grown = Koebe {
        mesh: cube.mesh.mapped(|p| p * 1.1),
        ..cube.clone()
    };
    let defects = KoebeDefects::of(&grown.mesh, &grown.face_poles);
    assert!(
        (defects.tangency - 0.1).abs() < 1e-14
            && (defects.planarity - 0.1 * FRAC_1_SQRT_2).abs() < 1e-14
    );
    // A unit cube moved up by 3: its edges' lines touch other spheres, and the upright ones do not
    // hold their closest points.
    let moved = cube.mesh.with_positions(
        cube.mesh
            .positions
            .map(|p| p + Vec3::z() * (3.0 * FRAC_1_SQRT_2)),
    );
    assert_eq!(
        KoebeDefects::of(&moved, &cube.face_poles).untouched_edges,
        4
    );
}

/// The Koebe mesh is laid over a lattice on the sphere, wherever that lies, and keeps its size at
/// the rim: the south pole, from where nothing can be projected, too.
#[test]
fn a_lattice_on_the_sphere_is_covered() {
    let edge = 0.05;
    let lattice = hexagon_patch(4);
    let north = lattice.positions.map(|p| {
        let w = p * edge;
        Vec3::new(2.0 * w.x, 2.0 * w.y, 1.0 - w.norm_squared()) / (1.0 + w.norm_squared())
    });
    let half_turn = |p: &Vec3| Vec3::new(p.x, -p.y, -p.z);
    let tilted = |p: &Vec3| nalgebra::Rotation3::from_euler_angles(0.7, -1.1, 0.3) * p;
    for positions in [north.clone(), north.map(half_turn), north.map(tilted)] {
        let given = lattice.with_positions(positions);
        let options = KoebeOptions {
            boundary: BoundaryCondition::Sphere,
            ..KoebeOptions::default()
        };
        let made = koebe(&given, &options, &Silent).unwrap();
        assert_sound(&made);
        for (x, p) in made.mesh.positions.iter().zip(&given.positions) {
            let off = (x.normalize() - p).norm() / edge;
            assert!(off < 0.1, "{off} edges off");
        }
    }
}
