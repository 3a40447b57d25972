//! The rule that no two types of the workspace have one name, so that a name alone says what is
//! meant. Traits and aliases count as types; what tests and bodies of functions declare does not.

use crate::circles::sources::{Source, crate_folders, sources, without_tests};
use std::collections::BTreeMap;
use std::path::Path;

/// Checks every crate of the workspace.
pub fn check(root: &Path) -> Result<(), String> {
    let mut crates = Vec::new();
    for folder in crate_folders(root)? {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        crates.push((name.into_owned(), sources(&folder.join("src"))?));
    }
    crate::verdict(complaints(&crates))
}

/// Every name that is declared more than once, with its places.
fn complaints(crates: &[(String, Vec<Source>)]) -> Vec<String> {
    let mut places: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (name, sources) in crates {
        for source in without_tests(sources) {
            for declared in &source.types {
                let place = format!("{name}/src/{}", source.file);
                places.entry(declared).or_default().push(place);
            }
        }
    }
    let repeated = places.iter().filter(|(_, places)| places.len() > 1);
    repeated
        .map(|(name, places)| format!("`{name}` is declared in {}", places.join(", ")))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let read = |(file, text): &(&str, &str)| Source::new(file, text).unwrap();
        let sources = files.iter().map(read).collect();
        complaints(&[("x".to_owned(), sources)])
    }

    #[test]
    fn names_of_the_workspace_are_declared_once() {
        check(&crate::root()).unwrap();
    }

    #[test]
    fn types_of_one_name_are_found_whatever_their_kinds() {
        let hostile = [
            "pub enum Site { A }",
            "trait Site {}",
            "type Site = u8;",
            "#[derive(Debug)] pub(crate) struct Site<'a>(&'a u8);",
            "mod inner { struct Site; }",
        ];
        for b in hostile {
            let complaints = found(&[("a.rs", "pub struct Site;"), ("b.rs", b)]);
            assert_eq!(
                complaints,
                ["`Site` is declared in x/src/a.rs, x/src/b.rs"],
                "{b}"
            );
        }
    }

    #[test]
    fn tests_bodies_and_other_kinds_of_names_are_free() {
        let files = [
            ("lib.rs", "mod a; pub struct Site;"),
            (
                "a.rs",
                "const Site: u8 = 0; fn f() { struct Site; } impl T for U { type Site = u8; }\n\
                 // struct Site\n#[cfg(test)] mod tests { struct Site; }\n#[cfg(test)] mod more;",
            ),
            ("a/more.rs", "struct Site;"),
        ];
        assert!(found(&files).is_empty());
    }
}
