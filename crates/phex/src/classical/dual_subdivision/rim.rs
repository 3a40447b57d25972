//! Rules of subdivision at the rim of a triangle mesh, where some of the vertices that they ask for
//! are missing.
//!
//! The triangles nearby are unfolded into the lattice of equilateral ones. What a rule would say
//! there of a quadratic function is said by the vertices that there are: of all weights that do so,
//! the least ones. So rows at the rim are curved like those inside; rules along the rim alone, or
//! with the missing vertices left out, know nothing of the curvature across it.

use nalgebra::{DMatrix, DVector};
use phex_mesh::{HalfEdgeId, Topology, Vec2, VertexId};
use std::collections::{BTreeMap, VecDeque};

pub(super) type Stencil = Vec<(VertexId, f64)>;

/// Height of an equilateral triangle over an edge of length 1.
const HEIGHT: f64 = 0.866_025_403_784_438_6;
/// How far from its place a rule looks, in edges.
const REACH: f64 = 2.1;
/// Sum of the absolute weights beyond which an extrapolation is not trusted.
const LARGEST: f64 = 4.0;

/// Lattice points by their coordinates along two sides of a triangle.
pub(super) fn lattice(i: f64, j: f64) -> Vec2 {
    Vec2::new(i + 0.5 * j, HEIGHT * j)
}

/// The stencil for a rule's points and weights in the lattice, whose origin is that of a half-edge,
/// which runs along the first axis, with its triangle above. `None` where the mesh is too small for
/// it.
pub(super) fn stencil(
    topology: &Topology,
    from: HalfEdgeId,
    rule: &[(Vec2, f64)],
) -> Option<Stencil> {
    let centre = rule.iter().map(|(p, w)| p * *w).sum::<Vec2>();
    let near = unfolded(topology, from, centre);
    [6, 3]
        .into_iter()
        .find_map(|terms| weights(&near, centre, rule, terms))
}

/// The least weights that agree with the rule on the first `terms` monomials.
fn weights(
    near: &BTreeMap<VertexId, Vec2>,
    centre: Vec2,
    rule: &[(Vec2, f64)],
    terms: usize,
) -> Option<Stencil> {
    if near.len() < terms {
        return None;
    }
    let moments = |p: &Vec2| {
        let d = p - centre;
        [1.0, d.x, d.y, d.x * d.x, d.x * d.y, d.y * d.y]
    };
    let points: Vec<(VertexId, Vec2)> = near.iter().map(|(v, p)| (*v, *p)).collect();
    let trust: Vec<f64> = points
        .iter()
        .map(|(_, p)| 1.0 / (1.0 + (p - centre).norm_squared()))
        .collect();
    let matrix = DMatrix::from_fn(terms, points.len(), |i, j| {
        moments(&points[j].1)[i] * trust[j]
    });
    let wanted = DVector::from_fn(terms, |i, _| {
        rule.iter().map(|(p, w)| w * moments(p)[i]).sum::<f64>()
    });
    let svd = matrix.svd(true, true);
    if svd.rank(1e-6) < terms {
        return None;
    }
    let solved = svd.solve(&wanted, 1e-9).ok()?;
    let weights = solved.iter().zip(&trust).map(|(w, t)| w * t);
    let made: Stencil = points.iter().map(|p| p.0).zip(weights).collect();
    (made.iter().map(|s| s.1.abs()).sum::<f64>() < LARGEST).then_some(made)
}

/// Vertices near a place, where they are with the triangles unfolded.
fn unfolded(topology: &Topology, from: HalfEdgeId, centre: Vec2) -> BTreeMap<VertexId, Vec2> {
    let ends = [
        (topology.origin(from), lattice(0.0, 0.0)),
        (topology.target(from), lattice(1.0, 0.0)),
    ];
    let mut placed = BTreeMap::from(ends);
    // Half-edges whose triangle lies beyond those that are placed, with their ends.
    let mut open = VecDeque::from([(from, ends.map(|e| e.1))]);
    if let Some(twin) = topology.twin(from) {
        open.push_back((twin, [ends[1].1, ends[0].1]));
    }
    while let Some((h, [a, b])) = open.pop_front() {
        let (d, apex) = (b - a, topology.target(topology.next(h)));
        let place = (a + b) * 0.5 + Vec2::new(-d.y, d.x) * HEIGHT;
        if (place - centre).norm() > REACH || placed.contains_key(&apex) {
            continue;
        }
        placed.insert(apex, place);
        let sides = [
            (topology.next(h), [b, place]),
            (topology.prev(h), [place, a]),
        ];
        for (side, [p, q]) in sides {
            open.extend(topology.twin(side).map(|twin| (twin, [q, p])));
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::super::{butterfly, loop_rule};
    use super::*;
    use crate::smooth_surface::subdivide::Refinement;
    use phex_mesh::PerVertex;

    const SIDE: u32 = 6;

    /// A rhombus of the lattice, and where its vertices are.
    fn rhombus() -> (Topology, PerVertex<Vec2>) {
        let at = |i: u32, j: u32| i * SIDE + j;
        let cells = (1..SIDE).flat_map(|i| (1..SIDE).map(move |j| (i - 1, j - 1)));
        let faces = cells.flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)];
            [[a, b, c], [b, d, c]]
        });
        let faces: Vec<[u32; 3]> = faces.collect();
        let count = (SIDE * SIDE) as usize;
        let place = |v: VertexId| {
            let v = v.index() as u32;
            lattice(f64::from(v / SIDE), f64::from(v % SIDE))
        };
        (
            Topology::from_faces(count, &faces).unwrap(),
            PerVertex::from_fn(count, place),
        )
    }

    fn quadratic(p: &Vec2) -> f64 {
        0.3 + p.x - 2.0 * p.y + 0.7 * p.x * p.x - 1.1 * p.x * p.y + 0.4 * p.y * p.y
    }

    /// Value and place of every refined vertex.
    fn refined(step: &Refinement, place: &PerVertex<Vec2>) -> Vec<(f64, Vec2)> {
        let values = step.apply(&place.map(quadratic));
        let places = step.apply(place);
        values.iter().copied().zip(places.iter().copied()).collect()
    }

    #[test]
    fn rules_do_to_quadratics_at_the_rim_what_they_do_inside() {
        let (topology, place) = rhombus();
        let (step, _) = butterfly::refinement(&topology);
        for (value, p) in refined(&step, &place) {
            assert!((value - quadratic(&p)).abs() < 1e-9, "{p:?}: {value}");
        }
        // Loop's rule adds a constant to quadratics, one at old vertices and another at new ones.
        let (step, _) = loop_rule::refinement(&topology);
        let made = refined(&step, &place);
        let pulled = |k: usize| made[k].0 - quadratic(&made[k].1);
        let (old, new) = (0..topology.n_vertices(), topology.n_vertices()..made.len());
        let first = (SIDE + 1) as usize;
        assert!(pulled(first).abs() > 0.1);
        assert!(
            old.into_iter()
                .all(|k| (pulled(k) - pulled(first)).abs() < 1e-9)
        );
        let along = |e| {
            let [a, b] = topology.edge_vertices(e).map(|v| place[v]);
            b - a
        };
        // Inside, the constant of an edge depends on its direction only.
        for (e, k) in topology.edges().zip(new) {
            let inner = topology
                .edges()
                .zip(topology.n_vertices()..)
                .find(|(f, _)| {
                    !topology.is_boundary_edge(*f)
                        && (along(*f) - along(e))
                            .norm()
                            .min((along(*f) + along(e)).norm())
                            < 1e-9
                });
            let (_, same) = inner.unwrap();
            assert!((pulled(k) - pulled(same)).abs() < 1e-9, "{e}");
        }
    }
}
