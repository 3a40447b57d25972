//! The operator that diffuses three waves over a surface, in single precision: it is multiplied
//! with hundreds of times.
//!
//! `mass + time * L` with the connection Laplacian `L` of the waves: an edge takes the three waves
//! of its far end, permutes and conjugates them as the charts of both ends are turned against each
//! other, and turns their phases by the edge's offset. Charts are turned first so that they agree
//! along a spanning tree, and vertices are taken in the order of that tree, so that almost nothing
//! is permuted and neighbours are near each other in memory.

use super::chart_graph::{ChartGraph, Lists, WaveHold};
use super::eisenstein::{Plane, waves};
use rayon::prelude::*;

/// Numbers that hold a vertex's three waves: four real parts, four imaginary ones, of which the
/// last are 0.
pub(super) const WIDTH: usize = 8;

pub(super) fn packed(a: &[Plane; 3]) -> [f32; WIDTH] {
    let [p, q, r] = a.map(|a| (a.re as f32, a.im as f32));
    [p.0, q.0, r.0, 0.0, p.1, q.1, r.1, 0.0]
}

pub(super) fn unpacked(a: &[f32]) -> [Plane; 3] {
    [0, 1, 2].map(|m| Plane::new(f64::from(a[m]), f64::from(a[m + 4])))
}

/// Real or imaginary parts of a vertex's waves.
type Lanes = [f32; 4];

#[inline]
fn lanes(value: impl FnMut(usize) -> f32) -> Lanes {
    std::array::from_fn(value)
}

/// How the waves of a neighbour are seen from a vertex where both charts agree: times phase and
/// weight.
#[derive(Clone, Copy)]
struct Link {
    vertex: u32,
    real: Lanes,
    imaginary: Lanes,
}

impl Link {
    fn new(to: u32, offset: Plane, weight: f64) -> Self {
        let [a, b, c, d, e, f, g, h] = packed(&waves(offset).map(|p| p * weight));
        Self {
            vertex: to,
            real: [a, b, c, d],
            imaginary: [e, f, g, h],
        }
    }

    /// Adds the neighbour's waves, as they are seen from here, to real and imaginary parts.
    #[inline]
    fn add(&self, re: &Lanes, im: &Lanes, sum: &mut (Lanes, Lanes)) {
        let (p, q) = (&self.real, &self.imaginary);
        let real = lanes(|m| p[m] * re[m] - q[m] * im[m]);
        let imaginary = lanes(|m| p[m] * im[m] + q[m] * re[m]);
        sum.0 = lanes(|m| sum.0[m] + real[m]);
        sum.1 = lanes(|m| sum.1[m] + imaginary[m]);
    }
}

/// A link between charts that do not agree: wave `m` is first wave `m - turn`, conjugated where
/// that passes half a turn.
#[derive(Clone, Copy)]
struct Seam {
    link: Link,
    turn: u8,
}

impl Seam {
    fn add(&self, re: &Lanes, im: &Lanes, sum: &mut (Lanes, Lanes)) {
        let at = |m: usize| match usize::from(self.turn) {
            turn if turn % 3 <= m => (m - turn % 3, turn >= 3),
            turn => (m + 3 - turn % 3, turn < 3),
        };
        let (mut x, mut y) = ([0.0; 4], [0.0; 4]);
        for m in 0..3 {
            let (from, conjugate) = at(m);
            x[m] = re[from];
            y[m] = if conjugate { -im[from] } else { im[from] };
        }
        self.link.add(&x, &y, sum);
    }
}

/// `mass + time * (connection Laplacian of the waves)`, three complex unknowns per vertex. Single
/// precision is more than the tolerance asks for.
pub(super) struct WaveOperator {
    mass: Vec<f32>,
    /// Sum of the weights of the edges at each vertex.
    degree: Vec<f32>,
    links: Lists<Link>,
    seams: Lists<Seam>,
    /// Weight with which each wave of each vertex is held to a value.
    held: Vec<Lanes>,
    /// What holds them.
    holds: Vec<WaveHold>,
}

impl WaveOperator {
    /// Waves over a graph.
    pub fn new(graph: &ChartGraph) -> Self {
        let (mut degree, mut links, mut seams) = (Vec::new(), Lists::new(), Lists::new());
        for v in 0..graph.mass.len() {
            let mut total = 0.0;
            for view in graph.views.of(v) {
                total += view.weight;
                let link = Link::new(view.to, view.offset, view.weight);
                match view.turn {
                    0 => links.items.push(link),
                    turn => seams.items.push(Seam { link, turn }),
                }
            }
            degree.push(total as f32);
            links.end();
            seams.end();
        }
        Self {
            mass: graph.mass.iter().map(|m| *m as f32).collect(),
            degree,
            links,
            seams,
            held: graph
                .holds
                .iter()
                .map(|h| packed_weights(&h.weight))
                .collect(),
            holds: graph.holds.clone(),
        }
    }

    /// `mass * x` and what the boundary draws to, from the waves `x`.
    pub(crate) fn right_side(&self, time: f32, mut x: Vec<f32>) -> Vec<f32> {
        for (v, y) in x.chunks_exact_mut(WIDTH).enumerate() {
            let drawn = match self.holds[v].weight {
                [0.0, 0.0, 0.0] => [0.0; WIDTH],
                _ => packed(&self.holds[v].drawn_at(&unpacked(y))),
            };
            y.iter_mut().for_each(|y| *y *= self.mass[v]);
            let wish = y.iter_mut().zip(&drawn);
            wish.for_each(|(y, drawn)| *y += time * drawn);
        }
        x
    }

    /// The diagonal.
    pub fn diagonal(&self, time: f32) -> Vec<f32> {
        let own = |i: usize| self.degree[i / WIDTH] + self.held[i / WIDTH][i % 4];
        (0..WIDTH * self.mass.len())
            .map(|i| self.mass[i / WIDTH] + time * own(i))
            .collect()
    }

    /// Writes the product with `a` to `y`.
    pub fn apply(&self, time: f32, a: &[f32], y: &mut [f32]) {
        let (a, y) = (a.as_chunks::<WIDTH>().0, y.as_chunks_mut::<WIDTH>().0);
        let rows = y.par_iter_mut().with_min_len(512).enumerate();
        rows.for_each(|(v, y)| {
            let sum = self.seen(v, a);
            let own = lanes(|m| self.mass[v] + time * (self.degree[v] + self.held[v][m]));
            let (re, im) = parts(&a[v]);
            let (y_re, y_im) = y.split_at_mut(4);
            y_re.copy_from_slice(&lanes(|m| own[m] * re[m] - time * sum.0[m]));
            y_im.copy_from_slice(&lanes(|m| own[m] * im[m] - time * sum.1[m]));
        });
    }

    /// The sum of the neighbours' waves as they are seen from a vertex, weighted.
    #[inline]
    fn seen(&self, v: usize, a: &[[f32; WIDTH]]) -> (Lanes, Lanes) {
        let mut sum = ([0.0; 4], [0.0; 4]);
        for link in self.links.of(v) {
            let (re, im) = parts(&a[link.vertex as usize]);
            link.add(re, im, &mut sum);
        }
        for seam in self.seams.of(v) {
            let (re, im) = parts(&a[seam.link.vertex as usize]);
            seam.add(re, im, &mut sum);
        }
        sum
    }
}

/// Real and imaginary parts.
#[inline]
fn parts(a: &[f32; WIDTH]) -> (&Lanes, &Lanes) {
    let ([re, im], []) = a.as_chunks::<4>() else {
        unreachable!("twice four")
    };
    (re, im)
}

fn packed_weights(weight: &[f64; 3]) -> Lanes {
    let [a, b, c] = weight.map(|w| w as f32);
    [a, b, c, 0.0]
}

#[cfg(test)]
mod tests {
    use super::super::chart_graph::tests::{charts_of, graph_of};
    use super::super::chart_graph::{Combing, for_each_view};
    use super::super::eisenstein::rotate;
    use super::*;
    use phex_mesh::PerVertex;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Conjugate gradients need it; a wave that is seen wrongly from one side of an edge breaks it.
    #[test]
    fn the_operator_is_symmetric_and_positive_definite() {
        for name in ["torus", "sphere", "wave"] {
            let fine = graph_of(name);
            let coarse = fine.coarse().0;
            for graph in [fine, coarse] {
                let operator = WaveOperator::new(&graph);
                let n = graph.mass.len();
                let mut random = ChaCha8Rng::seed_from_u64(9);
                let mut vector = || -> Vec<f32> {
                    let mut number = || random.random_range(-1.0..1.0);
                    let waves = (0..n).map(|_| [0, 1, 2].map(|_| Plane::new(number(), number())));
                    waves.flat_map(|a| packed(&a)).collect()
                };
                let apply = |x: &[f32]| {
                    let mut y = vec![0.0; x.len()];
                    operator.apply(0.7, x, &mut y);
                    y
                };
                let dot = |a: &[f32], b: &[f32]| -> f64 {
                    let terms = a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b));
                    terms.sum()
                };
                let masses = |x: &[f32]| -> f64 {
                    let mass = |i: usize| f64::from(operator.mass[i / WIDTH]);
                    let terms = (0..x.len()).map(|i| mass(i) * f64::from(x[i]).powi(2));
                    terms.sum()
                };
                for _ in 0..5 {
                    let (x, y) = (vector(), vector());
                    let (xy, yx) = (dot(&x, &apply(&y)), dot(&y, &apply(&x)));
                    assert!(
                        (xy - yx).abs() < 1e-6 * dot(&x, &apply(&x)),
                        "{name}: {xy} {yx}"
                    );
                    assert!(dot(&x, &apply(&x)) >= masses(&x) * (1.0 - 1e-6), "{name}");
                }
            }
        }
    }

    /// What a vertex sees of its neighbours are the waves of their points in its own chart,
    /// weighted. Round cones charts can't all agree, so that some are seen across seams.
    #[test]
    fn links_carry_waves_across_an_edge() {
        for (name, has_cones) in [("torus", false), ("sphere", true)] {
            let (surface, mesh, charts) = charts_of(name);
            let topology = surface.topology();
            let combing = Combing::new(topology, &charts);
            let graph = graph_of(name);
            let operator = WaveOperator::new(&graph);
            assert!(!operator.seams.items.is_empty() || !has_cones);
            let mut random = ChaCha8Rng::seed_from_u64(5);
            let mut cell = || random.random_range(-0.5..0.5);
            let at = PerVertex::from_fn(topology.n_vertices(), |_| Plane::new(cell(), cell()));
            let a = combing.in_order(|v| packed(&waves(rotate(at[v], combing.turned[v]))));
            for v in topology.vertices() {
                let (mut expected, mut size) = ([Plane::new(0.0, 0.0); 3], 0.0);
                for_each_view(topology, &charts, v, |w, e, view| {
                    let here = waves(rotate(view.apply(at[w]), combing.turned[v]));
                    for (sum, wave) in expected.iter_mut().zip(here) {
                        *sum += wave * mesh.weight[e];
                    }
                    size += mesh.weight[e].abs();
                });
                let (re, im) = operator.seen(combing.rank[v] as usize, &a);
                for m in 0..3 {
                    let seen = Plane::new(re[m].into(), im[m].into());
                    assert!((seen - expected[m]).norm() < 1e-5 * size, "{name}");
                }
            }
        }
    }
}
