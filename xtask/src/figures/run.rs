//! Running the program `phex` for the figures.

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

    /// Runs a command line that must make something: written (0), outside a tolerance (3) or invalid but kept (5).
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

    /// The path of an intermediate file.
    pub fn work(&self, name: &str) -> PathBuf {
        self.root.join(WORK).join(name)
    }

    /// The path of a file of the gallery.
    pub fn gallery(&self, name: &str) -> PathBuf {
        self.root.join(GALLERY).join(name)
    }
}
