//! Vertex normals against 80-digit references (`reference/vertex_normals.py`).

use phex::parallel_mesh::face_offset::angle_between;
use phex::parallel_mesh::{Displacement, NormalMethod, vertex_normal};
use phex_mesh::Vec3;
use std::collections::BTreeMap;

/// Largest relative error that is allowed.
const TOLERANCE: f64 = 1e-13;

struct Vertex {
    kind: String,
    slope: f64,
    normals: [Vec3; 3],
    angles: [f64; 3],
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
    let angles = std::array::from_fn(|i| angle_between(&edges[i], &edges[(i + 1) % 3], &normals[i]));
    Vertex {
        kind,
        slope: x[0],
        normals,
        angles,
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
        let found = vertex_normal(&vertex.normals, &vertex.angles);
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
        let found = vertex_normal(&vertex.normals, &vertex.angles);
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

/// Both ways are needed: folded vertices defeat the weights, flat ones the planes.
#[test]
fn every_way_has_its_vertices() {
    let chosen = |kind: &str, slope: f64| {
        let of_kind = vertices()
            .into_iter()
            .filter(|v| v.kind == kind && v.slope == slope);
        let methods = of_kind.map(|v| vertex_normal(&v.normals, &v.angles).method);
        methods.collect::<Vec<_>>()
    };
    let all = |methods: &[NormalMethod], m| methods.iter().all(|&x| x == m);
    assert!(all(&chosen("convex", 1e-9), NormalMethod::TangentWeights));
    assert!(all(&chosen("folded", 1e-7), NormalMethod::ThreePlanes));
}
