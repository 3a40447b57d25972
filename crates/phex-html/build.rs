//! Embeds the viewer of the HTML report: the one that `cargo xtask viewer` has built, else one that is built here where npm
//! is installed. Without either the report has pictures and tables.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where `cargo xtask viewer` puts it.
const BUILT: &str = "bundle";
/// Where its source is.
const SOURCE: &str = "../../studio/viewer";
/// What it is made from, there.
const PARTS: [&str; 4] = ["src", "package.json", "package-lock.json", "vite.config.js"];
/// The variable that keeps npm out of the build.
const OFF: &str = "PHEX_NO_NPM";

fn main() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let (built, source) = (root.join(BUILT), root.join(SOURCE));
    println!("cargo::rerun-if-changed={}", built.display());
    println!("cargo::rerun-if-env-changed={OFF}");
    // A file that is not there would make every build run this again.
    for part in PARTS.map(|part| source.join(part)) {
        if part.exists() {
            println!("cargo::rerun-if-changed={}", part.display());
        }
    }
    println!("cargo::rustc-check-cfg=cfg(viewer_bundle)");
    let bundle = Some(built.join("viewer.js")).filter(|file| file.is_file());
    if let Some(bundle) = bundle.or_else(|| made(&source)) {
        println!("cargo::rustc-cfg=viewer_bundle");
        println!("cargo::rustc-env=PHEX_VIEWER={}", bundle.display());
    }
}

/// The viewer, built beside the crate's other products.
fn made(source: &Path) -> Option<PathBuf> {
    let wanted = std::env::var_os(OFF).is_none() && source.join("package.json").is_file();
    if !wanted || npm(source, &["--version"]).is_err() {
        return None;
    }
    let out = std::env::var_os("OUT_DIR").map(PathBuf::from)?;
    match build(source, &out) {
        Ok(()) => Some(out.join("viewer.js")),
        Err(cause) => {
            println!("cargo::warning=HTML reports will have no interactive view: {cause}");
            None
        }
    }
}

fn build(source: &Path, out: &Path) -> Result<(), String> {
    if !source.join("node_modules/.package-lock.json").is_file() {
        // Without a network this must fail at once.
        npm(
            source,
            &["ci", "--silent", "--ignore-scripts", "--fetch-retries=0"],
        )?;
    }
    let out = out.to_string_lossy();
    npm(
        source,
        &["run", "--silent", "build", "--", "--outDir", &out],
    )
}

fn npm(source: &Path, words: &[&str]) -> Result<(), String> {
    let mut command = Command::new("npm");
    // What a build script prints is for cargo.
    command
        .current_dir(source)
        .args(words)
        .stdout(Stdio::null());
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("npm {} ended with {status}", words[0])),
        Err(cause) => Err(format!("npm: {cause}")),
    }
}
