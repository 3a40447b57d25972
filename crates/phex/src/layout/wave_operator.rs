//! The operator that diffuses three waves over a surface, in single precision: it is multiplied with hundreds of times.
//!
//! `mass + time * L` with the connection Laplacian `L` of the waves: an edge takes the three waves of its far end, permutes and conjugates them as the charts of both ends are turned
//! against each other, and turns their phases by the edge's offset. Charts are turned first so that they agree along a spanning tree, and vertices are taken in
//! the order of that tree, so that almost nothing is permuted and neighbours are near each other in memory.

use super::boundary::Pin;
use super::lattice::{Charts, Plane, Transition, rotate};
use super::waves::waves;
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{EdgeId, PerVertex, Topology, VertexId};
use rayon::prelude::*;
use std::collections::VecDeque;

/// A spanning tree along which charts agree once they are turned.
pub(super) struct Combing {
    /// Vertices in the order in which the tree reaches them.
    pub order: Vec<VertexId>,
    /// Place of each vertex in that order.
    rank: PerVertex<u32>,
    /// Sixths of a turn by which each vertex's chart is turned.
    pub turned: PerVertex<u8>,
}

impl Combing {
    /// Breadth first from the first vertex of each component.
    pub fn new(topology: &Topology, charts: &Charts) -> Self {
        let mut turned = PerVertex::filled(topology.n_vertices(), None);
        let mut order = Vec::with_capacity(topology.n_vertices());
        let mut queue = VecDeque::new();
        for root in topology.vertices() {
            if turned[root].is_none() {
                turned[root] = Some(0);
                queue.push_back(root);
            }
            while let Some(v) = queue.pop_front() {
                order.push(v);
                let here = turned[v].unwrap_or(0);
                for_each_view(topology, charts, v, |w, _, view| {
                    if turned[w].is_none() {
                        turned[w] = Some((here + view.turn) % 6);
                        queue.push_back(w);
                    }
                });
            }
        }
        let mut rank = PerVertex::filled(order.len(), 0);
        for (k, &v) in order.iter().enumerate() {
            rank[v] = k as u32;
        }
        Self {
            order,
            rank,
            turned: turned.map(|t| t.unwrap_or(0)),
        }
    }

    /// Values in the order of the tree.
    pub fn in_order<T>(&self, value: impl FnMut(VertexId) -> T) -> Vec<T> {
        self.order.iter().copied().map(value).collect()
    }

    /// The turn of a transition between turned charts, from `w` to `v`.
    fn turn(&self, v: VertexId, w: VertexId, view: Transition) -> u8 {
        (view.turn + self.turned[v] + 6 - self.turned[w]) % 6
    }
}

/// Calls `visit` for every neighbour of a vertex with the edge and the neighbour's transition to the vertex.
pub(super) fn for_each_view(
    topology: &Topology,
    charts: &Charts,
    v: VertexId,
    mut visit: impl FnMut(VertexId, EdgeId, Transition),
) {
    for h in topology.outgoing(v) {
        let view = charts.half_edge(topology, h);
        visit(topology.target(h), topology.edge(h), view);
        let before = topology.prev(h);
        if topology.twin(before).is_none() {
            let view = charts.half_edge(topology, before).inverse();
            visit(topology.origin(before), topology.edge(before), view);
        }
    }
}

/// Numbers that hold a vertex's three waves: four real parts, four imaginary ones, of which the last are 0.
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

/// How the waves of a neighbour are seen from a vertex where both charts agree: times phase and weight.
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

/// A link between charts that do not agree: wave `m` is first wave `m - turn`, conjugated where that passes half a turn.
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

/// Lists of many vertices in one: those of vertex `v` are `start[v]..start[v + 1]`.
struct Lists<T> {
    start: Vec<u32>,
    items: Vec<T>,
}

impl<T> Lists<T> {
    fn new() -> Self {
        Self {
            start: vec![0],
            items: Vec::new(),
        }
    }

    /// Ends a vertex's list.
    fn end(&mut self) {
        self.start.push(self.items.len() as u32);
    }

    #[inline]
    fn of(&self, v: usize) -> &[T] {
        &self.items[self.start[v] as usize..self.start[v + 1] as usize]
    }
}

/// `mass + time * (connection Laplacian of the waves)`, three complex unknowns per vertex. Single precision is more than the tolerance asks for.
pub(super) struct WaveOperator {
    mass: Vec<f32>,
    /// Sum of the weights of the edges at each vertex.
    degree: Vec<f32>,
    links: Lists<Link>,
    seams: Lists<Seam>,
    /// Weight with which each wave of each vertex is drawn to -1.
    pin: Vec<Lanes>,
}

impl WaveOperator {
    /// For charts that are turned, and vertices in an order.
    pub fn new(
        topology: &Topology,
        mesh: &IntrinsicMesh,
        charts: &Charts,
        pins: &PerVertex<Option<Pin>>,
        combing: &Combing,
    ) -> Self {
        let (mut degree, mut links, mut seams) = (Vec::new(), Lists::new(), Lists::new());
        for &v in &combing.order {
            let mut total = 0.0;
            for_each_view(topology, charts, v, |w, e, view| {
                let weight = mesh.weight[e];
                total += weight;
                let offset = rotate(view.offset, combing.turned[v]);
                let link = Link::new(combing.rank[w], offset, weight);
                match combing.turn(v, w, view) {
                    0 => links.items.push(link),
                    turn => seams.items.push(Seam { link, turn }),
                }
            });
            degree.push(total as f32);
            links.end();
            seams.end();
        }
        Self {
            mass: combing.in_order(|v| mesh.mass[v] as f32),
            degree,
            links,
            seams,
            pin: combing.in_order(|v| pin_weights(&pins[v], combing.turned[v])),
        }
    }

    /// `mass * x` and what the boundary draws to.
    pub fn right_side(&self, time: f32, mut x: Vec<f32>) -> Vec<f32> {
        for (v, y) in x.chunks_exact_mut(WIDTH).enumerate() {
            y.iter_mut().for_each(|y| *y *= self.mass[v]);
            let wish = y.iter_mut().zip(&self.pin[v]);
            wish.for_each(|(y, weight)| *y -= time * weight);
        }
        x
    }

    /// The diagonal.
    pub fn diagonal(&self, time: f32) -> Vec<f32> {
        let own = |i: usize| self.degree[i / WIDTH] + self.pin[i / WIDTH][i % 4];
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
            let own = lanes(|m| self.mass[v] + time * (self.degree[v] + self.pin[v][m]));
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

fn pin_weights(pin: &Option<Pin>, turned: u8) -> Lanes {
    let mut weights = [0.0; 4];
    if let Some(pin) = pin {
        weights[(pin.wave + usize::from(turned)) % 3] = pin.weight as f32;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::curvature;
    use crate::directions::directions;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

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
            let combing = Combing::new(surface.topology(), &charts);
            let operator = WaveOperator::new(
                surface.topology(),
                &mesh,
                &charts,
                &free(&surface),
                &combing,
            );
            let n = surface.positions().len();
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

    #[test]
    fn charts_are_turned_so_that_most_agree() {
        let (surface, _, charts) = charts_of("torus");
        let topology = surface.topology();
        let combing = Combing::new(topology, &charts);
        let (mut agree, mut all) = (0, 0);
        for v in topology.vertices() {
            for_each_view(topology, &charts, v, |w, _, view| {
                all += 1;
                agree += usize::from(combing.turn(v, w, view) == 0);
            });
        }
        assert!(agree > all * 4 / 5, "{agree} of {all}");
    }

    /// Waves of the same lattice seen from both ends of an edge differ by nothing: the operator leaves a lattice alone.
    #[test]
    fn links_carry_waves_across_an_edge() {
        for (name, has_cones) in [("torus", false), ("sphere", true)] {
            let (surface, mesh, charts) = charts_of(name);
            let topology = surface.topology();
            let combing = Combing::new(topology, &charts);
            let operator = WaveOperator::new(topology, &mesh, &charts, &free(&surface), &combing);
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
