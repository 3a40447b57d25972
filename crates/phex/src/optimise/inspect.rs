//! What came out: figures of the mesh, and the panels that are not as they should be.

use super::options::OptimiseOptions;
use super::panels::{FaceShapes, Panels};
use super::terms::barrier::clearance;
use super::terms::guard::{Breach, Guard};
use phex_mesh::measure::quantile;
use phex_mesh::{FaceId, ValidateOptions};
use serde::{Deserialize, Serialize};

/// What is wrong with a panel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum Fault {
    /// Two of its edges cross, or it is wound the wrong way in its own plane.
    NotSimple,
    /// A corner comes too near to an edge.
    LowClearance {
        /// Least distance between a corner and an edge that does not hold it, in mean edges.
        clearance: f64,
    },
    /// Its normal points away from the surface's.
    Flipped,
    /// The three panels at one of its vertices do not go round that vertex exactly once.
    WrongFan {
        /// Number of the vertex.
        vertex: u32,
    },
    /// It is folded by more than 90 degrees against a neighbour.
    Folded {
        /// The neighbour.
        neighbour: FaceId,
    },
    /// Its corners do not lie in a plane.
    NotPlanar {
        /// Largest distance of a corner to the best plane, in mean edges.
        distance: f64,
    },
}

/// A panel that is not as it should be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Offender {
    /// The panel.
    pub face: FaceId,
    /// What is wrong with it.
    #[serde(flatten)]
    pub fault: Fault,
}

/// Figures of a mesh. Lengths are in mean edges, deviations in the unit of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OptimisedFigures {
    /// Mean length of the edges, in the unit of the model.
    pub mean_edge: f64,
    /// Largest distance of a corner to the plane of its panel.
    pub planarity: f64,
    /// Least clearance of a panel.
    pub clearance: f64,
    /// Clearance that 95 % of the panels exceed.
    pub clearance_p05: f64,
    /// Largest distance of a vertex or panel centre to the surface.
    pub deviation_max: f64,
    /// Root mean square of those distances.
    pub deviation_rms: f64,
}

/// Figures and offenders of `x`; `deviation` is measured by the caller, who knows the surface.
pub(super) fn inspect(
    panels: &Panels,
    guard: &Guard,
    x: &[f64],
    deviation: (f64, f64),
    options: &OptimiseOptions,
) -> (OptimisedFigures, Vec<Offender>) {
    let shape = FaceShapes::at(panels, x);
    let mean_edge = panels.mean_edge(x);
    let clearances: Vec<f64> = (0..panels.n_faces())
        .map(|f| clearance(shape.face(panels, f)) / mean_edge)
        .collect();
    let mut ascending = clearances.clone();
    ascending.sort_by(f64::total_cmp);
    let quality = OptimisedFigures {
        mean_edge,
        planarity: shape.max_height() / mean_edge,
        clearance: quantile(&ascending, 0.0),
        clearance_p05: quantile(&ascending, 0.05),
        deviation_max: deviation.0,
        deviation_rms: deviation.1,
    };
    let mut offenders = measured_faults(panels, &shape, mean_edge, &clearances, options);
    for breach in guard.breaches(panels, &shape, x) {
        add_breach(panels, breach, &mut offenders);
    }
    offenders.sort_by_key(|o| o.face);
    (quality, offenders)
}

fn measured_faults(
    panels: &Panels,
    shape: &FaceShapes,
    mean_edge: f64,
    clearances: &[f64],
    options: &OptimiseOptions,
) -> Vec<Offender> {
    let mut offenders = Vec::new();
    for (f, &clearance) in clearances.iter().enumerate() {
        let heights = shape.face(panels, f).iter().map(|c| c.height.abs());
        let distance = heights.fold(0.0, f64::max) / mean_edge;
        if clearance < ValidateOptions::CLEARANCE {
            offenders.push(offender(f, Fault::LowClearance { clearance }));
        }
        if distance > options.planarity_tolerance {
            offenders.push(offender(f, Fault::NotPlanar { distance }));
        }
    }
    offenders
}

fn add_breach(panels: &Panels, breach: Breach, offenders: &mut Vec<Offender>) {
    match breach {
        Breach::NotSimple(f) => offenders.push(offender(f, Fault::NotSimple)),
        Breach::WrongSide(f) => offenders.push(offender(f, Fault::Flipped)),
        Breach::Fan(v) => {
            let vertex = v as u32;
            let faces = panels.corners_at(v).iter().map(|&c| panels.face_of(c));
            offenders.extend(faces.map(|f| offender(f, Fault::WrongFan { vertex })));
        }
        Breach::Fold([f, g]) => {
            for (one, other) in [(f, g), (g, f)] {
                let neighbour = FaceId::new(other as u32);
                offenders.push(offender(one, Fault::Folded { neighbour }));
            }
        }
    }
}

fn offender(face: usize, fault: Fault) -> Offender {
    Offender {
        face: FaceId::new(face as u32),
        fault,
    }
}
