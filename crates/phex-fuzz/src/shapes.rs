//! Surfaces that are right in themselves, sampled on grids.

use crate::raw_mesh::{RawMesh, RawPoint};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Triangles on a grid of `columns` x `rows` quadrilaterals over the unit square; a direction that
/// is closed has its last vertices for its first ones.
pub fn grid(
    [columns, rows]: [usize; 2],
    closed: [bool; 2],
    point: impl Fn(f64, f64) -> RawPoint,
) -> RawMesh {
    let across = if closed[0] { columns } else { columns + 1 };
    let along = if closed[1] { rows } else { rows + 1 };
    let at = |i: usize, j: usize| (i % across) + across * (j % along);
    let place = |k: usize| {
        let (i, j) = (k % across, k / across);
        point(i as f64 / columns as f64, j as f64 / rows as f64)
    };
    let pair = |k: usize| {
        let (i, j) = (k % columns, k / columns);
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [vec![a, b, c], vec![a, c, d]]
    };
    RawMesh {
        points: (0..across * along).map(place).collect(),
        faces: (0..columns * rows).flat_map(pair).collect(),
    }
}

/// A height above the square from -1 to 1.
pub fn graph(n: usize, height: impl Fn(f64, f64) -> f64) -> RawMesh {
    grid([n, n], [false; 2], |u, v| {
        let (x, y) = (2.0 * u - 1.0, 2.0 * v - 1.0);
        [x, y, height(x, y)]
    })
}

/// A tube of given radius about a closed curve.
pub fn tube(n: [usize; 2], radius: f64, curve: impl Fn(f64) -> RawPoint) -> RawMesh {
    grid(n, [true; 2], |u, v| {
        let h = 1e-4;
        let centre = curve(v);
        let tangent = unit(difference(curve(v + h), curve(v - h)));
        let across = unit(cross(tangent, [0.31, 0.17, 0.93]));
        let up = cross(across, tangent);
        let (sin, cos) = (TAU * u).sin_cos();
        sum(
            centre,
            sum(scaled(across, radius * cos), scaled(up, radius * sin)),
        )
    })
}

/// A surface of revolution about the z-axis, open at both ends, from its profile of radius and
/// height.
pub fn revolution(n: [usize; 2], profile: impl Fn(f64) -> [f64; 2]) -> RawMesh {
    grid(n, [true, false], |u, v| {
        let [r, z] = profile(v);
        [r * (TAU * u).cos(), r * (TAU * u).sin(), z]
    })
}

/// The unit sphere: an octahedron whose triangles are cut in four, `levels` times.
pub fn sphere(levels: usize) -> RawMesh {
    let round = |mesh: RawMesh| mesh.mapped(unit);
    (0..levels).fold(octahedron(), |mesh, _| round(subdivided(&mesh)))
}

/// A torus about the z-axis.
pub fn torus(n: [usize; 2], big: f64, small: f64) -> RawMesh {
    grid(n, [true; 2], |u, v| {
        let r = big + small * (TAU * v).cos();
        let (sin, cos) = (TAU * u).sin_cos();
        [r * cos, r * sin, small * (TAU * v).sin()]
    })
}

/// The regular octahedron.
pub fn octahedron() -> RawMesh {
    let points = [
        [1, 0, 0],
        [-1, 0, 0],
        [0, 1, 0],
        [0, -1, 0],
        [0, 0, 1],
        [0, 0, -1],
    ];
    let triangles = [
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    RawMesh::triangles(points.map(|p| p.map(f64::from)).to_vec(), &triangles)
}

/// A tetrahedron.
pub fn tetrahedron() -> RawMesh {
    let points = [[1, 1, 1], [-1, -1, 1], [-1, 1, -1], [1, -1, -1]];
    let triangles = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    RawMesh::triangles(points.map(|p| p.map(f64::from)).to_vec(), &triangles)
}

/// Each triangle cut in four at the middles of its sides.
pub fn subdivided(mesh: &RawMesh) -> RawMesh {
    let mut points = mesh.points.clone();
    let mut middles: HashMap<[usize; 2], usize> = HashMap::new();
    let mut faces = Vec::new();
    for face in &mesh.faces {
        let mut middle = |k: usize| {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                points.push(scaled(sum(points[a], points[b]), 0.5));
                points.len() - 1
            })
        };
        let [x, y, z] = [middle(0), middle(1), middle(2)];
        let corners = [[face[0], x, z], [x, face[1], y], [z, y, face[2]], [x, y, z]];
        faces.extend(corners.map(|f| f.to_vec()));
    }
    RawMesh { points, faces }
}

/// The skin of the cells of a box of unit cubes that are filled: closed, of any genus.
pub fn voxels([nx, ny, nz]: [usize; 3], filled: impl Fn([usize; 3]) -> bool) -> RawMesh {
    let is_filled = |c: [i64; 3]| {
        let inside = (0..3).all(|k| (0..[nx, ny, nz][k] as i64).contains(&c[k]));
        inside && filled(c.map(|x| x as usize))
    };
    let mut numbers: HashMap<[i64; 3], usize> = HashMap::new();
    let mut mesh = RawMesh::default();
    for cell in 0..nx * ny * nz {
        let c = [cell % nx, cell / nx % ny, cell / nx / ny].map(|x| x as i64);
        for (axis, side) in (0..6).map(|k| (k / 2, (k % 2) as i64)) {
            let mut beside = c;
            beside[axis] += 2 * side - 1;
            if !is_filled(c) || is_filled(beside) {
                continue;
            }
            let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[p, q]| {
                let mut corner = c;
                corner[axis] += side;
                corner[(axis + 1) % 3] += p;
                corner[(axis + 2) % 3] += q;
                *numbers.entry(corner).or_insert_with(|| {
                    mesh.points.push(corner.map(|x| x as f64));
                    mesh.points.len() - 1
                })
            });
            let [a, b, c, d] = corners;
            let ring = if side == 1 {
                [a, b, c, d]
            } else {
                [d, c, b, a]
            };
            mesh.faces.push(vec![ring[0], ring[1], ring[2]]);
            mesh.faces.push(vec![ring[0], ring[2], ring[3]]);
        }
    }
    mesh
}

/// A strip whose ends are joined after `half_turns` half turns; one-sided if they are odd.
pub fn twisted_strip(n: usize, width: f64, half_turns: usize) -> RawMesh {
    let turns = half_turns as f64;
    let mut strip = grid([n, 2], [false; 2], |u, v| {
        let (sin, cos) = (TAU * u).sin_cos();
        let (up, out) = (PI * turns * u).sin_cos();
        let side = width * (2.0 * v - 1.0);
        [
            (1.0 + side * out) * cos,
            (1.0 + side * out) * sin,
            side * up,
        ]
    });
    let across = n + 1;
    let joined = |v: usize| match (v % across, v / across) {
        (i, row) if i == n => across * (if half_turns % 2 == 1 { 2 - row } else { row }),
        _ => v,
    };
    strip
        .faces
        .iter_mut()
        .flatten()
        .for_each(|v| *v = joined(*v));
    strip.without_unused()
}

/// The Klein bottle that crosses itself like a figure of eight.
pub fn klein_bottle(n: usize) -> RawMesh {
    let mut bottle = grid([n, n], [false, true], |u, v| {
        let (a, b) = (TAU * u, TAU * v);
        let r = 2.0 + (a / 2.0).cos() * b.sin() - (a / 2.0).sin() * (2.0 * b).sin();
        let z = (a / 2.0).sin() * b.sin() + (a / 2.0).cos() * (2.0 * b).sin();
        [r * a.cos(), r * a.sin(), z]
    });
    let across = n + 1;
    for v in bottle.faces.iter_mut().flatten() {
        if *v % across == n {
            *v = across * ((n - *v / across) % n);
        }
    }
    bottle.without_unused()
}

/// A sum of vectors.
pub fn sum(a: RawPoint, b: RawPoint) -> RawPoint {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// A difference of vectors.
pub fn difference(a: RawPoint, b: RawPoint) -> RawPoint {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// A vector times a number.
pub fn scaled(a: RawPoint, s: f64) -> RawPoint {
    a.map(|x| x * s)
}

/// Inner product.
pub fn dot(a: RawPoint, b: RawPoint) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Cross product.
pub fn cross(a: RawPoint, b: RawPoint) -> RawPoint {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Length of a vector.
pub fn length(a: RawPoint) -> f64 {
    a[0].hypot(a[1]).hypot(a[2])
}

/// The vector of length 1 in a direction.
pub fn unit(a: RawPoint) -> RawPoint {
    scaled(a, 1.0 / length(a))
}
