//! Panels before any of them is planar.

use super::domain::Ground;
use super::lattice::laid_out;
use super::options::Candidate;
use super::{Clock, PipelineError, StageSeconds};
use crate::directions::guides::Cone;
use crate::layout::LayoutStatistics;
use crate::smooth_surface::Affinity;
use phex_mesh::HexMesh;

/// The panels of a lattice as they are laid out, on the surface and not planar.
#[derive(Clone)]
pub struct LatticePreview {
    /// The panels, in model coordinates; where they will be cut at the boundary they are whole.
    pub mesh: HexMesh,
    /// The lattice.
    pub statistics: LayoutStatistics,
    /// The cones of its direction field, in model coordinates.
    pub cones: Vec<Cone>,
    /// Where the time went.
    pub stages: Vec<StageSeconds>,
}

impl LatticePreview {
    pub(super) fn restored(mut self, affinity: &Affinity) -> Self {
        self.mesh = self.mesh.mapped(|p| affinity.restore(*p));
        for cone in &mut self.cones {
            *cone = cone.moved(|p| affinity.restore(p));
        }
        self
    }
}

/// Lays out the panels of the ground's options, normalised.
pub(super) fn lay_out(
    ground: &Ground,
    clock: &mut Clock<'_>,
) -> Result<LatticePreview, PipelineError> {
    let laid = laid_out(ground, Candidate::first(&ground.options), clock)?;
    Ok(LatticePreview {
        cones: laid.cones,
        mesh: laid.layout.mesh,
        statistics: laid.statistics,
        stages: std::mem::take(&mut clock.stages),
    })
}
