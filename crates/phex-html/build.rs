//! Embeds the viewer of the HTML report, and the page of the studio that shares its modules: those
//! that `cargo xtask viewer` has built, else such as are built here where npm is installed. Without
//! either the report has pictures and tables, and `phex --version` says why.

#[path = "npm.rs"]
mod npm;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where `cargo xtask viewer` puts it.
const BUILT: &str = "bundle";
/// Where its source is.
const SOURCE: &str = "../../studio/viewer";
/// What it is made from, there.
const PARTS: [&str; 4] = ["src", "package.json", "package-lock.json", "build.mjs"];
/// The scripts that become of it, and the variables that say where they are.
const SCRIPTS: [(&str, &str); 2] = [("viewer.js", "PHEX_VIEWER"), ("studio.js", "PHEX_STUDIO")];
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
    let whole = |folder: &PathBuf| SCRIPTS.iter().all(|(name, _)| folder.join(name).is_file());
    let bundle = Some(built).filter(whole);
    match bundle.map_or_else(|| made(&source), Ok) {
        Ok(bundle) => {
            println!("cargo::rustc-cfg=viewer_bundle");
            for (name, variable) in SCRIPTS {
                println!(
                    "cargo::rustc-env={variable}={}",
                    bundle.join(name).display()
                );
            }
        }
        Err(cause) => println!("cargo::rustc-env=PHEX_NO_VIEWER={cause}"),
    }
}

/// The folder of the scripts, built beside the crate's other products; or why not.
fn made(source: &Path) -> Result<PathBuf, String> {
    if std::env::var_os(OFF).is_some() {
        return Err(format!("the program was built with {OFF}"));
    }
    if !source.join("package.json").is_file() || npm(source, &["--version"]).is_err() {
        return Err("the program was built without npm, which makes it".to_owned());
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").unwrap_or_default());
    match build(source, &out) {
        Ok(()) => Ok(out),
        Err(cause) => {
            println!(
                "cargo::warning=HTML reports will have no interactive view: {cause}; `cargo xtask viewer` makes it later"
            );
            Err(format!("it could not be made: {cause}"))
        }
    }
}

fn build(source: &Path, out: &Path) -> Result<(), String> {
    if !npm::is_installed(source)? {
        npm(source, &npm::FETCH)?;
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
