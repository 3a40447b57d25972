//! Where a classical method applies, and what is said where it does not.

use crate::curvature::{Curvature, Principal, large_curvature, tangent_frame};
use phex_mesh::{EdgeId, FaceId, PerVertex, Topology, TriangleSurface, Vec3, VertexId};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use thiserror::Error;

/// Curvatures whose ratio is below this do not tell the sign of the Gauss curvature: estimates are
/// no better.
const SIGN_RATIO: f64 = 0.05;
/// Curvatures below this share of the surface's large ones do not either.
const SIGN_FLOOR: f64 = 0.02;

/// Share of the surface's area on which a sign must be clear to count: a few bad triangles are no
/// region.
const SIGN_SHARE: f64 = 0.005;

/// A vertex of the surface and its position, in the words of an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocatedVertex {
    /// The vertex.
    pub vertex: VertexId,
    /// Its position, model units.
    pub position: Vec3,
}

impl LocatedVertex {
    /// A vertex of a surface.
    pub(crate) fn of(surface: &TriangleSurface, vertex: VertexId) -> Self {
        let position = surface.positions()[vertex];
        Self { vertex, position }
    }
}

impl std::fmt::Display for LocatedVertex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let p = self.position;
        write!(
            f,
            "vertex {} at ({:.4}, {:.4}, {:.4})",
            self.vertex, p.x, p.y, p.z
        )
    }
}

/// Which assumption of a method fails, and where.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DomainError {
    /// The Gauss curvature changes its sign.
    #[error(
        "{method} needs Gauss curvature of one sign, but it is positive at {positive} and negative at {negative}: on the parabolic \
         curve between them {consequence}"
    )]
    MixedCurvature {
        /// The method.
        method: &'static str,
        /// Where `K > 0` most clearly.
        positive: LocatedVertex,
        /// Where `K < 0` most clearly.
        negative: LocatedVertex,
        /// What fails on the parabolic curve.
        consequence: &'static str,
    },
    /// Every point of space lies in a tangent plane.
    #[error(
        "{method} needs a point that no tangent plane passes through, but every point tried lies in one: the best is met by the tangent \
         plane at {place}, whose pole is at infinity"
    )]
    NoCentre {
        /// The method.
        method: &'static str,
        /// Where the tangent plane of the best centre passes through it.
        place: LocatedVertex,
    },
    /// A tangent plane passes through the centre of the quadric that is to be used.
    #[error(
        "{method} needs a quadric whose centre no tangent plane passes through, but that at {place} does, or comes too near: its pole is at infinity"
    )]
    ThroughCentre {
        /// The method.
        method: &'static str,
        /// Where the tangent plane touches.
        place: LocatedVertex,
    },
    /// Two points of the surface have one normal.
    #[error(
        "{method} needs a Gauss map that is one to one, but {first} and {second} have the same normal ({pairs} such pairs among \
         {vertices} vertices)"
    )]
    ManyToOne {
        /// The method.
        method: &'static str,
        /// A vertex.
        first: LocatedVertex,
        /// Another one with its normal.
        second: LocatedVertex,
        /// Number of pairs.
        pairs: usize,
        /// Vertices that were looked at.
        vertices: usize,
    },
    /// The surface is no quadric, or none that the sphere can be mapped to.
    #[error(
        "{method} makes spheres and ellipsoids only: {place} is {distance:.3} diagonals off the ellipsoid that fits best"
    )]
    NotAnEllipsoid {
        /// The method.
        method: &'static str,
        /// The vertex that is farthest off.
        place: LocatedVertex,
        /// Its distance, over the diagonal of the bounding box.
        distance: f64,
    },
    /// The quadric that fits is another one.
    #[error(
        "{method} makes spheres and ellipsoids only, but the quadric that fits the surface is {found}: {place} is {distance:.3} diagonals off \
         the sphere that fits best"
    )]
    OtherQuadric {
        /// The method.
        method: &'static str,
        /// What kind it is.
        found: &'static str,
        /// The vertex that is farthest off.
        place: LocatedVertex,
        /// Its distance, over the diagonal of the bounding box.
        distance: f64,
    },
    /// Facets so coarse that they do not tell the curvature.
    #[error(
        "{method} needs Gauss curvature of one sign, but the sign is not known at {place}: the surface turns by {degrees:.0} degrees from one of its triangles \
         to the next there, which is as good as a crease"
    )]
    Unresolved {
        /// The method.
        method: &'static str,
        /// An end of the edge between the two triangles.
        place: LocatedVertex,
        /// The angle between their normals, degrees.
        degrees: f64,
    },
    /// A coarse mesh whose planes turn too far from one panel to the next.
    #[error(
        "{method} needs a coarse mesh that follows the surface where its curvature is negative, but its planes turn by {degrees:.0} degrees from one panel to the next at \
         {place}: ask for more panels, or fewer levels"
    )]
    Coarse {
        /// The method.
        method: &'static str,
        /// Where one of the two panels touches.
        place: LocatedVertex,
        /// The angle between their planes, degrees.
        degrees: f64,
    },
    /// The surface has holes.
    #[error(
        "{method} needs a surface without holes, but there are {loops} boundary curves, one through {place}: cut the surface open"
    )]
    Holes {
        /// The method.
        method: &'static str,
        /// Number of boundary curves.
        loops: usize,
        /// A vertex on the shortest of them.
        place: LocatedVertex,
    },
    /// A part of the surface is flat, or bends in one direction only.
    #[error(
        "{method} needs Gauss curvature other than zero, but the surface bends in one direction at most at {place}: {consequence}"
    )]
    Developable {
        /// The method.
        method: &'static str,
        /// Where that is clearest.
        place: LocatedVertex,
        /// What fails there.
        consequence: &'static str,
    },
    /// A flat point of a surface with `K < 0` else.
    #[error(
        "{method} needs Gauss curvature of one sign everywhere, but the surface is flat at {place}, where its principal directions have no limit: {consequence}"
    )]
    FlatPoint {
        /// The method.
        method: &'static str,
        /// A vertex next to the point.
        place: LocatedVertex,
        /// What fails there.
        consequence: &'static str,
    },
}

impl DomainError {
    /// The same error with its places mapped, to vertices of the model say.
    pub fn mapped(mut self, map: impl Fn(LocatedVertex) -> LocatedVertex) -> Self {
        let move_to = |p: &mut LocatedVertex| *p = map(*p);
        match &mut self {
            Self::MixedCurvature {
                positive: a,
                negative: b,
                ..
            }
            | Self::ManyToOne {
                first: a,
                second: b,
                ..
            } => {
                move_to(a);
                move_to(b);
            }
            Self::NoCentre { place, .. }
            | Self::ThroughCentre { place, .. }
            | Self::NotAnEllipsoid { place, .. }
            | Self::OtherQuadric { place, .. }
            | Self::Unresolved { place, .. }
            | Self::Coarse { place, .. }
            | Self::Developable { place, .. }
            | Self::Holes { place, .. }
            | Self::FlatPoint { place, .. } => move_to(place),
        }
        self
    }
}

/// Signs of the Gauss curvature that occur on a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurvatureSign {
    /// `K > 0`, or flat.
    Elliptic,
    /// `K < 0`, or flat.
    Hyperbolic,
    /// Both.
    #[default]
    Mixed,
}

/// Where the Gauss curvature is positive most clearly and where negative, as far as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SignedPlaces {
    /// Where `K > 0`.
    pub positive: Option<LocatedVertex>,
    /// Where `K < 0`.
    pub negative: Option<LocatedVertex>,
}

impl SignedPlaces {
    /// Looks for both signs among the vertices of a surface.
    pub fn find(surface: &TriangleSurface, curvature: &Curvature) -> Self {
        let principal = curvature.principal();
        let floor = SIGN_FLOOR * large_curvature(&principal);
        Self {
            positive: extreme(surface, &principal, floor, 1.0),
            negative: extreme(surface, &principal, floor, -1.0),
        }
    }

    /// The sign of the surface.
    pub fn sign(&self) -> CurvatureSign {
        match (self.positive, self.negative) {
            (Some(_), Some(_)) => CurvatureSign::Mixed,
            (None, Some(_)) => CurvatureSign::Hyperbolic,
            _ => CurvatureSign::Elliptic,
        }
    }

    /// The sign of the surface, if it is one.
    ///
    /// # Errors
    /// Where both signs occur.
    pub fn one_sign(
        &self,
        method: &'static str,
        consequence: &'static str,
    ) -> Result<CurvatureSign, DomainError> {
        match (self.positive, self.negative) {
            (Some(positive), Some(negative)) => Err(DomainError::MixedCurvature {
                method,
                positive,
                negative,
                consequence,
            }),
            _ => Ok(self.sign()),
        }
    }
}

/// The vertex where the ratio of the curvatures is largest in the sense of `sign`, if enough of the
/// surface is beyond the noise in that sense. The least ratio among a vertex and its neighbours
/// counts, away from the boundary: there estimates see one side only.
fn extreme(
    surface: &TriangleSurface,
    principal: &PerVertex<Principal>,
    floor: f64,
    sign: f64,
) -> Option<LocatedVertex> {
    let topology = surface.topology();
    let ratio = |v: VertexId| {
        let p = &principal[v];
        let curved = p.large.abs() > floor && p.large != 0.0;
        if curved && !topology.is_boundary_vertex(v) {
            sign * p.small / p.large
        } else {
            0.0
        }
    };
    let least = |v: VertexId| {
        let ring = topology.outgoing(v).map(|h| ratio(topology.target(h)));
        ring.fold(ratio(v), f64::min)
    };
    let all = topology.vertices().map(|v| (v, least(v)));
    let sure: Vec<(VertexId, f64)> = all.filter(|v| v.1 > SIGN_RATIO).collect();
    let share = sure.iter().map(|v| area_at(surface, v.0)).sum::<f64>() / surface.area();
    let best = sure
        .into_iter()
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    (share > SIGN_SHARE).then(|| LocatedVertex::of(surface, best.0))
}

/// That there is one boundary curve at the most.
///
/// # Errors
/// If there are more: a vertex on the shortest.
pub(crate) fn without_holes(
    surface: &TriangleSurface,
    method: &'static str,
) -> Result<(), DomainError> {
    let loops = surface.boundary_loops();
    let shortest = loops.iter().min_by_key(|l| l.len()).and_then(|l| l.first());
    match shortest.filter(|_| loops.len() > 1) {
        None => Ok(()),
        Some(&vertex) => Err(DomainError::Holes {
            method,
            loops: loops.len(),
            place: LocatedVertex::of(surface, vertex),
        }),
    }
}

/// Curvatures whose ratio is below this are those of a surface that bends in one direction only.
const DEVELOPABLE_RATIO: f64 = 0.01;
/// Share of the surface's area on which it may.
const DEVELOPABLE_SHARE: f64 = 0.05;
/// Largest curvature, over the inverse of the surface's diagonal, of a plane.
const PLANE: f64 = 1e-3;

/// That the surface bends in two directions but for small parts of it.
///
/// # Errors
/// Where it bends in one direction at most: the vertex where that is clearest.
pub(crate) fn not_flat(
    surface: &TriangleSurface,
    curvature: &Curvature,
    method: &'static str,
    consequence: &'static str,
) -> Result<(), DomainError> {
    let topology = surface.topology();
    let floor = PLANE / surface.diagonal();
    let principal = curvature.principal();
    let ratio = |v: &VertexId| {
        let p = &principal[*v];
        match p.large.abs() > floor {
            true => (p.small / p.large).abs(),
            false => 0.0,
        }
    };
    let inner = topology.inner_vertices();
    let flat: Vec<VertexId> = inner.filter(|v| ratio(v) < DEVELOPABLE_RATIO).collect();
    let area: f64 = flat.iter().map(|v| area_at(surface, *v)).sum();
    let clearest = flat
        .into_iter()
        .min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
    match clearest.filter(|_| area > DEVELOPABLE_SHARE * surface.area()) {
        None => Ok(()),
        Some(vertex) => Err(DomainError::Developable {
            method,
            place: LocatedVertex::of(surface, vertex),
            consequence,
        }),
    }
}

/// Two thirds of the area of the triangles at a vertex.
fn area_at(surface: &TriangleSurface, v: VertexId) -> f64 {
    let topology = surface.topology();
    let around = topology.faces_at(v);
    around.map(|f| surface.area_vector(f).norm() / 3.0).sum()
}

/// Curvature below this share of that [`FLAT_RINGS`] edges away is that of a flat point.
const FLAT: f64 = 0.35;
/// See [`FLAT`].
const FLAT_RINGS: usize = 4;

/// A vertex next to a flat point of a surface with `K < 0` else: the principal directions turn by a
/// multiple of a half-turn round a triangle, and the curvature falls towards it. Umbilics, round
/// which they turn elsewhere, need `K > 0`.
fn flat_point(surface: &TriangleSurface, curvature: &Curvature) -> Option<LocatedVertex> {
    let topology = surface.topology();
    let principal = curvature.principal();
    let curved = |v: &VertexId| principal[*v].large.abs();
    let found = topology.faces().find_map(|f| {
        if !turns(surface, &principal, f) {
            return None;
        }
        let corners = topology.face_vertices(f).iter();
        let vertex = *corners.min_by(|a, b| curved(a).total_cmp(&curved(b)))?;
        let ring = ring(topology, vertex)?;
        let around = ring.iter().map(curved).sum::<f64>() / ring.len() as f64;
        (curved(&vertex) < FLAT * around).then_some(vertex)
    })?;
    Some(LocatedVertex::of(surface, found))
}

/// The vertices [`FLAT_RINGS`] edges away; `None` near a boundary.
fn ring(topology: &Topology, centre: VertexId) -> Option<Vec<VertexId>> {
    let mut seen = BTreeSet::from([centre]);
    let mut rim = vec![centre];
    for _ in 0..FLAT_RINGS {
        if rim.iter().any(|v| topology.is_boundary_vertex(*v)) {
            return None;
        }
        let next = rim.iter().flat_map(|v| topology.neighbours(*v));
        let next: BTreeSet<VertexId> = next.collect();
        rim = next.into_iter().filter(|v| seen.insert(*v)).collect();
    }
    (!rim.is_empty()).then_some(rim)
}

/// Whether the principal directions turn round a triangle.
fn turns(surface: &TriangleSurface, principal: &PerVertex<Principal>, f: FaceId) -> bool {
    let corners = surface.topology().face_vertices(f);
    let axes = tangent_frame(surface.area_vector(f).normalize());
    // Twice the angle, since a direction is a line.
    let angle = |v: &VertexId| {
        let d = principal[*v].large_direction;
        2.0 * d.dot(&axes[1]).atan2(d.dot(&axes[0]))
    };
    let angles: Vec<f64> = corners.iter().map(angle).collect();
    let wrapped = |x: f64| x - TAU * (x / TAU).round();
    let sum: f64 = (0..3)
        .map(|k| wrapped(angles[(k + 1) % 3] - angles[k]))
        .sum();
    sum.abs() > 1.0
}

/// Angle between neighbouring triangles of a surface, degrees, from which on nothing is known of
/// the curvature between them.
const CREASE: f64 = 30.0;

/// That the surface's triangles are small enough to tell its curvature.
///
/// # Errors
/// If two neighbouring ones make an angle of 30 degrees or more: the place where it is largest.
pub(crate) fn resolved(surface: &TriangleSurface, method: &'static str) -> Result<(), DomainError> {
    let topology = surface.topology();
    let turn = |e: EdgeId| {
        let [a, b] = (topology.faces_beside(e)?).map(|f| surface.area_vector(f));
        Some((topology.edge_vertices(e)[0], a.angle(&b).to_degrees()))
    };
    let turns = topology.edges().filter_map(turn);
    let sharpest = turns.max_by(|a, b| a.1.total_cmp(&b.1));
    match sharpest.filter(|s| s.1 >= CREASE) {
        None => Ok(()),
        Some((vertex, degrees)) => Err(DomainError::Unresolved {
            method,
            place: LocatedVertex::of(surface, vertex),
            degrees,
        }),
    }
}

/// That there is none on a surface of one sign.
///
/// # Errors
/// If there is one and the curvature is negative else.
pub(crate) fn no_flat_point(
    sign: CurvatureSign,
    surface: &TriangleSurface,
    curvature: &Curvature,
    method: &'static str,
    consequence: &'static str,
) -> Result<CurvatureSign, DomainError> {
    let found = match sign {
        CurvatureSign::Hyperbolic => flat_point(surface, curvature),
        _ => None,
    };
    match found {
        None => Ok(sign),
        Some(place) => Err(DomainError::FlatPoint {
            method,
            place,
            consequence,
        }),
    }
}
