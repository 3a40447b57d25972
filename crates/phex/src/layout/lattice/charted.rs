//! What a lattice is laid out on.

use super::boundary::Pin;
use super::eisenstein::Charts;
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{PerVertex, Topology};

/// Triangles with a metric, a chart at each vertex, and what the boundary wants of the lattice.
#[derive(Clone, Copy)]
pub(crate) struct ChartedSurface<'a> {
    pub topology: &'a Topology,
    pub mesh: &'a IntrinsicMesh,
    pub charts: &'a Charts,
    pub pins: &'a PerVertex<Option<Pin>>,
}
