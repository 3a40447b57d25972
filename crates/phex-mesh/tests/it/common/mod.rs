//! Hand-made meshes with known figures.
#![allow(dead_code)] // Each test file uses some of these.

use phex_mesh::{FaceId, HexMesh, PerVertex, TriangleSurface, Vec3, VertexId};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};

/// Golden ratio.
pub const PHI: f64 = 1.618_033_988_749_895;

/// The convex solid with the given vertices and one face for each given outward normal.
fn convex_solid(points: &[Vec3], normals: &[Vec3]) -> HexMesh {
    let faces: Vec<Vec<u32>> = normals
        .iter()
        .map(|&n| supporting_face(points, n))
        .collect();
    HexMesh::new(points.to_vec(), &faces).expect("a convex solid is a manifold")
}

/// The vertices that are farthest along `normal`, counter-clockwise round it.
fn supporting_face(points: &[Vec3], normal: Vec3) -> Vec<u32> {
    let far = points
        .iter()
        .map(|p| p.dot(&normal))
        .fold(f64::MIN, f64::max);
    let on = |p: &Vec3| p.dot(&normal) > far - 1e-9;
    let mut face: Vec<u32> = (0..points.len() as u32)
        .filter(|&i| on(&points[i as usize]))
        .collect();
    let centre = face.iter().map(|&i| points[i as usize]).sum::<Vec3>() / face.len() as f64;
    let x = points[face[0] as usize] - centre;
    let y = normal.cross(&x).normalize() * x.norm();
    let angle = |i: &u32| {
        let d = points[*i as usize] - centre;
        d.dot(&y).atan2(d.dot(&x))
    };
    face.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    face
}

/// Every choice of signs and every cyclic shift of a point, without repetition.
fn signed_cycles(p: [f64; 3]) -> Vec<Vec3> {
    let mut points: Vec<Vec3> = Vec::new();
    for signs in 0..8 {
        let q: [f64; 3] = std::array::from_fn(|k| if signs >> k & 1 == 1 { -p[k] } else { p[k] });
        for shift in 0..3 {
            let r = Vec3::new(q[shift], q[(shift + 1) % 3], q[(shift + 2) % 3]);
            if points.iter().all(|s| (s - r).norm() > 1e-9) {
                points.push(r);
            }
        }
    }
    points
}

/// The regular dodecahedron with edge length `2 / PHI`.
pub fn dodecahedron() -> HexMesh {
    let points = [
        signed_cycles([1.0, 1.0, 1.0]),
        signed_cycles([0.0, 1.0 / PHI, PHI]),
    ];
    convex_solid(&points.concat(), &signed_cycles([0.0, PHI, 1.0]))
}

/// The truncated icosahedron with edge length 2; the pentagons come first.
pub fn truncated_icosahedron() -> HexMesh {
    let points = [
        signed_cycles([0.0, 1.0, 3.0 * PHI]),
        signed_cycles([1.0, 2.0 + PHI, 2.0 * PHI]),
        signed_cycles([PHI, 2.0, 2.0 * PHI + 1.0]),
    ];
    let pentagons = signed_cycles([0.0, 1.0, PHI]);
    let hexagons = [
        signed_cycles([1.0, 1.0, 1.0]),
        signed_cycles([0.0, PHI, 1.0 / PHI]),
    ]
    .concat();
    convex_solid(&points.concat(), &[pentagons, hexagons].concat())
}

/// Centre of cell `(column, row)` of the honeycomb with edge length 1 in the plane z = 0.
fn cell_centre(column: usize, row: usize) -> Vec3 {
    let shift = if row % 2 == 1 { 0.5 } else { 0.0 };
    Vec3::new((column as f64 + shift) * 3f64.sqrt(), 1.5 * row as f64, 0.0)
}

/// A parallelogram of regular hexagons with edge length 1 in the plane z = 0, normals up. The face
/// of cell `(column, row)` is number `row * columns + column`.
pub fn honeycomb(columns: usize, rows: usize) -> HexMesh {
    let mut numbers: HashMap<(i64, i64), u32> = HashMap::new();
    let mut points = Vec::new();
    let mut faces = Vec::new();
    for (row, column) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
        let corner = |k: u8| {
            let angle = FRAC_PI_6 + f64::from(k) * FRAC_PI_3;
            cell_centre(column, row) + Vec3::new(angle.cos(), angle.sin(), 0.0)
        };
        let face: Vec<u32> = (0..6)
            .map(corner)
            .map(|p| {
                let key = ((p.x * 1e6).round() as i64, (p.y * 1e6).round() as i64);
                *numbers.entry(key).or_insert_with(|| {
                    points.push(p);
                    points.len() as u32 - 1
                })
            })
            .collect();
        faces.push(face);
    }
    HexMesh::new(points, &faces).expect("a honeycomb is a manifold")
}

/// A prism over a regular polygon of `2 * half_sides` sides (circumradius 1), each side a column of
/// `rows` bricks of height 1, neighbouring columns shifted by half a brick: hexagons with two
/// corners of 180 degrees. Each face's list starts at its corner number `start` (up to 5; 0 is a
/// right-angled one, 2 and 5 are straight).
pub fn brick_prism(half_sides: u32, rows: u32, start: usize) -> HexMesh {
    let (sides, cuts) = (2 * half_sides, 2 * rows + 2);
    // The vertex at height `cut / 2` on the upright between columns `k - 1` and `k`.
    let number = |k: u32, cut: u32| (k % sides) * cuts + cut;
    let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(sides);
    let at = |k: u32, cut: u32| Vec3::new(angle(k).cos(), angle(k).sin(), 0.5 * f64::from(cut));
    let brick = |k: u32, row: u32| {
        let low = 2 * row + k % 2;
        let [right, left] = [k + 1, k].map(|k| [0, 1, 2].map(|step| number(k, low + step)));
        let mut face = [left[0], right[0], right[1], right[2], left[2], left[1]];
        face.rotate_left(start);
        face
    };
    let points = (0..sides).flat_map(|k| (0..cuts).map(move |cut| at(k, cut)));
    let faces: Vec<_> = (0..sides)
        .flat_map(|k| (0..rows).map(move |row| brick(k, row)))
        .collect();
    HexMesh::new(points.collect(), &faces).expect("a brick prism is a manifold")
}

/// The face of a honeycomb's cell `(column, row)`.
pub fn cell(columns: usize, column: usize, row: usize) -> FaceId {
    FaceId::new((row * columns + column) as u32)
}

/// A copy of a mesh with one vertex moved.
pub fn moved(mesh: &HexMesh, v: VertexId, by: Vec3) -> HexMesh {
    let mut positions = mesh.positions.clone();
    positions[v] += by;
    mesh.with_positions(positions)
}

/// A copy of a mesh with every position mapped.
pub fn mapped(mesh: &HexMesh, map: impl FnMut(&Vec3) -> Vec3) -> HexMesh {
    mesh.with_positions(mesh.positions.map(map))
}

/// Several meshes as one.
pub fn union(parts: &[HexMesh]) -> HexMesh {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    for part in parts {
        let offset = points.len() as u32;
        points.extend_from_slice(part.positions.as_slice());
        let lists = part.topology().face_lists();
        faces.extend(
            lists
                .iter()
                .map(|f| f.iter().map(|v| v + offset).collect::<Vec<u32>>()),
        );
    }
    HexMesh::new(points, &faces).expect("parts are manifolds")
}

/// A mesh with one face.
pub fn single(corners: &[[f64; 3]]) -> HexMesh {
    let all: Vec<u32> = (0..corners.len() as u32).collect();
    HexMesh::new(corners.iter().map(|&p| p.into()).collect(), &[all]).expect("one face")
}

/// The square `[-half, half]^2` at height `z` as `n * n` squares, normals up.
pub fn square_grid(n: u32, half: f64, z: f64) -> HexMesh {
    let faces: Vec<[u32; 4]> = grid_cells(n).collect();
    HexMesh::new(grid_points(n, half, z), &faces).expect("a grid is a manifold")
}

/// The same as a triangle surface.
pub fn square_surface(n: u32, half: f64) -> TriangleSurface {
    let triangles: Vec<[u32; 3]> = grid_cells(n)
        .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .collect();
    TriangleSurface::new(grid_points(n, half, 0.0), &triangles).expect("a grid is a manifold")
}

fn grid_points(n: u32, half: f64, z: f64) -> Vec<Vec3> {
    let at = |i: u32| half * (2.0 * f64::from(i) / f64::from(n) - 1.0);
    (0..=n)
        .flat_map(|j| (0..=n).map(move |i| Vec3::new(at(i), at(j), z)))
        .collect()
}

fn grid_cells(n: u32) -> impl Iterator<Item = [u32; 4]> {
    let corner = move |i: u32, j: u32| j * (n + 1) + i;
    let cell = move |i, j| {
        [
            corner(i, j),
            corner(i + 1, j),
            corner(i + 1, j + 1),
            corner(i, j + 1),
        ]
    };
    (0..n).flat_map(move |j| (0..n).map(move |i| cell(i, j)))
}

/// Positions of a mesh as a map, for editing.
pub fn positions(mesh: &HexMesh) -> PerVertex<Vec3> {
    mesh.positions.clone()
}
