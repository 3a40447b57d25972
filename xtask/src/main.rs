//! Tasks of the project: `cargo xtask check` runs everything that continuous integration runs.

mod arrows;
mod attacks;
mod book;
mod circles;
mod comments;
mod figures;
mod foreign;
mod ledger;
mod measured;
mod old_linux;
mod package;
mod paths;
mod performance;
mod python;
mod release;
mod stages;
mod types;
mod viewer;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

const USAGE: &str = "usage: cargo xtask check | ledger [--compare] [ROW...] | performance [--large] [--models FOLDER] | foreign | python | wheel
                        | book [--write] [CHAPTER.md...] | viewer | browse | figures [NUMBER...] | obj STEP...
                        | package [--no-verify] | release | notes [TAG] | fuzz [--minutes N] | hostile | faults

check   formatting, house rules, clippy and documentation without warnings, all tests, examples build;
        stops at the first step that fails
foreign opens the files of the program with other programs (needs Python and pip)
python  builds the Python package and tests it (needs Python and pip)
wheel   packs it for other machines, in target/wheels (needs Python and pip)
book    runs every command of docs/book and compares what it prints; follows every relative link; with --write what is
        shown whole is brought up to date; --program PATH: another phex
viewer  builds the interactive part of the HTML report, and the page of the studio (needs npm)
browse  opens HTML reports and the studio in headless Chromium and clicks through them (needs npm, and Chromium or apt-get)
ledger  makes the rows of docs/ledger.md (surfaces at set sizes) and says what is better and worse than the committed ones;
        with --compare the file stays; with rows' names the others stay; --quick: the rows of check; --program PATH: another phex;
        --models FOLDER: models that are not in the repository (default ../shared/models)
performance measures what runs cost, and writes docs/performance.md
fuzz    random inputs for every reader and for what is made of meshes; 1 minute without a number
hostile all hostile surfaces through `phex mesh`; in the tests there are some of them
faults  kills, full discs and vanished files in all commands that write, 500 times; PHEX_FAULTS: so many times
figures the gallery in docs/gallery: the paper's figures and the table of methods and surfaces; with numbers only those
package packs the crates as they are published, in target/package, with the viewer inside (needs npm), and builds each from its
        package, but with --no-verify
release makes the archive of the program for machines without Rust, in target/release-files, with manual pages, completions and
        licences (needs npm; on Linux Python and pip, from which the linker for old systems comes)
notes   prints what the changelog says of this version; with a tag it checks that the tag names it
obj     cuts and joins OBJ files, as the gallery's commands need it";

/// One step of the check: its name, and what it runs.
struct Step {
    name: &'static str,
    run: fn(&Path) -> Result<(), Stop>,
}

/// Why a step did not do its work.
enum Stop {
    /// Something is wrong.
    Failed(String),
    /// This machine has not what it takes.
    Skipped(String),
}

impl Stop {
    /// A step that can't be taken on this machine.
    fn skipped(reason: impl Into<String>) -> Self {
        Self::Skipped(reason.into())
    }
}

impl From<String> for Stop {
    fn from(cause: String) -> Self {
        Self::Failed(cause)
    }
}

const CHECK: [Step; 17] = [
    Step {
        name: "formatting",
        run: |root| Ok(cargo(root, &["fmt", "--all", "--check"])?),
    },
    Step {
        name: "stages use earlier stages only",
        run: |root| Ok(stages::check(root)?),
    },
    Step {
        name: "crates depend one way",
        run: |root| Ok(arrows::check(root)?),
    },
    Step {
        name: "modules use one another in no circle",
        run: |root| Ok(circles::check(root)?),
    },
    Step {
        name: "types have names of their own",
        run: |root| Ok(types::check(root)?),
    },
    Step {
        name: "no machine paths",
        run: |root| Ok(paths::check(root)?),
    },
    Step {
        name: "comments wrap",
        run: |root| Ok(comments::check(root)?),
    },
    Step {
        name: "the report's viewer is built",
        run: viewer::build,
    },
    Step {
        name: "clippy without warnings",
        run: |root| {
            let what = ["clippy", "--workspace", "--all-targets"];
            Ok(cargo(
                root,
                &[&what[..], &["--", "-D", "warnings"]].concat(),
            )?)
        },
    },
    Step {
        name: "documentation without warnings",
        run: |root| Ok(documentation(root)?),
    },
    Step {
        name: "tests",
        // The browser comes while the processors compile; if it does not, the step that needs it
        // says so.
        run: |root| {
            std::thread::scope(|scope| {
                scope.spawn(viewer::browser);
                Ok(cargo(root, &["test", "--workspace"])?)
            })
        },
    },
    Step {
        name: "a minute of random inputs, and files in other programs",
        run: |root| side_by_side(|| Ok(attacks::fuzz(root, 1.0)?), || foreign::check(root)),
    },
    Step {
        name: "the book's commands do what it says",
        run: book::check,
    },
    Step {
        name: "no row of the ledger is worse",
        run: |root| Ok(ledger::check(root)?),
    },
    Step {
        name: "the report and the studio in a browser",
        run: viewer::browse,
    },
    Step {
        name: "everything builds",
        run: |root| Ok(python::built(root)?),
    },
    Step {
        name: "the Python package",
        run: python::check,
    },
];

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["check"] => check(&root()),
        ["foreign"] => exit(foreign::check(&root())),
        ["python"] => exit(python::check(&root())),
        ["wheel"] => exit(python::wheel(&root())),
        ["book", ref words @ ..] => exit(book::book(&root(), words)),
        ["viewer"] => exit(viewer::build(&root())),
        ["browse"] => exit(viewer::browse(&root())),
        ["ledger", ref words @ ..] => exit(ledger::ledger(&root(), words).map_err(Stop::from)),
        ["ledger-reference"] => {
            println!("{}", ledger::reference());
            ExitCode::SUCCESS
        }
        ["performance", ref words @ ..] => {
            exit(performance::performance(&root(), words).map_err(Stop::from))
        }
        ["fuzz", ref words @ ..] => {
            exit(attacks::fuzz_as_typed(&root(), words).map_err(Stop::from))
        }
        ["hostile"] => exit(attacks::hostile(&root()).map_err(Stop::from)),
        ["faults"] => exit(attacks::faults(&root()).map_err(Stop::from)),
        ["package", ref words @ ..] => exit(package::package(&root(), words)),
        ["release"] => exit(release::release(&root())),
        ["notes", ref words @ ..] => exit(release::notes(&root(), words)),
        ["obj", ref step @ ..] => exit(figures::steps::run(&root(), step).map_err(Stop::from)),
        ["figures", ref only @ ..] => exit(figures::figures(&root(), only).map_err(Stop::from)),
        _ => {
            eprintln!("{USAGE}");
            ExitCode::from(2)
        }
    }
}

fn exit(result: Result<(), Stop>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop::Failed(cause) | Stop::Skipped(cause)) => {
            eprintln!("{cause}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace's folder: the parent of this crate's.
fn root() -> PathBuf {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here).to_path_buf()
}

fn check(root: &Path) -> ExitCode {
    let mut skipped = Vec::new();
    let start = std::time::Instant::now();
    for step in &CHECK {
        println!("== {}, after {} s", step.name, start.elapsed().as_secs());
        match (step.run)(root) {
            Ok(()) => {}
            Err(Stop::Skipped(reason)) => {
                println!("== SKIPPED: {}: {reason}", step.name);
                skipped.push(step.name);
            }
            Err(Stop::Failed(cause)) => {
                println!("== FAILED: {}\n{cause}", step.name);
                return ExitCode::FAILURE;
            }
        }
    }
    println!("{}", passed(&skipped));
    ExitCode::SUCCESS
}

/// What takes a minute whatever else runs, and something else; a failure comes before a skip.
fn side_by_side(
    first: impl FnOnce() -> Result<(), Stop> + Send,
    second: impl FnOnce() -> Result<(), Stop>,
) -> Result<(), Stop> {
    let ends = std::thread::scope(|scope| {
        let first = scope.spawn(first);
        let second = second();
        let panicked = |_| Err(Stop::Failed("a step panicked".into()));
        [first.join().unwrap_or_else(panicked), second]
    });
    let stops = ends.into_iter().filter_map(Result::err);
    let first = stops.min_by_key(|stop| matches!(stop, Stop::Skipped(_)));
    first.map_or(Ok(()), Err)
}

/// The last line of a check in which nothing failed.
fn passed(skipped: &[&str]) -> String {
    let taken = CHECK.len() - skipped.len();
    match skipped {
        [] => format!("== all {taken} steps passed"),
        names => format!("== {taken} steps passed, skipped: {}", names.join(", ")),
    }
}

/// The program as the tests have built it: with `-p phex-cli` alone its packages have other
/// features, and half the tree would be compiled again.
fn program_as_tested(root: &Path) -> Result<PathBuf, String> {
    cargo(root, &["test", "--workspace", "--no-run", "--quiet"])?;
    let name = format!("phex{}", std::env::consts::EXE_SUFFIX);
    Ok(target_folder(root).join("debug").join(name))
}

/// Where cargo builds.
fn target_folder(root: &Path) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR");
    target.map_or_else(|| root.join("target"), PathBuf::from)
}

fn cargo(root: &Path, arguments: &[&str]) -> Result<(), String> {
    succeed(
        Command::new(cargo_program())
            .current_dir(root)
            .args(arguments),
    )
}

/// The cargo that runs this task, so that a chosen toolchain stays chosen.
fn cargo_program() -> OsString {
    std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

fn documentation(root: &Path) -> Result<(), String> {
    let mut command = Command::new(cargo_program());
    command.current_dir(root).env("RUSTDOCFLAGS", "-D warnings");
    succeed(command.args(["doc", "--workspace", "--no-deps"]))
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let status = command
        .status()
        .map_err(|e| format!("{command:?} can't be started: {e}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{command:?} ended with {status}"))
    }
}

/// All files below a folder, without version control, build products and results; in order.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>, String> {
    const SKIPPED: [&str; 5] = [".git", "target", "out", "node_modules", "bundle"];
    files_without(folder, &SKIPPED)
}

/// All files below a folder, whatever their names; in order.
fn all_files_below(folder: &Path) -> Result<Vec<PathBuf>, String> {
    files_without(folder, &[])
}

/// All files below a folder, without entries of some names.
fn files_without(folder: &Path, skipped: &[&str]) -> Result<Vec<PathBuf>, String> {
    let fail = |e| format!("{}: {e}", folder.display());
    let mut entries: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(fail)? {
        entries.push(entry.map_err(fail)?.path());
    }
    entries.sort();
    let mut files = Vec::new();
    for path in entries {
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if skipped.contains(&name.as_str()) {
            continue;
        }
        if path.is_dir() {
            files.extend(files_without(&path, skipped)?)
        } else {
            files.push(path)
        }
    }
    Ok(files)
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn write(path: &Path, text: &str) -> Result<(), String> {
    std::fs::write(path, text).map_err(|e| format!("{}: {e}", path.display()))
}

/// Copies a file into a folder, which is made where it is missing.
fn copied(from: &Path, to: &Path) -> Result<(), String> {
    let failed = |e: std::io::Error| format!("{}: {e}", to.display());
    to.parent()
        .map_or(Ok(()), std::fs::create_dir_all)
        .map_err(failed)?;
    std::fs::copy(from, to).map(drop).map_err(failed)
}

/// `Ok` without complaints, else all of them.
fn verdict(complaints: Vec<String>) -> Result<(), String> {
    if complaints.is_empty() {
        Ok(())
    } else {
        Err(complaints.join("\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_that_were_skipped_are_named_and_not_counted_as_passed() {
        assert_eq!(passed(&[]), format!("== all {} steps passed", CHECK.len()));
        let text = passed(&["files in other programs", "the Python package"]);
        let taken = CHECK.len() - 2;
        assert_eq!(
            text,
            format!(
                "== {taken} steps passed, skipped: files in other programs, the Python package"
            )
        );
    }

    #[test]
    fn a_failure_beside_a_skip_fails() {
        let failed = || Err(Stop::Failed("wrong".into()));
        let skipped = || Err(Stop::skipped("not there"));
        let [a, b] = [side_by_side(failed, skipped), side_by_side(skipped, failed)];
        assert!(matches!(a, Err(Stop::Failed(_))) && matches!(b, Err(Stop::Failed(_))));
        let one = side_by_side(|| Ok(()), skipped);
        assert!(matches!(one, Err(Stop::Skipped(_))));
        assert!(side_by_side(|| Ok(()), || Ok(())).is_ok());
    }
}
