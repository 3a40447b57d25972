//! Large meshes part by part, retries around single panels, and what is shared out among surfaces.

use super::fixtures::{Shape, brick_wall};
use super::whole::{all_simple, assert_sound};
use crate::layout::VertexKind;
use crate::optimise::holds::Hold;
use crate::optimise::panels::{points, unknowns};
use crate::optimise::solver::energy::PanelEnergy;
use crate::optimise::solver::energy::{Weights, panel_energy};
use crate::optimise::solver::parts::{Cuts, PartRegion, minimise_in_parts};
use crate::optimise::solver::solvers::{StepReporter, energy_assembly};
use crate::optimise::targets::reference::Reference;
use crate::optimise::terms::barrier::barriers;
use crate::optimise::{Anchor, GroundPlane, OptimiseOptions, Stage, Steering, planarize};
use crate::progress::Silent;
use phex_mesh::{HexMesh, PerVertex, TriangleSurface, Vec3, VertexId};
use phex_numeric::{DampedOptions, DampedProblem, SymmetricMatrix};
use std::f64::consts::PI;

/// The rest is at rest while a part moves, and nothing ever gets worse for the whole.
#[test]
fn part_by_part_the_energy_falls_and_panels_stay_simple() {
    let shape = Shape::Wave;
    let wall = brick_wall(shape, 20, 18);
    let options = OptimiseOptions::default();
    let reference = Reference::Surface(&shape);
    let stage = Stage::new(
        &wall,
        reference,
        None,
        &VertexKind::of_mesh(&wall),
        &options,
    );
    let start = unknowns(&wall);
    let setting = stage.setting(&start);
    let assembly = energy_assembly(setting.panels);
    let energy = |x: &[f64], penalty: f64| {
        let mut whole = panel_energy(&setting, &assembly, &start, &options);
        whole.weights.planarity = penalty;
        whole.energy(x)
    };
    let (barriers, mut x) = (barriers(setting.panels, &start, &options), start.clone());
    for (phase, &penalty) in crate::optimise::options::PENALTIES.iter().enumerate() {
        let mut weights = Weights::of(&options, &setting);
        weights.planarity = penalty;
        let limits = DampedOptions {
            max_iterations: 15,
            energy_tolerance: 3e-2,
            step_tolerance: 1e-3,
            phase: penalty,
        };
        let before = energy(&x, penalty);
        let outcome = minimise_in_parts(
            &setting,
            |s, assembly, part| {
                let anchor = part.of_vertices(&start);
                PanelEnergy::new(s, assembly, weights, part.of_faces(&barriers), &anchor)
            },
            &mut x,
            &Cuts { most: 70, phase },
            &limits,
            &mut StepReporter::new(&Silent, "optimise", 0),
        )
        .unwrap();
        assert!(outcome.factorisations >= 3, "{outcome:?}");
        assert!(energy(&x, penalty) < before, "phase {phase}");
        let mesh = wall.with_positions(PerVertex::from_vec(points(&x)));
        assert!(all_simple(&mesh), "phase {phase}");
    }
    // What comes out is close to planar, as after the same phases on the whole.
    let planarity = |x: &[f64]| {
        let shape = crate::optimise::panels::FaceShapes::at(setting.panels, x);
        shape.max_height() / setting.mean_edge
    };
    assert!(planarity(&x) < 1e-3 && planarity(&x) < 0.1 * planarity(&start));
}

/// A projection in a region makes its panels planar again, and moves nothing else.
#[test]
fn a_region_is_made_planar_and_the_rest_stays() {
    let shape = Shape::Wave;
    let options = OptimiseOptions::default();
    let planar = planarize(&brick_wall(shape, 20, 18), Some(&shape), &options, &Silent).unwrap();
    let mesh = planar.mesh;
    let mut stage = Stage::new(
        &mesh,
        Reference::Surface(&shape),
        None,
        &VertexKind::of_mesh(&mesh),
        &options,
    );
    let (x, topology) = (unknowns(&mesh), mesh.topology());
    let at = |v: &VertexId| topology.face_degree(*v) == 2;
    let v = topology.vertices().find(at).unwrap();
    let mut start = x.clone();
    start[3 * v.index()] += 0.02 * mesh.mean_edge();
    let place = Vec3::from_column_slice(&start[3 * v.index()..3 * v.index() + 3]);
    (stage.holds.held).insert(v.index() as u32, Hold::At(place));
    let region = PartRegion::near(&stage.panels, [v.index() as u32].into_iter(), 4);
    let mut solvers = region.solvers(&stage.panels).unwrap();
    let from = stage.start_at(&start);
    let run = stage.run_projection_of(&region, &mut solvers, &from, &options, &Silent);
    assert!(run.offenders.is_empty(), "{:?}", run.offenders);
    assert_eq!(run.x[3 * v.index()..][..3], *place.as_slice());
    let moved = (0..x.len()).filter(|k| run.x[*k] != x[*k]).count();
    assert!(moved > 20 && 3 * moved < x.len(), "{moved} of {}", x.len());
    assert_eq!(region.moved(&run.x, &x), run.x);
}

/// Faces whose vertices are all fixed have no place in the matrices, and the others feel no
/// difference.
#[test]
fn faces_at_rest_are_felt_by_none() {
    let shape = Shape::Wave;
    let wall = brick_wall(shape, 12, 9);
    let (options, x) = (OptimiseOptions::default(), unknowns(&wall));
    let linearised = |with_rest: bool| {
        let reference = Reference::Surface(&shape);
        let mut stage = Stage::new(
            &wall,
            reference,
            None,
            &VertexKind::of_mesh(&wall),
            &options,
        );
        for (v, p) in wall.positions.enumerate().filter(|(_, p)| p.x < 0.0) {
            stage.holds.held.insert(v.index() as u32, Hold::At(*p));
        }
        if with_rest {
            stage.panels = (stage.panels.clone()).with_rest(|v| stage.holds.fixes(v));
        }
        let setting = stage.setting(&x);
        let assembly = energy_assembly(setting.panels);
        let mut energy = panel_energy(&setting, &assembly, &x, &options);
        energy.weights.planarity = 30.0;
        let mut hessian = SymmetricMatrix::zeros(assembly.pattern().clone());
        let (mut gradient, mut product) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        energy.linearise(&x, &mut gradient, &mut hessian);
        let direction: Vec<f64> = (0..x.len()).map(|k| (1.3 * k as f64).sin()).collect();
        hessian.mul(&direction, &mut product);
        (assembly.n_block_entries(), [gradient, product].concat())
    };
    let ((some, with), (all, without)) = (linearised(true), linearised(false));
    assert!(2 * some < 3 * all / 2, "{some} of {all} entries");
    let differs = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-12 * (1.0 + b.abs());
    assert!(!with.iter().zip(&without).any(differs));
}

/// A bound on the deviation that the default misses is met, or at least approached, with panels as
/// planar and simple as ever.
#[test]
fn a_bound_on_the_deviation_draws_panels_nearer() {
    let shape = Shape::MonkeySaddle;
    let start = brick_wall(shape, 19, 9);
    let made = |o: &OptimiseOptions| planarize(&start, Some(&shape), o, &Silent).unwrap();
    let free = made(&OptimiseOptions::default());
    let share = free.quality.deviation_max / free.mesh.diagonal();
    let options = OptimiseOptions {
        max_deviation: Some(0.8 * share),
        ..OptimiseOptions::default()
    };
    let bound = made(&options);
    assert_sound(&bound, 1e-13);
    assert!(
        bound.quality.deviation_max < 0.95 * free.quality.deviation_max,
        "{:?} {:?}",
        free.quality,
        bound.quality
    );
}

/// Every brick of an egg-crate gets room, though curvature across the rows changes sign.
#[test]
fn tight_panels_get_room() {
    let wall = brick_wall(Shape::Wave, 41, 20);
    let result = planarize(&wall, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_sound(&result, 1e-13);
    assert!(result.quality.clearance >= 0.28, "{:?}", result.quality);
}

/// A wall over a whole period of the egg-crate, where curvature across the rows changes sign.
fn whole_period(columns: usize, rows: usize) -> HexMesh {
    let wall = brick_wall(Shape::Wave, columns, rows);
    wall.with_positions(PerVertex::from_fn(wall.topology().n_vertices(), |v| {
        let at = PI / 2.0 * (wall.position(v) + Vec3::new(2.0, 2.0, 0.0));
        Vec3::new(at.x, at.y, Shape::Wave.height(at.x, at.y))
    }))
}

/// Phases of low penalty lead rows of so fine a wall to where they turn round, and few panels keep
/// all others from becoming planar; the highest penalty at once does not, and no last resort is
/// needed.
#[test]
fn rows_that_would_turn_round_begin_with_the_highest_penalty() {
    let wall = whole_period(142, 70);
    let result = planarize(&wall, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_sound(&result, 1e-13);
    assert!(
        result.quality.clearance >= 0.3 && result.run.factorisations <= 35,
        "{:?}",
        result.run
    );
}

/// On a wall that has to slide along the surface the hold on the start is given up early, not after
/// all phases.
#[test]
fn a_hold_that_is_too_strong_is_given_up_early() {
    let wall = whole_period(100, 48);
    let result = planarize(&wall, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_sound(&result, 1e-13);
    assert!(
        result.quality.clearance >= 0.3 && result.run.factorisations <= 40,
        "{:?}",
        result.run
    );
}

fn square(corner: Vec3) -> TriangleSurface {
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let positions = corners.map(|[x, y]| corner + Vec3::new(x, y, 0.0));
    TriangleSurface::new(positions.to_vec(), &[[0, 1, 2], [0, 2, 3]]).unwrap()
}

/// Two squares: each gets what is nearest.
#[test]
fn what_is_held_goes_to_the_nearest_surface() {
    let surfaces = [square(Vec3::zeros()), square(Vec3::new(20.0, 0.0, 5.0))];
    let steering = Steering {
        fixed_vertices: vec![3],
        fixed_points: vec![[19.0, 0.0, 5.0], [1.0, 0.0, 0.0]],
        anchors: vec![Anchor {
            point: [21.0, 0.0, 5.0],
            weight: 2.0,
        }],
        curves: vec![vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0]]],
        grounds: vec![GroundPlane {
            point: None,
            normal: [0.0, 0.0, 1.0],
            reach: Some(0.5),
        }],
    };
    let shares = steering.shared(&surfaces, 0.1);
    assert_eq!(shares[0].fixed_points, [[1.0, 0.0, 0.0]]);
    assert_eq!(shares[1].fixed_points, [[19.0, 0.0, 5.0]]);
    assert_eq!([shares[0].anchors.len(), shares[1].anchors.len()], [0, 1]);
    assert_eq!([shares[0].curves.len(), shares[1].curves.len()], [1, 0]);
    assert_eq!([shares[0].grounds.len(), shares[1].grounds.len()], [1, 0]);
    assert!(shares.iter().all(|s| s.fixed_vertices.is_empty()));
    let nowhere = Steering {
        grounds: vec![GroundPlane {
            point: Some([0.0, 0.0, -9.0]),
            normal: [0.0, 0.0, 1.0],
            reach: Some(0.5),
        }],
        ..Steering::default()
    };
    let shares = nowhere.shared(&surfaces, 0.1);
    assert!(shares.iter().all(|s| s.grounds.len() == 1), "to be refused");
}
