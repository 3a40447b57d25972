//! Time of the smooth target: subdivision and corrections.

mod common;

use divan::Bencher;
use phex::smooth_surface::smooth_target;

fn main() {
    divan::main();
}

#[divan::bench(args = [300, 1000], sample_count = 5, sample_size = 1)]
fn torus(bencher: Bencher, panels: usize) {
    let surface = common::normalised(&common::shape("torus"));
    bencher.bench_local(|| smooth_target(&surface, 25 * panels, &Default::default()));
}
