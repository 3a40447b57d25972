//! What a mesh must keep to.

use crate::trim::Boundary;
use phex_mesh::PanelLimits;
use phex_mesh::validate::ValidateOptions;
use serde::{Deserialize, Serialize};

/// Distance to the surface, over the diagonal, that panels keep to where nothing else is asked for:
/// what PH-CPF allows.
pub const USUAL_DEVIATION: f64 = 5e-3;
/// Share of an open surface's area that panels cover at least, whatever happens at the boundary:
/// `whole` leaves half a row of panels bare. Trimming to whole panels keeps to half a hundredth
/// more (`trim/whole.rs`).
const COVERED: f64 = 0.97;
/// Width of the band along the boundary, in mean edges, in which the surface need not be near the
/// panels: whole panels leave half a row of it bare.
const BARE_RIM: f64 = 2.0;

/// What a mesh must keep to: every search compares meshes by these limits, and every report judges
/// by them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Limits of validity; lengths in mean edges.
    pub validity: ValidateOptions,
    /// Largest distance between mesh and reference surface, over the diagonal of the surface's
    /// bounding box; `None` does not limit it.
    pub deviation_rel: Option<f64>,
    /// Largest distance between the boundaries of mesh and open surface, over the same diagonal;
    /// `None` does not limit it.
    pub boundary_rel: Option<f64>,
    /// Least share of an open surface's area that panels cover, 0 to 1; `None` does not limit it.
    pub covered: Option<f64>,
    /// What a workshop can make; lengths in the unit of the mesh.
    pub panels: PanelLimits,
}

impl Limits {
    /// The usual limits with a largest deviation, over the diagonal, for panels that end as they
    /// do; `None` where that is not known, or where the boundary is led elsewhere.
    pub fn new(deviation_rel: Option<f64>, boundary: Option<Boundary>) -> Self {
        let follows = boundary.is_some_and(|how| how != Boundary::Whole);
        Self {
            deviation_rel,
            boundary_rel: deviation_rel.filter(|_| follows),
            covered: boundary.map(|_| COVERED),
            ..Self::default()
        }
    }

    /// Width of the band along the boundary, in model units, in which points of the surface need
    /// not be near the panels. Where panels follow the boundary, its limit does for the points as
    /// close to it as that; where they are left whole or their boundary `is_led` elsewhere, the
    /// band is two mean edges wide.
    pub(super) fn bare_rim(&self, [mean_edge, diagonal]: [f64; 2], is_led: bool) -> f64 {
        let rows = BARE_RIM * mean_edge;
        let follows = self.boundary_rel.filter(|_| !is_led);
        follows.map_or(rows, |limit| rows.min(limit * diagonal))
    }

    /// Whether panels are left whole at the boundary, so that those of two sides of a slit or a
    /// notch can overlap.
    pub(super) fn leaves_boundary(&self) -> bool {
        self.covered.is_some() && self.deviation_rel.is_some() && self.boundary_rel.is_none()
    }
}
