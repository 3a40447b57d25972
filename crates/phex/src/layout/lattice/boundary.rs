//! The lattice at the boundary: the outermost row of panels keeps half a row's distance from it.
//!
//! Where a lattice row runs along the boundary (see [`crate::directions::boundary`]), cells of the
//! outermost row are whole if the row's lattice points lie half a row's height inside. With `n` the
//! inward normal in a vertex's chart and `z` the offset of a lattice point, that is `<n, z> = h / 2
//! (mod h)`, `h` the height of a row: the wave whose reciprocal vector is `n / h` has the value -1
//! there. A [`Pin`] draws the offsets to it, in every step of the layout; along a mirror plane it
//! draws them to whole rows, and across one to columns ([`PinnedTo`]).

use super::eisenstein::{CELL, Plane, dot};
use crate::directions::Directions;
use crate::directions::boundary::{BoundaryFrame, frames};
use phex_mesh::{PerVertex, Topology, VertexId};
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6};

/// Weight that draws rows along the boundary to half a row's distance from it, per panel length.
const BOUNDARY_PHASE: f64 = 3.0;
/// Angle between row and boundary, radians, from which on nothing is pinned.
const MAX_MISFIT: f64 = 0.25;

/// What the boundary wants of the lattice at one of its vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pin {
    /// The wave (0 to 2) whose crests run along the boundary.
    pub wave: usize,
    /// Inward normal of the rows, a unit vector in the vertex's chart.
    pub normal: Plane,
    /// Weight: length of the boundary at the vertex, less where the row does not run along it.
    pub weight: f64,
    pub to: PinnedTo,
}

/// Where lattice points lie that a pin draws to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PinnedTo {
    /// Half a row inside the boundary.
    HalfRow,
    /// On a mirror plane that rows run along.
    Row,
    /// On a mirror plane at right angles to rows: every other row has a point there.
    Column,
}

impl Pin {
    /// The way to the nearest offset half-way between two rows, or on a row or a column.
    pub(crate) fn correction(&self, z: Plane) -> Plane {
        let (spacing, phase) = match self.to {
            PinnedTo::HalfRow => (CELL, 0.5),
            PinnedTo::Row => (CELL, 0.0),
            PinnedTo::Column => (0.5, 0.0),
        };
        let height = dot(self.normal, z) / spacing - phase;
        self.normal * ((height.round() - height) * spacing)
    }
}

/// Pins of the boundary's vertices, `None` inside and where no row runs along the boundary.
pub(crate) fn pins(topology: &Topology, directions: &Directions) -> PerVertex<Option<Pin>> {
    let frames = frames(topology, &directions.intrinsic);
    PerVertex::from_fn(topology.n_vertices(), |v: VertexId| {
        let frame = frames[v].as_ref()?;
        if directions.intrinsic.multiplicity[v] > 1 {
            return mirror_pin(frame, directions, v);
        }
        // Rows have their normals at odd multiples of a twelfth of a turn.
        let sixths = (frame.inward - directions.angle[v]) / FRAC_PI_3 - 0.5;
        let misfit = (sixths - sixths.round()) * FRAC_PI_3;
        let fit = 1.0 - (misfit / MAX_MISFIT).powi(2);
        let m = sixths.round().rem_euclid(6.0);
        (fit > 0.0).then(|| Pin {
            wave: m as usize % 3,
            normal: Plane::from_polar(1.0, FRAC_PI_3 * (m + 0.5)),
            weight: BOUNDARY_PHASE * fit * frame.length,
            to: PinnedTo::HalfRow,
        })
    })
}

/// Weight of pins in mirror planes, per panel length.
const MIRROR_WEIGHT: f64 = 20.0;

/// What a mirror plane wants: `None` where two of them meet.
fn mirror_pin(frame: &BoundaryFrame, directions: &Directions, v: VertexId) -> Option<Pin> {
    // Twelfths of a turn: odd where rows run along the plane.
    let twelfths = ((frame.inward - directions.angle[v]) / FRAC_PI_6).round();
    let m = twelfths.rem_euclid(12.0) as usize;
    let is_single = directions.intrinsic.multiplicity[v] == 2;
    is_single.then(|| Pin {
        wave: (m / 2) % 3,
        normal: Plane::from_polar(1.0, FRAC_PI_6 * m as f64),
        weight: MIRROR_WEIGHT * frame.length,
        to: match m % 2 {
            1 => PinnedTo::Row,
            _ => PinnedTo::Column,
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::lattice::eisenstein::reciprocal;

    #[test]
    fn half_way_between_two_rows_the_wave_is_at_its_trough() {
        for m in 0..3 {
            let normal = reciprocal(m) * CELL;
            let pin = Pin {
                wave: m,
                normal,
                weight: 1.0,
                to: PinnedTo::HalfRow,
            };
            for z in [Plane::new(0.3, -0.8), Plane::new(-1.7, 0.2)] {
                let z = z + pin.correction(z);
                let phase = dot(reciprocal(m), z);
                assert!((phase - phase.floor() - 0.5).abs() < 1e-12);
                assert!(pin.correction(z).norm() < 1e-12);
            }
        }
    }
}
