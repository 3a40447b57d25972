//! `phex mesh`: from a surface to planar hexagonal panels.

use super::deliver::Delivery;
use super::use_threads;
use crate::args::MeshCommand;
use crate::contact;
use crate::exit::{Exit, Failure};
use crate::html::Shown;
use crate::method_summary::{of_method, of_portfolio};
use crate::output::{check_writable, write_mesh};
use crate::progress::{Reporter, check_interruption, keep_best, take_interruption};
use crate::summary::{self, SummaryTable};
use crate::verdict::written;
use anyhow::Context;
use phex::report::OutputFile;
use phex_job::{
    Content, Given, JobResult, LAYOUT_ALONE, LastStage, MeshFile, MeshJob, MeshSettings, TimeLimit,
    sha256,
};
use std::path::Path;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, there is no result, or an output can't be written.
pub fn run(command: &MeshCommand) -> Result<Exit, Failure> {
    let settings = settings(command)?;
    check_writable(&outputs(command), &inputs(command, &settings))?;
    use_threads(settings.threads)?;
    let time_limit = command.time_limit.and_then(TimeLimit::from_now);
    let reporter = Reporter::new(&command.talk).within(time_limit);
    let job = job(command, settings, time_limit)?;
    if command.keep_best {
        keep_best();
    }
    let made = phex_job::run(&job, &reporter);
    reporter.finish();
    let made = made?;
    if command.keep_best {
        take_interruption();
    } else {
        check_interruption()?;
    }
    deliver(command, made)
}

fn job(
    command: &MeshCommand,
    settings: MeshSettings,
    time_limit: Option<TimeLimit>,
) -> Result<MeshJob, Failure> {
    let file = MeshFile::read(&command.input)?;
    let parts = file.surfaces()?;
    let given = Given::read(&settings)?;
    let start = command.start.as_deref().map(MeshFile::read).transpose()?;
    let start = start.map(|file| Ok::<_, Failure>((file.polygon_mesh()?.0, file.record)));
    Ok(MeshJob {
        given,
        start: start.transpose()?,
        keep_best: command.keep_best,
        time_limit,
        until: command.until,
        ..MeshJob::new(parts, file.record, settings)
    })
}

fn deliver(command: &MeshCommand, mut made: JobResult) -> Result<Exit, Failure> {
    if let Some(path) = &command.contact_sheet {
        contact::write(path, &made)?;
        made.report.outputs.push(written("contact_sheet", path));
    }
    let ways = made.tried.iter().zip(&made.classical);
    let methods =
        ways.map(|(tried, classical)| of_portfolio(tried) + &of_method(classical.as_ref()));
    let mut report = made.report;
    if let (Some(path), Some(smooth)) = (&command.write_target, &made.smooth) {
        write_mesh(path, &smooth.to_soup(), made.limits.unit)?;
        let bytes = std::fs::read(path).with_context(|| path.display().to_string())?;
        report.outputs.push(OutputFile {
            sha256: Some(sha256(bytes)),
            ..written("smooth_target", path)
        });
    }
    let before = match command.until {
        Some(LastStage::Layout) => {
            let count = made.mesh.topology().n_faces();
            let mut table = SummaryTable::default();
            table.row("layout", format!("{count} panels, {LAYOUT_ALONE}"));
            table.into_text()
        }
        None => methods.collect(),
    };
    let shown = Shown {
        surface: made.smooth.as_ref().or(Some(&made.facets)),
        start: made.start.as_ref(),
        given: Some(&made.facets),
        mesh: &made.mesh,
    };
    Delivery {
        output: Some(&command.output),
        keep_invalid: command.keep_invalid,
        panels: command.until.is_none(),
        before,
        after: summary::of_repetition(&report)
            + &summary::of_wishes(&made.wishes)
            + &summary::of_warnings(made.warnings),
        ..Delivery::new(shown, report, made.limits, &command.extras, &command.talk)
    }
    .send()
}

fn settings(command: &MeshCommand) -> Result<MeshSettings, Failure> {
    let file = command
        .config
        .as_deref()
        .map(MeshSettings::from_file)
        .transpose()?;
    let settings = command.settings.clone().over(file.unwrap_or_default());
    settings.check()?;
    let others = [("time-limit", command.time_limit.is_some())];
    let typed = &command.settings;
    typed.check_until(command.until, &settings, &Given::default(), &others)?;
    if command.start.is_some() {
        typed.check_start(&Given::default())?;
    } else {
        settings.check_effects(&Given::default())?;
    }
    Ok(settings)
}

fn inputs<'a>(command: &'a MeshCommand, settings: &'a MeshSettings) -> Vec<&'a Path> {
    std::iter::once(command.input.as_path())
        .chain(command.config.as_deref())
        .chain(command.start.as_deref())
        .chain(settings.inputs())
        .collect()
}

fn outputs(command: &MeshCommand) -> Vec<(&Path, Content)> {
    let target = command
        .write_target
        .as_deref()
        .map(|path| (path, Content::Mesh));
    let sheet = command.contact_sheet.as_deref();
    let sheet = sheet.map(|path| (path, Content::Other));
    std::iter::once((command.output.as_path(), Content::Mesh))
        .chain(target)
        .chain(sheet)
        .chain(command.extras.outputs())
        .collect()
}
