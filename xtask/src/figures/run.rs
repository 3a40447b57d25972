//! Running the program `phex` for the figures.

use super::steps;
use std::cell::RefCell;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Folder of intermediate files, below the repository's root.
pub const WORK: &str = "out/gallery";
/// Folder of the gallery.
pub const GALLERY: &str = "docs/gallery";

/// What a run of the program said.
#[derive(Clone, Debug)]
pub struct Said {
    /// The command line, as it can be typed.
    pub line: String,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
    /// Exit code.
    pub code: i32,
}

impl Said {
    /// The rest of the first line of the table that begins with a word.
    pub fn row(&self, label: &str) -> Option<&str> {
        let line = self
            .out
            .lines()
            .find(|l| l.split_whitespace().next() == Some(label))?;
        Some(line[label.len()..].trim())
    }
}

/// The program, built.
pub struct Phex {
    root: PathBuf,
    program: PathBuf,
    /// What was made already: figures share inputs, and each gives the commands that make its own.
    made: RefCell<HashSet<String>>,
}

impl Phex {
    /// Builds the program and makes the folders.
    pub fn build(root: &Path) -> Result<Self, String> {
        crate::cargo(root, &["build", "--release", "--package", "phex-cli"])?;
        for folder in [WORK, GALLERY] {
            std::fs::create_dir_all(root.join(folder)).map_err(|e| format!("{folder}: {e}"))?;
        }
        let program = root
            .join("target/release")
            .join(format!("phex{}", std::env::consts::EXE_SUFFIX));
        Ok(Self {
            root: root.to_path_buf(),
            program,
            made: RefCell::default(),
        })
    }

    /// Runs a command line; the exit code is for the caller to judge.
    pub fn run(&self, line: &str) -> Result<Said, String> {
        let output = Command::new(&self.program)
            .current_dir(&self.root)
            .args(line.split_whitespace())
            .output()
            .map_err(|e| format!("phex {line}: {e}"))?;
        Ok(Said {
            line: format!("phex {line}"),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
            code: output.status.code().unwrap_or(-1),
        })
    }

    /// Runs a command line that must make something: written (0), outside a tolerance (3) or
    /// invalid but kept (5).
    pub fn make(&self, line: &str) -> Result<Said, String> {
        let said = self.run(line)?;
        if [0, 3, 5].contains(&said.code) && said.err.is_empty() {
            Ok(said)
        } else {
            Err(format!(
                "phex {line}\nended with {}: {}",
                said.code, said.err
            ))
        }
    }

    /// Makes what a command line makes, of the program, of `cargo xtask obj` or of `printf`, unless
    /// that was done already.
    pub fn follow(&self, line: &str) -> Result<(), String> {
        if !self.made.borrow_mut().insert(line.to_owned()) {
            return Ok(());
        }
        if let Some(line) = line.strip_prefix("phex ") {
            return self.make(line).map(|_| ());
        }
        if let Some(step) = line.strip_prefix("cargo xtask obj ") {
            let words: Vec<&str> = step.split_whitespace().collect();
            return steps::run(&self.root, &words);
        }
        let text = line
            .strip_prefix("printf '")
            .and_then(|l| l.split_once("' > "));
        let (text, path) = text.ok_or_else(|| format!("`{line}` is not understood"))?;
        let path = self.root.join(path);
        std::fs::write(&path, text.replace("\\n", "\n"))
            .map_err(|e| format!("{}: {e}", path.display()))
    }

    /// Remembers that a command line of the program was run.
    pub fn remember(&self, line: &str) {
        self.made.borrow_mut().insert(format!("phex {line}"));
    }

    /// The path of an intermediate file.
    pub fn work(&self, name: &str) -> PathBuf {
        self.root.join(WORK).join(name)
    }

    /// The path of a file of the gallery.
    pub fn gallery(&self, name: &str) -> PathBuf {
        self.root.join(GALLERY).join(name)
    }
}
