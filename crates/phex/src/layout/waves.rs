//! Lattice positions by diffusing three waves and projecting them to a common phase, from coarse to fine.
//!
//! A lattice is the set where the waves `exp(2 pi i <g_m, z>)`, `m = 0, 1, 2`, are all 1. Each vertex holds the three
//! values of its own chart; a change of chart permutes (and conjugates) them. Repeating "diffuse for time `t`, project to
//! the nearest lattice phase" with falling `t` finds a position field whose dislocations sit only where size demands
//! (a diffusion-projection scheme in the manner of Merriman, Bence and Osher).

use super::boundary::Pin;
use super::lattice::{Charts, Eisenstein, Plane, dot, reciprocal};
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{PerVertex, Topology, VertexId};
use phex_numeric::{ConjugateGradientOptions, conjugate_gradients};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Diffusion times in squared lattice spacings, and steps at each.
const SCHEDULE: [(f64, usize); 4] = [(1.5, 15), (0.5, 12), (0.15, 10), (0.05, 8)];
/// Mean move of a step, in lattice spacings, below which the diffusion time has done its work.
const SETTLED: f64 = 0.003;
/// Positions tried in each direction of the lattice cell when a phase is projected.
const GRID: usize = 6;
/// Newton steps from the best of those; each halves the error and more.
const ASCENTS: usize = 4;
/// A step starts from the last one and is projected anyway, so it needs no accuracy. Less than this costs regularity, though: with 0.1 most
/// surfaces get a few irregular panels more.
const DIFFUSION: ConjugateGradientOptions = ConjugateGradientOptions {
    tolerance: 1e-2,
    max_iterations: 60,
};

/// Lattice offset of each vertex (position of a lattice point in the vertex's chart).
pub fn diffuse(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    pins: &PerVertex<Option<Pin>>,
    seed: u64,
) -> PerVertex<Plane> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut cell = || random.random_range(-0.5..0.5);
    let mut position: Vec<Plane> = topology
        .vertices()
        .map(|_| Plane::new(cell(), cell()))
        .collect();
    let projector = Projector::new();
    let operator = WaveOperator::new(topology, mesh, charts, pins);
    for (time, steps) in SCHEDULE {
        let diagonal = operator.diagonal(time);
        for _ in 0..steps {
            let mut x: Vec<f64> = position
                .par_iter()
                .flat_map_iter(|z| interleaved(waves(*z)))
                .collect();
            let rhs = operator.right_side(time, &x);
            conjugate_gradients(
                |a, y| operator.apply(time, a, y),
                &diagonal,
                &rhs,
                &mut x,
                &DIFFUSION,
            );
            let next: Vec<Plane> = x
                .par_chunks_exact(6)
                .map(|a| projector.project(a))
                .collect();
            let moved = mean_move(&position, &next);
            position = next;
            if moved < SETTLED {
                break;
            }
        }
    }
    PerVertex::from_vec(position)
}

/// Mean distance of two position fields, modulo the lattice.
fn mean_move(a: &[Plane], b: &[Plane]) -> f64 {
    let apart = |(a, b): (&Plane, &Plane)| {
        let d = b - a;
        (d - Eisenstein::nearest(d).to_plane()).norm()
    };
    a.iter().zip(b).map(apart).sum::<f64>() / a.len() as f64
}

pub(super) fn interleaved(a: [Plane; 3]) -> [f64; 6] {
    [a[0].re, a[0].im, a[1].re, a[1].im, a[2].re, a[2].im]
}

/// The three waves of a lattice offset.
pub(super) fn waves(z: Plane) -> [Plane; 3] {
    [0, 1, 2].map(|m| Plane::from_polar(1.0, TAU * dot(reciprocal(m), z)))
}

/// How the waves of a neighbour are seen from a vertex: wave `m` is wave `m - turn` there, conjugated where that passes half a turn, times
/// phase and weight.
#[derive(Clone, Copy)]
struct Link {
    vertex: u32,
    turn: u8,
    phase: [Plane; 3],
}

impl Link {
    /// The neighbour's waves without their phases.
    #[inline]
    fn seen(&self, a: &[f64]) -> [Plane; 3] {
        let at = |m: usize| Plane::new(a[2 * m], a[2 * m + 1]);
        let (p, q, r) = (at(0), at(1), at(2));
        match self.turn {
            0 => [p, q, r],
            1 => [r.conj(), p, q],
            2 => [q.conj(), r.conj(), p],
            3 => [p.conj(), q.conj(), r.conj()],
            4 => [r, p.conj(), q.conj()],
            _ => [q, r, p.conj()],
        }
    }
}

/// `mass + time * (connection Laplacian of the waves)`, three complex unknowns per vertex.
struct WaveOperator<'a> {
    mass: &'a [f64],
    /// Sum of the weights of the edges at each vertex.
    degree: Vec<f64>,
    /// Neighbours of each vertex with the links of their three waves, vertex after vertex.
    start: Vec<u32>,
    links: Vec<Link>,
    /// Weight with which each wave of each vertex is drawn to -1.
    pin: Vec<[f64; 3]>,
}

impl<'a> WaveOperator<'a> {
    fn new(
        topology: &Topology,
        mesh: &'a IntrinsicMesh,
        charts: &Charts,
        pins: &PerVertex<Option<Pin>>,
    ) -> Self {
        let (mut degree, mut start, mut links) = (Vec::new(), vec![0], Vec::new());
        for v in topology.vertices() {
            let mut total = 0.0;
            for h in topology.outgoing(v) {
                let weight = mesh.weight[topology.edge(h)];
                total += weight;
                links.push(link(
                    topology.target(h),
                    charts.half_edge(topology, h),
                    weight,
                ));
                let before = topology.prev(h);
                if topology.twin(before).is_none() {
                    let weight = mesh.weight[topology.edge(before)];
                    total += weight;
                    let transition = charts.half_edge(topology, before).inverse();
                    links.push(link(topology.origin(before), transition, weight));
                }
            }
            degree.push(total);
            start.push(links.len() as u32);
        }
        Self {
            mass: mesh.mass.as_slice(),
            degree,
            start,
            links,
            pin: pins.iter().map(pin_weights).collect(),
        }
    }

    /// `mass * x` and what the boundary draws to.
    fn right_side(&self, time: f64, x: &[f64]) -> Vec<f64> {
        let wish = |i: usize| match i % 2 {
            0 => time * self.pin[i / 6][i % 6 / 2],
            _ => 0.0,
        };
        let terms = x.iter().enumerate();
        terms.map(|(i, a)| a * self.mass[i / 6] - wish(i)).collect()
    }

    fn diagonal(&self, time: f64) -> Vec<f64> {
        let own = |i: usize| self.degree[i / 6] + self.pin[i / 6][i % 6 / 2];
        (0..6 * self.mass.len())
            .map(|i| self.mass[i / 6] + time * own(i))
            .collect()
    }

    fn apply(&self, time: f64, a: &[f64], y: &mut [f64]) {
        y.par_chunks_exact_mut(6)
            .with_min_len(512)
            .enumerate()
            .for_each(|(v, y)| {
                let mut sum = [0.0; 6];
                for link in &self.links[self.start[v] as usize..self.start[v + 1] as usize] {
                    let at = 6 * link.vertex as usize;
                    let seen = link.seen(&a[at..at + 6]);
                    for (m, (phase, z)) in link.phase.iter().zip(seen).enumerate() {
                        sum[2 * m] += phase.re * z.re - phase.im * z.im;
                        sum[2 * m + 1] += phase.re * z.im + phase.im * z.re;
                    }
                }
                let here = a[6 * v..6 * v + 6].iter().zip(&mut *y).zip(sum);
                for (k, ((a, y), sum)) in here.enumerate() {
                    let own = self.degree[v] + self.pin[v][k / 2];
                    *y = self.mass[v] * a + time * (own * a - sum);
                }
            });
    }
}

fn pin_weights(pin: &Option<Pin>) -> [f64; 3] {
    let mut weights = [0.0; 3];
    if let Some(pin) = pin {
        weights[pin.wave] = pin.weight;
    }
    weights
}

fn link(to: VertexId, transition: super::lattice::Transition, weight: f64) -> Link {
    Link {
        vertex: to.index() as u32,
        turn: transition.turn,
        phase: [0, 1, 2]
            .map(|m| Plane::from_polar(weight, TAU * dot(reciprocal(m), transition.offset))),
    }
}

/// Finds the lattice offset whose three waves are closest to given values.
pub(super) struct Projector {
    trial: Vec<(Plane, [Plane; 3])>,
    reciprocal: [Plane; 3],
}

impl Projector {
    pub fn new() -> Self {
        let w = Plane::from_polar(1.0, TAU / 6.0);
        let at = |i: usize| i as f64 / GRID as f64;
        let grid = (0..GRID).flat_map(|i| (0..GRID).map(move |k| (i, k)));
        let trial = grid
            .map(|(i, k)| w * at(k) + at(i))
            .map(|z| (z, waves(z)))
            .collect();
        Self {
            trial,
            reciprocal: [0, 1, 2].map(reciprocal),
        }
    }

    pub fn project(&self, values: &[f64]) -> Plane {
        let value = [0, 1, 2].map(|m| Plane::new(values[2 * m], values[2 * m + 1]));
        let score =
            |w: &[Plane; 3]| -> f64 { w.iter().zip(&value).map(|(a, b)| dot(*a, *b)).sum() };
        let mut best = (f64::NEG_INFINITY, Plane::new(0.0, 0.0));
        for (z, w) in &self.trial {
            let s = score(w);
            if s > best.0 {
                best = (s, *z);
            }
        }
        (0..ASCENTS).fold(best.1, |z, _| self.ascend(z, &value))
    }

    /// One damped Newton step towards the maximum of `sum Re(conj(a_m) wave_m(z))`.
    fn ascend(&self, z: Plane, value: &[Plane; 3]) -> Plane {
        let (mut gradient, mut bound) = (Plane::new(0.0, 0.0), 1e-9);
        let [first, second] =
            [0, 1].map(|m| Plane::from_polar(1.0, TAU * dot(self.reciprocal[m], z)));
        // The reciprocal vectors are a sixth of a turn apart, so that the third is the second less the first.
        let here = [first, second, second * first.conj()];
        for ((g, a), wave) in self.reciprocal.iter().zip(value).zip(here) {
            let turned = a.conj() * wave;
            gradient -= g * (TAU * turned.im);
            bound += a.norm() * TAU * TAU * g.norm_sqr() * 0.5;
        }
        z + gradient / bound
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::curvature;
    use crate::directions::directions;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    /// The charts of a shape, which turn against each other.
    fn charts_of(name: &str) -> (phex_mesh::TriangleSurface, IntrinsicMesh, Charts) {
        let options = TriangulationOptions {
            triangles: 500,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap();
        let length = 0.2 * surface.diagonal();
        let curvature = curvature(&surface, length, &Default::default());
        let directions = directions(&surface, &curvature, length, &Default::default()).unwrap();
        let charts = Charts::new(surface.topology(), &directions);
        (surface, directions.intrinsic, charts)
    }

    fn free(surface: &phex_mesh::TriangleSurface) -> PerVertex<Option<Pin>> {
        PerVertex::filled(surface.positions().len(), None)
    }

    /// Conjugate gradients need it; a wave that is seen wrongly from one side of an edge breaks it.
    #[test]
    fn the_operator_is_symmetric_and_positive_definite() {
        for name in ["torus", "sphere", "wave"] {
            let (surface, mesh, charts) = charts_of(name);
            let operator = WaveOperator::new(surface.topology(), &mesh, &charts, &free(&surface));
            let n = 6 * surface.positions().len();
            let mut random = ChaCha8Rng::seed_from_u64(9);
            let mut vector =
                || -> Vec<f64> { (0..n).map(|_| random.random_range(-1.0..1.0)).collect() };
            let apply = |x: &[f64]| {
                let mut y = vec![0.0; n];
                operator.apply(0.7, x, &mut y);
                y
            };
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let masses = |x: &[f64]| {
                (0..n)
                    .map(|i| operator.mass[i / 6] * x[i] * x[i])
                    .sum::<f64>()
            };
            for _ in 0..5 {
                let (x, y) = (vector(), vector());
                let (xy, yx) = (dot(&x, &apply(&y)), dot(&y, &apply(&x)));
                assert!(
                    (xy - yx).abs() < 1e-11 * dot(&x, &apply(&x)),
                    "{name}: {xy} {yx}"
                );
                assert!(dot(&x, &apply(&x)) >= masses(&x) * (1.0 - 1e-12), "{name}");
            }
        }
    }

    /// Waves of the same lattice seen from both ends of an edge differ by nothing: the operator leaves a lattice alone.
    #[test]
    fn links_carry_waves_across_an_edge() {
        let (surface, mesh, charts) = charts_of("torus");
        let topology = surface.topology();
        let operator = WaveOperator::new(topology, &mesh, &charts, &free(&surface));
        for v in topology.vertices().take(40) {
            let first = operator.start[phex_mesh::ElementId::index(v)] as usize;
            for (k, h) in topology.outgoing(v).enumerate() {
                let there = Plane::new(0.3, -0.45);
                let here = waves(charts.half_edge(topology, h).apply(there));
                let link = operator.links[first + k];
                let seen = link.seen(&interleaved(waves(there)));
                for (m, (phase, seen)) in link.phase.iter().zip(seen).enumerate() {
                    let weight = mesh.weight[topology.edge(h)];
                    assert!((phase * seen - here[m] * weight).norm() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn projection_finds_the_offset_of_waves() {
        let projector = Projector::new();
        for i in 0..200 {
            let z = Plane::new((f64::from(i) * 0.37).sin(), (f64::from(i) * 0.91).cos());
            let found = projector.project(&interleaved(waves(z)));
            let apart = found - z;
            let apart = apart - super::super::lattice::Eisenstein::nearest(apart).to_plane();
            assert!(apart.norm() < 1e-3, "{z} {found}");
        }
    }
}
