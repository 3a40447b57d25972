//! What offsets take over from their mesh.

use super::fixtures::*;
use crate::offset::*;
use phex_mesh::{HexMesh, Violation, violations};

fn options() -> OffsetOptions {
    OffsetOptions::default()
}

/// Edges of 109 degrees between the normals.
fn tetrahedron() -> HexMesh {
    mesh(
        &[
            [1.0, 1.0, 1.0],
            [-1.0, -1.0, 1.0],
            [-1.0, 1.0, -1.0],
            [1.0, -1.0, -1.0],
        ],
        &[&[0, 2, 1], &[0, 1, 3], &[0, 3, 2], &[1, 2, 3]],
    )
}

#[test]
fn offsets_of_a_sharp_mesh_are_as_sharp() {
    let mesh = tetrahedron();
    let image = face_gauss_image(&mesh, &options()).unwrap();
    let inherited = Inheritance::of(&mesh, &options()).unwrap();
    // Every edge folds, and every face lies against the mean of its neighbours.
    assert_eq!(inherited.violations.len(), 6 + 4);
    assert_eq!(inherited.validity, options().validity);
    let safe = safe_distances(&mesh, &image, &options());
    // The planes have the distance 1 / sqrt 3 from the centre: no further inwards.
    let inner = 1.0 / 3f64.sqrt();
    assert!((safe.inward.distance - inner).abs() < 1e-3, "{safe:?}");
    let moved = layer(&mesh, &image, -0.5 * inner, &options()).unwrap();
    let half = distance(&mapped(&mesh, |p| 0.5 * p), &moved);
    assert!(half < 1e-15);
}

/// A wedge of 2 degrees between its large faces.
#[test]
fn nearly_folded_edges_have_offsets() {
    let mesh = prism(&[[0.0, 0.0], [4.0, -0.07], [4.0, 0.07]], 0.14);
    let image = face_gauss_image(&mesh, &options()).unwrap();
    let moved = layer(&mesh, &image, 0.01, &options()).unwrap();
    let error = distance_error(&mesh, &moved, OffsetKind::Face, 0.01).unwrap();
    assert!(error < 1e-14, "{error:e}");
}

/// A step far lower than panels should be: its offsets may not be half as low again.
#[test]
fn short_edges_are_measured_by_themselves() {
    let low = 0.02;
    let step = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
        [2.0, 1.0],
        [2.0, 1.0 + low],
        [0.0, 1.0 + low],
    ];
    let mesh = prism(&step, 1.0);
    let image = face_gauss_image(&mesh, &options()).unwrap();
    let inherited = Inheritance::of(&mesh, &options()).unwrap();
    let short = |v: &Violation| {
        matches!(
            v,
            Violation::CollapsedEdge { .. } | Violation::SmallClearance { .. }
        )
    };
    assert!(!inherited.violations.is_empty() && inherited.violations.iter().all(short));
    let wanted = 0.5 * low / mesh.mean_edge();
    assert!((inherited.validity.edge_length_rel - wanted).abs() < 1e-15);
    assert!(layer(&mesh, &image, 0.1, &options()).is_ok());
}

#[test]
fn a_mesh_that_crosses_itself_is_refused_as_such() {
    // The walls of the first prism stand in the second one.
    let crossed = {
        let (a, b) = (
            cuboid(1.0, 1.0, 1.0),
            mapped(&cuboid(1.0, 1.0, 3.0), |p| p * 0.7),
        );
        let mut points: Vec<_> = a.positions.iter().copied().collect();
        points.extend(b.positions.iter().copied());
        let shifted = |f: &[u32]| f.iter().map(|v| v + 8).collect::<Vec<u32>>();
        let faces = |m: &HexMesh| m.to_soup().faces;
        let mut all = faces(&a);
        all.extend(faces(&b).iter().map(|f| shifted(f)));
        HexMesh::new(points, &all).unwrap()
    };
    let first = violations(&crossed, None, &options().validity).swap_remove(0);
    assert!(matches!(first, Violation::Crossing { .. }), "{first}");
    let image = face_gauss_image(&crossed, &options()).unwrap();
    let refused = layer(&crossed, &image, 0.01, &options()).unwrap_err();
    assert!(matches!(&refused, OffsetError::MeshNotValid { first: f, .. } if **f == first));
    assert!(refused.to_string().contains("mesh itself"), "{refused}");
    let safe = safe_distances(&crossed, &image, &options());
    assert_eq!(
        (safe.outward.distance, safe.inward.limit),
        (0.0, Some(first))
    );
}
