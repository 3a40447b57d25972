//! Classical methods: each panel gets a plane near the surface, and every vertex lies where its
//! planes meet, so that panels are planar by construction.
//!
//! A folder for each method, with its formula, guarantees and failures at the top; they share
//! `duality` (planes, poles, hulls, flips) and `domain` (where they apply). What takes the planes
//! of a layout is in `crate::layout` (`tangent_planes`, `forecast`); `crate::pipeline` puts
//! surface, lattice and method together.

pub(crate) mod domain;
pub(crate) mod dual_subdivision;
pub(crate) mod duality;
pub(crate) mod power_diagram;
pub(crate) mod projective_dual;
pub(crate) mod support_function;

pub use domain::{CurvatureSign, DomainError, LocatedVertex};
pub use dual_subdivision::{clear_centre_of, clear_quadric, dual_subdivision, one_sign};
pub use duality::{DualOptions, DualityError, Quadric, SubdivisionRule, dual_mesh};
pub use power_diagram::{PowerDiagram, PowerError, PowerSite, goldberg, power_diagram};
pub use projective_dual::DualDefects;
