//! The rule that crates depend on one another one way only.

use std::path::Path;

/// Each crate with the crates of the workspace that it may depend on.
const ARROWS: [(&str, &[&str]); 11] = [
    ("phex-mesh", &[]),
    ("phex-numeric", &[]),
    ("phex", &["phex-mesh", "phex-numeric"]),
    ("phex-picture", &["phex-mesh", "phex"]),
    ("phex-html", &["phex-mesh", "phex", "phex-picture"]),
    ("phex-fab", &["phex-mesh", "phex", "phex-picture"]),
    ("phex-job", &["phex-mesh", "phex-numeric", "phex"]),
    (
        "phex-study",
        &[
            "phex-mesh",
            "phex",
            "phex-job",
            "phex-picture",
            "phex-html",
            "phex-fab",
        ],
    ),
    (
        "phex-studio",
        &[
            "phex-mesh",
            "phex",
            "phex-job",
            "phex-picture",
            "phex-html",
            "phex-fab",
        ],
    ),
    (
        "phex-python",
        &[
            "phex-mesh",
            "phex",
            "phex-job",
            "phex-picture",
            "phex-html",
            "phex-fab",
            "phex-study",
        ],
    ),
    (
        "phex-cli",
        &[
            "phex-mesh",
            "phex-numeric",
            "phex",
            "phex-job",
            "phex-picture",
            "phex-html",
            "phex-fab",
            "phex-study",
            "phex-studio",
        ],
    ),
];

/// Checks the manifest of every crate.
pub fn check(root: &Path) -> Result<(), String> {
    let mut complaints = Vec::new();
    for (name, allowed) in ARROWS {
        let manifest = root.join("crates").join(name).join("Cargo.toml");
        for dependency in own_dependencies(&crate::read(&manifest)?) {
            if !allowed.contains(&dependency.as_str()) {
                complaints.push(format!(
                    "{}: `{name}` may not depend on `{dependency}`",
                    manifest.display()
                ));
            }
        }
    }
    crate::verdict(complaints)
}

/// Names of the crates of this workspace that a manifest lists, outside of the dependencies of
/// tests.
fn own_dependencies(manifest: &str) -> Vec<String> {
    let mut section = String::new();
    let mut found = Vec::new();
    for line in manifest.lines().map(str::trim) {
        if let Some(header) = line.strip_prefix('[') {
            section = header.trim_end_matches(']').to_owned();
            found.extend(section.strip_prefix("dependencies.").map(str::to_owned));
        } else if section.ends_with("dependencies") && section != "dev-dependencies" {
            let name = line.split(['=', '.', ' ']).next().unwrap_or("");
            found.push(name.to_owned());
        }
    }
    found.retain(|name| name == "phex" || name.starts_with("phex-"));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dependencies_are_found_in_every_notation() {
        let manifest = "[package]\nname = \"phex-mesh\"\n[dependencies]\nphex.workspace = true\nphex-cli = { path = \"x\" }\n\
                        serde = \"1\"\n[dependencies.phex-numeric]\npath = \"y\"\n[dev-dependencies]\nphex-studio = \"1\"\n";
        assert_eq!(
            own_dependencies(manifest),
            ["phex", "phex-cli", "phex-numeric"]
        );
    }
}
