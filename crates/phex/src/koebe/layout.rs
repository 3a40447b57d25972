//! Circles of known radii laid out in the plane, kite by kite, small circles first.
//!
//! Errors of a placement are proportional to the distances that it spans. Going outwards from the
//! smallest circle keeps every error small beside the circles around, which is what counts on the
//! sphere.

use super::circles::{Circles, NodeId};
use super::radii::Radii;
use phex_mesh::{EdgeId, HalfEdgeId, PerEdge, Vec2};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// A circle of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PlaneCircle {
    /// A circle with its inside.
    Circle { centre: Vec2, radius: f64 },
    /// The half-plane `normal . z >= offset`.
    HalfPlane { normal: Vec2, offset: f64 },
}

/// Circles and touching points in the plane.
#[derive(Clone, Debug)]
pub(super) struct PlaneLayout {
    /// One circle per node.
    pub circles: Vec<PlaneCircle>,
    /// Touching point of each edge; `None` for the point at infinity.
    pub touching: PerEdge<Option<Vec2>>,
}

/// A circle that waits for its place: seen from `from`, the kite `via` points in the direction
/// `axis`.
struct Waiting {
    radius: f64,
    node: NodeId,
    from: NodeId,
    via: HalfEdgeId,
    axis: f64,
}

impl PartialEq for Waiting {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Waiting {}
impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let by_radius = other.radius.total_cmp(&self.radius);
        by_radius
            .then(other.node.cmp(&self.node))
            .then(other.via.cmp(&self.via))
    }
}

struct CirclePlacer<'a> {
    circles: &'a Circles<'a>,
    radii: &'a Radii,
    placed: Vec<Option<PlaneCircle>>,
    touching: PerEdge<Option<Vec2>>,
    waiting: BinaryHeap<Waiting>,
}

/// Lays out every circle; `None` if a circle is joined to no other one of finite radius.
pub(super) fn lay_out(circles: &Circles, radii: &Radii) -> Option<PlaneLayout> {
    let n = circles.n_nodes();
    let mut builder = CirclePlacer {
        circles,
        radii,
        placed: vec![None; n],
        touching: PerEdge::filled(circles.topology.n_edges(), None),
        waiting: BinaryHeap::new(),
    };
    let first = circles
        .nodes()
        .min_by(|&a, &b| radii.rho[a].total_cmp(&radii.rho[b]))?;
    let kite = *circles.kites(first).first()?;
    builder.place(first, Vec2::zeros(), kite, 0.0);
    while let Some(next) = builder.waiting.pop() {
        builder.place_waiting(&next);
    }
    Some(PlaneLayout {
        circles: builder.placed.into_iter().collect::<Option<_>>()?,
        touching: builder.touching,
    })
}

impl CirclePlacer<'_> {
    fn place_waiting(&mut self, next: &Waiting) {
        if self.placed[next.node].is_some() {
            return;
        }
        let Some(PlaneCircle::Circle { centre, radius }) = self.placed[next.from] else {
            return;
        };
        let normal = direction(next.axis);
        if next.radius.is_finite() {
            let centre = centre + normal * radius.hypot(next.radius);
            self.place(
                next.node,
                centre,
                next.via,
                next.axis + std::f64::consts::PI,
            );
        } else {
            let offset = normal.dot(&centre);
            self.placed[next.node] = Some(PlaneCircle::HalfPlane { normal, offset });
        }
    }

    /// Places a circle of finite radius whose kite `via` points in the direction `axis`.
    fn place(&mut self, node: NodeId, centre: Vec2, via: HalfEdgeId, axis: f64) {
        let radius = self.radii.radius(node);
        self.placed[node] = Some(PlaneCircle::Circle { centre, radius });
        for (kite, other, axis, half) in self.fan(node, via, axis) {
            let (start, end) = self.kite_edges(node, kite);
            for (edge, angle) in [(start, axis - half), (end, axis + half)] {
                self.touching[edge].get_or_insert(centre + direction(angle) * radius);
            }
            if self.placed[other].is_none() {
                let radius = self.radii.radius(other);
                self.waiting.push(Waiting {
                    radius,
                    node: other,
                    from: node,
                    via: kite,
                    axis,
                });
            }
        }
    }

    /// Kites at a circle with the other circle, the direction of the axis and half the angle of
    /// each.
    fn fan(&self, node: NodeId, via: HalfEdgeId, axis: f64) -> Vec<(HalfEdgeId, NodeId, f64, f64)> {
        let mut cursor = 0.0;
        let mut shift = 0.0;
        let mut fan = Vec::new();
        for kite in self.circles.kites(node) {
            let other = self.circles.other(kite, node);
            let half = self.radii.half_angle(node, other);
            if kite == via {
                shift = axis - (cursor + half);
            }
            fan.push((kite, other, cursor + half, half));
            cursor += 2.0 * half;
        }
        fan.iter_mut().for_each(|kite| kite.2 += shift);
        fan
    }

    /// Edges at which a kite begins and ends, counter-clockwise round one of its circles.
    fn kite_edges(&self, node: NodeId, kite: HalfEdgeId) -> (EdgeId, EdgeId) {
        let t = self.circles.topology;
        let (own, previous) = (t.edge(kite), t.edge(t.prev(kite)));
        if self.circles.vertex(node).is_some() {
            (own, previous)
        } else {
            (previous, own)
        }
    }
}

fn direction(angle: f64) -> Vec2 {
    let (sin, cos) = angle.sin_cos();
    Vec2::new(cos, sin)
}
