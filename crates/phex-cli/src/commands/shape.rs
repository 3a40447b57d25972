//! `phex shape`: writes a built-in surface.

use super::tell;
use crate::args::ShapeCommand;
use crate::exit::{Exit, Failure, OrExit};
use crate::output::{self, check_writable, write_mesh};
use phex_job::{Content, Unit};
use phex_mesh::shapes::{Shape, ShapeInfo, TriangulationOptions, triangulate_with_parameters};

/// Runs the command.
///
/// # Errors
/// If a parameter is out of its range or the output can't be written.
pub fn run(command: &ShapeCommand) -> Result<Exit, Failure> {
    let (Some(name), Some(path), false) = (&command.name, &command.output, command.list) else {
        output::print(&list())?;
        return Ok(Exit::Success);
    };
    check_writable(&[(path, Content::Mesh)], &[])?;
    let parameters: Vec<(&str, f64)> = command
        .parameters
        .iter()
        .map(|(name, value)| (name.as_str(), *value))
        .collect();
    let shape = Shape::from_name(name, &parameters).or_exit(Exit::InputUnusable)?;
    let ShapeCommand {
        triangles,
        jitter,
        seed,
        ..
    } = *command;
    let options = TriangulationOptions {
        triangles,
        jitter,
        seed,
    };
    let surface = triangulate_with_parameters(&shape, &options).or_exit(Exit::InputUnusable)?;
    write_mesh(path, &surface.to_soup(), Unit::M)?;
    let (vertices, triangles) = (surface.positions.len(), surface.triangles.len());
    tell(
        command.talk.quiet,
        &format!(
            "{}: {shape:?}, {vertices} vertices, {triangles} triangles\n",
            path.display()
        ),
    )?;
    Ok(Exit::Success)
}

fn list() -> String {
    Shape::all().iter().map(entry).collect()
}

fn entry(shape: &ShapeInfo) -> String {
    let parameters = shape
        .parameters
        .iter()
        .map(|p| format!("    {:<12} {} [{}]\n", p.name, p.meaning, p.default));
    format!(
        "{:<22} {}\n{}",
        shape.name,
        shape.summary,
        parameters.collect::<String>()
    )
}
