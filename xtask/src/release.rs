//! What a release is made of, besides the crates and the wheels: the program in an archive for
//! machines without Rust, and the notes that go with it.

use crate::{Stop, cargo, old_linux, read, succeed, viewer};
use std::path::{Path, PathBuf};
use std::process::Command;

mod licences;

/// The version of all crates.
const VERSION: &str = env!("CARGO_PKG_VERSION");
/// Where in the archive texts are.
const TEXTS: &str = "share/doc/phex";
/// Where shells look for completions, and what `phex generate` calls them.
const COMPLETIONS: [(&str, &str); 3] = [
    ("phex.bash", "share/bash-completion/completions/phex"),
    ("_phex", "share/zsh/site-functions/_phex"),
    ("phex.fish", "share/fish/vendor_completions.d/phex.fish"),
];

/// Makes `target/release-files/phex-VERSION-ARCH-SYSTEM.tar.gz`. Its folders are those of
/// `/usr/local`; on Linux its program runs on old systems.
pub fn release(root: &Path) -> Result<(), Stop> {
    viewer::build(root)?;
    let program = built(root)?;
    let (arch, system) = (std::env::consts::ARCH, std::env::consts::OS);
    let name = format!("phex-{VERSION}-{arch}-{system}");
    let out = crate::target_folder(root).join("release-files");
    let folder = out.join(&name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    }
    fill(root, &folder, &program)?;
    let archive = out.join(format!("{name}.tar.gz"));
    let mut pack = Command::new("tar");
    // Whoever unpacks it as root does not get files of a user of this machine.
    if cfg!(target_os = "linux") {
        pack.args(["--owner=0", "--group=0", "--sort=name"]);
    }
    pack.arg("-czf").arg(&archive).arg("-C").arg(&out);
    succeed(pack.arg(&name))?;
    println!("{}", archive.display());
    Ok(())
}

/// The program; on Linux only the last link step is that for old systems.
fn built(root: &Path) -> Result<PathBuf, Stop> {
    let words = "rustc --release --locked -p phex-cli --bin phex -- -C strip=symbols";
    let mut words: Vec<String> = words.split(' ').map(str::to_owned).collect();
    let linux = cfg!(target_os = "linux");
    if linux {
        words.extend(old_linux::linking(root)?);
    }
    cargo(root, &words.iter().map(String::as_str).collect::<Vec<_>>())?;
    let name = format!("phex{}", std::env::consts::EXE_SUFFIX);
    let program = crate::target_folder(root).join("release").join(name);
    if linux {
        old_linux::check(&program)?;
    }
    Ok(program)
}

/// Puts everything into the archive's folder.
fn fill(root: &Path, folder: &Path, program: &Path) -> Result<(), Stop> {
    let name = program.file_name().unwrap_or_default();
    let placed = folder.join("bin").join(name);
    crate::copied(program, &placed)?;
    let generate = |what: &str, place: &Path| {
        let mut generate = Command::new(&placed);
        succeed(generate.args(["generate", what, "-o"]).arg(place))
    };
    generate("man", &folder.join("share/man/man1"))?;
    let completions = folder.with_file_name("completions");
    generate("completions", &completions)?;
    for (made, place) in COMPLETIONS {
        crate::copied(&completions.join(made), &folder.join(place))?;
    }
    for text in ["README.md", "CHANGELOG.md", "LICENSE-APACHE", "LICENSE-MIT"] {
        crate::copied(&root.join(text), &folder.join(TEXTS).join(text))?;
    }
    let licences = licences::of_program(root)?;
    let file = folder.join(TEXTS).join("THIRD-PARTY.txt");
    Ok(crate::write(&file, &licences)?)
}

/// Prints what the changelog says of this version; a tag, where one is typed, has to name it.
pub fn notes(root: &Path, words: &[&str]) -> Result<(), Stop> {
    match words {
        [] => {}
        [tag] if tag.strip_prefix('v') == Some(VERSION) => {}
        _ => return Err(Stop::from(format!("the tag of this version is v{VERSION}"))),
    }
    let changelog = read(&root.join("CHANGELOG.md"))?;
    println!("{}", section(&changelog, VERSION)?);
    Ok(())
}

/// What a changelog says of a version, without its heading.
fn section<'a>(changelog: &'a str, version: &str) -> Result<&'a str, String> {
    let heading = format!("\n## [{version}]");
    let missing = || format!("CHANGELOG.md has no section [{version}]");
    let start = changelog.find(&heading).ok_or_else(missing)? + heading.len();
    let rest = &changelog[start..];
    let rest = rest.split_once('\n').map_or("", |(_, below)| below);
    let text = rest.split("\n## [").next().unwrap_or_default().trim();
    if text.is_empty() {
        return Err(format!("CHANGELOG.md says nothing of [{version}]"));
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const CHANGELOG: &str = "# Changelog\n\n## [Unreleased]\n\n- New.\n\n## [0.2.0] - 2026-01-01\n\n- Faster.\n- Better.\n\n## [0.1.0]\n\nThe first.\n\n## [0.0.1]\n";

    #[test]
    fn notes_are_the_section_of_one_version_and_nothing_else() {
        assert_eq!(section(CHANGELOG, "0.2.0").unwrap(), "- Faster.\n- Better.");
        assert_eq!(section(CHANGELOG, "0.1.0").unwrap(), "The first.");
        assert_eq!(section(CHANGELOG, "Unreleased").unwrap(), "- New.");
        let missing = section(CHANGELOG, "0.3.0").unwrap_err();
        assert!(missing.contains("[0.3.0]"), "{missing}");
        assert!(section(CHANGELOG, "0.0.1").is_err(), "an empty section");
    }

    #[test]
    fn this_version_has_notes_and_its_own_tag_alone() {
        let root = crate::root();
        assert!(notes(&root, &[&format!("v{VERSION}")]).is_ok());
        assert!(notes(&root, &["v0.0.0"]).is_err());
        assert!(notes(&root, &[VERSION]).is_err());
    }
}
