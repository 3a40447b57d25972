//! Running the program in a folder of its own.

// Every test file is a program of its own and uses a part of this.
#![allow(dead_code)]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A temporary folder in which the program runs.
pub struct Workshop {
    folder: tempfile::TempDir,
}

/// What a run of the program gave.
pub struct Run {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Workshop {
    pub fn new() -> Self {
        Self {
            folder: tempfile::tempdir().expect("a temporary folder"),
        }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        let folder = path.parent().expect("a folder");
        std::fs::create_dir_all(folder).expect("a writable folder");
        std::fs::write(path, content).expect("a writable folder");
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).expect("valid JSON")
    }

    /// Names of all files, sorted.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("a readable folder");
        let mut names: Vec<String> = entries
            .map(|e| {
                e.expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect();
        names.sort();
        names
    }

    /// The program with arguments separated by blanks, not started yet.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_phex"));
        command
            .current_dir(self.folder.path())
            .args(arguments.split_whitespace());
        command
    }

    pub fn phex(&self, arguments: &str) -> Run {
        self.command(arguments)
            .output()
            .expect("the program starts")
            .into()
    }

    /// Runs the program and expects success.
    pub fn succeed(&self, arguments: &str) -> Run {
        let run = self.phex(arguments);
        assert_eq!(
            run.code,
            Some(0),
            "phex {arguments}\n{}{}",
            run.stdout,
            run.stderr
        );
        run
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code(),
            stdout: String::from_utf8_lossy(&output.stdout).into_owned(),
            stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
        }
    }
}

impl Run {
    /// Expects that there is a result, whatever its verdict; `what` was run.
    pub fn ends_well(&self, what: &str) {
        let well = matches!(self.code, Some(0 | 3));
        assert!(
            well,
            "{what}: {:?}\n{}{}",
            self.code, self.stdout, self.stderr
        );
    }

    /// Expects an exit code and every one of some texts on standard error.
    pub fn refuses(&self, code: i32, texts: &[&str]) {
        assert_eq!(self.code, Some(code), "{}{}", self.stdout, self.stderr);
        for text in texts {
            assert!(
                self.stderr.contains(text),
                "`{text}` is missing in: {}",
                self.stderr
            );
        }
    }
}

/// A flat honeycomb of `rows` x `columns` hexagons of edge 1; each vertex is shifted by
/// `shift(vertex, position)`.
pub fn honeycomb(
    rows: usize,
    columns: usize,
    shift: impl Fn(usize, [f64; 3]) -> [f64; 3],
) -> String {
    let half = 0.75_f64.sqrt();
    let mut corners: Vec<(i64, i64)> = Vec::new();
    let mut faces = String::new();
    for row in 0..rows as i64 {
        for column in 0..columns as i64 {
            // In units of half the width and a quarter of the height.
            let (x, y) = (2 * column + row % 2, 6 * row);
            let ring = [(0, -4), (1, -2), (1, 2), (0, 4), (-1, 2), (-1, -2)]
                .map(|(dx, dy)| (x + dx, y + dy));
            faces += "f";
            for corner in ring {
                let number = corners
                    .iter()
                    .position(|c| *c == corner)
                    .unwrap_or_else(|| {
                        corners.push(corner);
                        corners.len() - 1
                    });
                faces += &format!(" {}", number + 1);
            }
            faces += "\n";
        }
    }
    let line = |(i, &(x, y)): (usize, &(i64, i64))| {
        let [x, y, z] = shift(i, [half * x as f64, 0.25 * y as f64, 0.0]);
        format!("v {x} {y} {z}\n")
    };
    corners.iter().enumerate().map(line).collect::<String>() + &faces
}

/// Whether a path exists.
pub fn exists(path: &Path) -> bool {
    path.exists()
}
