//! The smooth target: it passes through its input, and is smooth between.
use crate::common::{
    figures, genus_two, mapped, normalised, punched_plane, rotation, shape, shape_with,
};
use phex::smooth_surface::{
    Affinity, Refinement, SmoothTarget, TargetOptions, boundary_corners, smooth_target,
};
use phex_mesh::{TriangleSurface, Vec3, VertexId};

fn refined(surface: &TriangleSurface, vertices: usize) -> SmoothTarget {
    smooth_target(surface, vertices, &TargetOptions::default())
}

fn largest_distance(a: &TriangleSurface, b: &TriangleSurface) -> f64 {
    let pairs = a.positions().iter().zip(b.positions());
    pairs.map(|(p, q)| (p - q).norm()).fold(0.0, f64::max)
}

/// A target that only approximates its input is caught, and so is a wrong report of how well it
/// does.
#[test]
fn the_target_passes_through_the_vertices_of_the_input() {
    for (name, tolerance) in [("torus", 1e-5), ("wave", 1e-4), ("monkey-saddle", 2e-4)] {
        let input = normalised(&shape(name, 1000));
        let target = refined(&input, 6000);
        let worst = largest_distance(&input, target.finest());
        assert!(worst < tolerance, "{name}: {worst:e}");
        assert_eq!(worst, target.interpolation_error, "{name}");
    }
}

#[test]
fn more_corrections_interpolate_better() {
    let input = normalised(&shape("ellipsoid", 500));
    let error = |corrections| {
        let options = TargetOptions {
            corrections,
            ..Default::default()
        };
        smooth_target(&input, 3000, &options).interpolation_error
    };
    let errors = [0, 2, 4, 6].map(error);
    assert!(errors.windows(2).all(|e| e[1] < 0.5 * e[0]), "{errors:?}");
}

/// Vertices keep their numbers and their place from level to level.
#[test]
fn coarse_levels_hold_points_of_the_finest() {
    let target = refined(&normalised(&shape("b-spline", 500)), 5000);
    assert!(target.levels.len() > 2);
    assert_eq!(target.levels.len(), target.refinements.len() + 1);
    for level in &target.levels {
        assert!(largest_distance(level, target.finest()) < 1e-15);
    }
}

#[test]
fn every_level_has_the_topology_of_the_input() {
    let cases = [
        (shape("sphere", 320), (2, 0)),
        (shape("torus", 500), (0, 0)),
        (genus_two(), (-2, 0)),
        (shape("plane", 300), (1, 1)),
        (shape("catenoid", 500), (0, 2)),
        (punched_plane(0.25), (-1, 3)),
    ];
    for (surface, expected) in cases {
        let target = refined(&normalised(&surface), 4 * surface.positions().len());
        for level in &target.levels {
            assert_eq!(figures(level.topology()), expected);
        }
        assert!(target.finest().positions().len() >= 4 * surface.positions().len());
    }
}

#[test]
fn an_input_that_is_fine_enough_is_left_alone() {
    let input = normalised(&shape("torus", 1000));
    let target = refined(&input, 100);
    assert!(target.refinements.is_empty());
    assert_eq!(target.finest().positions(), input.positions());
    assert_eq!(target.interpolation_error, 0.0);
}

/// Corners that creep or are rounded off are caught.
#[test]
fn sharp_corners_stay_where_they_are() {
    let input = normalised(&shape_with("plane", &[("width", 3.0)], 400));
    let target = refined(&input, 5000);
    assert_eq!(target.corners.len(), 4);
    let (low, high) = input.bounding_box();
    for level in &target.levels {
        for &corner in &target.corners {
            let p = level.positions()[corner];
            assert!((p - input.positions()[corner]).norm() < 1e-15);
            assert!((0..2).all(|k| p[k] == low[k] || p[k] == high[k]), "{p}");
        }
        assert_eq!(boundary_corners(level, 0.7).len(), 4);
    }
    // A rectangle of sides 3 : 2 and diagonal 1.
    assert!((target.finest().area() - 6.0 / 13.0).abs() < 1e-12);
}

#[test]
fn a_smooth_boundary_has_no_corners() {
    for name in ["monkey-saddle", "catenoid", "roof"] {
        let target = refined(&normalised(&shape(name, 1000)), 1000);
        assert!(target.corners.is_empty(), "{name}: {:?}", target.corners);
    }
}

/// A model in millimetres and in metres, far from the origin or not, is the same model.
#[test]
fn units_do_not_matter() {
    let input = shape("wave", 600);
    let reference = refined(&normalised(&input), 4000);
    for scale in [1e-3, 1e3, 1e4] {
        let other = refined(&normalised(&mapped(&input, |p| p * scale)), 4000);
        let worst = largest_distance(reference.finest(), other.finest());
        assert!(worst < 1e-12, "scale {scale}: {worst:e}");
        assert_eq!(reference.corners, other.corners);
    }
}

#[test]
fn the_similarity_and_its_inverse_cancel() {
    let surface = mapped(&shape("torus", 500), |p| {
        p * 37.0 + Vec3::new(5.0, -3.0, 900.0)
    });
    let affinity = Affinity::normalising(&surface);
    let unit = normalised(&surface);
    let (low, high) = unit.bounding_box();
    assert!(((high - low).norm() - 1.0).abs() < 1e-12 && (high + low).norm() < 1e-12);
    let pairs = surface.positions().iter().zip(unit.positions());
    for (p, q) in pairs {
        assert!((affinity.restore(*q) - p).norm() < 1e-11);
    }
}

#[test]
fn a_rotated_input_has_a_rotated_target() {
    let input = normalised(&shape("b-spline", 500));
    let turned = mapped(&input, |p| rotation() * p);
    let (a, b) = (refined(&input, 4000), refined(&turned, 4000));
    let a = mapped(a.finest(), |p| rotation() * p);
    assert!(largest_distance(&a, b.finest()) < 1e-12);
}

/// Faceted or shrunk spheres are caught: the target is far closer to the sphere than its input's
/// triangles are.
#[test]
fn a_sphere_stays_a_sphere() {
    let input = shape("sphere", 320);
    let target = refined(&input, 10_000);
    let errors = target.finest().positions().iter();
    let worst = errors.map(|p| (p.norm() - 1.0).abs()).fold(0.0, f64::max);
    let facets = input.topology().faces();
    let sagitta = facets
        .map(|f| 1.0 - (input.centroid(f)).norm())
        .fold(0.0, f64::max);
    assert!(worst < 0.15 * sagitta, "{worst:e} against {sagitta:e}");
}

/// Subdividing with no corners named pulls a corner in: this is what naming it prevents.
#[test]
fn an_unnamed_corner_is_rounded() {
    let input = shape("plane", 300);
    let corner: VertexId = boundary_corners(&input, 0.7)[0];
    let (step, _) = Refinement::of(input.topology(), &[]);
    let moved = step.apply(input.positions())[corner] - input.positions()[corner];
    assert!(moved.norm() > 1e-3);
}
