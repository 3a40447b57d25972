//! Edges made equal: fewer distinct lengths, and nothing lost for them.
use crate::common::{shape, shape_with};
use phex::repetition::Repetition;
use phex::symmetry::Symmetry;
use phex::{Boundary, Effort, MeshOptions, MeshRun, PanelSize, Silent, mesh_surface};
use phex_mesh::{HexMesh, TriangleSurface, deviation, measure};

/// Width of the intervals, over the edge of a regular hexagon.
const TOLERANCE: f64 = 0.01;

fn options(surface: &TriangleSurface, panels: usize) -> MeshOptions {
    let edge = (surface.area() / panels as f64 / 2.598).sqrt();
    MeshOptions {
        size: PanelSize::Panels(panels),
        effort: Effort::Draft,
        repeat_rel: Some(TOLERANCE * edge / surface.diagonal()),
        ..Default::default()
    }
}

/// Lengths in the order of size, and the intervals that they need, without the library.
fn intervals(mesh: &HexMesh, width: f64) -> usize {
    let mut lengths: Vec<f64> = Vec::new();
    for face in mesh.topology().face_lists() {
        for (i, a) in face.iter().enumerate() {
            let b = face[(i + 1) % face.len()];
            let place = |v: u32| mesh.positions.as_slice()[v as usize];
            lengths.push((place(*a) - place(b)).norm());
        }
    }
    lengths.sort_by(f64::total_cmp);
    let (mut count, mut end) = (0, f64::NEG_INFINITY);
    for length in lengths {
        if length > end {
            (count, end) = (count + 1, length + width);
        }
    }
    count
}

fn told(run: &MeshRun, surface: &TriangleSurface, options: &MeshOptions) -> Repetition {
    let before = run.unrepeated.as_ref().unwrap();
    let tolerance = options.repeat_rel.unwrap() * surface.diagonal();
    let told = Repetition::new(before, &run.mesh, tolerance);
    assert_eq!(told.before.edge_lengths, intervals(before, tolerance));
    assert_eq!(told.after.edge_lengths, intervals(&run.mesh, tolerance));
    told
}

fn assert_kept(run: &MeshRun) {
    assert!(run.is_sound(), "{:?}", run.violations());
    assert!(measure(&run.mesh).planarity.max <= 1e-12);
    let off = |mesh: &HexMesh| deviation(mesh, &run.target).deviation_max;
    let before = off(run.unrepeated.as_ref().unwrap());
    assert!(off(&run.mesh) <= before.max(5e-3));
}

#[test]
fn distinct_lengths_of_a_torus_are_halved_and_nothing_is_lost() {
    let torus = shape("torus", 3000);
    let options = options(&torus, 150);
    let run = mesh_surface(&torus, &options, &Silent).unwrap();
    let told = told(&run, &torus, &options);
    assert!(
        2 * told.after.edge_lengths <= told.before.edge_lengths,
        "{told:?}"
    );
    assert!(told.after.panels <= run.mesh.topology().n_faces());
    assert_kept(&run);
    let plain = MeshOptions {
        repeat_rel: None,
        ..options.clone()
    };
    let without = mesh_surface(&torus, &plain, &Silent).unwrap();
    assert!(without.unrepeated.is_none());
    assert_eq!(
        run.unrepeated.as_ref().unwrap().positions,
        without.mesh.positions
    );
    let again = mesh_surface(&torus, &options, &Silent).unwrap();
    assert_eq!(again.mesh.positions, run.mesh.positions);
}

#[test]
fn every_boundary_keeps_its_place() {
    let dome = shape("elliptic-paraboloid", 3000);
    for boundary in [Boundary::Snap, Boundary::Clip, Boundary::Whole] {
        let options = MeshOptions {
            boundary,
            ..options(&dome, 120)
        };
        let run = mesh_surface(&dome, &options, &Silent).unwrap();
        let told = told(&run, &dome, &options);
        assert!(
            told.after.edge_lengths <= told.before.edge_lengths,
            "{boundary:?}: {told:?}"
        );
        assert!(run.is_sound(), "{boundary:?}: {:?}", run.violations());
        assert!(measure(&run.mesh).planarity.max <= 1e-12);
    }
}

#[test]
fn images_of_symmetric_panels_stay_equal() {
    let dome = shape_with(
        "elliptic-paraboloid",
        &[("a", 15.0), ("b", 15.0), ("radius", 10.8)],
        3000,
    );
    let options = MeshOptions {
        symmetry: Symmetry::Turns(6),
        ..options(&dome, 300)
    };
    let run = mesh_surface(&dome, &options, &Silent).unwrap();
    let told = told(&run, &dome, &options);
    assert!(
        told.after.edge_lengths < told.before.edge_lengths,
        "{told:?}"
    );
    let orbits = run.orbits.as_ref().unwrap();
    for (v, (source, operation)) in orbits
        .vertices
        .iter()
        .enumerate()
        .filter(|(_, (_, k))| *k > 0)
    {
        let places = run.mesh.positions.as_slice();
        let image = orbits.operations[*operation as usize].image(places[*source as usize]);
        assert_eq!(image, places[v]);
    }
}

#[test]
fn a_tolerance_without_meaning_is_refused() {
    let torus = shape("torus", 3000);
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY, 2.0] {
        let options = MeshOptions {
            repeat_rel: Some(wrong),
            ..options(&torus, 60)
        };
        let error = mesh_surface(&torus, &options, &Silent).err().unwrap();
        assert!(error.to_string().contains("repeat_rel"), "{wrong}: {error}");
    }
}
