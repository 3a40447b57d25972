//! Paths of files that are to be written, checked before the long computation.

use crate::error::JobError;
use phex_mesh::io::{Format, link_target, shown};
use std::io;
use std::path::{Path, PathBuf};

/// What a file is to hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A mesh, in the format of its extension.
    Mesh,
    /// A picture, which is a PNG file.
    Picture,
    /// A page for browsers, which is an HTML file.
    Page,
    /// Anything else, whatever it is called.
    Other,
}

impl Content {
    /// Refuses a file whose name promises something else.
    fn check_name(self, path: &Path) -> Result<(), JobError> {
        let (what, extensions) = match self {
            Self::Mesh => {
                let format = Format::from_path(path);
                return format.map(drop).map_err(|e| JobError::in_file(path, &e));
            }
            Self::Picture => ("pictures are written as .png", &["png"][..]),
            Self::Page => ("pages are written as .html", &["html", "htm"][..]),
            Self::Other => return Ok(()),
        };
        let extension = path.extension().and_then(|e| e.to_str());
        let is_known = |e: &str| extensions.contains(&e.to_ascii_lowercase().as_str());
        match extension.is_some_and(is_known) {
            true => Ok(()),
            false => Err(JobError::Input(format!("{}: {what}", path.display()))),
        }
    }
}

/// The paths of all files of a command: none that is written is read, too, or written twice.
///
/// ```
/// use phex_job::{Content, OutputPaths};
/// use std::path::Path;
///
/// let mut paths = OutputPaths::beside([Path::new("dome.obj")]);
/// assert!(paths.add(Path::new("panels.obj"), Content::Mesh).is_ok());
/// assert!(paths.add(Path::new("./dome.obj"), Content::Mesh).is_err());
/// ```
#[derive(Debug)]
pub struct OutputPaths {
    taken: Vec<PathBuf>,
}

impl OutputPaths {
    /// No outputs yet, beside files that are read.
    pub fn beside<'a>(inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        let taken = inputs.into_iter().map(whole).collect();
        Self { taken }
    }

    /// Checks that a file can be written, and that it is no other one of the command.
    ///
    /// # Errors
    /// If it is, the path can't be written, or its extension is that of other content.
    pub fn add(&mut self, path: &Path, content: Content) -> Result<(), JobError> {
        let name = path.display();
        if path.is_dir() {
            return Err(JobError::Input(format!(
                "{name} can't be written: it is a folder"
            )));
        }
        content.check_name(path)?;
        let whole = whole(path);
        if self.taken.contains(&whole) {
            return Err(JobError::Input(format!(
                "{name}: is also read, or written twice: each output needs a file of its own"
            )));
        }
        self.taken.push(whole);
        check_place(path)
            .map_err(|cause| JobError::Input(format!("{name} can't be written: {cause}")))
    }
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

fn check_place(path: &Path) -> Result<(), String> {
    let path = &link_target(path).map_err(|e| e.to_string())?;
    if path.file_name().is_none() {
        return Err("it names no file".to_owned());
    }
    let folder = nearest_folder(path);
    let place = folder.display();
    if !folder.is_dir() {
        return Err(format!("{place} is not a folder"));
    }
    check_names(path, &folder)?;
    // A file without a name: nothing is left behind.
    let made = tempfile::tempfile_in(&folder);
    made.map_err(|e| format!("the folder {place} refuses files: {e}"))
        .map(drop)
}

/// Whether the file system takes the names of the folders and of the file that are to be made below
/// a folder, which may be too long.
fn check_names(path: &Path, folder: &Path) -> Result<(), String> {
    let below = path.strip_prefix(folder).unwrap_or(path);
    for name in below.components() {
        match std::fs::symlink_metadata(folder.join(name)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                let name = name.as_os_str().to_string_lossy();
                return Err(format!("the name `{}`: {error}", shown(&name)));
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
