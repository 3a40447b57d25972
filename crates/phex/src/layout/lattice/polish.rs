//! Gauss-Seidel polish of lattice offsets: every vertex moves to the mean of what its neighbours
//! see, modulo the lattice.

use super::chart_graph::{Lists, for_each_view};
use super::charted::ChartedSurface;
use super::eisenstein::{Eisenstein, Plane, Transition};
use phex_mesh::{PerVertex, VertexId};

/// Share of the way to the neighbours' mean that a vertex moves.
const RELAXATION: f64 = 0.9;

/// Mean move of a sweep, in lattice spacings, after which nothing more is to be gained.
const SETTLED: f64 = 2e-4;

/// How each vertex sees its neighbours: their numbers, transitions, and the weights of the edges.
fn views(charted: &ChartedSurface<'_>) -> Lists<(VertexId, Transition, f64)> {
    let mut views = Lists::new();
    for v in charted.topology.vertices() {
        for_each_view(charted.topology, charted.charts, v, |w, e, view| {
            views.items.push((w, view, charted.mesh.weight[e]));
        });
        views.end();
    }
    views
}

/// Runs up to `sweeps` sweeps in the order of the vertices; offsets are returned reduced to the
/// lattice cell round 0.
pub(crate) fn polish(charted: &ChartedSurface<'_>, position: &mut PerVertex<Plane>, sweeps: usize) {
    let views = views(charted);
    for _ in 0..sweeps {
        let mut moved = 0.0;
        for v in charted.topology.vertices() {
            let (mut sum, mut total) = (Plane::new(0.0, 0.0), 0.0);
            let here = position[v];
            let mut add = |seen: Plane, weight: f64| {
                sum += (seen - Eisenstein::nearest(seen - here).to_plane()) * weight;
                total += weight;
            };
            for (w, view, weight) in views.of(v.index()) {
                add(view.apply(position[*w]), *weight);
            }
            if let Some(pin) = &charted.pins[v] {
                add(here + pin.correction(here), pin.weight);
            }
            let step = (sum / total - here) * RELAXATION;
            moved += step.norm();
            position[v] = here + step;
        }
        if moved < SETTLED * position.len() as f64 {
            break;
        }
    }
    for z in position.iter_mut() {
        *z -= Eisenstein::nearest(*z).to_plane();
    }
}
