//! The table of `docs/book/src/edge-offsets.md`: panels with edge offsets on nine patches.
//!
//! `cargo run --release -p phex --example edge_offset_table -- 150 500 1500` makes them with about
//! so many panels each, and measures from coordinates: planarity, clearance, deviation from the
//! smooth surface, the edges of offsets at +-1 % and +-0.3 % of the diagonal, and the order of the
//! root mean square deviation in the panels' length between the first and the last number.

#[path = "../tests/it/common/patches.rs"]
mod patches;

use patches::{PATCHES, patch};
use phex::offset::{OffsetOptions, edge_gauss_image};
use phex::pipeline::Method;
use phex::{Boundary, MeshOptions, MeshRun, PanelSize, Silent, mesh_surface};
use phex_mesh::measure::deviation;
use phex_mesh::{HexMesh, measure};
use std::error::Error;

/// Cells along a side of a patch.
const CELLS: u32 = 120;

fn main() -> Result<(), Box<dyn Error>> {
    let counts: Vec<usize> = std::env::args()
        .skip(1)
        .map(|a| a.parse())
        .collect::<Result<_, _>>()?;
    println!(
        "| patch | panels | planarity | clearance | deviation max, rms (%) | edge offsets | sound | order |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, size, _, point) in PATCHES {
        let mut rows = Vec::new();
        for &count in &counts {
            let options = MeshOptions {
                size: PanelSize::Panels(count),
                method: Method::Koebe,
                boundary: Boundary::Whole,
                ..Default::default()
            };
            let run = mesh_surface(&patch(CELLS, size, point), &options, &Silent)?;
            rows.push(Row::of(&run)?);
        }
        let all = |f: &dyn Fn(&Row) -> String| rows.iter().map(f).collect::<Vec<_>>().join(", ");
        let order = match (rows.first(), rows.last()) {
            (Some(a), Some(b)) => 2.0 * (a.rms / b.rms).ln() / (b.panels / a.panels).ln(),
            _ => f64::NAN,
        };
        println!(
            "| {name} | {} | {:.0e} | {} | {} | {:.0e} | {} | {order:.1} |",
            all(&|r| r.panels.to_string()),
            rows.iter().map(|r| r.planarity).fold(0.0, f64::max),
            all(&|r| format!("{:.3}", r.clearance)),
            all(&|r| format!("{:.3} {:.4}", 100.0 * r.max, 100.0 * r.rms)),
            rows.iter().map(|r| r.edges).fold(0.0, f64::max),
            all(&|r| r.sound.to_string()),
        );
    }
    Ok(())
}

/// What one mesh has.
struct Row {
    panels: f64,
    /// Mean edges.
    planarity: f64,
    /// Mean edges.
    clearance: f64,
    /// Largest deviation over the diagonal.
    max: f64,
    /// Its root mean square.
    rms: f64,
    /// Largest error of an edge of an offset over the diagonal.
    edges: f64,
    sound: bool,
}

impl Row {
    fn of(run: &MeshRun) -> Result<Self, Box<dyn Error>> {
        let beyond = run.beyond.as_ref().map_or(&run.target, |b| &b.smooth);
        let (measures, off) = (measure(&run.mesh), deviation(&run.mesh, beyond));
        let image = edge_gauss_image(&run.mesh, &OffsetOptions::default())?.image;
        let shares = [0.01, 0.003, -0.003, -0.01].into_iter();
        let errors = shares.map(|share| {
            let distance = share * run.mesh.diagonal();
            worst_of_edges(&run.mesh, &image.offset(&run.mesh, distance), distance)
        });
        Ok(Self {
            panels: measures.faces as f64,
            planarity: measures.planarity.max,
            clearance: measures.clearance.min,
            max: off.deviation_max,
            rms: off.deviation_rms,
            edges: errors.fold(0.0, f64::max),
            sound: run.is_sound() && measures.face_sizes.keys().all(|n| *n == 6),
        })
    }
}

/// Distance and direction of each pair of corresponding edges, over the diagonal.
fn worst_of_edges(mesh: &HexMesh, moved: &HexMesh, distance: f64) -> f64 {
    let t = mesh.topology();
    let off = |e| {
        let [a, b] = t.edge_vertices(e);
        let [u, w] = [mesh, moved].map(|m| (m.position(b) - m.position(a)).normalize());
        let step = moved.position(a) - mesh.position(a);
        let away = (step.cross(&u).norm() - distance.abs()).abs();
        away.max(u.cross(&w).norm() * mesh.mean_edge())
    };
    t.edges().map(off).fold(0.0, f64::max) / mesh.diagonal()
}
