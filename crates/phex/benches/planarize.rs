//! Time of making bent bricks planar, by number of faces; before it path, iterations and
//! factorisations.
//!
//! `t` is a wall on a torus (radii 3 and 1) with rows along the long way, which takes the fast
//! path, `e` one on the egg-crate `z = 0.3 sin x + 0.2 sin y`, where curvature across the rows
//! changes sign and faces need the barrier. `peers/peers.py` runs other programs on the same
//! meshes.

use divan::Bencher;
use phex::Silent;
use phex::optimise::{Optimised, planarize};
use phex_mesh::{HexMesh, Vec3};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};

const CASES: [&str; 6] = ["t500", "t5k", "t20k", "e500", "e5k", "e20k"];

fn main() {
    for case in CASES {
        let result = planar(&wall(case));
        let run = &result.run;
        println!(
            "{case}: {:?} path, {} iterations, {} factorisations, planarity {:.1e}, clearance {:.2}",
            run.path,
            run.iterations,
            run.factorisations,
            result.quality.planarity,
            result.quality.clearance
        );
    }
    divan::main();
}

fn wall(case: &str) -> HexMesh {
    match case {
        "t500" => torus_wall(32, 16),
        "t5k" => torus_wall(100, 50),
        "t20k" => torus_wall(200, 100),
        "e500" => crate_wall(22),
        "e5k" => crate_wall(70),
        _ => crate_wall(142),
    }
}

fn planar(mesh: &HexMesh) -> Optimised {
    planarize(mesh, None, &Default::default(), &Silent).expect("walls are regular")
}

/// A brick: two corners and the middle of its long side below, the same above.
fn brick(at: impl Fn(usize, usize) -> u32, i: usize, j: usize) -> [u32; 6] {
    let (low, high) = (j, j + 1);
    [
        at(i, low),
        at(i + 1, low),
        at(i + 2, low),
        at(i + 2, high),
        at(i + 1, high),
        at(i, high),
    ]
}

fn torus_wall(columns: usize, rows: usize) -> HexMesh {
    let line = 2 * columns;
    let place = |k: usize| {
        let (u, v) = (
            (k % line) as f64 / line as f64 * TAU,
            (k / line) as f64 / rows as f64 * TAU,
        );
        let ring = 3.0 + v.cos();
        Vec3::new(ring * u.cos(), ring * u.sin(), v.sin())
    };
    let at = |i: usize, j: usize| ((j % rows) * line + i % line) as u32;
    let row = |j: usize| (j % 2..line).step_by(2).map(move |i| brick(at, i, j));
    let faces: Vec<[u32; 6]> = (0..rows).flat_map(row).collect();
    HexMesh::new((0..line * rows).map(place).collect(), &faces).expect("a torus")
}

fn crate_wall(n: usize) -> HexMesh {
    let line = 2 * n + 2;
    let place = |k: usize| {
        let (x, y) = (
            (k % line) as f64 * PI / n as f64,
            (k / line) as f64 * TAU / n as f64,
        );
        Vec3::new(x, y, 0.3 * x.sin() + 0.2 * y.sin())
    };
    let at = |i: usize, j: usize| (j * line + i) as u32;
    let row = |j: usize| (0..n).map(move |i| brick(at, 2 * i + j % 2, j));
    let faces: Vec<[u32; 6]> = (0..n).flat_map(row).collect();
    // The first and the last line have a point too many.
    let used: Vec<u32> = faces
        .iter()
        .flatten()
        .copied()
        .collect::<BTreeSet<_>>()
        .into_iter()
        .collect();
    let number = |v: u32| used.partition_point(|&u| u < v) as u32;
    let renumbered: Vec<[u32; 6]> = faces.iter().map(|f| f.map(number)).collect();
    let points = used.iter().map(|&v| place(v as usize)).collect();
    HexMesh::new(points, &renumbered).expect("a patch")
}

#[divan::bench(args = CASES, sample_count = 3, sample_size = 1)]
fn bricks_to_planar(bencher: Bencher, case: &str) {
    let mesh = wall(case);
    bencher.bench_local(|| planar(&mesh));
}
