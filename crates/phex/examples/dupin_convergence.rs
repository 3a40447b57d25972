//! Theorem 1 of Wang and Liu under refinement: how far the corners of panels are from a homothetic copy of Dupin's indicatrix, over the panel's radius,
//! and the rate at which that falls with the size of the panels.
//!
//! `cargo run --release --example dupin_convergence` prints a table for both layouts on a torus and a wave.

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
            println!("  panels   mean edge   median distance   mean distance   rate of the mean");
            let mut last: Option<[f64; 2]> = None;
            for panels in [150, 600, 2400] {
                let [edge, median, mean, count] = measure(&surface, method, panels)?;
                let rate = last.map_or(String::new(), |[e, d]| {
                    format!("{:.2}", (d / mean).ln() / (e / edge).ln())
                });
                println!(
                    "  {count:>6}   {edge:.4}      {median:.4}            {mean:.4}          {rate}"
                );
                last = Some([edge, mean]);
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
