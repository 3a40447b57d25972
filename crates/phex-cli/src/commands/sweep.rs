//! `phex sweep`: every variant of a study, and a table and a page of them.

use super::{tell, use_threads};
use crate::exit::{Exit, Failure};
use crate::html::Silently;
use crate::output_folder::{Extent, NamedFile, OutputFolder};
use crate::printable;
use crate::progress::Reporter;
use crate::shared_arguments::{ProgressMode, Talk};
use crate::sweep_arguments::{CollectArguments, SweepArguments, SweepCommand, SweepPart};
use phex::Progress;
use phex_study::{Row, StudyFile, Variant, collect, csv, page, solve};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::time::Instant;

/// Characters of a reason in a line; the table has all of it.
const LONGEST: usize = 110;
/// Files that `collect` writes.
const TABLE: &str = "designs.csv";
const PAGE: &str = "index.html";

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
    // Making tens of thousands of variants and naming their folders takes seconds.
    let told = format!("study      {} variants\n", file.count()?);
    tell(arguments.talk.quiet, &told)?;
    let variants = arguments.shard.unwrap_or_default().of(file.variants()?);
    // A variant that can't be named would end the study half-way.
    let keys = phex_study::keys(&variants)?;
    if let Some(note) = doubles(&variants, &keys) {
        Reporter::new(&arguments.talk).note(note);
    }
    std::fs::create_dir_all(out).map_err(|e| Failure::input(format!("{}: {e}", out.display())))?;
    let (begun, count) = (Instant::now(), variants.len());
    let mut endings: BTreeMap<String, usize> = BTreeMap::new();
    // JSON tells of whole variants, as in Python.
    let stages = Reporter::new(&Talk {
        progress: ProgressMode::None,
        ..arguments.talk.clone()
    });
    let progress: &dyn Progress = match arguments.talk.verbose {
        true => &stages,
        false => &Silently,
    };
    for (k, variant) in variants.iter().enumerate() {
        let row = solve(variant, out, &options, progress)?;
        *endings.entry(status(&row)).or_default() += 1;
        let seconds = begun.elapsed().as_secs_f64();
        let left = seconds / (k + 1) as f64 * (count - k - 1) as f64;
        if arguments.talk.progress == ProgressMode::Json {
            let done = (k + 1) as f64 / count as f64;
            printable::tell(&json!({ "event": "variant", "row": row }).to_string());
            let event = json!({ "event": "progress", "done": done, "left_seconds": left });
            printable::tell(&event.to_string());
        }
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

/// A sentence on variants that are the same as an earlier one, and that become one row with it.
fn doubles(variants: &[Variant], keys: &[String]) -> Option<String> {
    let mut first = HashMap::new();
    let earlier = |k: usize| Some((*first.entry(&keys[k]).or_insert(k), k)).filter(|(a, b)| a < b);
    let doubles: Vec<(usize, usize)> = (0..keys.len()).filter_map(earlier).collect();
    let &(a, b) = doubles.first()?;
    let name = |k: usize| variants[k].surface.display();
    let cause = match variants[a].surface == variants[b].surface {
        true => format!("{}: the same settings twice", name(a)),
        false => format!("{} and {} hold the same bytes", name(a), name(b)),
    };
    Some(match doubles.len() {
        1 => format!(
            "one of the variants is the same as another and becomes one row with it ({cause})"
        ),
        count => format!(
            "{count} of the variants are the same as others and become one row with them ({cause})"
        ),
    })
}

/// A variant in a line: its folder, how it ended, why, and why it can't be cut.
fn line(variant: &Variant, row: &Row) -> String {
    let text = |name: &str| row.get(name).and_then(Value::as_str).unwrap_or_default();
    let surface = variant.surface.display();
    let workshop = match text("out:workshop") {
        "" => String::new(),
        told if told.len() > LONGEST => {
            let start: String = told.chars().take(LONGEST).collect();
            format!("(workshop: {start}…)")
        }
        told => format!("(workshop: {told})"),
    };
    let words = [
        text("key"),
        text("out:status"),
        text("out:reason"),
        &workshop,
    ];
    let words: Vec<&str> = words.into_iter().filter(|w| !w.is_empty()).collect();
    format!("{} {surface}", words.join(" "))
}

fn collected(arguments: &CollectArguments) -> Result<Exit, Failure> {
    let folder = &arguments.folder;
    let output = OutputFolder::new(folder, "sweep collect", Extent::Added);
    output.check(&[TABLE, PAGE].map(str::to_owned), &[])?;
    let found = collect(folder)?;
    for told in &found.broken {
        let note = format!("{told}: left out; run the sweep again, which computes this variant");
        Reporter::new(&arguments.talk).note(note);
    }
    let rows = found.rows;
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
    let files: [NamedFile; 2] = [
        (TABLE.to_owned(), csv(&rows)?.into_bytes()),
        (PAGE.to_owned(), page(&title, &rows, folder)?.into_bytes()),
    ];
    output.write(&files)?;
    let told = |(name, bytes): &NamedFile| {
        let place = folder.join(name);
        format!(
            "written    {} ({} kB)\n",
            place.display(),
            bytes.len() / 1000
        )
    };
    let told: String = files.iter().map(told).collect();
    tell(
        arguments.talk.quiet,
        &format!("study      {} variants\n{told}", rows.len()),
    )?;
    Ok(Exit::Success)
}
