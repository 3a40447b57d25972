//! The library's computations as jobs use them: their errors say whose fault they are, their
//! results have one form.

use crate::error::{JobError, chain};
use crate::limits::TypedLimits;
use crate::settings::MeshSettings;
use phex::classical::DualityError;
use phex::directions::Cone;
use phex::directions::NetworkError;
use phex::layout::LayoutError;
use phex::optimise::{
    self, OptimiseError, OptimiseOptions, START_CLOSENESS, Steering, SurfaceTarget, Target,
};
use phex::pipeline::{self, AttemptSummary, ClassicalStatistics, NetworkCurves, network_curves};
use phex::report::{RunReport, StageTime};
use phex::{Beyond, MeshOptions, MeshRun, PipelineError, Progress, Session};
use phex_mesh::{HexMesh, PerFace, PolygonSoup, TriangleSurface};
use phex_numeric::{Outcome, Status};
use serde::Serialize;
use serde_json::Value;
use std::time::Instant;

/// What a computation reached.
pub struct Computed {
    /// The mesh, in model coordinates; valid or not.
    pub mesh: HexMesh,
    /// Area that each panel is to have, squares of the model's unit; only the proportions count,
    /// and 0 stands for any.
    pub wished: PerFace<f64>,
    /// The panels before the optimiser, where there were any, in model coordinates.
    pub start: Option<PolygonSoup>,
    /// The smooth surface that it was fitted to, in model coordinates.
    pub smooth: Option<TriangleSurface>,
    /// The mesh before its edges were made equal, where that was asked for.
    pub unrepeated: Option<HexMesh>,
    /// The surface continued beyond its boundary, in model coordinates, if panels were kept whole.
    pub beyond: Option<Beyond>,
    /// How the computation ended.
    pub outcome: Value,
    /// Time of each stage.
    pub stages: Vec<StageTime>,
    /// What the stages counted.
    pub statistics: Value,
    /// The cones of the lattice's field, in model coordinates.
    pub cones: Vec<Cone>,
    /// What a method by planes and poles met with.
    pub classical: Option<ClassicalStatistics>,
    /// The ways of the portfolio that were tried.
    pub tried: Vec<AttemptSummary>,
}

impl Computed {
    /// Tells in a report how it came about.
    pub fn describe(&self, report: &mut RunReport) {
        report.outcome = self.outcome.clone();
        report.statistics = self.statistics.clone();
        report.stages = self.stages.clone();
    }

    /// A mesh alone, whose panels may have any area.
    fn of(mesh: HexMesh) -> Self {
        Self {
            wished: PerFace::filled(mesh.topology().n_faces(), 0.0),
            mesh,
            start: None,
            smooth: None,
            unrepeated: None,
            beyond: None,
            outcome: Value::Null,
            stages: Vec::new(),
            statistics: Value::Null,
            cones: Vec::new(),
            classical: None,
            tried: Vec::new(),
        }
    }
}

/// Covers a connected surface with panels. A run that is cancelled gives the best mesh so far.
///
/// # Errors
/// If the surface can't be used, no panelling exists, or the run is cancelled before there is a
/// mesh.
pub fn mesh(
    surface: &Session,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Computed, JobError> {
    reached(surface.run(options, progress).map_err(pipeline_failure)?)
}

/// The panels of a connected surface as they are laid out, neither planar nor checked.
///
/// # Errors
/// If the surface can't be used, no panelling exists, or the run is cancelled.
pub fn lay_out(
    surface: &Session,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Computed, JobError> {
    let preview = surface.lay_out(options, progress);
    let preview = preview.map_err(pipeline_failure)?;
    Ok(Computed {
        stages: preview.stages.iter().map(StageTime::from).collect(),
        statistics: value(&preview.statistics)?,
        cones: preview.cones,
        ..Computed::of(preview.mesh)
    })
}

/// Brings an earlier mesh to a connected surface again. A run that is cancelled gives the mesh that
/// it has come to.
///
/// # Errors
/// If the mesh can't be used or held.
pub fn refit(
    earlier: &HexMesh,
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<Computed, JobError> {
    let run = pipeline::refit_surface(earlier, surface, options, progress);
    reached(run.map_err(pipeline_failure)?)
}

fn reached(run: MeshRun) -> Result<Computed, JobError> {
    Ok(Computed {
        outcome: value(&run.outcome)?,
        stages: run.stages.iter().map(StageTime::from).collect(),
        statistics: value(&run.statistics)?,
        cones: run.statistics.cones,
        classical: run.statistics.classical,
        tried: run.statistics.tried,
        wished: run.wished,
        mesh: run.mesh,
        start: run.start,
        smooth: Some(run.target),
        unrepeated: run.unrepeated,
        beyond: run.beyond,
    })
}

/// A conjugate curve network of a connected surface.
///
/// # Errors
/// If the surface can't be used or has no network, or the user interrupts.
pub fn network(
    surface: &TriangleSurface,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<NetworkCurves, JobError> {
    network_curves(surface, options, progress).map_err(pipeline_failure)
}

/// How a mesh is made planar.
pub struct Planarization {
    /// Weights and limits.
    pub options: OptimiseOptions,
    /// What is held.
    pub steering: Steering,
    /// Whether a mesh that is planar is optimised too.
    pub refit: bool,
    /// Whether the surface consists of the mesh's own facets: then vertices are held near to where
    /// they are besides.
    pub is_own: bool,
}

impl Planarization {
    /// How settings, with what was read for them, have a mesh made planar within limits, close to
    /// a surface or to itself.
    pub fn new(
        settings: MeshSettings,
        given: Steering,
        limits: &TypedLimits,
        (mesh, surface): (&HexMesh, Option<&TriangleSurface>),
    ) -> Self {
        let typed = settings.steering;
        let (mut options, mut steering) = (settings.stages.optimise, settings.stages.steering);
        typed.apply(given, &mut steering, &mut options);
        let extent = mesh.diagonal();
        let whole = surface.map_or(extent, TriangleSurface::diagonal);
        limits.demand(&mut options, mesh.mean_edge(), extent, whole);
        Self {
            options,
            steering,
            refit: typed.has_dials(),
            is_own: surface.is_none(),
        }
    }
}

/// Makes the faces of a mesh planar, close to a surface or to where they are.
///
/// # Errors
/// If the mesh can't be used, or the user interrupts.
pub fn planarize(
    mesh: &HexMesh,
    surface: Option<&TriangleSurface>,
    how: &Planarization,
    progress: &dyn Progress,
) -> Result<Computed, JobError> {
    let start = Instant::now();
    let target = surface.map(SurfaceTarget::new);
    let target = target.as_ref().map(|t| t as &dyn Target);
    let steer = if how.refit {
        optimise::refit
    } else {
        optimise::steer
    };
    let mut options = how.options.clone();
    if how.is_own {
        options.anchor = options.anchor.max(START_CLOSENESS);
    }
    let run = steer(mesh, target, &how.steering, &options, progress);
    let run = run.map_err(|e| JobError::unusable(&e))?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(Computed {
        outcome: ended(&run.outcome)?,
        stages: vec![StageTime {
            stage: "optimise".to_owned(),
            seconds,
        }],
        statistics: value(&[&run.run])?,
        start: Some(mesh.to_soup()),
        ..Computed::of(run.mesh)
    })
}

/// Refines a mesh in space and brings it to a surface, level by level.
///
/// # Errors
/// If the mesh can't be used, or the user interrupts.
pub fn subdivide(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    levels: usize,
    progress: &dyn Progress,
) -> Result<Vec<HexMesh>, JobError> {
    let made = pipeline::subdivide(mesh, surface, levels, &OptimiseOptions::default(), progress);
    let levels = made.map_err(pipeline_failure)?;
    Ok(levels.into_iter().map(|level| level.mesh).collect())
}

/// The outcome for the report.
fn ended(outcome: &Outcome) -> Result<Value, JobError> {
    if outcome.status == Status::Cancelled {
        Err(JobError::Cancelled)
    } else {
        value(outcome)
    }
}

fn value(of: &impl Serialize) -> Result<Value, JobError> {
    serde_json::to_value(of).map_err(|e| JobError::internal("the run report", &e))
}

fn pipeline_failure(error: PipelineError) -> JobError {
    let told = chain(&error);
    match error {
        PipelineError::Cancelled => JobError::Cancelled,
        PipelineError::Size(_)
        | PipelineError::Option(_)
        | PipelineError::Components(_)
        | PipelineError::NoPreview
        | PipelineError::Snap { .. }
        | PipelineError::Symmetry { .. }
        | PipelineError::Koebe(_)
        | PipelineError::Cones(_) => JobError::Input(told),
        PipelineError::Optimise(OptimiseError::Steering(_) | OptimiseError::BadOption(_)) => {
            JobError::Input(told)
        }
        PipelineError::Layout(LayoutError::Network(NetworkError::BadAxis)) => JobError::Input(told),
        PipelineError::Layout(
            LayoutError::Domain(_) | LayoutError::Duality(DualityError::SingularQuadric),
        ) => JobError::Input(told),
        PipelineError::Layout(LayoutError::Duality(_) | LayoutError::Power(_))
        | PipelineError::Fit(_)
        | PipelineError::Trim(_) => JobError::NoResult(told),
        PipelineError::Layout(
            LayoutError::Topology { .. } | LayoutError::NotDiscs { .. } | LayoutError::Network(_),
        ) => JobError::NoResult(told),
        _ => JobError::Internal(told),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_pipeline_keep_apart_whose_fault_it_is() {
        let unusable = pipeline_failure(PipelineError::Components(2));
        assert!(matches!(unusable, JobError::Input(_)), "{unusable:?}");
        let joined = LayoutError::Topology {
            reason: String::new(),
        };
        let too_large = LayoutError::NotDiscs {
            panels: 1,
            place: phex_mesh::Vec3::zeros(),
            handles: 1,
        };
        for layout in [joined, too_large] {
            let none = pipeline_failure(layout.into());
            assert!(matches!(none, JobError::NoResult(_)), "{none:?}");
        }
        assert_eq!(
            pipeline_failure(PipelineError::Cancelled),
            JobError::Cancelled
        );
    }

    #[test]
    fn a_cancelled_run_is_no_result() {
        assert_eq!(
            ended(&Outcome::empty(Status::Cancelled)),
            Err(JobError::Cancelled)
        );
        assert!(ended(&Outcome::empty(Status::Stalled)).is_ok());
    }
}
