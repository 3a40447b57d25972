//! What a run has reached, and how.

use crate::optimise::RunSummary;
use crate::optimise::inspect::Offender;
use crate::optimise::options::{OptimiseOptions, PathKind, StartKind};
use crate::optimise::panels::FaceShapes;
use crate::optimise::terms::barrier::clearance;
use crate::optimise::terms::setting::Setting;
use phex_numeric::{Outcome, Status};

/// What came of one start.
pub(in crate::optimise) struct Run {
    pub x: Vec<f64>,
    pub outcome: Outcome,
    pub offenders: Vec<Offender>,
    pub summary: RunSummary,
}

impl Run {
    pub fn is_cancelled(&self) -> bool {
        self.outcome.status == Status::Cancelled
    }
}

/// How a result came about.
pub(in crate::optimise) struct ResultOrigin {
    pub kind: StartKind,
    pub path: PathKind,
    /// Factorisations for parts of the mesh alone.
    pub in_parts: usize,
    pub outcome: Outcome,
}

/// Positions and what they are judged by on the way.
pub(in crate::optimise) struct Reached {
    pub x: Vec<f64>,
    planarity: f64,
    clearance: f64,
}

impl Reached {
    pub fn at(setting: &Setting<'_>, x: Vec<f64>) -> Self {
        let shape = FaceShapes::at(setting.panels, &x);
        let faces = 0..setting.panels.n_faces();
        let clearances = faces.map(|f| clearance(shape.face(setting.panels, f)));
        Self {
            planarity: shape.max_height() / setting.mean_edge,
            clearance: clearances.fold(f64::INFINITY, f64::min) / setting.panels.mean_edge(&x),
            x,
        }
    }

    pub(crate) fn is_planar(&self, options: &OptimiseOptions) -> bool {
        self.planarity <= options.planarity_tolerance
    }
}

/// The planar one; of two planar ones that with more clearance.
pub(in crate::optimise) fn better(a: Reached, b: Reached, options: &OptimiseOptions) -> Reached {
    let planar = [&a, &b].map(|reached| reached.is_planar(options));
    let second = match planar {
        [true, false] => false,
        [false, true] => true,
        [false, false] => b.planarity < a.planarity,
        [true, true] => b.clearance > a.clearance,
    };
    if second { b } else { a }
}
