//! `docs/performance.md`: what runs cost, measured on this machine.

use crate::measured::timed;
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;
use wait4::ResUse;

/// Where surfaces and meshes go.
const WORK: &str = "out/performance";
/// Times that a run is repeated; the shortest counts.
const REPEATS: usize = 3;
/// Seconds after which a run is not repeated.
const LONG: f64 = 20.0;

/// A run of the table: its surface, its options, and whether it has one thread.
struct TimedRun {
    surface: &'static str,
    triangles: Option<usize>,
    options: &'static str,
    alone: bool,
}

const fn run(
    surface: &'static str,
    triangles: Option<usize>,
    options: &'static str,
    alone: bool,
) -> TimedRun {
    TimedRun {
        surface,
        triangles,
        options,
        alone,
    }
}

/// First pictures, on all cores.
const FIRST: [TimedRun; 4] = [
    run("roof", None, "-n 200 --until layout --effort draft", false),
    run("roof", None, "-n 200 --effort draft", false),
    run("roof", None, "-n 200", false),
    run("roof", None, "-n 500", false),
];
/// Growth with the number of panels, on one core.
const GROWTH: [TimedRun; 9] = [
    run("wave", Some(100_000), "-n 1000", true),
    run("wave", Some(100_000), "-n 4000", true),
    run("wave", Some(100_000), "-n 16000", true),
    run("b-spline", Some(100_000), "-n 1000", true),
    run("b-spline", Some(100_000), "-n 4000", true),
    run("b-spline", Some(100_000), "-n 16000", true),
    run("torus", Some(100_000), "-n 1000", true),
    run("torus", Some(100_000), "-n 4000", true),
    run("torus", Some(100_000), "-n 16000", true),
];
/// The largest, made where `--large` asks for it.
const LARGE: [TimedRun; 1] = [run("wave", Some(100_000), "-n 100000", true)];
/// Growth with the number of triangles.
const FINE: [TimedRun; 3] = [
    run("wave", Some(10_000), "-n 1000", true),
    run("wave", Some(100_000), "-n 1000", true),
    run("wave", Some(1_000_000), "-n 1000", true),
];

/// What a run took and made.
struct Cost {
    wall: f64,
    cpu: f64,
    megabytes: f64,
    verdict: String,
    panels: u64,
    stages: String,
}

/// Measures everything, and writes the document.
pub fn performance(root: &Path, words: &[&str]) -> Result<(), String> {
    let large = match words {
        [] => false,
        ["--large"] => true,
        _ => return Err("usage: cargo xtask performance [--large]".to_owned()),
    };
    crate::cargo(root, &["build", "--package", "phex-cli", "--release"])?;
    let bench = Bench {
        root,
        program: root.join("target/release/phex"),
    };
    std::fs::create_dir_all(root.join(WORK)).map_err(|e| format!("{WORK}: {e}"))?;
    let mut text = HEAD.to_owned();
    text += &bench.table("First pictures, on all cores", &FIRST)?;
    let growth: Vec<&TimedRun> = match large {
        true => GROWTH.iter().chain(&LARGE).collect(),
        false => GROWTH.iter().collect(),
    };
    text += &bench.table_of("More panels, on one core", &growth)?;
    text += &bench.table("Finer inputs, on one core", &FINE)?;
    text += TAIL;
    crate::write(&root.join("docs/performance.md"), &text)
}

const HEAD: &str = "# What runs cost

`cargo xtask performance` writes this file; `--large` adds the run with 100,000 panels, which takes six to eight minutes and up to 5.2 GB. Seconds are those of one shared machine with two
cores, the shortest of three runs: compare rows, not days.
";

const TAIL: &str = "
Inputs with more than 32 vertices a panel are laid out on fewer of them (`smooth_surface/coarsen`); panels are kept close to, and compared with, all of the input. Curvature, directions, lattice and cells then cost what
the panels are; what still grows with the triangles is reading, closest points, and the copy of the surface that is reported.
";

struct Bench<'a> {
    root: &'a Path,
    program: PathBuf,
}

impl Bench<'_> {
    fn table(&self, title: &str, runs: &[TimedRun]) -> Result<String, String> {
        self.table_of(title, &runs.iter().collect::<Vec<_>>())
    }

    fn table_of(&self, title: &str, runs: &[&TimedRun]) -> Result<String, String> {
        let mut text = format!(
            "\n## {title}\n\n| surface | triangles | options | panels | verdict | wall s | CPU s | MB | stages, wall s |\n|---|---|---|---|---|---|---|---|---|\n"
        );
        for run in runs {
            let cost = self.cost(run)?;
            let triangles = run.triangles.map_or("-".to_owned(), |n| n.to_string());
            let _ = writeln!(
                text,
                "| {} | {triangles} | `{}` | {} | {} | {:.2} | {:.2} | {:.0} | {} |",
                run.surface,
                run.options,
                cost.panels,
                cost.verdict,
                cost.wall,
                cost.cpu,
                cost.megabytes,
                cost.stages
            );
            println!("{} {}: {:.2} s", run.surface, run.options, cost.cpu);
        }
        Ok(text)
    }

    fn surface(&self, run: &TimedRun) -> Result<PathBuf, String> {
        let Some(triangles) = run.triangles else {
            return Ok(self.root.join(format!("data/{}.obj", run.surface)));
        };
        let path = self.root.join(WORK);
        let path = path.join(format!("{}-{triangles}.obj", run.surface));
        if !path.exists() {
            let mut command = Command::new(&self.program);
            command.args(["shape", run.surface, "-q", "--triangles"]);
            crate::succeed(command.arg(triangles.to_string()).arg("-o").arg(&path))?;
        }
        Ok(path)
    }

    /// The cheapest of a few repeats.
    fn cost(&self, run: &TimedRun) -> Result<Cost, String> {
        let surface = self.surface(run)?;
        let mut best: Option<Cost> = None;
        for _ in 0..REPEATS {
            let cost = self.once(run, &surface)?;
            let long = cost.wall > LONG;
            if best.as_ref().is_none_or(|b| cost.wall < b.wall) {
                best = Some(cost);
            }
            if long {
                break;
            }
        }
        best.ok_or_else(|| "nothing was run".to_owned())
    }

    fn once(&self, run: &TimedRun, surface: &Path) -> Result<Cost, String> {
        let work = self.root.join(WORK);
        let report = work.join("report.json");
        let mut command = Command::new(&self.program);
        command.arg("mesh").arg(surface);
        command.args(run.options.split_whitespace()).arg("-q");
        if run.alone {
            command.args(["-t", "1"]);
        }
        command.arg("-o").arg(work.join("mesh.obj"));
        command.arg("--report").arg(&report);
        let start = std::time::Instant::now();
        let (code, used) = timed(&mut command)?;
        let wall = start.elapsed().as_secs_f64();
        let text = crate::read(&report)?;
        let told: Value = serde_json::from_str(&text).map_err(|e| format!("the report: {e}"))?;
        let ending = match (run.options.contains("--until"), code) {
            (true, 0) => "layout".to_owned(),
            _ => told["verdict"].as_str().unwrap_or("none").to_owned(),
        };
        Ok(cost_of(&used, wall, ending, &told))
    }
}

fn cost_of(used: &ResUse, wall: f64, verdict: String, report: &Value) -> Cost {
    let cpu = used.rusage.utime + used.rusage.stime;
    let stages = report["stages"].as_array();
    let stage = |s: &Value| Some((s["stage"].as_str()?.to_owned(), s["seconds"].as_f64()?));
    let stages = stages.into_iter().flatten().filter_map(stage);
    let told = stages.filter(|s| s.1 >= 0.02 * wall);
    let told: Vec<String> = told.map(|(name, s)| format!("{name} {s:.2}")).collect();
    Cost {
        wall,
        cpu: cpu.as_secs_f64(),
        megabytes: used.rusage.maxrss as f64 / 1e6,
        verdict,
        panels: report["measures"]["faces"].as_u64().unwrap_or(0),
        stages: told.join(", "),
    }
}
