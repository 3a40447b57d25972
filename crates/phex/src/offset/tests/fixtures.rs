//! Meshes with three faces at every inner vertex.

use crate::optimise::tests::fixtures::{brick_faces, mesh as used};
use phex_mesh::{HexMesh, Vec3, VertexId};

/// A mesh from coordinates and faces.
pub fn mesh(points: &[[f64; 3]], faces: &[&[u32]]) -> HexMesh {
    HexMesh::new(points.iter().map(|&p| Vec3::from(p)).collect(), faces).unwrap()
}

/// The prism over a polygon, from `z = 0` to `z = height`; closed, normals pointing out.
pub fn prism(polygon: &[[f64; 2]], height: f64) -> HexMesh {
    let n = polygon.len() as u32;
    let level = |z: f64| polygon.iter().map(move |&[x, y]| [x, y, z]);
    let points: Vec<[f64; 3]> = level(0.0).chain(level(height)).collect();
    let mut faces: Vec<Vec<u32>> = vec![(0..n).rev().collect(), (n..2 * n).collect()];
    for i in 0..n {
        let j = (i + 1) % n;
        faces.push(vec![i, j, n + j, n + i]);
    }
    let faces: Vec<&[u32]> = faces.iter().map(Vec::as_slice).collect();
    mesh(&points, &faces)
}

/// A box.
pub fn cuboid(a: f64, b: f64, c: f64) -> HexMesh {
    prism(&[[0.0, 0.0], [a, 0.0], [a, b], [0.0, b]], c)
}

/// A prism over an L: one edge is concave.
pub fn l_prism() -> HexMesh {
    let l = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    prism(&l, 1.5)
}

/// A regular dodecahedron with inradius 1, as the dual of the icosahedron.
pub fn dodecahedron() -> HexMesh {
    let golden = 0.5 * (1.0 + 5.0f64.sqrt());
    let mut normals = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (1.0, -golden),
        (-1.0, golden),
        (-1.0, -golden),
    ] {
        normals.push(Vec3::new(0.0, a, b).normalize());
        normals.push(Vec3::new(a, b, 0.0).normalize());
        normals.push(Vec3::new(b, 0.0, a).normalize());
    }
    polar_dual(&normals)
}

/// The polyhedron of the tangent planes of the unit sphere at some points of it, no four of them
/// meeting in a point.
pub fn polar_dual(normals: &[Vec3]) -> HexMesh {
    let n = normals.len();
    let mut points = Vec::new();
    let mut holders: Vec<[usize; 3]> = Vec::new();
    for i in 0..n {
        for j in i + 1..n {
            for k in j + 1..n {
                let rows = nalgebra::Matrix3::from_columns(&[normals[i], normals[j], normals[k]]);
                let Some(inverse) = rows.transpose().try_inverse() else {
                    continue;
                };
                let p: Vec3 = inverse * Vec3::repeat(1.0);
                if normals.iter().all(|m| m.dot(&p) <= 1.0 + 1e-9) {
                    points.push(p);
                    holders.push([i, j, k]);
                }
            }
        }
    }
    let face = |f: usize| {
        let axis = normals[f];
        let across = axis.cross(&Vec3::new(0.3, -0.5, 0.8)).normalize();
        let angle = |v: &u32| {
            let d = points[*v as usize] - axis;
            d.dot(&axis.cross(&across)).atan2(d.dot(&across))
        };
        let mut corners: Vec<u32> = (0..points.len() as u32)
            .filter(|&v| holders[v as usize].contains(&f))
            .collect();
        corners.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
        corners
    };
    let faces: Vec<Vec<u32>> = (0..n).map(face).collect();
    HexMesh::new(points, &faces).unwrap()
}

/// Points spread over the unit sphere, in no symmetric position.
pub fn spread_points(n: usize) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    let point = |k: usize| {
        let z = 1.0 - (2.0 * k as f64 + 1.0) / n as f64;
        let (r, t) = ((1.0 - z * z).sqrt(), golden * k as f64 + 0.1);
        Vec3::new(r * t.cos(), r * t.sin(), z)
    };
    (0..n).map(point).collect()
}

/// Hexagons in rows on a parametrised surface, over the unit square; `kink` lifts and lowers every
/// other vertex by that part of a row.
pub fn patch(
    columns: usize,
    rows: usize,
    kink: f64,
    surface: impl Fn(f64, f64) -> Vec3,
) -> HexMesh {
    let grid = (0..=rows).flat_map(|j| (0..columns).map(move |i| (i, j)));
    let place = |(i, j): (usize, usize)| {
        let up = if (i + j) % 2 == 0 { kink } else { -kink };
        surface(
            i as f64 / (columns - 1) as f64,
            (j as f64 + up) / rows as f64,
        )
    };
    used(
        &grid.map(place).collect::<Vec<_>>(),
        &brick_faces(columns, rows, false),
    )
}

/// The same mesh, each point mapped.
pub fn mapped(mesh: &HexMesh, f: impl Fn(Vec3) -> Vec3) -> HexMesh {
    mesh.with_positions(mesh.positions.map(|p| f(*p)))
}

/// Largest distance between corresponding vertices.
pub fn distance(a: &HexMesh, b: &HexMesh) -> f64 {
    let pairs = a.positions.iter().zip(&b.positions);
    pairs.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

/// Largest angle between corresponding edges.
pub fn parallelism(a: &HexMesh, b: &HexMesh) -> f64 {
    let vector = |m: &HexMesh, [v, w]: [VertexId; 2]| m.position(w) - m.position(v);
    let topology = a.topology();
    let angles = topology.edges().map(|e| {
        let ends = topology.edge_vertices(e);
        let (p, q) = (vector(a, ends), vector(b, ends));
        p.cross(&q).norm() / (p.norm() * q.norm())
    });
    angles.fold(0.0, f64::max)
}
