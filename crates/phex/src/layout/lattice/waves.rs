//! Lattice positions by diffusing three waves and projecting them to a common phase, from coarse to
//! fine.
//!
//! A lattice is the set where the waves `exp(2 pi i <g_m, z>)`, `m = 0, 1, 2`, are all 1. Each
//! vertex holds the three values of its own chart; a change of chart permutes (and conjugates)
//! them. Repeating "diffuse for time `t`, project to the nearest lattice phase" with falling `t`
//! finds a position field whose dislocations sit only where size demands (a diffusion-projection
//! scheme in the manner of Merriman, Bence and Osher). The longest time is run on groups of
//! vertices, from a random start.

use super::chart_graph::{ChartGraph, Combing};
use super::charted::ChartedSurface;
use super::eisenstein::{Eisenstein, Plane, dot, reciprocal, third, waves};
use super::wave_operator::{WIDTH, WaveOperator, packed, unpacked};
use crate::progress::Progress;
use phex_mesh::PerVertex;
use phex_numeric::{ConjugateGradientOptions, conjugate_gradients};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Diffusion times in squared lattice spacings, and steps at each: the longest on groups of
/// vertices, about a lattice spacing apart, where it costs a tenth and sees as much; the others on
/// all vertices.
const COARSE: [(f64, usize); 1] = [(1.5, 30)];
const FINE: [(f64, usize); 3] = [(0.5, 12), (0.15, 10), (0.05, 8)];
/// Mean move of a step, in lattice spacings, below which the diffusion time has done its work.
const SETTLED: f64 = 0.003;
/// Positions tried in each direction of the lattice cell when a phase is projected.
const GRID: usize = 6;
/// Newton steps from the best of those; each halves the error and more.
const ASCENTS: usize = 4;
/// A step starts from the last one and is projected anyway, so it needs no accuracy. Less than this
/// costs regularity, though: with 0.1 most surfaces get a few irregular panels more.
const DIFFUSION: ConjugateGradientOptions = ConjugateGradientOptions {
    tolerance: 1e-2,
    max_iterations: 60,
};

/// Lattice offset of each vertex (position of a lattice point in the vertex's chart).
pub(crate) fn diffuse(
    charted: &ChartedSurface<'_>,
    seed: u64,
    progress: &dyn Progress,
) -> PerVertex<Plane> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut cell = || random.random_range(-0.5..0.5);
    let combing = Combing::new(charted.topology, charted.charts);
    let graph = ChartGraph::new(charted, &combing);
    let (coarse, members) = graph.coarse();
    let start = (0..coarse.mass.len()).map(|_| Plane::new(cell(), cell()));
    let start = stepped(&coarse, start.collect(), &COARSE, progress);
    let start = members.iter().map(|m| m.of(&start)).collect();
    combing.restored(stepped(&graph, start, &FINE, progress).into_iter())
}

/// The offsets after the steps of a schedule, or those of a caller who cancels.
fn stepped(
    graph: &ChartGraph,
    mut position: Vec<Plane>,
    schedule: &[(f64, usize)],
    progress: &dyn Progress,
) -> Vec<Plane> {
    let projector = Projector::new();
    let operator = WaveOperator::new(graph);
    let packed = |position: &[Plane]| -> Vec<f32> {
        let waves = position.par_iter().map(|z| packed(&waves(*z)));
        waves.flatten_iter().collect()
    };
    for &(time, steps) in schedule {
        let time = time as f32;
        let diagonal = operator.diagonal(time);
        for _ in 0..steps {
            if progress.is_cancelled() {
                return position;
            }
            // From the last solution it would be fewer iterations, but more irregular panels.
            let mut x = packed(&position);
            let rhs = operator.right_side(time, x.clone());
            conjugate_gradients(
                |a, y| operator.apply(time, a, y),
                &diagonal,
                &rhs,
                &mut x,
                &DIFFUSION,
            );
            let next: Vec<Plane> = x
                .par_chunks_exact(WIDTH)
                .map(|a| projector.project(&unpacked(a)))
                .collect();
            let moved = mean_move(&position, &next);
            position = next;
            if moved < SETTLED {
                break;
            }
        }
    }
    position
}

/// Mean distance of two position fields, modulo the lattice.
fn mean_move(a: &[Plane], b: &[Plane]) -> f64 {
    let apart = |(a, b): (&Plane, &Plane)| {
        let d = b - a;
        (d - Eisenstein::nearest(d).to_plane()).norm_sqr().sqrt()
    };
    a.iter().zip(b).map(apart).sum::<f64>() / a.len() as f64
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

    pub fn project(&self, values: &[Plane; 3]) -> Plane {
        let score =
            |w: &[Plane; 3]| -> f64 { w.iter().zip(values).map(|(a, b)| dot(*a, *b)).sum() };
        let mut best = (f64::NEG_INFINITY, &self.trial[0]);
        for trial in &self.trial {
            let s = score(&trial.1);
            if s > best.0 {
                best = (s, trial);
            }
        }
        let (mut z, mut waves) = *best.1;
        let stiff = |(g, a): (&Plane, &Plane)| a.norm_sqr().sqrt() * TAU * TAU * g.norm_sqr() * 0.5;
        let bound = 1e-9 + self.reciprocal.iter().zip(values).map(stiff).sum::<f64>();
        for _ in 0..ASCENTS {
            let step = self.ascent(&waves, values) / bound;
            z += step;
            let [first, second] =
                [0, 1].map(|m| turned(waves[m], TAU * dot(self.reciprocal[m], step)));
            waves = [first, second, third(first, second)];
        }
        z
    }

    /// Gradient of `sum Re(conj(a_m) wave_m(z))`; over the bound of its own derivative it is a
    /// damped Newton step.
    fn ascent(&self, waves: &[Plane; 3], values: &[Plane; 3]) -> Plane {
        let terms = self.reciprocal.iter().zip(values).zip(waves);
        let force = |((g, a), wave): ((&Plane, &Plane), &Plane)| g * (-TAU * (a.conj() * wave).im);
        terms.map(force).sum()
    }
}

/// A wave whose phase grows by a small angle: series to the seventh power, exact to 1e-9 at a fifth
/// of a radian and 1e-6 at half of one.
fn turned(wave: Plane, angle: f64) -> Plane {
    let s = angle * angle;
    let cosine = 1.0 - s / 2.0 * (1.0 - s / 12.0 * (1.0 - s / 30.0));
    let sine = angle * (1.0 - s / 6.0 * (1.0 - s / 20.0 * (1.0 - s / 42.0)));
    wave * Plane::new(cosine, sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn projection_finds_the_offset_of_waves() {
        let projector = Projector::new();
        for i in 0..200 {
            let z = Plane::new((f64::from(i) * 0.37).sin(), (f64::from(i) * 0.91).cos());
            let found = projector.project(&waves(z));
            let apart = found - z;
            let apart = apart - super::super::eisenstein::Eisenstein::nearest(apart).to_plane();
            assert!(apart.norm() < 1e-3, "{z} {found}");
        }
    }
}
