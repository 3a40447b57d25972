//! Files of the program, opened by other programs: Python packages in an environment of their own.

use std::path::Path;
use std::process::Command;

const TEST: &str = "crates/phex-fab/tests/foreign";

/// Makes the environment where it is missing or out of date, makes a mesh, and runs the test.
pub fn check(root: &Path) -> Result<(), String> {
    let venv = root.join("target/foreign-venv");
    let python = venv.join("bin/python");
    let wanted = crate::read(&root.join(TEST).join("requirements.txt"))?;
    let stamp = venv.join("requirements.txt");
    if std::fs::read_to_string(&stamp).ok().as_ref() != Some(&wanted) {
        crate::succeed(
            Command::new("python3")
                .args(["-m", "venv", "--clear"])
                .arg(&venv),
        )?;
        let install = [
            "-m",
            "pip",
            "install",
            "--quiet",
            "--disable-pip-version-check",
            "-r",
        ];
        crate::succeed(
            Command::new(&python)
                .args(install)
                .arg(root.join(TEST).join("requirements.txt")),
        )?;
        std::fs::write(&stamp, &wanted).map_err(|e| format!("{}: {e}", stamp.display()))?;
    }
    crate::cargo(root, &["build", "-p", "phex-cli"])?;
    let (phex, folder) = (root.join("target/debug/phex"), root.join("target/foreign"));
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
    crate::succeed(
        Command::new(&python)
            .arg(script)
            .arg(&phex)
            .arg(&folder)
            .arg(&mesh),
    )
}
