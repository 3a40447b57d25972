//! Whole runs with the brick wall: what its meshes reach, and what is refused.
use crate::common::{figures, genus_two, shape};
use phex::directions::NetworkError;
use phex::layout::LayoutError;
use phex::pipeline::{Method, network_curves};
use phex::{MeshOptions, MeshRun, PanelSize, PipelineError, Silent, mesh_surface};
use phex_mesh::{TriangleSurface, Vec3, measure};

fn brick_run(surface: &TriangleSurface, panels: usize) -> Result<MeshRun, PipelineError> {
    let options = MeshOptions {
        size: PanelSize::Panels(panels),
        method: Method::BrickWall,
        ..Default::default()
    };
    mesh_surface(surface, &options, &Silent)
}

#[test]
fn meshes_of_patches_annuli_and_the_torus_are_sound() {
    let names = [
        "wave",
        "hyperbolic-paraboloid",
        "roof",
        "b-spline",
        "monkey-saddle",
        "torus",
    ];
    for name in names {
        let surface = shape(name, 6000);
        let run = brick_run(&surface, 250).unwrap();
        assert!(run.is_sound(), "{name}: {:?}", run.violations());
        assert!(measure(&run.mesh).planarity.max <= 1e-12, "{name}");
        assert_eq!(
            figures(run.mesh.topology()),
            figures(surface.topology()),
            "{name}"
        );
        let hexagons = measure(&run.mesh).hex.unwrap_or(0.0);
        assert!(hexagons > 0.93, "{name}: {hexagons}");
        assert_eq!(run.statistics.runs[0].start_faults, 0, "{name}");
    }
}

#[test]
fn surfaces_without_a_global_network_are_refused_by_name() {
    for (surface, chi) in [(shape("sphere", 2000), 2), (genus_two(), -2)] {
        match brick_run(&surface, 100) {
            Err(PipelineError::Layout(LayoutError::Network(e))) => {
                assert!(
                    matches!(e, NetworkError::Closed { euler, count, .. } if euler == chi && count > 0)
                );
                assert!(e.to_string().contains("no global conjugate network"));
            }
            other => panic!("{:?}", other.err()),
        }
    }
}

#[test]
fn singular_points_are_named_in_the_coordinates_of_the_model() {
    let sphere = crate::common::mapped(&shape("sphere", 2000), |p| {
        p * 50.0 + Vec3::new(900.0, 0.0, 0.0)
    });
    match brick_run(&sphere, 100) {
        Err(PipelineError::Layout(LayoutError::Network(NetworkError::Closed { near, .. }))) => {
            let radius = (near - Vec3::new(900.0, 0.0, 0.0)).norm();
            assert!((radius - 50.0).abs() < 2.0, "{near}");
        }
        other => panic!("{:?}", other.err()),
    }
}

#[test]
fn network_of_a_torus_consists_of_its_circles() {
    let options = MeshOptions {
        size: PanelSize::Panels(200),
        ..Default::default()
    };
    let curves = network_curves(&shape("torus", 6000), &options, &Silent).unwrap();
    let spread = |values: Vec<f64>| {
        let (low, high) = values
            .iter()
            .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
        high - low
    };
    for row in &curves.rows {
        assert!(row.closed);
        assert!(spread(row.points.iter().map(|p| p.z).collect()) < 0.02);
    }
    for column in &curves.columns {
        assert!(column.closed);
        let axis = column.points[0].xy().normalize().yx();
        let off: Vec<f64> = column
            .points
            .iter()
            .map(|p| p.x * axis.x - p.y * axis.y)
            .collect();
        assert!(spread(off) < 0.04);
    }
    assert!(curves.rows.len() > 6 && curves.columns.len() > 20);
}
