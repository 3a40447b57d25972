//! Lattice positions by diffusing three waves and projecting them to a common phase, from coarse to fine.
//!
//! A lattice is the set where the waves `exp(2 pi i <g_m, z>)`, `m = 0, 1, 2`, are all 1. Each vertex holds the three
//! values of its own chart; a change of chart permutes (and conjugates) them. Repeating "diffuse for time `t`, project to
//! the nearest lattice phase" with falling `t` finds a position field whose dislocations sit only where size demands
//! (a diffusion-projection scheme in the manner of Merriman, Bence and Osher).

use super::lattice::{Charts, Plane, dot, reciprocal};
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{EdgeId, PerVertex, Topology};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Diffusion times in squared lattice spacings, and steps at each.
const SCHEDULE: [(f64, usize); 4] = [(1.5, 12), (0.5, 8), (0.15, 6), (0.05, 4)];
/// Positions tried in each direction of the lattice cell when a phase is projected.
const GRID: usize = 6;

/// Lattice offset of each vertex (position of a lattice point in the vertex's chart).
pub fn diffuse(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    seed: u64,
) -> Result<PerVertex<Plane>, NumericError> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let n = topology.n_vertices();
    let mut position: Vec<Plane> =
        (0..n).map(|_| Plane::new(random.random_range(-0.5..0.5), random.random_range(-0.5..0.5))).collect();
    let projector = Projector::new();
    let mut factor: Option<Cholesky> = None;
    for (time, steps) in SCHEDULE {
        let matrix = wave_matrix(topology, mesh, charts, time)?;
        match &mut factor {
            Some(f) => f.refactor(&matrix)?,
            None => {
                let mut fresh = Cholesky::analyse(matrix.pattern(), 6)?;
                fresh.refactor(&matrix)?;
                factor = Some(fresh);
            }
        }
        let factor = factor.as_ref().expect("factorised above");
        for _ in 0..steps {
            let mut x: Vec<f64> = position
                .iter()
                .zip(&mesh.mass)
                .flat_map(|(z, m)| waves(*z).map(|a| a * *m))
                .flat_map(|a| [a.re, a.im])
                .collect();
            factor.solve(&mut x);
            position = x.par_chunks_exact(6).map(|a| projector.project(a)).collect();
        }
    }
    Ok(PerVertex::from_vec(position))
}

fn waves(z: Plane) -> [Plane; 3] {
    [0, 1, 2].map(|m| Plane::from_polar(1.0, TAU * dot(reciprocal(m), z)))
}

/// `mass + time * (connection Laplacian of the waves)`, three complex unknowns per vertex in real form.
fn wave_matrix(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    time: f64,
) -> Result<SymmetricMatrix, NumericError> {
    let mut own: Vec<f64> = mesh.mass.as_slice().to_vec();
    for e in topology.edges() {
        for v in topology.edge_vertices(e) {
            own[v.index()] += time * mesh.weight[e];
        }
    }
    let diagonal = own.into_iter().enumerate().flat_map(|(v, d)| (0..6).map(move |k| (6 * v as u32 + k, d)));
    let diagonal = diagonal.map(|(i, d)| (i, i, d));
    let coupling = topology.edges().flat_map(|e| edge_entries(topology, mesh, charts, time, e));
    SymmetricMatrix::from_triplets(6 * topology.n_vertices(), diagonal.chain(coupling))
}

fn edge_entries(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    time: f64,
    e: EdgeId,
) -> impl Iterator<Item = (u32, u32, f64)> + use<> {
    let [i, j] = topology.edge_vertices(e).map(|v| 6 * v.index() as u32);
    let (transition, weight) = (charts.edge(e), time * mesh.weight[e]);
    (0..3usize).flat_map(move |m| {
        // Wave m of the origin is wave (m - turn) of the target, times the phase of the offset.
        let source = (m + 6 - transition.turn as usize) % 6;
        let sign = if source < 3 { 1.0 } else { -1.0 };
        let phase = Plane::from_polar(-weight, TAU * dot(reciprocal(m), transition.offset));
        let (r, c) = (i + 2 * m as u32, j + 2 * (source % 3) as u32);
        let block = [(0, 0, phase.re), (0, 1, -phase.im * sign), (1, 0, phase.im), (1, 1, phase.re * sign)];
        block.into_iter().map(move |(p, q, v)| ((r + p).max(c + q), (r + p).min(c + q), v))
    })
}

/// Finds the lattice offset whose three waves are closest to given values.
struct Projector {
    trial: Vec<(Plane, [Plane; 3])>,
    reciprocal: [Plane; 3],
}

impl Projector {
    fn new() -> Self {
        let w = Plane::from_polar(1.0, TAU / 6.0);
        let at = |i: usize| i as f64 / GRID as f64;
        let grid = (0..GRID).flat_map(|i| (0..GRID).map(move |k| (i, k)));
        let trial = grid.map(|(i, k)| w * at(k) + at(i)).map(|z| (z, waves(z))).collect();
        Self { trial, reciprocal: [0, 1, 2].map(reciprocal) }
    }

    fn project(&self, values: &[f64]) -> Plane {
        let value = [0, 1, 2].map(|m| Plane::new(values[2 * m], values[2 * m + 1]));
        let score = |w: &[Plane; 3]| -> f64 { w.iter().zip(&value).map(|(a, b)| dot(*a, *b)).sum() };
        let mut best = (f64::NEG_INFINITY, Plane::new(0.0, 0.0));
        for (z, w) in &self.trial {
            let s = score(w);
            if s > best.0 {
                best = (s, *z);
            }
        }
        (0..8).fold(best.1, |z, _| self.ascend(z, &value))
    }

    /// One damped Newton step towards the maximum of `sum Re(conj(a_m) wave_m(z))`.
    fn ascend(&self, z: Plane, value: &[Plane; 3]) -> Plane {
        let (mut gradient, mut bound) = (Plane::new(0.0, 0.0), 1e-9);
        for (g, a) in self.reciprocal.iter().zip(value) {
            let turned = a.conj() * Plane::from_polar(1.0, TAU * dot(*g, z));
            gradient -= g * (TAU * turned.im);
            bound += a.norm() * TAU * TAU * g.norm_sqr() * 0.5;
        }
        z + gradient / bound
    }
}
