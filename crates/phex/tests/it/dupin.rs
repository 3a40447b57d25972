//! Theorem 1 of Wang and Liu: panels are inscribed in homothetic copies of Dupin's indicatrix, the
//! better the smaller they are.
use phex::curvature::indicatrix_distances;
use phex::curvature::{CurvatureOptions, curvature};
use phex::optimise::OptimiseOptions;
use phex::pipeline::Method;
use phex::{Effort, MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::TriangleSurface;

/// Mean edge, and median and mean of the distances of the corners from the indicatrix.
fn measured(
    surface: &TriangleSurface,
    method: Method,
    panels: usize,
    optimise: OptimiseOptions,
) -> [f64; 3] {
    let options = MeshOptions {
        size: PanelSize::Panels(panels),
        method,
        // Nothing but the size differs.
        effort: Effort::Draft,
        optimise,
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
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    [run.mesh.mean_edge(), known[known.len() / 2], mean]
}

#[test]
fn distances_fall_with_the_size_of_panels() {
    for (name, method) in [("torus", Method::BrickWall), ("wave", Method::Lattice)] {
        let surface = crate::common::shape(name, 20_000);
        let [coarse, fine] =
            [150, 2400].map(|n| measured(&surface, method, n, OptimiseOptions::default()));
        let rate = (coarse[1] / fine[1]).ln() / (coarse[0] / fine[0]).ln();
        assert!(fine[1] < 0.04, "{name}: {fine:?}");
        // Towards 1 with smaller panels: see the example `dupin_convergence`. Lattices of different
        // sizes differ by chance, so sizes are far apart.
        assert!(rate > 0.7, "{name}: {coarse:?} {fine:?} rate {rate}");
    }
}

/// On the wave rows cross asymptotic directions, where a barrier of fixed reach holds panels open:
/// the mean falls with the size only if closeness and reach go with it.
#[test]
fn weights_that_go_with_the_size_let_the_mean_fall_on_the_wave() {
    let surface = crate::common::shape("wave", 20_000);
    let usual = OptimiseOptions::default;
    let refined = |n: usize| usual().refined((n as f64 / 150.0).sqrt());
    let [coarse, fine] = [600, 2400].map(|n| measured(&surface, Method::Lattice, n, refined(n)));
    let rate = (coarse[2] / fine[2]).ln() / (coarse[0] / fine[0]).ln();
    // Lattices of different sizes differ by chance: some tenths, see the example
    // `dupin_convergence`.
    assert!(rate > 0.7, "{coarse:?} {fine:?} rate {rate}");
    let as_usual = measured(&surface, Method::Lattice, 2400, usual());
    assert!(fine[2] < 0.65 * as_usual[2], "{fine:?} {as_usual:?}");
}
