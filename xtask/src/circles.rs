//! The rule that modules of a crate do not use one another in a circle.
//!
//! The modules that one module declares are compared with one another, each with everything below
//! it: `a` uses `b` where a file of `a` names an item that a file of `b` defines. A module and
//! those that it declares itself are one thing here and may use each other. Test code is left out.

mod names;
pub mod sources;

use names::Names;
use sources::{Source, crate_folders, sources, without_tests};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Which modules a module uses, with a place of each use.
type Uses = BTreeMap<String, BTreeMap<String, String>>;

/// Checks every crate of the workspace.
pub fn check(root: &Path) -> Result<(), String> {
    let mut all = BTreeMap::new();
    for folder in crate_folders(root)? {
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        all.extend(uses(&name, &sources(&folder.join("src"))?));
    }
    crate::verdict(complaints(&all))
}

/// The circles of all modules.
fn complaints(all: &BTreeMap<String, Uses>) -> Vec<String> {
    let found = all.iter().flat_map(|(within, uses)| {
        let told = move |modules| told(within, uses, &modules);
        knots(uses).into_iter().map(told)
    });
    found.collect()
}

/// For each module of a crate which of the modules that it declares use which others.
fn uses(name: &str, sources: &[Source]) -> BTreeMap<String, Uses> {
    let sources = without_tests(sources);
    let names = Names::new(&sources);
    let mut all: BTreeMap<String, Uses> = BTreeMap::new();
    for source in sources {
        for path in &source.paths {
            let defined = names.module_of(&source.module, path);
            let pairs = source.module.iter().zip(&defined);
            let shared = pairs.take_while(|(a, b)| a == b).count();
            let (Some(user), Some(used)) = (source.module.get(shared), defined.get(shared)) else {
                continue;
            };
            let within = [&[name.to_owned()], &defined[..shared]].concat().join("::");
            let uses = all.entry(within).or_default();
            let place = format!("{} names {}", source.file, path.join("::"));
            let used_by = uses.entry(user.clone()).or_default();
            used_by.entry(used.clone()).or_insert(place);
        }
    }
    all
}

/// Sets of modules each of which reaches all others of its set.
fn knots(uses: &Uses) -> BTreeSet<BTreeSet<String>> {
    let reached: BTreeMap<&String, BTreeSet<String>> = uses
        .keys()
        .map(|from| (from, reached(uses, from)))
        .collect();
    let reaches = |a: &String, b: &String| reached.get(a).is_some_and(|r| r.contains(b));
    let knot = |a: &&String| -> BTreeSet<String> {
        let there = reached[*a].iter().filter(|b| reaches(b, a));
        there.cloned().collect()
    };
    let knots = uses.keys().map(|a| knot(&a));
    knots.filter(|knot| !knot.is_empty()).collect()
}

/// The modules that a module uses, directly or through others.
fn reached(uses: &Uses, from: &str) -> BTreeSet<String> {
    let (mut reached, mut open) = (BTreeSet::new(), vec![from.to_owned()]);
    while let Some(module) = open.pop() {
        for used in uses.get(&module).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(used.clone()) {
                open.push(used.clone());
            }
        }
    }
    reached
}

/// A circle in words, with a line for each use.
fn told(within: &str, uses: &Uses, modules: &BTreeSet<String>) -> String {
    let names: Vec<&str> = modules.iter().map(String::as_str).collect();
    let mut text = format!("{within}: {} use one another:", names.join(", "));
    for (user, used) in uses.iter().filter(|(user, _)| modules.contains(*user)) {
        for (to, place) in used.iter().filter(|(to, _)| modules.contains(*to)) {
            text += &format!("\n  {user} -> {to}: {place}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn uses_of(files: &[(&str, &str)]) -> BTreeMap<String, Uses> {
        let read = |(file, text): &(&str, &str)| Source::new(file, text).unwrap();
        let sources: Vec<Source> = files.iter().map(read).collect();
        uses("x", &sources)
    }

    /// The first words of each circle.
    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let complaints = complaints(&uses_of(files)).into_iter();
        complaints
            .map(|c| c.split(" use ").next().unwrap().to_owned())
            .collect()
    }

    #[test]
    fn workspace_has_no_circle() {
        check(&crate::root()).unwrap();
    }

    #[test]
    fn circle_is_found_however_it_is_written() {
        let hostile = [
            "use crate::a::A;",
            "use crate::{c, a::{A, B}};",
            "use super::a;",
            "fn f() { crate::a::make() }",
            "fn f() { assert!(super::a::is(3)) }",
            "mod inner { use super::super::a::A; }",
            "use crate::A;",
            "use crate as root; fn f() -> root::a::A {}",
        ];
        for b in hostile {
            let files = [
                ("lib.rs", "mod a; mod b; mod c; pub use a::A;"),
                ("a.rs", "use crate::b::B; pub struct A;"),
                ("b.rs", b),
                ("c.rs", "pub struct C;"),
            ];
            assert_eq!(found(&files), ["x: a, b"], "{b}");
        }
    }

    #[test]
    fn circle_through_others_and_deep_below_is_found() {
        let files = [
            ("lib.rs", "mod a; mod b; mod c;"),
            ("a/mod.rs", "mod p;"),
            ("a/p.rs", "use crate::b::q;"),
            ("b/mod.rs", "pub mod q;"),
            ("b/q.rs", "use crate::c::C;"),
            ("c.rs", "use crate::a::A;"),
        ];
        assert_eq!(found(&files), ["x: a, b, c"]);
        let siblings = [
            ("lib.rs", "mod a;"),
            ("a.rs", "mod p; mod q; use self::p::P;"),
            ("a/p.rs", "use super::q::Q;"),
            ("a/q.rs", "use super::P;"),
        ];
        assert_eq!(found(&siblings), ["x::a: p, q"]);
    }

    #[test]
    fn parents_tests_comments_and_one_way_are_free() {
        let files = [
            ("lib.rs", "mod a; mod b; pub use a::A;"),
            ("a/mod.rs", "mod p; mod q; use p::P; use q::Q; struct A;"),
            ("a/p.rs", "use super::A; use crate::b::B;"),
            ("a/q.rs", "use super::p::P; use super::P as R;"),
            (
                "b.rs",
                "//! See [`crate::a`].\n// crate::a::A\nconst X: &str = \"crate::a\";\n\
                 #[cfg(test)]\nmod tests { use crate::a::A; }\n#[cfg(test)] mod more;",
            ),
            ("b/more.rs", "use crate::a::A;"),
        ];
        assert!(found(&files).is_empty());
    }
}
