//! What this program and this machine have.

use crate::html;
use crate::summary::SummaryTable;
use phex::report::SCHEMA_VERSION;

/// Versions, processor, memory, and what this build has inside.
pub fn facts() -> SummaryTable {
    let mut table = SummaryTable::default();
    let (arch, system) = (std::env::consts::ARCH, std::env::consts::OS);
    let version = env!("CARGO_PKG_VERSION");
    table.row(
        "phex",
        format!("{version}, reports of version {SCHEMA_VERSION}"),
    );
    let checked = cfg!(debug_assertions);
    let built = if checked {
        ", with assertions (slower)"
    } else {
        ""
    };
    table.row("built for", format!("{arch} {system}{built}"));
    table.row("processor", processor());
    table.row("memory", memory());
    let view = html::without_view();
    table.row("viewer", view.unwrap_or_else(|| "inside".to_owned()));
    let studio = cfg!(feature = "studio");
    table.row(
        "studio",
        if studio {
            "inside"
        } else {
            "left out of this build"
        },
    );
    table
}

/// Cores, and the instructions that matrix kernels choose by: results may differ between two sets.
fn processor() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let cores = format!("{cores} threads at once");
    #[cfg(target_arch = "x86_64")]
    {
        let sets = [
            ("AVX2", std::is_x86_feature_detected!("avx2")),
            ("FMA", std::is_x86_feature_detected!("fma")),
            ("AVX-512", std::is_x86_feature_detected!("avx512f")),
        ];
        let has: Vec<&str> = sets.iter().filter(|s| s.1).map(|s| s.0).collect();
        format!("{cores}; {}", has.join(", "))
    }
    #[cfg(not(target_arch = "x86_64"))]
    cores
}

/// Memory, where the system tells it in a file.
fn memory() -> String {
    let told = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let of = |key: &str| {
        let line = told.lines().find_map(|l| l.strip_prefix(key))?;
        let kilobytes: f64 = line.split_whitespace().next()?.parse().ok()?;
        Some(kilobytes * 1024.0 / 1e9)
    };
    match (of("MemAvailable:"), of("MemTotal:")) {
        (Some(free), Some(all)) => format!(
            "{free:.1} GB free of {all:.1} GB; 10,000 panels take about 1 GB, 100,000 about 9 GB"
        ),
        _ => "not told by this system".to_owned(),
    }
}
