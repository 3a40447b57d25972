//! Files of the program, opened by other programs: Python packages in an environment of their own.

use crate::{Stop, program_as_tested, viewer};
use std::path::{Path, PathBuf};
use std::process::Command;

/// How packages are installed.
const PIP: [&str; 5] = [
    "-m",
    "pip",
    "install",
    "--quiet",
    "--disable-pip-version-check",
];
const TEST: &str = "crates/phex-fab/tests/foreign";
/// The packages that open the program's files.
pub const REQUIREMENTS: &str = "crates/phex-fab/tests/foreign/requirements.txt";

/// Makes the environment where it is missing or out of date, makes a mesh, and runs the test.
pub fn check(root: &Path) -> Result<(), Stop> {
    let python = environment(root, &[REQUIREMENTS])?;
    let phex = program_as_tested(root)?;
    let folder = root.join("target/foreign");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    let [surface, mesh] = ["surface.obj", "panels.obj"].map(|name| folder.join(name));
    crate::succeed(
        Command::new(&phex)
            .args(["shape", "torus", "--triangles", "4000", "-q", "-o"])
            .arg(&surface),
    )?;
    crate::succeed(
        Command::new(&phex)
            .arg("mesh")
            .arg(&surface)
            .args(["-n", "400", "-q", "-o"])
            .arg(&mesh),
    )?;
    let script = root.join(TEST).join("check.py");
    let mut test = Command::new(&python);
    Ok(crate::succeed(
        test.arg(script).arg(&phex).arg(&folder).arg(&mesh),
    )?)
}

/// Adds a package to the environment, which stays as it is where the package is there.
pub fn add(python: &Path, package: &str) -> Result<(), Stop> {
    let mut install = Command::new(python);
    install.args(PIP).arg(package);
    crate::succeed(&mut install)
        .map_err(|cause| Stop::skipped(format!("{package} can't be installed: {cause}")))
}

/// The Python of an environment with the packages that some lists name, which is made where it is
/// missing or out of date. Packages are added for a list that was not asked for before.
pub fn environment(root: &Path, lists: &[&str]) -> Result<PathBuf, Stop> {
    let system = viewer::program("python3")
        .ok_or_else(|| Stop::skipped("Python is not installed, whose packages open the files"))?;
    let venv = root.join("target/foreign-venv");
    let python = venv.join("bin/python");
    let stamp = venv.join("requirements.txt");
    let wanted: Result<String, String> = lists.iter().map(|l| crate::read(&root.join(l))).collect();
    let wanted = wanted?;
    if std::fs::read_to_string(&stamp).is_ok_and(|there| there.starts_with(&wanted)) {
        return Ok(python);
    }
    // Without the module venv, or without a network, these are not to be had here.
    let skipped = |cause| Stop::skipped(format!("its packages can't be installed: {cause}"));
    let mut make = Command::new(system);
    make.args(["-m", "venv", "--clear"]).arg(&venv);
    crate::succeed(&mut make).map_err(skipped)?;
    if !lists.is_empty() {
        let mut install = Command::new(&python);
        install.args(PIP);
        for list in lists {
            install.arg("-r").arg(root.join(list));
        }
        crate::succeed(&mut install).map_err(skipped)?;
    }
    std::fs::write(&stamp, &wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    Ok(python)
}
