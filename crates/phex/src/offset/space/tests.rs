use super::*;
use crate::test_meshes::*;
use nalgebra::DMatrix;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Rank by a dense singular value decomposition of the equations as they stand in the text: three
/// per face.
fn dense_dimension(mesh: &HexMesh) -> usize {
    let t = mesh.topology();
    let space = ParallelSpace::new(mesh).unwrap();
    let mut matrix = DMatrix::zeros(3 * t.n_faces(), t.n_edges());
    for h in t.half_edges() {
        for k in 0..3 {
            matrix[(3 * t.face(h).index() + k, t.edge(h).index())] =
                t.along(h, space.direction(t.edge(h))[k]);
        }
    }
    t.n_edges()
        - matrix
            .singular_values()
            .iter()
            .filter(|&&s| s > 1e-9)
            .count()
}

/// A mesh whose face planes touch the sphere at the vertices of a random triangulation of it.
fn tangent_planes(seed: u64) -> HexMesh {
    use crate::koebe::{KoebeOptions, koebe};
    let graph = dual(&graph(&random_triangulation(40, seed)));
    koebe(&graph, &KoebeOptions::default(), &crate::progress::Silent)
        .unwrap()
        .mesh
}

fn bumpy_patch() -> HexMesh {
    // Planes tangent to a paraboloid over a hexagonal lattice: its vertices are where three meet.
    let flat = hexagon_patch(4);
    flat.with_positions(
        flat.positions
            .map(|p| Vec3::new(p.x, p.y, 0.5 - 0.5 * (p.x * p.x + p.y * p.y))),
    )
}

#[test]
fn dimensions_of_known_meshes() {
    let dimension = |mesh: &HexMesh| ParallelSpace::new(mesh).unwrap().dimension();
    assert_eq!(dimension(&prism(4)), 3, "bricks");
    for n in [3, 5, 6, 11] {
        assert_eq!(
            dimension(&prism(n)),
            n as usize + 2 - 3,
            "a plane per face, less translations"
        );
    }
    assert_eq!(
        dimension(&graph_of_regular_octahedron()),
        1,
        "triangles grow together"
    );
    // An open patch of flat hexagons: 3 directions of every edge, two equations a face, all
    // independent.
    let flat = hexagon_patch(3);
    let (edges, faces) = (flat.topology().n_edges(), flat.topology().n_faces());
    assert_eq!(dimension(&flat), edges - 2 * faces);
    for seed in 0..3 {
        let mesh = tangent_planes(seed);
        assert_eq!(dimension(&mesh), mesh.topology().n_faces() - 3);
    }
}

fn graph_of_regular_octahedron() -> HexMesh {
    let axes = [
        Vec3::x(),
        -Vec3::x(),
        Vec3::y(),
        -Vec3::y(),
        Vec3::z(),
        -Vec3::z(),
    ];
    let faces = [
        [0u32, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    HexMesh::new(axes.to_vec(), &faces).unwrap()
}

#[test]
fn dimension_is_that_of_the_dense_equations() {
    for mesh in [
        prism(7),
        tangent_planes(5),
        hexagon_patch(2),
        bumpy_patch(),
        graph_of_regular_octahedron(),
    ] {
        let space = ParallelSpace::new(&mesh).unwrap();
        assert_eq!(space.dimension(), dense_dimension(&mesh));
        let rank = space.rank();
        assert!(
            rank.largest_zero < 1e-13 && rank.smallest_nonzero > 1e-4,
            "{rank:?}"
        );
    }
}

#[test]
fn torus_closes_round_both_ways() {
    let mesh = quad_torus(7, 6);
    let space = ParallelSpace::new(&mesh).unwrap();
    // Without the loops 7 + 6 - 2 + ... more lengths would close face by face.
    assert!(space.dimension() < dense_dimension(&mesh));
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let wish = PerEdge::from_fn(mesh.topology().n_edges(), |_| rng.random_range(0.5..2.0));
    let parallel = space.mesh_with_lengths(&wish);
    assert!(largest_turn(&mesh, &parallel) < 1e-12);
}

#[test]
fn annulus_has_a_closing_loop() {
    let mut faces = prism(6).topology().face_lists();
    faces.truncate(6);
    let tube = HexMesh::new(prism(6).positions.into_vec(), &faces).unwrap();
    // Lengths: one height; six widths, which must close in the plane.
    assert_eq!(ParallelSpace::new(&tube).unwrap().dimension(), 1 + 6 - 2);
}

#[test]
fn wishes_are_projected_onto_parallel_meshes() {
    for mesh in [tangent_planes(9), bumpy_patch(), prism(6)] {
        let space = ParallelSpace::new(&mesh).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let own = space.lengths(&mesh);
        let wish = own.map(|l| l * rng.random_range(0.9..1.1));
        let lengths = space.project_lengths(&wish);
        assert!(space.closure_defect(&lengths) < 1e-13);
        let moved = space.mesh_with_lengths(&lengths);
        assert!(largest_turn(&mesh, &moved) < 1e-11);
        for (a, b) in space.lengths(&moved).iter().zip(&lengths) {
            assert!((a - b).abs() < 1e-12);
        }
        // A parallel mesh is its own projection, and the projection is the closest point: the rest
        // is orthogonal.
        let again = space.closest(&moved.positions);
        assert!(
            again
                .positions
                .iter()
                .zip(&moved.positions)
                .all(|(a, b)| (a - b).norm() < 1e-13)
        );
        let nearby = mesh
            .positions
            .map(|p| p + Vec3::from_fn(|_, _| rng.random_range(-0.1..0.1)));
        let closest = space.closest(&nearby);
        let dot: f64 = (nearby.iter().zip(&closest.positions))
            .zip(&moved.positions)
            .map(|((wish, found), other)| (wish - found).dot(other))
            .sum();
        assert!(dot.abs() < 1e-10, "{dot}");
        assert!(largest_turn(&mesh, &closest) < 1e-11);
    }
}

#[test]
fn plane_shifts_span_the_space_of_a_closed_mesh() {
    let mesh = tangent_planes(3);
    let space = ParallelSpace::new(&mesh).unwrap();
    let shifts: Vec<PerEdge<f64>> = mesh
        .topology()
        .faces()
        .map(|f| {
            let mut lengths = PerEdge::filled(mesh.topology().n_edges(), 0.0);
            let shift = space.plane_shift(f).expect("closed, degree 3");
            assert_eq!(shift.len(), 2 * mesh.topology().valence(f));
            shift
                .into_iter()
                .for_each(|(e, change)| lengths[e] += change);
            assert!(space.closure_defect(&lengths) < 1e-9);
            lengths
        })
        .collect();
    let matrix = DMatrix::from_fn(shifts.len(), mesh.topology().n_edges(), |i, j| {
        shifts[i].as_slice()[j]
    });
    let largest = matrix.singular_values()[0];
    let rank = matrix
        .singular_values()
        .iter()
        .filter(|&&s| s > 1e-10 * largest)
        .count();
    assert_eq!(rank, space.dimension());
}

#[test]
fn plane_shift_moves_one_plane() {
    let mesh = prism(6);
    let space = ParallelSpace::new(&mesh).unwrap();
    let top = FaceId::new(7);
    let mut lengths = space.lengths(&mesh);
    space
        .plane_shift(top)
        .unwrap()
        .into_iter()
        .for_each(|(e, change)| lengths[e] += 0.5 * change);
    let moved = space.mesh_with_lengths(&lengths);
    assert!(moved.corners(top).all(|p| (p.z - 1.5).abs() < 1e-14));
    assert!(space.plane_shift(FaceId::new(0)).is_some());
    let patch = hexagon_patch(1);
    let flat = ParallelSpace::new(&patch).unwrap();
    assert!(
        patch
            .topology()
            .faces()
            .all(|f| flat.plane_shift(f).is_none()),
        "no edge leaves a flat mesh"
    );
}

#[test]
fn bent_faces_and_collapsed_edges_are_refused() {
    let mut bent = prism(4);
    bent.positions[VertexId::new(5)].z += 0.1;
    assert!(matches!(
        ParallelSpace::new(&bent),
        Err(ParallelError::NotPlanar { .. })
    ));
    let mut collapsed = prism(3);
    collapsed.positions[VertexId::new(1)] = collapsed.positions[VertexId::new(0)];
    let refused = ParallelSpace::new(&collapsed).unwrap_err();
    assert!(
        matches!(refused, ParallelError::NoDirection { .. }),
        "{refused}"
    );
}

#[test]
fn large_mesh() {
    let mesh = {
        use crate::koebe::{KoebeOptions, koebe};
        let graph = dual(&graph(&flipped_icosphere(2500, 1000, 1)));
        koebe(&graph, &KoebeOptions::default(), &crate::progress::Silent)
            .unwrap()
            .mesh
    };
    let space = ParallelSpace::new(&mesh).unwrap();
    assert_eq!(
        space.dimension(),
        mesh.topology().n_faces() - 3,
        "{:?}",
        space.rank()
    );
}
