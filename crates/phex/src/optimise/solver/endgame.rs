//! The end of the feasible path: the energy minimised on the constraints themselves.
//!
//! The phases end where the energy hardly falls, which is far from a minimum: soft directions along
//! the surface decide how much room the tightest panels have. From the planar positions Newton's
//! method on the Lagrangian (`phex_numeric::lagrange`) of
//!
//! ```text
//! minimise closeness + fairness + barrier + anchor   under   Q^T h = 0
//! ```
//!
//! goes on with exact second derivatives: of the constraints (`planarity::add_multiplied`), of the
//! barrier (`spatial_barrier`), and of the closeness to a smooth stand-in for the surface
//! (`osculating`). Near the minimum steps fall to rounding within four iterations.

use super::energy::PanelEnergy;
use crate::optimise::constraints::jacobian::Jacobian;
use phex_numeric::{
    Assembly, Cholesky, DampedProblem, LagrangeNewton, LagrangeOptions, LagrangeProblem, Outcome,
    Record, SymmetricMatrix,
};
use std::ops::ControlFlow;

/// Weight of the squared constraints beside the multipliers.
pub(super) const RIGIDITY: f64 = 3e3;
/// Step, in mean edges, that counts as none.
const NO_STEP: f64 = 1e-9;

/// Length of a move, in mean edges, after which the stand-in for the surface is kept: it is good
/// nearby.
const NEARBY: f64 = 1e-2;

/// Minimises on the constraints, from positions that nearly meet them, with `most` iterations at
/// the most.
///
/// `assembly` is that of the constraints, `system` belongs to the energy.
pub(super) fn minimise_on_constraints(
    energy: &mut PanelEnergy<'_>,
    assembly: &Assembly,
    system: (&mut Cholesky, &mut SymmetricMatrix),
    x: &mut [f64],
    most: usize,
    observe: impl FnMut(&Record) -> ControlFlow<()>,
) -> Outcome {
    energy.constrain(x);
    let limits = LagrangeOptions {
        max_iterations: most,
        step_tolerance: NO_STEP,
        phase: f64::INFINITY,
    };
    let mut problem = OnConstraints {
        jacobian: Jacobian::new(energy.panels(), assembly),
        energy,
        last: Vec::new(),
        is_nearby: false,
    };
    let mut newton = LagrangeNewton::new(system, assembly.pattern().dimension());
    newton.minimise(&mut problem, x, &limits, observe)
}

/// The energy with multipliers of planarity, and the constraints linearised.
struct OnConstraints<'e, 'a> {
    energy: &'e mut PanelEnergy<'a>,
    jacobian: Jacobian<'e>,
    /// Where the stand-in touched the surface last.
    last: Vec<f64>,
    is_nearby: bool,
}

impl OnConstraints<'_, '_> {
    /// Lets the stand-in touch the surface anew, until positions hardly change.
    fn follow_surface(&mut self, x: &[f64]) {
        if self.is_nearby {
            return;
        }
        let moved: Vec<f64> = x.iter().zip(&self.last).map(|(x, l)| x - l).collect();
        self.is_nearby = !moved.is_empty() && self.step_length(&moved) < NEARBY;
        self.energy.freeze(x);
        self.last = x.to_vec();
    }
}

impl LagrangeProblem for OnConstraints<'_, '_> {
    fn merit(&mut self, x: &[f64]) -> f64 {
        self.energy.energy(x)
    }

    fn linearise(
        &mut self,
        x: &[f64],
        gradient: &mut [f64],
        values: &mut [f64],
        hessian: &mut SymmetricMatrix,
    ) {
        for (v, freedom) in self.energy.holds().freedoms(x) {
            self.jacobian.metric[v as usize] = freedom;
        }
        self.follow_surface(x);
        self.energy.energy(x);
        self.jacobian.linearise(self.energy.shape(), values);
        if let Some(l) = &mut self.energy.multipliers {
            self.jacobian.keep_to_range(l);
        }
        self.energy.linearise(x, gradient, hessian);
    }

    fn product(&self, d: &[f64], values: &mut [f64]) {
        self.jacobian.product(d, values);
    }

    fn spread(&self, y: &[f64], d: &mut [f64]) {
        self.jacobian.spread(y, d);
    }

    fn add_multipliers(&mut self, change: &[f64]) {
        if let Some(l) = &mut self.energy.multipliers {
            self.jacobian.add_at_corners(change, l);
        }
    }

    fn step_bound(&mut self, x: &[f64], step: &[f64]) -> f64 {
        DampedProblem::step_bound(self.energy, x, step)
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        DampedProblem::step_length(self.energy, step)
    }

    fn residual(&self) -> f64 {
        DampedProblem::residual(self.energy)
    }

    fn retract(&self, x: &mut [f64]) {
        DampedProblem::retract(self.energy, x);
    }
}
