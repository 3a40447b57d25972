//! The Gauss image for edge-distance offsets of a mesh that has been cut: inner edges touch the
//! unit sphere, those of the cut do not.
//!
//! A panel of a Koebe mesh meets the sphere in a circle of angular radius `phi_f` about its normal.
//! The circles of two panels touch each other where their common edge touches the sphere, so that
//!
//! ```text
//! phi_f + phi_g = theta_fg                              for the angle between their normals,
//! phi_f = (theta_fg + theta_fh - theta_gh) / 2          where three of them meet.
//! ```
//!
//! One vertex inside gives all radii, and all other edges check them. What the cut made goes with
//! that: the end of an inner edge moves as the vertex at its other end, so that the edge keeps its
//! length and no sliver of a panel collapses; corners of the cut within a panel move in between, by
//! the length of the way. So every vertex stays in the planes of its panels, and inner edges have
//! beams without torsion. Edges of the cut turn within their panels. They can't all be kept
//! parallel: the image of a boundary curve would have to move sideways by the integral of its
//! geodesic torsion, which need not come back to where it started.
//!
//! | symbol | here |
//! |---|---|
//! | `phi_f` | `radii`, radians |
//! | `theta_fg` | `angle` |
//!
//! *Guaranteed*: inner edges keep their distance to rounding, panels stay planar and parallel.
//! *Fails*: where an inner edge does not close, and where the Koebe mesh is not convex.

use super::{EdgeGaussImage, corner_rows, facing, touching};
use crate::offset::OffsetError;
use crate::offset::face_offset::face_normals;
use crate::offset::gauss_image::{GaussImage, OffsetKind};
use nalgebra::Matrix3;
use phex_mesh::{EdgeId, FaceId, HexMesh, PerEdge, PerFace, PerVertex, Topology, Vec3, VertexId};
use std::collections::VecDeque;

/// The image by the inner edges of a mesh, whether they close or not; `None` without any.
///
/// # Errors
/// If a face has no area.
pub(super) fn inner_edge_image(
    mesh: &HexMesh,
    vertex_normals: &PerVertex<Vec3>,
) -> Result<Option<EdgeGaussImage>, OffsetError> {
    let t = mesh.topology();
    let Some(first) = t.inner_edges().next() else {
        return Ok(None);
    };
    let circles = PanelCircles::of(mesh, first)?;
    let contacts = PerEdge::from_fn(t.n_edges(), |e| circles.contact(e));
    let mut positions = PerVertex::from_fn(t.n_vertices(), |v| image_of(mesh, v, &contacts));
    for row in corner_rows(mesh, t.edge_vertices(first)[0]) {
        for (v, share) in row.shares(mesh) {
            positions[v] = positions[row.from].lerp(&positions[row.to], share);
        }
    }
    let (edge, defect) = largest_gap(mesh, &positions, &contacts, first);
    Ok(Some(EdgeGaussImage {
        facing: facing(&positions, vertex_normals),
        image: GaussImage {
            kind: OffsetKind::Edge,
            positions,
        },
        defect,
        edge,
        free_edges: t.boundary_edges().collect(),
    }))
}

/// The circles in which the panels of the image meet the unit sphere.
struct PanelCircles<'a> {
    mesh: &'a HexMesh,
    normals: PerFace<Vec3>,
    /// Angular radii.
    radii: PerFace<f64>,
}

/// Where two circles touch each other.
#[derive(Clone, Copy)]
struct InnerEdge {
    point: Vec3,
    /// Unit direction of the edge.
    along: Vec3,
    /// How far apart the places are that the two circles say.
    gap: f64,
}

impl<'a> PanelCircles<'a> {
    /// Radii spread from a vertex inside; without one the first two circles are of one size.
    fn of(mesh: &'a HexMesh, first: EdgeId) -> Result<Self, OffsetError> {
        let t = mesh.topology();
        let normals = face_normals(mesh)?;
        let inside = t.inner_vertices().next();
        let (root, radius) = match inside {
            Some(v) => {
                let around: Vec<FaceId> = t.faces_at(v).collect();
                let angle = |i: usize, k: usize| angle(&normals[around[i]], &normals[around[k]]);
                (around[0], (angle(0, 1) + angle(0, 2) - angle(1, 2)) / 2.0)
            }
            None => {
                let [f, g] = t.faces_beside(first).unwrap_or([FaceId::new(0); 2]);
                (f, angle(&normals[f], &normals[g]) / 2.0)
            }
        };
        let radii = spread(t, &normals, root, radius);
        Ok(Self {
            mesh,
            normals,
            radii,
        })
    }

    /// Where an edge touches the sphere: where the circles of its panels say, in the middle.
    fn contact(&self, e: EdgeId) -> Option<InnerEdge> {
        let t = self.mesh.topology();
        let [f, g] = t.faces_beside(e)?;
        let [a, b] = t.edge_vertices(e);
        let along = (self.mesh.position(b) - self.mesh.position(a)).normalize();
        let towards = |f: FaceId, g: FaceId| {
            let across = along.cross(&self.normals[f]);
            let (sin, cos) = self.radii[f].sin_cos();
            self.normals[f] * cos + across * (sin * across.dot(&self.normals[g]).signum())
        };
        let [p, q] = [towards(f, g), towards(g, f)];
        let middle = touching(p + q, &along);
        Some(InnerEdge {
            point: middle.normalize(),
            along,
            gap: (p - q).norm(),
        })
    }
}

/// Angle of two unit vectors, radians, accurate for small ones, too.
fn angle(a: &Vec3, b: &Vec3) -> f64 {
    a.cross(b).norm().atan2(a.dot(b))
}

/// Radii of all circles from that of one; each next one fills the angle between the normals.
fn spread(t: &Topology, normals: &PerFace<Vec3>, root: FaceId, radius: f64) -> PerFace<f64> {
    let mut radii: PerFace<Option<f64>> = PerFace::filled(t.n_faces(), None);
    radii[root] = Some(radius);
    let mut queue = VecDeque::from([(root, radius)]);
    while let Some((f, radius)) = queue.pop_front() {
        for g in t.adjacent_faces(f) {
            if radii[g].is_none() {
                let next = angle(&normals[f], &normals[g]) - radius;
                radii[g] = Some(next);
                queue.push_back((g, next));
            }
        }
    }
    radii.map(|r| r.unwrap_or(radius))
}

/// Where the lines of the inner edges at a vertex meet. With one of them the vertex goes with the
/// other end of that edge or, if it is the only one there, too, to its point on the sphere. Zero
/// without any.
fn image_of(mesh: &HexMesh, v: VertexId, contacts: &PerEdge<Option<InnerEdge>>) -> Vec3 {
    let edges = mesh.topology().spokes(v).into_iter();
    let mut inner = edges.filter_map(|(e, to)| Some((contacts[e]?, to)));
    meeting(mesh, v, contacts).unwrap_or_else(|| match inner.next() {
        Some((contact, to)) => meeting(mesh, to, contacts).unwrap_or(contact.point),
        None => Vec3::zeros(),
    })
}

/// The point nearest to the lines of the inner edges at a vertex; `None` with fewer than two.
fn meeting(mesh: &HexMesh, v: VertexId, contacts: &PerEdge<Option<InnerEdge>>) -> Option<Vec3> {
    let edges = mesh.topology().spokes(v).into_iter();
    let lines: Vec<InnerEdge> = edges.filter_map(|(e, _)| contacts[e]).collect();
    if lines.len() < 2 {
        return None;
    }
    let across = |c: &InnerEdge| Matrix3::identity() - c.along * c.along.transpose();
    let matrix: Matrix3<f64> = lines.iter().map(across).sum();
    let right: Vec3 = lines.iter().map(|c| c.point).sum();
    matrix.cholesky().map(|c| c.solve(&right))
}

/// The inner edge whose ends or circles disagree most about where it touches.
fn largest_gap(
    mesh: &HexMesh,
    positions: &PerVertex<Vec3>,
    contacts: &PerEdge<Option<InnerEdge>>,
    first: EdgeId,
) -> (EdgeId, f64) {
    let mut largest = (first, 0.0);
    for (e, contact) in contacts.enumerate() {
        let Some(c) = contact else { continue };
        let ends = mesh.topology().edge_vertices(e);
        let gaps = ends.map(|v| (touching(positions[v], &c.along) - c.point).norm());
        for gap in gaps.into_iter().chain([c.gap]) {
            if gap > largest.1 || gap.is_nan() {
                largest = (e, gap);
            }
        }
    }
    largest
}
