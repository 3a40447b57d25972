//! Steering after the layout, and warm starts: a mesh that exists is brought to the smooth surface
//! again, with vertices held.
//!
//! Held vertices refer to the mesh as it is delivered, so they come last, after the boundary is
//! trimmed. Vertices that are on the boundary then stay on it, where neither
//! the user nor planarity wants them elsewhere.

use super::{Clock, MeshOptions, MeshRun, PipelineError, Statistics};
use super::{normalise, repeated, rim};
use crate::optimise::{self, SurfaceTarget};
use crate::progress::Progress;
use crate::smooth_surface::{self, Normalised, TargetKind};
use phex_mesh::{HexMesh, TriangleSurface, VertexId};

/// Holds the vertices that the options say, in a finished run.
pub(super) fn steered(
    mut run: MeshRun,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let progress = clock.progress;
    if options.steering.is_empty() || progress.is_cancelled() {
        return Ok(run);
    }
    let held = clock.timed("optimise", || {
        rim::steered(&run.mesh, &run.target, options, progress)
    })?;
    run.statistics.add(held.run);
    (run.mesh, run.outcome) = (held.mesh, held.outcome);
    Ok(run)
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
    let mut statistics = Statistics::of(&smooth, panels);
    statistics.add(refitted.run);
    let run = MeshRun {
        start: Some(start.to_soup()),
        ..MeshRun::new(
            refitted.mesh,
            close_to.clone(),
            refitted.outcome,
            statistics,
        )
    };
    let run = repeated::repeated(run, &model.surface, &normalised, &mut clock)?;
    let mut run = run.restored(&model, &options.steering);
    for &v in &options.steering.fixed_vertices {
        let v = VertexId::new(v);
        run.mesh.positions[v] = earlier.positions[v];
    }
    run.stages = clock.stages;
    Ok(run)
}
