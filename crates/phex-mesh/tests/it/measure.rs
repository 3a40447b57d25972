//! The measures on meshes whose figures are known in closed form.
use crate::common::*;
use nalgebra::Rotation3;
use phex_mesh::measure::planarity_diagonals;
use phex_mesh::{FaceId, HexMesh, MeshMeasures, Vec3, VertexId, deviation, measure};
use proptest::prelude::*;
use std::collections::BTreeMap;

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.abs().max(b.abs()).max(1.0)
}

#[test]
fn planar_honeycomb() {
    let m = measure(&honeycomb(5, 4));
    assert_eq!(
        (m.faces, m.interior_faces, m.hex, m.degree3),
        (20, 6, Some(1.0), 1.0)
    );
    assert_eq!(
        (m.euler_characteristic, m.boundary_loops, m.components),
        (1, 1, 1)
    );
    assert_eq!(m.face_sizes, BTreeMap::from([(6, 20)]));
    assert_eq!((m.faces_concave, m.faces_not_simple), (0, 0));
    assert!(m.planarity.max < 1e-15 && m.planarity_diagonals.max < 1e-15);
    assert!(close(m.mean_edge, 1.0) && close(m.edge_length.min, 1.0));
    assert!(close(m.angle.min, 120.0) && close(m.angle.max, 120.0));
    assert!(close(m.dihedral.min, 180.0) && close(m.dihedral.max, 180.0));
    assert!(close(m.clearance.min, 1.0) && close(m.clearance.max, 1.0));
    assert!(close(m.area, 20.0 * 1.5 * 3f64.sqrt()) && close(m.largest_face_over_area, 0.05));
}

#[test]
fn brick_prism_has_straight_corners() {
    let m = measure(&brick_prism(7, 5, 0));
    assert_eq!(
        (m.faces, m.euler_characteristic, m.boundary_loops),
        (70, 0, 2)
    );
    assert_eq!((m.hex, m.degree3, m.faces_concave), (Some(1.0), 1.0, 0));
    assert!(close(m.angle.min, 90.0));
    assert!(close(m.dihedral.max, 180.0) && close(m.dihedral.min, 180.0 - 360.0 / 14.0));
}

#[test]
fn regular_dodecahedron() {
    let m = measure(&dodecahedron());
    assert_eq!((m.vertices, m.edges, m.faces), (20, 30, 12));
    assert_eq!(
        (m.euler_characteristic, m.boundary_loops, m.components),
        (2, 0, 1)
    );
    assert_eq!((m.degree3, m.hex), (1.0, Some(0.0)));
    assert!(m.planarity.max < 1e-15);
    assert!(close(m.mean_edge, 2.0 / PHI) && close(m.edge_length.max, 1.0));
    assert!(close(m.angle.min, 108.0) && close(m.angle.max, 108.0));
    let expected = (-1.0 / 5f64.sqrt()).acos().to_degrees();
    assert!(close(m.dihedral.min, expected) && close(m.dihedral.max, expected));
    let area = 3.0 * (25.0 + 10.0 * 5f64.sqrt()).sqrt() * (2.0 / PHI).powi(2);
    assert!(close(m.area, area) && close(m.diagonal, 2.0 * PHI * 3f64.sqrt()));
}

#[test]
fn truncated_icosahedron_has_its_two_dihedral_angles() {
    let m = measure(&truncated_icosahedron());
    assert_eq!((m.vertices, m.edges, m.faces), (60, 90, 32));
    assert_eq!(m.face_sizes, BTreeMap::from([(5, 12), (6, 20)]));
    assert_eq!(m.hex, Some(20.0 / 32.0));
    assert!(m.planarity.max < 1e-15 && close(m.mean_edge, 2.0));
    assert!(close(
        m.dihedral.min,
        (-5f64.sqrt() / 3.0).acos().to_degrees()
    ));
    let hexagon_pentagon = (-((5.0 + 2.0 * 5f64.sqrt()) / 15.0).sqrt()).acos();
    assert!(close(m.dihedral.max, hexagon_pentagon.to_degrees()));
    assert!(close(m.angle.min, 108.0) && close(m.angle.max, 120.0));
}

#[test]
fn reentrant_edge_has_a_dihedral_angle_above_180() {
    // A valley: two squares that rise on both sides of the edge x = 0, at right angles to each
    // other.
    let points = [
        [0, 0, 0],
        [0, 1, 0],
        [-1, 1, 1],
        [-1, 0, 1],
        [1, 0, 1],
        [1, 1, 1],
    ];
    let points = points
        .map(|p: [i32; 3]| Vec3::from(p.map(f64::from)))
        .to_vec();
    let valley = HexMesh::new(points, &[[0, 1, 2, 3], [1, 0, 4, 5]]).unwrap();
    let m = measure(&valley);
    assert_eq!(m.dihedral.count, 1);
    assert!(close(m.dihedral.min, 270.0));
    assert!(close(
        measure(&mapped(&valley, |p| Vec3::new(p.x, p.y, -p.z)))
            .dihedral
            .min,
        90.0
    ));
}

#[test]
fn concave_faces_are_counted_apart_from_crossing_ones() {
    let arrow = [
        [0.0, 0.0, 0.0],
        [4.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 4.0, 0.0],
    ];
    let bow_tie = [
        [9.0, 0.0, 0.0],
        [11.0, 0.0, 0.0],
        [9.5, 2.0, 0.0],
        [11.5, 1.0, 0.0],
        [8.5, 2.5, 0.0],
    ];
    let m = measure(&union(&[single(&arrow), single(&bow_tie), honeycomb(1, 1)]));
    assert_eq!(
        (m.faces_concave, m.faces_concave_simple, m.faces_not_simple),
        (2, 1, 1)
    );
    assert_eq!(m.per_element.concave.as_slice(), [true, true, false]);
    assert_eq!(m.components, 3);
}

/// Largest distance to the total-least-squares plane of a regular hexagon (edge 1) with one corner
/// raised by `h`.
fn raised_hexagon_planarity(h: f64) -> f64 {
    // In the plane through the raised corner the covariance is [[3, h], [h, 5 h^2 / 6]]; across
    // it, 3.
    let (xx, zz) = (3.0, 5.0 * h * h / 6.0);
    let lambda = 2.0 * (xx * zz - h * h) / (xx + zz + ((xx - zz).powi(2) + 4.0 * h * h).sqrt());
    let slope = h / (xx - lambda);
    (5.0 * h / 6.0 - slope) / (1.0 + slope * slope).sqrt()
}

#[test]
fn raised_vertex_has_exactly_the_predicted_planarity() {
    let flat = honeycomb(4, 4);
    let v = flat.topology().face_vertices(cell(4, 1, 1))[0];
    for h in [1e-6, 1e-3, 0.3] {
        let m = measure(&moved(&flat, v, Vec3::z() * h));
        let edges = m.edges as f64;
        let mean_edge = (edges - 3.0 + 3.0 * (1.0 + h * h).sqrt()) / edges;
        assert!(close(m.mean_edge, mean_edge));
        let expected = raised_hexagon_planarity(h);
        assert!((m.planarity_length.max - expected).abs() < 1e-14 + 1e-12 * expected);
        assert!((m.planarity.max - expected / mean_edge).abs() < 1e-14 + 1e-12 * expected);
        let mut worst = m.planarity.worst[..3].to_vec();
        worst.sort();
        let mut faces: Vec<FaceId> = flat.topology().faces_at(v).collect();
        faces.sort();
        assert_eq!(worst, faces);
        let flat_faces = m
            .per_element
            .planarity_length
            .iter()
            .filter(|&&p| p < 1e-14)
            .count();
        assert_eq!(flat_faces, m.faces - 3);
    }
}

#[test]
fn planarity_by_diagonals() {
    let quad = |h: f64| {
        [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, h],
            [0.0, 1.0, 0.0],
        ]
        .map(Vec3::from)
    };
    let h = 0.1f64;
    let distance = h / (4.0 + 2.0 * h * h).sqrt();
    let mean_diagonal = 0.5 * ((2.0 + h * h).sqrt() + 2f64.sqrt());
    assert!(close(
        planarity_diagonals(&quad(h)),
        distance / mean_diagonal
    ));
    assert_eq!(planarity_diagonals(&quad(0.0)), 0.0);
    assert_eq!(planarity_diagonals(&quad(h)[..3]), 0.0);
    // Two of six quadruples of this rectangle with two corners of 180 degrees have parallel
    // diagonals.
    let brick = [
        [0.0, 0.0],
        [1.0, 0.0],
        [2.0, 0.0],
        [2.0, 1.0],
        [1.0, 1.0],
        [0.0, 1.0],
    ];
    let brick = brick.map(|[x, y]| Vec3::new(0.6 * x, 0.8 * x, y));
    assert!(planarity_diagonals(&brick) < 1e-15);
}

#[test]
fn deviation_of_a_shifted_square() {
    let (h, surface) = (0.1, square_surface(8, 2.0));
    let small = deviation(&square_grid(4, 1.0, h), &surface);
    let diagonal = 4.0 * 2f64.sqrt();
    assert!(close(small.diagonal, diagonal));
    assert!(close(small.deviation_max, h / diagonal) && close(small.deviation_rms, h / diagonal));
    assert!(close(small.coverage_max, (2.0 + h * h).sqrt() / diagonal));
    assert!(
        close(small.coverage_inner_max, h / diagonal),
        "within 1 of the border is left out"
    );
    assert!(small.same_topology);
    // The first surface vertex is a corner, and the four corners are the worst.
    assert_eq!(small.coverage.worst[..4], [0, 8, 72, 80].map(VertexId::new));
    let coarse = deviation(&square_grid(1, 1.0, h), &surface);
    assert_eq!(
        coarse.coverage_inner_max, 0.0,
        "no vertex is farther than 4 from the border"
    );
}

#[test]
fn deviation_finds_the_worst_vertex_and_other_topology() {
    let surface = square_surface(8, 2.0);
    let flat = square_grid(4, 1.0, 0.0);
    let d = deviation(&moved(&flat, VertexId::new(7), Vec3::z() * -0.5), &surface);
    assert!(close(d.deviation_max * d.diagonal, 0.5) && d.vertices.worst[0] == VertexId::new(7));
    assert!(
        close(d.face_centres.max * d.diagonal, 0.125)
            && close(d.vertex_distance[VertexId::new(7)], 0.5)
    );
    let twice = union(&[flat.clone(), mapped(&flat, |p| p + Vec3::z())]);
    assert!(!deviation(&twice, &surface).same_topology);
}

#[test]
fn coverage_respects_concave_faces() {
    // An L-shaped face leaves the notch uncovered; a fan from its first corner would cover it.
    let l = [
        [2.0, 2.0],
        [-2.0, 2.0],
        [-2.0, -2.0],
        [0.0, -2.0],
        [0.0, 0.0],
        [2.0, 0.0],
    ];
    let d = deviation(
        &single(&l.map(|[x, y]| [x, y, 0.0])),
        &square_surface(8, 2.0),
    );
    assert!(close(d.coverage_max * d.diagonal, 2.0) && d.coverage.worst[0] == VertexId::new(8));
}

fn relative_figures(m: &MeshMeasures) -> Vec<f64> {
    let summaries = [
        (m.planarity.max, m.planarity.mean),
        (m.planarity_diagonals.max, m.planarity_diagonals.p95),
        (m.edge_length.min, m.edge_length.p05),
        (m.clearance.min, m.clearance.mean),
        (m.angle.min, m.angle.p05),
        (m.dihedral.max, m.dihedral.mean),
        (m.face_area.max, m.largest_face_over_area),
    ];
    summaries.iter().flat_map(|&(a, b)| [a, b]).collect()
}

fn bumpy_honeycomb() -> HexMesh {
    let wave = |p: &Vec3| {
        Vec3::new(
            p.x + 0.1 * p.y.sin(),
            p.y,
            0.2 * (p.x * 0.7).sin() * (p.y * 0.9).cos(),
        )
    };
    mapped(&honeycomb(5, 5), wave)
}

proptest! {
    #[test]
    fn relative_figures_do_not_depend_on_the_frame(
        axis in prop::array::uniform3(-3.0..3.0), shift in prop::array::uniform3(-10.0..10.0), exponent in -6.0..6.0,
    ) {
        let mesh = bumpy_honeycomb();
        let (rotation, scale) = (Rotation3::new(Vec3::from(axis)), f64::powf(10.0, exponent));
        let other = mapped(&mesh, |p| (rotation * p + Vec3::from(shift)) * scale);
        let (a, b) = (measure(&mesh), measure(&other));
        for (x, y) in relative_figures(&a).into_iter().zip(relative_figures(&b)) {
            prop_assert!((x - y).abs() < 1e-9, "{x} {y}");
        }
        prop_assert_eq!(a.faces_concave, b.faces_concave);
        prop_assert_eq!(a.per_element.simple, b.per_element.simple);
        prop_assert!((b.mean_edge / scale - a.mean_edge).abs() < 1e-9);
    }
}

#[test]
fn infinite_coordinates_give_no_figures_but_an_answer() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mesh = moved(&honeycomb(3, 3), VertexId::new(7), Vec3::x() * bad);
        let m = measure(&mesh);
        assert!(!m.planarity.max.is_finite());
        assert!(m.faces_not_simple > 0);
    }
}
