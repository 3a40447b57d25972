//! Support function: panels from a triangulation of the Gauss sphere.
//!
//! The support function `h(n)` of a surface with a one-to-one Gauss map is the signed distance of the tangent plane with normal `n`
//! from the origin. Interpolated linearly over the triangles of the Gauss sphere, `h(n) = x . n` with one `x` for each
//! triangle: the point where three tangent planes meet. These points are the vertices of a P-Hex mesh.
//!
//! The Gauss sphere is sampled regularly, as the lattice of the surface that is regular in the third fundamental form
//! `III = II I^-1 II`. Then:
//!
//! * `K > 0`: the triangulation is that of the convex hull of the dual points `n / h` (by flips that are decided exactly): the piecewise
//!   linear `h` is convex, and so is every panel.
//! * `K < 0`: the regular triangulation as it is.
//!
//! Source: Almegaard, Bagger, Gravesen, Juettler, Sir, "Surfaces with piecewise linear support functions over spherical triangulations"
//! (2007), as reviewed by W. Wang and Y. Liu, "A note on planar hexagonal meshes" (2010), section 2: inversion in the sphere takes this
//! to the projective dual, so it has the same limits.
//!
//! Guaranteed: planar panels; for `K > 0` convex ones inside. Refused: where `K` changes its sign or the Gauss map is many-to-one,
//! with two vertices that share a normal.

mod gauss_map;

pub use gauss_map::shared_normals;

use super::domain::{CurvatureSign, DomainError, SignedPlaces};
use super::duality::{DualityError, Plane, Quadric, clear_centre, convex_flips};
use super::projective_dual::with_floor;
use crate::curvature::Curvature;
use nalgebra::Matrix3;
use phex_mesh::{HexMesh, PerFace, PerVertex, TriangleSurface, Vec3};

/// Name in messages.
const METHOD: &str = "support-function";

/// The third fundamental form as a tangential tensor, with a small isotropic part where the surface is flat.
pub fn metric(curvature: &Curvature) -> PerVertex<Matrix3<f64>> {
    let raw = curvature.tensor.map(|s| s * s);
    with_floor(raw, &curvature.normal)
}

/// The sign of the Gauss curvature, if the method applies.
///
/// # Errors
/// Where `K` changes its sign, or two vertices share a normal.
pub fn check(
    surface: &TriangleSurface,
    curvature: &Curvature,
) -> Result<CurvatureSign, DomainError> {
    let places = SignedPlaces::find(surface, curvature);
    let sign = places.one_sign(METHOD, "the Gauss map folds over")?;
    let pairs = shared_normals(surface, &curvature.normal);
    match pairs.first() {
        None => Ok(sign),
        Some(&[first, second]) => Err(DomainError::ManyToOne {
            method: METHOD,
            first,
            second,
            pairs: pairs.len(),
            vertices: surface.positions().len(),
        }),
    }
}

/// Panels joined as the hull of their planes' poles is, and the number of flips; nothing changes where no centre avoids the planes.
///
/// # Errors
/// If a plane passes through the centre that avoids them best.
pub fn convex_panels(
    mesh: &HexMesh,
    planes: &PerFace<Plane>,
    points: &PerFace<Vec3>,
) -> Result<(HexMesh, usize), DualityError> {
    let (centre, clearness) = clear_centre(planes.as_slice(), points.as_slice());
    if clearness <= 0.0 {
        return Ok((mesh.clone(), 0));
    }
    let sphere = Quadric::sphere(centre, 1.0)?;
    let pole = |(face, plane)| {
        sphere
            .pole(plane)
            .ok_or(DualityError::PoleAtInfinity { face })
    };
    let poles: Result<Vec<Vec3>, _> = planes.enumerate().map(pole).collect();
    Ok(convex_flips(mesh, &PerFace::from_vec(poles?)))
}
