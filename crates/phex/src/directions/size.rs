//! Sizes: the panel length wanted at each vertex.
//!
//! `L(x) = min(L0, c / k_max(x), sqrt(2 t(x) / k_max(x)))` resolves features (`c` is the largest `L
//! k_max`, twice the sagitta's share) and keeps panels of sheets apart that are only `t` from each
//! other (the sagitta `L^2 k_max / 8` stays below `t / 4`), times the user's relative size field;
//! `L0` follows from the number of panels. Sizes change by a stated share per panel at most,
//! because each faster change costs a 5|7 pair.

use crate::curvature::Principal;
use phex_mesh::{PerVertex, Topology, TriangleSurface};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// How sizes follow the surface.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SizeOptions {
    /// Largest panel length times curvature (`L k_max`), or `None` for uniform panels. 0.4 resolves
    /// features well.
    pub adaptive: Option<f64>,
}

/// Share of the distance to the opposite sheet that the sagitta of a panel may be: those of both
/// sheets stand off towards each other.
const OF_THICKNESS: f64 = 0.25;
/// Smallest size over the largest that curvature may ask for.
const SMALLEST: f64 = 0.25;
/// Relative change of size per panel length at the most.
const GRADATION: f64 = 0.15;
/// Smallest size that thickness may ask for, over the smallest that curvature may: sheets nearly
/// touch in few places.
const THINNEST: f64 = 0.3;

/// What a surface asks of sizes at its vertices.
pub struct Demands<'a> {
    /// Its curvature.
    pub principal: &'a PerVertex<Principal>,
    /// Its distance to the opposite sheet, where sizes adapt to it.
    pub thickness: Option<&'a PerVertex<f64>>,
    /// The user's field, one positive number per vertex.
    pub field: Option<&'a PerVertex<f64>>,
}

/// Relative sizes (only their ratios matter): the user's field and, where asked for, what curvature
/// and thickness demand of panels of length `length`. `None` if all panels are to have one size.
pub fn relative_sizes(
    surface: &TriangleSurface,
    demands: &Demands<'_>,
    length: f64,
    options: &SizeOptions,
) -> Option<PerVertex<f64>> {
    let Demands {
        principal,
        thickness,
        field,
    } = demands;
    if options.adaptive.is_none() && field.is_none() {
        return None;
    }
    let own = |v| match options.adaptive {
        Some(c) => {
            let curvature = principal[v].large.abs();
            let resolved = (c / (curvature * length)).clamp(SMALLEST, 1.0);
            let apart = thickness.map_or(f64::INFINITY, |t| {
                (8.0 * OF_THICKNESS * t[v] / curvature).sqrt() / length
            });
            resolved.min(apart.max(THINNEST * SMALLEST))
        }
        None => 1.0,
    };
    let wish = PerVertex::from_fn(principal.len(), |v| own(v) * field.map_or(1.0, |f| f[v]));
    Some(graded(surface, &wish, GRADATION / length))
}

/// The largest field below `wish` whose slope is at most `slope` times the size (per length): sizes
/// grow away from small ones as `size + slope size distance` does.
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

/// The factor `L0` that makes panels of length `L0 * relative` cover the surface with `panels`
/// cells of area `cell L^2`.
pub(crate) fn base_length(
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
            surface.face_area(f) / (size * size)
        })
        .sum();
    (share / (cell * panels as f64)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::Vec3;

    #[test]
    fn sagittas_of_opposite_panels_stay_within_a_quarter_of_the_thickness() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let positions = corners.map(|[x, y]| Vec3::new(x, y, 0.0)).to_vec();
        let surface = TriangleSurface::new(positions, &[[0, 1, 2], [0, 2, 3]]).unwrap();
        let bent = Principal {
            small: 0.0,
            large: -2.0,
            small_direction: Vec3::x(),
            large_direction: Vec3::y(),
        };
        let (principal, length) = (PerVertex::filled(4, bent), 0.3);
        let options = SizeOptions {
            adaptive: Some(0.4),
        };
        let size_at = |t: f64| {
            let thickness = PerVertex::filled(4, t);
            let demands = Demands {
                principal: &principal,
                thickness: Some(&thickness),
                field: None,
            };
            let sizes = relative_sizes(&surface, &demands, length, &options).unwrap();
            length * sizes[phex_mesh::VertexId::new(0)]
        };
        for t in [0.003, 0.01] {
            let sagitta = size_at(t).powi(2) * 2.0 / 8.0;
            assert!((sagitta - 0.25 * t).abs() < 1e-12, "{sagitta}");
        }
        assert!((size_at(1.0) - 0.2).abs() < 1e-12);
        assert!((size_at(1e-9) - 0.3 * 0.25 * length).abs() < 1e-12);
    }
}
