//! Principal curvatures of a triangulated torus at the scale of panels, next to their exact range.
//!
//! The tube's radius is 0.4, so one curvature is 2.5 everywhere; the other runs from `-1 / 0.6`
//! inside to `1 / 1.4` outside. The estimate averages over a panel, so it is a little smaller:
//! curvature is wanted at the scale of what is built.

use phex::curvature::{CurvatureOptions, curvature};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let torus = Shape::from_name("torus", &[("major", 1.0), ("minor", 0.4)])?;
    let surface = triangulate(&torus, &TriangulationOptions::default())?;
    for panel_length in [0.1, 0.2, 0.4] {
        let estimate = curvature(&surface, panel_length, &CurvatureOptions::default());
        let principal = estimate.principal();
        let range = |values: &[f64]| {
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            format!("{low:6.3} to {high:6.3}")
        };
        let small: Vec<f64> = principal.iter().map(|p| p.small).collect();
        let large: Vec<f64> = principal.iter().map(|p| p.large).collect();
        println!(
            "panels of {panel_length}: k1 {} (exact -1.667 to 0.714), k2 {} (exact 2.5)",
            range(&small),
            range(&large)
        );
    }
    Ok(())
}
