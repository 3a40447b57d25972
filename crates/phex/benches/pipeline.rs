//! Time of the whole flow; before it, where the time of one run goes, and what it took.

mod common;

use common::{CASES, shape};
use divan::Bencher;
use phex::{MeshOptions, MeshRun, PanelSize, Silent, mesh_surface};

fn main() {
    for case in CASES {
        print(case, &mesh(case));
    }
    divan::main();
}

fn mesh((name, panels): (&str, usize)) -> MeshRun {
    let options = MeshOptions {
        size: PanelSize::Panels(panels),
        ..Default::default()
    };
    mesh_surface(&shape(name), &options, &Silent).expect("built-in shapes can be meshed")
}

fn print(case: (&str, usize), run: &MeshRun) {
    let total: f64 = run.stages.iter().map(|s| s.seconds).sum();
    println!(
        "{case:?}: {total:.2} s, {} panels, {} factorisations, {} local changes, sound: {}",
        run.mesh.topology().n_faces(),
        run.statistics.factorisations,
        run.statistics.search.as_ref().map_or(0, |s| s.kept),
        run.is_sound()
    );
    for stage in &run.stages {
        let share = 100.0 * stage.seconds / total;
        println!("  {:12} {:6.2} s {share:5.1} %", stage.stage, stage.seconds);
    }
}

#[divan::bench(args = CASES, sample_count = 3, sample_size = 1)]
fn surface_to_panels(bencher: Bencher, case: (&'static str, usize)) {
    bencher.bench_local(|| mesh(case));
}
