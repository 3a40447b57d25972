//! The rule that no file of the repository names a folder of somebody's machine.

use std::path::Path;

/// Folders at the root of a machine that no portable text names.
const MACHINE_FOLDERS: [&str; 4] = ["work", "root", "home", "Users"];

/// Checks every text file.
pub fn check(root: &Path) -> Result<(), String> {
    let mut complaints = Vec::new();
    for file in crate::files_below(root)? {
        let Ok(text) = std::fs::read_to_string(&file) else {
            continue;
        };
        for (number, line) in text.lines().enumerate() {
            if names_machine_path(line) {
                complaints.push(format!(
                    "{}:{}: machine path in `{}`",
                    file.display(),
                    number + 1,
                    line.trim()
                ));
            }
        }
    }
    crate::verdict(complaints)
}

fn names_machine_path(line: &str) -> bool {
    MACHINE_FOLDERS.iter().any(|folder| {
        let path = format!("/{folder}/");
        line.match_indices(&path)
            .any(|(at, _)| !continues_a_path(&line[..at]))
    })
}

/// Whether a slash after this text belongs to a longer path (`frame/work/` names no machine
/// folder).
fn continues_a_path(before: &str) -> bool {
    before
        .chars()
        .next_back()
        .is_some_and(|c| c.is_alphanumeric() || ".-_~/".contains(c))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn absolute_paths_are_found_and_relative_ones_are_free() {
        let folder = |name: &str| format!("let path = \"/{name}/me/roof.obj\";");
        assert!(names_machine_path(&folder("work")) && names_machine_path(&folder("root")));
        assert!(!names_machine_path(
            "see frame/work/notes and https://example.org/home/x"
        ));
        assert!(!names_machine_path("data/roof.obj"));
    }
}
