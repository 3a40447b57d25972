//! The minimum on the constraints: exact second derivatives, and steps that fall to rounding.

use super::derivatives::{
    NO_BARRIER, NOTHING, gradient_agrees, hessian_agrees, rough, with_energy,
};
use super::fixtures::{Shape, brick_wall, layout, planar_paraboloid};
use super::whole::assert_sound;
use crate::Silent;
use crate::optimise::constraints::jacobian::Jacobian;
use crate::optimise::solver::energy::{PanelEnergy, Weights};
use crate::optimise::solver::solvers::constraint_assembly;
use crate::optimise::terms::barrier::Barrier;
use crate::optimise::terms::closeness::{ClosenessWeights, DistanceLimit};
use crate::optimise::{OptimiseOptions, Optimised, PathKind, optimise};
use phex_numeric::DampedProblem;

/// Some multipliers that planar faces can have.
fn some_multipliers(energy: &PanelEnergy<'_>) -> Vec<f64> {
    let panels = energy.panels();
    let assembly = constraint_assembly(panels);
    let mut jacobian = Jacobian::new(panels, &assembly);
    jacobian.linearise(
        energy.shape(),
        &mut vec![0.0; assembly.pattern().dimension()],
    );
    let mut l: Vec<f64> = (0..panels.n_corners())
        .map(|c| (1.7 * c as f64).sin())
        .collect();
    jacobian.keep_to_range(&mut l);
    l
}

#[test]
fn multiplied_heights_have_their_derivatives() {
    let bent = rough(Shape::Wave);
    with_energy(
        &bent,
        Shape::Wave,
        NOTHING,
        NO_BARRIER,
        |energy, x, hessian| {
            energy.constrain(x);
            energy.energy(x);
            energy.multipliers = Some(some_multipliers(energy));
            gradient_agrees(energy, x, hessian, bent.mean_edge());
        },
    );
    let planar = planar_paraboloid(7, 3);
    with_energy(
        &planar,
        Shape::Wave,
        NOTHING,
        NO_BARRIER,
        |energy, x, hessian| {
            energy.constrain(x);
            energy.energy(x);
            energy.multipliers = Some(some_multipliers(energy));
            hessian_agrees(energy, x, hessian, planar.mean_edge());
        },
    );
}

#[test]
fn the_barrier_in_space_has_its_derivatives() {
    let mesh = rough(Shape::MonkeySaddle);
    let barrier = Barrier {
        weight: 1e-3,
        reach: 1.2 * mesh.mean_edge(),
    };
    with_energy(
        &mesh,
        Shape::MonkeySaddle,
        NOTHING,
        barrier,
        |energy, x, hessian| {
            energy.constrain(x);
            gradient_agrees(energy, x, hessian, mesh.mean_edge());
            hessian_agrees(energy, x, hessian, mesh.mean_edge());
        },
    );
}

#[test]
fn the_stand_in_for_a_surface_has_its_derivatives_and_touches_it() {
    let closeness = ClosenessWeights {
        vertex: 1.0,
        centre: 3.0,
        rim: 0.1,
        limit: DistanceLimit::NONE,
    };
    let weights = Weights {
        closeness,
        ..NOTHING
    };
    for target in [Shape::Wave, Shape::Square] {
        let mesh = rough(target);
        with_energy(&mesh, target, weights, NO_BARRIER, |energy, x, hessian| {
            energy.constrain(x);
            let before = energy.energy(x);
            energy.freeze(x);
            let after = energy.energy(x);
            assert!((after - before).abs() <= 1e-9 * before, "{before} {after}");
            gradient_agrees(energy, x, hessian, mesh.mean_edge());
            hessian_agrees(energy, x, hessian, mesh.mean_edge());
        });
    }
}

fn finished(shape: Shape, newton_iterations: usize) -> Optimised {
    let options = OptimiseOptions {
        newton_iterations: Some(newton_iterations),
        ..OptimiseOptions::default()
    };
    let layout = layout(brick_wall(shape, 17, 10), &shape);
    optimise(&layout, &shape, &options, &Silent).unwrap()
}

#[test]
fn steps_fall_to_rounding_at_the_minimum() {
    for shape in [Shape::Wave, Shape::MonkeySaddle] {
        let result = finished(shape, 200);
        assert_sound(&result, 1e-12);
        assert_eq!(result.run.path, PathKind::Feasible);
        let on_constraints =
            |r: &&phex_numeric::Record| r.phase.is_infinite() && r.energy.is_finite();
        let history = result.outcome.history.iter().filter(on_constraints);
        let least = history.map(|r| r.step).fold(f64::INFINITY, f64::min);
        assert!(least < 1e-8, "{least:e}");
        // A few steps bring most of it.
        let [none, some] = [0, 6].map(|n| finished(shape, n).quality.clearance);
        assert!(some >= none - 0.02, "{none} {some}");
    }
}
