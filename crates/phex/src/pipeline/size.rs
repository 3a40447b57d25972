//! How many panels a size means.

use super::options::{Effort, MeshOptions, PanelSize};
use super::{MeshRun, PipelineError};
use crate::layout::MAX_PANELS;
use crate::optimise::Steering;
use crate::progress::Progress;
use phex_mesh::TriangleSurface;
use phex_mesh::polygon::HEXAGON;

/// The number of panels that the options ask for; `run` makes a mesh with as many.
pub(super) fn wished_panels(
    surface: &TriangleSurface,
    options: &MeshOptions,
    run: impl Fn(usize, &MeshOptions) -> Result<MeshRun, PipelineError>,
    progress: &dyn Progress,
) -> Result<usize, PipelineError> {
    let panels = panel_count(surface, options.size)?;
    match options.size {
        PanelSize::Panels(_) => Ok(panels),
        PanelSize::EdgeLength(wanted) => corrected_count((panels, wanted), options, run, progress),
    }
}

/// The number of panels with which their mean edge is nearest to what is wanted, of a few. Panels
/// that are long or re-entrant have longer edges than regular ones of their area: how much is known
/// when they are there. What is searched afterwards hardly changes it. Edges at the boundary do not
/// count: where it has teeth there are many short ones, and panels would grow for them.
fn corrected_count(
    (mut panels, wanted): (usize, f64),
    options: &MeshOptions,
    run: impl Fn(usize, &MeshOptions) -> Result<MeshRun, PipelineError>,
    progress: &dyn Progress,
) -> Result<usize, PipelineError> {
    let options = &MeshOptions {
        effort: Effort::Draft,
        steering: Steering::default(),
        repeat_rel: None,
        ..options.clone()
    };
    let mut best: Option<(f64, usize)> = None;
    for _ in 0..=EDGE_CORRECTIONS {
        let run = match (run(panels, options), best) {
            (Err(error), None) => return Err(error),
            (Err(_), Some(_)) => break,
            (Ok(run), _) => run,
        };
        let error = (run.mesh.mean_inner_edge() / wanted).ln();
        if best.is_none_or(|b| error.abs() < b.0) {
            best = Some((error.abs(), panels));
        }
        let count = (panels as f64 * (2.0 * error).exp()).round();
        let possible = (1.0..=MAX_PANELS as f64).contains(&count) && count != panels as f64;
        if error.abs() < EDGE_TOLERANCE || !possible || progress.is_cancelled() {
            break;
        }
        panels = count as usize;
    }
    Ok(best.map_or(panels, |b| b.1))
}

/// Relative error of the mean edge that is corrected by another run, and such runs at the most: a
/// lattice has the number of panels that is asked for up to a few per cent, so that one may miss.
const EDGE_TOLERANCE: f64 = 0.025;
const EDGE_CORRECTIONS: usize = 4;

/// Panels that a size means for a surface.
pub(super) fn panel_count(
    surface: &TriangleSurface,
    size: PanelSize,
) -> Result<usize, PipelineError> {
    let (_, components) = surface.topology().components();
    if components != 1 {
        return Err(PipelineError::Components(components));
    }
    let count = match size {
        PanelSize::Panels(n) => n as f64,
        PanelSize::EdgeLength(e) if e > 0.0 && e.is_finite() => surface.area() / (HEXAGON * e * e),
        PanelSize::EdgeLength(e) => {
            return Err(PipelineError::Size(format!(
                "the edge length must be positive and finite, not {e}"
            )));
        }
    };
    if count < 1.0 || count.is_nan() {
        return Err(PipelineError::Size(format!(
            "{count:.3} panels were asked for, at least 1 is needed"
        )));
    }
    if count > MAX_PANELS as f64 {
        return Err(PipelineError::Size(format!(
            "{count:.0} panels were asked for, more than {MAX_PANELS}"
        )));
    }
    Ok(count.round() as usize)
}
