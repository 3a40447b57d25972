//! Files that are written: checked before the long computation, written whole or not at all.

use crate::exit::{Exit, Failure, OrExit};
use crate::printable::printable;
use crate::progress::{check_interruption, while_writing};
use anyhow::Context;
use phex_job::{Unit, in_file};
use phex_mesh::PolygonSoup;
use phex_mesh::io::{Format, WriteCause, WriteError, atomic_write, link_target, shown, write_soup};
use phex_picture::Picture;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What a file is to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A mesh, in the format of its extension.
    Mesh,
    /// JSON or a picture.
    Other,
}

/// The paths that are given, of those that may be.
pub fn given<'a>(paths: impl IntoIterator<Item = Option<&'a PathBuf>>) -> Vec<&'a Path> {
    let given = paths.into_iter().flatten();
    given.map(PathBuf::as_path).collect()
}

/// Checks that files can be written where they are asked for, that no two are the same, and that
/// none is an input.
///
/// # Errors
/// If the extension of a mesh is unknown, or a path can't be written.
pub fn check_writable(outputs: &[(&Path, Content)], inputs: &[&Path]) -> Result<(), Failure> {
    let mut taken: Vec<PathBuf> = inputs.iter().map(|p| whole(p)).collect();
    for &(path, content) in outputs {
        if content == Content::Mesh {
            Format::from_path(path)
                .with_context(|| path.display().to_string())
                .or_exit(Exit::InputUnusable)?;
        }
        let whole = whole(path);
        if taken.contains(&whole) {
            let message = format!(
                "{}: is also read or written under another name of this command",
                path.display()
            );
            return Err(Failure::input(message));
        }
        taken.push(whole);
        check_place(path)
            .with_context(|| format!("{} can't be written", path.display()))
            .or_exit(Exit::InputUnusable)?;
    }
    Ok(())
}

/// The path without links, as far as it exists.
fn whole(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let absolute = link_target(&absolute).unwrap_or(absolute);
    let folder = absolute.parent().and_then(|p| p.canonicalize().ok());
    absolute
        .canonicalize()
        .ok()
        .or_else(|| Some(folder?.join(absolute.file_name()?)))
        .unwrap_or(absolute)
}

fn check_place(path: &Path) -> anyhow::Result<()> {
    anyhow::ensure!(
        path != Path::new("-"),
        "no file is written to standard output (`./-` is a file of this name; `check` and `info` have --json)"
    );
    let path = &link_target(path)?;
    anyhow::ensure!(path.file_name().is_some(), "it names no file");
    anyhow::ensure!(!path.is_dir(), "it is a folder");
    let folder = nearest_folder(path);
    anyhow::ensure!(folder.is_dir(), "{} is not a folder", folder.display());
    check_names(path, &folder)?;
    // A file without a name: nothing is left behind.
    tempfile::tempfile_in(&folder)
        .with_context(|| format!("the folder {} refuses files", folder.display()))?;
    Ok(())
}

/// Whether the file system takes the names of the folders and of the file that are to be made below
/// a folder, which may be too long.
fn check_names(path: &Path, folder: &Path) -> anyhow::Result<()> {
    let below = path.strip_prefix(folder).unwrap_or(path);
    for name in below.components() {
        match std::fs::symlink_metadata(folder.join(name)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                let name = name.as_os_str().to_string_lossy();
                return Err(error).with_context(|| format!("the name `{}`", shown(&name)));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The nearest ancestor of a path that exists; missing folders are made when the file is written.
fn nearest_folder(path: &Path) -> PathBuf {
    let here = Path::new(".");
    let named = path
        .ancestors()
        .skip(1)
        .map(|p| if p.as_os_str().is_empty() { here } else { p });
    named
        .into_iter()
        .find(|p| p.exists())
        .unwrap_or(here)
        .to_path_buf()
}

/// Writes a mesh with coordinates in a unit; in metres where the format demands it.
///
/// # Errors
/// If the user interrupted, the mesh has no place in the format, or writing fails.
pub fn write_mesh(path: &Path, soup: &PolygonSoup, unit: Unit) -> Result<(), Failure> {
    write_with(|| write_soup(path, &in_file(path, soup, unit)))
}

/// Writes a text.
///
/// # Errors
/// If the user interrupted, or writing fails.
pub fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    write_bytes(path, text.as_bytes())
}

/// Writes a picture as PNG.
///
/// # Errors
/// If the user interrupted, or writing fails.
pub fn write_picture(path: &Path, picture: &Picture) -> Result<(), Failure> {
    write_bytes(path, &picture.to_png())
}

/// Writes bytes.
///
/// # Errors
/// If the user interrupted, or writing fails.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_with(|| atomic_write(path, |out| out.write_all(bytes)).map_err(|e| e.in_file(path)))
}

fn write_with(write: impl FnOnce() -> Result<(), WriteError>) -> Result<(), Failure> {
    check_interruption()?;
    while_writing(write).map_err(|error| {
        let exit = match error.cause {
            WriteCause::Io(_) => Exit::Internal,
            _ => Exit::InputUnusable,
        };
        Failure {
            exit,
            cause: error.into(),
        }
    })
}

/// Prints a result on standard output; a closed pipe is no error.
///
/// # Errors
/// If standard output can't be written.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out
        .write_all(printable(text).as_bytes())
        .and_then(|()| out.flush())
    {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).context("standard output").map_err(Failure::from)
        }
        _ => Ok(()),
    }
}
