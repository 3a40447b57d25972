//! The interactive part of the HTML report: building it, and trying it in a browser.

use crate::{cargo, succeed};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where its source is.
const SOURCE: &str = "studio/viewer";
/// Debian's name of the browser, as a package and as a program.
const BROWSER: &str = "chromium";

/// Builds the viewer into the folder from which the report's crate embeds it.
pub fn build(root: &Path) -> Result<(), String> {
    let Some(npm) = program("npm") else {
        println!(
            "   skipped: npm is not installed, so reports have pictures instead of the interactive view"
        );
        return Ok(());
    };
    install(root, &npm)?;
    let mut build = Command::new(&npm);
    succeed(
        build
            .current_dir(root.join(SOURCE))
            .args(["run", "--silent", "build"]),
    )
}

/// Opens reports in a headless browser.
pub fn browse(root: &Path) -> Result<(), String> {
    let (Some(npm), Some(node)) = (program("npm"), program("node")) else {
        println!("   skipped: npm is not installed, so there is no interactive view to try");
        return Ok(());
    };
    let Some(browser) = browser()? else {
        println!("   skipped: there is no {BROWSER}, and no apt-get to install it");
        return Ok(());
    };
    install(root, &npm)?;
    // As the tests have built it: nothing is compiled twice.
    cargo(root, &["test", "--workspace", "--no-run", "--quiet"])?;
    let mut test = Command::new(node);
    test.current_dir(root.join(SOURCE)).arg("test/report.mjs");
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root.join("target"), PathBuf::from);
    succeed(test.arg(target.join("debug/phex")).arg(browser))
}

/// Fetches the packages that the lock file names, unless they are there.
fn install(root: &Path, npm: &Path) -> Result<(), String> {
    let source = root.join(SOURCE);
    let changed = |file: &str| source.join(file).metadata().and_then(|m| m.modified()).ok();
    let installed = changed("node_modules/.package-lock.json");
    if installed.is_some() && installed >= changed("package-lock.json") {
        return Ok(());
    }
    succeed(
        Command::new(npm)
            .current_dir(source)
            .args(["ci", "--silent"]),
    )
}

/// The browser, installed if need be; `None` where it can't be installed.
fn browser() -> Result<Option<PathBuf>, String> {
    if let Some(browser) = program(BROWSER) {
        return Ok(Some(browser));
    }
    let Some(apt) = program("apt-get") else {
        return Ok(None);
    };
    let mut install = Command::new(apt);
    install
        .env("DEBIAN_FRONTEND", "noninteractive")
        .args(["install", "-y", "-qq", BROWSER])
        .stdout(Stdio::null());
    succeed(&mut install)?;
    Ok(program(BROWSER))
}

/// A program of the search path.
fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}
