//! Vertex normals against 80-digit references (`reference/vertex_normals.py`).

use phex::offset::{Displacement, NormalMethod, TrivalentVertex, vertex_normal};
use phex_mesh::Vec3;
use std::collections::BTreeMap;

/// Largest relative error that is allowed.
const TOLERANCE: f64 = 1e-13;

struct Vertex {
    kind: String,
    slope: f64,
    corner: TrivalentVertex,
    reference: Vec3,
}

fn vertices() -> Vec<Vertex> {
    let table = include_str!("reference/vertex_normals.txt");
    let lines = table.lines().filter(|l| !l.starts_with('#'));
    lines.map(parse).collect()
}

fn parse(line: &str) -> Vertex {
    let mut words = line.split_whitespace();
    let kind = words.next().unwrap().to_owned();
    let x: Vec<f64> = words.map(|w| w.parse().unwrap()).collect();
    let vector = |at: usize| Vec3::from_column_slice(&x[at..at + 3]);
    let edges = [vector(1), vector(4), vector(7)];
    let normals: [Vec3; 3] =
        std::array::from_fn(|i| edges[i].cross(&edges[(i + 1) % 3]).normalize() * x[10 + i]);
    Vertex {
        kind,
        slope: x[0],
        corner: TrivalentVertex { normals, edges },
        reference: vector(13),
    }
}

fn relative_error(found: &Displacement, vertex: &Vertex) -> f64 {
    (found.vector - vertex.reference).norm() / vertex.reference.norm()
}

#[test]
fn all_digits_at_every_slope() {
    let mut worst: BTreeMap<String, f64> = BTreeMap::new();
    for vertex in vertices() {
        let found = vertex_normal(&vertex.corner);
        let error = relative_error(&found, &vertex);
        let entry = worst.entry(vertex.kind.clone()).or_default();
        *entry = entry.max(error);
        assert!(
            error <= TOLERANCE,
            "{} at slope {:e}: relative error {error:e} by {found:?}",
            vertex.kind,
            vertex.slope
        );
    }
    assert_eq!(worst.len(), 7, "every kind of vertex is in the table");
    println!("largest relative errors: {worst:?}");
}

#[test]
fn the_estimate_covers_the_error() {
    for vertex in vertices() {
        let found = vertex_normal(&vertex.corner);
        let error = relative_error(&found, &vertex);
        assert!(
            error <= 4.0 * found.error && found.error <= 1e-11,
            "{} at slope {:e}: error {error:e}, estimate {:e}",
            vertex.kind,
            vertex.slope,
            found.error
        );
    }
}

/// No way is enough alone: folded vertices defeat weights and mitres, flat ones the planes.
#[test]
fn every_way_has_its_vertices() {
    let chosen = |kind: &str, slope: f64| {
        let of_kind = vertices()
            .into_iter()
            .filter(|v| v.kind == kind && v.slope == slope);
        let methods = of_kind.map(|v| vertex_normal(&v.corner).method);
        methods.collect::<Vec<_>>()
    };
    let has = |methods: &[NormalMethod], m| methods.contains(&m);
    assert!(!has(&chosen("convex", 1e-9), NormalMethod::ThreePlanes));
    assert!(!has(&chosen("t", 1e-9), NormalMethod::ThreePlanes));
    let folded = chosen("folded", 1e-7);
    assert!(folded.iter().all(|&m| m == NormalMethod::ThreePlanes));
    let all: Vec<_> = vertices()
        .iter()
        .map(|v| vertex_normal(&v.corner).method)
        .collect();
    assert!(has(&all, NormalMethod::TangentWeights) && has(&all, NormalMethod::MitrePlanes));
}

/// Two bricks of a row in one plane and the next row at an angle: nothing but the edges tells where
/// along the ridge the vertex goes, and the mitre keeps it upright over the ridge.
#[test]
fn coplanar_faces_leave_the_vertex_in_its_mitre() {
    let (sin, cos) = 0.3f64.sin_cos();
    let up = Vec3::z();
    let tilted = Vec3::new(0.0, -sin, cos);
    let corner = TrivalentVertex {
        normals: [up, up, tilted],
        edges: [Vec3::x(), Vec3::new(0.2, 1.0, 0.0), -Vec3::x()],
    };
    let found = vertex_normal(&corner);
    // In the mitre of the slanting edge: no component across it.
    let across = up.cross(&corner.edges[1]);
    assert!(found.vector.dot(&across).abs() < 1e-15, "{found:?}");
    assert!(found.residual < 1e-15 && found.error < 1e-14);
}
