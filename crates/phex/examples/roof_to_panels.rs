//! A surface in, planar hexagonal panels out: `roof_to_panels [SURFACE] [MESH]`.
//!
//! Without a file the built-in roof is covered, and the panels go to `roof-phex.obj`.

use phex::{Boundary, Event, Mesher, Progress, Surface};
use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};

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
    let mut files = std::env::args().skip(1);
    let surface = match files.next() {
        Some(file) => Surface::read(file)?,
        None => triangulate(
            &Shape::from_name("roof", &[])?,
            &TriangulationOptions::default(),
        )?,
    };
    let made = Mesher::new()
        .panels(200)
        .boundary(Boundary::Clip)
        .progress(&Stages)
        .run(&surface)?;
    let report = made.report();
    println!(
        "{} panels, {:?}; planarity {:.1e} mean edges",
        report.assessment.measures.faces,
        report.assessment.verdict,
        report.assessment.measures.planarity.max
    );
    for violation in &report.assessment.violations {
        println!("{violation}");
    }
    made.write(files.next().as_deref().unwrap_or("roof-phex.obj"))?;
    Ok(())
}
