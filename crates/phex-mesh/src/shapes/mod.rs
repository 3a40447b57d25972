//! Analytic surfaces: known position, normal and curvature at every parameter, to make test
//! surfaces and to judge results by.
//!
//! * [`Shape`] names every built-in surface and its parameters: `Shape::from_name("torus",
//!   &[("minor", 0.3)])`.
//! * [`ParametricSurface`] is the differential geometry. From the closed-form derivatives `x_u,
//!   x_v, x_uu, x_uv, x_vv` follow `E = x_u.x_u`, `F = x_u.x_v`, `G = x_v.x_v`, `n = x_u x x_v /
//!   |x_u x x_v|`, `L = n.x_uu`, `M = n.x_uv`, `N = n.x_vv`, and the principal curvatures as
//!   eigenvalues of `II` with respect to `I`.
//! * [`triangulate`] makes a triangle surface of it whose vertices lie on the surface exactly.
//!
//! | symbol | name | meaning |
//! |---|---|---|
//! | `u, v` | parameters | see each shape's file for what they measure |
//! | `k1 >= k2` | [`PrincipalCurvatures`] | positive where the surface bends towards its normal |
//! | `K, H` | `gauss_curvature`, `mean_curvature` | `k1 k2`, `(k1 + k2) / 2` |
//!
//! Guaranteed: triangulations are oriented manifolds of the surface's topology that agree with its
//! normals; the same options give the same bytes. Not guaranteed: well-shaped triangles where
//! parameters are extreme (a torus with `minor` near `major`).

mod b_spline;
mod domain;
mod ellipsoid;
mod graph;
mod minimal;
mod parametric;
mod registry;
mod revolution;
mod roof;
mod triangulate;

pub use domain::{BoundaryArc, Interval, ParameterDomain, Region};
pub use parametric::{FirstForm, ParametricSurface, PrincipalCurvatures, SecondForm, SurfaceJet};
pub use registry::{Shape, ShapeInfo, ShapeParameter};
pub use triangulate::{
    Triangulation, TriangulationOptions, triangulate, triangulate_with_parameters,
};

use crate::topology::TopologyError;
use thiserror::Error;

/// Why a shape or its triangulation cannot be made as asked.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum ShapeError {
    /// No shape has this name.
    #[error("there is no shape called {name:?}; there are {known}")]
    UnknownShape {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: String,
    },
    /// The shape has no such parameter.
    #[error("the shape {shape} has no parameter {parameter:?}; it has {known}")]
    UnknownParameter {
        /// The shape.
        shape: &'static str,
        /// The name asked for.
        parameter: String,
        /// The names there are.
        known: String,
    },
    /// A parameter was given more than once.
    #[error("parameter {parameter} of the shape {shape} is given twice")]
    RepeatedParameter {
        /// The shape.
        shape: &'static str,
        /// The parameter.
        parameter: &'static str,
    },
    /// A value is outside its range, or not a number.
    #[error(
        "parameter {parameter} of the shape {shape} is {value}, it must be from {min} to {max}"
    )]
    ParameterOutOfRange {
        /// The shape.
        shape: &'static str,
        /// The parameter.
        parameter: &'static str,
        /// The value asked for.
        value: f64,
        /// Smallest value allowed (with the other parameters as they are).
        min: f64,
        /// Largest value allowed (with the other parameters as they are).
        max: f64,
    },
    /// A parameter that counts something has a fractional value.
    #[error("parameter {parameter} of the shape {shape} is {value}, it must be a whole number")]
    NotAWholeNumber {
        /// The shape.
        shape: &'static str,
        /// The parameter.
        parameter: &'static str,
        /// The value asked for.
        value: f64,
    },
    /// The number of triangles cannot be made.
    #[error("{triangles} triangles are asked for, the number must be from {min} to {max}")]
    TriangleCount {
        /// The number asked for.
        triangles: usize,
        /// Smallest number allowed.
        min: usize,
        /// Largest number allowed.
        max: usize,
    },
    /// The jitter would fold triangles over.
    #[error("jitter is {jitter}, it must be from 0 to {max}")]
    Jitter {
        /// The jitter asked for.
        jitter: f64,
        /// Largest jitter allowed.
        max: f64,
    },
    /// The triangles are not a manifold.
    #[error("the triangulation of the shape is broken: {0}")]
    Topology(#[from] TopologyError),
}
