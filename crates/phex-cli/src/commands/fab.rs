//! `phex fab`: the folder of workshop files.

use super::{in_unit, tell, use_threads};
use crate::exit::{Exit, Failure};
use crate::fab_arguments::FabCommand;
use crate::output::given;
use crate::output_folder::{Extent, OutputFolder};
use crate::progress::Reporter;
use crate::summary::SummaryTable;
use phex_fab::folder::{files, left_out, summary};
use phex_fab::plate::Plate;
use phex_fab::schedule::{self, panel_centres};
use phex_fab::{FabError, FabOptions, Fabrication, PanelIds, fabricate, valid_mesh};
use phex_job::MeshFile;
use phex_job::MeshSettings;
use phex_job::{Unit, chain};
use phex_mesh::{HexMesh, ValidateOptions};
use std::collections::BTreeSet;
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If the mesh is not valid, the thickness goes past the safe offset, a panel does not fit on a
/// sheet, the folder can't be written, or it holds an input or files of others that are in the way;
/// nothing is written then.
pub fn run(command: &FabCommand) -> Result<Exit, Failure> {
    use_threads(command.threads)?;
    let folder = OutputFolder::new(&command.output, "fab", Extent::Whole);
    let inputs = given([
        Some(&command.input),
        command.keep_ids.as_ref(),
        command.limits.as_ref(),
    ]);
    folder.check(&[], &inputs)?;
    let (mesh, _) = MeshFile::read(&command.input)?.polygon_mesh()?;
    let (options, unit) = options(command, &mesh)?;
    let failure = |error| failure(error, unit);
    let ids = ids(command.keep_ids.as_deref(), &mesh, options.unit_mm)?;
    let valid = valid_mesh(mesh, &ids, &options.validity).map_err(failure)?;
    let reporter = Reporter::new(&command.talk);
    let fabrication = fabricate(valid, ids, options, &reporter);
    reporter.finish();
    let fabrication = fabrication.map_err(failure)?;
    let files = files(&fabrication).map_err(failure)?;
    folder.write(&files)?;
    tell(command.talk.quiet, &text(&fabrication, command))?;
    Ok(Exit::Success)
}

fn options(command: &FabCommand, mesh: &HexMesh) -> Result<(FabOptions, Unit), Failure> {
    let limits = command.limits.as_deref().map(MeshSettings::from_file);
    let limits = limits.transpose()?.unwrap_or_default();
    limits.check()?;
    let unit = command.unit.or(limits.unit).unwrap_or_default();
    let size = mesh.diagonal();
    let planarity = command
        .planarity
        .map(|q| q.fraction(unit, mesh.mean_edge()));
    let options = FabOptions {
        thickness: command.thickness.length(unit, size),
        gap: command.gap.map_or(0.0, |gap| gap.length(unit, size)),
        side: command.side.into(),
        unit_mm: unit.metres() / Unit::Mm.metres(),
        sheet_mm: command.sheet.millimetres(),
        spacing_mm: command.spacing.millimetres(),
        rotations: command.rotations.clone(),
        nest_effort: command.nest_effort,
        tolerance_mm: command.tolerance.millimetres(),
        angle_tolerance: command.angle_tolerance.to_radians(),
        text_mm: command.text.millimetres(),
        limits: limits.limits.in_units(unit, size),
        validity: ValidateOptions {
            planarity,
            ..Default::default()
        },
    };
    Ok((options, unit))
}

fn ids(previous: Option<&Path>, mesh: &HexMesh, unit_mm: f64) -> Result<PanelIds, Failure> {
    let Some(path) = previous else {
        return Ok(PanelIds::new(mesh));
    };
    let unreadable =
        |cause: &dyn std::fmt::Display| Failure::input(format!("{}: {cause}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| unreadable(&e))?;
    let mut centres = panel_centres(&bytes).map_err(|e| unreadable(&e))?;
    centres
        .iter_mut()
        .for_each(|(_, centre)| *centre /= unit_mm);
    Ok(PanelIds::keeping(mesh, &centres))
}

fn failure(error: FabError, unit: Unit) -> Failure {
    let exit = match error {
        // A thickness or a gap that was typed.
        FabError::Offset { .. } => return in_unit(chain(&error), unit),
        FabError::Cancelled => return Failure::interrupted(),
        FabError::Content { .. } | FabError::Nest { .. } => Exit::Internal,
        _ => Exit::InputUnusable,
    };
    Failure {
        exit,
        cause: error.into(),
    }
}

/// Most panels that a line of the table names; the `panels` schedule has all.
const NAMED: usize = 6;
/// Reach of a lower face beyond the upper one that is told, in mm.
const NOTICED: f64 = 0.1;

fn text(fabrication: &Fabrication, command: &FabCommand) -> String {
    let summary = summary(fabrication);
    let number = |name: &str| summary[name].as_f64().unwrap_or(f64::NAN);
    let mut table = SummaryTable::default();
    table.row(
        "panels",
        format!(
            "{}, {} distinct ({}), {:.1} m2",
            number("panels"),
            number("distinct_panels"),
            naming(fabrication),
            number("area_m2")
        ),
    );
    table.row(
        "edges",
        format!(
            "{}, {} distinct lengths, {} distinct dihedral angles, {}",
            number("edges"),
            number("distinct_lengths"),
            number("distinct_dihedral_angles"),
            mitres(fabrication)
        ),
    );
    let [length, width] = fabrication.options.sheet_mm;
    table.row(
        "sheets",
        format!(
            "{} of {width} x {length} mm, used to {:.1} % ({:.1} % without the last one's offcut)",
            number("sheets"),
            number("use_percent"),
            number("use_without_last_offcut_percent")
        ),
    );
    let lines = [
        ("names", nothing_kept(command, fabrication)),
        ("limits", beyond_limits(fabrication)),
        ("CUT", beyond(fabrication)),
        ("no room", without_room(fabrication)),
        ("left out", left_out(fabrication)),
    ];
    for (name, line) in lines {
        if let Some(line) = line {
            table.row(name, line);
        }
    }
    table.row("written", command.output.display());
    table.into_text()
}

/// How panels are named: by the letters of their rows, by numbers, or as in an earlier run.
fn naming(fabrication: &Fabrication) -> String {
    let ids = &fabrication.ids;
    let names = || fabrication.plates.iter().map(|plate| ids.panel(plate.face));
    if let Some(kept) = ids.kept() {
        return format!("{kept} of their names kept");
    }
    if ids.has_rows() {
        // The shorter letters come first: AA after Z.
        let row = |name: &'_ str| {
            name.trim_end_matches(|c: char| c.is_ascii_digit())
                .to_owned()
        };
        let rows: BTreeSet<(usize, String)> = names().map(row).map(|r| (r.len(), r)).collect();
        let [first, last] = [rows.first(), rows.last()].map(|r| r.map_or("", |(_, row)| row));
        return format!("named by rows, {first} to {last}");
    }
    let [first, last] = [names().next(), names().next_back()].map(Option::unwrap_or_default);
    format!("{first} to {last}")
}

/// That no panel keeps a name, where names were to be kept.
fn nothing_kept(command: &FabCommand, fabrication: &Fabrication) -> Option<String> {
    let path = command
        .keep_ids
        .as_ref()
        .filter(|_| fabrication.ids.kept() == Some(0))?;
    Some(format!(
        "of {} fit no panel, all are new: none is within half a mean edge of one there",
        path.display()
    ))
}

/// How many panels are beyond which limits, where some are set.
fn beyond_limits(fabrication: &Fabrication) -> Option<String> {
    let (panels, of) = schedule::beyond_limits(fabrication);
    if of.is_empty() {
        return None;
    }
    if panels == 0 {
        return Some("all panels keep to them".to_owned());
    }
    let missed = of.iter().filter(|(_, count)| *count > 0);
    let missed = missed.map(|(kind, count)| format!("{count} --{}", kind.name().replace('_', "-")));
    Some(format!(
        "{panels} panels are beyond them: {} (columns ..._used of panels.csv)",
        missed.collect::<Vec<_>>().join(", ")
    ))
}

/// How far lower faces reach beyond the upper ones, which are what is drawn to cut.
fn beyond(fabrication: &Fabrication) -> Option<String> {
    let beyond = fabrication.plates.iter().map(Plate::beyond);
    let all: Vec<f64> = beyond.filter(|&mm| mm >= NOTICED).collect();
    let most = all.iter().copied().fold(0.0, f64::max);
    let panels = match all.len() {
        0 => return None,
        1 => "one panel".to_owned(),
        n => format!("{n} panels"),
    };
    Some(format!(
        "is the upper faces; the lower ones of {panels} reach beyond, up to {most:.1} mm"
    ))
}

fn mitres(fabrication: &Fabrication) -> String {
    let sides = fabrication.plates.iter().flat_map(|p| &p.sides);
    let degrees = sides.map(|s| s.mitre.to_degrees());
    let (low, high) = degrees.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), m| {
        (low.min(m), high.max(m))
    });
    format!("mitres {low:+.1} to {high:+.1} degrees")
}

/// The panels that are too small for a text, if there are any.
fn without_room(fabrication: &Fabrication) -> Option<String> {
    let panels = fabrication.texts.iter().zip(&fabrication.plates);
    let names: Vec<&str> = panels
        .filter(|(text, _)| !text.left_out.is_empty())
        .map(|(_, plate)| fabrication.ids.panel(plate.face))
        .collect();
    let first = names[..names.len().min(NAMED)].join(", ");
    let all = match names.len() {
        0 => return None,
        n if n > NAMED => format!("{n} panels, {first} ..."),
        _ => first,
    };
    Some(format!(
        "for every label on {all} (column labels_left_out of panels.csv)"
    ))
}
