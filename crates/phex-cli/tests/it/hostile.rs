//! Hostile surfaces through `phex mesh`, with all methods and at all boundaries: each run ends in
//! time with a documented exit code, and what passes is right by the judge of `phex-fuzz`, which
//! shares no code with the program.

// Comparisons are written so that a NaN is a fault.
#![allow(clippy::neg_cmp_op_on_partial_ord)]
use crate::common::Workshop;
use phex_fuzz::referee::{deviation, faults, kind, torn};
use phex_fuzz::{HostileSurface, RawMesh, hostile_surfaces};
use std::collections::BTreeMap;
use std::process::{Child, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

const METHODS: [&str; 9] = [
    "tangent-planes",
    "brick-wall",
    "power-diagram",
    "projective-dual",
    "dual-subdivision",
    "support-function",
    "parallel",
    "koebe",
    "best",
];
/// Those that refuse surfaces by their curvature, and can be made to try.
const OF_CURVATURE: [&str; 4] = [
    "projective-dual",
    "dual-subdivision",
    "support-function",
    "parallel",
];
const BOUNDARIES: [&str; 3] = ["snap", "whole", "clip"];
/// What a run is allowed, and when it is called a hang.
const TIME_LIMIT: Duration = Duration::from_secs(3);
const PATIENCE: Duration = Duration::from_secs(60);
/// Largest distance of what passes to the surface's facets, over the diagonal: the program holds
/// panels to 0.005 of the smooth surface through the vertices.
const DEVIATION: f64 = 0.02;

/// One run of the program on a surface.
struct Attack<'a> {
    surface: &'a HostileSurface,
    arguments: String,
}

/// How it ended.
struct AttackEnding {
    code: Option<i32>,
    time: Duration,
    said: String,
    table: String,
    complaints: Vec<String>,
}

/// One of ten surfaces; all of them by `cargo xtask hostile`.
#[test]
fn some_hostile_surfaces_end_honestly() {
    attack_all(10);
}

#[test]
#[ignore = "minutes: cargo xtask hostile"]
fn all_hostile_surfaces_end_honestly() {
    attack_all(1);
}

fn attack_all(step: usize) {
    let only = std::env::var("PHEX_HOSTILE").unwrap_or_default();
    let surfaces = hostile_surfaces();
    let chosen = surfaces.iter().enumerate().step_by(step);
    let chosen = chosen.filter(|(_, s)| s.name.contains(&only));
    let attacks: Vec<Attack> = chosen.flat_map(|(k, s)| attacks(k, s)).collect();
    let began = Instant::now();
    let endings = in_parallel(&attacks);
    let summary = summary(&endings, began.elapsed());
    println!("{summary}");
    let complaints: Vec<String> = attacks
        .iter()
        .zip(&endings)
        .filter(|(_, e)| !e.complaints.is_empty())
        .map(|(a, e)| format!("phex {}\n  {}", a.command(), e.complaints.join("\n  ")))
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// A lattice, and another method, at different boundaries.
fn attacks(k: usize, surface: &HostileSurface) -> [Attack<'_>; 2] {
    let panels = 20 + 10 * (k % 5);
    let effort = if k.is_multiple_of(3) {
        "draft"
    } else {
        "normal"
    };
    let boundary = BOUNDARIES[k % 3];
    let lattice = format!("-n {panels} --effort {effort} --boundary {boundary}");
    let (method, boundary) = (METHODS[k % 9], BOUNDARIES[(k / 3 + 1) % 3]);
    let mut other = format!("-n {panels} --method {method}");
    if OF_CURVATURE.contains(&method) {
        other += " --any-domain";
    }
    if !["koebe", "power-diagram"].contains(&method) {
        other += &format!(" --boundary {boundary}");
    }
    [lattice, other].map(|arguments| Attack { surface, arguments })
}

fn in_parallel(attacks: &[Attack]) -> Vec<AttackEnding> {
    let (next, endings) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
    let work = || {
        while let Some((k, attack)) = take(&next, attacks) {
            let ending = attack.run();
            endings.lock().expect("no worker panics").insert(k, ending);
        }
    };
    std::thread::scope(|scope| {
        let workers = std::thread::available_parallelism().map_or(2, usize::from);
        (0..workers).for_each(|_| drop(scope.spawn(work)));
    });
    let endings = endings.into_inner().expect("no worker panics");
    endings.into_values().collect()
}

fn take<'a, T>(next: &AtomicUsize, all: &'a [T]) -> Option<(usize, &'a T)> {
    let k = next.fetch_add(1, Ordering::Relaxed);
    Some((k, all.get(k)?))
}

fn summary(endings: &[AttackEnding], time: Duration) -> String {
    let mut codes: BTreeMap<String, usize> = BTreeMap::new();
    for ending in endings {
        let code = ending.code.map_or("none".to_owned(), |c| c.to_string());
        *codes.entry(code).or_default() += 1;
    }
    let longest = endings.iter().map(|e| e.time).max().unwrap_or_default();
    let wrong = endings.iter().filter(|e| !e.complaints.is_empty()).count();
    format!(
        "{} runs in {:.0} s, the longest {:.1} s, exit codes {codes:?}, {wrong} with complaints",
        endings.len(),
        time.as_secs_f64(),
        longest.as_secs_f64()
    )
}

impl Attack<'_> {
    fn command(&self) -> String {
        let limit = TIME_LIMIT.as_secs();
        let Self { surface, arguments } = self;
        format!(
            "mesh {} -o out.obj {arguments} --threads 1 --time-limit {limit}s",
            surface.name
        )
    }

    fn run(&self) -> AttackEnding {
        let shop = Workshop::new();
        shop.write(&self.surface.name, &self.surface.bytes);
        shop.write("out.obj", "precious");
        let log = |name: &str| std::fs::File::create(shop.path(name)).expect("a writable folder");
        let mut command = shop.command(&self.command());
        command.stdout(log("stdout")).stderr(log("stderr"));
        let began = Instant::now();
        let mut child = command.stdin(Stdio::null()).spawn().expect("it starts");
        let code = wait(&mut child, began);
        let time = began.elapsed();
        let [said, table] =
            ["stderr", "stdout"].map(|name| String::from_utf8_lossy(&shop.read(name)).into_owned());
        let mut ending = AttackEnding {
            code,
            time,
            said,
            table,
            complaints: Vec::new(),
        };
        ending.complaints = self.complaints(&shop, &ending);
        if std::env::var_os("PHEX_HOSTILE_LOUD").is_some() {
            let said = ending.said.lines().last().unwrap_or_default();
            let seconds = time.as_secs_f64();
            println!("{code:?} {seconds:.1} s: {}: {said}", self.command());
            let complaints = ending.complaints.iter().take(3);
            complaints.for_each(|c| println!("  COMPLAINT {}: {c}", self.surface.name));
        }
        ending
    }

    fn complaints(&self, shop: &Workshop, ending: &AttackEnding) -> Vec<String> {
        let mut complaints = Vec::new();
        let written = shop.read("out.obj");
        match ending.code {
            Some(0) => complaints.extend(self.false_pass(&written)),
            Some(3) => complaints.extend(self.untold(&written, &ending.table)),
            Some(4 | 5) if written != b"precious" => complaints.push("it was written".to_owned()),
            Some(4 | 5) => {}
            other => complaints.push(format!("exit code {other:?}")),
        }
        if self.surface.refused && ending.code != Some(4) {
            complaints.push(format!("exit code {:?} of what is no surface", ending.code));
        }
        if ending.said.contains("panicked") {
            complaints.push(ending.said.clone());
        }
        let is_told = ending.said.contains("error: ") || ending.table.contains("FAILED");
        if matches!(ending.code, Some(4 | 5)) && !is_told {
            complaints.push(format!("no reason is given: {}", ending.said));
        }
        complaints
    }

    /// What is wrong with a mesh that is outside a tolerance, and is not in the table; some faults
    /// make a mesh invalid, and no table excuses them.
    fn untold(&self, obj: &[u8], table: &str) -> Vec<String> {
        let measured = [
            ("planarity", "planarity"),
            ("clearance", "clearance"),
            ("length", "edge_length"),
            ("folded", "folds"),
            // Of the surface itself, which is why the mesh is not invalid.
            ("passes through", "crossings"),
        ];
        let failed = |check: &str| {
            let mut lines = table.lines().filter(|l| l.starts_with("FAILED"));
            lines.any(|l| l.contains(&format!(" {check}:")))
        };
        let is_told = |fault: &String| {
            let mut kinds = measured.iter().filter(|(word, _)| fault.contains(word));
            kinds.any(|(_, check)| failed(check))
        };
        let mut faults = self.invalid(obj);
        faults.retain(|fault| !is_told(fault));
        faults
    }

    /// What is wrong with a mesh that is said to be valid.
    fn invalid(&self, obj: &[u8]) -> Vec<String> {
        match RawMesh::from_obj(&String::from_utf8_lossy(obj)) {
            Ok(mesh) => faults(&mesh),
            Err(line) => vec![format!("`{line}` in the mesh")],
        }
    }

    /// What is wrong with a mesh that is said to pass.
    fn false_pass(&self, obj: &[u8]) -> Vec<String> {
        let mut found = self.invalid(obj);
        let Ok(mesh) = RawMesh::from_obj(&String::from_utf8_lossy(obj)) else {
            return found;
        };
        let far = deviation(&mesh, &self.surface.mesh);
        if !(far <= DEVIATION) {
            found.push(format!("{far:.4} diagonals from the surface"));
        }
        let (of_mesh, of_surface) = (kind(&mesh), kind(&self.surface.mesh));
        if torn(&self.surface.mesh).is_empty() && of_mesh != of_surface {
            found.push(format!("{of_mesh:?} for {of_surface:?}"));
        }
        found
    }
}

/// The exit code; none for a run that is killed because it does not end.
fn wait(child: &mut Child, began: Instant) -> Option<i32> {
    loop {
        if let Some(status) = child.try_wait().expect("it can be waited for") {
            return status.code();
        }
        if began.elapsed() > PATIENCE {
            child.kill().expect("it can be killed");
            child.wait().expect("it can be waited for");
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}
