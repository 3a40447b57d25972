//! Panels cut along the boundary curve.
//!
//! Every edge is walked for the places where it leaves or enters the surface; they become vertices
//! that both panels share. A place nearer than [`NEAR`] to an end of the edge is moved to that end,
//! so that no tiny edges arise. The parts of a panel's outline that lie inside are then joined
//! along the boundary curve, which has the surface on its left as the panel has.

use super::curve::{LoopPoint, OutlineLoops};
use super::follow::is_simple;
use super::{Domain, TrimError, Trimmed, compact, near_boundary};
use phex_mesh::{EdgeId, FaceId, FacePlane, HexMesh, PerEdge, PerFace, Vec3};

/// Largest distance between the boundary curve and the edges that stand for it, over the largest
/// that is allowed.
const OF_LIMIT: f64 = 0.2;
/// Intervals into which an edge is divided to find where it crosses the boundary.
const INTERVALS: usize = 16;
/// Bisections that locate a crossing.
const BISECTIONS: usize = 40;
/// Share of an edge nearer than which a crossing is moved to the edge's end.
const NEAR: f64 = 0.12;
/// Distance, diagonals, over which a crossing is never moved.
const NEAR_LENGTH: f64 = 2.5e-3;

/// The panels' parts inside the boundary.
pub(super) fn clipped(mesh: &HexMesh, domain: &Domain<'_>) -> Result<Trimmed, TrimError> {
    let near = near_boundary(mesh, domain.original);
    let mut cut = Cut::new(mesh, domain, &near);
    let (mut faces, mut parent) = (Vec::new(), Vec::new());
    for f in mesh.topology().faces() {
        for face in cut.parts(f) {
            faces.push(face);
            parent.push(f);
        }
    }
    Ok(Trimmed {
        mesh: compact(&cut.positions, &faces)?,
        parent: PerFace::from_vec(parent),
    })
}

/// The curve along which panels are cut.
pub(super) fn curve(domain: &Domain<'_>) -> OutlineLoops {
    let tolerance = OF_LIMIT * domain.limit;
    OutlineLoops::of(domain.original, domain.corner_angle, tolerance)
}

/// An edge between its cuts: vertices in the direction of its half-edge, and whether each piece
/// between them is inside.
#[derive(Clone, Debug)]
struct CutEdge {
    vertices: Vec<u32>,
    inside: Vec<bool>,
}

/// All edges with their cuts.
struct Cut<'a> {
    mesh: &'a HexMesh,
    positions: Vec<Vec3>,
    edges: PerEdge<CutEdge>,
    curve: OutlineLoops,
    domain: &'a Domain<'a>,
    /// Distance over which a crossing is never moved.
    near_length: f64,
}

impl<'a> Cut<'a> {
    fn new(mesh: &'a HexMesh, domain: &'a Domain<'a>, near: &[bool]) -> Self {
        let topology = mesh.topology();
        let mut positions = mesh.positions.as_slice().to_vec();
        let near_length = NEAR_LENGTH * domain.original.diagonal();
        let edges = PerEdge::from_fn(topology.n_edges(), |e: EdgeId| {
            let close = topology.edge_faces(e).any(|f| near[f.index()]);
            cut_edge(mesh, domain, e, close, near_length, &mut positions)
        });
        Self {
            mesh,
            positions,
            edges,
            curve: curve(domain),
            domain,
            near_length,
        }
    }

    /// What is left of a panel: usually one polygon, none if it lies outside.
    fn parts(&mut self, f: FaceId) -> Vec<Vec<u32>> {
        let (vertices, inside) = self.outline(f);
        if inside.iter().all(|i| *i) {
            return vec![vertices];
        }
        let runs = runs(&vertices, &inside);
        let corners: Vec<Vec3> = self.mesh.corners(f).collect();
        let plane = FacePlane::fit(&corners);
        let parts = self.joined(&runs, &plane);
        if parts.iter().all(|p| p.is_simple(self, &plane)) {
            return parts.into_iter().map(|p| p.outline).collect();
        }
        // A corner that reaches to the curve between two cuts, or over it, parts the panel.
        let split = self.split_at_curve(&runs);
        let split = self.joined(&split, &plane);
        let sound = |parts: &[PanelPart]| {
            let simple = parts.iter().filter(|p| p.is_simple(self, &plane));
            simple.map(|p| p.outline.len()).sum::<usize>()
        };
        let parts = if sound(&split) > sound(&parts) {
            split
        } else {
            parts
        };
        let kept = parts.into_iter().filter_map(|p| p.sound(self, &plane));
        kept.collect()
    }

    /// Runs cut at the vertices that lie on the curve or beyond it.
    fn split_at_curve(&self, runs: &[Vec<u32>]) -> Vec<Vec<u32>> {
        let reaches = |v: u32| {
            let p = self.positions[v as usize];
            let distance = (self.curve.at(self.curve.closest(p)) - p).norm();
            distance < self.near_length || !self.domain.contains(p)
        };
        let mut split = Vec::new();
        for run in runs {
            let mut part = vec![run[0]];
            for (i, &v) in run.iter().enumerate().skip(1) {
                part.push(v);
                if i + 1 < run.len() && reaches(v) {
                    split.push(std::mem::replace(&mut part, vec![v]));
                }
            }
            split.push(part);
        }
        split
    }

    /// A panel's outline with all cuts, and whether the piece after each vertex is inside.
    fn outline(&self, f: FaceId) -> (Vec<u32>, Vec<bool>) {
        let topology = self.mesh.topology();
        let (mut vertices, mut inside) = (Vec::new(), Vec::new());
        for h in topology.face_half_edges(f) {
            let edge = &self.edges[topology.edge(h)];
            let n = edge.inside.len();
            if topology.runs_along(h) {
                vertices.extend(&edge.vertices[..n]);
                inside.extend(&edge.inside);
            } else {
                vertices.extend(edge.vertices[1..].iter().rev());
                inside.extend(edge.inside.iter().rev());
            }
        }
        (vertices, inside)
    }

    /// Joins runs along the boundary curve: from the end of each to the start of the one that comes
    /// next on the curve.
    fn joined(&mut self, runs: &[Vec<u32>], plane: &FacePlane) -> Vec<PanelPart> {
        let place = |v: u32| self.curve.closest(self.positions[v as usize]);
        let starts: Vec<LoopPoint> = runs.iter().map(|r| place(r[0])).collect();
        let ends: Vec<LoopPoint> = runs.iter().map(|r| place(r[r.len() - 1])).collect();
        let mut used = vec![false; runs.len()];
        let mut parts = Vec::new();
        for first in 0..runs.len() {
            let (mut part, mut at) = (Vec::new(), first);
            let mut bare = Vec::new();
            while !used[at] {
                used[at] = true;
                part.extend(&runs[at]);
                bare.extend(&runs[at]);
                let ahead = |k: &usize| self.curve.ahead(ends[at], starts[*k]);
                // Runs of a panel that is parted in a corner begin where others end; there it is
                // parted, not joined.
                let apart = |k: usize| runs[k].first() != runs[at].last();
                let open = (0..runs.len()).filter(|&k| (!used[k] || k == first) && apart(k));
                let next = open
                    .min_by(|a, b| ahead(a).total_cmp(&ahead(b)))
                    .unwrap_or(first);
                self.follow(ends[at], starts[next], plane, &mut part);
                at = next;
            }
            if !part.is_empty() {
                parts.push(PanelPart {
                    outline: part,
                    bare,
                });
            }
        }
        parts
    }

    /// Adds vertices along the curve between two places, in the plane of the panel.
    fn follow(&mut self, from: LoopPoint, to: LoopPoint, plane: &FacePlane, part: &mut Vec<u32>) {
        let Some(&last) = part.last() else { return };
        let (begin, end) = (self.positions[last as usize], self.curve.at(to));
        for p in self.curve.between(from, to, begin, end) {
            let flat = p - plane.normal * plane.height(p);
            part.push(self.positions.len() as u32);
            self.positions.push(flat);
        }
    }
}

/// A part of a panel.
struct PanelPart {
    outline: Vec<u32>,
    /// The same without its vertices along the curve.
    bare: Vec<u32>,
}

impl PanelPart {
    fn is_simple(&self, cut: &Cut<'_>, plane: &FacePlane) -> bool {
        is_simple(&self.outline, &cut.positions, plane)
    }

    /// The part if it is a simple polygon, else without its vertices along the curve, else nothing.
    fn sound(self, cut: &Cut<'_>, plane: &FacePlane) -> Option<Vec<u32>> {
        let mut either = [self.outline, self.bare].into_iter();
        either.find(|face| is_simple(face, &cut.positions, plane))
    }
}

/// Stretches of an outline that are inside, each with the vertices at both its ends.
fn runs(vertices: &[u32], inside: &[bool]) -> Vec<Vec<u32>> {
    let n = vertices.len();
    let begins = (0..n).filter(|&i| inside[i] && !inside[(i + n - 1) % n]);
    begins
        .map(|start| {
            let length = (0..n).take_while(|k| inside[(start + k) % n]).count();
            (0..=length).map(|k| vertices[(start + k) % n]).collect()
        })
        .collect()
}

fn cut_edge(
    mesh: &HexMesh,
    domain: &Domain<'_>,
    e: EdgeId,
    close: bool,
    near_length: f64,
    positions: &mut Vec<Vec3>,
) -> CutEdge {
    let [a, b] = mesh.topology().edge_vertices(e);
    let (p, q) = (mesh.positions[a], mesh.positions[b]);
    let inside = |t: f64| domain.contains(p + (q - p) * t);
    let ends = [a, b].map(|v| v.index() as u32);
    if !close {
        return CutEdge {
            vertices: ends.to_vec(),
            inside: vec![inside(0.5)],
        };
    }
    let near = NEAR.min(near_length / (q - p).norm());
    let cuts: Vec<f64> = crossings(inside)
        .into_iter()
        .filter(|t| *t > near && *t < 1.0 - near)
        .collect();
    let cuts = without_close_pairs(cuts, near);
    let stops: Vec<f64> = std::iter::once(0.0)
        .chain(cuts.iter().copied())
        .chain([1.0])
        .collect();
    let mut vertices = vec![ends[0]];
    for t in &cuts {
        vertices.push(positions.len() as u32);
        positions.push(p + (q - p) * *t);
    }
    vertices.push(ends[1]);
    CutEdge {
        vertices,
        inside: stops
            .windows(2)
            .map(|w| inside(0.5 * (w[0] + w[1])))
            .collect(),
    }
}

/// Parameters where a predicate changes along an edge, ascending.
fn crossings(inside: impl Fn(f64) -> bool) -> Vec<f64> {
    let at = |i: usize| i as f64 / INTERVALS as f64;
    let states: Vec<bool> = (0..=INTERVALS).map(|i| inside(at(i))).collect();
    let changes = (0..INTERVALS).filter(|&i| states[i] != states[i + 1]);
    changes
        .map(|i| {
            let (mut low, mut high) = (at(i), at(i + 1));
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                if inside(middle) == states[i] {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            0.5 * (low + high)
        })
        .collect()
}

/// Drops pairs of crossings that are so close to each other that the piece between them does not
/// count.
fn without_close_pairs(cuts: Vec<f64>, near: f64) -> Vec<f64> {
    let mut kept: Vec<f64> = Vec::new();
    for t in cuts {
        match kept.last() {
            Some(last) if t - last < near => {
                kept.pop();
            }
            _ => kept.push(t),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{domain, square};
    use super::*;
    use crate::smooth_surface::extend;
    use phex_mesh::FlatFace;

    /// A panel across the boundary whose re-entrant corner reaches a little beyond it, with two
    /// panels in the notch: both its parts are kept, and meet in that corner.
    #[test]
    fn a_corner_beyond_the_curve_parts_a_panel() {
        let original = square();
        let extension = extend::extend(&original, 0.5, 0.5).unwrap();
        let domain = domain(&original, &extension);
        let at = [
            (0.5, -0.2),
            (2.5, -0.2),
            (2.5, 0.8),
            (1.5, -0.005),
            (0.5, 0.8),
            (1.5, 2.0),
        ];
        let positions = at.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec();
        let faces: [&[u32]; 3] = [&[0, 1, 2, 3, 4], &[3, 2, 5], &[3, 5, 4]];
        let mesh = HexMesh::new(positions, &faces).unwrap();
        let left = clipped(&mesh, &domain).unwrap();
        let parts = left.parent.enumerate().filter(|(_, p)| p.index() == 0);
        let areas: Vec<f64> = parts
            .map(|(f, _)| FlatFace::new(&left.mesh.corners(f).collect::<Vec<_>>()).area())
            .collect();
        assert_eq!(areas.len(), 2);
        assert!(
            areas.iter().all(|a| (a - 0.4).abs() < 0.01),
            "{areas:?}: the boundary cuts either part to a triangle"
        );
    }
}
