//! Small holes, which directions run across as if the surface went on there.
//!
//! Round a hole a field turns at no price, so that cones gather in small holes and beside them, and
//! panels shrink towards them. A fan of triangles over each hole takes that away. The open end of a
//! column is no such hole: to close it would take the Gauss curvature of a cap, 2 pi for a tube,
//! and rows go round it.

use super::intrinsic::IntrinsicMesh;
use super::turns::cones;
use super::{DirectionOptions, Directions};
use nalgebra::Matrix3;
use phex_mesh::polygon::sides;
use phex_mesh::{EdgeId, FaceId, PerEdge, PerVertex, TriangleSurface, Vec3, VertexId};
use std::f64::consts::{FRAC_PI_3, PI};

/// Largest length of the rim of a hole, lattice spacings, that directions run across: round larger
/// holes, which are four panels across, there is room for rows of their own.
const SMALL_RIM: f64 = 12.0;

/// Largest Gauss curvature of what closes a hole that directions run across, radians: that of a cap
/// on a cone whose sides are 60 degrees steep.
const LARGEST_CAP: f64 = PI;

/// A surface with a fan of triangles over each of its small holes: the vertices and triangles of
/// the surface come first, then a vertex in the middle of each hole.
pub(super) struct FilledSurface {
    /// The surface with its fans.
    pub surface: TriangleSurface,
    /// A vertex on the rim of each hole.
    beside: Vec<VertexId>,
}

impl FilledSurface {
    /// That of a surface with a metric, where it has small holes; the longest rim is no hole.
    pub fn new(surface: &TriangleSurface, metric: &PerVertex<Matrix3<f64>>) -> Option<Self> {
        let length = |rim: &[VertexId]| rim_length(surface, metric, rim);
        let mut rims = surface.boundary_loops();
        rims.sort_by(|a, b| length(b).total_cmp(&length(a)));
        let is_small = |rim: &[VertexId]| {
            length(rim) < SMALL_RIM && cap_curvature(surface, rim).abs() < LARGEST_CAP
        };
        let small: Vec<&Vec<VertexId>> = rims.iter().skip(1).filter(|rim| is_small(rim)).collect();
        if small.is_empty() {
            return None;
        }
        let mut triangles: Vec<[u32; 3]> = surface.triangles().collect();
        let mut positions = surface.positions().clone().into_vec();
        for rim in &small {
            let middle = positions.len() as u32;
            let sum: Vec3 = rim.iter().map(|v| positions[v.index()]).sum();
            positions.push(sum / rim.len() as f64);
            // The surface lies to the left of its rim, the fan to the right.
            let fan = sides(rim).map(|[a, b]| [b.index() as u32, a.index() as u32, middle]);
            triangles.extend(fan);
        }
        let filled = TriangleSurface::new(positions, &triangles).ok()?;
        let normals = surface.normals().iter().copied();
        let middles = filled
            .normals()
            .iter()
            .skip(surface.normals().len())
            .copied();
        let normals = PerVertex::from_vec(normals.chain(middles).collect());
        Some(Self {
            surface: filled.with_normals(normals),
            beside: small.iter().map(|rim| rim[0]).collect(),
        })
    }

    /// What is known at each vertex of the surface, in the middle of a hole as on its rim.
    pub fn extended<T: Copy>(&self, known: &PerVertex<T>) -> PerVertex<T> {
        let middles = self.beside.iter().map(|v| known[*v]);
        PerVertex::from_vec(known.iter().copied().chain(middles).collect())
    }

    /// Weights of alignment with the surface, which is not there in the middle of a hole.
    pub fn weights(&self, known: &PerVertex<f64>) -> PerVertex<f64> {
        let middles = self.beside.iter().map(|_| 0.0);
        PerVertex::from_vec(known.iter().copied().chain(middles).collect())
    }

    /// The directions of the filled surface on the open one.
    pub fn opened(
        &self,
        surface: &TriangleSurface,
        filled: &Directions,
        options: &DirectionOptions,
    ) -> Directions {
        let topology = surface.topology();
        let metric: Vec<Matrix3<f64>> = filled.metric.iter().copied().collect();
        let metric = PerVertex::from_vec(metric[..topology.n_vertices()].to_vec());
        let mesh = IntrinsicMesh::new(surface, &metric).with_mirrors(surface, &options.mirrors);
        let within = self.surface.topology();
        // Half-edges of the surface have the same numbers in both.
        let angle = PerVertex::from_fn(topology.n_vertices(), |v| {
            let h = topology.outgoing(v).next().expect("each vertex has one");
            let turned = filled.angle[v] - filled.intrinsic.polar(within, h);
            let is_rim = topology.is_boundary_vertex(v) && !within.is_boundary_vertex(v);
            let unscaled = match is_rim {
                true => filled.intrinsic.angle_sum[v] / (2.0 * PI),
                false => 1.0,
            };
            mesh.polar(topology, h) + turned * unscaled
        });
        let turn = PerEdge::from_fn(topology.n_edges(), |e: EdgeId| {
            let h = topology.edge_half_edge(e);
            let edge = within.edge(h);
            let rest = within.along(h, filled.rest(within, edge));
            let [i, j] = topology.edge_vertices(e);
            let turned = angle[j] - angle[i] - mesh.transport(e) - rest;
            (turned / FRAC_PI_3).round() as i32
        });
        Directions {
            cone: cones(topology, &mesh, &angle, &turn),
            metric,
            intrinsic: mesh,
            angle,
            turn,
            cancelled: filled.cancelled,
        }
    }
}

/// Whether a surface has holes that directions for panels of a length can run across.
pub(crate) fn has_small_holes(surface: &TriangleSurface, length: &PerVertex<f64>) -> bool {
    let metric = length.map(|l| Matrix3::from_diagonal_element(l.powi(-2)));
    FilledSurface::new(surface, &metric).is_some()
}

/// Gauss curvature of a disc that goes on smoothly from the rim of a hole, radians, by the theorem
/// of Gauss and Bonnet: 0 for a hole in a plate, 2 pi for the end of a tube.
fn cap_curvature(surface: &TriangleSurface, rim: &[VertexId]) -> f64 {
    let topology = surface.topology();
    let angle_in = |v: VertexId, f: FaceId| {
        let others = topology.face_vertices(f).iter().filter(|w| **w != v);
        let mut sides = others.map(|w| surface.positions()[*w] - surface.positions()[v]);
        sides
            .next()
            .zip(sides.next())
            .map_or(0.0, |(a, b)| a.angle(&b))
    };
    let angle = |v: VertexId| topology.faces_at(v).map(|f| angle_in(v, f)).sum::<f64>();
    2.0 * PI + rim.iter().map(|v| PI - angle(*v)).sum::<f64>()
}

/// Length of a closed line of vertices in a metric.
fn rim_length(
    surface: &TriangleSurface,
    metric: &PerVertex<Matrix3<f64>>,
    rim: &[VertexId],
) -> f64 {
    let length = |[a, b]: [VertexId; 2]| {
        let d = surface.positions()[b] - surface.positions()[a];
        (0.5 * d.dot(&((metric[a] + metric[b]) * d))).sqrt()
    };
    sides(rim).map(length).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of a cone round its axis, `steep` radians steep, with 40 places round it; the first
    /// rim is the lower, larger one.
    fn strip(steep: f64) -> TriangleSurface {
        let n = 40_u32;
        let ring = |r: f64| {
            (0..n).map(move |k| {
                let turn = 2.0 * PI * f64::from(k) / f64::from(n);
                let height = (2.0 - r) * steep.tan();
                Vec3::new(r * turn.cos(), r * turn.sin(), height)
            })
        };
        let next = |k: u32| (k + 1) % n;
        let triangles: Vec<[u32; 3]> = (0..n)
            .flat_map(|k| [[k, next(k), n + k], [next(k), n + next(k), n + k]])
            .collect();
        TriangleSurface::new(ring(2.0).chain(ring(1.0)).collect(), &triangles).unwrap()
    }

    #[test]
    fn a_hole_is_closed_by_a_cap_as_steep_as_the_surface_round_it() {
        for steep in [0.0_f64, 0.5, 1.2] {
            let surface = strip(steep);
            let mut rims = surface.boundary_loops();
            rims.sort_by_key(|rim| std::cmp::Reverse(rim[0]));
            let expected = 2.0 * PI * (1.0 - steep.cos());
            let found = cap_curvature(&surface, &rims[0]);
            assert!(
                (found - expected).abs() < 0.05,
                "{steep}: {found} {expected}"
            );
        }
    }

    #[test]
    fn directions_run_across_the_hole_of_a_flat_ring_and_not_across_the_end_of_a_column() {
        let has_hole = |steep: f64| {
            let surface = strip(steep);
            let length = PerVertex::filled(surface.positions().len(), 2.0);
            has_small_holes(&surface, &length)
        };
        assert!(has_hole(0.0) && has_hole(0.8));
        assert!(!has_hole(1.3));
    }
}
