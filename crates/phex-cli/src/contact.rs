//! The contact sheet of the ways that were tried.

use crate::exit::Failure;
use crate::output::write_bytes;
use phex_html::{SheetKind, contact_file};
use phex_job::{JobResult, WayShown, ways};
use phex_picture::ContactTile;
use std::path::{Path, PathBuf};

/// Writes the sheet, as a page or a picture by the extension of its name.
///
/// # Errors
/// If the file can't be written.
pub fn write(path: &Path, made: &JobResult) -> Result<(), Failure> {
    let (heading, shown) = ways(made);
    let tiles: Vec<ContactTile<'_>> = shown.iter().map(tile).collect();
    let kind = SheetKind::of(path).unwrap_or_default();
    write_bytes(
        path,
        &contact_file(kind, &made.input_name(), &heading, &tiles),
    )
}

fn tile<'a>(way: &'a WayShown<'_>) -> ContactTile<'a> {
    ContactTile {
        mesh: way.mesh,
        title: &way.title,
        lines: &way.lines,
    }
}

/// A path whose extension says what kind of sheet it is.
///
/// # Errors
/// If it is none of those.
pub fn sheet_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match SheetKind::of(&path) {
        Some(_) => Ok(path),
        None => Err("a contact sheet is a .png or a .html file".to_owned()),
    }
}
