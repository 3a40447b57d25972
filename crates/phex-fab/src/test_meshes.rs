//! Meshes for tests.

use phex_mesh::{HexMesh, Vec3};
use std::collections::HashMap;

/// A honeycomb of `rows` x `columns` hexagons of edge 1 with its vertices moved.
pub fn honeycomb(rows: i32, columns: i32, place: impl Fn(Vec3) -> Vec3) -> HexMesh {
    let mut numbers: HashMap<(i32, i32), u32> = HashMap::new();
    let (mut positions, mut faces) = (Vec::new(), Vec::new());
    let half = 0.75_f64.sqrt();
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        // In units of half the width and a quarter of the height.
        let (x, y) = (2 * column + row % 2, 6 * row);
        let ring = [(0, -4), (1, -2), (1, 2), (0, 4), (-1, 2), (-1, -2)];
        let face = ring.map(|(dx, dy)| {
            *numbers.entry((x + dx, y + dy)).or_insert_with(|| {
                positions.push(place(Vec3::new(
                    half * f64::from(x + dx),
                    0.25 * f64::from(y + dy),
                    0.0,
                )));
                positions.len() as u32 - 1
            })
        });
        faces.push(face);
    }
    HexMesh::new(positions, &faces).expect("a manifold")
}

/// A cuboid with normals pointing out.
pub fn cuboid(x: f64, y: f64, z: f64) -> HexMesh {
    let corner = |k: usize| {
        let far = |bit: usize, size: f64| if k & bit == 0 { 0.0 } else { size };
        Vec3::new(far(1, x), far(2, y), far(4, z))
    };
    let faces = [
        [2, 3, 1, 0],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [1, 3, 7, 5],
        [3, 2, 6, 7],
        [2, 0, 4, 6],
    ];
    HexMesh::new((0..8).map(corner).collect(), &faces).expect("a manifold")
}
