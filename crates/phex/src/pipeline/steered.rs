//! Steering after the layout, and warm starts: a mesh that exists is brought to the smooth surface
//! again, with vertices held.
//!
//! Held vertices refer to the mesh as it is delivered, so they come last, after the boundary is
//! trimmed. Vertices that are on the boundary then stay on it, where neither
//! the user nor planarity wants them elsewhere.

use super::{Clock, MeshOptions, MeshRun, PipelineError, Statistics};
use super::{normalise, repeated, rim};
use crate::optimise::{self, Optimised, SurfaceTarget};
use crate::progress::Progress;
use crate::smooth_surface::{self, Normalised, TargetKind};
use phex_mesh::{HexMesh, TriangleSurface, VertexId};

/// Holds the vertices that the options say, in a finished run.
pub(super) fn steered(
    run: MeshRun,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    if options.steering.is_empty() || progress.is_cancelled() {
        return Ok(run);
    }
    let mut clock = Clock::new(progress);
    clock.stages = run.stages.clone();
    let held = clock.timed("optimise", || {
        rim::steered(&run.mesh, &run.target, options, progress)
    })?;
    Ok(with_result(run, held, clock))
}

/// Brings an earlier panelling, in model coordinates, to the smooth surface through the vertices of
/// `surface`: a warm start, as after a change of weights, of the surface, or of what is held.
/// Nothing is laid out.
///
/// # Errors
/// If the mesh or an option can't be used. A mesh that did not become valid is returned, with its
/// offenders.
pub fn refit_surface(
    earlier: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    options.check()?;
    let mut clock = Clock::new(progress);
    let panels = earlier.topology().n_faces();
    let model = match normalise::may_raise(options) {
        true => Normalised::raised(surface),
        false => Normalised::of(surface),
    };
    let vertices = options.cell_vertices(panels) as usize;
    let smooth = clock.stage("target", || {
        smooth_surface::smooth_target(&model.surface, vertices, &options.target)
    })?;
    let close_to = match options.target.kind {
        TargetKind::Facets => &model.surface,
        _ => smooth.finest(),
    };
    let start = earlier.mapped(|p| model.affinity.normalise(*p));
    let normalised = normalise::normalised(options, &model)?;
    let target = SurfaceTarget::new(close_to);
    let refitted = clock.stage("optimise", || {
        let close = Some(&target as &dyn optimise::Target);
        let (steering, settings) = (&normalised.steering, &normalised.optimise);
        optimise::refit(&start, close, steering, settings, progress)
    })??;
    let (outcome, statistics) = (refitted.outcome.clone(), Statistics::of(&smooth, panels));
    let run = MeshRun {
        start: Some(start.to_soup()),
        ..MeshRun::new(start, close_to.clone(), outcome, statistics)
    };
    let run = with_result(run, refitted, clock);
    let run = repeated::repeated(run, &model.surface, &normalised, progress)?;
    let mut run = run.restored(&model, &options.steering);
    for &v in &options.steering.fixed_vertices {
        let v = VertexId::new(v);
        run.mesh.positions[v] = earlier.positions[v];
    }
    Ok(run)
}

fn with_result(mut run: MeshRun, result: Optimised, clock: Clock<'_>) -> MeshRun {
    run.statistics.add(result.run);
    run.mesh = result.mesh;
    run.outcome = result.outcome;
    run.stages = clock.stages;
    run
}
