//! A folder of files that a command makes, in which everything of others stays.
//!
//! The file `phex.sha256` lists what the command wrote, with checksums (`sha256sum -c phex.sha256`
//! reads it). Only a file that is listed and still has its checksum is written over or removed.
//! Every other file is somebody's work: where one has a name that is needed, nothing is written at
//! all.
//!
//! New files are written into `.phex-new` in the folder first. Then the list takes up the checksums
//! of old and new files, the new ones take their places by a rename each, those that are no longer
//! made go, and the list keeps the new checksums alone. A run that is killed leaves the old files
//! whole, or every new one whole in its place or in `.phex-new`; the next run finds all of them in
//! the list.

mod list;
#[cfg(test)]
mod tests;

use crate::exit::{Exit, Failure, OrExit};
use crate::output::check_writable;
use crate::progress::{check_interruption, while_writing};
use anyhow::Context;
use list::{LIST, List};
use phex_job::Content;
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// Where files are until all of them are written.
const STAGE: &str = ".phex-new";
/// A file in it that is locked by the run that writes.
const LOCK: &str = "lock";
/// The list that is placed last, while it is in `STAGE`.
const LAST_LIST: &str = "last.sha256";
/// Files that a refusal names.
const NAMED: usize = 5;

/// A file to write: its path in the folder, with `/` between its parts, and its bytes.
pub type NamedFile = (String, Vec<u8>);

/// How much of the folder is the command's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// The folder is new, empty or of an earlier run, and files of that run that are no longer made
    /// go.
    Whole,
    /// Files are added to whatever is there, and those of earlier runs stay.
    Added,
}

/// A folder that a command writes.
#[derive(Clone, Copy, Debug)]
pub struct OutputFolder<'a> {
    path: &'a Path,
    command: &'static str,
    extent: Extent,
}

/// One of the steps that change the folder, in this order; a run may be killed between or within
/// any two.
enum FolderStep {
    /// Writes a file in `STAGE`.
    Stage { name: String, bytes: Vec<u8> },
    /// Moves a file from `STAGE` to its place.
    Place { from: String, to: String },
    /// Removes a file of an earlier run.
    Remove(String),
}

impl<'a> OutputFolder<'a> {
    /// A folder that need not be there yet; `command` is the command's name, as it is typed.
    pub fn new(path: &'a Path, command: &'static str, extent: Extent) -> Self {
        Self {
            path,
            command,
            extent,
        }
    }

    /// Checks before the computation that files of these names (and others) can be written, and
    /// that inputs are safe.
    ///
    /// # Errors
    /// If the folder can't be written, holds inputs and is the command's as a whole, or files of
    /// others are in the way.
    pub fn check(&self, names: &[String], inputs: &[&Path]) -> Result<(), Failure> {
        if self.path.is_symlink() && !self.path.exists() {
            return Err(self.refused("it is a link to nothing"));
        }
        if self.path.exists() && !self.path.is_dir() {
            return Err(self.refused("it is no folder"));
        }
        let list = self.path.join(LIST);
        check_writable(&[(&list, Content::Other)], &[])?;
        if self.extent == Extent::Whole {
            inputs
                .iter()
                .try_for_each(|input| self.check_input(input))?;
        }
        self.check_files(&self.listed()?, names)
    }

    /// Writes all files, and removes those of an earlier run that are no longer made if the folder
    /// is the command's.
    ///
    /// # Errors
    /// If files of others are in the way, another run is writing there, the user interrupted, or
    /// the system refuses.
    pub fn write(&self, files: &[NamedFile]) -> Result<(), Failure> {
        check_interruption()?;
        while_writing(|| self.write_all(files))
    }

    fn write_all(&self, files: &[NamedFile]) -> Result<(), Failure> {
        let is_new = !self.path.exists();
        let lock = self.locked_stage().or_exit(Exit::InputUnusable)?;
        let staged = self.steps(files).and_then(|[stage, place]| {
            self.run(&stage)?;
            Ok(place)
        });
        // Where placing fails, what is not in its place yet stays in `STAGE`.
        let (made, is_over) = match staged {
            Ok(place) => (self.run(&place), true),
            Err(failure) => (Err(failure), false),
        };
        drop(lock);
        if made.is_ok() || !is_over {
            // A stage that stays does no harm: the next run empties it.
            let _ = fs::remove_dir_all(self.path.join(STAGE));
        }
        if is_new && !is_over {
            let _ = fs::remove_dir(self.path);
        }
        made
    }

    /// Makes `STAGE` and empties it, and keeps other runs out of it as long as the result lives.
    fn locked_stage(&self) -> anyhow::Result<File> {
        let stage = self.path.join(STAGE);
        let make = || -> io::Result<File> {
            fs::create_dir_all(self.path)?;
            if !fs::symlink_metadata(&stage).is_ok_and(|found| found.is_dir()) {
                fs::create_dir(&stage)?;
            }
            let mut options = OpenOptions::new();
            options.create(true).append(true).open(stage.join(LOCK))
        };
        let lock = make().with_context(|| format!("{} can't be made", stage.display()))?;
        if matches!(lock.try_lock(), Err(TryLockError::WouldBlock)) {
            anyhow::bail!("{}: another run is writing there", self.path.display());
        }
        empty(&stage).with_context(|| format!("{} can't be emptied", stage.display()))?;
        Ok(lock)
    }

    /// What is to be done: first in `STAGE`, then in the folder itself.
    ///
    /// # Errors
    /// If files of others are in the way, or the list can't be read.
    fn steps(&self, files: &[NamedFile]) -> Result<[Vec<FolderStep>; 2], Failure> {
        let listed = self.listed()?;
        let names: Vec<String> = files.iter().map(|(name, _)| name.clone()).collect();
        self.check_files(&listed, &names)?;
        let new = List::of(files);
        let found = listed.found_in(self.path);
        let mut last = match self.extent {
            Extent::Whole => List::default(),
            Extent::Added => found.clone(),
        };
        last.replace(&new);
        let mut either = listed.clone();
        either.add(&new);

        let stage = |name: &str, bytes: &[u8]| FolderStep::Stage {
            name: name.to_owned(),
            bytes: bytes.to_vec(),
        };
        let place = |from: &str, to: &str| FolderStep::Place {
            from: from.to_owned(),
            to: to.to_owned(),
        };
        let present = new.found_in(self.path);
        let missing = || files.iter().filter(|(name, _)| !present.holds(name));
        let mut staged = vec![stage(LIST, either.text(self.command).as_bytes())];
        staged.push(stage(LAST_LIST, last.text(self.command).as_bytes()));
        staged.extend(missing().map(|(name, bytes)| stage(name, bytes)));
        let mut placed = vec![place(LIST, LIST)];
        placed.extend(missing().map(|(name, _)| place(name, name)));
        // A listed file that has been changed is the user's.
        let gone = found.names().filter(|name| !last.holds(name));
        placed.extend(gone.map(|name| FolderStep::Remove(name.to_owned())));
        placed.push(place(LAST_LIST, LIST));
        Ok([staged, placed])
    }

    fn run(&self, steps: &[FolderStep]) -> Result<(), Failure> {
        let run = |step: &FolderStep| step.run(self.path);
        steps.iter().try_for_each(run).or_exit(Exit::Internal)
    }

    /// What earlier runs wrote.
    ///
    /// # Errors
    /// If the folder is to be the command's and holds other things only, or its list is of another
    /// command.
    fn listed(&self) -> Result<List, Failure> {
        let path = self.path.join(LIST);
        match fs::read(&path) {
            Ok(bytes) => List::parse(&bytes, self.command)
                .map_err(|cause| self.refused(&format!("`{LIST}` {cause}"))),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                if self.extent == Extent::Whole && self.holds_anything() {
                    let cause = format!(
                        "the folder holds other files (and no `{LIST}` of an earlier run); \
                         give a new or an empty folder"
                    );
                    return Err(self.refused(&cause));
                }
                Ok(List::default())
            }
            Err(error) => Err(self.refused(&format!("`{LIST}`: {error}"))),
        }
    }

    fn holds_anything(&self) -> bool {
        let entries = fs::read_dir(self.path).into_iter().flatten().flatten();
        entries.into_iter().any(|e| e.file_name() != STAGE)
    }

    fn check_input(&self, input: &Path) -> Result<(), Failure> {
        let (Ok(folder), Ok(file)) = (self.path.canonicalize(), input.canonicalize()) else {
            return Ok(());
        };
        if !file.starts_with(&folder) {
            return Ok(());
        }
        let (file, folder) = (input.display(), self.path.display());
        Err(Failure::input(format!(
            "{file} is read and lies in the folder that is written ({folder}): copy it to another \
             place and give it from there, or give another folder"
        )))
    }

    /// Checks that nothing of others has a name that is needed, nor (in a folder that is the
    /// command's) has changed.
    fn check_files(&self, listed: &List, names: &[String]) -> Result<(), Failure> {
        let earlier = listed.names().filter(|_| self.extent == Extent::Whole);
        let needed: BTreeSet<&str> = names.iter().map(String::as_str).chain(earlier).collect();
        let others = needed.into_iter().filter(|n| !listed.allows(self.path, n));
        let why = |name: &str| {
            let cause = if listed.holds(name) {
                "has been changed since"
            } else {
                "is in the way"
            };
            format!("{name} {cause}")
        };
        let others: Vec<String> = others.map(why).collect();
        if others.is_empty() {
            return Ok(());
        }
        let more = match others.len().saturating_sub(NAMED) {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        let named = others[..NAMED.min(others.len())].join(", ");
        Err(self.refused(&format!(
            "only files that an earlier `phex {}` wrote are written over; {named}{more}: move them \
             away, or give another folder",
            self.command
        )))
    }

    fn refused(&self, cause: &str) -> Failure {
        Failure::input(format!("{}: {cause}", self.path.display()))
    }
}

/// Removes what a killed run left, but for the lock.
fn empty(stage: &Path) -> io::Result<()> {
    for entry in fs::read_dir(stage)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            fs::remove_dir_all(entry.path())?;
        } else if entry.file_name() != LOCK {
            fs::remove_file(entry.path())?;
        }
    }
    Ok(())
}

impl FolderStep {
    fn run(&self, folder: &Path) -> anyhow::Result<()> {
        let stage = folder.join(STAGE);
        let (path, done) = match self {
            Self::Stage { name, bytes } => {
                let path = stage.join(name);
                (path.clone(), write_new(&path, bytes))
            }
            Self::Place { from, to } => {
                let path = folder.join(to);
                (path.clone(), place(&stage.join(from), &path))
            }
            Self::Remove(name) => {
                let path = folder.join(name);
                (path.clone(), remove(&path))
            }
        };
        done.with_context(|| path.display().to_string())
    }
}

fn write_new(path: &Path, bytes: &[u8]) -> io::Result<()> {
    make_parent(path)?;
    let mut file = File::create_new(path)?;
    file.write_all(bytes)?;
    file.sync_all()
}

/// Moves a file over an earlier one, whose permissions it takes.
fn place(from: &Path, to: &Path) -> io::Result<()> {
    make_parent(to)?;
    if let Ok(earlier) = fs::metadata(to) {
        fs::set_permissions(from, earlier.permissions())?;
    }
    fs::rename(from, to)
}

fn make_parent(path: &Path) -> io::Result<()> {
    path.parent().map_or(Ok(()), fs::create_dir_all)
}

fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}
