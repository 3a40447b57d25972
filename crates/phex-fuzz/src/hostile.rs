//! Surfaces that no program should be given, and that every program is.

use crate::damage::{DAMAGES, noisy, turned};
use crate::raw_mesh::{RawMesh, RawPoint};
use crate::shapes::{
    graph, grid, klein_bottle, octahedron, revolution, scaled, sphere, subdivided, sum,
    tetrahedron, torus, tube, twisted_strip, voxels,
};
use std::f64::consts::{PI, TAU};

/// A file with a surface, and what has to become of it.
#[derive(Clone, Debug)]
pub struct HostileSurface {
    /// What it is; also the name of its file.
    pub name: String,
    /// The file's bytes.
    pub bytes: Vec<u8>,
    /// What is in the file, as far as it is a mesh, without damages that can be mended.
    pub mesh: RawMesh,
    /// Whether there is no surface in it that could be meshed.
    pub refused: bool,
}

/// Nothing can be made of these damages.
const HOPELESS: [&str; 4] = ["one-nan", "one-infinite", "huge-1e200", "tiny-1e-160"];

/// What these damages do can be mended: the surface is the one before.
const MENDABLE: [&str; 7] = [
    "faces-twice",
    "one-face-twice",
    "faces-twice-reversed",
    "not-welded",
    "nearly-welded",
    "degenerate-triangles",
    "t-junctions",
];

/// All of them, in a fixed order; names are different.
pub fn hostile_surfaces() -> Vec<HostileSurface> {
    let sound = sound_shapes();
    let count = sound.len();
    let damaged = DAMAGES.iter().enumerate().flat_map(|(k, (damage, apply))| {
        let chosen = (0..3).map(move |i| (3 * k + 5 * i) % count);
        let chosen: Vec<_> = chosen.map(|i| (sound[i].0, sound[i].1.clone())).collect();
        chosen.into_iter().map(move |(shape, mesh)| {
            let (refused, name) = (HOPELESS.contains(damage), format!("{shape}_{damage}"));
            let written = apply(mesh.clone());
            let is_mendable = MENDABLE.contains(damage);
            let meant = if is_mendable { mesh } else { written.clone() };
            (name, written, meant, refused)
        })
    });
    let named = |(name, mesh): (&str, RawMesh), refused| (name.to_owned(), mesh, refused);
    let given = strange_shapes()
        .into_iter()
        .map(|shape| named(shape, false));
    let none = no_surfaces().into_iter().map(|shape| named(shape, true));
    let as_they_are = given.chain(few_triangles()).chain(none);
    let all =
        damaged.chain(as_they_are.map(|(name, mesh, refused)| (name, mesh.clone(), mesh, refused)));
    all.enumerate()
        .map(|(k, (name, written, meant, refused))| HostileSurface {
            mesh: meant,
            ..in_a_file(k, (name, written, refused))
        })
        .collect()
}

/// Every fourth surface that survives text and single precision is in another format than OBJ.
fn in_a_file(k: usize, (name, mesh, refused): (String, RawMesh, bool)) -> HostileSurface {
    let (extension, bytes) = match k % 8 {
        3 => ("ply", mesh.to_ply().into_bytes()),
        5 => ("off", mesh.to_off().into_bytes()),
        7 if name.ends_with("_shuffled") => ("stl", mesh.to_stl()),
        _ => ("obj", mesh.to_obj().into_bytes()),
    };
    HostileSurface {
        name: format!("{k:03}_{name}.{extension}"),
        bytes,
        mesh,
        refused,
    }
}

/// Surfaces without fault, of every kind of curvature, boundary and genus.
fn sound_shapes() -> Vec<(&'static str, RawMesh)> {
    vec![
        ("plane", graph(10, |_, _| 0.0)),
        ("dome", graph(12, |x, y| 0.5 - 0.3 * (x * x + y * y))),
        ("saddle", graph(12, |x, y| 0.4 * (x * x - y * y))),
        ("sphere", sphere(3)),
        ("torus", torus([28, 14], 2.0, 0.8)),
        ("pipe", revolution([20, 10], |v| [1.0, 3.0 * v])),
        ("cone", revolution([20, 10], |v| [0.2 + v, 2.0 * v])),
        (
            "wave",
            graph(16, |x, y| 0.15 * (4.0 * x).sin() * (3.0 * y).cos()),
        ),
        ("annulus", revolution([28, 6], |v| [0.6 + v, 0.0])),
        (
            "helicoid",
            grid([8, 24], [false; 2], |u, v| {
                let (sin, cos) = (3.0 * PI * v).sin_cos();
                [(2.0 * u - 1.0) * cos, (2.0 * u - 1.0) * sin, 2.0 * v]
            }),
        ),
        (
            "catenoid",
            revolution([24, 12], |v| [(1.6 * v - 0.8).cosh(), 1.6 * v]),
        ),
    ]
}

/// Surfaces that are surfaces, and are hard.
fn strange_shapes() -> Vec<(&'static str, RawMesh)> {
    [
        closed_shapes(),
        open_shapes(),
        crossing_shapes(),
        uneven_shapes(),
    ]
    .concat()
}

fn closed_shapes() -> Vec<(&'static str, RawMesh)> {
    let frame = |[x, y, z]: [usize; 3]| [x, y, z].iter().filter(|c| **c == 1).count() <= 1;
    let knot = |t: f64| {
        let (a, b) = (2.0 * TAU * t, 3.0 * TAU * t);
        [
            (2.0 + b.cos()) * a.cos(),
            (2.0 + b.cos()) * a.sin(),
            b.sin(),
        ]
    };
    let dumbbell = |[x, y, z]: RawPoint| [4.0 * x, y * waist(x), z * waist(x)];
    vec![
        ("cube", subdivided(&subdivided(&voxels([1; 3], |_| true)))),
        ("octahedron-fine", subdivided(&subdivided(&octahedron()))),
        ("tetrahedron-fine", subdivided(&subdivided(&tetrahedron()))),
        ("genus-5-frame", subdivided(&voxels([3; 3], frame))),
        (
            "genus-5-plate",
            subdivided(&voxels([11, 3, 1], |[x, y, _]| x % 2 == 0 || y != 1)),
        ),
        (
            "genus-6-plate",
            voxels([7, 5, 1], |[x, y, _]| x % 2 == 0 || y % 2 == 0),
        ),
        ("stairs", subdivided(&voxels([5, 2, 5], |[x, _, z]| z <= x))),
        ("trefoil", tube([8, 60], 0.35, knot)),
        (
            "long-ellipsoid",
            sphere(3).mapped(|[x, y, z]| [10.0 * x, y, z]),
        ),
        (
            "disc-ellipsoid",
            sphere(3).mapped(|[x, y, z]| [x, y, 0.02 * z]),
        ),
        ("dumbbell", sphere(4).mapped(dumbbell)),
        ("thin-torus", torus([60, 6], 10.0, 0.1)),
        ("fat-torus", torus([30, 20], 1.0, 0.98)),
        ("hedgehog", spiky(sphere(3), 9, 1.5)),
        ("dented", spiky(sphere(3), 9, 0.3)),
        (
            "two-sheets",
            sphere(4).mapped(|[x, y, z]| [x, y, 0.004 * z + 0.6 * (x * x + y * y)]),
        ),
        ("hammered", noisy(sphere(3), 0.05)),
        ("cigar-1e4", sphere(3).mapped(|[x, y, z]| [1e4 * x, y, z])),
    ]
}

fn waist(x: f64) -> f64 {
    0.03 + x * x
}

/// Every `step`th vertex is moved out or in by a factor.
fn spiky(mut mesh: RawMesh, step: usize, factor: f64) -> RawMesh {
    let chosen = mesh.points.iter_mut().step_by(step);
    chosen.for_each(|p| *p = scaled(*p, factor));
    mesh
}

fn open_shapes() -> Vec<(&'static str, RawMesh)> {
    let spiral = |u: f64, v: f64| {
        let (sin, cos) = (5.0 * TAU * u).sin_cos();
        [(0.3 + u) * cos, (0.3 + u) * sin, 0.3 * v]
    };
    let comb = |[x, y, _]: RawPoint| y < 0.0 || (6.0 * x).rem_euclid(1.0) < 0.5;
    let star = |[x, y, z]: RawPoint| {
        let reach = 0.6 + 0.35 * (9.0 * y.atan2(x)).sin();
        [reach * x, reach * y, z]
    };
    vec![
        ("spiral", grid([160, 3], [false; 2], spiral)),
        (
            "ribbon-1e3",
            grid([200, 2], [false; 2], |u, v| {
                [100.0 * u, 0.1 * v, (9.0 * u).sin()]
            }),
        ),
        ("comb", kept(graph(24, |x, _| 0.1 * x * x), comb)),
        ("star", graph(30, |x, y| 0.2 * x * y).mapped(star)),
        (
            "50-holes",
            holed(graph(40, |x, y| 0.2 * (x * x + y * y)), 5),
        ),
        ("sieve", holed(sphere(4), 2)),
        ("nearly-closed", without_face(sphere(3), 17)),
        (
            "half-torus",
            kept(torus([30, 16], 2.0, 0.7), |p| p[0] > 0.01),
        ),
        ("two-turns", twisted_strip(40, 0.3, 2)),
        ("four-turns", twisted_strip(80, 0.2, 4)),
        (
            "pleats",
            graph(24, |x, _| 0.2 * ((5.0 * x).rem_euclid(2.0) - 1.0).abs()),
        ),
        ("fold-175", graph(12, |x, _| 20.0 * x.abs())),
        ("cliff", graph(16, |x, _| if x > 0.06 { 1.0 } else { 0.0 })),
        (
            "needle-mountain",
            graph(16, |x, y| 0.02 / (0.01 + x * x + y * y)),
        ),
        (
            "monkey-saddle",
            graph(16, |x, y| 0.5 * (x * x * x - 3.0 * x * y * y)),
        ),
        (
            "high-saddle",
            graph(20, |x, y| {
                0.3 * x.hypot(y).powi(3) * (5.0 * y.atan2(x)).cos()
            }),
        ),
        ("cone-tip", graph(16, |x, y| 1.0 - x.hypot(y))),
        ("long-pipe", revolution([8, 200], |v| [0.05, 20.0 * v])),
        ("short-pipe", revolution([60, 2], |v| [5.0, 0.1 * v])),
        ("funnel", revolution([24, 24], |v| [0.01 + v.powi(4), -v])),
        (
            "bellows",
            revolution([24, 40], |v| [1.0 + 0.3 * (8.0 * TAU * v).sin(), 3.0 * v]),
        ),
        ("slit", slit(graph(16, |x, y| 0.2 * (x * x - y)))),
        ("bumpy", noisy(graph(20, |_, _| 0.0), 0.01)),
    ]
}

/// The largest part of a surface that consists of faces whose centre is wanted, without faces that
/// hang on a corner alone.
fn kept(mesh: RawMesh, wanted: impl Fn(RawPoint) -> bool) -> RawMesh {
    let centre = |f: &Vec<usize>| {
        scaled(
            f.iter().fold([0.0; 3], |s, &v| sum(s, mesh.points[v])),
            1.0 / f.len() as f64,
        )
    };
    let faces = mesh
        .faces
        .iter()
        .filter(|f| wanted(centre(f)))
        .cloned()
        .collect();
    let points = mesh.points.clone();
    RawMesh { points, faces }.without_unused()
}

/// Holes of one vertex and its faces, `spacing` apart in the order of vertices where they don't
/// meet.
fn holed(mesh: RawMesh, spacing: usize) -> RawMesh {
    let mut near = vec![false; mesh.points.len()];
    let mut gone = vec![false; mesh.points.len()];
    for v in (0..mesh.points.len()).step_by(spacing) {
        let around: Vec<&Vec<usize>> = mesh.faces.iter().filter(|f| f.contains(&v)).collect();
        let ring: Vec<usize> = around.iter().copied().flatten().copied().collect();
        if around.len() >= 4 && is_inner(&mesh, v) && ring.iter().all(|&w| !near[w]) {
            gone[v] = true;
            ring.iter().for_each(|&w| near[w] = true);
        }
    }
    let faces = mesh
        .faces
        .iter()
        .filter(|f| f.iter().all(|&v| !gone[v]))
        .cloned()
        .collect();
    let points = mesh.points.clone();
    RawMesh { points, faces }.without_unused()
}

/// Whether as many faces as vertices are around a vertex.
fn is_inner(mesh: &RawMesh, v: usize) -> bool {
    let around: Vec<&Vec<usize>> = mesh.faces.iter().filter(|f| f.contains(&v)).collect();
    let mut ring: Vec<usize> = around.iter().copied().flatten().copied().collect();
    ring.sort_unstable();
    ring.dedup();
    ring.len() == around.len() + 1
}

fn without_face(mut mesh: RawMesh, face: usize) -> RawMesh {
    mesh.faces.remove(face);
    mesh
}

/// A grid over a square cut open along a line from its lower side to its middle.
fn slit(mut mesh: RawMesh) -> RawMesh {
    let cut: Vec<usize> = (0..mesh.points.len())
        .filter(|&v| mesh.points[v][0].abs() < 1e-9 && mesh.points[v][1] < -1e-9)
        .collect();
    for v in cut {
        mesh.points.push(mesh.points[v]);
        let new = mesh.points.len() - 1;
        for face in mesh.faces.iter_mut().filter(|f| f.contains(&v)) {
            let x: f64 = face.iter().map(|&w| mesh.points[w][0]).sum();
            if x > 0.0 {
                face.iter_mut().filter(|w| **w == v).for_each(|w| *w = new);
            }
        }
    }
    mesh
}

fn crossing_shapes() -> Vec<(&'static str, RawMesh)> {
    let eight = |u: f64, v: f64| {
        let t = TAU * u;
        [t.sin(), t.sin() * t.cos(), 2.0 * v]
    };
    vec![
        ("figure-eight", grid([40, 10], [true, false], eight)),
        ("spindle-torus", torus([30, 20], 0.6, 1.0)),
        ("horn-torus", torus([30, 21], 1.0, 1.0)),
        (
            "enneper",
            graph(24, |_, _| 0.0).mapped(|[x, y, _]| {
                let (x, y) = (2.2 * x, 2.2 * y);
                [
                    x - x.powi(3) / 3.0 + x * y * y,
                    y - y.powi(3) / 3.0 + x * x * y,
                    x * x - y * y,
                ]
            }),
        ),
        (
            "wound-twice",
            grid([50, 5], [true, false], |u, v| {
                let (sin, cos) = (2.0 * TAU * u).sin_cos();
                [(1.0 + v) * cos, (1.0 + v) * sin, 0.3 * (TAU * u).sin()]
            }),
        ),
        (
            "folded-flat",
            graph(16, |_, _| 0.0).mapped(|[x, y, _]| [x.abs(), y, 0.0]),
        ),
        // Straight down, faces of both sides would lie on one another and be there twice.
        (
            "squashed-sphere",
            sphere(3).mapped(|[x, y, z]| [x + 0.1 * z, y, 0.0]),
        ),
        (
            "inside-out",
            turned(sphere(3), |_| true).mapped(|[x, y, z]| [x, y, z * (2.0 * z * z - 1.0)]),
        ),
    ]
}

fn uneven_shapes() -> Vec<(&'static str, RawMesh)> {
    let dome = |x: f64, y: f64| [x, y, 0.5 - 0.4 * (x * x + y * y)];
    let uneven = |n: [usize; 2], f: fn(f64) -> f64| {
        grid(n, [false; 2], move |u, v| {
            dome(2.0 * f(u) - 1.0, 2.0 * v - 1.0)
        })
    };
    vec![
        ("sampled-1e2", uneven([20, 12], |u| u.powi(4))),
        (
            "sampled-1e4",
            uneven([20, 12], |u| 10f64.powf(4.0 * (u - 1.0))),
        ),
        (
            "sampled-1e8",
            uneven([24, 12], |u| 10f64.powf(8.0 * (u - 1.0))),
        ),
        ("strips-1-to-100", uneven([200, 2], |u| u)),
        ("strips-1-to-1000", uneven([1, 1000], |u| u)),
        (
            "one-side-fine",
            fine_in_a_corner(graph(6, |x, y| 0.3 * x * y), 6),
        ),
        ("fan-of-200", fan_about_a_point(200)),
        (
            "poles",
            revolution([40, 20], |v| [(PI * v).sin() + 1e-9, (PI * v).cos()]),
        ),
        ("quads-not-planar", quads(8)),
        ("polygon-of-300", polygon(300, |_| 1.0)),
        (
            "star-polygon",
            polygon(60, |k| if k % 2 == 0 { 1.0 } else { 0.4 }),
        ),
        ("coarse-torus", torus([4, 3], 2.0, 1.0)),
        ("coarse-pipe", revolution([3, 1], |v| [1.0, v])),
        (
            "skew-grid",
            graph(12, |x, y| 0.2 * x * y).mapped(|[x, y, z]| [x + 20.0 * y, y, z]),
        ),
    ]
}

/// A corner that is cut finer and finer.
fn fine_in_a_corner(mut mesh: RawMesh, times: usize) -> RawMesh {
    for _ in 0..times {
        let last = mesh.faces.pop().expect("there are faces");
        let centre = scaled(
            last.iter().fold([0.0; 3], |s, &v| sum(s, mesh.points[v])),
            1.0 / 3.0,
        );
        mesh.points.push(centre);
        let new = mesh.points.len() - 1;
        mesh.faces
            .extend([0, 1, 2].map(|k| vec![last[k], last[(k + 1) % 3], new]));
    }
    mesh
}

fn fan_about_a_point(n: usize) -> RawMesh {
    let rim = (0..n).map(|k| {
        let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
        [cos, sin, 0.1 * (2.0 * cos * sin)]
    });
    let points = std::iter::once([0.0; 3]).chain(rim).collect();
    let faces = (0..n).map(|k| vec![0, 1 + k, 1 + (k + 1) % n]).collect();
    RawMesh { points, faces }
}

fn quads(n: usize) -> RawMesh {
    let pairs = graph(n, |x, y| 0.3 * (3.0 * x * y).sin());
    let quad = |two: &[Vec<usize>]| vec![two[0][0], two[0][1], two[0][2], two[1][2]];
    RawMesh {
        faces: pairs.faces.chunks(2).map(quad).collect(),
        points: pairs.points,
    }
}

fn polygon(n: usize, radius: impl Fn(usize) -> f64) -> RawMesh {
    let corner = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
        [radius(k) * cos, radius(k) * sin, 0.0]
    };
    RawMesh {
        points: (0..n).map(corner).collect(),
        faces: vec![(0..n).collect()],
    }
}

/// Strips of one to twelve triangles, flat and bent, and the smallest closed surfaces.
fn few_triangles() -> Vec<(String, RawMesh, bool)> {
    let strip = |n: usize, bent: f64| {
        let point = |k: usize| [0.5 * k as f64, (k % 2) as f64, bent * (k as f64).powi(2)];
        let triangle = |k: usize| {
            if k.is_multiple_of(2) {
                [k, k + 2, k + 1]
            } else {
                [k, k + 1, k + 2]
            }
        };
        let triangles: Vec<_> = (0..n).map(triangle).collect();
        RawMesh::triangles((0..n + 2).map(point).collect(), &triangles)
    };
    let flat = (1..=12).map(|n| (format!("{n}-triangles"), strip(n, 0.0), false));
    let bent = (2..=12)
        .step_by(2)
        .map(|n| (format!("{n}-bent-triangles"), strip(n, 0.03), false));
    let needle = RawMesh::triangles(
        vec![[0.0; 3], [1e4, 0.0, 0.0], [5e3, 1.0, 0.0]],
        &[[0, 1, 2]],
    );
    let closed = [
        ("tetrahedron", tetrahedron()),
        ("octahedron", octahedron()),
        ("needle", needle),
    ];
    let closed = closed.map(|(name, mesh)| (name.to_owned(), mesh, false));
    flat.chain(bent).chain(closed).collect()
}

/// What is no surface, or has no area.
fn no_surfaces() -> Vec<(&'static str, RawMesh)> {
    let ball = || sphere(2);
    let at = |x: f64| ball().mapped(|p| sum(p, [x, 0.0, 0.0]));
    vec![
        ("moebius", twisted_strip(30, 0.3, 1)),
        ("moebius-3", twisted_strip(60, 0.2, 3)),
        ("klein-bottle", klein_bottle(20)),
        (
            "balls-touching",
            joined_at(ball().beside(&at(2.0)), [1.0, 0.0, 0.0]),
        ),
        ("two-balls", ball().beside(&at(3.0))),
        (
            "ball-in-ball",
            ball().beside(&ball().mapped(|p| scaled(p, 0.5))),
        ),
        ("three-on-an-edge", book(3)),
        ("nine-on-an-edge", book(9)),
        (
            "bow-tie",
            joined_at(
                graph(4, |_, _| 0.0)
                    .beside(&graph(4, |_, _| 0.0).mapped(|p| sum(p, [2.0, 2.0, 0.0]))),
                [1.0, 1.0, 0.0],
            ),
        ),
        (
            "all-in-one-point",
            graph(4, |_, _| 0.0).mapped(|_| [1.0, 2.0, 3.0]),
        ),
        (
            "all-on-a-line",
            graph(4, |_, _| 0.0).mapped(|[x, _, _]| [x, 2.0 * x, 0.0]),
        ),
        (
            "no-faces",
            RawMesh {
                points: vec![[0.0; 3], [1.0; 3], [2.0, 0.0, 1.0]],
                faces: Vec::new(),
            },
        ),
        ("nothing", RawMesh::default()),
        ("random-faces", random_faces()),
        (
            "bow-tie-polygon",
            RawMesh {
                points: vec![[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
                faces: vec![vec![0, 1, 2, 3]],
            },
        ),
    ]
}

/// Vertices at a point become one.
fn joined_at(mut mesh: RawMesh, point: RawPoint) -> RawMesh {
    let is_there = |p: &RawPoint| (0..3).all(|k| (p[k] - point[k]).abs() < 1e-9);
    let first = mesh
        .points
        .iter()
        .position(is_there)
        .expect("a vertex is there");
    let there: Vec<bool> = mesh.points.iter().map(is_there).collect();
    mesh.faces
        .iter_mut()
        .flatten()
        .filter(|v| there[**v])
        .for_each(|v| *v = first);
    mesh.without_unused()
}

/// Triangles that have one edge in common.
fn book(pages: usize) -> RawMesh {
    let page = |k: usize| {
        let (sin, cos) = (TAU * k as f64 / pages as f64).sin_cos();
        [cos, sin, 0.5]
    };
    let points = [[0.0; 3], [0.0, 0.0, 1.0]]
        .into_iter()
        .chain((0..pages).map(page))
        .collect();
    RawMesh {
        points,
        faces: (0..pages).map(|k| vec![0, 1, 2 + k]).collect(),
    }
}

fn random_faces() -> RawMesh {
    let mesh = noisy(graph(5, |_, _| 0.0), 0.5);
    let n = mesh.points.len();
    let faces = (0..60).map(|k| vec![(7 * k) % n, (11 * k + 3) % n, (5 * k + 1) % n]);
    RawMesh {
        faces: faces
            .filter(|f| f[0] != f[1] && f[1] != f[2] && f[2] != f[0])
            .collect(),
        ..mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn there_are_enough_surfaces_and_they_have_names_of_their_own() {
        let all = hostile_surfaces();
        let names: BTreeSet<&String> = all.iter().map(|s| &s.name).collect();
        assert_eq!(names.len(), all.len());
        assert!(all.len() >= 150, "{} surfaces", all.len());
    }

    /// What is called a surface is one, but for what has been done to it.
    #[test]
    fn strange_shapes_are_oriented_manifolds() {
        for (name, mesh) in sound_shapes().into_iter().chain(strange_shapes()) {
            let torn = crate::referee::torn(&mesh);
            assert!(torn.is_empty(), "{name}: {torn:?}");
        }
    }

    #[test]
    fn genus_and_holes_are_as_their_names_say() {
        let shapes = strange_shapes();
        let of = |name: &str| {
            let mesh = &shapes.iter().find(|s| s.0 == name).expect("it is there").1;
            let kind = crate::referee::kind(mesh);
            (kind.euler_characteristic, kind.boundary_loops)
        };
        assert_eq!(of("genus-5-frame"), (-8, 0));
        assert_eq!(of("genus-5-plate"), (-8, 0));
        assert_eq!(of("genus-6-plate"), (-10, 0));
        assert!(of("50-holes").1 >= 50, "{:?}", of("50-holes"));
        assert_eq!(of("two-turns"), (0, 2));
    }
}
