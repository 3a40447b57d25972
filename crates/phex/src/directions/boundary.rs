//! The boundary as a direction: where a lattice row could run along it.

use super::intrinsic::IntrinsicMesh;
use nalgebra::Complex;
use phex_mesh::{HalfEdgeId, PerVertex, Topology, VertexId};
use std::f64::consts::PI;

/// The boundary at one of its vertices, in the vertex's polar coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoundaryFrame {
    /// Polar angle of the direction that points inwards, half-way between the two boundary edges.
    pub inward: f64,
    /// Angle by which the boundary turns here (positive to the left, where the surface lies).
    pub turning: f64,
    /// Half the length of the two boundary edges, lattice spacings.
    pub length: f64,
    /// Mean of `exp(6 i t)` over the directions `t` of the two edges: of length 1 where a lattice
    /// can follow both.
    pub alignment: Complex<f64>,
}

/// Turning, radians, from which on a mirror plane has an end.
const CORNER_TURN: f64 = 0.3;

impl BoundaryFrame {
    /// Whether a mirror plane in which the boundary lies has an end here.
    pub fn ends_mirror(&self) -> bool {
        self.turning.abs() >= CORNER_TURN
    }
}

/// Frames of the vertices on the boundary; `None` inside.
pub(crate) fn frames(
    topology: &Topology,
    mesh: &IntrinsicMesh,
) -> PerVertex<Option<BoundaryFrame>> {
    PerVertex::from_fn(topology.n_vertices(), |v: VertexId| {
        topology
            .is_boundary_vertex(v)
            .then(|| frame(topology, mesh, v))
    })
}

fn frame(topology: &Topology, mesh: &IntrinsicMesh, v: VertexId) -> BoundaryFrame {
    let angle = mesh.angle_sum[v];
    let side = |h: HalfEdgeId| mesh.length[topology.edge(h)];
    let [out, back] = boundary_half_edges(topology, v);
    let (ahead, behind) = (side(out), side(back));
    // The first edge lies at angle 0, the last at `angle`; both count by their length.
    let mean =
        (Complex::new(ahead, 0.0) + Complex::from_polar(behind, 6.0 * angle)) / (ahead + behind);
    BoundaryFrame {
        inward: 0.5 * angle,
        turning: PI - angle,
        length: 0.5 * (ahead + behind),
        alignment: mean,
    }
}

/// Angle, radians, by which a straight side may turn in all.
const STRAIGHT: f64 = 0.05;

/// Frames of the vertices on the longest straight side of the boundary alone: on a plane rows
/// follow it everywhere, where all sides together would bend them.
pub(crate) fn on_longest_side(
    topology: &Topology,
    frames: &PerVertex<Option<BoundaryFrame>>,
) -> PerVertex<Option<BoundaryFrame>> {
    let mut longest: (f64, Vec<VertexId>) = (0.0, Vec::new());
    for side in topology
        .boundary_loops()
        .iter()
        .flat_map(|l| sides(l, frames))
    {
        let length = side
            .iter()
            .filter_map(|v| frames[*v])
            .map(|f| f.length)
            .sum();
        if length > longest.0 {
            longest = (length, side);
        }
    }
    let mut kept = PerVertex::filled(topology.n_vertices(), None);
    longest.1.iter().for_each(|v| kept[*v] = frames[*v]);
    kept
}

/// The straight sides of a loop, without the corners between them, from its sharpest corner on.
fn sides(boundary: &[VertexId], frames: &PerVertex<Option<BoundaryFrame>>) -> Vec<Vec<VertexId>> {
    let turning = |i: usize| frames[boundary[i]].map_or(0.0, |f| f.turning);
    let sharper = |i: &usize, j: &usize| turning(*i).abs().total_cmp(&turning(*j).abs());
    let first = (0..boundary.len()).max_by(sharper).unwrap_or(0);
    let mut sides = vec![Vec::new()];
    let mut turned = 0.0;
    for i in (0..boundary.len()).map(|k| (first + k) % boundary.len()) {
        turned += turning(i);
        if f64::abs(turned) < STRAIGHT {
            sides.last_mut().expect("there is a side").push(boundary[i]);
        } else {
            sides.push(Vec::new());
            turned = 0.0;
        }
    }
    sides
}

/// The half-edge along the boundary that leaves a boundary vertex, and the one that enters it.
pub(crate) fn boundary_half_edges(topology: &Topology, v: VertexId) -> [HalfEdgeId; 2] {
    let mut outgoing = topology.outgoing(v);
    let first = outgoing.next().expect("a vertex has an outgoing half-edge");
    let last = outgoing.last().unwrap_or(first);
    [first, topology.prev(last)]
}
