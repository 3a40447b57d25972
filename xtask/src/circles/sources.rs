//! Source files of a crate, and the paths that their code names.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};
use std::path::{Path, PathBuf};

/// A path of a program, in segments. The first may be `crate`, `self` or `super`.
pub type Segments = Vec<String>;

/// A file, as far as the rule looks at it.
pub struct Source {
    /// Its name within `src`.
    pub file: String,
    /// The module that it is; the crate's root has no segments.
    pub module: Segments,
    /// Paths that its code names, from this module.
    pub paths: Vec<Segments>,
    /// Names that `use` brings into this module, with their paths; `*` for all of a module's.
    pub imports: Vec<(String, Segments)>,
    /// Modules that exist in tests only.
    pub test_modules: Vec<String>,
    /// Types, traits and aliases that it declares, outside of bodies.
    pub types: Vec<String>,
}

/// The folders of all crates of the workspace, this one too.
pub fn crate_folders(root: &Path) -> Result<Vec<PathBuf>, String> {
    let crates = root.join("crates");
    let fail = |e| format!("{}: {e}", crates.display());
    let mut folders = vec![root.join("xtask")];
    for entry in std::fs::read_dir(&crates).map_err(fail)? {
        folders.push(entry.map_err(fail)?.path());
    }
    folders.sort();
    Ok(folders)
}

/// All files of a folder of sources.
pub fn sources(folder: &Path) -> Result<Vec<Source>, String> {
    let mut sources = Vec::new();
    for path in crate::all_files_below(folder)? {
        if path.extension().is_some_and(|e| e == "rs") {
            let name = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy();
            sources.push(Source::new(&name.replace('\\', "/"), &crate::read(&path)?)?);
        }
    }
    Ok(sources)
}

/// Those of some files that are not of tests only.
pub fn without_tests(sources: &[Source]) -> Vec<&Source> {
    let tests = |s: &Source| -> Vec<Segments> {
        let names = s.test_modules.iter().cloned();
        names
            .map(|name| [&s.module[..], &[name]].concat())
            .collect()
    };
    let tests: Vec<Segments> = sources.iter().flat_map(tests).collect();
    let is_test = |s: &&Source| tests.iter().any(|test| s.module.starts_with(test));
    sources.iter().filter(|s| !is_test(s)).collect()
}

impl Source {
    /// Reads a file whose name within `src` is given.
    pub fn new(file: &str, text: &str) -> Result<Self, String> {
        let tokens: TokenStream = text.parse().map_err(|e| format!("{file}: {e}"))?;
        let mut source = Self {
            file: file.to_owned(),
            module: module(file),
            paths: Vec::new(),
            imports: Vec::new(),
            test_modules: Vec::new(),
            types: Vec::new(),
        };
        source.types(tokens.clone());
        source.scan(tokens, 0);
        Ok(source)
    }

    /// Collects the types that a module declares, and those of the modules in it.
    fn types(&mut self, tokens: TokenStream) {
        const WORDS: [&str; 4] = ["struct", "enum", "trait", "type"];
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            match &tokens[at..] {
                tests if is_test_attribute(tests) => {
                    at += skipped_item(tests).0;
                    continue;
                }
                [word, TokenTree::Ident(name), ..] if WORDS.iter().any(|w| is_word(word, w)) => {
                    self.types.push(name.to_string());
                }
                [word, _, TokenTree::Group(body), ..] if is_word(word, "mod") => {
                    self.types(body.stream());
                }
                _ => {}
            }
            at += 1;
        }
    }

    /// Collects paths; `depth` counts the modules within the file that the tokens lie in.
    fn scan(&mut self, tokens: TokenStream, depth: usize) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            at += self.item(&tokens[at..], depth);
        }
    }

    /// Reads what the tokens begin with; returns the number of tokens that this takes.
    fn item(&mut self, tokens: &[TokenTree], depth: usize) -> usize {
        if is_test_attribute(tokens) {
            let (length, module) = skipped_item(tokens);
            self.test_modules.extend(module);
            return length;
        }
        match tokens {
            [first, rest @ ..] if is_word(first, "use") => {
                let length = rest.iter().position(|t| is_sign(t, ';'));
                let length = length.unwrap_or(rest.len());
                self.import(&rest[..length], depth);
                length + 1
            }
            [first, _, TokenTree::Group(body), ..] if is_word(first, "mod") => {
                self.scan(body.stream(), depth + 1);
                3
            }
            [TokenTree::Group(group), ..] => {
                self.scan(group.stream(), depth);
                1
            }
            [TokenTree::Ident(_), ..] => {
                let (path, length) = path(tokens);
                if path.len() > 1 {
                    self.paths.extend(at_depth(path, depth));
                }
                length
            }
            _ => 1,
        }
    }

    /// Records what a `use` brings in.
    fn import(&mut self, tree: &[TokenTree], depth: usize) {
        let mut leaves = Vec::new();
        open_tree(&Vec::new(), tree, &mut leaves);
        for (name, path) in leaves {
            let Some(path) = at_depth(path, depth) else {
                continue;
            };
            if depth == 0 {
                self.imports.push((name, path.clone()));
            }
            self.paths.push(path);
        }
    }
}

/// The module that a file is.
fn module(file: &str) -> Segments {
    let mut module: Segments = file
        .trim_end_matches(".rs")
        .split('/')
        .map(str::to_owned)
        .collect();
    let last = module.last().map(String::as_str);
    if last == Some("mod") || module.len() == 1 && matches!(last, Some("lib" | "main")) {
        module.pop();
    }
    module
}

/// A path of a module within the file, from the file's own module; nothing if it stays inside.
fn at_depth(mut path: Segments, depth: usize) -> Option<Segments> {
    if depth == 0 || path[0] == "crate" {
        return Some(path);
    }
    let climbs = path.iter().take_while(|s| *s == "super").count();
    if climbs < depth {
        return None;
    }
    path.drain(..depth);
    if climbs == depth {
        path.insert(0, "self".to_owned());
    }
    Some(path)
}

fn is_word(token: &TokenTree, word: &str) -> bool {
    matches!(token, TokenTree::Ident(ident) if ident == word)
}

fn is_sign(token: &TokenTree, sign: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == sign)
}

/// Whether tokens begin with `#[cfg(test)]`.
fn is_test_attribute(tokens: &[TokenTree]) -> bool {
    let [hash, TokenTree::Group(attribute), ..] = tokens else {
        return false;
    };
    let text = attribute.to_string().replace(' ', "");
    is_sign(hash, '#') && text == "[cfg(test)]"
}

/// Length of an item that begins with its attribute, and its name if it is a module.
fn skipped_item(tokens: &[TokenTree]) -> (usize, Option<String>) {
    let is_end = |t: &TokenTree| match t {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        other => is_sign(other, ';'),
    };
    let end = tokens.iter().position(is_end).unwrap_or(tokens.len() - 1);
    let module = tokens[..end].iter().position(|t| is_word(t, "mod"));
    (end + 1, module.map(|at| tokens[at + 1].to_string()))
}

/// The path that tokens begin with, and the number of its tokens.
fn path(tokens: &[TokenTree]) -> (Segments, usize) {
    let mut path = Vec::new();
    let mut length = 0;
    while let Some(TokenTree::Ident(ident)) = tokens.get(length) {
        path.push(ident.to_string());
        length += 1;
        let more = tokens.get(length..length + 2);
        if !more.is_some_and(|two| two.iter().all(|t| is_sign(t, ':'))) {
            break;
        }
        length += 2;
    }
    (path, length)
}

/// All names that a tree of a `use` brings in.
fn open_tree(prefix: &Segments, tree: &[TokenTree], leaves: &mut Vec<(String, Segments)>) {
    // A path of the language's own begins with two colons.
    let tree = match tree {
        [a, b, rest @ ..] if is_sign(a, ':') && is_sign(b, ':') => rest,
        tree => tree,
    };
    let (path, length) = path(tree);
    let whole = [&prefix[..], &path].concat();
    match &tree[length..] {
        [TokenTree::Group(group), ..] => open_group(&whole, group, leaves),
        [star, ..] if is_sign(star, '*') => leaves.push(("*".to_owned(), whole)),
        [word, name, ..] if is_word(word, "as") => leaves.push((name.to_string(), trimmed(whole))),
        _ => {
            let path = trimmed(whole);
            leaves.extend(path.last().cloned().map(|name| (name, path)));
        }
    }
}

/// Opens the trees between braces.
fn open_group(prefix: &Segments, group: &Group, leaves: &mut Vec<(String, Segments)>) {
    let tokens: Vec<TokenTree> = group.stream().into_iter().collect();
    for tree in tokens.split(|t| is_sign(t, ',')) {
        if !tree.is_empty() {
            open_tree(prefix, tree, leaves);
        }
    }
}

/// `a::b` of `a::b::self`.
fn trimmed(mut path: Segments) -> Segments {
    if path.len() > 1 && path.last().is_some_and(|s| s == "self") {
        path.pop();
    }
    path
}
