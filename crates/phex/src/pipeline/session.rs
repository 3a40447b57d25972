//! A surface kept between runs: what a change of options does not touch is not computed again.

use super::domain::Ground;
use super::options::{MeshOptions, Method};
use super::preview::{LatticePreview, lay_out};
use super::symmetric;
use super::watched::InModel;
use super::{Clock, MeshRun, PipelineError};
use super::{classical, normalise, portfolio, repeated, size, steered};
use crate::optimise::OptimiseError;
use crate::progress::{Event, Progress};
use crate::smooth_surface::{Normalised, TargetOptions};
use crate::symmetry::{Orbits, Symmetry};
use crate::trim::Boundary;
use phex_mesh::TriangleSurface;
use std::sync::{Mutex, OnceLock, PoisonError};

/// A connected surface with what earlier runs on it have computed: its smooth target, the strip
/// beyond its boundary, and curvature. Runs give the same bytes as [`mesh_surface`] on a surface
/// that is new.
///
/// [`mesh_surface`]: super::mesh_surface
///
/// ```
/// # use phex_mesh::shapes::{Shape, TriangulationOptions, triangulate};
/// # let torus = triangulate(&Shape::from_name("torus", &[])?, &TriangulationOptions::default())?;
/// use phex::{MeshOptions, PanelSize, Session, Silent};
///
/// let session = Session::new(torus);
/// let mut options = MeshOptions { size: PanelSize::Panels(60), ..Default::default() };
/// for degrees in [10.0_f64, 0.0] {
///     options.directions.rotate = degrees.to_radians();
///     let preview = session.lay_out(&options, &Silent)?;
///     assert!(preview.mesh.topology().n_faces() > 50);
/// }
/// assert!(session.run(&options, &Silent)?.is_sound());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Session {
    surface: TriangleSurface,
    plain: OnceLock<Normalised>,
    raised: OnceLock<Normalised>,
    kept: Mutex<Option<(GroundKey, Ground)>>,
}

/// What a ground depends on.
#[derive(Clone, PartialEq)]
struct GroundKey {
    diagonal: f64,
    panels: usize,
    method: Method,
    boundary: Boundary,
    target: TargetOptions,
    max_deviation: Option<f64>,
    field_vertices: f64,
    cell_density: f64,
}

impl GroundKey {
    fn of((surface, panels): (&TriangleSurface, usize), options: &MeshOptions) -> Self {
        Self {
            // Raised heights make another surface.
            diagonal: surface.diagonal(),
            panels,
            method: options.method,
            boundary: options.boundary,
            target: options.target.clone(),
            max_deviation: options.optimise.max_deviation,
            field_vertices: options.field_vertices(panels),
            cell_density: options.cell_density.max(options.field_density),
        }
    }
}

impl Session {
    /// A session with a surface; nothing is computed yet.
    pub fn new(surface: TriangleSurface) -> Self {
        Self {
            surface,
            plain: OnceLock::new(),
            raised: OnceLock::new(),
            kept: Mutex::new(None),
        }
    }

    /// The surface.
    pub fn surface(&self) -> &TriangleSurface {
        &self.surface
    }

    /// Makes a planar hexagonal mesh of the surface.
    ///
    /// # Errors
    /// As [`mesh_surface`](super::mesh_surface).
    pub fn run(
        &self,
        options: &MeshOptions,
        progress: &dyn Progress,
    ) -> Result<MeshRun, PipelineError> {
        options.check()?;
        let is_closed = self.surface.topology().is_closed();
        let steering = options.steering.check_boundary(is_closed);
        steering.map_err(OptimiseError::from)?;
        let run = |panels: usize, options: &MeshOptions| self.made(panels, options, progress);
        let panels = size::wished_panels(&self.surface, options, run, progress)?;
        self.made(panels, options, progress)
    }

    /// The panels of a run before any of them is planar: the first lattice, laid out. It is a
    /// picture of where panels will be, and no result; nothing is judged.
    ///
    /// # Errors
    /// As [`mesh_surface`](super::mesh_surface), and for methods by planes.
    pub fn lay_out(
        &self,
        options: &MeshOptions,
        progress: &dyn Progress,
    ) -> Result<LatticePreview, PipelineError> {
        options.check()?;
        if !options.method.lays_out() {
            return Err(PipelineError::NoPreview);
        }
        let panels = size::panel_count(&self.surface, options.size)?;
        let model = self.model(options);
        let options = normalise::normalised(options, model)?;
        let mut clock = Clock::new(progress);
        let surface = &model.surface;
        let ground = clock.stage("target", || self.ground((surface, panels), &options))?;
        match lay_out(&ground, &mut clock) {
            Ok(preview) => Ok(preview.restored(&model.affinity)),
            Err(error) => Err(error.in_model(model)),
        }
    }

    fn made(
        &self,
        panels: usize,
        given: &MeshOptions,
        progress: &dyn Progress,
    ) -> Result<MeshRun, PipelineError> {
        self.made_in(self.model(given), panels, given, progress)
    }

    /// Goes to normalised coordinates, which all methods work in, and back.
    fn made_in(
        &self,
        model: &Normalised,
        panels: usize,
        given: &MeshOptions,
        progress: &dyn Progress,
    ) -> Result<MeshRun, PipelineError> {
        let options = normalise::normalised(given, model)?;
        let in_model = &InModel {
            progress,
            affinity: &model.affinity,
        };
        let surface = &model.surface;
        let mut clock = Clock::new(in_model);
        let made = self.panelled(model, panels, &options, &mut clock);
        let held = made.and_then(|run| steered::steered(run, surface, &options, &mut clock));
        let equal = held.and_then(|run| repeated::repeated(run, surface, &options, &mut clock));
        let run = equal.map_err(|error| error.in_model(model))?;
        let kept = |o: &Orbits| o.are_kept(&model.affinity);
        if !run.orbits.as_ref().is_none_or(kept) {
            // Images would bend where heights are lowered.
            return self.made_in(self.plain(), panels, given, progress);
        }
        Ok(MeshRun {
            stages: clock.stages,
            ..run.restored(model, &given.steering)
        })
    }

    /// Panels by the method of the options, normalised.
    fn panelled(
        &self,
        model: &Normalised,
        panels: usize,
        options: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<MeshRun, PipelineError> {
        if !options.method.lays_out() {
            return classical::mesh_with_panels(model, panels, options, clock);
        }
        if options.symmetry != Symmetry::None {
            let made = symmetric::mesh_with_panels(&model.surface, panels, options, clock)?;
            if let Some(run) = made {
                // What other attempts took is not told.
                clock.stages.clone_from(&run.stages);
                return Ok(run);
            }
        }
        let ground = clock.stage("target", || self.ground((&model.surface, panels), options))?;
        let unused = clock.stage("symmetry", || symmetric::unused(&ground))?;
        let notes = ground.calmed().map(teeth_note).into_iter().chain(unused);
        notes.for_each(|message| clock.progress.report(&Event::Note { message }));
        portfolio::mesh_with_panels(&ground, options, clock)
    }

    /// The surface in the coordinates that these options work in.
    fn model(&self, options: &MeshOptions) -> &Normalised {
        let raised = || {
            self.raised
                .get_or_init(|| Normalised::raised(&self.surface))
        };
        let raised = normalise::may_raise(options).then(raised);
        // Symmetries are kept to the last bit where heights are those of a coordinate.
        let keeps = |m: &&Normalised| {
            options.symmetry == Symmetry::None || m.affinity.axis.iter().any(|x| x.abs() == 1.0)
        };
        raised.filter(keeps).unwrap_or_else(|| self.plain())
    }

    /// The surface in coordinates with heights as they are.
    fn plain(&self) -> &Normalised {
        self.plain.get_or_init(|| Normalised::of(&self.surface))
    }

    /// What panels are laid out on: that of the last run where it is the same.
    fn ground(
        &self,
        (surface, panels): (&TriangleSurface, usize),
        options: &MeshOptions,
    ) -> Ground {
        let key = GroundKey::of((surface, panels), options);
        // A run that panicked has put nothing half-done here.
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, ground)) = kept.as_ref().filter(|(last, _)| *last == key) {
            return ground.with_options(options);
        }
        let ground = Ground::new(surface, panels, options);
        *kept = Some((key, ground.clone()));
        ground
    }
}

/// What is told of a boundary with teeth that stand out so far, over the diagonal.
fn teeth_note(moved: f64) -> String {
    let share = 100.0 * moved;
    format!(
        "the boundary has teeth, and panels follow a calmer line, up to {share:.2} % of the diagonal off it; the check `boundary` compares with that line"
    )
}
