//! Time of the optimiser from a layout to planar panels; before it, iterations and factorisations.

mod common;

use common::{CASES, Prepared};
use divan::Bencher;
use phex::Silent;
use phex::layout::Layout;
use phex::optimise::{Optimised, SurfaceTarget, optimise};

fn main() {
    for case in CASES {
        let prepared = Prepared::new(case);
        let run = planar(&prepared, &layout(&prepared)).run;
        println!(
            "{case:?}: {:?}, {} iterations, {} factorisations, {:?}",
            run.start, run.iterations, run.factorisations, run.status
        );
    }
    divan::main();
}

fn layout(prepared: &Prepared) -> Layout {
    prepared.panelling(&prepared.seeds().seeds)
}

fn planar(prepared: &Prepared, layout: &Layout) -> Optimised {
    let target = SurfaceTarget::new(&prepared.surface);
    optimise(layout, &target, &Default::default(), &Silent).expect("the layout is regular")
}

#[divan::bench(args = CASES, sample_count = 3, sample_size = 1)]
fn layout_to_planar(bencher: Bencher, case: (&'static str, usize)) {
    let prepared = Prepared::new(case);
    let layout = layout(&prepared);
    bencher.bench_local(|| planar(&prepared, &layout));
}
