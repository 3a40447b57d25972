//! The metric in which panels are regular, and the cones of its direction field.
//!
//! On a closed surface the indices of a six-fold field add up to six times the Euler
//! characteristic: twelve pentagons on a sphere, none needed on a torus.

use phex::curvature::{CurvatureOptions, curvature, principal};
use phex::directions::{DirectionOptions, directions};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in ["sphere", "ellipsoid", "torus", "wave"] {
        let surface = triangulate(
            &Shape::from_name(name, &[])?,
            &TriangulationOptions::default(),
        )?;
        let panel_length = 0.06 * surface.diagonal();
        let curvature = curvature(&surface, panel_length, &CurvatureOptions::default());
        let field = directions(
            &surface,
            &curvature,
            panel_length,
            &DirectionOptions::default(),
        )?;
        let aspect = field.metric.enumerate().map(|(v, m)| {
            let p = principal(curvature.normal[v], m);
            (p.large / p.small).sqrt()
        });
        println!(
            "{name}: panels up to {:.2} times as long as wide, {} cones, sum of indices {}, Euler characteristic {}",
            aspect.fold(1.0, f64::max),
            field.cone.iter().filter(|c| **c != 0).count(),
            field.cone.iter().sum::<i32>(),
            surface.topology().euler_characteristic()
        );
    }
    Ok(())
}
