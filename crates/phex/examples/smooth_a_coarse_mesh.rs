//! The smooth surface that a coarse triangulation samples.
//!
//! A sphere of 320 triangles is refined until it has 5000 vertices: the target passes through the
//! input's vertices, and lies far closer to the sphere than the triangles did.

use phex::smooth_surface::{Affinity, TargetOptions, smooth_target};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let options = TriangulationOptions {
        triangles: 320,
        ..Default::default()
    };
    let sphere = triangulate(&Shape::from_name("sphere", &[])?, &options)?;
    // Stages work on a model of diagonal 1.
    let affinity = Affinity::normalising(&sphere);
    let target = smooth_target(
        &sphere.mapped(|p| affinity.normalise(*p)),
        5000,
        &TargetOptions::default(),
    );
    println!("interpolation error: {:.1e}", target.interpolation_error);
    for level in &target.levels {
        let radii = level.positions().iter();
        let worst = radii
            .map(|p| (affinity.restore(*p).norm() - 1.0).abs())
            .fold(0.0, f64::max);
        let vertices = level.positions().len();
        println!("{vertices:6} vertices, off the sphere by {worst:.1e}");
    }
    Ok(())
}
