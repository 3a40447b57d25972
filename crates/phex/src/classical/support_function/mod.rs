//! Support function: panels from a triangulation of the Gauss sphere.
//!
//! The support function `h(n)` of a surface with a one-to-one Gauss map is the signed distance of
//! the tangent plane with normal `n` from the origin. Interpolated linearly over the triangles of
//! the Gauss sphere, `h(n) = x . n` with one `x` for each triangle: the point where three tangent
//! planes meet. These points are the vertices of a P-Hex mesh.
//!
//! The Gauss sphere is sampled regularly, as the lattice of the surface that is regular in the
//! third fundamental form `III = II I^-1 II`. Then:
//!
//! * `K > 0`: the triangulation is that of the convex hull of the dual points `n / h` (by flips
//!   that are decided exactly): the piecewise linear `h` is convex, and so is every panel.
//! * `K < 0`: the regular triangulation, along the directions in which it keeps the sign rule
//!   (`crate::directions::saddle`).
//!
//! Source: Almegaard, Bagger, Gravesen, Juettler, Sir, "Surfaces with piecewise linear support
//! functions over spherical triangulations" (2007), as reviewed by W. Wang and Y. Liu, "A note on
//! planar hexagonal meshes" (2010), section 2: inversion in the sphere takes this to the projective
//! dual, so it has the same limits.
//!
//! Guaranteed: planar panels; for `K > 0` convex ones inside. Refused: where `K` changes its sign
//! or the Gauss map is many-to-one, with two vertices that share a normal.

mod gauss_map;

pub(crate) use gauss_map::shared_normals;

use super::domain::{CurvatureSign, DomainError, SignedPlaces};
use super::projective_dual::with_floor;
use crate::curvature::Curvature;
use nalgebra::Matrix3;
use phex_mesh::{PerVertex, TriangleSurface};

/// Name in messages.
pub(crate) const METHOD: &str = "support-function";

/// The third fundamental form as a tangential tensor, with a small isotropic part where the surface
/// is flat.
pub(crate) fn metric(curvature: &Curvature) -> PerVertex<Matrix3<f64>> {
    let raw = curvature.tensor.map(|s| s * s);
    with_floor(raw, &curvature.normal)
}

/// The sign of the Gauss curvature, if the method applies.
///
/// # Errors
/// Where `K` changes its sign, or two vertices share a normal.
pub(crate) fn check(
    surface: &TriangleSurface,
    curvature: &Curvature,
) -> Result<CurvatureSign, DomainError> {
    let places = SignedPlaces::find(surface, curvature);
    let sign = places.one_sign(METHOD, "the Gauss map folds over")?;
    one_to_one(surface, curvature, METHOD).map(|()| sign)
}

/// That no two places far from each other have the same normal.
///
/// # Errors
/// Two vertices that share one.
pub(crate) fn one_to_one(
    surface: &TriangleSurface,
    curvature: &Curvature,
    method: &'static str,
) -> Result<(), DomainError> {
    let pairs = shared_normals(surface, &curvature.normal);
    match pairs.first() {
        None => Ok(()),
        Some(&[first, second]) => Err(DomainError::ManyToOne {
            method,
            first,
            second,
            pairs: pairs.len(),
            vertices: surface.positions().len(),
        }),
    }
}
