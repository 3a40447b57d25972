//! Planes and their poles: what the classical methods have in common.
//!
//! All of them give each panel a plane near the surface and put every vertex where its planes meet;
//! they differ in how the planes are chosen. A panel is then planar to rounding whatever happens.
//! Whether it is *simple* depends on the touching points: to second order a vertex is the
//! circumcentre of its triangle of touching points in the metric `q = II` (the faces are simple
//! where these triangles are not obtuse in `q` for `K > 0`, and where their edges lie on both sides
//! of the asymptotic cone for `K < 0`).
//!
//! Polarity with respect to a quadric with symmetric matrix `Q` maps a plane `a x + b y + c z + d =
//! 0` to the point `Q (a, b, c, d)^T` (homogeneous coordinates), and the planes through a point to
//! the points of a plane: faces become vertices, vertices become faces.
//!
//! | symbol | here |
//! |---|---|
//! | plane `n . x = h` | [`OrientedPlane`] |
//! | `Q` | [`Quadric`]; the unit sphere is `diag(1, 1, 1, -1)` and maps the plane to `n / h` |
//! | the dual `S'` of a surface | poles of its tangent planes |
//!
//! Source: W. Wang and Y. Liu, "A note on planar hexagonal meshes" (2010), section 2.
//!
//! Guaranteed: polarity applied twice is the identity up to rounding; flips and hulls are decided
//! by exact predicates on the given coordinates. Fails where a plane passes through the centre of
//! the quadric (its pole is at infinity) and where three planes do not meet in one point; the error
//! names the element.

mod centre;
mod envelope;
mod flips;
mod hull;
mod mesh_dual;
mod options;
mod panels;
mod plane;
mod quadric;
mod rim;

pub(crate) use centre::{clear_centre, clearness};
pub(crate) use envelope::envelope;
pub(crate) use flips::{convex_panels, hull_about, saddle_flips, uncrossing_flips};
pub(crate) use hull::{HullError, convex_hull};
pub(crate) use mesh_dual::DualTriangles;
pub use mesh_dual::dual_mesh;

pub use options::{DualOptions, SubdivisionRule};
pub(crate) use panels::Flipped;
pub(crate) use plane::{OrientedPlane, meet};
pub use quadric::Quadric;
pub(crate) use rim::without_broken_rim;

use phex_mesh::{FaceId, TopologyError, Vec3, VertexId};
use thiserror::Error;

/// Why a mesh or a surface has no dual.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DualityError {
    /// A plane passes through the centre.
    #[error(
        "the plane of face {face} passes through the centre of the quadric: its pole is at infinity (choose another centre)"
    )]
    PoleAtInfinity {
        /// The face.
        face: FaceId,
    },
    /// Planes that do not meet in one point.
    #[error(
        "the planes of the panels near ({:.4}, {:.4}, {:.4}) do not meet in one point: the surface is flat or developable there",
        near.x, near.y, near.z
    )]
    NoMeet {
        /// The vertex.
        vertex: VertexId,
        /// Where it was expected.
        near: Vec3,
    },
    /// A vertex with more or fewer faces than three.
    #[error("vertex {vertex} inside has {degree} faces, but three must meet at every vertex")]
    Degree {
        /// The vertex.
        vertex: VertexId,
        /// Number of its faces.
        degree: usize,
    },
    /// A vertex at the boundary with three faces or more.
    #[error(
        "vertex {vertex} at the boundary has more than two faces, so one of them has no part of the boundary there"
    )]
    Crowded {
        /// The vertex.
        vertex: VertexId,
    },
    /// An open mesh whose vertices all lie on the boundary.
    #[error("every vertex of the mesh lies on its boundary: only vertices inside have dual faces")]
    NoInterior,
    /// The matrix of the quadric has no inverse.
    #[error("the matrix of the quadric is singular or not finite, so it defines no polarity")]
    SingularQuadric,
    /// The dual is no manifold.
    #[error("the dual is no manifold")]
    Topology(#[from] TopologyError),
}

impl DualityError {
    /// The same error with its place mapped, to model coordinates say.
    pub fn mapped(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        if let Self::NoMeet { near, .. } = &mut self {
            *near = map(*near);
        }
        self
    }
}
