//! `phex info`: what is in a file, and what is wrong with it.

use super::tell;
use crate::args::InfoCommand;
use crate::exit::{Exit, Failure};
use crate::output;
use crate::summary::SummaryTable;
use anyhow::Context;
use phex_job::{ComponentInfo, FileInfo, MeshFile};

/// How many components the table lists; JSON holds all of them.
const LISTED: usize = 10;

/// Runs the command.
///
/// # Errors
/// If the file can't be read, or standard output can't be written.
pub fn run(command: &InfoCommand) -> Result<Exit, Failure> {
    let file = MeshFile::read(&command.input)?;
    let info = FileInfo::new(&file);
    if command.json {
        let json = serde_json::to_string_pretty(&info).context("the information")?;
        output::print(&(json + "\n"))?;
    } else {
        tell(command.talk.quiet, &table(&info))?;
    }
    Ok(if info.problem.is_some() {
        Exit::InputUnusable
    } else {
        Exit::Success
    })
}

fn table(info: &FileInfo) -> String {
    let mut table = SummaryTable::default();
    table.row("file", &info.path);
    table.row("vertices", info.vertices);
    table.row("faces", faces_by_size(info));
    let [low, high] = info.bounding_box;
    table.row(
        "box",
        format!("{low:?} to {high:?}, diagonal {}", info.diagonal),
    );
    let [min, mean, max] = [
        info.edge_length_min,
        info.edge_length_mean,
        info.edge_length_max,
    ];
    table.row(
        "edges",
        format!("from {min:.4e} to {max:.4e}, mean {mean:.4e}"),
    );
    if let Some(area) = info.area {
        table.row("area", area);
        table.row("components", info.components.len());
    }
    for component in info.components.iter().take(LISTED) {
        table.row("surface", sentence(component));
    }
    if info.components.len() > LISTED {
        table.row(
            "surface",
            format!("and {} more", info.components.len() - LISTED),
        );
    }
    for note in &info.notes {
        table.row("note", note);
    }
    if let Some(problem) = &info.problem {
        table.row("PROBLEM", problem);
    }
    table.into_text()
}

fn faces_by_size(info: &FileInfo) -> String {
    let sizes: Vec<String> = info
        .face_sizes
        .iter()
        .map(|(size, n)| format!("{n} with {size} corners"))
        .collect();
    format!("{} ({})", info.faces, sizes.join(", "))
}

fn sentence(component: &ComponentInfo) -> String {
    let ComponentInfo {
        vertices,
        triangles,
        boundary_loops,
        genus,
        area,
        ..
    } = component;
    let boundary = match boundary_loops {
        0 => "closed".to_owned(),
        1 => "1 boundary loop".to_owned(),
        n => format!("{n} boundary loops"),
    };
    format!("{vertices} vertices, {triangles} triangles, {boundary}, genus {genus}, area {area}")
}
