//! The list of files that a command wrote into a folder, with the SHA-256 of each.

use super::NamedFile;
use phex_job::sha256;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path};

/// Name of the list.
pub(super) const LIST: &str = "phex.sha256";

/// Names of files and the checksums that they may have: one, or while a run places its files also
/// that of the old one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct List {
    sums: BTreeMap<String, BTreeSet<String>>,
}

impl List {
    /// The list of some files.
    pub fn of(files: &[NamedFile]) -> Self {
        let entry = |(name, bytes): &NamedFile| (name.clone(), [sha256(bytes)].into());
        Self {
            sums: files.iter().map(entry).collect(),
        }
    }

    /// Reads a list.
    ///
    /// # Errors
    /// If it is not one that `command` wrote; the cause goes on after the name of the list.
    pub fn parse(bytes: &[u8], command: &str) -> Result<Self, String> {
        let foreign = || format!("is not a list that `phex {command}` wrote; give another folder");
        let text = std::str::from_utf8(bytes).map_err(|_| foreign())?;
        if !text.starts_with(&head(command)) {
            return Err(foreign());
        }
        let mut list = Self::default();
        for (number, line) in text.lines().enumerate().skip(1) {
            let entry = line.split_once("  ").filter(|(sum, name)| {
                sum.len() == 64 && sum.bytes().all(|c| c.is_ascii_hexdigit()) && is_inside(name)
            });
            let (sum, name) = entry.ok_or_else(|| {
                format!("can't be used: line {} is no checksum and name", number + 1)
            })?;
            list.entry(name).insert(sum.to_owned());
        }
        Ok(list)
    }

    /// The list as a file that `sha256sum -c` reads.
    pub fn text(&self, command: &str) -> String {
        let lines = self.sums.iter().flat_map(|(name, sums)| {
            let line = move |sum: &String| format!("{sum}  {name}\n");
            sums.iter().map(line)
        });
        head(command) + &lines.collect::<String>()
    }

    /// Names of the files, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.sums.keys().map(String::as_str)
    }

    /// Whether a file is listed.
    pub fn holds(&self, name: &str) -> bool {
        self.sums.contains_key(name)
    }

    /// Whether a file of this name may be written in a folder: there is none, or one that is as
    /// listed.
    pub fn allows(&self, folder: &Path, name: &str) -> bool {
        let mut path = folder.to_path_buf();
        let parts: Vec<Component<'_>> = Path::new(name).components().collect();
        for (k, part) in parts.iter().enumerate() {
            path.push(part);
            match fs::symlink_metadata(&path) {
                Err(error) => return error.kind() == std::io::ErrorKind::NotFound,
                Ok(found) if k + 1 < parts.len() && found.is_dir() => {}
                Ok(found) => {
                    return k + 1 == parts.len() && found.is_file() && self.has(&path, name);
                }
            }
        }
        false
    }

    fn has(&self, path: &Path, name: &str) -> bool {
        let (sums, bytes) = (self.sums.get(name), fs::read(path));
        sums.zip(bytes.ok())
            .is_some_and(|(sums, bytes)| sums.contains(&sha256(&bytes)))
    }

    /// The listed files that are in a folder and as listed, each with the checksum that it has.
    pub fn found_in(&self, folder: &Path) -> Self {
        let found = self.sums.keys().filter_map(|name| {
            let path = folder.join(name);
            let is_ours = path.is_file() && self.allows(folder, name);
            let bytes = is_ours.then(|| fs::read(&path).ok()).flatten()?;
            Some((name.clone(), [sha256(&bytes)].into()))
        });
        Self {
            sums: found.collect(),
        }
    }

    /// Lists these files, too, and these checksums of files that are listed.
    pub fn add(&mut self, other: &Self) {
        for (name, sums) in &other.sums {
            self.entry(name).extend(sums.iter().cloned());
        }
    }

    /// Lists these files with these checksums alone.
    pub fn replace(&mut self, other: &Self) {
        self.sums.extend(other.sums.clone());
    }

    fn entry(&mut self, name: &str) -> &mut BTreeSet<String> {
        self.sums.entry(name.to_owned()).or_default()
    }
}

/// First line of a list; `sha256sum` passes over it.
fn head(command: &str) -> String {
    format!(
        "# Files of `phex {command}`: it writes over them and removes them as long as they are as listed.\n"
    )
}

/// Whether a path leads to a file below the folder that it starts from.
fn is_inside(name: &str) -> bool {
    let normal = |part: Component<'_>| matches!(part, Component::Normal(_));
    !name.is_empty() && Path::new(name).components().all(normal)
}
