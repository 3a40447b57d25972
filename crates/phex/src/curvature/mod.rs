//! Curvature: the shape operator of the target at the scale of a panel.
//!
//! A second-order jet `z = c + p x + q y + (a x^2 + 2 b x y + d y^2) / 2` is fitted over the
//! connected neighbourhood of radius `r` of each vertex (weights `exp(-2 (distance / reach)^2)`);
//! the normal is `(-p, -q, 1) / W` with `W = sqrt(1 + p^2 + q^2)` and the second fundamental form
//! `[a b; b d] / W`. `r` is a share of the panel length: the layout needs curvature at the scale of
//! a panel, not of a triangle, and this is what removes noise. The *tensor* is then smoothed, never
//! the directions. Two radii are compared, and their disagreement lowers the
//! [`Curvature::confidence`].
//!
//! Sign: positive where the surface is convex seen from the side of its normals.
//!
//! | symbol | variable |
//! |---|---|
//! | `II` as a tensor of space | [`Curvature::tensor`] |
//! | `k1, k2` with `|k1| <= |k2|` | [`Principal::small`], [`Principal::large`] |
//!
//! Guaranteed: exact for quadrics in graph form at the fitted vertex, error `O(r^2)` elsewhere; a
//! plane gives 0. Fails: where features are smaller than `r` they are averaged.

pub(crate) mod dupin;
mod jet;
mod tensor;

pub use dupin::{Indicatrix, free_panels, indicatrix_distances, inscribing_curves};
pub use tensor::{Principal, principal, tangent_frame};
pub(crate) use tensor::{large_curvature, smoothed, turn_to_pole};

use nalgebra::Matrix3;
use phex_mesh::{IdMap, PerVertex, SurfacePoint, TriangleSurface, Vec3, VertexId};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// How curvature is estimated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CurvatureOptions {
    /// Radius of the fitted neighbourhood over the panel length.
    pub radius_rel: f64,
    /// Passes of tensor smoothing over the one-ring.
    pub smoothing: usize,
}

impl Default for CurvatureOptions {
    fn default() -> Self {
        Self {
            radius_rel: 0.6,
            smoothing: 6,
        }
    }
}

/// Curvature of a surface at its vertices.
#[derive(Clone, Debug)]
pub struct Curvature {
    /// Unit normals of the fitted jets.
    pub normal: PerVertex<Vec3>,
    /// Second fundamental form as a tangential tensor: `e . tensor e` is the normal curvature along
    /// a unit tangent `e`, in 1 / length.
    pub tensor: PerVertex<Matrix3<f64>>,
    /// Agreement of two radii, 0 (none) to 1 (full).
    pub confidence: PerVertex<f64>,
}

/// Curvature of `surface` at the scale of panels of length `panel_length` (model units of the
/// surface).
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let options = TriangulationOptions { triangles: 2000, ..Default::default() };
/// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
/// use phex::curvature::{CurvatureOptions, curvature};
///
/// let found = curvature(&sphere, 0.2, &CurvatureOptions::default());
/// // Of radius 1.
/// assert!(found.principal().iter().all(|p| (p.large - 1.0).abs() < 0.05));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn curvature(
    surface: &TriangleSurface,
    panel_length: f64,
    options: &CurvatureOptions,
) -> Curvature {
    let length = PerVertex::filled(surface.positions().len(), panel_length);
    curvature_sized(surface, &length, options)
}

/// The same at the scale of panels whose length changes: one for each vertex.
pub fn curvature_sized(
    surface: &TriangleSurface,
    panel_length: &PerVertex<f64>,
    options: &CurvatureOptions,
) -> Curvature {
    let fits: Vec<(jet::Jet, f64)> = (0..surface.positions().len())
        .into_par_iter()
        .map_init(
            || jet::Neighbourhood::new(surface),
            |hood, i| {
                let v = VertexId::new(i as u32);
                let radius = options.radius_rel * panel_length[v];
                let members = hood.collect(v, radius);
                let fit = jet::fit(surface, v, members, f64::INFINITY);
                let inner = jet::fit(surface, v, members, 0.6 * radius);
                let confidence = agreement(&fit.tensor, &inner.tensor);
                (fit, confidence)
            },
        )
        .collect();
    let normal = PerVertex::from_vec(fits.iter().map(|f| f.0.normal).collect());
    let raw = PerVertex::from_vec(fits.iter().map(|f| f.0.tensor).collect());
    let confidence = PerVertex::from_vec(fits.iter().map(|f| f.1).collect());
    let tensor = tensor::smoothed(surface.topology(), &normal, raw, options.smoothing);
    Curvature {
        normal,
        tensor,
        confidence,
    }
}

/// The second fundamental form at some vertices, which is not smoothed: tensors as in
/// [`Curvature::tensor`], in 1 / length, in the order of `vertices`.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let options = TriangulationOptions { triangles: 2000, ..Default::default() };
/// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
/// use phex::curvature::{CurvatureOptions, principal, tensors_at};
/// use phex_mesh::VertexId;
///
/// let v = VertexId::new(7);
/// let found = tensors_at(&sphere, &[v], 0.2, &CurvatureOptions::default());
/// // Of radius 1.
/// assert!((principal(sphere.normals()[v], &found[0]).large - 1.0).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tensors_at(
    surface: &TriangleSurface,
    vertices: &[VertexId],
    panel_length: f64,
    options: &CurvatureOptions,
) -> Vec<Matrix3<f64>> {
    let radius = options.radius_rel * panel_length;
    let fit = |hood: &mut jet::Neighbourhood<'_>, v: &VertexId| {
        let members = hood.collect(*v, radius);
        jet::fit(surface, *v, members, f64::INFINITY).tensor
    };
    let vertices = vertices.par_iter();
    vertices
        .map_init(|| jet::Neighbourhood::new(surface), fit)
        .collect()
}

/// The same at points of the surface, in their order: between those at the corners of their
/// triangles. The cost follows the points, however fine the surface is.
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let options = TriangulationOptions { triangles: 2000, ..Default::default() };
/// # let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
/// use phex::curvature::{CurvatureOptions, principal, tensors_at_points};
/// use phex_mesh::Vec3;
///
/// let foot = sphere.closest_point(Vec3::new(0.3, -2.0, 0.4));
/// let found = tensors_at_points(&sphere, &[foot], 0.2, &CurvatureOptions::default());
/// // Of radius 1.
/// assert!((principal(foot.normal, &found[0]).large - 1.0).abs() < 0.05);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn tensors_at_points(
    surface: &TriangleSurface,
    points: &[SurfacePoint],
    panel_length: f64,
    options: &CurvatureOptions,
) -> Vec<Matrix3<f64>> {
    let corners = |p: &SurfacePoint| surface.topology().face_vertices(p.triangle);
    let near: BTreeSet<VertexId> = points.iter().flat_map(corners).copied().collect();
    let near: Vec<VertexId> = near.into_iter().collect();
    let tensors = tensors_at(surface, &near, panel_length, options);
    let of_vertex: IdMap<VertexId, Matrix3<f64>> = near.into_iter().zip(tensors).collect();
    let between = |p: &SurfacePoint| {
        let parts = corners(p).iter().zip(p.barycentric);
        parts.map(|(v, b)| of_vertex[v] * b).sum()
    };
    points.iter().map(between).collect()
}

fn agreement(outer: &Matrix3<f64>, inner: &Matrix3<f64>) -> f64 {
    let scale = outer.norm().max(inner.norm());
    if scale == 0.0 {
        return 1.0;
    }
    let ratio = (outer - inner).norm() / (0.5 * scale);
    1.0 / (1.0 + ratio * ratio)
}

impl Curvature {
    /// The curvature of the next finer level: tensors and normals follow the subdivision stencils.
    pub fn refined(&self, step: &crate::smooth_surface::subdivide::Refinement) -> Self {
        let normal = step
            .apply(&self.normal)
            .map(|n| n.try_normalize(0.0).unwrap_or_else(Vec3::z));
        Self {
            normal,
            tensor: step.apply(&self.tensor),
            confidence: step.apply(&self.confidence),
        }
    }

    /// Principal curvatures and directions at every vertex.
    pub fn principal(&self) -> PerVertex<Principal> {
        PerVertex::from_vec(
            self.normal
                .iter()
                .zip(self.tensor.iter())
                .map(|(n, s)| tensor::principal(*n, s))
                .collect(),
        )
    }
}
