//! The rule that a stage of the pipeline uses earlier stages only.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// The stages in the order of the data flow.
const ORDER: [&str; 15] = [
    "smooth_surface",
    "curvature",
    "directions",
    "classical",
    "layout",
    "optimise",
    "symmetry",
    "trim",
    "quality",
    "search",
    "repetition",
    "koebe",
    "offset",
    "report",
    "pipeline",
];

/// Checks every source file of every stage, and that every folder is one.
pub fn check(root: &Path) -> Result<(), String> {
    let source = root.join("crates/phex/src");
    let files = crate::all_files_below(&source)?;
    let mut complaints = unknown(&source, &files);
    for (position, stage) in ORDER.iter().enumerate() {
        for file in files.iter().filter(|file| module(&source, file) == *stage) {
            let depth = module_depth(file.strip_prefix(&source).unwrap_or(file));
            for later in later_stages(&crate::read(file)?, position, depth) {
                complaints.push(format!(
                    "{}: stage `{stage}` uses the later stage `{later}`",
                    file.display()
                ));
            }
        }
    }
    crate::verdict(complaints)
}

/// What is said of stages without files and of folders that are no stage.
fn unknown(source: &Path, files: &[PathBuf]) -> Vec<String> {
    let missing = ORDER
        .iter()
        .filter(|stage| !files.iter().any(|f| module(source, f) == **stage));
    let missing = missing.map(|stage| format!("stage `{stage}` has no file"));
    let is_folder = |f: &&PathBuf| f.parent().is_some_and(|folder| folder != source);
    let folders: BTreeSet<String> = files
        .iter()
        .filter(is_folder)
        .map(|f| module(source, f))
        .collect();
    let strange = folders
        .into_iter()
        .filter(|name| !ORDER.contains(&name.as_str()));
    let strange = strange.map(|name| format!("folder `{name}` is no stage in the order of stages"));
    missing.chain(strange).collect()
}

/// The module of the crate's root that a file is or lies in.
fn module(source: &Path, file: &Path) -> String {
    let inner = file.strip_prefix(source).unwrap_or(file);
    let first = inner
        .components()
        .next()
        .map(|c| c.as_os_str().to_string_lossy());
    first.unwrap_or_default().trim_end_matches(".rs").to_owned()
}

/// How many modules a file lies below the crate's root.
fn module_depth(path_in_source: &Path) -> usize {
    let parts = path_in_source.components().count();
    if path_in_source
        .file_name()
        .is_some_and(|name| name == "mod.rs")
    {
        parts - 1
    } else {
        parts
    }
}

/// Stages after `position` that a source text names in its code.
fn later_stages(source: &str, position: usize, depth: usize) -> Vec<&'static str> {
    let code: String = source
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""))
        .collect::<Vec<_>>()
        .join(" ");
    let named = names_at_root(&code, depth);
    ORDER[position + 1..]
        .iter()
        .filter(|stage| named.iter().any(|name| name == *stage))
        .copied()
        .collect()
}

/// First path segments after `crate::`, or after enough `super::` to reach the crate's root; groups
/// are opened.
fn names_at_root(code: &str, depth: usize) -> Vec<String> {
    let mut names = Vec::new();
    for (start, _) in code.match_indices("crate::") {
        if !ends_in_word(&code[..start]) {
            names.extend(first_segments(&code[start + "crate::".len()..]));
        }
    }
    let climb = "super::".repeat(depth);
    for (start, _) in code.match_indices(&climb) {
        let rest = code[start..].trim_start_matches("super::");
        names.extend(first_segments(rest));
    }
    names
}

fn ends_in_word(text: &str) -> bool {
    text.chars().next_back().is_some_and(is_word)
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

/// `a` of `a::b`, and `a`, `c` of `{a::b, c}`.
fn first_segments(path: &str) -> Vec<String> {
    let word = |text: &str| {
        text.trim_start()
            .chars()
            .take_while(|&c| is_word(c))
            .collect::<String>()
    };
    let Some(group) = path.trim_start().strip_prefix('{') else {
        return vec![word(path)];
    };
    let (mut depth, mut items) = (0, vec![String::new()]);
    for c in group.chars() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => items.push(String::new()),
            _ if depth == 0 => items.last_mut().expect("never empty").push(c),
            _ => {}
        }
    }
    items.iter().map(|item| word(item)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const CURVATURE: usize = 1;

    #[test]
    fn later_stage_is_found_however_it_is_written() {
        let hostile = [
            "use crate::layout::Layout;",
            "use crate::{Progress, layout::{Layout, VertexKind}};",
            "use crate::{\n    smooth_surface,\n    layout,\n};",
            "fn f() { crate::layout::make() }",
            "use super::layout::Layout;",
            "mod tests { use super::super::layout::Layout; }",
        ];
        for source in hostile {
            assert_eq!(later_stages(source, CURVATURE, 1), ["layout"], "{source}");
        }
        assert_eq!(
            later_stages("use super::super::layout;", CURVATURE, 2),
            ["layout"]
        );
    }

    #[test]
    fn earlier_stages_own_modules_and_comments_are_free() {
        let harmless = [
            "use crate::smooth_surface::SmoothTarget;",
            "use crate::curvature::layout;",
            "use crate::{Event, smooth_surface::{layout, SmoothTarget}};",
            "//! See [`crate::layout`].",
            "use my_crate::layout::Layout;",
            "let layout = 3;",
        ];
        for source in harmless {
            assert!(later_stages(source, CURVATURE, 1).is_empty(), "{source}");
        }
        assert!(
            later_stages("use super::layout;", CURVATURE, 2).is_empty(),
            "a module of the stage itself"
        );
    }

    #[test]
    fn every_folder_is_a_stage_and_every_stage_has_files() {
        let source = Path::new("src");
        let stages = ORDER.map(|stage| source.join(stage).join("mod.rs"));
        assert!(unknown(source, &stages).is_empty());
        let file = source.join("pipeline.rs");
        let root = source.join("lib.rs");
        let with_file: Vec<PathBuf> = stages[..ORDER.len() - 1]
            .iter()
            .cloned()
            .chain([file, root])
            .collect();
        assert!(unknown(source, &with_file).is_empty());
        assert_eq!(unknown(source, &stages[1..]).len(), 1);
        let strange = source.join("out").join("deep").join("a.rs");
        let more: Vec<PathBuf> = stages.iter().cloned().chain([strange]).collect();
        assert_eq!(unknown(source, &more).len(), 1);
    }

    #[test]
    fn depth_counts_modules() {
        assert_eq!(module_depth(Path::new("layout/mod.rs")), 1);
        assert_eq!(module_depth(Path::new("layout/waves.rs")), 2);
        assert_eq!(module_depth(Path::new("report/picture/mod.rs")), 2);
    }
}
