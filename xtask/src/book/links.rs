//! Links of Markdown files.

use std::path::{Path, PathBuf};

/// Where a relative link leads.
#[derive(Debug, PartialEq, Eq)]
pub struct LinkTarget {
    /// The file, from the folder of the text; empty for the text itself.
    pub path: String,
    /// The heading, as pages name it; empty for the file as a whole.
    pub heading: String,
}

/// The relative links of a text, outside of code.
pub fn targets(text: &str) -> Vec<LinkTarget> {
    let mut found = Vec::new();
    let mut fenced = false;
    for line in text.lines() {
        fenced ^= line.trim_start().starts_with("```");
        if !fenced {
            found.extend(of_line(line));
        }
    }
    found
}

fn of_line(line: &str) -> Vec<LinkTarget> {
    // What stands between backticks is code: every second piece.
    let prose: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
    let after_text = prose.split("](").skip(1);
    let links = after_text.filter_map(|rest| rest.split([')', ' ']).next());
    let relative = links.filter(|link| !link.contains("://") && !link.is_empty());
    let target = |link: &str| {
        let (path, heading) = link.split_once('#').unwrap_or((link, ""));
        LinkTarget {
            path: path.to_owned(),
            heading: heading.to_owned(),
        }
    };
    relative.map(target).collect()
}

/// What is wrong with the links of a file; `inside` is the folder that none of them may leave.
pub fn complaints(file: &Path, text: &str, inside: Option<&Path>) -> Vec<String> {
    let folder = file.parent().unwrap_or(file);
    let wrong = |target: LinkTarget| {
        let path = match target.path.as_str() {
            "" => file.to_path_buf(),
            path => normal(&folder.join(path)),
        };
        let why = problem(&path, &target.heading, inside)?;
        let link = format!("{}#{}", target.path, target.heading);
        Some(format!("{}: link `{link}`: {why}", file.display()))
    };
    targets(text).into_iter().filter_map(wrong).collect()
}

fn problem(path: &Path, heading: &str, inside: Option<&Path>) -> Option<&'static str> {
    if !path.exists() {
        return Some("no such file");
    }
    if inside.is_some_and(|folder| !path.starts_with(folder)) {
        return Some("leaves the book");
    }
    let named = heading.is_empty()
        || std::fs::read_to_string(path)
            .is_ok_and(|text| headings(&text).any(|name| name == heading));
    (!named).then_some("no such heading")
}

/// The headings of a text as pages name them.
fn headings(text: &str) -> impl Iterator<Item = String> {
    let lines = text.lines().filter(|line| line.starts_with('#'));
    lines.map(|line| {
        let words = line.trim_start_matches('#').trim().to_lowercase();
        let kept = words
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    })
}

/// A path without `..`.
fn normal(path: &Path) -> PathBuf {
    let mut parts = PathBuf::new();
    for part in path.components() {
        match part {
            std::path::Component::ParentDir => drop(parts.pop()),
            std::path::Component::CurDir => {}
            part => parts.push(part),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_found_and_code_is_none() {
        let text = "See [a](a.md#one), ![b](p/b.png) and [c](https://c.org).\n```\n[d](d.md)\n```\n`[e](e.md)` [f](#f)";
        let found: Vec<String> = (targets(text).into_iter())
            .map(|t| format!("{}#{}", t.path, t.heading))
            .collect();
        assert_eq!(found, ["a.md#one", "p/b.png#", "#f"]);
    }

    #[test]
    fn headings_are_named_as_pages_name_them() {
        let names: Vec<String> = headings("# Why 3, 4, 5?\ntext\n## `phex mesh`").collect();
        assert_eq!(names, ["why-3-4-5", "phex-mesh"]);
    }

    #[test]
    fn a_link_to_nowhere_or_out_of_the_book_is_told() {
        let here = Path::new(file!());
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/book");
        let file = folder.join(here.file_name().unwrap());
        let told = |text: &str| complaints(&file, text, Some(&folder));
        assert!(told("[a](links.rs)").is_empty());
        assert!(told("[a](nothing.md)")[0].contains("no such file"));
        assert!(told("[a](../main.rs)")[0].contains("leaves the book"));
        assert!(told("[a](links.rs#nowhere)")[0].contains("no such heading"));
    }
}
