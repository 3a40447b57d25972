//! `phex parallel`: meshes parallel to a given one: the closest to a surface or to edge lengths,
//! and the space of all of them.

mod space;

use super::deliver::{Delivery, judged};
use crate::exit::{Exit, Failure, OrExit};
use crate::html::Shown;
use crate::output::{check_writable, given, write_text};
use crate::parallel_arguments::{ParallelCommand, ParallelStart};
use crate::progress::{Reporter, check_interruption};
use crate::summary::SummaryTable;
use crate::verdict::written;
use anyhow::Context;
use phex::offset::face_curvatures;
use phex::offset::{EdgeSigns, FitOptions, FitStart, Fitted, SIGNED_FAIRNESS, fit_parallel};
use phex::report::InputFile;
use phex_job::TypedLimits;
use phex_job::{Content, MeshFile};
use phex_mesh::{FlatFace, HexMesh, TriangleSurface};
use serde_json::{Value, json};
use std::path::Path;

/// A parallel mesh, with what there is to say of it.
struct ParallelMesh {
    mesh: HexMesh,
    surface: Option<TriangleSurface>,
    /// The surface's file.
    input: Option<InputFile>,
    settings: Value,
    statistics: Value,
    table: SummaryTable,
    /// The basis, as CSV.
    basis: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// If an input can't be used, or the output can't be written.
pub fn run(command: &ParallelCommand) -> Result<Exit, Failure> {
    command.limits.check(command.surface.is_some())?;
    check_writable(&outputs(command), &inputs(command))?;
    let file = MeshFile::read(&command.input)?;
    let (mesh, _) = file.polygon_mesh()?;
    let made = match &command.surface {
        Some(surface) => fitted(command, &mesh, surface)?,
        None => space::made(command, mesh)?,
    };
    check_interruption()?;
    let limits = TypedLimits::from(&command.limits);
    let shown = Shown {
        surface: made.surface.as_ref(),
        ..Shown::of(&made.mesh)
    };
    let mut report = judged("parallel", &shown, &limits);
    report.settings = json!({ "parallel": made.settings });
    report.statistics = made.statistics.clone();
    report.inputs = std::iter::once(file.record)
        .chain(made.input.clone())
        .collect();
    if let (Some(path), Some(text)) = (&command.basis, &made.basis) {
        write_text(path, text)?;
        report.outputs.push(written("basis", path));
    }
    Delivery {
        output: command.output.as_deref(),
        keep_invalid: command.keep_invalid,
        // Without a file to write, the space is told and no mesh is made.
        panels: command.output.is_some(),
        after: made.table.clone().into_text(),
        ..Delivery::new(shown, report, limits, &command.extras, &command.talk)
    }
    .send()
}

fn inputs(command: &ParallelCommand) -> Vec<&Path> {
    let signs = command.signs.as_ref().filter(|signs| !is_rule(signs));
    given([
        Some(&command.input),
        command.surface.as_ref(),
        command.lengths.as_ref(),
        signs,
    ])
}

fn outputs(command: &ParallelCommand) -> Vec<(&Path, Content)> {
    let mesh = command.output.as_deref().map(|p| (p, Content::Mesh));
    let basis = command.basis.as_deref().map(|p| (p, Content::Other));
    mesh.into_iter()
        .chain(basis)
        .chain(command.extras.outputs())
        .collect()
}

/// The parallel mesh that is closest to a surface.
fn fitted(
    command: &ParallelCommand,
    mesh: &HexMesh,
    surface: &Path,
) -> Result<ParallelMesh, Failure> {
    let reporter = Reporter::new(&command.talk);
    let file = MeshFile::read(surface)?;
    let surface = file.surface()?;
    let options = options(command, mesh)?;
    let fitted = fit_parallel(mesh, &surface, &options, &reporter)
        .with_context(|| command.input.display().to_string())
        .or_exit(Exit::InputUnusable)?;
    reporter.finish();
    Ok(ParallelMesh {
        settings: json!(options),
        statistics: json!({
            "status": fitted.status,
            "rounds": fitted.rounds,
            "edges_at_bound": fitted.edges_at_bound,
            "reversed_edges": fitted.reversed_edges.len(),
            "crossed_faces": fitted.crossed_faces,
            "mean_curvature": fitted.mean_curvature,
            "mean_curvature_spread": fitted.mean_curvature_spread,
        }),
        table: table(&fitted, mesh),
        basis: command
            .basis
            .is_some()
            .then(|| space::of(mesh).map(|space| space::basis(&space)))
            .transpose()?,
        mesh: facing(fitted.mesh, mesh),
        surface: Some(surface),
        input: Some(file.record),
    })
}

/// Whether the sign rule is asked for.
fn is_rule(signs: &Path) -> bool {
    signs.as_os_str() == "rule"
}

/// The mesh with its faces to the side of the surface to which the Gauss image looks.
fn facing(mesh: HexMesh, gauss_image: &HexMesh) -> HexMesh {
    let normal = |mesh: &HexMesh, f| FlatFace::of(mesh, f).normal();
    let faces = mesh.topology().faces();
    let same: f64 = faces
        .map(|f| normal(&mesh, f).dot(&normal(gauss_image, f)))
        .sum();
    if same < 0.0 { mesh.turned_over() } else { mesh }
}

fn options(command: &ParallelCommand, mesh: &HexMesh) -> Result<FitOptions, Failure> {
    Ok(FitOptions {
        signs: match &command.signs {
            None => EdgeSigns::Positive,
            Some(rule) if is_rule(rule) => EdgeSigns::SignRule,
            Some(file) => EdgeSigns::Reversed(space::edges(file, mesh)?),
        },
        minimal: command.minimal,
        start: match command.start {
            ParallelStart::Normals => FitStart::Normals,
            ParallelStart::Positions => FitStart::Positions,
        },
        least_edge: command.least_edge,
        fairness: command.fairness.unwrap_or(if command.signs.is_some() {
            SIGNED_FAIRNESS
        } else {
            FitOptions::default().fairness
        }),
        constant_mean_curvature: command.constant_mean_curvature,
        ..FitOptions::default()
    })
}

fn table(fitted: &Fitted, gauss_image: &HexMesh) -> SummaryTable {
    let mut table = SummaryTable::default();
    table.row(
        "fit",
        format!("{:?} after {} rounds", fitted.status, fitted.rounds),
    );
    if !fitted.reversed_edges.is_empty() {
        let (reversed, all) = (
            fitted.reversed_edges.len(),
            fitted.mesh.topology().n_edges(),
        );
        table.row(
            "signs",
            format!("{reversed} of {all} edges run against those of the given mesh"),
        );
    }
    if fitted.edges_at_bound > 0 {
        table.row(
            "short edges",
            format!("{} are as short as is allowed", fitted.edges_at_bound),
        );
    }
    let spread = fitted.mean_curvature_spread;
    let faces = face_curvatures(&fitted.mesh, gauss_image);
    let ends = faces.iter().fold([f64::MAX, f64::MIN], |[low, high], c| {
        [low.min(c.mean), high.max(c.mean)]
    });
    table.row(
        "curvature",
        format!(
            "mean {:.4}, rms spread {spread:.1e} of it; faces from {:.5} to {:.5}",
            fitted.mean_curvature, ends[0], ends[1]
        ),
    );
    table
}
