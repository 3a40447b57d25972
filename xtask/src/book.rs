//! The book in `docs/book`: every command that it shows is run, every link leads somewhere, and the
//! reference of commands is the program's own.

use crate::{Stop, copied, program_as_tested, read, succeed, verdict, viewer::program, write};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

mod chapter;
mod links;
mod transcript;

/// The book's source.
const SOURCE: &str = "docs/book/src";
/// Where commands run: a folder for each chapter.
const SCRATCH: &str = "out/book";
/// What is in each of these folders, as it is in the repository's.
const GIVEN: [&str; 2] = ["data", "docs/limits"];
/// The chapter that the program writes.
const REFERENCE: &str = "commands.md";

/// Checks the whole book.
pub fn check(root: &Path) -> Result<(), Stop> {
    book(root, &[])
}

/// Checks the book, or some chapters of it.
pub fn book(root: &Path, words: &[&str]) -> Result<(), Stop> {
    let task = BookTask::parsed(words)?;
    let source = root.join(SOURCE);
    let given = task.program.map(PathBuf::from);
    let phex = given.map_or_else(|| program_as_tested(root), Ok)?;
    let place = BookFolder::new(root, &phex)?;
    place.reference(&source.join(REFERENCE), task.writes)?;
    structure(root, &source)?;
    let mut complaints = Vec::new();
    for path in chapters(&source)? {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if task.chapters.is_empty() || task.chapters.contains(&&*name) {
            complaints.extend(chapter::check(&place, &path, task.writes).err());
        }
    }
    verdict(complaints)?;
    built(root)
}

/// What is to be done.
#[derive(Default)]
struct BookTask<'a> {
    chapters: Vec<&'a str>,
    program: Option<&'a str>,
    /// Whether output that is shown whole is brought up to date.
    writes: bool,
}

impl<'a> BookTask<'a> {
    fn parsed(words: &[&'a str]) -> Result<Self, String> {
        let mut task = Self::default();
        let mut words = words.iter();
        while let Some(word) = words.next() {
            match *word {
                "--write" => task.writes = true,
                "--program" => task.program = Some(words.next().ok_or("--program PATH")?),
                option if option.starts_with('-') => return Err(format!("no option {option}")),
                chapter => task.chapters.push(chapter),
            }
        }
        Ok(task)
    }
}

/// Where the book's commands run.
struct BookFolder {
    root: PathBuf,
    scratch: PathBuf,
    /// The search path, with the program first.
    path: std::ffi::OsString,
}

impl BookFolder {
    fn new(root: &Path, phex: &Path) -> Result<Self, String> {
        let scratch = root.join(SCRATCH);
        let programs = scratch.join("bin");
        std::fs::create_dir_all(&programs).map_err(|e| format!("{}: {e}", programs.display()))?;
        let name = format!("phex{}", std::env::consts::EXE_SUFFIX);
        copied(phex, &programs.join(name))?;
        let others = std::env::var_os("PATH").unwrap_or_default();
        let all = std::iter::once(programs).chain(std::env::split_paths(&others));
        let path = std::env::join_paths(all).map_err(|e| e.to_string())?;
        Ok(Self {
            root: root.to_path_buf(),
            scratch,
            path,
        })
    }

    /// A new folder for a chapter's commands, with the repository's data.
    fn folder(&self, chapter: &str) -> Result<PathBuf, String> {
        let folder = self.scratch.join(chapter);
        if folder.exists() {
            std::fs::remove_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        }
        for given in GIVEN {
            for file in crate::files_below(&self.root.join(given))? {
                let below = file.strip_prefix(&self.root).unwrap_or(&file);
                copied(&file, &folder.join(below))?;
            }
        }
        Ok(folder)
    }

    /// What a command line prints, on both streams, and whether it succeeds.
    fn said(&self, folder: &Path, line: &str) -> Result<(String, bool), String> {
        let mut shell = Command::new("sh");
        let ran = shell
            .current_dir(folder)
            .env("PATH", &self.path)
            .args(["-c", &format!("exec 2>&1\n{line}")])
            .output()
            .map_err(|e| format!("sh: {e}"))?;
        let text = String::from_utf8_lossy(&ran.stdout).into_owned();
        Ok((text, ran.status.success()))
    }

    /// Compares the reference of commands with what the program says, or writes it.
    fn reference(&self, path: &Path, writes: bool) -> Result<(), String> {
        let (text, fine) = self.said(&self.scratch, "phex generate reference")?;
        if !fine {
            return Err(format!("phex generate reference: {text}"));
        }
        match read(path) {
            Ok(shown) if shown == text => Ok(()),
            _ if writes => write(path, &text),
            _ => Err(format!(
                "{}: not what the program says; `cargo xtask book --write` writes it anew",
                path.display()
            )),
        }
    }
}

/// The chapters in the order of their names.
fn chapters(source: &Path) -> Result<Vec<PathBuf>, String> {
    let files = crate::files_below(source)?;
    let is_chapter = |f: &PathBuf| f.extension().is_some_and(|e| e == "md");
    Ok(files.into_iter().filter(is_chapter).collect())
}

/// Every chapter is in the summary, and every relative link of the book, and of the other texts,
/// leads to a file; those of the book stay inside of it, since nothing else is in its pages.
fn structure(root: &Path, source: &Path) -> Result<(), String> {
    let summary = source.join("SUMMARY.md");
    let listed: BTreeSet<PathBuf> = links::targets(&read(&summary)?)
        .into_iter()
        .map(|target| source.join(target.path))
        .collect();
    let mut complaints = Vec::new();
    for chapter in chapters(source)? {
        if chapter != summary && !listed.contains(&chapter) {
            complaints.push(format!("{}: not in SUMMARY.md", chapter.display()));
        }
    }
    for file in crate::files_below(root)? {
        if file.extension().is_some_and(|e| e == "md") {
            let inside = file.starts_with(source).then_some(source);
            complaints.extend(links::complaints(&file, &read(&file)?, inside));
        }
    }
    verdict(complaints)
}

/// Builds the book's pages, where mdBook is installed.
fn built(root: &Path) -> Result<(), Stop> {
    let Some(mdbook) = program("mdbook") else {
        println!("mdbook is not installed: the book's pages were not built");
        return Ok(());
    };
    let mut build = Command::new(mdbook);
    let pages = root.join(SCRATCH).join("pages");
    build.current_dir(root).args(["build", "docs/book", "-d"]);
    Ok(succeed(build.arg(pages))?)
}
