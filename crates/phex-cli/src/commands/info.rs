//! `phex info`: what is in a file, and what is wrong with it.

use super::tell;
use crate::args::InfoCommand;
use crate::exit::{Exit, Failure};
use crate::output;
use crate::summary::SummaryTable;
use anyhow::Context;
use phex::quality::told_place;
use phex_job::{
    ComponentInfo, FileInfo, MeshFile, Suggestion, SurfaceKind, TypedPanelSize, Unit, four_digits,
    panels,
};
use phex_mesh::TriangleSurface;
use serde::Serialize;

/// How many components the table lists; JSON holds all of them.
const LISTED: usize = 10;
/// Numbers of panels that are told of where none is asked for.
const USUAL: [u64; 3] = [100, 300, 1000];

/// Runs the command.
///
/// # Errors
/// If the file can't be read, or standard output can't be written.
pub fn run(command: &InfoCommand) -> Result<Exit, Failure> {
    let file = MeshFile::read(&command.input)?;
    let info = FileInfo::new(&file);
    let surface = file.surface().ok();
    let kind = surface.as_ref().map(SurfaceKind::new);
    let both = kind.as_ref().zip(surface.as_ref());
    let suggestions = both.map(|(kind, surface)| suggested(command, kind, surface));
    let told = FileAnswer {
        info: &info,
        kind: kind.as_ref(),
        suggestions: suggestions.transpose()?.unwrap_or_default(),
    };
    if command.json {
        let json = serde_json::to_string_pretty(&told).context("the information")?;
        output::print(&(json + "\n"))?;
    } else {
        let text = table(&info, command.unit) + &advice(command, &told);
        tell(command.talk.quiet, &text)?;
    }
    Ok(if info.problem.is_some() {
        Exit::InputUnusable
    } else {
        Exit::Success
    })
}

/// Everything that is told of a file.
#[derive(Serialize)]
struct FileAnswer<'a> {
    #[serde(flatten)]
    info: &'a FileInfo,
    kind: Option<&'a SurfaceKind>,
    suggestions: Vec<Suggestion>,
}

/// What to expect of the panels that are asked for, or of some usual numbers of them.
fn suggested(
    command: &InfoCommand,
    kind: &SurfaceKind,
    surface: &TriangleSurface,
) -> Result<Vec<Suggestion>, Failure> {
    let mut asked = Vec::new();
    if let Some(edge) = command.edge_length {
        let panels = panels(TypedPanelSize::EdgeLength(edge), surface, command.unit)?;
        asked.push(kind.of_panels(panels));
    }
    if let Some(near) = command.max_deviation {
        let length = near.length(command.unit, surface.diagonal());
        if length == 0.0 {
            let told = format!("--max-deviation {near}: the length must be positive");
            return Err(Failure::input(told));
        }
        asked.push(kind.of_deviation(length));
    }
    Ok(match asked.is_empty() {
        true => USUAL.map(|n| kind.of_panels(n)).to_vec(),
        false => asked,
    })
}

/// What is said where no number of panels comes as near as is asked for, which is looked for last.
fn missed(command: &InfoCommand, told: &FileAnswer<'_>) -> Option<String> {
    let (asked, last) = command.max_deviation.zip(told.suggestions.last())?;
    let misses = last.deviation > asked.length(command.unit, told.info.diagonal);
    misses.then(|| {
        let panels = last.panels;
        format!("at most {panels} panels make sense, and these are not as near as {asked}")
    })
}

fn advice(command: &InfoCommand, told: &FileAnswer<'_>) -> String {
    let unit = command.unit;
    let mut table = SummaryTable::default();
    let Some(kind) = told.kind else {
        return String::new();
    };
    for sentence in kind.sentences() {
        table.row("kind", sentence);
    }
    for s in &told.suggestions {
        let share = 100.0 * s.deviation / told.info.diagonal;
        let (edge, off) = (s.edge_length, s.deviation);
        table.row(
            "suggestion",
            format!(
                "-n {}: edges of about {} {unit}, {} {unit} ({share:.2} %) off the surface",
                s.panels,
                four_digits(edge),
                four_digits(off)
            ),
        );
    }
    if told.info.face_sizes.keys().any(|n| *n > 3) {
        table.row(
            "note",
            "`phex mesh` takes polygons as triangles and makes panels of its own; `phex planarize` makes given faces planar, three of \
             which meet at each inner vertex; a mesh of quadrilaterals is a surface here, not panels",
        );
    }
    if let Some(note) = missed(command, told) {
        table.row("note", note);
    }
    let least = kind.resolving();
    if told.suggestions.iter().any(|s| s.panels < least) {
        table.row(
            "note",
            format!("fewer than about {least} panels are longer than its tightest bends: --adaptive makes them smaller there"),
        );
    }
    table.into_text()
}

fn table(info: &FileInfo, unit: Unit) -> String {
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
    ]
    .map(four_digits);
    table.row(
        "edges",
        format!("from {min} to {max} {unit}, mean {mean} {unit}"),
    );
    if let Some(area) = info.area {
        table.row("area", unit.told_area(area));
        table.row("components", info.components.len());
    }
    for component in info.components.iter().take(LISTED) {
        table.row("surface", sentence(component, unit));
    }
    if info.components.len() > LISTED {
        table.row(
            "surface",
            format!("and {} more", info.components.len() - LISTED),
        );
    }
    for note in info.notes.iter().chain(&unit.doubted(info.diagonal)) {
        table.row("note", note);
    }
    if let Some(problem) = &info.problem {
        table.row("PROBLEM", problem);
        if let Some(place) = place(info) {
            table.row("", place);
        }
    }
    table.into_text()
}

/// Where the problem is.
fn place(info: &FileInfo) -> Option<String> {
    let named = info.problem_at.iter().take(LISTED);
    let places: Vec<String> = named.copied().map(told_place).collect();
    let more = match info.problem_at.len().saturating_sub(LISTED) {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    let told = places.join(", ");
    (!places.is_empty()).then(|| format!("at {told}{more}; vertices and faces are counted from 0"))
}

fn faces_by_size(info: &FileInfo) -> String {
    let sizes: Vec<String> = info
        .face_sizes
        .iter()
        .map(|(size, n)| format!("{n} with {size} corners"))
        .collect();
    format!("{} ({})", info.faces, sizes.join(", "))
}

fn sentence(component: &ComponentInfo, unit: Unit) -> String {
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
    let area = unit.told_area(*area);
    format!("{vertices} vertices, {triangles} triangles, {boundary}, genus {genus}, area {area}")
}
