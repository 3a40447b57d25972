//! What is said of a surface, and of how many panels suit it, against what is known of it.

use phex_job::SurfaceKind;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn kind(name: &str, parameters: &[(&str, f64)]) -> SurfaceKind {
    let shape = Shape::from_name(name, parameters).unwrap();
    let options = TriangulationOptions {
        triangles: 4000,
        ..Default::default()
    };
    SurfaceKind::new(&triangulate(&shape, &options).unwrap())
}

#[test]
fn signs_of_the_curvature_are_told_apart() {
    assert!(kind("sphere", &[]).domes > 0.99);
    assert!(kind("hyperbolic-paraboloid", &[]).saddles > 0.99);
    assert!(kind("cylinder", &[]).one_way > 0.99);
    assert!(kind("plane", &[]).flat > 0.99);
    let torus = kind("torus", &[]);
    // The outer half has more area than the inner one.
    assert!(torus.domes > 0.5 && torus.saddles > 0.3, "{torus:?}");
}

#[test]
fn numbers_of_panels_agree_with_lengths_of_edges_and_distances() {
    let sphere = kind("sphere", &[]);
    assert!((sphere.strongest - 1.0).abs() < 0.05, "{sphere:?}");
    let some = sphere.of_panels(500);
    let again = sphere.of_deviation(some.deviation).panels;
    assert!((500..=510).contains(&again), "{again}");
    // A flat surface needs one panel, whatever is asked for.
    assert_eq!(kind("plane", &[]).of_deviation(0.01).panels, 1);
}

#[test]
fn a_surface_that_passes_through_itself_is_told() {
    assert_eq!(kind("enneper", &[]).crosses_at, None);
    let options = TriangulationOptions {
        triangles: 4000,
        ..Default::default()
    };
    let plane = triangulate(&Shape::from_name("plane", &[]).unwrap(), &options).unwrap();
    let (low, high) = plane.bounding_box();
    // A sheet that is rolled up until its two ends pass through each other.
    let rolled = plane.mapped(|p| {
        let t = 4.4 * (p.x - low.x) / (high.x - low.x) - 2.2;
        [t * t * t / 3.0 - 1.2 * t, p.y + 0.1 * t, t * t].into()
    });
    let crossed = SurfaceKind::new(&rolled);
    assert!(crossed.self_crossings > 10, "{}", crossed.self_crossings);
    let told = crossed.sentences().pop().unwrap();
    assert!(told.contains("passes through itself"), "{told}");
}
