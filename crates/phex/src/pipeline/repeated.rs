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
    let others = References {
        beyond,
        elsewhere: &elsewhere,
        ..References::of_facets(Some(facets))
    };
    let judge = Judge::new(&run.target, others, options.limits());
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

/// The mesh with edges made equal; panels that are not valid or too many are left as they are,
/// which is said.
pub(super) fn made_equal(
    task: &RepetitionTask<'_>,
    mesh: &HexMesh,
    progress: &dyn Progress,
) -> Result<HexMesh, PipelineError> {
    let most = RepetitionTask::MOST_PANELS;
    let hindrance = if mesh.topology().n_faces() > most {
        format!("more than {most} panels would move at once")
    } else if (task.merit)(mesh).invalid > 0.0 {
        "panels are not valid".to_owned()
    } else {
        return Ok(task.repeated(mesh.clone(), progress)?);
    };
    let message = format!("edges are not made equal: {hindrance}");
    progress.report(&Event::Note { message });
    Ok(mesh.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::tests::fixtures::{Shape, brick_wall};
    use phex_mesh::Vec3;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Notes(Mutex<Vec<String>>);

    impl Progress for Notes {
        fn report(&self, event: &Event) {
            if let Event::Note { message } = event {
                self.0.lock().unwrap().push(message.clone());
            }
        }
    }

    #[test]
    fn more_panels_than_can_move_at_once_are_told_before_anything_is_measured() {
        let corners = vec![Vec3::zeros(), Vec3::x(), Vec3::y()];
        let surface = TriangleSurface::new(corners, &[[0, 1, 2]]).unwrap();
        let options = MeshOptions::default();
        let judge = Judge::new(&surface, References::default(), options.limits());
        let target = SurfaceTarget::new(&surface);
        let site = Site {
            judge: &judge,
            close_to: &target,
            hold: None,
            mirrors: &[],
            areas: None,
            options: &options.optimise,
        };
        let task = RepetitionTask {
            site: &site,
            merit: &|_| panic!("it is judged"),
            target: &target,
            quotient: &Quotient::default(),
            steering: &options.steering,
            tolerance: 0.1,
        };
        let many = brick_wall(Shape::Square, 210, 100);
        assert!(many.topology().n_faces() > RepetitionTask::MOST_PANELS);
        let notes = Notes::default();
        let mesh = made_equal(&task, &many, &notes).unwrap();
        assert_eq!(mesh.positions, many.positions);
        let said = notes.0.into_inner().unwrap();
        assert!(said[..] == ["edges are not made equal: more than 8000 panels would move at once"]);
    }
}
