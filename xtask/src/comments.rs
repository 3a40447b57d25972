//! The rule that comments of Rust files wrap at 100 columns. Rows of tables, formulas and code
//! between fences, and words that are longer than a line, can't be wrapped.

use std::path::Path;

/// Most characters in a line that is a comment.
const COLUMNS: usize = 100;

/// Checks every Rust file.
pub fn check(root: &Path) -> Result<(), String> {
    let mut complaints = Vec::new();
    for file in crate::files_below(root)? {
        if file.extension().is_none_or(|e| e != "rs") {
            continue;
        }
        let text = std::fs::read_to_string(&file).map_err(|e| e.to_string())?;
        let mut fenced = false;
        for (number, line) in text.lines().enumerate() {
            fenced ^= words(line).is_some_and(|w| w.starts_with("```"));
            if !fenced && is_too_long(line) {
                let (file, number) = (file.display(), number + 1);
                complaints.push(format!("{file}:{number}: a comment wider than {COLUMNS}"));
            }
        }
    }
    crate::verdict(complaints)
}

fn is_too_long(line: &str) -> bool {
    let wraps = |w: &str| !w.starts_with('|') && w.contains(' ');
    line.chars().count() > COLUMNS && words(line).is_some_and(wraps)
}

/// What a comment says, if a line is one.
fn words(line: &str) -> Option<&str> {
    let comment = line.trim_start().strip_prefix("//")?;
    Some(comment.trim_start_matches(['/', '!']).trim())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_comments_are_found_and_what_cannot_be_wrapped_is_free() {
        let long = "word ".repeat(25);
        assert!(is_too_long(&format!("    /// {long}")));
        assert!(!is_too_long(&format!("//! | {long} |")));
        assert!(!is_too_long(&format!("// {}", long.replace(' ', "-"))));
        assert!(!is_too_long(&format!("let text = \"{long}\";")));
        assert!(!is_too_long("// short"));
    }
}
