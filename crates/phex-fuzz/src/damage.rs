//! What goes wrong with surfaces on their way from one program to the next.

use crate::raw_mesh::RawMesh;
use crate::shapes::{length, scaled, sum, unit};
use rand::Rng;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;

/// A name, and what it does to a mesh.
pub type Damage = (&'static str, fn(RawMesh) -> RawMesh);

/// Everything that can happen to a mesh.
pub const DAMAGES: [Damage; 35] = [
    ("far-1e6", |m| m.mapped(|p| sum(p, [1e6, -1e6, 1e6]))),
    ("far-1e9", |m| m.mapped(|p| sum(p, [1e9, 0.0, 0.0]))),
    ("far-1e14", |m| m.mapped(|p| sum(p, [0.0, 1e14, 0.0]))),
    ("tiny-1e-30", |m| m.mapped(|p| scaled(p, 1e-30))),
    ("tiny-1e-49", |m| m.mapped(|p| scaled(p, 1e-49))),
    ("tiny-1e-160", |m| m.mapped(|p| scaled(p, 1e-160))),
    ("huge-1e30", |m| m.mapped(|p| scaled(p, 1e30))),
    ("huge-1e49", |m| m.mapped(|p| scaled(p, 1e49))),
    ("huge-1e200", |m| m.mapped(|p| scaled(p, 1e200))),
    ("flat-1e-6", |m| m.mapped(|[x, y, z]| [x, y, 1e-6 * z])),
    ("thin-1e-3", |m| m.mapped(|[x, y, z]| [1e-3 * x, y, z])),
    ("thin-1e-8", |m| m.mapped(|[x, y, z]| [1e-8 * x, y, z])),
    ("noise-1e-12", |m| noisy(m, 1e-12)),
    ("noise-0.3%", |m| noisy(m, 3e-3)),
    ("noise-3%", |m| noisy(m, 3e-2)),
    ("noise-30%", |m| noisy(m, 0.3)),
    ("flipped", |m| turned(m, |_| true)),
    ("some-flipped", |m| turned(m, |k| k % 3 == 0)),
    ("one-flipped", |m| turned(m, |k| k == 5)),
    ("shuffled", shuffled),
    ("faces-twice", faces_twice),
    ("one-face-twice", one_face_twice),
    ("faces-twice-reversed", |m| {
        let f = turned(m.clone(), |_| true).faces;
        RawMesh {
            faces: [m.faces, f].concat(),
            ..m
        }
    }),
    ("not-welded", not_welded),
    ("nearly-welded", |m| noisy(not_welded(m), 1e-13)),
    ("isolated-vertices", isolated_vertices),
    ("degenerate-triangles", degenerate_triangles),
    ("collapsed-triangles", collapsed_triangles),
    ("t-junctions", t_junctions),
    ("needles", needles),
    ("spike", spike),
    ("one-nan", |m| one_coordinate(m, f64::NAN)),
    ("one-infinite", |m| one_coordinate(m, f64::INFINITY)),
    ("one-far-away", |m| one_coordinate(m, 1e8)),
    ("holes", holes),
];

fn random() -> ChaCha8Rng {
    ChaCha8Rng::seed_from_u64(7)
}

fn size(mesh: &RawMesh) -> f64 {
    mesh.points.iter().map(|&p| length(p)).fold(0.0, f64::max)
}

/// Every coordinate moved at random by up to a part of the mesh's size.
pub fn noisy(mesh: RawMesh, part: f64) -> RawMesh {
    let (mut random, range) = (random(), part * size(&mesh));
    mesh.mapped(|p| p.map(|x| x + random.random_range(-range..=range)))
}

/// Some faces the other way round.
pub fn turned(mut mesh: RawMesh, which: impl Fn(usize) -> bool) -> RawMesh {
    let faces = mesh.faces.iter_mut().enumerate();
    faces
        .filter(|(k, _)| which(*k))
        .for_each(|(_, f)| f.reverse());
    mesh
}

/// Vertices and faces in another order, faces from another corner.
fn shuffled(mesh: RawMesh) -> RawMesh {
    let mut random = random();
    let mut order: Vec<usize> = (0..mesh.points.len()).collect();
    order.shuffle(&mut random);
    let mut points = mesh.points.clone();
    order
        .iter()
        .zip(&mesh.points)
        .for_each(|(&to, &p)| points[to] = p);
    let mut faces = mesh.faces;
    faces.shuffle(&mut random);
    for face in &mut faces {
        face.iter_mut().for_each(|v| *v = order[*v]);
        let first = random.random_range(0..face.len());
        face.rotate_left(first);
    }
    RawMesh { points, faces }
}

fn faces_twice(mut mesh: RawMesh) -> RawMesh {
    mesh.faces.extend(mesh.faces.clone());
    mesh
}

fn one_face_twice(mut mesh: RawMesh) -> RawMesh {
    mesh.faces.push(mesh.faces[0].clone());
    mesh
}

/// Every face with vertices of its own.
fn not_welded(mesh: RawMesh) -> RawMesh {
    let mut apart = RawMesh::default();
    for face in &mesh.faces {
        let first = apart.points.len();
        apart.points.extend(face.iter().map(|&v| mesh.points[v]));
        apart.faces.push((first..first + face.len()).collect());
    }
    apart
}

fn isolated_vertices(mut mesh: RawMesh) -> RawMesh {
    let far = size(&mesh);
    mesh.points
        .extend((1..40).map(|k| [far * f64::from(k), 0.0, -far]));
    mesh
}

/// A triangle without area on an edge of the first face.
fn degenerate_triangles(mut mesh: RawMesh) -> RawMesh {
    let [a, b] = [mesh.faces[0][0], mesh.faces[0][1]];
    mesh.points
        .push(scaled(sum(mesh.points[a], mesh.points[b]), 0.5));
    mesh.faces.push(vec![a, mesh.points.len() - 1, b]);
    mesh
}

/// Triangles that have lost their area because corners came to lie on one another.
fn collapsed_triangles(mut mesh: RawMesh) -> RawMesh {
    for k in (0..mesh.faces.len()).step_by(17) {
        let [a, b] = [mesh.faces[k][0], mesh.faces[k][1]];
        mesh.points[b] = mesh.points[a];
    }
    mesh
}

/// Faces that are cut at the middle of a side, of which the face beside it knows nothing.
fn t_junctions(mut mesh: RawMesh) -> RawMesh {
    for k in (0..mesh.faces.len()).step_by(11) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.faces[k][i]);
        mesh.points
            .push(scaled(sum(mesh.points[a], mesh.points[b]), 0.5));
        let middle = mesh.points.len() - 1;
        mesh.faces[k] = vec![a, middle, c];
        mesh.faces.push(vec![middle, b, c]);
    }
    mesh
}

/// Every seventh face cut into three by a point next to a corner of it.
fn needles(mut mesh: RawMesh) -> RawMesh {
    for k in (0..mesh.faces.len()).step_by(7) {
        let [a, b, c] = [0, 1, 2].map(|i| mesh.faces[k][i]);
        let others = sum(mesh.points[b], mesh.points[c]);
        let near = sum(scaled(mesh.points[a], 1.0 - 2e-5), scaled(others, 1e-5));
        mesh.points.push(near);
        let new = mesh.points.len() - 1;
        mesh.faces[k] = vec![a, b, new];
        mesh.faces.extend([vec![b, c, new], vec![c, a, new]]);
    }
    mesh
}

/// One vertex drawn out by the size of the whole.
fn spike(mut mesh: RawMesh) -> RawMesh {
    let (far, k) = (size(&mesh), mesh.points.len() / 2);
    mesh.points[k] = sum(
        mesh.points[k],
        scaled(unit(sum(mesh.points[k], [0.1, 0.2, 1.0])), far),
    );
    mesh
}

fn one_coordinate(mut mesh: RawMesh, value: f64) -> RawMesh {
    let k = mesh.points.len() / 3;
    mesh.points[k][1] = value;
    mesh
}

/// Single faces left out that have no vertex in common.
fn holes(mesh: RawMesh) -> RawMesh {
    let mut touched: BTreeSet<usize> = BTreeSet::new();
    let mut faces = Vec::new();
    for (k, face) in mesh.faces.iter().enumerate() {
        let is_free = face.iter().all(|v| !touched.contains(v));
        if k % 13 == 6 && is_free {
            touched.extend(face);
        } else {
            faces.push(face.clone());
        }
    }
    RawMesh { faces, ..mesh }
}
