//! The whole flow in one call: a surface in, planar hexagonal panels out, and what is known about
//! them.

use phex::{Event, MeshOptions, PanelSize, Progress, mesh_surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
use phex_mesh::{deviation, measure};

/// Prints the stages as they begin.
struct Stages;

impl Progress for Stages {
    fn report(&self, event: &Event) {
        if let Event::StageStarted { stage } = event {
            println!("{stage} ...");
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let roof = triangulate(
        &Shape::from_name("roof", &[])?,
        &TriangulationOptions::default(),
    )?;
    let options = MeshOptions {
        size: PanelSize::Panels(200),
        ..Default::default()
    };
    let run = mesh_surface(&roof, &options, &Stages)?;
    let figures = measure(&run.mesh);
    println!("{} panels, sound: {}", figures.faces, run.is_sound());
    println!("planarity {:.1e} mean edges", figures.planarity.max);
    let off = 100.0 * deviation(&run.mesh, &run.target).deviation_max;
    println!("off the smooth surface by {off:.3} % of its diagonal at most");
    for violation in &run.violations {
        println!("{violation}");
    }
    Ok(())
}
