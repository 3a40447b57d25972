//! Where a classical method applies, and what is said where it does not.

use crate::curvature::{Curvature, Principal};
use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Curvatures whose ratio is below this do not tell the sign of the Gauss curvature: estimates are no better.
const SIGN_RATIO: f64 = 0.05;
/// Curvatures below this share of the surface's large ones do not either.
const SIGN_FLOOR: f64 = 0.02;

/// A vertex of the surface and its position, in the words of an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The vertex.
    pub vertex: VertexId,
    /// Its position, model units.
    pub position: Vec3,
}

impl std::fmt::Display for Place {
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
        positive: Place,
        /// Where `K < 0` most clearly.
        negative: Place,
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
        place: Place,
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
        first: Place,
        /// Another one with its normal.
        second: Place,
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
        place: Place,
        /// Its distance, over the diagonal of the bounding box.
        distance: f64,
    },
    /// The quadric that fits is another one.
    #[error(
        "{method} makes spheres and ellipsoids only, but the quadric through the surface is {found} (near {place})"
    )]
    OtherQuadric {
        /// The method.
        method: &'static str,
        /// What kind it is.
        found: &'static str,
        /// A vertex of it.
        place: Place,
    },
}

impl DomainError {
    /// The same error with its places mapped, to model coordinates say.
    pub fn mapped(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        let move_to = |p: &mut Place| p.position = map(p.position);
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
            | Self::NotAnEllipsoid { place, .. }
            | Self::OtherQuadric { place, .. } => move_to(place),
        }
        self
    }
}

/// Signs of the Gauss curvature that occur on a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurvatureSign {
    /// `K > 0`, or flat.
    Elliptic,
    /// `K < 0`, or flat.
    Hyperbolic,
    /// Both.
    Mixed,
}

/// Where the Gauss curvature is positive most clearly and where negative, as far as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedPlaces {
    /// Where `K > 0`.
    pub positive: Option<Place>,
    /// Where `K < 0`.
    pub negative: Option<Place>,
}

impl SignedPlaces {
    /// Looks for both signs among the vertices of a surface.
    pub fn find(surface: &TriangleSurface, curvature: &Curvature) -> Self {
        let principal = curvature.principal();
        let floor = SIGN_FLOOR * crate::directions::metric::large_curvature(&principal);
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

/// The vertex where the ratio of the curvatures is largest in the sense of `sign`, if it is beyond the noise.
fn extreme(
    surface: &TriangleSurface,
    principal: &PerVertex<Principal>,
    floor: f64,
    sign: f64,
) -> Option<Place> {
    let ratio = |p: &Principal| {
        let curved = p.large.abs() > floor && p.large != 0.0;
        if curved {
            sign * p.small / p.large
        } else {
            0.0
        }
    };
    let best = principal
        .enumerate()
        .map(|(v, p)| (v, ratio(p)))
        .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
    (best.1 > SIGN_RATIO).then(|| Place {
        vertex: best.0,
        position: surface.positions()[best.0],
    })
}
