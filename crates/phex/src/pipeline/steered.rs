//! Steering after the layout, and warm starts: a mesh that exists is brought to the smooth surface
//! again, with vertices held.
//!
//! Held vertices refer to the mesh as it is delivered, so they come last, after the boundary is
//! trimmed. Vertices that are on the boundary then stay on it, where neither
//! the user nor planarity wants them elsewhere, and the ground lets go of those that it would take
//! with their panels out of the limits.

use super::domain::Beyond;
use super::{Clock, MeshOptions, MeshRun, PipelineError, Statistics};
use super::{normalise, repeated, rim};
use crate::optimise::{self, Optimised, SurfaceTarget, led_elsewhere};
use crate::progress::Progress;
use crate::quality::{Judge, References};
use crate::smooth_surface::{self, Normalised, TargetKind};
use phex_mesh::{FaceId, HexMesh, TriangleSurface, VertexId};
use std::collections::BTreeSet;

/// Rounds in which vertices are let go of the ground at the most.
const ROUNDS: usize = 4;

/// Holds the vertices that the options say, in a finished run; `facets` is the surface as it was
/// given.
pub(super) fn steered(
    mut run: MeshRun,
    facets: &TriangleSurface,
    options: &MeshOptions,
    clock: &mut Clock<'_>,
) -> Result<MeshRun, PipelineError> {
    let progress = clock.progress;
    if options.steering.is_empty() || progress.is_cancelled() {
        return Ok(run);
    }
    let held = clock.timed("optimise", || held_within(&run, facets, options, progress))?;
    let (meshes, settings) = ((&run.mesh, &held.mesh), &options.optimise);
    optimise::tell_loose(meshes, &options.steering, settings, progress)?;
    run.statistics.add(held.run);
    (run.mesh, run.outcome) = (held.mesh, held.outcome);
    Ok(run)
}

/// The mesh with vertices held, without those that the ground would take with their panels out of
/// limits that were kept before: first all panels give way, then those near what is held, with
/// fewer vertices in the ground from round to round, and none at last.
fn held_within(
    run: &MeshRun,
    facets: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Optimised, PipelineError> {
    let elsewhere = led_elsewhere(&options.steering, &run.mesh);
    let others = References {
        beyond: run.beyond.as_ref().map(Beyond::surfaces),
        elsewhere: &elsewhere,
        ..References::of_facets(Some(facets))
    };
    let judge = Judge::new(&run.target, others, options.limits());
    let any_area = vec![0.0; run.mesh.topology().n_faces()];
    let outside = |mesh: &HexMesh| {
        let judged = judge.whole(mesh, &any_area).of_face;
        judged.map(|found| found.invalid + found.outside())
    };
    let before = outside(&run.mesh);
    let mut loose = BTreeSet::new();
    for round in 0..=ROUNDS {
        let what = (options, &loose, round > 0);
        let held = rim::steered(&run.mesh, &run.target, what, progress)?;
        let after = outside(&held.mesh);
        let harmed = after.enumerate().filter(|(f, found)| **found > before[*f]);
        let harmed: BTreeSet<FaceId> = harmed.map(|(f, _)| f).collect();
        let near = match round {
            ROUNDS => run.mesh.topology().faces().collect(),
            _ => harmed.clone(),
        };
        let let_go = &mut |faces| {
            optimise::let_go_of_ground(&options.steering, &run.mesh, faces, &mut loose)
        };
        if harmed.is_empty() || progress.is_cancelled() || !let_go(&near) {
            return Ok(held);
        }
    }
    rim::steered(&run.mesh, &run.target, (options, &loose, true), progress)
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
