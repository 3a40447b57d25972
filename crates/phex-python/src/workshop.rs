//! The request for the workshop's files.

use crate::answer::{Answer, AnswerPart};
use crate::inputs::Inputs;
use phex::Progress;
use phex_fab::folder::{files, summary};
use phex_fab::{FabError, FabOptions, PanelIds, Rotations, Side, fabricate, valid_mesh};
use phex_job::{JobError, MeshSettings, Quantity, SheetSize, Unit, WorkshopLength, chain};
use phex_mesh::ValidateOptions;
use serde::Deserialize;
use std::path::PathBuf;

/// Options of `phex.fabricate`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorkshopRequest {
    thickness: Quantity,
    gap: Option<Quantity>,
    side: Side,
    unit: Option<Unit>,
    /// That of the run which made the mesh.
    mesh_unit: Option<Unit>,
    sheet: SheetSize,
    spacing: Quantity,
    rotations: Option<Vec<f64>>,
    nest_effort: u32,
    text: Quantity,
    tolerance: Quantity,
    angle_tolerance: f64,
    planarity: Option<Quantity>,
    limits: Option<PathBuf>,
}

impl WorkshopRequest {
    /// The unit of the mesh: what is given, or else what its run and the job file agree on.
    fn model_unit(&self, job: Option<Unit>) -> Result<Unit, JobError> {
        match (self.unit, self.mesh_unit, job) {
            (None, Some(mesh), Some(job)) if mesh != job => Err(JobError::Input(format!(
                "limits: the job's unit is {job}, and that of the mesh {mesh}: give `unit`"
            ))),
            (given, mesh, job) => Ok(given.or(mesh).or(job).unwrap_or_default()),
        }
    }
}

/// Workshop files of a valid mesh.
///
/// # Errors
/// If the mesh is not valid, the thickness goes too far or a panel does not fit on a sheet.
pub fn fabricated(
    request: WorkshopRequest,
    inputs: Inputs,
    progress: &dyn Progress,
) -> Result<Answer, JobError> {
    let mesh = inputs.panels()?;
    let limits = request.limits.as_deref().map(MeshSettings::from_file);
    let limits = limits.transpose()?.unwrap_or_default();
    limits.check()?;
    let (unit, size) = (request.model_unit(limits.unit)?, mesh.diagonal());
    let planarity = request
        .planarity
        .map(|q| q.fraction(unit, mesh.mean_edge()));
    let options = FabOptions {
        thickness: request.thickness.length(unit, size),
        gap: request.gap.map_or(0.0, |gap| gap.length(unit, size)),
        side: request.side,
        unit_mm: unit.metres() / Unit::Mm.metres(),
        sheet_mm: request.sheet.millimetres(),
        spacing_mm: millimetres("spacing", request.spacing)?,
        rotations: request
            .rotations
            .map_or(Rotations::Free, Rotations::Degrees),
        nest_effort: request.nest_effort,
        tolerance_mm: millimetres("tolerance", request.tolerance)?,
        angle_tolerance: request.angle_tolerance.to_radians(),
        text_mm: millimetres("text", request.text)?,
        limits: limits.limits.in_units(unit, size),
        validity: ValidateOptions {
            planarity,
            ..ValidateOptions::default()
        },
    };
    let ids = PanelIds::new(&mesh);
    let valid = valid_mesh(mesh, &ids, &options.validity).map_err(failure)?;
    let made = fabricate(valid, ids, options, progress).map_err(failure)?;
    Ok(vec![
        ("summary", AnswerPart::Text(summary(&made).to_string())),
        ("files", AnswerPart::Files(files(&made).map_err(failure)?)),
    ])
}

/// A length of the workshop: a plain number is in millimetres.
fn millimetres(name: &str, quantity: Quantity) -> Result<f64, JobError> {
    let length = WorkshopLength::try_from(quantity);
    let length = length.map_err(|e| JobError::Input(format!("{name}: {e}")))?;
    Ok(length.millimetres())
}

fn failure(error: FabError) -> JobError {
    let told = chain(&error);
    match error {
        FabError::Cancelled => JobError::Cancelled,
        FabError::Content { .. } | FabError::Nest { .. } => JobError::Internal(told),
        _ => JobError::Input(told),
    }
}
