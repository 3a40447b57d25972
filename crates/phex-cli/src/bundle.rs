//! A bundle: everything that a check read and said, in one file that can be sent.

use crate::exit::{Exit, Failure, OrExit};
use crate::html::typed_command;
use crate::machine::facts;
use crate::output::write_bytes;
use anyhow::Context;
use phex::report::RunReport;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a bundle: the files that were read, the check's report, and what program and machine are.
///
/// # Errors
/// If a file can't be read any more, or the bundle can't be written.
pub fn write(path: &Path, read: &[PathBuf], report: &RunReport) -> Result<(), Failure> {
    let mut files = BTreeMap::new();
    for file in read {
        let bytes = std::fs::read(file).with_context(|| file.display().to_string());
        let name = free_name(&files, file);
        files.insert(name, bytes.or_exit(Exit::InputUnusable)?);
    }
    let json = report.to_json().context("the report")?;
    files.insert("check.json".to_owned(), json.into_bytes());
    let about = format!("{}\n\n{}", typed_command(), facts().into_text());
    files.insert("about.txt".to_owned(), about.into_bytes());
    let bytes = zipped(&files).context("the bundle")?;
    write_bytes(path, &bytes)
}

/// The name of a file in the bundle, with a number before it if that is taken.
fn free_name(taken: &BTreeMap<String, Vec<u8>>, file: &Path) -> String {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let names = (2..).map(|k| format!("inputs/{k}-{name}"));
    std::iter::once(format!("inputs/{name}"))
        .chain(names)
        .find(|name| !taken.contains_key(name))
        .unwrap_or_default()
}

fn zipped(files: &BTreeMap<String, Vec<u8>>) -> anyhow::Result<Vec<u8>> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    for (name, bytes) in files {
        archive.start_file(name, options)?;
        archive.write_all(bytes)?;
    }
    Ok(archive.finish()?.into_inner())
}
