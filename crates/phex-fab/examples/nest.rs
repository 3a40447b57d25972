//! Sheet use of a mesh: `cargo run --release -p phex-fab --example nest -- MESH UNIT_MM WIDTH HEIGHT SPACING`.
use phex_fab::{FabOptions, PanelIds, fabricate, valid_mesh};
use phex_mesh::HexMesh;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let a: Vec<String> = std::env::args().collect();
    let n = |k: usize| a[k].parse::<f64>().unwrap();
    let mesh = HexMesh::read(a[1].as_ref())?;
    let ids = PanelIds::new(&mesh);
    let options = FabOptions {
        unit_mm: n(2),
        sheet_mm: [n(3), n(4)],
        spacing_mm: n(5),
        thickness: 1e-4 * mesh.mean_edge(),
        ..Default::default()
    };
    let mesh = valid_mesh(mesh, &ids, &options.validity)?;
    let start = std::time::Instant::now();
    let fab = fabricate(mesh, ids, options.clone())?;
    let area: f64 = fab.plates.iter().map(|p| p.area()).sum();
    let last = fab.sheets.last().unwrap();
    let reach = last
        .iter()
        .flat_map(|p| p.apply(&fab.plates[p.plate].top))
        .map(|p| p.x)
        .fold(0.0, f64::max);
    let sheet = options.sheet_mm[0] * options.sheet_mm[1];
    let full = (fab.sheets.len() - 1) as f64 * sheet;
    println!(
        "{} sheets, use {:.1} %, without the last offcut {:.1} %, {:.1} s",
        fab.sheets.len(),
        100.0 * area / (full + sheet),
        100.0 * area / (full + (reach + options.spacing_mm) * options.sheet_mm[1]),
        start.elapsed().as_secs_f64()
    );
    for k in 0..fab.sheets.len().min(3) {
        std::fs::write(
            format!("/tmp/wfab/s{k}.svg"),
            phex_fab::drawing::svg(&phex_fab::drawing::sheet(&fab, k, &fab.texts)),
        )?;
    }
    Ok(())
}
