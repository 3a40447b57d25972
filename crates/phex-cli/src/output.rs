//! Files that are written: checked before the long computation, written whole or not at all.

use crate::exit::{Exit, Failure};
use crate::printable::printable;
use crate::progress::{check_interruption, while_writing};
use anyhow::Context;
use phex_job::{Content, OutputPaths, Unit, in_file};
use phex_mesh::PolygonSoup;
use phex_mesh::io::{WriteCause, WriteError, atomic_write, write_soup};
use phex_picture::Picture;
use std::io::Write;
use std::path::{Path, PathBuf};

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
    let mut paths = OutputPaths::beside(inputs.iter().copied());
    for &(path, content) in outputs {
        if path == Path::new("-") {
            return Err(Failure::input(
                "- can't be written: no file is written to standard output (`./-` is a file of this name; `check` and `info` have --json)",
            ));
        }
        paths.add(path, content)?;
    }
    Ok(())
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
