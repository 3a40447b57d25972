//! Meshes that tests of several folders share.

use phex_mesh::{HexMesh, PerEdge, Topology, Vec3};
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Triangles of an icosahedron with outward orientation.
pub fn icosahedron() -> Vec<[u32; 3]> {
    let ring = |k: u32, i: u32| 1 + 5 * k + i % 5;
    let caps = (0..5).flat_map(|i| {
        [
            [0, ring(0, i), ring(0, i + 1)],
            [11, ring(1, i + 1), ring(1, i)],
        ]
    });
    let belt = (0..5).flat_map(|i| {
        [
            [ring(0, i), ring(1, i), ring(0, i + 1)],
            [ring(0, i + 1), ring(1, i), ring(1, i + 1)],
        ]
    });
    caps.chain(belt).collect()
}

/// A mesh of given faces whose positions say nothing.
pub fn graph<F: AsRef<[u32]>>(faces: &[F]) -> HexMesh {
    let n = faces
        .iter()
        .flat_map(|f| f.as_ref())
        .max()
        .map_or(0, |&m| m as usize + 1);
    HexMesh::new(vec![Vec3::zeros(); n], faces).expect("a manifold")
}

/// One vertex per face, one face per vertex, of a closed mesh.
pub fn dual(mesh: &HexMesh) -> HexMesh {
    let t = mesh.topology();
    let ring = |v| t.faces_at(v).map(|f| f.index() as u32).collect();
    let faces: Vec<Vec<u32>> = t.vertices().map(ring).collect();
    HexMesh::new(mesh.centres().into_vec(), &faces).expect("the dual of a closed mesh is closed")
}

/// Every vertex cut off: one vertex per half-edge.
pub fn truncated(mesh: &HexMesh) -> HexMesh {
    let t = mesh.topology();
    let face = |f| {
        let two = |h| [h, t.twin(h).expect("a closed mesh")];
        t.face_half_edges(f)
            .flat_map(two)
            .map(|h| h.index() as u32)
            .collect()
    };
    let cut = |v| t.outgoing(v).map(|h| h.index() as u32).collect();
    let faces: Vec<Vec<u32>> = t.faces().map(face).chain(t.vertices().map(cut)).collect();
    graph(&faces)
}

/// A random triangulation of the sphere with `n` vertices: insertions at random, then ten random
/// flips per vertex. Degrees are very uneven.
pub fn random_triangulation(n: usize, seed: u64) -> Vec<[u32; 3]> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut triangles = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    for v in 4..n as u32 {
        let i = rng.random_range(0..triangles.len());
        let [a, b, c] = triangles[i];
        triangles[i] = [a, b, v];
        triangles.extend([[b, c, v], [c, a, v]]);
    }
    flip(&mut triangles, 10 * n, &mut rng);
    triangles
}

/// A subdivided icosahedron with about `n` vertices after `flips` random flips: tame at first.
pub fn flipped_icosphere(n: usize, flips: usize, seed: u64) -> Vec<[u32; 3]> {
    let mut triangles = icosahedron();
    while triangles.len() < 2 * n - 4 {
        triangles = subdivided(&triangles);
    }
    flip(&mut triangles, flips, &mut ChaCha8Rng::seed_from_u64(seed));
    triangles
}

fn subdivided(triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut next = triangles.iter().flatten().max().map_or(0, |m| m + 1);
    let mut middle = HashMap::new();
    let mut split = |a: u32, b: u32| {
        *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
            next += 1;
            next - 1
        })
    };
    let mut four = |&[a, b, c]: &[u32; 3]| {
        let [d, e, f] = [split(a, b), split(b, c), split(c, a)];
        [[a, d, f], [b, e, d], [c, f, e], [d, e, f]]
    };
    triangles.iter().flat_map(&mut four).collect()
}

/// Flips random edges wherever that makes no double edge.
fn flip(triangles: &mut [[u32; 3]], count: usize, rng: &mut ChaCha8Rng) {
    let mut left = HashMap::new();
    for (i, t) in triangles.iter().enumerate() {
        (0..3).for_each(|k| _ = left.insert((t[k], t[(k + 1) % 3]), i));
    }
    for _ in 0..count {
        let (i, k) = (rng.random_range(0..triangles.len()), rng.random_range(0..3));
        let [a, b, c] = [0, 1, 2].map(|m| triangles[i][(k + m) % 3]);
        let j = left[&(b, a)];
        let d = triangles[j]
            .into_iter()
            .find(|x| ![a, b].contains(x))
            .expect("a third corner");
        if left.contains_key(&(c, d)) {
            continue;
        }
        left.remove(&(a, b));
        left.remove(&(b, a));
        (triangles[i], triangles[j]) = ([c, a, d], [d, b, c]);
        for i in [i, j] {
            let t = triangles[i];
            (0..3).for_each(|k| _ = left.insert((t[k], t[(k + 1) % 3]), i));
        }
    }
}

/// The same mesh with vertices, faces and the starts of faces in another order, and where each
/// vertex went.
pub fn renumbered(mesh: &HexMesh, seed: u64) -> (HexMesh, Vec<u32>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut new: Vec<u32> = (0..mesh.topology().n_vertices() as u32).collect();
    new.shuffle(&mut rng);
    let mut positions = vec![Vec3::zeros(); new.len()];
    for (p, &v) in mesh.positions.iter().zip(&new) {
        positions[v as usize] = *p;
    }
    let mut faces = mesh.topology().face_lists();
    faces.shuffle(&mut rng);
    for face in &mut faces {
        face.iter_mut().for_each(|v| *v = new[*v as usize]);
        let shift = rng.random_range(0..face.len());
        face.rotate_left(shift);
    }
    (
        HexMesh::new(positions, &faces).expect("still a manifold"),
        new,
    )
}

/// Regular hexagons of edge 1 in the plane, `rings` rings about one.
pub fn hexagon_patch(rings: i64) -> HexMesh {
    let (mut numbers, mut positions) = (HashMap::new(), Vec::new());
    let mut faces = Vec::new();
    for q in -rings..=rings {
        for r in (-rings - q).max(-rings)..=(rings - q).min(rings) {
            let centre = Vec3::new(
                1.5 * q as f64,
                3f64.sqrt() * (r as f64 + 0.5 * q as f64),
                0.0,
            );
            let corner = |k: usize| {
                let angle = PI / 3.0 * k as f64;
                centre + Vec3::new(angle.cos(), angle.sin(), 0.0)
            };
            let mut number = |k: usize| {
                let p = corner(k);
                let key = ((p.x * 4.0).round() as i64, (p.y * 4.0).round() as i64);
                *numbers.entry(key).or_insert_with(|| {
                    positions.push(p);
                    positions.len() as u32 - 1
                })
            };
            faces.push((0..6).map(&mut number).collect::<Vec<u32>>());
        }
    }
    HexMesh::new(positions, &faces).expect("a patch")
}

/// A closed prism over a regular polygon.
pub fn prism(n: u32) -> HexMesh {
    let corner = |i: u32| {
        let angle = 2.0 * PI * f64::from(i % n) / f64::from(n);
        Vec3::new(angle.cos(), angle.sin(), f64::from(i / n))
    };
    let side = |i: u32| vec![i, (i + 1) % n, n + (i + 1) % n, n + i];
    let mut faces: Vec<Vec<u32>> = (0..n).map(side).collect();
    faces.push((0..n).rev().collect());
    faces.push((n..2 * n).collect());
    HexMesh::new((0..2 * n).map(corner).collect(), &faces).expect("a prism")
}

/// Quadrilaterals round a torus whose faces are planar: a polygon of trapezia turned about the
/// axis.
pub fn quad_torus(around: u32, across: u32) -> HexMesh {
    let position = |i: u32, j: u32| {
        let (u, v) = (
            2.0 * PI * f64::from(i) / f64::from(around),
            2.0 * PI * f64::from(j) / f64::from(across),
        );
        let radius = 2.0 + 0.7 * v.cos();
        Vec3::new(radius * u.cos(), radius * u.sin(), 0.7 * v.sin())
    };
    let id = |i: u32, j: u32| (i % around) * across + j % across;
    let cells = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let faces: Vec<[u32; 4]> = cells
        .clone()
        .map(|(i, j)| [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)])
        .collect();
    HexMesh::new(cells.map(|(i, j)| position(i, j)).collect(), &faces).expect("a torus")
}

/// Largest sine of the angle between an edge and its parallel, over all edges.
pub fn largest_turn(mesh: &HexMesh, other: &HexMesh) -> f64 {
    let direction = |m: &HexMesh, t: &Topology| {
        PerEdge::from_fn(t.n_edges(), |e| {
            let [a, b] = t.edge_vertices(e);
            (m.position(b) - m.position(a)).normalize()
        })
    };
    let t = mesh.topology();
    let (a, b) = (direction(mesh, t), direction(other, t));
    a.iter()
        .zip(&b)
        .map(|(a, b)| a.cross(b).norm())
        .fold(0.0, f64::max)
}
