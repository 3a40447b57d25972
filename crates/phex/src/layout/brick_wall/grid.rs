//! The pattern laid on a surface: coordinates in bricks and rows at every vertex, continued across
//! triangles.

use super::bricks::{Brick, Translation, rounded_periods, wall_crossing};
use crate::directions::network::ConjugateNetwork;
use phex_mesh::{
    EdgeId, FaceId, HalfEdgeId, PerEdge, PerVertex, Topology, TriangleSurface, VertexId,
};

/// Brick coordinates on a surface.
#[derive(Clone, Debug)]
pub(crate) struct BrickGrid {
    /// Coordinates `(u, v)` of each vertex, in bricks and rows.
    pub at: PerVertex<[f64; 2]>,
    /// Translation that continues the coordinates of an edge's second vertex to its first, along
    /// its half-edge.
    jump: PerEdge<Translation>,
}

/// Corners of a triangle in one chart.
pub(crate) type Chart = [[f64; 2]; 3];

impl BrickGrid {
    /// The network at `scale` (bricks and rows per length), with periods rounded to translations of
    /// the pattern.
    pub fn new(
        surface: &TriangleSurface,
        network: &ConjugateNetwork,
        scale: [f64; 2],
        offset: [f64; 2],
    ) -> Self {
        let topology = surface.topology();
        let wanted: Vec<[f64; 2]> = (network.along.periods.iter())
            .zip(&network.across.periods)
            .map(|(u, v)| [u * scale[0], v * scale[1]])
            .collect();
        let periods = rounded_periods(&wanted);
        let of = |k: usize, unit: f64| periods.iter().map(move |p| unit * p[k] as f64).collect();
        let (along, across): (Vec<f64>, Vec<f64>) = (of(0, 0.5), of(1, 1.0));
        let u = (network.along).function(topology, &network.basis, scale[0], &along);
        let v = (network.across).function(topology, &network.basis, scale[1], &across);
        let at = |i: VertexId| [u.value[i] + offset[0], v.value[i] + offset[1]];
        let jump = |e: EdgeId| {
            let terms = network.basis.iter().zip(&periods);
            terms.fold([0, 0], |[half, row], (cochain, p)| {
                let times = i64::from(cochain[e]);
                [half + times * p[0], row + times * p[1]]
            })
        };
        Self {
            at: PerVertex::from_fn(topology.n_vertices(), at),
            jump: PerEdge::from_fn(topology.n_edges(), jump),
        }
    }

    /// Translation along a half-edge.
    pub(crate) fn jump(&self, topology: &Topology, h: HalfEdgeId) -> Translation {
        let e = topology.edge(h);
        if topology.runs_along(h) {
            self.jump[e]
        } else {
            self.jump[e].map(|t| -t)
        }
    }

    /// Coordinates of the target of a half-edge in the chart of its origin.
    pub fn target(&self, topology: &Topology, h: HalfEdgeId) -> [f64; 2] {
        shifted(self.at[topology.target(h)], self.jump(topology, h))
    }

    /// Corners of a triangle in the chart of its first corner.
    pub(crate) fn chart(&self, topology: &Topology, f: FaceId) -> Chart {
        let corners = topology.face_vertices(f);
        let jumps = self.corner_jumps(topology, f);
        std::array::from_fn(|k| shifted(self.at[corners[k]], jumps[k]))
    }

    /// Bricks that hold the corners of a triangle, in the chart of its first corner.
    pub(crate) fn corner_bricks(
        &self,
        topology: &Topology,
        bricks: &PerVertex<Brick>,
        f: FaceId,
    ) -> [Brick; 3] {
        let corners = topology.face_vertices(f);
        let jumps = self.corner_jumps(topology, f);
        std::array::from_fn(|k| bricks[corners[k]].moved(jumps[k]))
    }

    fn corner_jumps(&self, topology: &Topology, f: FaceId) -> [Translation; 3] {
        let mut jumps = [[0, 0]; 3];
        for (k, h) in topology.face_half_edges(f).take(2).enumerate() {
            let step = self.jump(topology, h);
            jumps[k + 1] = [jumps[k][0] + step[0], jumps[k][1] + step[1]];
        }
        jumps
    }

    /// The triangle across side `k`, continued from a chart.
    pub fn across(
        &self,
        topology: &Topology,
        f: FaceId,
        chart: &Chart,
        k: usize,
    ) -> Option<(FaceId, Chart)> {
        let h = topology.face_half_edges(f).nth(k)?;
        let twin = topology.twin(h)?;
        let g = topology.face(twin);
        let first = topology.face_half_edges(g).position(|x| x == twin)?;
        let (origin, target) = (chart[(k + 1) % 3], chart[k]);
        let next = topology.next(twin);
        let (from, to) = (self.at[topology.origin(next)], self.target(topology, next));
        let mut continued = [[0.0; 2]; 3];
        continued[first] = origin;
        continued[(first + 1) % 3] = target;
        continued[(first + 2) % 3] = [target[0] + to[0] - from[0], target[1] + to[1] - from[1]];
        Some((g, continued))
    }

    /// The brick of each vertex. Vertices of the boundary count as lying a little inside, so that
    /// rounding does not decide where the boundary runs along a row.
    pub fn bricks(&self, topology: &Topology) -> PerVertex<Brick> {
        const INWARDS: f64 = 0.4;
        PerVertex::from_fn(topology.n_vertices(), |v| {
            let [mut u, mut w] = self.at[v];
            if topology.is_boundary_vertex(v) {
                let ring = self.ring(topology, v);
                let mean = |k: usize| {
                    ring.iter().map(|p| p[k]).sum::<f64>() / ring.len() as f64 - self.at[v][k]
                };
                u += INWARDS * mean(0);
                w += INWARDS * mean(1);
            }
            Brick::containing([u, w])
        })
    }

    /// Coordinates of the neighbours of a vertex in its chart.
    fn ring(&self, topology: &Topology, v: VertexId) -> Vec<[f64; 2]> {
        let mut ring = Vec::new();
        for h in topology.outgoing(v) {
            ring.push(self.target(topology, h));
            let before = topology.prev(h);
            if topology.twin(before).is_none() {
                let back = self.jump(topology, before).map(|t| -t);
                ring.push(shifted(self.at[topology.origin(before)], back));
            }
        }
        ring
    }

    /// Number of the cell of each vertex (the connected part of a brick), and the vertex nearest to
    /// the middle of the brick for each cell.
    pub fn cells(
        &self,
        topology: &Topology,
        bricks: &PerVertex<Brick>,
    ) -> (PerVertex<u32>, Vec<VertexId>) {
        const NONE: u32 = u32::MAX;
        let mut label = PerVertex::filled(topology.n_vertices(), NONE);
        let mut middles: Vec<VertexId> = Vec::new();
        for start in topology.vertices() {
            if label[start] != NONE {
                continue;
            }
            let number = middles.len() as u32;
            let mut middle = (f64::INFINITY, start);
            label[start] = number;
            let mut stack = vec![start];
            while let Some(v) = stack.pop() {
                middle = closer(middle, (self.off_centre(v, bricks[v]), v));
                for w in self.brick_mates(topology, bricks, v) {
                    if label[w] == NONE {
                        label[w] = number;
                        stack.push(w);
                    }
                }
            }
            middles.push(middle.1);
        }
        (label, middles)
    }

    fn off_centre(&self, v: VertexId, brick: Brick) -> f64 {
        let (p, c) = (self.at[v], brick.centre());
        (p[0] - c[0]).hypot(p[1] - c[1])
    }

    /// Neighbours of a vertex in the same brick.
    fn brick_mates(
        &self,
        topology: &Topology,
        bricks: &PerVertex<Brick>,
        v: VertexId,
    ) -> Vec<VertexId> {
        let mut mates = Vec::new();
        for h in topology.outgoing(v) {
            let w = topology.target(h);
            if bricks[w].moved(self.jump(topology, h)) == bricks[v] {
                mates.push(w);
            }
            let before = topology.prev(h);
            let w = topology.origin(before);
            let back = self.jump(topology, before).map(|t| -t);
            if topology.twin(before).is_none() && bricks[w].moved(back) == bricks[v] {
                mates.push(w);
            }
        }
        mates
    }

    /// Share of the way along an edge's half-edge at which it crosses the wall between the bricks
    /// of its ends.
    pub fn crossing(&self, topology: &Topology, bricks: &PerVertex<Brick>, e: EdgeId) -> f64 {
        let h = topology.edge_half_edge(e);
        let (a, b) = (topology.origin(h), topology.target(h));
        let of_b = bricks[b].moved(self.jump(topology, h));
        wall_crossing([self.at[a], self.target(topology, h)], [bricks[a], of_b])
    }
}

fn shifted(p: [f64; 2], [half, row]: Translation) -> [f64; 2] {
    [p[0] + 0.5 * half as f64, p[1] + row as f64]
}

fn closer(a: (f64, VertexId), b: (f64, VertexId)) -> (f64, VertexId) {
    if b.0 < a.0 || (b.0 == a.0 && b.1 < a.1) {
        b
    } else {
        a
    }
}
