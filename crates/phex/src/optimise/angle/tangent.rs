//! Steps along the constraints: their equations in the metric of the energy.

use super::constraints::AngleConstraints;
use crate::optimise::error::OptimiseError;
use crate::optimise::panels::{point, put};
use crate::optimise::solver::solvers::system;
use nalgebra::Matrix3;
use phex_numeric::{Assembly, Cholesky, Constraints, SymmetricMatrix};

/// Damping of the descent at the start, over the weight of closeness, and its limits.
const DAMPING: [f64; 3] = [1e-1, 1e-4, 1e3];
/// Factorisation and memory of the descent's equations.
pub(super) struct Tangent {
    cholesky: Cholesky,
    pub(super) normal: SymmetricMatrix,
    pub(super) hessian: SymmetricMatrix,
    pub(super) gradient: Vec<f64>,
    pub(super) step: Vec<f64>,
    pub(super) multiplier: Vec<f64>,
    damping: f64,
}

impl Tangent {
    pub(super) fn new(
        energy: &Assembly,
        angles: &Assembly,
        n: usize,
    ) -> Result<Self, OptimiseError> {
        let (cholesky, normal) = system(angles, 1)?;
        Ok(Self {
            multiplier: vec![0.0; normal.dimension()],
            cholesky,
            normal,
            hessian: SymmetricMatrix::zeros(energy.pattern().clone()),
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            damping: DAMPING[0],
        })
    }

    /// Inverse diagonal blocks `W` of the damped Hessian.
    fn metric(&self) -> Vec<Matrix3<f64>> {
        let entry = |row: usize, column: usize| {
            let at = self.hessian.pattern().position(row as u32, column as u32);
            at.map_or(0.0, |k| self.hessian.values()[k])
        };
        let block = |v: usize| {
            let lower = Matrix3::from_fn(|a, b| entry(3 * v + a.max(b), 3 * v + a.min(b)));
            let damped = lower + Matrix3::identity() * self.damping;
            damped.try_inverse().unwrap_or_else(Matrix3::identity)
        };
        (0..self.gradient.len() / 3).map(block).collect()
    }

    /// The step of steepest descent in the metric `W` that keeps the linearised constraints or,
    /// with their values, meets them; false if there is none.
    pub(super) fn solve(
        &mut self,
        constraints: &mut AngleConstraints<'_>,
        values: Option<&[f64]>,
    ) -> bool {
        let metric = self.metric();
        let weighted = |d: &mut [f64]| {
            for (v, w) in metric.iter().enumerate() {
                let turned = w * point(d, v);
                put(d, v, &turned);
            }
        };
        let mut free = self.gradient.clone();
        weighted(&mut free);
        constraints.applied(&free, &mut self.multiplier);
        // J step = -values.
        for (b, value) in self.multiplier.iter_mut().zip(values.unwrap_or_default()) {
            *b -= value;
        }
        constraints.assemble(|v| metric[v], &mut self.normal);
        let shift = 1e-12 * self.normal.diagonal().fold(0.0, f64::max);
        if self.cholesky.refactor_shifted(&self.normal, shift).is_err() {
            return false;
        }
        self.cholesky.solve(&mut self.multiplier);
        constraints.transposed(&self.multiplier, &mut self.step);
        for (d, g) in self.step.iter_mut().zip(&self.gradient) {
            *d -= g;
        }
        weighted(&mut self.step);
        self.step.iter().all(|d| d.is_finite())
    }

    pub(super) fn adapt(&mut self, fraction: f64) {
        let factor = if fraction > 0.5 { 0.3 } else { 4.0 };
        self.damping = (self.damping * factor).clamp(DAMPING[1], DAMPING[2]);
    }
}
