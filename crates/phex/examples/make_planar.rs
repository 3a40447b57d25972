//! Any polygon mesh with three faces at a vertex, made planar: a honeycomb that is draped over a
//! saddle.

use phex::Silent;
use phex::optimise::{OptimiseOptions, planarize};
use phex_mesh::{HexMesh, Vec3, measure};
use std::collections::HashMap;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = draped_honeycomb(10, 8)?;
    let before = measure(&mesh);
    let result = planarize(&mesh, None, &OptimiseOptions::default(), &Silent)?;
    let after = measure(&result.mesh);
    println!(
        "{} panels, {:?} after {} iterations, sound: {}",
        before.faces,
        result.outcome.status,
        result.outcome.iterations,
        result.is_sound()
    );
    println!(
        "planarity {:.1e} -> {:.1e} mean edges, least clearance {:.2} -> {:.2}",
        before.planarity.max, after.planarity.max, before.clearance.min, after.clearance.min
    );
    Ok(())
}

/// Regular hexagons of edge 1, lifted to `z = (x^2 - y^2) / 40`.
fn draped_honeycomb(columns: i32, rows: i32) -> Result<HexMesh, phex_mesh::TopologyError> {
    // Corners lie on a grid of half columns and half edges.
    const CORNERS: [[i32; 2]; 6] = [[1, 1], [0, 2], [-1, 1], [-1, -1], [0, -2], [1, -1]];
    let mut number: HashMap<[i32; 2], u32> = HashMap::new();
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let centre = [2 * column + row % 2 - columns, 3 * row - 3 * rows / 2];
        let face = CORNERS.map(|[x, y]| {
            let at = [centre[0] + x, centre[1] + y];
            *number.entry(at).or_insert_with(|| {
                positions.push(lifted(at));
                positions.len() as u32 - 1
            })
        });
        faces.push(face);
    }
    HexMesh::new(positions, &faces)
}

fn lifted([x, y]: [i32; 2]) -> Vec3 {
    let (x, y) = (0.75f64.sqrt() * f64::from(x), 0.5 * f64::from(y));
    Vec3::new(x, y, (x * x - y * y) / 40.0)
}
