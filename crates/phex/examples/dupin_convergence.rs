//! Theorem 1 of Wang and Liu under refinement: how far the corners of panels are from a homothetic copy of Dupin's indicatrix, over the panel's radius,
//! and the rate at which that falls with the size of the panels.
//!
//! `cargo run --release -p phex --example dupin_convergence` prints a table for both layouts on a torus and a wave. On the wave, a brick wall's panels are not
//! inscribed where the curvature across the rows vanishes, however small they are; the lattice turns its rows there.

use phex::curvature::dupin::indicatrix_distances;
use phex::curvature::{CurvatureOptions, curvature};
use phex::pipeline::Method;
use phex::{MeshOptions, PanelSize, Silent, mesh_surface};
use phex_mesh::TriangleSurface;
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in ["torus", "wave"] {
        let options = TriangulationOptions {
            triangles: 60_000,
            ..Default::default()
        };
        let surface = triangulate(&Shape::from_name(name, &[])?, &options)?;
        for method in [Method::BrickWall, Method::Lattice] {
            println!("{name}, {method:?}");
            println!("  panels  mean edge  median  rate   mean    rate");
            let mut last: Option<[f64; 3]> = None;
            for panels in [150, 600, 2400] {
                let [edge, median, mean, count] = measure(&surface, method, panels)?;
                let rate = |now: f64, k: usize| {
                    last.map_or(f64::NAN, |l| (l[k] / now).ln() / (l[0] / edge).ln())
                };
                let (of_median, of_mean) = (rate(median, 1), rate(mean, 2));
                println!(
                    "  {count:>6}  {edge:.4}     {median:.4}  {of_median:.2}   {mean:.4}  {of_mean:.2}"
                );
                last = Some([edge, median, mean]);
            }
        }
    }
    Ok(())
}

/// Mean edge, median and mean of the distances, number of panels.
fn measure(
    surface: &TriangleSurface,
    method: Method,
    panels: usize,
) -> Result<[f64; 4], Box<dyn std::error::Error>> {
    let options = MeshOptions {
        size: PanelSize::Panels(panels),
        method,
        ..Default::default()
    };
    let run = mesh_surface(surface, &options, &Silent)?;
    // Curvature at the points themselves, not at the scale of panels.
    let curvature = curvature(
        surface,
        0.02 * surface.diagonal(),
        &CurvatureOptions::default(),
    );
    let distances = indicatrix_distances(&run.mesh, surface, &curvature);
    let mut known: Vec<f64> = distances.iter().flatten().copied().collect();
    known.sort_by(f64::total_cmp);
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    let count = run.mesh.topology().n_faces() as f64;
    Ok([run.mesh.mean_edge(), known[known.len() / 2], mean, count])
}
