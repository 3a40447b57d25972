//! Time of metric and direction field: two fields of two factorisations each, and one for the
//! conformal factor.

mod common;

use common::{CASES, Prepared};
use divan::Bencher;
use phex::directions::directions;

fn main() {
    divan::main();
}

#[divan::bench(args = CASES, sample_count = 3, sample_size = 1)]
fn metric_and_field(bencher: Bencher, case: (&'static str, usize)) {
    let p = Prepared::new(case);
    bencher.bench_local(|| {
        directions(&p.surface, &p.curvature, p.length, &Default::default()).unwrap()
    });
}
