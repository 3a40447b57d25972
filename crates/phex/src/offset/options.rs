//! Options of offsets.

use phex_mesh::ValidateOptions;
use serde::{Deserialize, Serialize};

/// Options of everything that is computed here.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OffsetOptions {
    /// What is asked of the mesh (its planarity) and of every offset (all of it).
    pub validity: ValidateOptions,
    /// Largest defect of the angle condition that vertex offsets take, in radians. Default 1e-9:
    /// what then adds up over a thousand faces still leaves edges parallel to 1e-6.
    pub angle: f64,
    /// Largest failure to close, on the unit sphere, that vertex offsets take. Default 1e-7.
    pub closing: f64,
}

impl Default for OffsetOptions {
    fn default() -> Self {
        Self {
            validity: ValidateOptions::default(),
            angle: 1e-9,
            closing: 1e-7,
        }
    }
}
