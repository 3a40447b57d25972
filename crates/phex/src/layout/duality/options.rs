//! Options of the classical methods.

use serde::{Deserialize, Serialize};

/// Options of the methods that work by planes and their poles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DualOptions {
    /// Go on where the surface is outside the method's domain, to see what becomes of it; what fails is told by the statistics.
    pub any_domain: bool,
    /// `lambda` of `tangent-planes`, a pure number >= 0: 0 lets the planes meet exactly; from 0.05 to 0.5 vertices are held back where
    /// planes meet badly, and the optimiser makes the panels planar.
    pub regularisation: f64,
}
