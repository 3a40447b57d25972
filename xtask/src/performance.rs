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

/// Where the surface of a run comes from.
#[derive(Clone, Copy)]
enum TimedSurface {
    /// A file of the repository's `data`.
    Kept(&'static str),
    /// A shape of the program, of so many triangles.
    Shape(&'static str, usize),
    /// A file in the folder of models, where there is one.
    Model(&'static str),
}
use TimedSurface::{Kept, Model, Shape};

/// A run of the table: its surface, its options, and whether it has one thread.
struct TimedRun {
    surface: TimedSurface,
    options: &'static str,
    alone: bool,
}

const fn on_all_cores(surface: TimedSurface, options: &'static str) -> TimedRun {
    TimedRun {
        surface,
        options,
        alone: false,
    }
}

const fn alone(surface: TimedSurface, options: &'static str) -> TimedRun {
    TimedRun {
        surface,
        options,
        alone: true,
    }
}

/// First pictures, on all cores.
const FIRST: [TimedRun; 4] = [
    on_all_cores(Kept("roof"), "-n 200 --until layout --effort draft"),
    on_all_cores(Kept("roof"), "-n 200 --effort draft"),
    on_all_cores(Kept("roof"), "-n 200"),
    on_all_cores(Kept("roof"), "-n 500"),
];
const WAVE: TimedSurface = Shape("wave", 100_000);
const METRO: TimedSurface = Model("phcpf/metro.off");
const TORUS: TimedSurface = Shape("torus", 100_000);
const ELLIPSOID: TimedSurface = Shape("ellipsoid", 100_000);
/// Growth with the number of panels, on one core.
const GROWTH: [TimedRun; 12] = [
    alone(WAVE, "-n 1000"),
    alone(WAVE, "-n 4000"),
    alone(WAVE, "-n 16000"),
    alone(METRO, "-n 1000"),
    alone(METRO, "-n 4000"),
    alone(METRO, "-n 16000"),
    alone(TORUS, "-n 1000"),
    alone(TORUS, "-n 4000"),
    alone(TORUS, "-n 16000"),
    alone(ELLIPSOID, "-n 1000"),
    alone(ELLIPSOID, "-n 4000"),
    alone(ELLIPSOID, "-n 16000"),
];
/// The largest, made where `--large` asks for them.
const LARGE: [TimedRun; 4] = [
    alone(WAVE, "-n 100000"),
    alone(METRO, "-n 100000"),
    alone(TORUS, "-n 100000"),
    alone(ELLIPSOID, "-n 100000"),
];
/// Growth with the number of triangles.
const FINE: [TimedRun; 3] = [
    alone(Shape("wave", 10_000), "-n 1000"),
    alone(Shape("wave", 100_000), "-n 1000"),
    alone(Shape("wave", 1_000_000), "-n 1000"),
];

/// Two runs one after the other, each `PANELS:DEGREES`, on a surface that is kept in between.
struct KeptRuns {
    surface: TimedSurface,
    first: &'static str,
    second: &'static str,
}

const fn kept(surface: TimedSurface, first: &'static str, second: &'static str) -> KeptRuns {
    KeptRuns {
        surface,
        first,
        second,
    }
}

/// What a session spares.
const KEPT: [KeptRuns; 6] = [
    kept(Kept("roof"), "500:0", "500:15"),
    kept(Kept("roof"), "500:0", "600:0"),
    kept(Shape("wave", 100_000), "1000:0", "1000:15"),
    kept(Shape("wave", 100_000), "1000:0", "1200:0"),
    kept(Shape("wave", 1_000_000), "1000:0", "1000:15"),
    kept(Shape("wave", 1_000_000), "1000:0", "1200:0"),
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

/// What the command is asked for.
struct Wanted {
    large: bool,
    models: PathBuf,
}

impl Wanted {
    fn of(root: &Path, words: &[&str]) -> Option<Self> {
        let mut wanted = Self {
            large: false,
            models: root.join("../shared/models"),
        };
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--large" => wanted.large = true,
                "--models" => wanted.models = words.next()?.into(),
                _ => return None,
            }
        }
        Some(wanted)
    }
}

/// Measures everything, and writes the document.
pub fn performance(root: &Path, words: &[&str]) -> Result<(), String> {
    let usage = "usage: cargo xtask performance [--large] [--models FOLDER]";
    let wanted = Wanted::of(root, words).ok_or_else(|| usage.to_owned())?;
    crate::cargo(root, &["build", "--package", "phex-cli", "--release"])?;
    crate::cargo(
        root,
        &[
            "build",
            "--package",
            "phex",
            "--example",
            SESSION,
            "--release",
        ],
    )?;
    let bench = Bench {
        root,
        program: root.join("target/release/phex"),
        models: wanted.models,
    };
    std::fs::create_dir_all(root.join(WORK)).map_err(|e| format!("{WORK}: {e}"))?;
    let mut text = HEAD.to_owned();
    text += &bench.table("First pictures, on all cores", FIRST.iter())?;
    let large = LARGE.iter().filter(|_| wanted.large);
    text += &bench.table("More panels, on one core", GROWTH.iter().chain(large))?;
    text += &bench.table("Finer inputs, on one core", FINE.iter())?;
    text += TAIL;
    text += &bench.kept_runs()?;
    crate::write(&root.join("docs/performance.md"), &text)
}

const HEAD: &str = "# What runs cost

`cargo xtask performance` writes this file; `--large` adds the runs with 100,000 panels, which take five to ten minutes each and up to 6 GB; rows of models that are not in the repository are made where their folder is there
(`--models`). Seconds are those of one shared machine with two cores, the shortest of three runs: compare rows, not days.
";

const TAIL: &str = "
Inputs with more than 32 vertices a panel, those in long triangles, and those with large ones at creases or among many small ones (`smooth_surface/elongated`), are laid out on seven of them a panel (`smooth_surface/coarsen`), which are refined once for cells; panels are kept close to, and compared with, all of the input. Curvature, directions, lattice and cells then cost what
the panels are; what still grows with the triangles is reading, closest points, and the copy of the surface that is reported.
";

const KEPT_HEAD: &str = "
## A surface that is kept, on one core

Two runs one after the other, with so many panels and rows turned by so many degrees: CPU seconds of the second one alone, and of the same with a `Session` that has made the first (`crates/phex/examples/session_runs.rs`,
less what reading takes).

| surface | triangles | first | second | fresh, s | kept, s | kept / fresh |
|---|---|---|---|---|---|---|
";

/// The example that makes runs with a session.
const SESSION: &str = "session_runs";

struct Bench<'a> {
    root: &'a Path,
    program: PathBuf,
    models: PathBuf,
}

impl TimedSurface {
    /// Name and number of triangles, for the table.
    fn told(self) -> (&'static str, String) {
        match self {
            Shape(name, triangles) => (name, triangles.to_string()),
            Kept(name) | Model(name) => (name, "-".to_owned()),
        }
    }
}

impl Bench<'_> {
    fn table<'r>(
        &self,
        title: &str,
        runs: impl Iterator<Item = &'r TimedRun>,
    ) -> Result<String, String> {
        let mut text = format!(
            "\n## {title}\n\n| surface | triangles | options | panels | verdict | wall s | CPU s | MB | stages, wall s |\n|---|---|---|---|---|---|---|---|---|\n"
        );
        for run in runs {
            let Some(surface) = self.surface(run.surface)? else {
                continue;
            };
            let cost = self.cost(run, &surface)?;
            let (name, triangles) = run.surface.told();
            let _ = writeln!(
                text,
                "| {name} | {triangles} | `{}` | {} | {} | {:.2} | {:.2} | {:.0} | {} |",
                run.options,
                cost.panels,
                cost.verdict,
                cost.wall,
                cost.cpu,
                cost.megabytes,
                cost.stages
            );
            println!("{name} {}: {:.2} s", run.options, cost.cpu);
        }
        Ok(text)
    }

    fn kept_runs(&self) -> Result<String, String> {
        let mut text = KEPT_HEAD.to_owned();
        for runs in &KEPT {
            let Some(surface) = self.surface(runs.surface)? else {
                continue;
            };
            let cpu = |runs: &[&str]| self.session_seconds(&surface, runs);
            let fresh = cpu(&[runs.second])? - cpu(&[])?;
            let kept = cpu(&[runs.first, runs.second])? - cpu(&[runs.first])?;
            let (name, triangles) = runs.surface.told();
            let _ = writeln!(
                text,
                "| {name} | {triangles} | `{}` | `{}` | {fresh:.2} | {kept:.2} | {:.2} |",
                runs.first,
                runs.second,
                kept / fresh
            );
            println!("{name} {} {}: {:.2}", runs.first, runs.second, kept / fresh);
        }
        Ok(text)
    }

    /// CPU seconds of some runs with one session, the least of a few times.
    fn session_seconds(&self, surface: &Path, runs: &[&str]) -> Result<f64, String> {
        let mut least = f64::INFINITY;
        for _ in 0..REPEATS {
            let program = self.root.join("target/release/examples").join(SESSION);
            let mut command = Command::new(program);
            command.arg(surface).args(runs);
            command.env("RAYON_NUM_THREADS", "1");
            let (code, used) = timed(&mut command)?;
            if code != 0 {
                return Err(format!("{SESSION} ended with {code}"));
            }
            least = least.min(cpu_seconds(&used));
        }
        Ok(least)
    }

    /// The file of a surface, written first where the program makes it; `None` where the model is
    /// not there.
    fn surface(&self, surface: TimedSurface) -> Result<Option<PathBuf>, String> {
        let (name, triangles) = match surface {
            Kept(name) => return Ok(Some(self.root.join(format!("data/{name}.obj")))),
            Model(name) => return Ok(Some(self.models.join(name)).filter(|p| p.is_file())),
            Shape(name, triangles) => (name, triangles),
        };
        let path = self.root.join(WORK);
        let path = path.join(format!("{name}-{triangles}.obj"));
        if !path.exists() {
            let mut command = Command::new(&self.program);
            command.args(["shape", name, "-q", "--triangles"]);
            crate::succeed(command.arg(triangles.to_string()).arg("-o").arg(&path))?;
        }
        Ok(Some(path))
    }

    /// The cheapest of a few repeats.
    fn cost(&self, run: &TimedRun, surface: &Path) -> Result<Cost, String> {
        let mut best: Option<Cost> = None;
        for _ in 0..REPEATS {
            let cost = self.once(run, surface)?;
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

fn cpu_seconds(used: &ResUse) -> f64 {
    (used.rusage.utime + used.rusage.stime).as_secs_f64()
}

fn cost_of(used: &ResUse, wall: f64, verdict: String, report: &Value) -> Cost {
    let stages = report["stages"].as_array();
    let stage = |s: &Value| Some((s["stage"].as_str()?.to_owned(), s["seconds"].as_f64()?));
    let stages = stages.into_iter().flatten().filter_map(stage);
    let told = stages.filter(|s| s.1 >= 0.02 * wall);
    let told: Vec<String> = told.map(|(name, s)| format!("{name} {s:.2}")).collect();
    Cost {
        wall,
        cpu: cpu_seconds(used),
        megabytes: used.rusage.maxrss as f64 / 1e6,
        verdict,
        panels: report["measures"]["faces"].as_u64().unwrap_or(0),
        stages: told.join(", "),
    }
}
