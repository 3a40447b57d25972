//! The interactive part of the HTML report and the page of the studio: building them, and trying
//! them in a browser.

#[path = "../../crates/phex-html/npm.rs"]
mod npm;

use crate::{Stop, program_as_tested, succeed};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where its source is.
const SOURCE: &str = "studio/viewer";
/// What is done in the browser: with reports, and with the studio.
const SCRIPTS: [&str; 3] = ["test/report.mjs", "test/study.mjs", "test/studio.mjs"];
/// Debian's name of the browser, as a package and as a program.
const BROWSER: &str = "chromium";

/// Builds the viewer into the folder from which the report's crate embeds it.
pub fn build(root: &Path) -> Result<(), Stop> {
    let npm = program("npm").ok_or_else(|| {
        Stop::skipped("npm is not installed, so reports have pictures and no interactive view")
    })?;
    install(root, &npm)?;
    let mut build = Command::new(&npm);
    build.current_dir(root.join(SOURCE));
    Ok(succeed(build.args(["run", "--silent", "build"]))?)
}

/// Opens reports, the page of a study and the studio in a headless browser.
pub fn browse(root: &Path) -> Result<(), Stop> {
    let (Some(npm), Some(node)) = (program("npm"), program("node")) else {
        return Err(Stop::skipped(
            "npm is not installed, so there is no interactive view to try",
        ));
    };
    let browser = browser()?;
    install(root, &npm)?;
    let phex = program_as_tested(root)?;
    for script in SCRIPTS {
        let mut test = Command::new(&node);
        test.current_dir(root.join(SOURCE)).arg(script);
        succeed(test.args([&phex, &browser]))?;
    }
    Ok(())
}

/// Fetches the packages that the lock file names, unless they are there.
fn install(root: &Path, npm: &Path) -> Result<(), Stop> {
    let source = root.join(SOURCE);
    if npm::is_installed(&source)? {
        return Ok(());
    }
    let mut fetch = Command::new(npm);
    succeed(fetch.current_dir(source).args(npm::FETCH))
        .map_err(|cause| Stop::skipped(format!("the viewer's packages can't be fetched: {cause}")))
}

/// The browser, installed if need be and if that is possible.
pub fn browser() -> Result<PathBuf, Stop> {
    if let Some(browser) = program(BROWSER) {
        return Ok(browser);
    }
    let Some(apt) = program("apt-get") else {
        let message = format!("there is no {BROWSER}, and no apt-get to install it");
        return Err(Stop::skipped(message));
    };
    let mut install = Command::new(apt);
    install
        .env("DEBIAN_FRONTEND", "noninteractive")
        .args(["install", "-y", "-qq", BROWSER])
        .stdout(Stdio::null());
    // Without root, or without a network, this is not to be had here.
    succeed(&mut install).map_err(|cause| {
        Stop::skipped(format!(
            "there is no {BROWSER}, and it can't be installed: {cause}"
        ))
    })?;
    program(BROWSER).ok_or_else(|| Stop::skipped(format!("there is no {BROWSER}")))
}

/// A program of the search path.
pub fn program(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH")?;
    std::env::split_paths(&path)
        .map(|folder| folder.join(name))
        .find(|file| file.is_file())
}
