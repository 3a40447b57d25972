//! `phex convert`: one mesh format to another; faces stay as they are.

use super::tell;
use crate::args::ConvertCommand;
use crate::exit::{Exit, Failure};
use crate::output::{check_writable, write_mesh};
use crate::progress::Reporter;
use phex_job::{Content, MeshFile};
use phex_mesh::io::Format;

/// Runs the command.
///
/// # Errors
/// If the input can't be used or the output can't be written.
pub fn run(command: &ConvertCommand) -> Result<Exit, Failure> {
    check_writable(&[(&command.output, Content::Mesh)], &[&command.input])?;
    let in_metres = Format::from_path(&command.output).is_ok_and(Format::is_in_metres);
    if let Some(unit) = command.unit.filter(|_| !in_metres) {
        let path = command.output.display();
        return Err(Failure::input(format!(
            "--unit {unit} has no effect on {path}, whose coordinates stay as they are: leave it out"
        )));
    }
    let unit = command.unit.unwrap_or_default();
    let file = MeshFile::read(&command.input)?;
    if let Some(note) = file.doubted(unit).filter(|_| in_metres) {
        Reporter::new(&command.talk).note(note);
    }
    write_mesh(&command.output, &file.soup, unit)?;
    let (vertices, faces) = (file.record.vertices, file.record.faces);
    tell(
        command.talk.quiet,
        &format!(
            "{}: {vertices} vertices, {faces} faces\n",
            command.output.display()
        ),
    )?;
    Ok(Exit::Success)
}
