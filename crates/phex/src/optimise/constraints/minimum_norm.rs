//! The planarity constraints, as a problem for `phex_numeric::MinimumNorm`.

use super::guarded::GuardedSteps;
use super::jacobian::Jacobian;
use super::planarity::ConstraintBases;
use crate::optimise::panels::Panels;
use crate::optimise::terms::setting::Setting;
use nalgebra::Matrix3;
use phex_numeric::{Assembly, Constraints, SymmetricMatrix};

/// The planarity constraints of all faces. Held vertices move within their tangent spaces, which
/// are the metric.
pub(in crate::optimise) struct PlanarityConstraints<'a> {
    setting: &'a Setting<'a>,
    jacobian: Jacobian<'a>,
    steps: GuardedSteps<'a>,
    /// Whether steps are held back where they lead out.
    pub passes_by: bool,
}

impl<'a> PlanarityConstraints<'a> {
    /// The unknowns of `assembly` are the constraints, its elements the vertices.
    pub fn new(
        setting: &'a Setting<'a>,
        assembly: &'a Assembly,
        start: &[f64],
        least_clearance: Option<f64>,
    ) -> Self {
        Self {
            jacobian: Jacobian::new(setting.panels, assembly),
            steps: GuardedSteps::new(setting, start, least_clearance),
            setting,
            passes_by: true,
        }
    }

    /// Constraints that each vertex takes part in, as elements of the assembly of `J J^T`.
    pub fn elements(panels: &Panels) -> Vec<Vec<u32>> {
        let bases = ConstraintBases::new(panels);
        let of_corner = |&c: &u32| bases.of_face(panels.face_of(c)).map(|i| i as u32);
        let of_vertex = |v| panels.corners_at(v).iter().flat_map(of_corner).collect();
        (0..panels.n_vertices()).map(of_vertex).collect()
    }

    /// Number of constraints.
    pub fn count(panels: &Panels) -> usize {
        ConstraintBases::new(panels).n_constraints()
    }
}

impl Constraints for PlanarityConstraints<'_> {
    fn linearise(&mut self, x: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix) {
        self.steps.linearised.update(self.setting.panels, x);
        self.jacobian.metric.fill(Matrix3::identity());
        for (v, freedom) in self.setting.holds.freedoms(x) {
            self.jacobian.metric[v as usize] = freedom;
        }
        self.jacobian.linearise(&self.steps.linearised, values);
        self.jacobian.normal_matrix(normal);
    }

    fn transposed(&self, y: &[f64], d: &mut [f64]) {
        self.jacobian.spread(y, d);
    }

    fn step_bound(&mut self, _x: &[f64], step: &[f64]) -> f64 {
        self.steps.bound(&self.setting.holds.whole_step(step))
    }

    fn admissible(&mut self, x: &[f64]) -> Option<f64> {
        self.steps.admits(x).then(|| self.steps.planarity())
    }

    fn hold_back(&mut self, x: &[f64], step: &mut [f64]) {
        match self.passes_by {
            true => self.steps.hold_back(x, step),
            false => step.iter_mut().for_each(|d| *d *= 0.5),
        }
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        self.steps.length(step)
    }

    fn retract(&self, x: &mut [f64]) {
        self.setting.holds.retract(x);
    }
}
