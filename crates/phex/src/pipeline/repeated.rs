//! Edges made equal in a finished run, where that is asked for.

use super::domain::Beyond;
use super::{Clock, MeshOptions, MeshRun, PipelineError, rim};
use crate::optimise::{Quotient, SurfaceTarget, led_elsewhere};
use crate::progress::{Event, Progress};
use crate::quality::{Judge, References};
use crate::repetition::RepetitionTask;
use crate::search::Site;
use phex_mesh::{HexMesh, TriangleSurface};

/// A run with edges made equal, if the options ask for it and its panels are valid; `facets` is the
/// surface as it was given. Symmetric panels were made equal as they were made.
///
/// # Errors
/// If the mesh can't be held as the options say.
pub(super) fn repeated(
    mut run: MeshRun,
    facets: &TriangleSurface,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let progress = clock.progress;
    let Some(tolerance_rel) = options.repeat_rel else {
        return Ok(run);
    };
    if run.unrepeated.is_some() || progress.is_cancelled() {
        return Ok(run);
    }
    let beyond = run.beyond.as_ref().map(Beyond::surfaces);
    let elsewhere = led_elsewhere(&options.steering, &run.mesh);
    let references = References {
        smooth: Some(&run.target),
        facets: Some(facets),
        beyond,
        elsewhere: &elsewhere,
    };
    let judge = Judge::new(&run.target, references, options.limits());
    let close_to = &SurfaceTarget::new(beyond.map_or(&run.target, |b| b[0]));
    let site = Site {
        judge: &judge,
        close_to,
        hold: rim::held(&run.target, options),
        mirrors: &[],
        areas: None,
        options: &options.optimise,
    };
    let task = RepetitionTask {
        site: &site,
        merit: &|mesh| judge.with_cover(site.judged(mesh).merit, mesh),
        target: close_to,
        quotient: &Quotient::default(),
        steering: &options.steering,
        tolerance: tolerance_rel * facets.diagonal(),
    };
    let mesh = clock.timed("repetition", || made_equal(&task, &run.mesh, progress))?;
    run.unrepeated = Some(std::mem::replace(&mut run.mesh, mesh));
    Ok(run)
}

/// The mesh with edges made equal; panels that are not valid are left as they are, which is said.
pub(super) fn made_equal(
    task: &RepetitionTask<'_>,
    mesh: &HexMesh,
    progress: &dyn Progress,
) -> Result<HexMesh, PipelineError> {
    if (task.merit)(mesh).invalid > 0.0 {
        let message = "edges are not made equal: panels are not valid".to_owned();
        progress.report(&Event::Note { message });
        return Ok(mesh.clone());
    }
    Ok(task.repeated(mesh.clone(), progress)?)
}
