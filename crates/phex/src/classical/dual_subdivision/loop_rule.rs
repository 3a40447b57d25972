//! Loop's rule, which at the rim does to quadratic functions what it does inside.

use super::rim::{self, Stencil};
use crate::smooth_surface::subdivide::{Refinement, Splits, edge_stencil, vertex_stencil};
use phex_mesh::{EdgeId, Topology, VertexId};

/// One step: old vertices are smoothed, new ones follow from the two triangles at their edge.
pub(super) fn refinement(topology: &Topology) -> (Refinement, Topology) {
    Refinement::with_stencils(
        topology,
        &Splits::all(topology),
        |v| vertex(topology, v),
        |e| edge(topology, e),
    )
}

fn vertex(topology: &Topology, v: VertexId) -> Stencil {
    let from = topology.outgoing(v).next();
    let Some(from) = from.filter(|_| topology.is_boundary_vertex(v)) else {
        return vertex_stencil(topology, v);
    };
    let ring = [
        (1.0, 0.0),
        (0.0, 1.0),
        (-1.0, 1.0),
        (-1.0, 0.0),
        (0.0, -1.0),
        (1.0, -1.0),
    ];
    let around = ring.map(|(i, j)| (rim::lattice(i, j), 0.0625));
    let mut rule = around.to_vec();
    rule.push((rim::lattice(0.0, 0.0), 0.625));
    rim::stencil(topology, from, &rule).unwrap_or_else(|| vec![(v, 1.0)])
}

fn edge(topology: &Topology, e: EdgeId) -> Stencil {
    if !topology.is_boundary_edge(e) {
        return edge_stencil(topology, e);
    }
    let rule = [
        (0.0, 0.0, 0.375),
        (1.0, 0.0, 0.375),
        (0.0, 1.0, 0.125),
        (1.0, -1.0, 0.125),
    ];
    let rule = rule.map(|(i, j, w)| (rim::lattice(i, j), w));
    let from = topology.edge_half_edge(e);
    rim::stencil(topology, from, &rule).unwrap_or_else(|| edge_stencil(topology, e))
}
