//! The crates as they are published.

use crate::{Stop, cargo, cargo_program, viewer};
use std::path::Path;
use std::process::Command;

/// The crates that are published, each after those that it depends on; `cargo publish` takes them
/// in this order.
const PUBLISHED: [&str; 10] = [
    "phex-mesh",
    "phex-numeric",
    "phex",
    "phex-picture",
    "phex-html",
    "phex-fab",
    "phex-job",
    "phex-study",
    "phex-studio",
    "phex-cli",
];
/// What the package of the report's crate must hold, so that installing the program takes no npm.
const VIEWER: [&str; 2] = ["bundle/viewer.js", "bundle/studio.js"];

/// Packs all crates, and builds each from its package unless `--no-verify` is said.
pub fn package(root: &Path, words: &[&str]) -> Result<(), Stop> {
    viewer::build(root)?;
    holds_the_viewer(root)?;
    let mut what = vec!["package", "--locked", "--allow-dirty"];
    what.extend(words);
    what.extend(PUBLISHED.iter().flat_map(|name| ["-p", name]));
    Ok(cargo(root, &what)?)
}

fn holds_the_viewer(root: &Path) -> Result<(), String> {
    let mut list = Command::new(cargo_program());
    list.current_dir(root)
        .args(["package", "--list", "--allow-dirty", "-p", "phex-html"]);
    let listed = list.output().map_err(|e| e.to_string())?;
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    let missing = VIEWER
        .iter()
        .filter(|file| !listed.lines().any(|l| l == **file));
    crate::verdict(
        missing
            .map(|file| format!("phex-html has no {file}"))
            .collect(),
    )
}
