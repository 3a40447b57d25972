//! What Newton's method on the constraints brings: objective, last step, room and deviation against
//! the number of its iterations.
//!
//! `cargo run --release -p phex --example minimum -- MESH.obj ...` prints the table of
//! `docs/optimiser.md`, with the meshes that `benches/peers/peers.py` makes.

use phex::Silent;
use phex::optimise::{OptimiseOptions, Optimised, planarize};
use phex_mesh::measure::measure;
use phex_mesh::{HexMesh, io};
use phex_numeric::Record;
use std::path::Path;
use std::time::Instant;

const ITERATIONS: [usize; 7] = [0, 3, 6, 12, 25, 50, 200];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!(
        "| mesh | iterations | factorisations | seconds | objective | last step | least clearance | least angle | deviation max, rms |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for file in std::env::args().skip(1) {
        let path = Path::new(&file);
        let mesh = HexMesh::from_soup(&io::read_soup(path)?)?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        for newton_iterations in ITERATIONS {
            let options = OptimiseOptions {
                newton_iterations: Some(newton_iterations),
                ..OptimiseOptions::default()
            };
            let start = Instant::now();
            let result = planarize(&mesh, None, &options, &Silent)?;
            let seconds = start.elapsed().as_secs_f64();
            println!("| {name} {}", row(&result, newton_iterations, seconds));
        }
    }
    Ok(())
}

fn row(result: &Optimised, iterations: usize, seconds: f64) -> String {
    let (run, quality) = (&result.run, &result.quality);
    let on_constraints = |r: &&Record| r.phase.is_infinite() && r.energy.is_finite();
    let last = result.outcome.history.iter().rfind(on_constraints);
    let (objective, step) = last.map_or((String::new(), String::new()), |r| {
        let size = quality.mean_edge * quality.mean_edge;
        (format!("{:.3}", r.energy / size), format!("{:.0e}", r.step))
    });
    let angle = measure(&result.mesh).angle.min;
    format!(
        "| {iterations} | {} | {seconds:.2} | {objective} | {step} | {:.3} | {angle:.0} | {:.4}, {:.5} |",
        run.factorisations,
        quality.clearance,
        quality.deviation_max / quality.mean_edge,
        quality.deviation_rms / quality.mean_edge,
    )
}
