//! The modified butterfly rule.

use super::rim::{self, Stencil};
use crate::smooth_surface::subdivide::{Refinement, Splits};
use phex_mesh::{EdgeId, HalfEdgeId, Topology, VertexId};
use std::f64::consts::TAU;

/// One step: old vertices stay, new ones follow from their neighbourhood.
pub(super) fn refinement(topology: &Topology) -> (Refinement, Topology) {
    Refinement::with_stencils(
        topology,
        &Splits::all(topology),
        |v| vec![(v, 1.0)],
        |e| edge(topology, e),
    )
}

fn edge(topology: &Topology, e: EdgeId) -> Stencil {
    let h = topology.edge_half_edge(e);
    let sides = topology.twin(h).map(|twin| [h, twin]);
    let ends = [topology.origin(h), topology.target(h)].map(|v| irregularity(topology, v));
    match (sides, ends) {
        (Some(sides), [None, None]) => {
            regular(topology, sides).unwrap_or_else(|| at_rim(topology, h))
        }
        (Some([h, twin]), [Some(_), Some(_)]) => {
            let both = [irregular(topology, h), irregular(topology, twin)];
            both.into_iter()
                .flatten()
                .map(|(v, w)| (v, 0.5 * w))
                .collect()
        }
        (Some([h, _]), [Some(_), None]) => irregular(topology, h),
        (Some([_, twin]), [None, Some(_)]) => irregular(topology, twin),
        (None, _) => at_rim(topology, h),
    }
}

/// The valence of an inner vertex where it is not 6; the boundary counts as regular.
fn irregularity(topology: &Topology, v: VertexId) -> Option<usize> {
    let valence = topology.edge_degree(v);
    (!topology.is_boundary_vertex(v) && valence != 6).then_some(valence)
}

/// Eight points: `(8, 8, 2, 2, -1, -1, -1, -1) / 16`, if they are all there.
fn regular(topology: &Topology, sides: [HalfEdgeId; 2]) -> Option<Stencil> {
    let mut stencil = Stencil::new();
    for h in sides {
        let (next, previous) = (topology.next(h), topology.prev(h));
        stencil.push((topology.origin(h), 0.5));
        stencil.push((topology.origin(previous), 0.125));
        for wing in [next, previous] {
            let wing = topology.twin(wing)?;
            stencil.push((topology.origin(topology.prev(wing)), -1.0 / 16.0));
        }
    }
    Some(stencil)
}

/// What the eight points would say of a quadratic function.
fn at_rim(topology: &Topology, h: HalfEdgeId) -> Stencil {
    let points = [
        (0.0, 0.0, 0.5),
        (1.0, 0.0, 0.5),
        (0.0, 1.0, 0.125),
        (1.0, -1.0, 0.125),
        (1.0, 1.0, -0.0625),
        (-1.0, 1.0, -0.0625),
        (2.0, -1.0, -0.0625),
        (0.0, -1.0, -0.0625),
    ];
    let rule = points.map(|(i, j, w)| (rim::lattice(i, j), w));
    let ends = [topology.origin(h), topology.target(h)];
    rim::stencil(topology, h, &rule).unwrap_or_else(|| ends.map(|v| (v, 0.5)).to_vec())
}

/// The rule round an irregular vertex, for the edge that leaves it.
fn irregular(topology: &Topology, from: HalfEdgeId) -> Stencil {
    let centre = topology.origin(from);
    let ring: Vec<VertexId> = topology
        .outgoing(centre)
        .map(|h| topology.target(h))
        .collect();
    let n = ring.len();
    let first = topology
        .outgoing(centre)
        .position(|h| h == from)
        .unwrap_or(0);
    let weight = |j: usize| match (n, j) {
        (3, 0) => 5.0 / 12.0,
        (3, _) => -1.0 / 12.0,
        (4, 0) => 3.0 / 8.0,
        (4, 2) => -1.0 / 8.0,
        (4, _) => 0.0,
        _ => {
            let t = TAU * j as f64 / n as f64;
            (0.25 + t.cos() + 0.5 * (2.0 * t).cos()) / n as f64
        }
    };
    let around = (0..n).map(|j| (ring[(first + j) % n], weight(j)));
    std::iter::once((centre, 0.75)).chain(around).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

    #[test]
    fn weights_sum_to_one_and_a_plane_stays_plane() {
        for name in ["ellipsoid", "monkey-saddle", "torus"] {
            let options = TriangulationOptions {
                triangles: 300,
                ..Default::default()
            };
            let surface = triangulate(&Shape::from_name(name, &[]).unwrap(), &options).unwrap();
            let topology = surface.topology();
            for e in topology.edges() {
                let sum: f64 = edge(topology, e).iter().map(|s| s.1).sum();
                assert!((sum - 1.0).abs() < 1e-14, "{name}");
            }
        }
    }

    #[test]
    fn regular_lattices_are_interpolated_to_third_order() {
        let options = TriangulationOptions {
            triangles: 400,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name("plane", &[]).unwrap(), &options).unwrap();
        let topology = surface.topology();
        let cubic = |p: phex_mesh::Vec3| p.x.powi(3) - 2.0 * p.x * p.y * p.y + p.y * p.y - p.x;
        let mut inner = 0;
        for e in topology.edges() {
            let [a, b] = topology.edge_vertices(e);
            let near = |v| {
                topology
                    .neighbours(v)
                    .iter()
                    .all(|w| !topology.is_boundary_vertex(*w))
            };
            if ![a, b]
                .into_iter()
                .all(|v| near(v) && topology.edge_degree(v) == 6)
            {
                continue;
            }
            let middle = (surface.positions()[a] + surface.positions()[b]) * 0.5;
            let value: f64 = edge(topology, e)
                .iter()
                .map(|(v, w)| w * cubic(surface.positions()[*v]))
                .sum();
            assert!(
                (value - cubic(middle)).abs() < 1e-12,
                "{value} {}",
                cubic(middle)
            );
            inner += 1;
        }
        assert!(inner > 50);
    }
}
