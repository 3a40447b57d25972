//! Sizes: the panel length wanted at each vertex.
//!
//! `L(x) = min(L0, c / k_max(x))` resolves features (`c` is the largest `L k_max`, twice the sagitta's share), times the
//! user's relative size field; `L0` follows from the number of panels. Sizes change by a stated share per panel at most,
//! because each faster change costs a 5|7 pair.

use crate::curvature::Principal;
use phex_mesh::{PerVertex, Topology, TriangleSurface};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How sizes follow the surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SizeOptions {
    /// Largest panel length times curvature (`L k_max`), or `None` for uniform panels. 0.4 resolves features well.
    pub adaptive: Option<f64>,
    /// Smallest size over the largest that `adaptive` may ask for.
    pub smallest_rel: f64,
    /// Relative change of size per panel length at the most.
    pub gradation: f64,
}

impl Default for SizeOptions {
    fn default() -> Self {
        Self {
            adaptive: None,
            smallest_rel: 0.25,
            gradation: 0.15,
        }
    }
}

/// Relative sizes (only their ratios matter): the user's field (one positive number per vertex) and, where asked for,
/// what curvature demands of panels of length `length`. `None` if all panels are to have one size.
pub fn relative_sizes(
    surface: &TriangleSurface,
    principal: &PerVertex<Principal>,
    field: Option<&PerVertex<f64>>,
    length: f64,
    options: &SizeOptions,
) -> Option<PerVertex<f64>> {
    if options.adaptive.is_none() && field.is_none() {
        return None;
    }
    let curved = |p: &Principal| match options.adaptive {
        Some(c) => (c / (p.large.abs() * length)).clamp(options.smallest_rel, 1.0),
        None => 1.0,
    };
    let wish = PerVertex::from_fn(principal.len(), |v| {
        curved(&principal[v]) * field.map_or(1.0, |f| f[v])
    });
    Some(graded(surface, &wish, options.gradation / length))
}

/// The largest field below `wish` whose slope is at most `slope` times the size (per length): sizes grow away from small
/// ones as `size + slope size distance` does.
fn graded(surface: &TriangleSurface, wish: &PerVertex<f64>, slope: f64) -> PerVertex<f64> {
    let topology: &Topology = surface.topology();
    let mut size = wish.clone();
    let key = |s: f64| Reverse(s.to_bits());
    let mut heap: BinaryHeap<_> = topology
        .vertices()
        .map(|v| (key(size[v]), Reverse(v)))
        .collect();
    while let Some((Reverse(bits), Reverse(v))) = heap.pop() {
        let here = f64::from_bits(bits);
        if here > size[v] {
            continue;
        }
        for w in topology.neighbours(v) {
            let step = (surface.positions()[v] - surface.positions()[w]).norm();
            let allowed = here + slope * step;
            if allowed < size[w] {
                size[w] = allowed;
                heap.push((key(allowed), Reverse(w)));
            }
        }
    }
    size
}

/// The factor `L0` that makes panels of length `L0 * relative` cover the surface with `panels` cells of area `cell L^2`.
pub fn base_length(
    surface: &TriangleSurface,
    relative: &PerVertex<f64>,
    cell: f64,
    panels: usize,
) -> f64 {
    let topology = surface.topology();
    let share: f64 = topology
        .faces()
        .map(|f| {
            let size = topology
                .face_vertices(f)
                .iter()
                .map(|&v| relative[v])
                .sum::<f64>()
                / 3.0;
            0.5 * surface.area_vector(f).norm() / (size * size)
        })
        .sum();
    (share / (cell * panels as f64)).sqrt()
}

/// `L k_max` at each vertex: above about 0.8 a feature is smaller than the panels on it.
pub fn resolution(principal: &PerVertex<Principal>, length: &PerVertex<f64>) -> PerVertex<f64> {
    PerVertex::from_fn(length.len(), |v| principal[v].large.abs() * length[v])
}
