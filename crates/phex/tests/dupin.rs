//! Theorem 1 of Wang and Liu: panels are inscribed in homothetic copies of Dupin's indicatrix, the better the smaller they are.

mod common;

use phex::curvature::dupin::indicatrix_distances;
use phex::curvature::{CurvatureOptions, curvature};
use phex::pipeline::Method;
use phex::{MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::TriangleSurface;

/// Mean edge and median distance of the corners from the indicatrix.
fn measured(surface: &TriangleSurface, method: Method, panels: usize) -> [f64; 2] {
    let options = MeshOptions {
        size: PanelSize::Panels(panels),
        method,
        // One anisotropy, so that nothing but the size differs.
        portfolio: Vec::new(),
        ..Default::default()
    };
    let run = mesh_surface(surface, &options, &Silent).unwrap();
    assert!(run.is_sound());
    let curvature = curvature(
        surface,
        0.02 * surface.diagonal(),
        &CurvatureOptions::default(),
    );
    let distances = indicatrix_distances(&run.mesh, surface, &curvature);
    let mut known: Vec<f64> = distances.iter().flatten().copied().collect();
    assert!(known.len() > panels / 3);
    known.sort_by(f64::total_cmp);
    [run.mesh.mean_edge(), known[known.len() / 2]]
}

#[test]
fn distances_fall_with_the_size_of_panels() {
    for (name, method) in [("torus", Method::BrickWall), ("wave", Method::Lattice)] {
        let surface = common::shape(name, 20_000);
        let [coarse, fine] = [300, 1200].map(|n| measured(&surface, method, n));
        let rate = (coarse[1] / fine[1]).ln() / (coarse[0] / fine[0]).ln();
        assert!(fine[1] < 0.04, "{name}: {fine:?}");
        // Towards 1 with smaller panels: see the example `dupin_convergence`.
        assert!(rate > 0.7, "{name}: {coarse:?} {fine:?} rate {rate}");
    }
}
