//! Everything that can happen to a command that writes: it is killed at any moment, or in the midst
//! of a file; the disc is full; memory ends; inputs and folders vanish. Each file is then the old
//! one or the new one, whole; the next run leaves nothing but what it makes; and a command that
//! could say so has said why.

#![cfg(target_os = "linux")]
use crate::common::Workshop;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// FilesBelow below a folder, by their names.
type FilesBelow = BTreeMap<String, Vec<u8>>;

/// What each command writes below `out`; `$` is another value in the run before.
const COMMANDS: [(&str, [&str; 2]); 17] = [
    ("shape torus -o out/t.obj --triangles $", ["600", "400"]),
    (
        "mesh dome.obj -o out/m.ply --report out/m.json --until layout -n $",
        ["20", "12"],
    ),
    (
        "planarize m.obj -o out/p.off --report out/p.json --planarity $",
        ["1e-9", "1e-8"],
    ),
    (
        "offset m.obj -o out --distance $ --solids",
        ["0.001", "0.002"],
    ),
    (
        "fab m.obj --planarity 1e-9 -o out --nest-effort 0 --thickness $",
        ["1mm", "2mm"],
    ),
    ("render m.obj -o out/m.png --size $", ["200x150", "100x80"]),
    (
        "report m.obj --html out/m.html --planarity $",
        ["1e-9", "1e-8"],
    ),
    ("convert $ out/m.glb", ["m.obj", "dome.obj"]),
    ("convert $ out/m.3mf", ["m.obj", "dome.obj"]),
    ("koebe m.obj -o out/k.obj --opening $", ["60", "50"]),
    (
        "parallel m.obj -o out/p.obj --basis out/b.csv --unit $",
        ["m", "mm"],
    ),
    ("dual m.obj -o out/d.obj --radius $", ["1", "2"]),
    (
        "subdivide m.obj -o out/s.obj --planarity $",
        ["1e-9", "1e-8"],
    ),
    (
        "power-diagram --goldberg $ -o out/g.obj --png out/g.png",
        ["1,1", "2,0"],
    ),
    ("dupin dome.obj -o out/d.obj --size $", ["0.1", "0.2"]),
    ("network dome.obj -o out/n.obj -n $", ["30", "20"]),
    ("sweep $ -o out", ["study.toml", "study.toml"]),
];

/// What happens to a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum InjectedFault {
    /// It is killed after a random time.
    Killed,
    /// It is killed by the system when a file grows to a random size.
    KilledInAFile,
    /// FilesBelow can't grow beyond a random size, as on a full disc.
    FullDisc,
    /// It may have a random amount of memory.
    LittleMemory,
    /// Its inputs vanish after a random time.
    VanishedInput,
    /// The folder that it writes in vanishes after a random time.
    VanishedFolder,
}

const FAULTS: [InjectedFault; 6] = [
    InjectedFault::Killed,
    InjectedFault::KilledInAFile,
    InjectedFault::FullDisc,
    InjectedFault::LittleMemory,
    InjectedFault::VanishedInput,
    InjectedFault::VanishedFolder,
];

#[test]
fn some_commands_survive_some_faults() {
    trials(6, 8);
}

/// As many trials as the variable `PHEX_FAULTS` says.
#[test]
#[ignore = "minutes: cargo xtask faults"]
fn all_commands_survive_all_faults() {
    let typed = std::env::var("PHEX_FAULTS")
        .ok()
        .and_then(|n| n.parse().ok());
    trials(typed.unwrap_or(500), 1);
}

/// A number of trials, spread over every `step`th command.
fn trials(count: usize, step: usize) {
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let benches: Vec<FaultBench> = COMMANDS.iter().step_by(step).map(FaultBench::new).collect();
    let mut endings: BTreeMap<String, usize> = BTreeMap::new();
    for k in 0..count {
        let bench = &benches[k % benches.len()];
        // Half of the trials are kills.
        let fault = FAULTS[(k / benches.len() % 10).saturating_sub(4)];
        let ended = bench.attack(fault, &mut random);
        *endings.entry(format!("{fault:?} {ended}")).or_default() += 1;
    }
    println!("{count} trials: {endings:#?}");
}

/// A command with what it finds and what it makes.
struct FaultBench {
    new: String,
    inputs: Workshop,
    before: FilesBelow,
    after: FilesBelow,
    time: Duration,
}

impl FaultBench {
    fn new((command, [new, old]): &(&'static str, [&str; 2])) -> Self {
        let inputs = inputs();
        let [new, old] = [new, old].map(|value| command.replace('$', value));
        inputs.phex(&old).ends_well(&old);
        let before = files(&inputs.path("out"));
        let began = Instant::now();
        inputs.phex(&new).ends_well(&new);
        let time = began.elapsed();
        let after = files(&inputs.path("out"));
        std::fs::remove_dir_all(inputs.path("out")).expect("it is there");
        Self {
            new,
            inputs,
            before,
            after,
            time,
        }
    }

    /// A folder with inputs, and what the run before has made.
    fn shop(&self) -> Workshop {
        let shop = Workshop::new();
        for (name, bytes) in files(&self.inputs.path("")) {
            shop.write(&name, bytes);
        }
        for (name, bytes) in &self.before {
            let path = shop.path("out").join(name);
            std::fs::create_dir_all(path.parent().expect("below a folder"))
                .expect("it can be made");
            std::fs::write(path, bytes).expect("it can be written");
        }
        shop
    }

    /// How a run ended to which a fault happened.
    fn attack(&self, fault: InjectedFault, random: &mut ChaCha8Rng) -> String {
        let shop = self.shop();
        let limit = self.limit(fault, random);
        let mut command = limited(&shop, &self.new, fault, limit);
        let log = std::fs::File::create(shop.path("said")).expect("it can be made");
        command.stdout(Stdio::null()).stderr(log);
        let mut child = command.spawn().expect("prlimit is there");
        let wait = self.time.mul_f64(random.random_range(0.0..1.2));
        match fault {
            InjectedFault::Killed => {
                std::thread::sleep(wait);
                child.kill().expect("it can be killed");
            }
            InjectedFault::VanishedInput => {
                std::thread::sleep(wait);
                remove_inputs(&shop);
            }
            InjectedFault::VanishedFolder => {
                std::thread::sleep(wait);
                let _ = std::fs::remove_dir_all(shop.path("out"));
            }
            _ => {}
        }
        let status = child.wait().expect("it ends");
        let told = format!(
            "phex {} ({fault:?}, {limit} bytes, {wait:?}): {status}",
            self.new
        );
        self.check_message(fault, status, &shop, &told);
        self.check_files(fault, &shop, &told);
        self.check_next_run(fault, &shop, &told);
        status
            .code()
            .map_or("by signal".to_owned(), |code| format!("with {code}"))
    }

    /// A size of files or of memory at which a run is stopped.
    fn limit(&self, fault: InjectedFault, random: &mut ChaCha8Rng) -> usize {
        let largest = self.after.values().map(Vec::len).max().unwrap_or(0);
        match fault {
            InjectedFault::LittleMemory => random.random_range(30_000_000..150_000_000),
            _ => random.random_range(0..=largest),
        }
    }

    fn check_message(&self, fault: InjectedFault, status: ExitStatus, shop: &Workshop, told: &str) {
        let said = String::from_utf8_lossy(&shop.read("said")).into_owned();
        assert!(
            !said.contains("panicked") || fault == InjectedFault::LittleMemory,
            "{told}: {said}"
        );
        let by_system = matches!(fault, InjectedFault::Killed | InjectedFault::KilledInAFile);
        match status.code() {
            Some(0 | 3 | 5) => {}
            Some(1 | 4) => assert!(said.contains("error: "), "{told}: {said}"),
            None if by_system && matches!(status.signal(), Some(9 | 25)) => {}
            // No memory for libraries, or none for the program, which says so.
            _ => assert!(
                fault == InjectedFault::LittleMemory && !said.is_empty(),
                "{told}: {said}"
            ),
        }
    }

    /// Each file is the old or the new one; while folders change, a file may be on its way.
    fn check_files(&self, fault: InjectedFault, shop: &Workshop, told: &str) {
        let found = files(&shop.path("out"));
        if fault == InjectedFault::VanishedFolder {
            return;
        }
        for (name, old) in &self.before {
            let new = self.after.get(name);
            let staged = found.get(&format!(".phex-new/{name}"));
            let is_whole = match found.get(name) {
                Some(now) => {
                    now == old
                        || new.is_some_and(|new| is_same(name, now, new))
                        || name == "phex.sha256"
                }
                None => new.is_none() || staged.is_some(),
            };
            assert!(
                is_whole,
                "{told}: {name} is neither the old nor the new one"
            );
        }
    }

    /// The next run ends as if nothing had happened.
    fn check_next_run(&self, fault: InjectedFault, shop: &Workshop, told: &str) {
        remove_inputs(shop);
        for (name, bytes) in files(&self.inputs.path("")) {
            shop.write(&name, bytes);
        }
        shop.phex(&self.new).ends_well(told);
        let found = files(&shop.path("out"));
        let others = found.keys().find(|name| !self.after.contains_key(*name));
        assert_eq!(others, None, "{told}: a leftover");
        // What earlier runs added has vanished with the folder.
        let is_all = found.len() == self.after.len() || fault == InjectedFault::VanishedFolder;
        assert!(is_all, "{told}: {:?}", found.keys());
        for (name, now) in &found {
            assert!(
                is_same(name, now, &self.after[name]),
                "{told}: {name} after the next run"
            );
        }
    }
}

/// Whether files are the same but for times in them.
fn is_same(name: &str, now: &[u8], new: &[u8]) -> bool {
    let is_timed = name == "phex.sha256";
    match Path::new(name).extension().and_then(|e| e.to_str()) {
        Some("json") => serde_json::from_slice::<serde_json::Value>(now).is_ok(),
        Some("html") => now.ends_with(&new[new.len() - 8..]),
        Some("csv") if name.starts_with("study") => !now.is_empty(),
        _ => now == new || is_timed,
    }
}

fn inputs() -> Workshop {
    let shop = Workshop::new();
    shop.succeed("shape elliptic-paraboloid -o dome.obj --triangles 400");
    shop.write("m.obj", honeycomb_on_a_bowl());
    shop.write(
        "study.toml",
        "surfaces = ['dome.obj']\n[settings]\npanels = 12\neffort = 'draft'\n",
    );
    shop
}

/// Panels in the tangent planes of a paraboloid: their planes meet in threes.
fn honeycomb_on_a_bowl() -> String {
    // The planes over a regular triangulation touch z = (x^2 + y^2)/2 at its vertices, and meet
    // above the circumcentres at heights below by half the circumradius squared.
    crate::common::honeycomb(3, 3, |_, [x, y, _]| {
        [0.1 * x, 0.1 * y, 0.005 * (x * x + y * y - 1.0)]
    })
}

fn remove_inputs(shop: &Workshop) {
    for name in ["dome.obj", "m.obj", "study.toml"] {
        let _ = std::fs::remove_file(shop.path(name));
    }
}

/// The program below a limit; a full disc lets it live and tell.
fn limited(shop: &Workshop, arguments: &str, fault: InjectedFault, bytes: usize) -> Command {
    let kind = match fault {
        InjectedFault::KilledInAFile | InjectedFault::FullDisc => "fsize",
        InjectedFault::LittleMemory => "as",
        _ => return shop.command(arguments),
    };
    let ignored = if fault == InjectedFault::FullDisc {
        "trap '' XFSZ; "
    } else {
        ""
    };
    let mut command = Command::new("sh");
    let script = format!("{ignored}exec prlimit --core=0 --{kind}={bytes} \"$0\" \"$@\"");
    command
        .current_dir(shop.path(""))
        .args(["-c", &script, env!("CARGO_BIN_EXE_phex")]);
    command.args(arguments.split_whitespace());
    command
}

/// Every file below a folder; of the inputs' folder only the files in itself.
fn files(folder: &Path) -> FilesBelow {
    let mut found = FilesBelow::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(&at).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path
                    .strip_prefix(folder)
                    .expect("below it")
                    .to_string_lossy();
                found.insert(name.into_owned(), std::fs::read(&path).expect("readable"));
            }
        }
    }
    found
}

/// A small file system that is full: what was there stays, and the message says it.
#[test]
fn a_full_file_system_is_told() {
    let shop = inputs();
    let script = "mkdir d && mount -t tmpfs -o size=16k none d || exit 77\n\
                  echo old > d/t.obj; \"$0\" shape torus -o d/t.obj --triangles 600; echo $? >> code; \
                  cat d/t.obj; ls -A d";
    let mut command = Command::new("unshare");
    command
        .current_dir(shop.path(""))
        .args(["-m", "sh", "-c", script, env!("CARGO_BIN_EXE_phex")]);
    let Ok(output) = command.output() else {
        return println!("skipped: there is no `unshare`");
    };
    if !shop.path("code").exists() {
        return println!("skipped: no file system can be mounted");
    }
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(shop.read("code"), b"1\n", "{said}");
    assert!(
        said.contains("No space left") && said.contains("d/t.obj"),
        "{said}"
    );
    assert_eq!(String::from_utf8_lossy(&output.stdout), "old\nt.obj\n");
}

/// Nobody may write into a folder of somebody else.
#[test]
fn a_folder_that_may_not_be_written_is_told_before_the_computation() {
    let shop = inputs();
    let program = env!("CARGO_BIN_EXE_phex");
    let mut command = Command::new("setpriv");
    command
        .current_dir(shop.path(""))
        .args(["--reuid=65534", "--clear-groups", program]);
    let folder: std::fs::Permissions = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(shop.path(""), folder).expect("it is ours");
    let output = command.args(["convert", "m.obj", "n.ply"]).output();
    let Some(output) = output.ok().filter(|o| o.status.code() != Some(127)) else {
        return println!("skipped: there is no `setpriv`");
    };
    let said = String::from_utf8_lossy(&output.stderr);
    if said.contains("setpriv") {
        return println!("skipped: {said}");
    }
    assert_eq!(output.status.code(), Some(4), "{said}");
    assert!(said.contains("n.ply can't be written"), "{said}");
    assert!(!shop.path("n.ply").exists());
}

/// Results that can't be printed are an error that is told.
#[test]
fn a_standard_output_that_takes_nothing_is_told() {
    let shop = inputs();
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full");
    let output = shop
        .command("info m.obj")
        .stdout(full.expect("Linux has it"))
        .output();
    let output = output.expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("standard output"), "{said}");
}
