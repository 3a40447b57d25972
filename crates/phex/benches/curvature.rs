//! Time of the curvature of a surface with 25 vertices a panel.

mod common;

use common::{CASES, panel_length, target};
use divan::Bencher;
use phex::curvature::curvature;

fn main() {
    divan::main();
}

#[divan::bench(args = CASES, sample_count = 5, sample_size = 1)]
fn jets(bencher: Bencher, case: (&'static str, usize)) {
    let target = target(case.0, case.1);
    let length = panel_length(target.finest(), case.1);
    bencher.bench_local(|| curvature(target.finest(), length, &Default::default()));
}
