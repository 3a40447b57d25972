//! Directions: the metric in which panels are regular, and the six-fold direction field of their
//! lattice.
//!
//! A hexagonal lattice that is regular in the metric `|II|` gives simple panels at every rotation,
//! for either sign of the Gauss curvature (`K`): for equilateral dual triangles the values `II(e,
//! e)` of the three edges are `cos 2(t + i pi / 3)` up to scale, and sum to zero. So the surface
//! gets the intrinsic metric
//!
//! `M = diag(a1, a2) / (L^2 sqrt(a1 a2))`, `a2 = sqrt(k2^2 + k0^2)`, `a1 = max(sqrt(k1^2 + k0^2),
//! a2 / rho^2)`
//!
//! in principal directions, as edge lengths `l^2 = e . M e`; from then on everything is intrinsic
//! and isotropic. A 6-RoSy field `u = exp(6 i theta)` minimises `|grad u|^2 + c |u - u0|^2`, with
//! `u0` along the direction of smaller curvature and `c` large only where theory asks for alignment
//! (`|k1| rho^2 / |k2| < 0.8`, near parabolic curves). A screened conformal factor `(Laplacian +
//! alpha) s = K_cones - K` trades change of size against dislocations.
//!
//! | symbol | variable |
//! |---|---|
//! | `rho` | [`DirectionOptions::anisotropy`] |
//! | `k0` | 0.05 times the 90 % quantile of `|k2|`, and a thousandth of the reciprocal diagonal |
//! | `alpha` | [`DirectionOptions::conformal_screening`] |
//! | `theta` | [`Directions::angle`], from the first half-edge of the vertex, counter-clockwise |
//!
//! Guaranteed: defined everywhere (a plane gets the isotropic metric and a constant direction);
//! unit lattice spacing is one intrinsic length; where the metric violates triangle inequalities it
//! is blended towards them. Fails, with an error, where triangles are degenerate to rounding, so
//! that a linear system can't be solved.

pub(crate) mod boundary;
pub(crate) mod cones;
pub(crate) mod conformal;
pub(crate) mod guides;
pub(crate) mod holes;
pub(crate) mod intrinsic;
mod metric;
mod mirrors;
pub(crate) mod network;
pub(crate) mod rosy;
pub(crate) mod saddle;
pub(crate) mod size;
#[cfg(test)]
mod tests;
pub(crate) mod thickness;
pub(crate) mod turns;

pub use cones::ConeError;
pub use guides::{Cone, Guides};
pub use intrinsic::IntrinsicMesh;
pub use mirrors::MirrorPlane;
pub use network::{Conjugacy, Curve, NetworkError, NetworkFamily, NetworkOptions};
pub use size::{Demands, SizeOptions, relative_sizes};
pub use thickness::thickness;

use crate::curvature::{Curvature, Principal};
use crate::progress::{Progress, Silent};
use holes::FilledSurface;
use nalgebra::Matrix3;
use phex_mesh::{EdgeId, PerEdge, PerFace, PerVertex, Topology, TriangleSurface};
use phex_numeric::NumericError;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_3;

/// Distance, in panels, up to which opposite cones are cancelled in one of the fields that are
/// compared; from it on rows keep their way along a whole mirror plane, too.
pub(crate) const FAR_REACH: f64 = 12.0;

/// How metric and field are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DirectionOptions {
    /// Largest ratio of panel lengths along the two principal directions (1: isotropic). 1.5 to 2
    /// is the measured optimum.
    pub anisotropy: f64,
    /// Weight of the compulsory alignment near parabolic curves.
    pub alignment: f64,
    /// Screening of the conformal factor (larger: more uniform size, more dislocations), per panel
    /// area.
    pub conformal_screening: f64,
    /// Largest logarithm of the conformal factor.
    pub conformal_limit: f64,
    /// Rotation of the preferred direction, radians.
    pub rotate: f64,
    /// Weight of the alignment of a lattice row with the boundary, per panel length of it (0: the
    /// boundary is ignored).
    pub boundary_alignment: f64,
    /// Distance, in panels, up to which opposite cones are cancelled (0: none are). More of them
    /// give fewer irregular panels, and larger ones where the surface is strongly curved. `None`
    /// is 4; lattices then are made with 12 and without a limit, too, and the best one is kept.
    pub cancel_reach: Option<f64>,
    /// Whether directions run across small holes as if the surface went on there, and not round
    /// them. A lattice is made with either, and the better one kept.
    pub across_holes: bool,
    /// Weight of the alignment that keeps the edges of a lattice off the asymptotic directions, for
    /// surfaces with `K < 0` (0: none); see `saddle`.
    pub saddle_alignment: f64,
    /// Lines that rows run along, and prescribed cones.
    pub guides: Guides,
    /// Planes that the lattice is symmetric about where the boundary lies in them.
    pub mirrors: Vec<MirrorPlane>,
}

impl Default for DirectionOptions {
    fn default() -> Self {
        Self {
            anisotropy: 2.0,
            alignment: 5.0,
            conformal_screening: 0.2,
            conformal_limit: 0.6,
            rotate: 0.0,
            boundary_alignment: 0.5,
            cancel_reach: None,
            across_holes: false,
            saddle_alignment: 0.0,
            guides: Guides::default(),
            mirrors: Vec::new(),
        }
    }
}

/// Metric and lattice directions on the triangles of a surface.
#[derive(Clone, Debug)]
pub struct Directions {
    /// Metric tensor at each vertex: `e . metric e` is the squared length of a tangent `e` in
    /// lattice spacings.
    pub metric: PerVertex<Matrix3<f64>>,
    /// Intrinsic lengths, angles and weights of that metric.
    pub intrinsic: IntrinsicMesh,
    /// Angle of the lattice direction at each vertex (radians, modulo pi / 3), in the vertex's
    /// polar coordinates.
    pub angle: PerVertex<f64>,
    /// Turns of the field along each edge, in sixths, from the frame of its origin to that of its
    /// target.
    pub turn: PerEdge<i32>,
    /// Index of the field in each triangle, in sixths of a turn.
    pub cone: PerFace<i32>,
    /// Pairs of opposite cones that were cancelled.
    pub cancelled: usize,
}

impl Directions {
    /// Lattice spacings longer by a `factor` > 0, along the same directions.
    pub(crate) fn lengthen(&mut self, factor: f64) {
        let area = factor.powi(-2);
        self.metric.iter_mut().for_each(|m| *m *= area);
        self.intrinsic.scale(1.0 / factor);
    }

    /// Angle, radians, by which the field turns along an edge beyond its whole turns.
    pub fn rest(&self, topology: &Topology, e: EdgeId) -> f64 {
        let turned = turns::rest(topology, &self.intrinsic, &self.angle, e);
        turned - f64::from(self.turn[e]) * FRAC_PI_3
    }
}

/// Metric and field for panels of one length, on a surface whose diagonal is about 1: curvature
/// counts as flat below a thousandth of the reciprocal unit.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let options = TriangulationOptions { triangles: 2000, ..Default::default() };
/// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
/// use phex::curvature::{CurvatureOptions, curvature};
/// use phex::directions::{DirectionOptions, directions};
///
/// let curvature = curvature(&sphere, 0.2, &CurvatureOptions::default());
/// let found = directions(&sphere, &curvature, 0.2, &DirectionOptions::default())?;
/// // Six times the Euler characteristic: twelve pentagons.
/// assert_eq!(found.cone.iter().sum::<i32>(), 12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`directions_sized`].
pub fn directions(
    surface: &TriangleSurface,
    curvature: &Curvature,
    panel_length: f64,
    options: &DirectionOptions,
) -> Result<Directions, NumericError> {
    let length = PerVertex::filled(surface.positions().len(), panel_length);
    directions_sized(surface, curvature, &length, options, &Silent)
}

/// Metric and field for panels of length `panel_length` at each vertex, on a surface whose diagonal
/// is about 1, as for [`directions`]; for a caller who cancels perhaps without the conformal
/// factor.
///
/// # Errors
/// If a linear system can't be solved, which only happens when the surface's triangles are
/// numerically degenerate.
pub fn directions_sized(
    surface: &TriangleSurface,
    curvature: &Curvature,
    panel_length: &PerVertex<f64>,
    options: &DirectionOptions,
    progress: &dyn Progress,
) -> Result<Directions, NumericError> {
    let principal = curvature.principal();
    let tensor = metric::metric(surface, curvature, &principal, panel_length, options);
    let mut weight = metric::alignment_weight(&principal, curvature, options);
    let mut wished = principal;
    if options.saddle_alignment > 0.0 {
        (wished, weight) = saddle::wishes(surface, curvature, &tensor, options.saddle_alignment);
    }
    let guides = &options.guides;
    guides.align(surface, &mut wished, &mut weight, options.alignment);
    in_metric(surface, tensor, &wished, &weight, options, progress)
}

/// Directions for a given metric, which the conformal factor may change: the field follows the
/// smaller curvature of `principal` as strongly as `weight` says.
///
/// # Errors
/// As [`directions_sized`].
pub fn in_metric(
    surface: &TriangleSurface,
    tensor: PerVertex<Matrix3<f64>>,
    principal: &PerVertex<Principal>,
    weight: &PerVertex<f64>,
    options: &DirectionOptions,
    progress: &dyn Progress,
) -> Result<Directions, NumericError> {
    let filled = (options.across_holes).then(|| FilledSurface::new(surface, &tensor));
    let Some(filled) = filled.flatten() else {
        return across(surface, tensor, principal, weight, options, progress);
    };
    let (principal, weight) = (filled.extended(principal), filled.weights(weight));
    let directions = across(
        &filled.surface,
        filled.extended(&tensor),
        &principal,
        &weight,
        options,
        progress,
    )?;
    Ok(filled.opened(surface, &directions, options))
}

/// The same for a surface without small holes.
fn across(
    surface: &TriangleSurface,
    mut tensor: PerVertex<Matrix3<f64>>,
    principal: &PerVertex<Principal>,
    weight: &PerVertex<f64>,
    options: &DirectionOptions,
    progress: &dyn Progress,
) -> Result<Directions, NumericError> {
    let measured = |tensor: &PerVertex<Matrix3<f64>>| {
        IntrinsicMesh::new(surface, tensor).with_mirrors(surface, &options.mirrors)
    };
    let mut intrinsic = measured(&tensor);
    let mut factor = None;
    let mut field = |intrinsic: &IntrinsicMesh, tensor: &PerVertex<Matrix3<f64>>| {
        let field = rosy::field(
            surface,
            intrinsic,
            tensor,
            principal,
            weight,
            options,
            &mut factor,
        )?;
        cones::settle_cones(surface, intrinsic, field, options, progress)
    };
    let mut turned = field(&intrinsic, &tensor)?;
    if options.conformal_limit > 0.0 && !progress.is_cancelled() {
        let scale = conformal::log_factor(surface.topology(), &intrinsic, &turned.cone, options)?;
        for (m, s) in tensor.iter_mut().zip(scale.iter()) {
            *m *= (2.0 * s).exp();
        }
        intrinsic = measured(&tensor);
        if !progress.is_cancelled() {
            turned = field(&intrinsic, &tensor)?;
        }
    }
    Ok(Directions {
        metric: tensor,
        intrinsic,
        angle: turned.angle,
        turn: turned.turn,
        cone: turned.cone,
        cancelled: turned.cancelled,
    })
}
