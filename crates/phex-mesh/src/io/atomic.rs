//! Files that appear whole or not at all.

use super::error::{WriteCause, WriteError};
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Names of temporary files begin and end like this, and are made for nothing else.
const PREFIX: &str = ".phex-";
const SUFFIX: &str = ".tmp";

/// Symbolic links that are followed in a row at the most, as systems do.
const MOST_LINKS: usize = 40;

/// Writes a file through a temporary file in the same folder, which takes the file's name once it
/// is complete: on any error an existing file stays as it was. Missing folders are made, symbolic
/// links followed, also to files that are not there; the permissions of a file that is replaced
/// stay. What exists and is no regular file (a pipe, a terminal) is written directly.
///
/// A temporary file is locked while it is written. What a killed run has left is not, and goes when
/// the next file is written into that folder. Runs side by side may write into one folder.
///
/// # Errors
/// If the folder or file can't be written, or `write` fails; the error names `path`.
pub fn atomic_write(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<(), WriteError> {
    let result = match fs::metadata(path) {
        Ok(found) if found.is_dir() => Err(io::Error::other("it is a folder")),
        Ok(found) if !found.is_file() => {
            fs::File::create(path).and_then(|mut file| write(&mut file))
        }
        found => replace(path, found.ok().map(|found| found.permissions()), write),
    };
    result.map_err(|error| WriteError::from(WriteCause::from(error)).in_file(path))
}

fn replace(
    path: &Path,
    permissions: Option<fs::Permissions>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let target = link_target(path)?;
    let folder = folder_of(&target);
    fs::create_dir_all(&folder)?;
    remove_left_behind(&folder);
    let temporary = locked_file(&folder)?;
    let mut out = BufWriter::new(temporary);
    write(&mut out)?;
    let file = out.into_inner().map_err(io::IntoInnerError::into_error)?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    file.as_file().sync_all()?;
    file.persist(&target)?;
    Ok(())
}

/// The file that a path stands for, whether it is there or not: symbolic links in its last place
/// are followed.
///
/// # Errors
/// If links go round in a circle.
pub fn link_target(path: &Path) -> io::Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = fs::read_link(&target) else {
            return Ok(target);
        };
        // A link that is not absolute counts from the folder that it is in.
        target = folder_of(&target).join(next);
    }
    Err(io::Error::other("its symbolic links go round in a circle"))
}

/// Removes temporary files that no running program holds; what can't be looked at stays.
fn remove_left_behind(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    let is_ours = |name: &str| name.starts_with(PREFIX) && name.ends_with(SUFFIX);
    for entry in entries.flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && entry.file_name().to_str().is_some_and(is_ours) {
            // The lock is held until the file is gone: nobody writes into what is about to go.
            // Another run may have been quicker.
            if let Ok(file) = fs::File::open(entry.path())
                && file.try_lock().is_ok()
            {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// A temporary file that no other run takes for left behind. Between its making and its lock
/// another run may have done so: then it is gone, or about to go, and the next one is made.
fn locked_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    loop {
        let temporary = temporary_file(folder)?;
        match temporary.as_file().try_lock() {
            Err(fs::TryLockError::WouldBlock) => {}
            // Where the system has no locks nothing is taken for left behind either.
            Err(fs::TryLockError::Error(_)) => return Ok(temporary),
            Ok(()) if temporary.path().exists() => return Ok(temporary),
            Ok(()) => {}
        }
    }
}

fn temporary_file(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    // Temporary files are private by default; this one is to be an ordinary file (the umask still
    // applies).
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/report.json");
        atomic_write(&path, |out| out.write_all(b"old")).unwrap();
        let error = atomic_write(&path, |out| {
            out.write_all(b"half of the n")?;
            Err(io::Error::other("disk full"))
        })
        .unwrap_err();
        assert!(
            error.to_string().contains("report.json") && error.to_string().contains("disk full")
        );
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn runs_side_by_side_leave_each_others_temporary_files() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path();
        std::thread::scope(|scope| {
            for run in 0..8 {
                scope.spawn(move || {
                    for file in 0..200 {
                        let path = place.join(format!("{run}-{file}"));
                        atomic_write(&path, |out| out.write_all(b"whole")).unwrap();
                    }
                });
            }
        });
        assert_eq!(fs::read_dir(place).unwrap().count(), 8 * 200);
    }

    #[test]
    fn a_folder_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        assert!(atomic_write(folder.path(), |out| out.write_all(b"x")).is_err());
        assert!(folder.path().is_dir());
    }

    #[test]
    fn a_folder_that_is_a_file_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "x").unwrap();
        assert!(atomic_write(&file.join("out.obj"), |out| out.write_all(b"x")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_the_file_is_readable_by_others() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(folder.path().join("plain"), "x").unwrap();
        fs::write(&file, "old").unwrap();
        symlink(&file, &link).unwrap();
        atomic_write(&link, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        let mode = |name: &str| {
            fs::metadata(folder.path().join(name))
                .unwrap()
                .permissions()
                .mode()
        };
        assert_eq!(mode("file"), mode("plain"));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_is_written_directly() {
        atomic_write(Path::new("/dev/null"), |out| out.write_all(b"x")).unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }

    #[cfg(unix)]
    #[test]
    fn a_replaced_file_keeps_its_permissions() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("private.obj");
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        atomic_write(&path, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        let mode = fs::metadata(&path).unwrap().permissions().mode();
        assert_eq!(mode & 0o777, 0o600);
    }

    #[cfg(unix)]
    #[test]
    fn links_to_files_that_are_not_there_are_followed() {
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        symlink("deep/er/file", at("second")).unwrap();
        symlink(at("second"), at("first")).unwrap();
        atomic_write(&at("first"), |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(at("deep/er/file")).unwrap(), b"new");
        let is_link = |name| fs::symlink_metadata(at(name)).unwrap().is_symlink();
        assert!(is_link("first") && is_link("second"));
        symlink("round", at("about")).unwrap();
        symlink("about", at("round")).unwrap();
        let error = atomic_write(&at("round"), |out| out.write_all(b"x")).unwrap_err();
        assert!(error.to_string().contains("circle"), "{error}");
        assert!(is_link("round") && is_link("about"));
    }

    #[test]
    fn what_a_killed_run_left_goes_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let (left, held, user) = (at(".phex-aB3.tmp"), at(".phex-xY9.tmp"), at(".phex-notes"));
        for path in [&left, &held, &user] {
            fs::write(path, "half").unwrap();
        }
        let other_run = fs::File::open(&held).unwrap();
        other_run.lock().unwrap();
        atomic_write(&at("out.obj"), |out| out.write_all(b"whole")).unwrap();
        assert!(!left.exists() && held.exists() && user.exists());
        drop(other_run);
        atomic_write(&at("out.obj"), |out| out.write_all(b"whole")).unwrap();
        assert!(!held.exists() && user.exists());
    }
}
