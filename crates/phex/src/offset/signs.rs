//! Which edges of a parallel mesh run against those of its Gauss image, and what keeps its panels
//! simple then.
//!
//! `M + d M'` has edges at distance `d` from those of `M` if `M'` is a Koebe mesh parallel to `M`;
//! nothing asks that parallel edges point the same way. Let `S` be the shape operator where the
//! surface has the normal of an edge of `M'`, `d_e` the edge's direction, `m_e` the one across it,
//! and `R = S^-1` (so that `dp = R dn`). Panels that are hexagons of a regular lattice on the Gauss
//! sphere touch the surface in a lattice, too, and three of their planes meet in a circumcentre of
//! the metric `R`. The edge's length over that of its image is then, to first order,
//!
//! ```text
//! l_e / l'_e = (q_j + q_k - q_i) = (3 R(d_e, d_e) - R(m_e, m_e)) / 2
//!            = (3 II(m_e, m_e) - II(d_e, d_e)) / (2 K),
//! ```
//!
//! with `q_i = R(m_e, m_e)` across the edge and `q_j, q_k` those across the other two families, at
//! 60 degrees to it: the *sign rule*. On a sphere it is the radius for all edges. Where `K < 0` and
//! an edge is along a principal direction, `l = -(3 rho + 1) / 2, 1, 1` over the radius of
//! curvature across that edge, `rho` being the ratio of the radii: one family runs against its
//! image. On a minimal surface it is twice as long as the others.
//!
//! A hexagon with edges `-b, a, c, -b, a, c` turns by 120 degrees four times and by 60 degrees
//! twice the other way: two opposite corners are re-entrant. The *waist* is what is left between
//! them. The hexagon is simple if each of these two corners lies inside the lines of both edges at
//! the other: the diagonal between them parts it into two polygons without re-entrant corners, on
//! its two sides. For `-b, a, c` that is `b > a` and `b > c`, for principal directions `rho > 1/3`.
//! Where `K -> 0` lengths pass through zero, and there is no such mesh.
//!
//! | symbol | here |
//! |---|---|
//! | `l_e` | `SignedLengths::wished`, from [`EdgeSigns`] |
//! | waist | `Waist`, a linear form in the vertices |
//!
//! Source: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer freeform structures for
//! architecture" (2007) for parallel meshes; Wang and Liu, "A note on planar hexagonal meshes"
//! (2010) leaves edge offsets where `K < 0` open.
//!
//! *Guaranteed*: a panel with two re-entrant corners whose waist is open is simple. *Fails*, with
//! the face or edge: where the surface is flat, and where a panel can't be simple with such signs.

use super::space::ParallelSpace;
use crate::curvature::{CurvatureOptions, curvature, tangent_frame};
use nalgebra::Matrix3;
use phex_mesh::polygon::is_simple;
use phex_mesh::{
    BoundaryCurve, EdgeId, FaceId, FlatFace, HexMesh, PerEdge, TriangleSurface, Vec3, VertexId,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};
use thiserror::Error;

/// A good [`FitOptions::fairness`](super::FitOptions::fairness) with lengths by the sign rule: from
/// 0.01 to 0.3 panels are as close to a hyperbolic paraboloid as with 0.001, and have more
/// clearance (0.42, not 0.34).
pub const SIGNED_FAIRNESS: f64 = 0.03;

/// Which edges of a parallel mesh point against those of the given mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EdgeSigns {
    /// None.
    #[default]
    Positive,
    /// Those that the sign rule of the surface's normal curvatures says: none where `K > 0`, one of
    /// three families where `K < 0`.
    SignRule,
    /// These.
    Reversed(Vec<EdgeId>),
}

/// Why there are no signs, or no simple panels with them.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SignError {
    /// The rule has no answer.
    #[error(
        "the surface is flat near vertex {vertex} of it, where it has the normal of edge {edge} (vertices {} and {}): lengths of edges have no limit there",
        vertices[0], vertices[1]
    )]
    Flat {
        /// The edge.
        edge: EdgeId,
        /// Its ends.
        vertices: [VertexId; 2],
        /// The vertex of the surface.
        vertex: VertexId,
    },
    /// An edge that does not exist.
    #[error("edge {edge} is to be reversed, but the mesh has {edges} edges only")]
    NoSuchEdge {
        /// The edge.
        edge: EdgeId,
        /// Number of edges.
        edges: usize,
    },
    /// With these signs the corners of a panel turn by another angle than a full turn.
    #[error(
        "face {face} would turn by {} degrees with {reversed} of its {valence} edges reversed, a simple panel turns by 360: the surface's curvature changes its sign there, or an edge is near an asymptotic direction",
        turning.to_degrees().round()
    )]
    Turning {
        /// The face.
        face: FaceId,
        /// Sum of the turning angles, radians.
        turning: f64,
        /// Number of reversed edges.
        reversed: usize,
        /// Number of edges.
        valence: usize,
    },
}

/// Signed lengths that edges of a mesh parallel to a Gauss image are wished to have.
#[derive(Clone, Debug)]
pub(super) struct SignedLengths {
    /// Model units; negative where the edge runs against its image.
    pub wished: PerEdge<f64>,
    /// Waists of the panels with two re-entrant corners.
    pub waists: Vec<Waist>,
}

impl SignedLengths {
    /// `None` where no edge is reversed: panels are convex then. Where curvatures at the rim,
    /// which are estimated from one side, give no answer those a panel's length inside are taken.
    pub fn new(
        space: &ParallelSpace,
        surface: &TriangleSurface,
        signs: &EdgeSigns,
    ) -> Result<Option<Self>, SignError> {
        if *signs == EdgeSigns::Positive {
            return Ok(None);
        }
        let with = |places: &[VertexId]| {
            let ruled = ruled_lengths(space, surface, places)?;
            let wished = match signs {
                EdgeSigns::Reversed(edges) => reversed(&ruled, edges)?,
                _ => ruled,
            };
            let topology = space.mesh().topology();
            let waists = topology.faces().map(|f| waists_of(space, f, &wished));
            let waists = waists.collect::<Result<Vec<_>, _>>()?.concat();
            Ok(Some(Self { wished, waists }))
        };
        let all: Vec<VertexId> = surface.topology().vertices().collect();
        let inside = || with(&seen_all_round(surface, panel_length(space, surface)));
        with(&all).or_else(|error| inside().map_err(|_| error))
    }
}

/// Length of panels that would cover the surface.
fn panel_length(space: &ParallelSpace, surface: &TriangleSurface) -> f64 {
    (surface.area() / space.mesh().topology().n_faces() as f64).sqrt()
}

fn reversed(lengths: &PerEdge<f64>, edges: &[EdgeId]) -> Result<PerEdge<f64>, SignError> {
    let mut wished = lengths.clone().map(|l| l.abs());
    for &edge in edges {
        if edge.index() >= lengths.len() {
            let edges = lengths.len();
            return Err(SignError::NoSuchEdge { edge, edges });
        }
        wished[edge] = -lengths[edge].abs();
    }
    Ok(wished)
}

/// Signs, 1 or -1.
struct SideSigns {
    /// By which normals of the image's faces look away from the origin, whichever way they go
    /// round: where `K < 0` the Gauss map turns them over.
    image: f64,
    /// By which the surface's normals then look to the same side.
    surface: f64,
}

fn side_of(space: &ParallelSpace, surface: &TriangleSurface) -> SideSigns {
    let image = space.mesh();
    let sign = |x: f64| if x < 0.0 { -1.0 } else { 1.0 };
    let faces = || image.topology().faces();
    let outwards: f64 = faces().map(|f| space.normal(f).dot(&image.centre(f))).sum();
    let to: Vec3 = faces().map(|f| image.centre(f)).sum();
    let all = surface.topology().faces();
    let looks: Vec3 = all.map(|f| surface.area_vector(f)).sum();
    // A closed surface looks to all sides alike, and its normals point outwards.
    let open = !surface.topology().is_closed();
    SideSigns {
        image: sign(outwards),
        surface: if open { sign(to.dot(&looks)) } else { 1.0 },
    }
}

/// The lengths by the sign rule, with curvatures at some vertices of the surface.
fn ruled_lengths(
    space: &ParallelSpace,
    surface: &TriangleSurface,
    places: &[VertexId],
) -> Result<PerEdge<f64>, SignError> {
    let image = space.mesh();
    let topology = image.topology();
    let size = panel_length(space, surface);
    let curved = curvature(surface, size, &CurvatureOptions::default());
    let normals = edge_normals(space);
    let side = side_of(space, surface);
    let length = |edge: EdgeId| {
        let (along, normal) = (space.direction(edge), normals[edge] * side.image);
        let vertex = closest_normal(surface, places, &(normal * side.surface));
        let second = curved.tensor[vertex] * side.surface;
        let ratio = length_ratio(&second, &normal, &along);
        let length = image.edge_length(edge) * ratio;
        let flat = !length.is_finite() || length.abs() > FAR * surface.diagonal();
        let vertices = topology.edge_vertices(edge);
        let found = (!flat).then_some(length);
        found.ok_or(SignError::Flat {
            edge,
            vertices,
            vertex,
        })
    };
    let lengths = topology.edges().map(length).collect::<Result<_, _>>()?;
    Ok(PerEdge::from_vec(lengths))
}

/// Vertices whose curvature is estimated from all sides: a panel's length from the boundary, or any
/// where there are none so far inside.
pub(super) fn seen_all_round(surface: &TriangleSurface, size: f64) -> Vec<VertexId> {
    let vertices = || surface.topology().vertices();
    let Some(boundary) = BoundaryCurve::of(surface) else {
        return vertices().collect();
    };
    let is_inside = |v: &VertexId| !boundary.is_within(surface.positions()[*v], size);
    let inside: Vec<VertexId> = vertices().filter(is_inside).collect();
    match inside.is_empty() {
        true => vertices().collect(),
        false => inside,
    }
}

/// The sign rule: length of an edge in a direction over that of its image, for a second fundamental
/// form; infinite or not a number where `K = 0`. Where `K > 0` no edge runs against the others: one
/// that would, because the lattice is turned off the direction of the larger radius, is short.
pub(super) fn length_ratio(second: &Matrix3<f64>, normal: &Vec3, along: &Vec3) -> f64 {
    let [x, y] = tangent_frame(*normal);
    let form = |a: &Vec3, b: &Vec3| a.dot(&(second * b));
    let gauss = form(&x, &x) * form(&y, &y) - form(&x, &y).powi(2);
    let across = normal.cross(along);
    let ratio = (3.0 * form(&across, &across) - form(along, along)) / (2.0 * gauss);
    if gauss > 0.0 {
        let outwards = form(&x, &x).signum();
        return outwards * (outwards * ratio).max(SHORT / gauss.sqrt());
    }
    ratio
}

/// Length of such an edge over that of its image and the mean radius of curvature.
const SHORT: f64 = 0.1;

/// Edges that would be longer than so many diagonals of the surface are those of a flat one.
const FAR: f64 = 10.0;

/// Mean normals of the faces at each edge.
fn edge_normals(space: &ParallelSpace) -> PerEdge<Vec3> {
    let topology = space.mesh().topology();
    PerEdge::from_fn(topology.n_edges(), |e| {
        let sum: Vec3 = topology.edge_faces(e).map(|f| space.normal(f)).sum();
        let along = space.direction(e);
        (sum - along * sum.dot(&along)).normalize()
    })
}

/// The vertex of the surface, of those given, whose normal is closest to a direction.
pub(super) fn closest_normal(
    surface: &TriangleSurface,
    places: &[VertexId],
    direction: &Vec3,
) -> VertexId {
    let closeness = |w: &VertexId| surface.normals()[*w].dot(direction);
    let vertices = places.iter().copied();
    let closest = vertices.max_by(|a, b| closeness(a).total_cmp(&closeness(b)).then(b.cmp(a)));
    closest.unwrap_or_else(|| VertexId::new(0))
}

/// That a vertex lies inside the line of an edge at another: `inward . (to - from)` is positive.
#[derive(Clone, Copy, Debug)]
pub(super) struct Waist {
    pub face: FaceId,
    pub from: VertexId,
    pub to: VertexId,
    /// Unit vector in the plane of the face.
    pub inward: Vec3,
}

/// The four conditions that keep the waist of a panel open; none for a convex panel.
///
/// Panels with one re-entrant corner, or more than two, are left to the check of the result.
pub(super) fn waists_of(
    space: &ParallelSpace,
    face: FaceId,
    lengths: &PerEdge<f64>,
) -> Result<Vec<Waist>, SignError> {
    let topology = space.mesh().topology();
    let vertices = topology.face_vertices(face);
    let half_edges: Vec<_> = topology.face_half_edges(face).collect();
    let normal = space.normal(face);
    let directions: Vec<Vec3> = half_edges
        .iter()
        .map(|&h| {
            let edge = topology.edge(h);
            topology.along(h, space.direction(edge) * lengths[edge].signum())
        })
        .collect();
    let n = directions.len();
    // The turn at the origin of half-edge `i`.
    let turn = |i: usize| {
        let (before, after) = (directions[(i + n - 1) % n], directions[i]);
        before.cross(&after).dot(&normal).atan2(before.dot(&after))
    };
    let turning: f64 = (0..n).map(turn).sum();
    if (turning.abs() - TAU).abs() > 0.5 * PI {
        let negative = |h: &&_| lengths[topology.edge(**h)] < 0.0;
        return Err(SignError::Turning {
            face,
            turning,
            reversed: half_edges.iter().filter(negative).count(),
            valence: n,
        });
    }
    let left = turning.signum();
    let reentrant: Vec<usize> = (0..n).filter(|&i| turn(i) * left < 0.0).collect();
    let &[r, s] = &reentrant[..] else {
        return Ok(Vec::new());
    };
    let at = |from: usize, to: usize| {
        [(from + n - 1) % n, from].map(|side| Waist {
            face,
            from: vertices[from],
            to: vertices[to],
            inward: normal.cross(&directions[side]) * left,
        })
    };
    Ok([at(r, s), at(s, r)].concat())
}

/// Panels of a mesh whose outlines cross or touch themselves, by exact predicates.
pub(super) fn crossed(mesh: &HexMesh) -> Vec<FaceId> {
    let flat = FlatFace::all(mesh);
    let faces = mesh.topology().faces();
    faces.filter(|f| !is_simple(&flat[*f].polygon)).collect()
}
