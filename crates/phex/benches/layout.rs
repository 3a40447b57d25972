//! Time of the lattice (seeds), and of cells and panels; before them, what the lattice had to do.

mod common;

use common::{CASES, Prepared};
use divan::Bencher;

fn main() {
    for case in CASES {
        let placed = Prepared::new(case).seeds();
        println!(
            "{case:?}: {} panels, {:?}",
            placed.seeds.len(),
            placed.statistics
        );
    }
    divan::main();
}

#[divan::bench(args = CASES, sample_count = 3, sample_size = 1)]
fn lattice(bencher: Bencher, case: (&'static str, usize)) {
    let prepared = Prepared::new(case);
    bencher.bench_local(|| prepared.seeds());
}

#[divan::bench(args = CASES, sample_count = 5, sample_size = 1)]
fn cells(bencher: Bencher, case: (&'static str, usize)) {
    let prepared = Prepared::new(case);
    let seeds = prepared.seeds().seeds;
    bencher.bench_local(|| prepared.panelling(&seeds));
}
