//! Level lines of a multivalued function as polylines on the surface.

use super::function::Function;
use phex_mesh::{EdgeId, FaceId, HalfEdgeId, Topology, TriangleSurface, Vec3};
use std::collections::BTreeMap;

/// A curve of a network.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its points, in order; a closed curve does not repeat the first one.
    pub points: Vec<Vec3>,
    /// Whether the last point is joined to the first.
    pub closed: bool,
}

/// The curves on which `function` has whole values, in the order of the edges that they begin in.
/// The function's periods must be whole.
pub(crate) fn level_lines(surface: &TriangleSurface, function: &Function) -> Vec<Curve> {
    let topology = surface.topology();
    let mut links: BTreeMap<Crossing, Vec<Crossing>> = BTreeMap::new();
    for f in topology.faces() {
        for [a, b] in segments(topology, function, f) {
            links.entry(a).or_default().push(b);
            links.entry(b).or_default().push(a);
        }
    }
    let place = |c: &Crossing| c.place(surface, function);
    let mut curves = Vec::new();
    // Open curves first, from their ends; what remains is closed.
    let ends: Vec<Crossing> = links
        .iter()
        .filter(|(_, l)| l.len() == 1)
        .map(|(c, _)| *c)
        .collect();
    for start in ends {
        let chain = take_chain(&mut links, start);
        if chain.len() > 1 {
            curves.push(Curve {
                points: chain.iter().map(place).collect(),
                closed: false,
            });
        }
    }
    while let Some((&start, _)) = links.iter().next() {
        let chain = take_chain(&mut links, start);
        curves.push(Curve {
            points: chain.iter().map(place).collect(),
            closed: chain.len() > 2,
        });
    }
    curves
}

/// Where a level crosses an edge; the level is counted in the chart of the edge's first vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Crossing {
    edge: EdgeId,
    level: i64,
}

impl Crossing {
    fn place(&self, surface: &TriangleSurface, function: &Function) -> Vec3 {
        let [a, b] = surface.topology().edge_vertices(self.edge);
        let t = (self.level as f64 - function.value[a]) / function.change[self.edge];
        let t = if t.is_finite() {
            t.clamp(0.0, 1.0)
        } else {
            0.5
        };
        surface.positions()[a] * (1.0 - t) + surface.positions()[b] * t
    }
}

/// Pieces of level lines in a triangle. A corner on a level counts as above it, so that each level
/// crosses two sides.
fn segments(topology: &Topology, function: &Function, f: FaceId) -> Vec<[Crossing; 2]> {
    let corners = function.corners(topology, f);
    let low = corners.iter().copied().fold(f64::INFINITY, f64::min);
    let high = corners.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (first, last) = (low.floor() as i64, high.ceil() as i64);
    let mut list = Vec::new();
    for level in first..=last {
        let above = corners.map(|c| c >= level as f64);
        let crossed: Vec<Crossing> = topology
            .face_half_edges(f)
            .enumerate()
            .filter(|(k, _)| above[*k] != above[(k + 1) % 3])
            .map(|(k, h)| crossing(topology, function, h, corners, k, level))
            .collect();
        if let [a, b] = crossed[..] {
            list.push([a, b]);
        }
    }
    list
}

fn crossing(
    topology: &Topology,
    function: &Function,
    h: HalfEdgeId,
    corners: [f64; 3],
    k: usize,
    level: i64,
) -> Crossing {
    let edge = topology.edge(h);
    let start = topology.edge_vertices(edge)[0];
    let here = if topology.origin(h) == start {
        corners[k]
    } else {
        corners[(k + 1) % 3]
    };
    let shift = (here - function.value[start]).round() as i64;
    Crossing {
        edge,
        level: level - shift,
    }
}

/// Follows the links from `start`, removing them.
fn take_chain(links: &mut BTreeMap<Crossing, Vec<Crossing>>, start: Crossing) -> Vec<Crossing> {
    let mut chain = Vec::new();
    let mut next = Some(start);
    while let Some(at) = next {
        next = links
            .remove(&at)
            .and_then(|l| l.into_iter().find(|c| links.contains_key(c)));
        chain.push(at);
    }
    chain
}
