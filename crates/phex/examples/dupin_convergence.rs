//! Theorem 1 of Wang and Liu under refinement: how far the corners of panels are from a homothetic copy of Dupin's indicatrix, over the panel's radius,
//! and the rate at which that falls with the size of the panels.
//!
//! `cargo run --release -p phex --example dupin_convergence` prints a table for both layouts on a torus and a wave: the median and the mean of all inner panels,
//! the mean of those that nothing holds open, and their share. On the wave, a brick wall's panels are not inscribed where the curvature across the rows vanishes, however
//! small they are: there no simple brick of these proportions has its corners on the surface. The lattice turns its rows there.

use phex::curvature::dupin::{free_panels, indicatrix_distances};
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
            println!("  panels  mean edge  median  rate   mean    rate   free    rate   share");
            let mut last: Option<Measured> = None;
            for panels in [150, 600, 2400] {
                let now = measure(&surface, method, panels)?;
                let columns = (0..3).map(|k| {
                    let rate = last.as_ref().map_or(f64::NAN, |l| {
                        (l.figures[k] / now.figures[k]).ln() / (l.edge / now.edge).ln()
                    });
                    format!("{:.4}  {rate:.2}", now.figures[k])
                });
                let columns: Vec<String> = columns.collect();
                println!(
                    "  {:>6}  {:.4}     {}   {:.2}",
                    now.panels,
                    now.edge,
                    columns.join("   "),
                    now.share
                );
                last = Some(now);
            }
        }
    }
    Ok(())
}

/// What one mesh has.
struct Measured {
    panels: usize,
    edge: f64,
    /// Median and mean of the distances, and the mean of those where panels are free.
    figures: [f64; 3],
    /// Share of the panels that is free.
    share: f64,
}

fn measure(
    surface: &TriangleSurface,
    method: Method,
    panels: usize,
) -> Result<Measured, Box<dyn std::error::Error>> {
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
    let free = free_panels(&run.mesh);
    let at_free = distances.iter().zip(&free).filter(|pair| *pair.1);
    let at_free: Vec<f64> = at_free.filter_map(|pair| *pair.0).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    Ok(Measured {
        panels: run.mesh.topology().n_faces(),
        edge: run.mesh.mean_edge(),
        figures: [known[known.len() / 2], mean(&known), mean(&at_free)],
        share: at_free.len() as f64 / known.len() as f64,
    })
}
