//! Random inputs, hostile surfaces and faults, for longer than the tests take (`docs/fuzzing.md`).

use crate::{cargo_program, succeed};
use std::path::Path;
use std::process::Command;

/// Tests of `crates/phex-fuzz/tests` that share the time.
const TARGETS: f64 = 13.0;

/// Tries all targets with random inputs for some minutes.
pub fn fuzz(root: &Path, minutes: f64) -> Result<(), String> {
    let seconds = (60.0 * minutes / TARGETS).to_string();
    let tests = ["--test", "readers", "--test", "meshes"];
    let mut command = tests_of(root, &tests, &["--test-threads=1"]);
    succeed(command.env("PHEX_FUZZ_SECONDS", seconds))
}

/// What is typed after `fuzz`.
pub fn fuzz_as_typed(root: &Path, words: &[&str]) -> Result<(), String> {
    let minutes = match words {
        [] => Some(1.0),
        ["--minutes", n] => n.parse().ok(),
        _ => None,
    };
    let minutes = minutes.filter(|m: &f64| *m > 0.0 && m.is_finite());
    fuzz(root, minutes.ok_or("write `fuzz --minutes N`")?)
}

/// All hostile surfaces through `phex mesh`.
pub fn hostile(root: &Path) -> Result<(), String> {
    succeed(&mut tests_of(
        root,
        &["--test", "it"],
        &["--ignored", "hostile::"],
    ))
}

/// Kills, full discs, little memory, vanished files, in all commands that write.
pub fn faults(root: &Path) -> Result<(), String> {
    succeed(&mut tests_of(
        root,
        &["--test", "it"],
        &["--ignored", "faults::"],
    ))
}

/// Tests with the features of the whole workspace, as every other task builds them.
fn tests_of(root: &Path, which: &[&str], how: &[&str]) -> Command {
    let mut command = Command::new(cargo_program());
    command.current_dir(root).args(["test", "--workspace"]);
    command.args(which).args(["--", "--nocapture"]).args(how);
    command
}
