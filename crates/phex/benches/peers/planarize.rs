//! Makes the faces of a mesh planar and prints one line of JSON with processor seconds and figures,
//! as peers do.
//!
//! `cargo run --release --example planarize -- MESH.obj OUT.obj`; the comparison is run by
//! `benches/peers/peers.py`.

use phex::Silent;
use phex::optimise::{OptimiseOptions, planarize};
use phex_mesh::HexMesh;
use serde_json::json;
use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = files.as_slice() else {
        return Err("two files: a mesh, and where to write the result".into());
    };
    let mesh = HexMesh::from_soup(&phex_mesh::io::read_soup(Path::new(input))?)?;
    let before = processor_seconds();
    let result = planarize(&mesh, None, &OptimiseOptions::default(), &Silent)?;
    let seconds = processor_seconds() - before;
    phex_mesh::io::write_soup(Path::new(output), &result.mesh.to_soup())?;
    let run = &result.run;
    println!(
        "{}",
        json!({
            "peer": "phex",
            "path": run.path,
            "iterations": run.iterations,
            "factorisations": run.factorisations,
            "user_s": seconds,
            "rss_mb": peak_memory(),
            "planarity": result.quality.planarity,
            "last_step": result.outcome.history.last().map(|r| r.step),
            "clearance": result.quality.clearance,
            "offenders": result.offenders.len(),
        })
    );
    Ok(())
}

/// Seconds that all threads of this process have run; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    let tasks = std::fs::read_dir("/proc/self/task").into_iter().flatten();
    let nanoseconds = tasks.flatten().filter_map(|task| {
        let text = std::fs::read_to_string(task.path().join("schedstat")).ok()?;
        text.split(' ').next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-9
}

/// Largest resident memory, in megabytes; 0 where the system does not tell.
fn peak_memory() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmHWM:"));
    let kilobytes = line.and_then(|l| l.split_whitespace().nth(1)?.parse::<f64>().ok());
    kilobytes.unwrap_or(0.0) / 1024.0
}
