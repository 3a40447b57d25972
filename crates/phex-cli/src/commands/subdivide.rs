//! `phex subdivide`: a finer mesh with planar faces.

use super::deliver::{Delivery, judged, outputs};
use crate::dual_arguments::{SubdivideCommand, SubdivideRule};
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::output::{check_writable, given};
use crate::progress::{Reporter, check_interruption};
use crate::summary::SummaryTable;
use anyhow::Context;
use phex::classical::SubdivisionRule;
use phex::classical::{clear_quadric, dual_subdivision, one_sign};
use phex_job::MeshFile;
use phex_job::TypedLimits;
use phex_mesh::{HexMesh, TriangleSurface, measure};
use serde_json::json;

/// Runs the command.
///
/// # Errors
/// If an input can't be used, the mesh has no dual, or the output can't be written.
pub fn run(command: &SubdivideCommand) -> Result<Exit, Failure> {
    let inputs = given([Some(&command.input), command.surface.as_ref()]);
    if command.any_domain && command.rule == SubdivideRule::Robust {
        return Err(Failure::input(
            "--any-domain has no effect with --rule robust, which takes any surface",
        ));
    }
    command.limits.check(command.surface.is_some())?;
    check_writable(&outputs(&command.output, &command.extras), &inputs)?;
    let reporter = Reporter::new(&command.talk);
    let file = MeshFile::read(&command.input)?;
    let surface_file = command.surface.as_deref().map(MeshFile::read).transpose()?;
    let (mesh, _) = file.polygon_mesh()?;
    let surface = match &surface_file {
        Some(file) => Some(file.surface()?),
        None if command.rule == SubdivideRule::Robust => Some(file.surface()?),
        None => None,
    };
    let outside = outside_domain(command, &mesh)?;
    let levels = made(command, &mesh, surface.as_ref(), &reporter)?;
    reporter.finish();
    check_interruption()?;
    let mut table = SummaryTable::default();
    if let Some(sentence) = &outside {
        table.row("domain", format!("outside: {sentence}"));
    }
    for (k, level) in levels.iter().enumerate() {
        let m = measure(level);
        let (planarity, crossed) = (m.planarity.max, m.faces_not_simple);
        table.row(
            "level",
            format!(
                "{}: {} panels, planarity {planarity:.1e} mean edges, {crossed} not simple",
                k + 1,
                m.faces
            ),
        );
    }
    let finest = levels.last().unwrap_or(&mesh);
    let limits = TypedLimits::from(&command.limits);
    let shown = Shown {
        surface: surface.as_ref().filter(|_| surface_file.is_some()),
        ..Shown::of(finest)
    };
    let mut report = judged("subdivide", &shown, &limits);
    report.settings = json!({ "rule": format!("{:?}", command.rule), "levels": command.levels });
    report.statistics = json!({ "outside_domain": outside });
    report.inputs = std::iter::once(file.record)
        .chain(surface_file.map(|f| f.record))
        .collect();
    Delivery {
        output: Some(&command.output),
        keep_invalid: command.keep_invalid,
        after: table.into_text(),
        ..Delivery::new(shown, report, limits, &command.extras, &command.talk)
    }
    .send()
}

/// Why the rules through the dual do not apply to a mesh, if they are to be tried all the same.
fn outside_domain(command: &SubdivideCommand, mesh: &HexMesh) -> Result<Option<String>, Failure> {
    if command.rule == SubdivideRule::Robust {
        return Ok(None);
    }
    match one_sign(mesh) {
        Ok(_) => Ok(None),
        Err(e) if command.any_domain => Ok(Some(e.to_string())),
        Err(e) => Err(e)
            .with_context(|| command.input.display().to_string())
            .or_exit(Exit::InputUnusable),
    }
}

fn made(
    command: &SubdivideCommand,
    mesh: &HexMesh,
    surface: Option<&TriangleSurface>,
    reporter: &Reporter,
) -> Result<Vec<HexMesh>, Failure> {
    let levels = usize::from(command.levels);
    let rule = match (command.rule, surface) {
        (SubdivideRule::Robust, Some(surface)) => {
            return Ok(phex_job::subdivide(mesh, surface, levels, reporter)?);
        }
        (SubdivideRule::Butterfly, _) => SubdivisionRule::Butterfly,
        _ => SubdivisionRule::Loop,
    };
    let refined = clear_quadric(mesh).and_then(|q| dual_subdivision(mesh, &q, rule, levels));
    refined
        .with_context(|| command.input.display().to_string())
        .or_exit(Exit::InputUnusable)
}
