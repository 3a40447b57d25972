//! Metric and direction field: identities that hold for every surface, and the answers on simple
//! ones.

use crate::common::{Stages, genus_two, punched_plane, shape, shape_with};
use crate::curvature::tangent_frame;
use crate::directions::DirectionOptions;
use crate::directions::cones::prescribed_faces;
use crate::directions::guides::{Cone, Guides};
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{PerVertex, TriangleSurface, Vec3, VertexId};
use std::f64::consts::{FRAC_PI_3, PI};

fn cone_sum(stages: &Stages) -> i32 {
    stages.directions.cone.iter().sum()
}

/// Angle modulo a sixth of a turn, in `[-pi / 6, pi / 6)`.
fn modulo_sixth(angle: f64) -> f64 {
    (angle + 0.5 * FRAC_PI_3).rem_euclid(FRAC_PI_3) - 0.5 * FRAC_PI_3
}

/// Angle in the metric from the tangent `along` to the lattice direction at a vertex, modulo a
/// sixth of a turn.
fn lattice_angle(stages: &Stages, v: VertexId, along: Vec3) -> f64 {
    let (topology, d) = (stages.topology(), &stages.directions);
    let (m, n) = (&d.metric[v], stages.surface.normals()[v]);
    let unit = |e: Vec3| e / e.dot(&(m * e)).sqrt();
    let x = unit(along - n * along.dot(&n));
    let left = n.cross(&x);
    let y = unit(left - x * x.dot(&(m * left)));
    let mut mean = 0.0;
    let mut count = 0.0;
    for h in topology.outgoing(v) {
        let e = stages.surface.positions()[topology.target(h)] - stages.surface.positions()[v];
        let edge = e.dot(&(m * y)).atan2(e.dot(&(m * x)));
        mean += modulo_sixth(d.angle[v] - d.intrinsic.polar(topology, h) + edge);
        count += 1.0;
    }
    mean / count
}

/// Determinant of a metric in the tangent plane.
fn determinant(stages: &Stages, v: VertexId) -> f64 {
    let [a, b] = tangent_frame(stages.curvature.normal[v]);
    let m = &stages.directions.metric[v];
    a.dot(&(m * a)) * b.dot(&(m * b)) - a.dot(&(m * b)).powi(2)
}

/// Without the conformal factor a panel has the same area everywhere: `det M = 1 / L^4`.
#[test]
fn the_metric_has_the_determinant_of_the_panel_length() {
    let rigid = DirectionOptions {
        conformal_limit: 0.0,
        ..Default::default()
    };
    for name in ["torus", "wave", "monkey-saddle", "ellipsoid"] {
        let stages = Stages::with(&shape(name, 1000), 80, &rigid);
        let expected = stages.length.powi(-4);
        for v in stages.topology().vertices() {
            assert!(
                (determinant(&stages, v) / expected - 1.0).abs() < 1e-9,
                "{name} {v}"
            );
        }
    }
}

/// The ratio of panel lengths along the principal directions stays below the option.
#[test]
fn anisotropy_is_limited() {
    for limit in [1.0, 1.5, 2.0] {
        let options = DirectionOptions {
            anisotropy: limit,
            ..Default::default()
        };
        let stages = Stages::with(&shape("cylinder", 1000), 80, &options);
        let mut largest: f64 = 0.0;
        for v in stages.topology().vertices() {
            let p = crate::curvature::principal(
                stages.curvature.normal[v],
                &stages.directions.metric[v],
            );
            largest = largest.max((p.large / p.small).sqrt());
        }
        assert!(
            (largest - limit).abs() < 0.02 * limit,
            "{largest} for {limit}"
        );
    }
}

/// The conformal factor keeps within its limit.
#[test]
fn conformal_scaling_is_limited() {
    let options = DirectionOptions {
        conformal_screening: 1e-3,
        conformal_limit: 0.2,
        ..Default::default()
    };
    let stages = Stages::with(&shape("torus", 1000), 100, &options);
    let size = |v| (determinant(&stages, v) * stages.length.powi(4)).ln() / 4.0;
    let sizes: Vec<f64> = stages.topology().vertices().map(size).collect();
    assert!(sizes.iter().all(|s| s.abs() < 0.2 + 1e-9));
    assert!(
        sizes.iter().any(|s| s.abs() > 0.05),
        "the factor does something"
    );
}

#[test]
fn intrinsic_triangles_are_euclidean() {
    for name in ["torus", "wave", "b-spline"] {
        let stages = Stages::new(&shape(name, 1000), 60);
        let (topology, mesh) = (stages.topology(), &stages.directions.intrinsic);
        for f in topology.faces() {
            let sum: f64 = topology.face_half_edges(f).map(|h| mesh.corner[h]).sum();
            assert!((sum - PI).abs() < 1e-9, "{name} {f}: {sum}");
        }
        let areas: f64 = mesh.area.iter().sum();
        assert!((mesh.mass.iter().sum::<f64>() - areas).abs() < 1e-9 * areas);
        assert!(mesh.weight.iter().all(|w| *w > 0.0));
        // As many lattice cells as panels were asked for, up to the conformal factor.
        let cell = 0.75_f64.sqrt();
        let panels = areas / cell;
        assert!((panels / 60.0 - 1.0).abs() < 0.1, "{name}: {panels}");
    }
}

/// Gauss-Bonnet: the angles of the intrinsic mesh add up to the Euler characteristic.
#[test]
fn the_intrinsic_curvature_is_the_euler_characteristic() {
    let cases = [
        (shape("sphere", 320), 2),
        (shape("torus", 1000), 0),
        (genus_two(), -2),
        (shape("plane", 500), 1),
        (shape("catenoid", 1000), 0),
        (punched_plane(0.25), -1),
    ];
    for (surface, euler) in cases {
        let stages = Stages::new(&surface, 60);
        let (topology, mesh) = (stages.topology(), &stages.directions.intrinsic);
        let turn = |v| {
            if topology.is_boundary_vertex(v) {
                PI
            } else {
                2.0 * PI
            }
        };
        let total: f64 = topology
            .vertices()
            .map(|v| turn(v) - mesh.angle_sum[v])
            .sum();
        assert!(
            (total / (2.0 * PI) - f64::from(euler)).abs() < 1e-9,
            "{total}"
        );
    }
}

/// On a closed surface the indices of a six-fold field add up to six times the Euler characteristic
/// (Poincare-Hopf).
#[test]
fn cones_of_closed_surfaces_add_up() {
    let cases = [
        (shape("sphere", 320), 12),
        (shape("ellipsoid", 1000), 12),
        (shape("torus", 1000), 0),
        (genus_two(), -12),
    ];
    for (surface, expected) in cases {
        assert_eq!(cone_sum(&Stages::new(&surface, 80)), expected);
    }
}

/// With a boundary, the indices are six times the Euler characteristic less the sixths of a turn
/// that the field makes against the boundary's tangent, loop by loop.
#[test]
fn cones_of_open_surfaces_agree_with_the_boundary() {
    let surfaces = [
        shape("wave", 1000),
        shape("b-spline", 1000),
        shape("monkey-saddle", 1000),
        shape("hyperboloid", 1000),
        shape("elliptic-paraboloid", 1000),
        punched_plane(0.25),
    ];
    for surface in surfaces {
        let stages = Stages::new(&surface, 60);
        let (topology, d) = (stages.topology(), &stages.directions);
        let boundary = topology.boundary_edges();
        let mut total = 2.0 * PI * topology.euler_characteristic() as f64;
        for e in boundary {
            total += d.rest(topology, e);
            total -= PI - d.intrinsic.angle_sum[topology.edge_vertices(e)[1]];
        }
        let sixths = total / FRAC_PI_3;
        assert!(
            (sixths - f64::from(cone_sum(&stages))).abs() < 1e-6,
            "{sixths}"
        );
    }
}

#[test]
fn a_plane_has_a_constant_field() {
    let stages = Stages::new(&shape("plane", 500), 80);
    assert!(stages.directions.cone.iter().all(|c| *c == 0));
    for v in stages.topology().vertices() {
        assert!(lattice_angle(&stages, v, Vec3::x()).abs() < 1e-6);
        let isotropic = nalgebra::Matrix3::identity() / stages.length.powi(2);
        let difference = stages.directions.metric[v] - isotropic;
        let tangential = difference.fixed_view::<2, 2>(0, 0).norm();
        assert!(tangential < 1e-3 * isotropic.norm(), "{tangential}");
    }
}

/// A surface without the triangles at the vertex that is nearest to a point.
fn with_hole(surface: &TriangleSurface, place: Vec3) -> TriangleSurface {
    let topology = surface.topology();
    let distance = |v: &VertexId| (surface.positions()[*v] - place).norm();
    let nearest = topology
        .vertices()
        .min_by(|v, w| distance(v).total_cmp(&distance(w)));
    let nearest = nearest.unwrap();
    // The last vertex takes the number of the one that goes.
    let mut positions = surface.positions().clone().into_vec();
    let last = positions.len() as u32 - 1;
    positions.swap_remove(nearest.index());
    let number = |v: u32| if v == last { nearest.index() as u32 } else { v };
    let kept = topology
        .faces()
        .filter(|f| !topology.face_vertices(*f).contains(&nearest));
    let triangles: Vec<[u32; 3]> = kept
        .map(|f| {
            let corners: [VertexId; 3] = topology.face_vertices(f).try_into().unwrap();
            corners.map(|v| number(v.index() as u32))
        })
        .collect();
    TriangleSurface::new(positions, &triangles).unwrap()
}

/// Directions run across a small hole as if the surface went on there: on a plane they stay what
/// they are, on its rim, too, and on a sphere cones are those of the sphere.
#[test]
fn directions_run_across_small_holes() {
    let options = DirectionOptions {
        across_holes: true,
        ..Default::default()
    };
    let plane = with_hole(&shape("plane", 500), Vec3::new(0.1, 0.05, 0.0));
    let stages = Stages::with(&plane, 80, &options);
    assert_eq!(stages.topology().boundary_loops().len(), 2);
    assert!(stages.directions.cone.iter().all(|c| *c == 0));
    for v in stages.topology().vertices() {
        let angle = lattice_angle(&stages, v, Vec3::x());
        assert!(angle.abs() < 1e-3, "{v}: {angle}");
    }
    let sphere = with_hole(&shape("sphere", 2000), Vec3::new(0.3, 0.4, 0.8));
    let stages = Stages::with(&sphere, 150, &options);
    assert_eq!(cone_sum(&stages), 12);
    let (topology, d) = (stages.topology(), &stages.directions);
    let rests = topology.edges().map(|e| d.rest(topology, e).abs());
    assert!(rests.fold(0.0, f64::max) < 0.5 * FRAC_PI_3);
}

/// Opposite cones vanish in pairs: fewer are left, their sum stays, and the indices are still those
/// of the turned field.
#[test]
fn opposite_cones_cancel() {
    let surface = genus_two();
    let with = |reach: f64| {
        let options = DirectionOptions {
            cancel_reach: Some(reach),
            ..Default::default()
        };
        Stages::with(&surface, 400, &options)
    };
    let (before, after) = (with(0.0), with(6.0));
    let count = |s: &Stages| s.directions.cone.iter().map(|c| c.abs()).sum::<i32>();
    assert_eq!(cone_sum(&before), cone_sum(&after));
    assert_eq!(before.directions.cancelled, 0);
    assert!(after.directions.cancelled > 0);
    assert!(
        count(&after) < count(&before),
        "{} {}",
        count(&before),
        count(&after)
    );
}

/// Lattice rows follow the direction that is straight: on a cylinder, the axis. A field across it
/// is caught.
#[test]
fn a_cylinder_is_ruled_along_its_axis() {
    let stages = Stages::new(&shape_with("cylinder", &[("height", 4.0)], 2000), 150);
    assert!(stages.directions.cone.iter().all(|c| *c == 0));
    for v in stages.topology().vertices() {
        let angle = lattice_angle(&stages, v, Vec3::z()).to_degrees();
        assert!(angle.abs() < 1.0, "{v}: {angle}");
    }
}

#[test]
fn the_rotate_option_turns_the_field() {
    for (name, axis) in [("plane", Vec3::x()), ("cylinder", Vec3::z())] {
        let options = DirectionOptions {
            rotate: 0.2,
            boundary_alignment: 0.0,
            ..Default::default()
        };
        let stages = Stages::with(&shape(name, 1000), 80, &options);
        for v in stages.topology().vertices() {
            let angle = lattice_angle(&stages, v, axis);
            assert!((angle - 0.2).abs() < 0.02, "{name} {v}: {angle}");
        }
    }
}

/// The matching across an edge is the same from both sides, and its rest is at most half a sixth.
#[test]
fn matchings_are_smallest() {
    let options = DirectionOptions {
        cancel_reach: Some(0.0),
        ..Default::default()
    };
    let stages = Stages::with(&shape("wave", 1000), 60, &options);
    let (topology, d) = (stages.topology(), &stages.directions);
    for e in topology.edges() {
        let rest = d.rest(topology, e);
        assert!(rest.abs() <= 0.5 * FRAC_PI_3 + 1e-12);
    }
}

/// A field that follows its surface: turning the surface in space turns nothing intrinsic.
#[test]
fn metric_and_cones_follow_a_rotation() {
    let surface = shape("torus", 1000);
    let turned = crate::common::mapped(&surface, |p| crate::common::rotation() * p);
    let (a, b) = (Stages::new(&surface, 80), Stages::new(&turned, 80));
    // The model is normalised by its box, which a rotation changes, so lengths differ by a factor
    // that cancels here.
    let ratio = |i: usize| {
        a.directions.intrinsic.length.as_slice()[i] / b.directions.intrinsic.length.as_slice()[i]
    };
    for i in 0..a.topology().n_edges() {
        assert!((ratio(i) - 1.0).abs() < 1e-6, "{}", ratio(i));
    }
    assert_eq!(cone_sum(&a), cone_sum(&b));
}

/// Lengths that violate the triangle inequality are mended, whatever the metric.
#[test]
fn wild_metrics_are_mended() {
    let surface: TriangleSurface = shape("plane", 500);
    let n = surface.positions().len();
    let metric = PerVertex::from_fn(n, |v: VertexId| {
        let s = if v.index().is_multiple_of(7) {
            1e4
        } else {
            1.0
        };
        nalgebra::Matrix3::from_diagonal(&Vec3::new(s, 1.0 / s, 1.0))
    });
    let mesh = IntrinsicMesh::new(&surface, &metric);
    let topology = surface.topology();
    for f in topology.faces() {
        let sides: Vec<f64> = topology
            .face_half_edges(f)
            .map(|h| mesh.length[topology.edge(h)])
            .collect();
        let longest = sides.iter().copied().fold(0.0, f64::max);
        assert!(
            longest < 0.99 * (sides.iter().sum::<f64>() - longest),
            "{sides:?}"
        );
        let angles: f64 = topology.face_half_edges(f).map(|h| mesh.corner[h]).sum();
        assert!((angles - PI).abs() < 1e-9);
    }
}

/// Rows run along a line, whatever it is drawn on; where nothing else is wished the whole field
/// follows it.
#[test]
fn rows_follow_a_line() {
    let along = Vec3::new(1.0, 0.4, 0.0);
    let line = [-along, along].map(|p| [p.x, p.y, p.z]).to_vec();
    let options = DirectionOptions {
        boundary_alignment: 0.0,
        guides: Guides {
            lines: vec![line],
            ..Default::default()
        },
        ..Default::default()
    };
    let stages = Stages::with(&shape("plane", 1000), 80, &options);
    for v in stages.topology().vertices() {
        let angle = lattice_angle(&stages, v, along).to_degrees();
        assert!(angle.abs() < 1.0, "{v}: {angle}");
    }
}

fn with_cones(name: &str, cones: &[([f64; 3], i32)]) -> Stages {
    let cone = |&(position, index): &([f64; 3], i32)| Cone { position, index };
    let options = DirectionOptions {
        guides: Guides::of_cones(cones.iter().map(cone).collect()),
        ..Default::default()
    };
    Stages::with(&shape(name, 1000), 80, &options)
}

/// Six cones of two sixths at the ends of the axes instead of the twelve that a sphere would have.
#[test]
fn cones_are_where_they_are_prescribed() {
    let sphere = Stages::new(&shape("sphere", 1000), 80).surface;
    let distance = sphere.positions().iter().map(|p| p.norm());
    let r = distance.fold(0.0, f64::max);
    let ends = [
        [r, 0.0, 0.0],
        [-r, 0.0, 0.0],
        [0.0, r, 0.0],
        [0.0, -r, 0.0],
        [0.0, 0.0, r],
        [0.0, 0.0, -r],
    ];
    let stages = with_cones("sphere", &ends.map(|p| (p, 2)));
    let cones: Vec<_> = stages
        .directions
        .cone
        .enumerate()
        .filter(|(_, i)| **i != 0)
        .collect();
    assert_eq!(cones.len(), 6);
    for (f, index) in cones {
        assert_eq!(*index, 2);
        let middle = stages.surface.centroid(f);
        let near = ends.iter().map(|p| (Vec3::from(*p) - middle).norm());
        assert!(near.fold(f64::INFINITY, f64::min) < 0.2 * r);
    }
}

/// On an open surface what is left over goes out of the boundary.
#[test]
fn an_open_surface_takes_any_cones() {
    let stages = with_cones("plane", &[([0.1, 0.1, 0.0], 1), ([-0.2, 0.1, 0.0], 1)]);
    assert_eq!(cone_sum(&stages), 2);
    assert_eq!(
        stages.directions.cone.iter().filter(|c| **c != 0).count(),
        2
    );
}

#[test]
fn impossible_cones_are_refused() {
    let surface = shape("sphere", 1000);
    let cone = |x: f64, index| Cone {
        position: [x, 0.0, 0.0],
        index,
    };
    let message = |cones: &[Cone]| prescribed_faces(&surface, cones).unwrap_err().to_string();
    assert!(message(&[cone(1.0, 5)]).contains("add up to 5 sixths"));
    assert!(message(&[cone(1.0, 6), cone(1.0, 6)]).contains("0 and 1 lie in the same place"));
    assert!(prescribed_faces(&surface, &[]).unwrap().is_empty());
}
