//! Gradients and Hessians against finite differences, and the constraints against their own
//! Jacobian.

use super::fixtures::{Shape, brick_wall, jittered, planar_paraboloid, planar_saddle, turn_edge};
use crate::optimise::constraints::jacobian::Jacobian;
use crate::optimise::constraints::minimum_norm::PlanarityConstraints;
use crate::optimise::holds::Holds;
use crate::optimise::panels::{Panels, unknowns};
use crate::optimise::solver::energy::{PanelEnergy, Weights};
use crate::optimise::targets::reference::Reference;
use crate::optimise::terms::areas::{AreaWish, any};
use crate::optimise::terms::barrier::Barrier;
use crate::optimise::terms::closeness::{ClosenessWeights, DistanceLimit};
use crate::optimise::terms::concavity::ConcavityTerm;
use crate::optimise::terms::edge_lengths::EdgeLengths;
use crate::optimise::terms::guard::Guard;
use crate::optimise::terms::inequality::Elastic;
use crate::optimise::terms::setting::Setting;
use crate::optimise::{FaceLimits, ShapeWish};
use nalgebra::Matrix3;
use phex_mesh::{EdgeId, FaceId, HexMesh, PanelLimits, PerEdge, Vec3};
use phex_numeric::{Assembly, Constraints, DampedProblem, SymmetricMatrix};

pub(super) const NOTHING: Weights = Weights {
    planarity: 0.0,
    closeness: ClosenessWeights {
        vertex: 0.0,
        centre: 0.0,
        rim: 0.0,
        limit: DistanceLimit::NONE,
    },
    fairness: 0.0,
    anchor: 0.0,
    corner: 0.0,
    limits: 0.0,
};

pub(super) const NO_BARRIER: Barrier = Barrier {
    weight: 0.0,
    reach: 0.01,
};

/// Calls `test` with the energy of a mesh that has only the given terms.
pub(super) fn with_energy(
    mesh: &HexMesh,
    target: Shape,
    weights: Weights,
    barrier: Barrier,
    test: impl FnOnce(&mut PanelEnergy<'_>, &[f64], &mut SymmetricMatrix),
) {
    with_limits(
        mesh,
        target,
        (weights, &FaceLimits::none(mesh.topology().n_faces())),
        barrier,
        test,
    );
}

fn with_limits(
    mesh: &HexMesh,
    target: Shape,
    (weights, limits): (Weights, &FaceLimits),
    barrier: Barrier,
    test: impl FnOnce(&mut PanelEnergy<'_>, &[f64], &mut SymmetricMatrix),
) {
    let panels = Panels::new(mesh.topology());
    let x = unknowns(mesh);
    let (reference, guard) = (
        Reference::Surface(&target),
        Guard::new(mesh.topology(), None, 0.1),
    );
    let boundary = mesh.topology().vertices();
    let boundary = boundary.filter(|&v| mesh.topology().is_boundary_vertex(v));
    let rim: Vec<u32> = boundary.map(|v| v.index() as u32).collect();
    let corner: Vec<bool> = (0..panels.n_vertices()).map(|v| v % 5 == 0).collect();
    // Areas of any proportion that nobody insists on: they scale like edges alone.
    let size = |f: usize| AreaWish {
        area: if matches!(target, Shape::Square) {
            1.0
        } else {
            1.0 + (f % 3) as f64
        },
        weight: 0.0,
    };
    let areas: Vec<AreaWish> = (0..panels.n_faces()).map(size).collect();
    let setting = Setting {
        panels: &panels,
        reference: &reference,
        guard: &guard,
        rim: &rim,
        corner: &corner,
        holds: &Holds::default(),
        areas: &areas,
        limits,
        mean_edge: panels.mean_edge(&x),
    };
    let dofs = |v: u32| [3 * v, 3 * v + 1, 3 * v + 2];
    let faces =
        (0..panels.n_faces()).map(|f| panels.vertices(f).iter().flat_map(|&v| dofs(v)).collect());
    let vertices = (0..panels.n_vertices() as u32).map(|v| dofs(v).to_vec());
    let elements: Vec<Vec<u32>> = faces.chain(vertices).collect();
    let assembly = Assembly::new(x.len(), &elements);
    let barriers = vec![barrier; panels.n_faces()];
    let mut energy = PanelEnergy::new(&setting, &assembly, weights, barriers, &x);
    let mut hessian = SymmetricMatrix::zeros(assembly.pattern().clone());
    test(&mut energy, &x, &mut hessian);
}

fn gradient(energy: &mut PanelEnergy<'_>, x: &[f64], hessian: &mut SymmetricMatrix) -> Vec<f64> {
    let mut g = vec![0.0; x.len()];
    energy.energy(x);
    energy.linearise(x, &mut g, hessian);
    g
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| v.abs().max(m))
}

/// The gradient agrees with central differences of the energy.
fn gradient_is_right(weights: Weights, barrier: Barrier, target: Shape, mesh: &HexMesh) {
    with_energy(mesh, target, weights, barrier, |energy, x, hessian| {
        gradient_agrees(energy, x, hessian, mesh.mean_edge());
    });
}

pub(super) fn gradient_agrees(
    energy: &mut PanelEnergy<'_>,
    x: &[f64],
    hessian: &mut SymmetricMatrix,
    mean_edge: f64,
) {
    let g = gradient(energy, x, hessian);
    assert!(largest(&g) > 0.0);
    let step = 1e-6 * mean_edge;
    let mut x = x.to_vec();
    for k in 0..x.len() {
        let at = x[k];
        let mut difference = 0.0;
        for sign in [1.0, -1.0] {
            x[k] = at + sign * step;
            difference += sign * energy.energy(&x) / (2.0 * step);
        }
        x[k] = at;
        let error = (difference - g[k]).abs() / largest(&g);
        assert!(
            error < 2e-7,
            "unknown {k}: {difference:e} against {:e}",
            g[k]
        );
    }
}

/// The Hessian agrees with central differences of the gradient.
fn hessian_is_right(weights: Weights, target: Shape, mesh: &HexMesh) {
    with_energy(mesh, target, weights, NO_BARRIER, |energy, x, hessian| {
        hessian_agrees(energy, x, hessian, mesh.mean_edge());
    });
}

pub(super) fn hessian_agrees(
    energy: &mut PanelEnergy<'_>,
    x: &[f64],
    hessian: &mut SymmetricMatrix,
    mean_edge: f64,
) {
    gradient(energy, x, hessian);
    let exact = hessian.clone();
    let step = 1e-6 * mean_edge;
    let mut x = x.to_vec();
    for k in 0..x.len() {
        let at = x[k];
        let mut column = vec![0.0; x.len()];
        for sign in [1.0, -1.0] {
            x[k] = at + sign * step;
            let g = gradient(energy, &x, hessian);
            column
                .iter_mut()
                .zip(g)
                .for_each(|(c, g)| *c += sign * g / (2.0 * step));
        }
        x[k] = at;
        let (mut unit, mut expected) = (vec![0.0; x.len()], vec![0.0; x.len()]);
        unit[k] = 1.0;
        exact.mul(&unit, &mut expected);
        let size = largest(exact.values());
        let error = column
            .iter()
            .zip(&expected)
            .map(|(c, e)| (c - e).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-6 * size, "column {k}: {error:e} of {size:e}");
    }
}

/// A rough little mesh with a pentagon and a heptagon.
pub(super) fn rough(shape: Shape) -> HexMesh {
    let wall = brick_wall(shape, 7, 4);
    let topology = wall.topology();
    let inner = |e: &phex_mesh::EdgeId| {
        let ends = topology.edge_vertices(*e);
        ends.iter().all(|&v| !topology.is_boundary_vertex(v))
    };
    let edge = topology.edges().find(inner).unwrap();
    let [a, b] = topology.edge_vertices(edge).map(|v| v.index() as u32);
    jittered(&turn_edge(&wall, a, b), 0.05, 7)
}

#[test]
fn gradient_of_planarity() {
    let weights = Weights {
        planarity: 3.0,
        ..NOTHING
    };
    gradient_is_right(weights, NO_BARRIER, Shape::Wave, &rough(Shape::Wave));
}

#[test]
fn gradient_of_closeness() {
    for target in [Shape::Wave, Shape::MonkeySaddle, Shape::Square] {
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
        gradient_is_right(weights, NO_BARRIER, target, &rough(target));
    }
}

#[test]
fn gradient_of_concavity() {
    let mesh = jittered(&planar_saddle(7, 4, 0.05), 0.05, 3);
    with_energy(
        &mesh,
        Shape::Wave,
        NOTHING,
        NO_BARRIER,
        |energy, x, hessian| {
            energy.concavity = Some(ConcavityTerm {
                weight: 2.0,
                faces: vec![true; energy.panels().n_faces()],
                edge: mesh.mean_edge(),
            });
            gradient_agrees(energy, x, hessian, mesh.mean_edge());
        },
    );
}

#[test]
fn gradient_of_areas() {
    let mesh = rough(Shape::MonkeySaddle);
    with_energy(
        &mesh,
        Shape::MonkeySaddle,
        NOTHING,
        NO_BARRIER,
        |energy, x, hessian| {
            let panels = energy.panels();
            // Some lack, some have too much, some may have any area, some any that is large enough.
            let size = mesh.mean_edge().powi(2);
            let wish = |f: usize| AreaWish {
                area: [4.0, 1.0, 4.0, 4.0, 1.0][f % 5] * size,
                weight: [2.0, 2.0, 0.0, 2.0, 2.0][f % 5],
            };
            energy.areas = (0..panels.n_faces()).map(wish).collect();
            gradient_agrees(energy, x, hessian, mesh.mean_edge());
        },
    );
}

#[test]
fn gradient_of_fairness_and_anchor() {
    let weights = Weights {
        fairness: 0.7,
        ..NOTHING
    };
    let mesh = jittered(&brick_wall(Shape::Wave, 13, 8), 0.05, 7);
    gradient_is_right(weights, NO_BARRIER, Shape::Wave, &mesh);
    // The anchor has no force at the start, so it is tested together.
    let weights = Weights {
        anchor: 0.5,
        corner: 0.2,
        ..weights
    };
    gradient_is_right(weights, NO_BARRIER, Shape::Wave, &mesh);
}

#[test]
fn fairness_with_frozen_middles_has_the_same_gradient_and_an_exact_hessian() {
    let weights = Weights {
        fairness: 0.7,
        ..NOTHING
    };
    let mesh = jittered(&brick_wall(Shape::Wave, 13, 8), 0.05, 7);
    let test = |energy: &mut PanelEnergy<'_>, x: &[f64], hessian: &mut SymmetricMatrix| {
        let free = gradient(energy, x, hessian);
        let value = energy.energy(x);
        energy.freeze(x);
        let frozen = gradient(energy, x, hessian);
        let difference: Vec<f64> = free.iter().zip(&frozen).map(|(a, b)| a - b).collect();
        assert!(largest(&difference) < 1e-12 * largest(&free));
        assert!((energy.energy(x) - value).abs() < 1e-12 * value);
        hessian_agrees(energy, x, hessian, mesh.mean_edge());
    };
    with_energy(&mesh, Shape::Wave, weights, NO_BARRIER, test);
}

/// One hexagon moved along pays nothing, whichever its shape.
#[test]
fn panels_that_are_alike_pay_nothing_for_fairness() {
    let weights = Weights {
        fairness: 1.0,
        ..NOTHING
    };
    let wall = brick_wall(Shape::Square, 13, 8);
    let energy_of = |mesh: &HexMesh| {
        let mut energy_there = 0.0;
        let test = |energy: &mut PanelEnergy<'_>, x: &[f64], _: &mut SymmetricMatrix| {
            energy_there = energy.energy(x);
        };
        with_energy(mesh, Shape::Square, weights, NO_BARRIER, test);
        energy_there
    };
    assert!(energy_of(&wall) < 1e-20);
    let sheared = wall.positions.map(|p| Vec3::new(p.x + 0.4 * p.y, p.y, p.z));
    assert!(energy_of(&wall.with_positions(sheared)) < 1e-20);
    assert!(energy_of(&jittered(&wall, 0.05, 7)) > 1e-6);
}

#[test]
fn gradient_of_the_barrier_in_planes_that_turn() {
    let mesh = rough(Shape::MonkeySaddle);
    let barrier = Barrier {
        weight: 1e-3,
        reach: 1.2 * mesh.mean_edge(),
    };
    gradient_is_right(NOTHING, barrier, Shape::MonkeySaddle, &mesh);
}

#[test]
fn hessian_of_quadratic_terms_is_exact() {
    let weights = Weights {
        anchor: 0.5,
        corner: 0.2,
        ..NOTHING
    };
    hessian_is_right(weights, Shape::Wave, &rough(Shape::Wave));
}

#[test]
fn hessian_of_planarity_is_exact_where_faces_are_planar() {
    let weights = Weights {
        planarity: 2.0,
        ..NOTHING
    };
    hessian_is_right(weights, Shape::Wave, &planar_paraboloid(7, 3));
}

#[test]
fn hessian_of_closeness_is_exact_at_a_plane_and_beyond_its_rim() {
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
    // Reaches beyond the square on two sides.
    let mesh = brick_wall(Shape::Square, 7, 4);
    let wide = Vec3::new(1.3, 0.9, 1.0);
    let large = mesh.with_positions(mesh.positions.map(|p| p.component_mul(&wide)));
    let shifted = jittered(&large, 0.01, 3);
    assert!(shifted.positions.iter().any(|p| p.x > 1.0));
    hessian_is_right(weights, Shape::Square, &shifted);
}

#[test]
fn normal_matrix_is_the_product_of_the_jacobian() {
    let mesh = rough(Shape::Wave);
    let panels = Panels::new(mesh.topology());
    let x = unknowns(&mesh);
    let (target, guard) = (Shape::Wave, Guard::new(mesh.topology(), None, 0.1));
    let reference = Reference::Surface(&target);
    let corner = vec![false; panels.n_vertices()];
    let setting = Setting {
        panels: &panels,
        reference: &reference,
        guard: &guard,
        rim: &[],
        corner: &corner,
        holds: &Holds::default(),
        areas: &any(panels.n_faces()),
        limits: &FaceLimits::none(panels.n_faces()),
        mean_edge: panels.mean_edge(&x),
    };
    let count = PlanarityConstraints::count(&panels);
    let assembly = Assembly::new(count, &PlanarityConstraints::elements(&panels));
    let mut constraints = PlanarityConstraints::new(&setting, &assembly, &x, Some(0.0));
    let mut normal = SymmetricMatrix::zeros(assembly.pattern().clone());
    let mut values = vec![0.0; count];
    constraints.linearise(&x, &mut values, &mut normal);
    let rows: Vec<Vec<f64>> = (0..count)
        .map(|i| {
            let (mut y, mut row) = (vec![0.0; count], vec![0.0; x.len()]);
            y[i] = 1.0;
            constraints.transposed(&y, &mut row);
            row
        })
        .collect();
    for i in 0..count {
        let (mut unit, mut column) = (vec![0.0; count], vec![0.0; count]);
        unit[i] = 1.0;
        normal.mul(&unit, &mut column);
        for j in 0..count {
            let product: f64 = rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum();
            assert!((product - column[j]).abs() < 1e-14, "{i} {j}");
        }
    }
    the_jacobian_agrees(&panels, &assembly, &x, &rows);
    // The sum of squared constraints is the sum of squared heights.
    let shape = crate::optimise::panels::FaceShapes::at(&panels, &x);
    let heights: f64 = shape.corners.iter().map(|c| c.height * c.height).sum();
    let squares: f64 = values.iter().map(|c| c * c).sum();
    assert!((heights - squares).abs() < 1e-12 * heights);
}

/// `J d`, `W J^T y` and `J W J^T` of a [`Jacobian`] against its rows, with metrics that differ from
/// vertex to vertex.
fn the_jacobian_agrees(panels: &Panels, assembly: &Assembly, x: &[f64], rows: &[Vec<f64>]) {
    let n = panels.n_vertices();
    let mut jacobian = Jacobian::new(panels, assembly);
    let mut values = vec![0.0; rows.len()];
    jacobian.linearise(
        &crate::optimise::panels::FaceShapes::at(panels, x),
        &mut values,
    );
    let metric = |v: usize| {
        let axis = Vec3::new((v as f64).sin(), (v as f64).cos(), 0.3);
        Matrix3::from_diagonal_element(0.2) + axis * axis.transpose()
    };
    jacobian.metric = (0..n).map(metric).collect();
    let mut normal = SymmetricMatrix::zeros(assembly.pattern().clone());
    jacobian.normal_matrix(&mut normal);
    for i in (0..rows.len()).step_by(17) {
        let mut unit = vec![0.0; rows.len()];
        unit[i] = 1.0;
        let (mut spread, mut column) = (vec![0.0; x.len()], vec![0.0; rows.len()]);
        jacobian.spread(&unit, &mut spread);
        for (v, moved) in spread.chunks_exact(3).enumerate() {
            let row = Vec3::from_column_slice(&rows[i][3 * v..3 * v + 3]);
            let expected = metric(v) * row;
            assert!((Vec3::from_column_slice(moved) - expected).norm() < 1e-14);
        }
        jacobian.product(&spread, &mut values);
        normal.mul(&unit, &mut column);
        for (j, row) in rows.iter().enumerate() {
            let along: f64 = row.iter().zip(&spread).map(|(a, b)| a * b).sum();
            assert!((along - values[j]).abs() < 1e-13, "{i} {j}");
            assert!((along - column[j]).abs() < 1e-13, "{i} {j}");
        }
    }
}

/// Each limit by itself, so tight that most panels are beyond it or near.
#[test]
fn gradient_of_limits() {
    let mesh = rough(Shape::Wave);
    let (edge, area) = (mesh.mean_edge(), mesh.mean_edge().powi(2));
    let faces = mesh.topology().n_faces();
    let none = || FaceLimits::none(faces);
    let panels = |panels: PanelLimits| FaceLimits {
        panels: vec![panels; faces],
        ..none()
    };
    let any = PanelLimits::default();
    let limits = [
        panels(PanelLimits {
            min_edge: Some(0.9 * edge),
            ..any
        }),
        panels(PanelLimits {
            max_edge: Some(1.1 * edge),
            ..any
        }),
        panels(PanelLimits {
            min_angle: Some(95.0),
            ..any
        }),
        panels(PanelLimits {
            max_area: Some(2.0 * area),
            ..any
        }),
        panels(PanelLimits {
            max_panel: Some([2.0 * edge, 1.5 * edge]),
            ..any
        }),
        FaceLimits {
            clearance: vec![edge; faces],
            ..none()
        },
        FaceLimits {
            area: vec![3.0 * area; faces],
            ..none()
        },
    ];
    for limits in &limits {
        gradient_of_limit(&mesh, Shape::Wave, limits);
    }
    // The plane of a face turns, which moments of its area feel in second order alone where it is
    // planar.
    let flat = rough(Shape::Square);
    let flat = flat.with_positions(flat.positions.map(|p| Vec3::new(p.x, p.y, 0.0)));
    let long = panels(PanelLimits {
        max_aspect: Some(1.3),
        ..any
    });
    gradient_of_limit(&flat, Shape::Square, &long);
    let wish = ShapeWish {
        aspect: 1.2,
        weight: 0.3,
    };
    let wished = FaceLimits {
        shape: vec![wish; faces],
        ..none()
    };
    gradient_of_limit(&flat, Shape::Square, &wished);
    // Points above the inside of a panel and beyond one of its edges.
    let beside = |f: FaceId, share: f64| {
        let corner = flat.corners(f).next().unwrap();
        flat.centre(f) + (corner - flat.centre(f)) * share + Vec3::z() * (0.2 * edge)
    };
    let points = |f: FaceId| vec![beside(f, 0.3), beside(f, 1.2)];
    let covering = FaceLimits {
        distance: 0.3 * edge,
        cover: flat.topology().faces().map(points).collect(),
        ..none()
    };
    gradient_of_limit(&flat, Shape::Square, &covering);
}

fn gradient_of_limit(mesh: &HexMesh, target: Shape, limits: &FaceLimits) {
    let weights = Weights {
        limits: 3.0,
        ..NOTHING
    };
    let what = (weights, limits);
    with_limits(mesh, target, what, NO_BARRIER, |energy, x, hessian| {
        gradient_agrees(energy, x, hessian, mesh.mean_edge());
    });
}

#[test]
fn gradient_of_the_largest_distance() {
    for share in [0.05, 0.2] {
        let mesh = rough(Shape::Wave);
        let limit = DistanceLimit {
            elastic: Elastic { weight: 2.0 },
            most: share * mesh.mean_edge(),
        };
        let closeness = ClosenessWeights {
            limit,
            ..NOTHING.closeness
        };
        let weights = Weights {
            closeness,
            ..NOTHING
        };
        gradient_is_right(weights, NO_BARRIER, Shape::Wave, &mesh);
    }
}

#[test]
fn lengths_of_edges_have_their_derivatives() {
    let mesh = rough(Shape::Wave);
    let (topology, edge) = (mesh.topology(), mesh.mean_edge());
    let lengths = |share: f64| {
        let length = |e: EdgeId| mesh.edge_length(e) + share * edge * (e.index() as f64).sin();
        PerEdge::from_fn(topology.n_edges(), length)
    };
    let term = |share| Some(EdgeLengths::new(topology, &lengths(share), 3.0));
    with_energy(
        &mesh,
        Shape::Wave,
        NOTHING,
        NO_BARRIER,
        |energy, x, hessian| {
            energy.lengths = term(0.3);
            gradient_agrees(energy, x, hessian, edge);
            // The Gauss-Newton part is all of the Hessian where edges are as long as they are to
            // be.
            energy.lengths = term(0.0);
            hessian_agrees(energy, x, hessian, edge);
        },
    );
}
