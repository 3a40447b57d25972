//! The licences of the packages that are inside of the program, as one text.

use crate::{cargo, target_folder};
use serde::Deserialize;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// What gathers them, and its version.
const TOOL: (&str, &str) = ("cargo-bundle-licenses", "5.0.0");
/// The folder of the program's manifest.
const PROGRAM: &str = "crates/phex-cli";
/// What that says of a text that is in no file of a package.
const MISSING: &str = "NOT FOUND";
/// Where texts stand that some packages name and do not hold.
const STANDARD: [(&str, &str); 3] = [
    ("MIT", "as LICENSE-MIT, with the copyright of its authors"),
    ("Apache-2.0", "as LICENSE-APACHE"),
    ("MPL-2.0", "at https://www.mozilla.org/MPL/2.0/"),
];

/// How the text begins; the tool sees neither of the two that are no packages of Rust.
const HEADING: &str = "phex has the packages of this list inside; some of them only on other systems. It also has Rust's
standard library (MIT OR Apache-2.0, https://github.com/rust-lang/rust), and for its reports
three.js (MIT), whose licence stands in every report that uses it.

";

#[derive(Deserialize)]
struct Gathered {
    third_party_libraries: Vec<Library>,
}

#[derive(Deserialize)]
struct Library {
    package_name: String,
    package_version: String,
    repository: String,
    license: String,
    licenses: Vec<LicenceText>,
}

#[derive(Deserialize)]
struct LicenceText {
    license: String,
    text: String,
}

/// Gathers them; the tool is installed below `target` where it is missing.
pub fn of_program(root: &Path) -> Result<String, String> {
    let (tool, version) = TOOL;
    let tools = target_folder(root).join("tools");
    let place = tools.to_string_lossy();
    let install = ["install", tool, "--version", version, "--locked", "--quiet"];
    cargo(root, &[&install[..], &["--root", &place]].concat())?;
    let mut gather = Command::new(tools.join("bin").join(tool));
    gather.current_dir(root.join(PROGRAM));
    gather.args(["bundle-licenses", "--format", "json"]);
    // Its warnings, hundreds of lines, say what the text says of each package.
    let gathered = gather.env("RUST_LOG", "error").output();
    let gathered = gathered.map_err(|e| format!("{tool}: {e}"))?;
    if !gathered.status.success() {
        return Err(String::from_utf8_lossy(&gathered.stderr).into_owned());
    }
    let gathered: Gathered =
        serde_json::from_slice(&gathered.stdout).map_err(|e| format!("{tool}: {e}"))?;
    let mut libraries = gathered.third_party_libraries;
    // The crates of the workspace have the licences of phex.
    libraries.retain(|l| l.package_name.split('-').next() != Some("phex"));
    as_text(&libraries)
}

/// Packages with their licences, then every text once.
fn as_text(libraries: &[Library]) -> Result<String, String> {
    let mut list = HEADING.to_owned();
    let mut texts: Vec<&str> = Vec::new();
    for library in libraries {
        let Library {
            package_name,
            package_version,
            repository,
            license,
            ..
        } = library;
        // Writing to a string does not fail.
        let _ = writeln!(
            list,
            "{package_name} {package_version}, {repository}\n    {license}"
        );
        for line in lines(library, &mut texts)? {
            let _ = writeln!(list, "    {line}");
        }
    }
    for (number, text) in texts.iter().enumerate() {
        let rule = "-".repeat(60);
        let _ = write!(
            list,
            "\n{rule}\ntext {}\n\n{}\n",
            number + 1,
            text.trim_end()
        );
    }
    Ok(list)
}

/// Where the texts of a package's licences stand; new ones are added to the list.
fn lines<'a>(library: &'a Library, texts: &mut Vec<&'a str>) -> Result<Vec<String>, String> {
    let mut said = Vec::new();
    for LicenceText { license, text } in &library.licenses {
        if text.trim() == MISSING {
            let standard = STANDARD.iter().find(|(name, _)| name == license);
            said.extend(standard.map(|(name, place)| format!("{name}: {place}")));
            continue;
        }
        let known = texts.iter().position(|t| t == text);
        let number = known.unwrap_or_else(|| {
            texts.push(text);
            texts.len() - 1
        });
        said.push(format!("{license}: text {}", number + 1));
    }
    match said.is_empty() {
        false => Ok(said),
        true => Err(format!(
            "{} {} has no text of its licence {}",
            library.package_name, library.package_version, library.license
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn library(name: &str, texts: &[(&str, &str)]) -> Library {
        Library {
            package_name: name.to_owned(),
            package_version: "1.0.0".to_owned(),
            repository: "https://github.com/a/b".to_owned(),
            license: "MIT OR Zlib".to_owned(),
            licenses: texts
                .iter()
                .map(|(license, text)| LicenceText {
                    license: (*license).to_owned(),
                    text: (*text).to_owned(),
                })
                .collect(),
        }
    }

    #[test]
    fn every_text_stands_once_and_missing_ones_are_told() {
        let all = [
            library("one", &[("MIT", "Be free."), ("Zlib", MISSING)]),
            library("two", &[("MIT", "Be free.")]),
            library("three", &[("MIT", MISSING)]),
        ];
        let text = as_text(&all).unwrap();
        assert_eq!(text.matches("Be free.").count(), 1, "{text}");
        assert_eq!(text.matches("    MIT: text 1\n").count(), 2, "{text}");
        assert!(text.contains("    MIT: as LICENSE-MIT"), "{text}");
    }

    #[test]
    fn a_package_without_any_text_stops_the_release() {
        let told = as_text(&[library("bare", &[("Zlib", MISSING)])]).unwrap_err();
        assert!(told.contains("bare 1.0.0"), "{told}");
    }
}
