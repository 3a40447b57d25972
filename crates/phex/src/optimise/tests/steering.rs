//! Held vertices: exactly where they are to be, and the mesh planar all the same.

use super::fixtures::{Shape, brick_wall, jittered, planar_paraboloid};
use super::whole::{CancelAfter, all_simple, assert_sound};
use crate::optimise::{
    Anchor, GroundPlane, OptimiseError, OptimiseOptions, Optimised, Steering, SteeringError,
    led_elsewhere, refit, steer, wishes,
};
use crate::progress::{Event, Progress, Silent};
use phex_mesh::{FaceId, HexMesh, Vec3, VertexId};
use phex_numeric::Status;

fn steered(mesh: &HexMesh, shape: Shape, steering: &Steering) -> Optimised {
    steer(
        mesh,
        Some(&shape),
        steering,
        &OptimiseOptions::default(),
        &Silent,
    )
    .unwrap()
}

fn refused(mesh: &HexMesh, steering: &Steering) -> SteeringError {
    let error = steer(mesh, None, steering, &OptimiseOptions::default(), &Silent);
    match error.unwrap_err() {
        OptimiseError::Steering(error) => error,
        other => panic!("{other}"),
    }
}

fn rim(mesh: &HexMesh) -> Vec<VertexId> {
    let topology = mesh.topology();
    let rim = topology.vertices();
    rim.filter(|&v| topology.is_boundary_vertex(v)).collect()
}

#[test]
fn fixed_vertices_keep_every_bit() {
    let wall = brick_wall(Shape::Wave, 15, 8);
    let fixed_vertices = vec![3, 40, 41, 77, 100];
    let steering = Steering {
        fixed_vertices: fixed_vertices.clone(),
        ..Default::default()
    };
    let result = steered(&wall, Shape::Wave, &steering);
    assert_sound(&result, 1e-13);
    for v in fixed_vertices.into_iter().map(VertexId::new) {
        assert_eq!(result.mesh.positions[v], wall.positions[v], "{v}");
    }
    let moved = wall.positions.iter().zip(result.mesh.positions.iter());
    assert!(moved.filter(|(p, q)| p != q).count() > 100);
}

#[test]
fn fixed_points_are_taken_by_the_nearest_vertices() {
    let wall = brick_wall(Shape::Wave, 15, 8);
    let middle = wall.positions[VertexId::new(60)] + Vec3::new(0.02, 0.03, -0.04);
    let steering = Steering {
        fixed_points: vec![middle.into()],
        ..Default::default()
    };
    let result = steered(&wall, Shape::Wave, &steering);
    assert_sound(&result, 1e-13);
    assert_eq!(result.mesh.positions[VertexId::new(60)], middle);
}

#[test]
fn vertices_stay_in_planes_straight_and_oblique() {
    let wall = brick_wall(Shape::MonkeySaddle, 15, 8);
    let lowest = rim(&wall).into_iter().map(|v| wall.positions[v].y);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    for tilt in [0.0, 0.1] {
        let normal = Vec3::new(0.0, 1.0, tilt);
        let ground = GroundPlane {
            point: Some([0.0, lowest, 0.0]),
            normal: normal.into(),
            reach: Some(0.3),
        };
        let steering = Steering {
            grounds: vec![ground],
            ..Default::default()
        };
        let height = |p: &Vec3| (p - Vec3::y() * lowest).dot(&normal.normalize());
        let reach = 0.3 * wall.mean_edge();
        let near: Vec<VertexId> = (rim(&wall).into_iter())
            .filter(|&v| height(&wall.positions[v]).abs() <= reach)
            .collect();
        assert!(near.len() > 5);
        let result = steered(&wall, Shape::MonkeySaddle, &steering);
        assert_sound(&result, 1e-13);
        for v in near {
            let above = height(&result.mesh.positions[v]);
            let bound = if tilt == 0.0 { 0.0 } else { 1e-15 };
            assert!(above.abs() <= bound, "{v}: {above:e}");
        }
    }
}

/// The ground of a bowl is at its rim, not below it.
#[test]
fn the_ground_without_a_point_is_at_the_lowest_vertex_of_the_boundary() {
    let mut bowl = brick_wall(Shape::Square, 15, 8);
    for p in bowl.positions.iter_mut() {
        p.z = p.x.powi(2).max(p.y.powi(2));
    }
    let steering = Steering {
        grounds: vec![GroundPlane::default()],
        ..Default::default()
    };
    let held = wishes::resolve(&steering, &bowl, None).unwrap().held;
    assert!(!held.is_empty());
    assert!(
        led_elsewhere(&steering, &bowl).is_empty(),
        "the boundary is judged"
    );
}

#[test]
fn the_ground_takes_nothing_from_farther_than_panels_may_be_from_the_surface() {
    let wall = brick_wall(Shape::Wave, 15, 8);
    let edge = wall.mean_edge();
    let level = -2.0 - 0.2 * edge;
    let steering = Steering {
        grounds: vec![GroundPlane {
            point: Some([0.0, level, 0.0]),
            normal: [0.0, 1.0, 0.0],
            reach: None,
        }],
        ..Default::default()
    };
    for (most, told) in [(0.3, false), (0.1, true)] {
        let options = OptimiseOptions {
            max_deviation: Some(most * edge / wall.diagonal()),
            ..OptimiseOptions::default()
        };
        let notes = Notes::default();
        let made = steer(&wall, Some(&Shape::Wave), &steering, &options, &notes).unwrap();
        let stands = |v: &VertexId| made.mesh.positions[*v].y == level;
        assert_eq!(rim(&wall).iter().any(stands), !told, "{most}");
        let notes = notes.0.into_inner().unwrap();
        let tells = notes.iter().any(|n| n.contains("`--ground-reach 0.2"));
        assert_eq!(tells, told, "{notes:?}");
    }
}

#[test]
fn the_rim_slides_on_a_curve() {
    let wall = brick_wall(Shape::Wave, 15, 8);
    // Along the sides where every second row begins; two corners of each of its first panels slide.
    let height = |x: f64, y: f64| 0.3 * x.sin() + 0.2 * y.sin();
    let side = |x: f64| {
        let at = |k: i32| [x, 0.05 * f64::from(k), height(x, 0.05 * f64::from(k))];
        (-50..=50).map(at).collect::<Vec<_>>()
    };
    let steering = Steering {
        curves: vec![side(-2.0), side(2.0)],
        ..Default::default()
    };
    let on_side = |v: &VertexId| wall.positions[*v].x.abs() == 2.0;
    let near: Vec<VertexId> = rim(&wall).into_iter().filter(on_side).collect();
    assert!(near.len() > 8);
    let result = steered(&wall, Shape::Wave, &steering);
    assert_sound(&result, 1e-13);
    let mut slid = 0.0f64;
    for v in near {
        let p = result.mesh.positions[v];
        assert_eq!(p.x, wall.positions[v].x);
        let y0 = 0.05 * (p.y / 0.05).floor();
        let t = (p.y - y0) / 0.05;
        let z = (1.0 - t) * height(p.x, y0) + t * height(p.x, y0 + 0.05);
        assert!((p.z - z).abs() < 1e-14, "{v} at {p}");
        slid = slid.max((p.y - wall.positions[v].y).abs());
    }
    assert!(slid > 1e-3, "they do slide: {slid}");
}

#[test]
fn anchors_pull_the_more_the_heavier_they_are() {
    let wall = brick_wall(Shape::Wave, 15, 8);
    let point = wall.positions[VertexId::new(60)] + Vec3::new(0.05, 0.05, 0.0);
    let distance = |weight: f64| {
        let anchors = vec![Anchor {
            point: point.into(),
            weight,
        }];
        let steering = Steering {
            anchors,
            ..Default::default()
        };
        let result = steered(&wall, Shape::Wave, &steering);
        assert_sound(&result, 1e-13);
        (result.mesh.positions[VertexId::new(60)] - point).norm()
    };
    let far = [1e-3, 1.0, 100.0].map(distance);
    assert!(far[0] > 1.5 * far[1] && far[1] > far[2], "{far:?}");
}

/// A planar mesh is a fixed point of `planarize`; a warm start goes on from it.
#[test]
fn a_warm_start_moves_a_planar_mesh_to_another_surface() {
    let planar = planar_paraboloid(15, 8);
    let paraboloid_scaled = Shape::Wave;
    let options = OptimiseOptions::default();
    let steering = Steering::default();
    let result = refit(
        &planar,
        Some(&paraboloid_scaled),
        &steering,
        &options,
        &Silent,
    )
    .unwrap();
    let kept = steer(
        &planar,
        Some(&paraboloid_scaled),
        &steering,
        &options,
        &Silent,
    )
    .unwrap();
    assert!(result.quality.planarity < 1e-12);
    assert!(result.quality.deviation_max < 0.5 * kept.quality.deviation_max);
}

#[test]
fn without_a_surface_the_mesh_stays_where_it_is() {
    let rough = jittered(&planar_paraboloid(15, 8), 0.05, 3);
    let steering = Steering {
        fixed_vertices: vec![0, 30, 31],
        ..Default::default()
    };
    let options = OptimiseOptions::default();
    let result = steer(&rough, None, &steering, &options, &Silent).unwrap();
    assert_sound(&result, 1e-13);
    let moved = rough.positions.iter().zip(result.mesh.positions.iter());
    let most = moved.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max);
    assert!(
        most < 0.3 * rough.mean_edge(),
        "{}",
        most / rough.mean_edge()
    );
    assert!(result.quality.deviation_max < 0.1 * rough.mean_edge());
}

#[test]
fn what_cannot_be_held_is_named() {
    let wall = brick_wall(Shape::Wave, 11, 6);
    let with = |steering: Steering| refused(&wall, &steering);
    assert!(matches!(
        with(Steering {
            fixed_vertices: vec![0, 9999],
            ..Default::default()
        }),
        SteeringError::NoSuchVertex { vertex: 9999, .. }
    ));
    assert!(matches!(
        with(Steering {
            fixed_vertices: vec![4, 4],
            ..Default::default()
        }),
        SteeringError::Taken { index: 1, .. }
    ));
    assert!(matches!(
        with(Steering {
            fixed_points: vec![[0.0, f64::NAN, 0.0]],
            ..Default::default()
        }),
        SteeringError::Unusable {
            what: "fixed point",
            index: 0,
            ..
        }
    ));
    assert!(matches!(
        with(Steering {
            fixed_points: vec![[90.0, 0.0, 0.0]],
            ..Default::default()
        }),
        SteeringError::TooFar { index: 0, .. }
    ));
    assert!(matches!(
        with(Steering {
            curves: vec![vec![[0.0; 3], [0.1, 0.0, 90.0]]],
            ..Default::default()
        }),
        SteeringError::NothingNear { .. }
    ));
    let ground = GroundPlane {
        normal: [0.0; 3],
        ..Default::default()
    };
    assert!(matches!(
        with(Steering {
            grounds: vec![ground],
            ..Default::default()
        }),
        SteeringError::Unusable {
            what: "ground plane",
            ..
        }
    ));
    let anchor = Anchor {
        point: [0.0; 3],
        weight: 0.0,
    };
    assert!(matches!(
        with(Steering {
            anchors: vec![anchor],
            ..Default::default()
        }),
        SteeringError::Unusable { what: "anchor", .. }
    ));
}

#[test]
fn a_face_with_four_fixed_corners_off_a_plane_is_named() {
    let rough = jittered(&brick_wall(Shape::Wave, 11, 6), 0.05, 1);
    let face = FaceId::new(7);
    let corners = rough.topology().face_vertices(face);
    let fixed_vertices = corners[..4].iter().map(|v| v.index() as u32).collect();
    let steering = Steering {
        fixed_vertices,
        ..Default::default()
    };
    match refused(&rough, &steering) {
        SteeringError::OverConstrained {
            face: named,
            count: 4,
            distance,
        } => {
            assert_eq!(named, face);
            assert!(distance > 1e-3);
        }
        other => panic!("{other}"),
    }
    // Three of them always lie in one; far apart, they leave it about where it is.
    let three = [corners[0], corners[2], corners[4]];
    let fixed_vertices = three.iter().map(|v| v.index() as u32).collect();
    let steering = Steering {
        fixed_vertices,
        ..Default::default()
    };
    let wall = brick_wall(Shape::Wave, 11, 6);
    assert_sound(&steered(&wall, Shape::Wave, &steering), 1e-13);
}

/// Mirror images of the vertices of a mesh that is symmetric about `x = 0`.
fn mirrored(mesh: &HexMesh) -> Vec<VertexId> {
    let nearest = |p: &Vec3| {
        let image = Vec3::new(-p.x, p.y, p.z);
        let distance = |v: &VertexId| (mesh.positions[*v] - image).norm();
        let all = mesh.topology().vertices();
        all.min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .unwrap()
    };
    mesh.positions.iter().map(nearest).collect()
}

#[test]
fn a_symmetric_start_stays_symmetric() {
    // An odd number of columns: the wall is its own mirror image.
    let mut wall = brick_wall(Shape::MonkeySaddle, 13, 6);
    let symmetric = |p: &Vec3| Vec3::new(p.x, p.y, 0.3 * p.x * p.x - 0.2 * p.y * p.y);
    wall = wall.with_positions(wall.positions.map(symmetric));
    let image = mirrored(&wall);
    let asymmetry = |mesh: &HexMesh| {
        let apart = |(v, p): (VertexId, &Vec3)| {
            let q = mesh.positions[image[v.index()]];
            (Vec3::new(-p.x, p.y, p.z) - q).norm()
        };
        mesh.positions.enumerate().map(apart).fold(0.0, f64::max) / mesh.mean_edge()
    };
    assert!(asymmetry(&wall) < 1e-14);
    let options = OptimiseOptions::default();
    let result = refit(&wall, None, &Steering::default(), &options, &Silent).unwrap();
    assert_sound(&result, 1e-13);
    let moved = wall.positions.iter().zip(result.mesh.positions.iter());
    assert!(moved.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max) > 1e-3);
    let left = asymmetry(&result.mesh);
    assert!(left < 1e-9, "{left:e}");
}

/// Numbers of faces and vertices decide nothing but rounding.
#[test]
fn renumbering_renumbers_the_result() {
    let wall = brick_wall(Shape::Wave, 13, 6);
    let n = wall.positions.len();
    // 7 does not divide the number of vertices.
    let shuffled = |k: usize, n: usize| (7 * k + 3) % n;
    assert!(!n.is_multiple_of(7));
    let mut points = vec![Vec3::zeros(); n];
    for (v, p) in wall.positions.enumerate() {
        points[shuffled(v.index(), n)] = *p;
    }
    let mut faces: Vec<Vec<u32>> = wall.topology().face_lists();
    for face in &mut faces {
        face.iter_mut()
            .for_each(|v| *v = shuffled(*v as usize, n) as u32);
        face.rotate_left(2);
    }
    faces.reverse();
    let other = HexMesh::new(points, &faces).unwrap();
    let plain = steered(&wall, Shape::Wave, &Steering::default());
    let renumbered = steered(&other, Shape::Wave, &Steering::default());
    let apart = |(v, p): (VertexId, &Vec3)| {
        let q = renumbered.mesh.positions[VertexId::new(shuffled(v.index(), n) as u32)];
        (p - q).norm()
    };
    let most = plain
        .mesh
        .positions
        .enumerate()
        .map(apart)
        .fold(0.0, f64::max);
    assert!(most < 1e-7 * wall.mean_edge(), "{most:e}");
}

/// Cancelled wherever it is, a steered run has its vertices in place and its panels simple.
#[test]
fn cancelled_at_any_iteration_held_vertices_are_in_place() {
    let wall = brick_wall(Shape::Wave, 11, 6);
    let point = wall.positions[VertexId::new(20)] + Vec3::new(0.02, 0.01, 0.03);
    let ground = GroundPlane {
        point: Some([0.0, -2.0, 0.0]),
        normal: [0.0, 1.0, 0.0],
        reach: Some(0.1),
    };
    let steering = Steering {
        fixed_points: vec![point.into()],
        grounds: vec![ground],
        ..Default::default()
    };
    let low = |v: &VertexId| wall.positions[*v].y == -2.0;
    let low: Vec<VertexId> = rim(&wall).into_iter().filter(low).collect();
    for limit in 0..200 {
        let progress = CancelAfter::new(limit);
        let options = OptimiseOptions::default();
        let result = steer(&wall, Some(&Shape::Wave), &steering, &options, &progress).unwrap();
        assert!(all_simple(&result.mesh), "after {limit}");
        assert_eq!(result.mesh.positions[VertexId::new(20)], point);
        assert!(low.iter().all(|&v| result.mesh.positions[v].y == -2.0));
        if result.outcome.status != Status::Cancelled {
            return;
        }
    }
    panic!("never finished");
}

/// Notes of a run.
#[derive(Default)]
struct Notes(std::sync::Mutex<Vec<String>>);

impl Progress for Notes {
    fn report(&self, event: &Event) {
        if let Event::Note { message } = event {
            self.0.lock().unwrap().push(message.clone());
        }
    }
}

/// Three corners of a panel on a curve in a plane, the others off it: it can't be planar and is
/// named, and so are the corners that are let go for it.
#[test]
fn a_panel_that_its_holds_bend_is_named_and_let_go() {
    let wall = brick_wall(Shape::Wave, 15, 8);
    let at = |k: i32| {
        let x = 0.05 * f64::from(k);
        [x, -2.0, 0.3 * x.sin() + 0.2 * (-2.0f64).sin()]
    };
    let steering = Steering {
        curves: vec![(-50..=50).map(at).collect()],
        ..Default::default()
    };
    let notes = Notes::default();
    let options = OptimiseOptions::default();
    let result = steer(&wall, Some(&Shape::Wave), &steering, &options, &notes).unwrap();
    assert!(result.is_sound(), "{:?}", result.offenders);
    let notes = notes.0.into_inner().unwrap();
    for told in [
        "of its 6 corners are held",
        "vertices of the boundary that are not held",
    ] {
        assert!(notes.iter().any(|n| n.contains(told)), "{notes:?}");
    }
    assert!(all_simple(&result.mesh));
}
