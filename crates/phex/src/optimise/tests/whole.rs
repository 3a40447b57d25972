//! Whole runs on analytic surfaces.

use super::fixtures::{
    Shape, brick_wall, jittered, layout, mesh, noise, planar_paraboloid, turn_edge,
};
use crate::layout::{Layout, PanelWish, VertexKind};
use crate::optimise::panels::{FaceShapes as Faces, Panels, unknowns};
use crate::optimise::simple::is_simple;
use crate::optimise::{
    Fault, OptimiseError, OptimiseOptions, Optimised, PathKind, Solver, StartKind, Target,
    TargetPoint, optimise, planarize,
};
use crate::progress::{Event, Progress, Silent};
use nalgebra::Rotation3;
use phex_mesh::measure::aspect as aspect_of;
use phex_mesh::{FlatFace, HexMesh, PerFace, Vec3, VertexId};
use phex_numeric::Status;
use std::sync::atomic::{AtomicUsize, Ordering};

fn run(layout: &Layout, target: &dyn Target) -> Optimised {
    optimise(layout, target, &OptimiseOptions::default(), &Silent).unwrap()
}

pub(super) fn all_simple(mesh: &HexMesh) -> bool {
    let panels = Panels::new(mesh.topology());
    let faces = Faces::at(&panels, &unknowns(mesh));
    (0..panels.n_faces()).all(|f| is_simple(faces.face(&panels, f)))
}

pub(super) fn assert_sound(result: &Optimised, planarity: f64) {
    assert_eq!(result.offenders, []);
    assert_eq!(result.outcome.status, Status::Converged);
    assert!(
        result.quality.planarity <= planarity,
        "{:?}",
        result.quality
    );
    assert!(all_simple(&result.mesh));
}

#[test]
fn brick_walls_become_planar_and_stay_simple() {
    for (shape, columns, rows) in [
        (Shape::Torus(1.0), 40, 14),
        (Shape::Wave, 25, 12),
        (Shape::MonkeySaddle, 25, 12),
    ] {
        let result = run(&layout(brick_wall(shape, columns, rows), &shape), &shape);
        assert_sound(&result, 1e-13);
        assert!(result.quality.deviation_max < 0.02, "{:?}", result.quality);
        assert!(result.quality.clearance > 0.15, "{:?}", result.quality);
    }
}

/// Even areas make bricks where rows are narrow longer, and a wished shape bounds that.
#[test]
fn panels_are_no_longer_than_wished_if_areas_can_give_way() {
    let shape = Shape::Torus(1.0);
    let run = |aspect: f64| {
        let mut layout = layout(brick_wall(shape, 24, 14), &shape);
        let area = layout.mesh.mean_edge().powi(2);
        let wish = PanelWish {
            area,
            share: 1.0,
            aspect,
        };
        layout.face_wish = PerFace::filled(layout.mesh.topology().n_faces(), wish);
        let result = run(&layout, &shape);
        assert_sound(&result, 1e-13);
        let faces = FlatFace::all(&result.mesh);
        let aspects = faces.iter().map(|face| aspect_of(&face.polygon));
        aspects.fold(0.0, f64::max)
    };
    let (any, wished) = (run(f64::INFINITY), run(2.5));
    assert!(any > 3.3 && wished < 0.9 * any, "{any} {wished}");
}

/// Rows of bricks along lines of curvature: one factorisation takes the circumcentres to a
/// stationary point.
#[test]
fn a_conjugate_layout_takes_the_fast_path() {
    let shape = Shape::Torus(1.0);
    let wall = brick_wall(shape, 80, 28);
    let on_layout = run(&layout(wall.clone(), &shape), &shape);
    let options = OptimiseOptions::default();
    let on_itself = planarize(&wall, None, &options, &Silent).unwrap();
    let on_surface = planarize(&wall, Some(&shape), &options, &Silent).unwrap();
    assert_sound(&on_layout, 1e-13);
    for result in [on_itself, on_surface] {
        assert_eq!(result.run.path, PathKind::Fast);
        assert!(result.outcome.factorisations <= 2, "{:?}", result.outcome);
        let last = result.outcome.history.last().unwrap();
        assert!(last.step < 1e-8, "{last:?}");
        assert_sound(&result, 1e-13);
        assert!(result.quality.clearance > 0.5, "{:?}", result.quality);
    }
}

/// Bricks where the curvature across rows changes sign are no good start: the feasible path is
/// taken, and says so.
#[test]
fn a_layout_that_is_not_conjugate_takes_the_feasible_path() {
    let wall = brick_wall(Shape::Wave, 41, 20);
    let result = planarize(&wall, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_eq!(result.run.path, PathKind::Feasible);
    assert_sound(&result, 1e-13);
    let again = planarize(&result.mesh, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_eq!(again.run.path, PathKind::Projection);
    assert_eq!(again.mesh.positions, result.mesh.positions);
}

#[test]
fn pentagons_and_heptagons_on_an_ellipsoid() {
    let shape = Shape::Ellipsoid(Vec3::new(1.0, 0.8, 0.6));
    let ball = dual_icosphere(2, &shape);
    let result = run(&layout(ball.clone(), &shape), &shape);
    assert_sound(&result, 1e-13);
    let topology = ball.topology();
    let hexagons = |f: phex_mesh::FaceId| topology.valence(f) == 6;
    let between = topology.edges().find(|&e| {
        let h = topology.edge_half_edge(e);
        let ends = [h, topology.twin(h).unwrap()];
        let around = ends
            .iter()
            .flat_map(|&h| topology.outgoing(topology.origin(h)));
        around.map(|h| topology.face(h)).all(hexagons)
    });
    let [a, b] = topology
        .edge_vertices(between.unwrap())
        .map(|v| v.index() as u32);
    let turned = turn_edge(&ball, a, b);
    let valences: Vec<usize> = turned
        .topology()
        .faces()
        .map(|f| turned.topology().valence(f))
        .collect();
    assert_eq!(valences.iter().filter(|&&k| k == 7).count(), 2);
    assert_sound(&run(&layout(turned, &shape), &shape), 1e-13);
}

/// Dual of an icosahedron subdivided `levels` times: pentagons and hexagons.
fn dual_icosphere(levels: usize, target: &dyn Target) -> HexMesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = [
        [-1.0, g, 0.0],
        [1.0, g, 0.0],
        [-1.0, -g, 0.0],
        [1.0, -g, 0.0],
        [0.0, -1.0, g],
        [0.0, 1.0, g],
        [0.0, -1.0, -g],
        [0.0, 1.0, -g],
        [g, 0.0, -1.0],
        [g, 0.0, 1.0],
        [-g, 0.0, -1.0],
        [-g, 0.0, 1.0],
    ]
    .map(|p| Vec3::from(p).normalize())
    .to_vec();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    points.push((points[p as usize] + points[q as usize]).normalize());
                    points.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let sphere = HexMesh::new(points, &triangles).unwrap();
    let topology = sphere.topology();
    let cells: Vec<Vec<u32>> = topology
        .vertices()
        .map(|v| topology.faces_at(v).map(|f| f.index() as u32).collect())
        .collect();
    let centres: Vec<Vec3> = topology.faces().map(|f| sphere.centre(f)).collect();
    let feet: Vec<Vec3> = target
        .closest_points(&centres, &[])
        .iter()
        .map(|q| q.position)
        .collect();
    mesh(&feet, &cells)
}

#[test]
fn a_planar_mesh_is_a_fixed_point() {
    let planar = planar_paraboloid(15, 8);
    let result = planarize(&planar, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_sound(&result, 1e-13);
    assert_eq!(result.start, StartKind::AsGiven);
    let moved = planar.positions.iter().zip(result.mesh.positions.iter());
    assert!(moved.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max) < 1e-12);
}

#[test]
fn a_nearly_planar_mesh_moves_little() {
    let planar = planar_paraboloid(15, 8);
    let near = jittered(&planar, 1e-4, 5);
    let result = planarize(&near, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_sound(&result, 1e-13);
    let moved = near.positions.iter().zip(result.mesh.positions.iter());
    let largest = moved.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    assert!(
        largest > 0.0 && largest < 1e-3 * near.mean_edge(),
        "{largest:e}"
    );
}

#[test]
fn far_from_planar_without_a_target() {
    let rough = jittered(&planar_paraboloid(15, 8), 0.08, 11);
    let result = planarize(&rough, None, &OptimiseOptions::default(), &Silent).unwrap();
    assert_sound(&result, 1e-13);
}

/// A target that is another one, turned, scaled and shifted.
struct Moved<'a> {
    target: &'a dyn Target,
    rotation: Rotation3<f64>,
    scale: f64,
    shift: Vec3,
}

impl Moved<'_> {
    fn place(&self, p: &Vec3) -> Vec3 {
        self.rotation * (p * self.scale) + self.shift
    }
}

impl Target for Moved<'_> {
    fn closest_points(&self, points: &[Vec3], _near: &[TargetPoint]) -> Vec<TargetPoint> {
        let back = |p: &Vec3| self.rotation.inverse() * (p - self.shift) / self.scale;
        let inner: Vec<Vec3> = points.iter().map(back).collect();
        let forth = |q: TargetPoint| TargetPoint {
            position: self.place(&q.position),
            normal: self.rotation * q.normal,
        };
        self.target
            .closest_points(&inner, &[])
            .into_iter()
            .map(forth)
            .collect()
    }

    fn closest_on_boundary(&self, _points: &[Vec3]) -> Option<Vec<phex_mesh::BoundaryPoint>> {
        None
    }
}

#[test]
fn rigid_motion_and_scale_move_the_result_along() {
    let shape = Shape::Wave;
    let plain = brick_wall(shape, 15, 8);
    let expected = run(&layout(plain.clone(), &shape), &shape);
    let moved = Moved {
        target: &shape,
        rotation: Rotation3::from_euler_angles(0.3, -1.1, 2.0),
        scale: 250.0,
        shift: Vec3::new(10.0, -30.0, 20.0),
    };
    let start = plain.with_positions(plain.positions.map(|p| moved.place(p)));
    let result = run(&layout(start, &moved), &moved);
    assert_sound(&result, 1e-12);
    let error = |(p, q): (&Vec3, &Vec3)| (moved.place(p) - q).norm() / result.quality.mean_edge;
    let pairs = expected
        .mesh
        .positions
        .iter()
        .zip(result.mesh.positions.iter());
    let largest = pairs.map(error).fold(0.0, f64::max);
    assert!(largest < 1e-6, "{largest:e}");
}

#[test]
fn random_simple_starts_end_simple() {
    let options = OptimiseOptions {
        smoothing: [0, 40],
        ..OptimiseOptions::default()
    };
    let mut tried = 0;
    for seed in 0..240 {
        let amount = 0.05 + 0.2 * noise(seed)().abs();
        let shape = [Shape::Torus(1.0), Shape::Wave, Shape::MonkeySaddle][seed as usize % 3];
        let wall = match shape {
            Shape::Torus(_) => brick_wall(shape, 24, 8),
            _ => brick_wall(shape, 9, 5),
        };
        let start = jittered(&wall, amount, seed);
        if !all_simple(&start) {
            continue;
        }
        tried += 1;
        let result = optimise(&layout(start, &shape), &shape, &options, &Silent).unwrap();
        assert!(all_simple(&result.mesh), "seed {seed}");
        assert!(
            result.quality.planarity < 1e-13,
            "seed {seed}: {:?}",
            result.quality
        );
    }
    assert!(tried >= 150, "only {tried} simple starts");
}

/// Cancels after a number of iterations.
pub(super) struct CancelAfter {
    limit: usize,
    seen: AtomicUsize,
}

impl CancelAfter {
    pub fn new(limit: usize) -> Self {
        let seen = AtomicUsize::new(0);
        Self { limit, seen }
    }
}

impl Progress for CancelAfter {
    fn report(&self, event: &Event) {
        if matches!(event, Event::Iteration { .. }) {
            self.seen.fetch_add(1, Ordering::Relaxed);
        }
    }
    fn is_cancelled(&self) -> bool {
        self.seen.load(Ordering::Relaxed) >= self.limit
    }
}

#[test]
fn cancelled_at_any_iteration_gives_a_simple_mesh() {
    let shape = Shape::MonkeySaddle;
    let start = layout(brick_wall(shape, 11, 6), &shape);
    let mut finished = false;
    for limit in 0..200 {
        let progress = CancelAfter::new(limit);
        let result = optimise(&start, &shape, &OptimiseOptions::default(), &progress).unwrap();
        assert!(all_simple(&result.mesh), "after {limit}");
        if result.outcome.status != Status::Cancelled {
            finished = true;
            break;
        }
        assert!(result.outcome.iterations <= limit.max(1));
    }
    assert!(finished);
}

#[test]
fn the_rim_is_kept_and_corners_stay() {
    let shape = Shape::Square;
    let mut start = layout(brick_wall(shape, 13, 8), &shape);
    // Fill the square: the wall is 0.9 wide, its outline goes to the rim.
    let corners: Vec<VertexId> = start
        .mesh
        .topology()
        .vertices()
        .filter(|&v| {
            let p = start.mesh.positions[v];
            p.x.abs() > 0.89 && p.y.abs() > 0.89
        })
        .collect();
    for &v in &corners {
        let p = &mut start.mesh.positions[v];
        *p = Vec3::new(p.x.signum(), p.y.signum(), 0.0);
        start.vertex_kind[v] = VertexKind::BoundaryCorner;
    }
    assert!(corners.len() >= 2);
    let result = run(&start, &shape);
    assert_sound(&result, 1e-13);
    for &v in &corners {
        let moved = (result.mesh.positions[v] - start.mesh.positions[v]).norm();
        assert!(moved < 0.1 * result.quality.mean_edge, "{moved:e}");
    }
    let topology = result.mesh.topology();
    for v in topology.boundary_vertices() {
        let p = result.mesh.positions[v];
        let rim = p.x.abs().max(p.y.abs());
        assert!(
            (rim - 1.0).abs() < 0.25 * result.quality.mean_edge,
            "{v} at {p}"
        );
    }
}

#[test]
fn the_same_bytes_with_one_thread_and_with_two() {
    let shape = Shape::Torus(1.0);
    let start = layout(jittered(&brick_wall(shape, 60, 20), 0.03, 1), &shape);
    assert!(start.mesh.topology().n_faces() > 512);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| run(&start, &shape))
    };
    let (one, two) = (with_threads(1), with_threads(2));
    assert_eq!(one.mesh, two.mesh);
    assert_eq!(one.outcome.history.len(), two.outcome.history.len());
}

#[test]
fn a_panel_wound_against_the_surface_is_named() {
    let shape = Shape::Wave;
    let mut start = layout(brick_wall(shape, 11, 6), &shape);
    let face = phex_mesh::FaceId::new(5);
    start.face_normal[face] = -start.face_normal[face];
    let options = OptimiseOptions {
        ..OptimiseOptions::default()
    };
    let result = optimise(&start, &shape, &options, &Silent).unwrap();
    assert_eq!(result.offenders.len(), 1, "{:?}", result.offenders);
    assert_eq!(
        (result.offenders[0].face, result.offenders[0].fault),
        (face, Fault::Flipped)
    );
    assert!(!result.is_sound());
    assert_eq!(result.run.start_faults, 1);
}

#[test]
fn a_crossed_panel_does_not_hang_and_is_named_or_cured() {
    let shape = Shape::Wave;
    let wall = brick_wall(shape, 11, 6);
    let inner = wall
        .topology()
        .faces()
        .find(|&f| !wall.topology().is_boundary_face(f))
        .unwrap();
    let corners = wall.topology().face_vertices(inner);
    let mut crossed = wall.positions.clone();
    let (a, b) = (corners[0], corners[3]);
    (crossed[a], crossed[b]) = (wall.positions[b], wall.positions[a]);
    let options = OptimiseOptions {
        smoothing: [0, 0],
        ..OptimiseOptions::default()
    };
    let result = optimise(
        &layout(wall.with_positions(crossed), &shape),
        &shape,
        &options,
        &Silent,
    )
    .unwrap();
    assert!(result.run.start_faults > 0);
    let named = result.offenders.iter().any(|o| o.fault == Fault::NotSimple);
    assert_eq!(all_simple(&result.mesh), !named);
}

#[test]
fn unusable_input_is_refused() {
    let shape = Shape::Wave;
    let good = layout(brick_wall(shape, 9, 4), &shape);
    let refuse = |layout: &Layout, options: &OptimiseOptions| {
        optimise(layout, &shape, options, &Silent).unwrap_err()
    };
    let options = OptimiseOptions::default();
    let mut bad = good.clone();
    bad.mesh.positions[VertexId::new(3)].x = f64::NAN;
    let error = refuse(&bad, &options);
    assert_eq!(
        error,
        OptimiseError::NotFinite {
            vertex: VertexId::new(3)
        }
    );
    let mut bad = good.clone();
    bad.face_normal[phex_mesh::FaceId::new(2)] = Vec3::zeros();
    assert!(matches!(
        refuse(&bad, &options),
        OptimiseError::BadNormal { .. }
    ));
    let weak = OptimiseOptions {
        barrier: 0.0,
        ..options
    };
    let error = refuse(&good, &weak);
    assert!(
        matches!(&error, OptimiseError::BadOption(e) if (&*e.option, e.value) == ("barrier", 0.0)),
        "{error}"
    );
}

/// The paper's formulation: as planar, where the start is good; where panels would cross, nothing
/// stops them, and they are named.
#[test]
fn tetrahedra_flatten_panels_and_say_which_ones_cross() {
    let options = OptimiseOptions {
        solver: Solver::Tetrahedra,
        ..OptimiseOptions::default()
    };
    for shape in [Shape::Torus(1.0), Shape::Wave] {
        let wall = match shape {
            Shape::Torus(_) => brick_wall(shape, 40, 14),
            _ => brick_wall(shape, 25, 12),
        };
        let start = layout(wall, &shape);
        let result = optimise(&start, &shape, &options, &Silent).unwrap();
        let ours = run(&start, &shape);
        assert!(result.quality.planarity < 1e-6, "{:?}", result.quality);
        assert!(ours.is_sound() && ours.quality.clearance > result.quality.clearance);
        let named = result.offenders.iter().any(|o| o.fault == Fault::NotSimple);
        assert_eq!(all_simple(&result.mesh), !named);
        println!(
            "{shape:?} {:?} {:?} {}",
            result.quality,
            result.outcome.status,
            result.offenders.len()
        );
    }
}

/// Along the sharp rim of a flat ellipsoid panels of both sides meet; without what folds pay some
/// of them end over the rim.
#[test]
fn panels_do_not_fold_at_a_sharp_rim() {
    for height in [0.03, 0.04, 0.05] {
        let shape = Shape::Ellipsoid(Vec3::new(1.0, 0.9, height));
        let ball = dual_icosphere(2, &shape);
        let mesh = run(&layout(ball, &shape), &shape).mesh;
        let result = planarize(&mesh, Some(&shape), &OptimiseOptions::default(), &Silent).unwrap();
        assert_sound(&result, 1e-13);
        assert!(result.quality.clearance > 0.06, "{:?}", result.quality);
    }
}
