//! `phex sweep`: every variant of a study, and a table and a page of them.

use super::{tell, use_threads};
use crate::exit::{Exit, Failure};
use crate::html::Silently;
use crate::output::write_text;
use crate::sweep_arguments::{CollectArguments, SweepArguments, SweepCommand, SweepPart};
use phex_study::{Row, StudyFile, Variant, collect, csv, page, solve};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::time::Instant;

/// Runs the command.
///
/// # Errors
/// If the study can't be used, a file can't be written, or the user interrupts. Variants that end
/// without a mesh are rows, and no error.
pub fn run(command: &SweepCommand) -> Result<Exit, Failure> {
    match &command.part {
        Some(SweepPart::Collect(arguments)) => collected(arguments),
        None => swept(&command.solve),
    }
}

fn swept(arguments: &SweepArguments) -> Result<Exit, Failure> {
    let (Some(study), Some(out)) = (&arguments.study, &arguments.output) else {
        return Err(Failure::new(Exit::Usage, "give a study and --output"));
    };
    use_threads(arguments.threads)?;
    let file = StudyFile::read(study)?;
    let options = file.solve_options()?;
    let variants = arguments.shard.unwrap_or_default().of(file.variants()?);
    // A variant that can't be named would end the study half-way.
    phex_study::keys(&variants)?;
    std::fs::create_dir_all(out).map_err(|e| Failure::input(format!("{}: {e}", out.display())))?;
    let (begun, count) = (Instant::now(), variants.len());
    let mut endings: BTreeMap<String, usize> = BTreeMap::new();
    for (k, variant) in variants.iter().enumerate() {
        let row = solve(variant, out, &options, &Silently)?;
        *endings.entry(status(&row)).or_default() += 1;
        let seconds = begun.elapsed().as_secs_f64();
        let left = seconds / (k + 1) as f64 * (count - k - 1) as f64;
        tell(
            arguments.talk.quiet,
            &format!(
                "{}  {} of {count}, {left:.0} s left\n",
                line(variant, &row),
                k + 1
            ),
        )?;
    }
    let told: Vec<String> = endings.iter().map(|(s, n)| format!("{n} {s}")).collect();
    tell(
        arguments.talk.quiet,
        &format!("study      {count} variants: {}\n", told.join(", ")),
    )?;
    Ok(match endings.contains_key("not-written") {
        true => Exit::Internal,
        false => Exit::Success,
    })
}

fn status(row: &Row) -> String {
    let status = row.get("out:status").and_then(Value::as_str);
    status.unwrap_or_default().to_owned()
}

/// A variant in a line: its folder, how it ended, why.
fn line(variant: &Variant, row: &Row) -> String {
    let text = |name: &str| row.get(name).and_then(Value::as_str).unwrap_or_default();
    let surface = variant.surface.display();
    let words = [text("key"), text("out:status"), text("out:reason")];
    format!("{} {surface}", words.join(" ").trim_end())
}

fn collected(arguments: &CollectArguments) -> Result<Exit, Failure> {
    let folder = &arguments.folder;
    let rows = collect(folder)?;
    if rows.is_empty() {
        let told = format!(
            "{}: no folder in it holds a finished variant",
            folder.display()
        );
        return Err(Failure::input(told));
    }
    let name = folder.canonicalize().unwrap_or_else(|_| folder.clone());
    let name = name.file_name().map(|n| n.to_string_lossy().into_owned());
    let title = arguments.title.clone().or(name).unwrap_or_default();
    let files = [
        ("designs.csv", csv(&rows)?),
        ("index.html", page(&title, &rows, folder)?),
    ];
    for (name, text) in &files {
        write_text(&folder.join(name), text)?;
    }
    let told = |(name, text): &(&str, String)| {
        let place = Path::new(folder).join(name);
        format!(
            "wrote      {} ({} kB)\n",
            place.display(),
            text.len() / 1000
        )
    };
    let told: String = files.iter().map(told).collect();
    tell(
        arguments.talk.quiet,
        &format!("study      {} variants\n{told}", rows.len()),
    )?;
    Ok(Exit::Success)
}
