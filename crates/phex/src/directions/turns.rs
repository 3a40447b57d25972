//! Whole turns of a direction field along edges, the cones they make, and cones that move.
//!
//! With the turns `p` of the field along edges as unknowns of their own, a cone moves across an
//! edge when its turn changes by one. Moved into its opposite, or out of the boundary, it vanishes.
//! With the turns fixed the angles are the solution of one linear system,
//!
//! ```text
//! min  sum_e w_e (t_j - t_i - r_e - p_e pi/3)^2  +  sum_v a_v (t_v - wish_v)^2 .
//! ```
//!
//! Source: trivial connections (Crane, Desbrun, Schroeder 2010).

use super::intrinsic::{Distance, IntrinsicMesh, row};
use super::rosy::SixFoldField;
use nalgebra::Complex;
use phex_mesh::{EdgeId, FaceId, IdMap, PerEdge, PerFace, PerVertex, Topology, VertexId};
use phex_numeric::{Cholesky, NumericError, SymmetricMatrix};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::{FRAC_PI_3, PI};

/// Solves with the wishes taken anew, because they are known up to a sixth of a turn.
const SOLVES: usize = 3;
/// Hold on the last angles, over the area, which decides where there is no wish.
const HOLD: f64 = 1e-6;

/// Turns along edges and the cones that they make.
pub(crate) struct Turns {
    /// Turns along each edge from its origin to its target, sixths.
    pub turn: PerEdge<i32>,
    /// Index in each triangle, sixths.
    pub cone: PerFace<i32>,
}

impl Turns {
    /// The turns with the smallest rest for given angles.
    pub fn smallest(topology: &Topology, mesh: &IntrinsicMesh, angle: &PerVertex<f64>) -> Self {
        let turn = smallest_turns(topology, mesh, angle);
        Self {
            cone: cones(topology, mesh, angle, &turn),
            turn,
        }
    }

    /// Carries an index from the beginning of a route to its end.
    pub fn carry(&mut self, topology: &Topology, route: &Route, index: i32) {
        for &(f, e) in &route.path {
            self.turn[e] += index * side(topology, f, e);
        }
        self.cone[route.from] -= index;
        if let Some(to) = route.to {
            self.cone[to] += index;
        }
    }
}

/// A way over triangles, each with the edge to leave it by.
pub(crate) struct Route {
    /// Length, lattice spacings.
    pub length: f64,
    /// The first triangle.
    pub from: FaceId,
    /// The last one, or none: out of the boundary.
    pub to: Option<FaceId>,
    path: Vec<(FaceId, EdgeId)>,
}

/// The shortest ways from a triangle to those within `reach` lattice spacings that `wanted` names,
/// at `most` so many, the shortest first. Where `leaving`, the one out of the boundary is the last.
pub(crate) fn routes(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    from: FaceId,
    (reach, most): (f64, usize),
    leaving: bool,
    wanted: impl Fn(FaceId) -> bool,
) -> Vec<Route> {
    let mut known = ReachedTriangles::default();
    known.insert(from, (0.0, None));
    let mut heap = BinaryHeap::from([Reverse((Distance(0.0), from))]);
    let mut found = Vec::new();
    let mut exit: Option<(f64, FaceId, EdgeId)> = None;
    while let Some(Reverse((Distance(length), f))) = heap.pop() {
        if length > known[&f].0 {
            continue;
        }
        if exit.is_some_and(|e| e.0 <= length) {
            break;
        }
        if wanted(f) {
            found.push(Route {
                length,
                from,
                to: Some(f),
                path: path_to(&known, f),
            });
            if found.len() >= most {
                break;
            }
        }
        for h in topology.face_half_edges(f) {
            let Some(twin) = topology.twin(h) else {
                let out = length + mesh.half_crossing(f);
                if leaving && exit.is_none_or(|e| out < e.0) {
                    exit = Some((out, f, topology.edge(h)));
                }
                continue;
            };
            let g = topology.face(twin);
            let next = length + mesh.half_crossing(f) + mesh.half_crossing(g);
            if next <= reach && known.get(&g).is_none_or(|k| next < k.0) {
                known.insert(g, (next, Some((f, topology.edge(h)))));
                heap.push(Reverse((Distance(next), g)));
            }
        }
    }
    if let Some((length, f, edge)) = exit.filter(|_| found.len() < most) {
        let mut path = path_to(&known, f);
        path.push((f, edge));
        found.push(Route {
            length,
            from,
            to: None,
            path,
        });
    }
    found
}

/// Turns of the field along each edge with the smallest rest, in sixths.
pub(crate) fn smallest_turns(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    angle: &PerVertex<f64>,
) -> PerEdge<i32> {
    PerEdge::from_fn(topology.n_edges(), |e| {
        (rest(topology, mesh, angle, e) / FRAC_PI_3).round() as i32
    })
}

/// Angle by which the field turns along an edge.
pub(super) fn rest(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    angle: &PerVertex<f64>,
    e: EdgeId,
) -> f64 {
    let [i, j] = topology.edge_vertices(e);
    angle[j] - angle[i] - mesh.transport(e)
}

/// 1 if `f` lies to the left of the edge, else -1.
fn side(topology: &Topology, f: FaceId, e: EdgeId) -> i32 {
    if topology.face(topology.edge_half_edge(e)) == f {
        1
    } else {
        -1
    }
}

/// Index in each triangle of a field with given turns, in sixths.
pub(crate) fn cones(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    angle: &PerVertex<f64>,
    turn: &PerEdge<i32>,
) -> PerFace<i32> {
    PerFace::from_fn(topology.n_faces(), |f| {
        let (mut turned, mut holonomy) = (0.0, 0.0);
        for e in topology.face_half_edges(f).map(|h| topology.edge(h)) {
            let sign = f64::from(side(topology, f, e));
            turned += sign * (rest(topology, mesh, angle, e) - f64::from(turn[e]) * FRAC_PI_3);
            holonomy += sign * mesh.transport(e);
        }
        let holonomy = (holonomy + PI).rem_euclid(2.0 * PI) - PI;
        ((turned + holonomy) / FRAC_PI_3).round() as i32
    })
}

/// Distance of each triangle reached, and the triangle and edge before it.
type ReachedTriangles = IdMap<FaceId, (f64, Option<(FaceId, EdgeId)>)>;

fn path_to(known: &ReachedTriangles, to: FaceId) -> Vec<(FaceId, EdgeId)> {
    let mut path = Vec::new();
    let mut at = to;
    while let Some((before, edge)) = known[&at].1 {
        path.push((before, edge));
        at = before;
    }
    path.reverse();
    path
}

/// The angles that fit fixed turns best.
pub(crate) fn settle(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    field: &SixFoldField,
    turn: &PerEdge<i32>,
) -> Result<PerVertex<f64>, NumericError> {
    let factor = Cholesky::new(&matrix(topology, mesh, &field.wish)?)?;
    let mut angle = field.angle.clone();
    for _ in 0..SOLVES {
        let mut rhs = PerVertex::from_fn(topology.n_vertices(), |v: VertexId| {
            let wish = nearest(field.wish[v], angle[v]);
            field.wish[v].norm() * wish + HOLD * mesh.mass[v] * angle[v]
        });
        for e in topology.edges() {
            let [i, j] = topology.edge_vertices(e);
            let step = mesh.weight[e] * (mesh.transport(e) + f64::from(turn[e]) * FRAC_PI_3);
            rhs[i] -= step;
            rhs[j] += step;
        }
        let mut x = rhs.into_vec();
        factor.solve(&mut x);
        angle = PerVertex::from_vec(x);
    }
    Ok(angle)
}

fn matrix(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    wish: &PerVertex<Complex<f64>>,
) -> Result<SymmetricMatrix, NumericError> {
    let own = topology
        .vertices()
        .map(|v| (row(v), row(v), wish[v].norm() + HOLD * mesh.mass[v]));
    let edges = topology.edges().flat_map(|e| {
        let [i, j] = topology.edge_vertices(e).map(row);
        let w = mesh.weight[e];
        [(i, i, w), (j, j, w), (i.max(j), i.min(j), -w)]
    });
    SymmetricMatrix::from_triplets(topology.n_vertices(), own.chain(edges))
}

/// The angle of a wish, of its six the one nearest to `near`.
fn nearest(wish: Complex<f64>, near: f64) -> f64 {
    let angle = wish.arg() / 6.0;
    angle + ((near - angle) / FRAC_PI_3).round() * FRAC_PI_3
}
