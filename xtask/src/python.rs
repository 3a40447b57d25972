//! The Python package: built, tested from Python, and packed as a wheel.

use crate::{Stop, cargo, cargo_program, copied, foreign, old_linux, succeed, target_folder};
use std::path::{Path, PathBuf};
use std::process::Command;

/// What builds wheels, from PyPI.
const MATURIN: &str = "maturin==1.16.*";
/// What the tests need besides what reads the program's files.
const TESTED_WITH: &str = "python/tests/requirements.txt";

/// Tests the module as the workspace's build has made it: with the features of the other packages,
/// so that nothing is compiled twice, and without maturin.
pub fn check(root: &Path) -> Result<(), Stop> {
    let python = foreign::environment(root, &[foreign::REQUIREMENTS, TESTED_WITH])?;
    built(root)?;
    let place = placed(root)?;
    let program = format!("phex{}", std::env::consts::EXE_SUFFIX);
    let mut tests = Command::new(&python);
    tests
        .current_dir(root.join("python"))
        .env("PYTHONPATH", &place)
        .env("PHEX_PROGRAM", debug(root).join(program))
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
    succeed(&mut tests)?;
    let mut stubs = Command::new(&python);
    stubs.env("PYTHONPATH", &place).current_dir(&place);
    Ok(succeed(stubs.args(["-m", "mypy.stubtest", "phex._phex"]))?)
}

/// Builds everything that is no test, with the features that tests have.
pub fn built(root: &Path) -> Result<(), String> {
    let what = [
        "build",
        "--workspace",
        "--lib",
        "--bins",
        "--examples",
        "--quiet",
    ];
    cargo(root, &what)
}

fn debug(root: &Path) -> PathBuf {
    target_folder(root).join("debug")
}

/// A folder with the package and its compiled part.
fn placed(root: &Path) -> Result<PathBuf, String> {
    let place = target_folder(root).join("python");
    let package = place.join("phex");
    if package.exists() {
        let failed = |e| format!("{}: {e}", package.display());
        std::fs::remove_dir_all(&package).map_err(failed)?;
    }
    let source = root.join("python/src/phex");
    for file in crate::files_below(&source)? {
        let below = file.strip_prefix(&source).unwrap_or(&file);
        if below.extension().is_some_and(|e| e == "pyc") {
            continue;
        }
        copied(&file, &package.join(below))?;
    }
    let (library, module) = names();
    copied(&debug(root).join(library), &package.join(module))?;
    Ok(place)
}

/// What cargo calls the module, and what Python does.
fn names() -> (String, &'static str) {
    let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let module = match cfg!(windows) {
        true => "_phex.pyd",
        false => "_phex.abi3.so",
    };
    (format!("{prefix}_phex{suffix}"), module)
}

/// Makes a wheel in `target/wheels`; on Linux only the last link step is zig's, for old systems.
pub fn wheel(root: &Path) -> Result<(), Stop> {
    let python = foreign::environment(root, &[])?;
    foreign::add(&python, MATURIN)?;
    let out = target_folder(root).join("wheels");
    let mut build = Command::new(&python);
    build
        .current_dir(root.join("python"))
        .env("CARGO", cargo_program())
        .args(["-m", "maturin", "build", "--release", "--locked", "--out"])
        .arg(&out);
    if cfg!(target_os = "linux") {
        build.args(["--compatibility", "manylinux2014", "--"]);
        build.args(old_linux::linking(root)?);
    }
    Ok(succeed(&mut build)?)
}
