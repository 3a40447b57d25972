//! Optimise: planar, simple panels close to the surface.
//!
//! The unknowns are the vertices alone; the plane of a face is the best one (total least squares)
//! of its corners. Minimised is
//!
//! ```text
//! E = w_p/2 sum h^2                      planarity, a penalty that rises: 1, 30, 1e3, 1e4
//!   + w_c/2 sum |x - p(x)|^2             closeness of vertices, w_cf of face centres, w_bd of the rim to the boundary curve
//!   + w_s/4 sum |T (a / s - s b)|^2      fairness: edges `a`, `b` of neighbours alike,
//!   + w_s/2 sum |x_a + x_(a+m) - M|^2    and central symmetry of each panel
//!   + w_a/2 sum (a - A)^2 / a            evenness: areas of panels
//!   - w_b sum (z - 1)^2 ln z             barrier of all distances between a vertex and an edge of the same face
//!   + w_e/2 sum (l - L)^2                 lengths of edges, where some are to be equal
//!   + sum e(c)                            limits of panels, edges and corners, inequalities with slack
//!   + w_t/2 sum |x - x_0|^2              anchor, w_k at the corners of the boundary
//! ```
//!
//! along the **feasible path**: damped Gauss-Newton steps that end before the first collision
//! within a face and never leave the region where every panel is simple. A projection of minimum
//! norm onto the exact constraints `Q^T h = 0`, guarded in the same way, then takes planarity to
//! the floor of rounding.
//!
//! | symbol | here | meaning |
//! |---|---|---|
//! | `h_i`, `n` | `panels::Corner::height`, `FacePlane::normal` | height over, normal of the best plane of a face |
//! | `P`, `Q` | `constraints::planarity::projector`, `constraints::planarity::ConstraintBases` | projector onto the complement of `[1 xi eta]`, its basis |
//! | `z = d / d_hat`, `w_b`, `tau` | `terms::barrier`, [`OptimiseOptions::barrier`], [`OptimiseOptions::barrier_reach`] | distance over reach, weight, reach over the root of the area |
//! | `w_p` | `options::PENALTIES` | weight of planarity |
//! | `w_c`, `w_cf`, `w_bd` | [`OptimiseOptions::vertex_closeness`], [`OptimiseOptions::centre_closeness`], [`OptimiseOptions::boundary_closeness`] | closeness |
//! | `w_s`, `w_t`, `w_k` | [`OptimiseOptions::fairness`], [`OptimiseOptions::anchor`], [`OptimiseOptions::corner_closeness`] | fairness, anchors |
//! | `c` | `terms::shape_limits`, [`OptimiseOptions::panels`] | what a limit leaves |
//! | `w_a`, `a` | [`OptimiseOptions::evenness`], [`crate::layout::PanelWish`] | weight of areas, the area that a panel is to have; its shape is bounded by a `c` of less weight |
//!
//! [`planarize`] tries the **fast path** (`solver/fast.rs`) before it, where the planes of the
//! panels meet in points that make them nearly planar, as on conjugate meshes: the same closeness
//! under exact planarity, one factorisation of a matrix half the size. Its result is taken only if
//! it has converged, is valid and within limits; [`RunSummary::path`] tells which path it was.
//!
//! At the end of the feasible path Newton's method goes on **on the constraints**, with exact
//! second derivatives (`solver/endgame.rs`): a few iterations by default, which bring most of the
//! room that tight panels can have, or as many as it takes to the minimum, where steps fall to
//! rounding ([`OptimiseOptions::newton_iterations`]; figures in `docs/optimiser.md`).
//!
//! Meshes of more than 8,000 faces go the feasible path part by part (`solver/parts.rs`). In a mesh
//! that is laid out the search tries panels again that lack something, each with what is around it
//! and with more weight on that (`solver/emphasis.rs`).
//!
//! Sources: the penalty of Wang and Liu, "A note on planar hexagonal meshes" (2010), section 3,
//! with the plane eliminated; the feasible path and its barrier after Li et al., "Incremental
//! potential contact" (2020), within each face's plane. Differences: no auxiliary planes or
//! tetrahedra; likeness of panels instead of neighbour averaging; exact projection at the end; face
//! centres count; the damping follows the collision step (`phex_numeric::damped`).
//!
//! *Guaranteed*: a panel that is simple at the start of a phase is simple ever after, so with a
//! certified start a cancelled run has simple panels too. The projection besides keeps panels on
//! their side of the surface, fans that go round once, edges that do not fold, and a clearance,
//! each where it finds them so. The same input gives the same bytes for any number of threads. A
//! panel that starts out crossed is left without barrier until it comes right.
//!
//! *Fails*: where the layout gives no simple start, where it folds (thin sheets, sharp creases:
//! fans and folds are not prevented while the penalty rises), and in wrong local basins (a panel
//! squeezed between its neighbours; a stronger barrier and higher penalties are then tried).
//! Nothing is then claimed: [`Optimised::offenders`] names the panels.

mod angle;
mod constraints;
mod error;
mod holds;
mod images;
mod inspect;
mod local;
mod options;
mod panels;
mod quotient;
mod run;
mod simple;
mod solver;
mod steering;
mod targets;
mod terms;

#[cfg(test)]
pub(crate) mod tests;

use crate::layout::{Layout, VertexKind};
use crate::progress::{Event, Progress};
use holds::{Hold, Holds};
use panels::{FaceShapes, Panels, points, unknowns};
use phex_mesh::{
    BoundaryCurve, BoundaryPoint, FaceId, HexMesh, PerFace, PerVertex, Topology, Vec3,
};
use phex_numeric::{Outcome, Status};
use serde::Serialize;
use solver::reached::Run;
use solver::solvers::Solvers;
use solver::start::Smoothing;
use std::collections::{BTreeMap, BTreeSet};
use steering::{grounded, on_boundary, wishes};
use targets::reference::Reference;
use terms::areas::{self, AreaWish};
use terms::guard::Guard;

pub use angle::{AngleOptimised, AngleOptions, satisfy_angle_condition};
pub use error::{OptimiseError, SteeringError};
pub(crate) use holds::{PUT_THERE, in_plane};
pub use inspect::{Fault, Offender, OptimisedFigures};
pub(crate) use local::LocalPart;
pub use options::{Dials, OptimiseOptions, PathKind, START_CLOSENESS, Solver, StartKind};
pub(crate) use panels::Image;
pub(crate) use quotient::Quotient;
pub(crate) use solver::emphasis::EMPHASES;
pub(crate) use steering::lengthened::{KeptVertices, LengthStage};
pub use steering::on_boundary::BoundaryHold;
pub(crate) use steering::on_boundary::{onto_boundary, steer_on_boundary};
pub(crate) use steering::wishes::let_go_of_ground;
pub use steering::wishes::{Anchor, GroundPlane, Steering, led_elsewhere};
pub use targets::surface_target::SurfaceTarget;
pub(crate) use terms::angle_term::walks::{free_edges, middle_vertex};
pub(crate) use terms::shape_limits::{FaceLimits, ShapeWish};

/// Foot point on a target surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Closest point.
    pub position: Vec3,
    /// Unit normal there.
    pub normal: Vec3,
}

/// The surface that panels are kept close to: a smooth triangulation, the original facets, or an
/// analytic shape.
pub trait Target: Sync {
    /// Closest points, in the order of `points`. `near` is empty, or holds a point of the target
    /// for each that is probably near it (the foot points found last); it may speed up the search
    /// and never changes the result.
    fn closest_points(&self, points: &[Vec3], near: &[TargetPoint]) -> Vec<TargetPoint>;
    /// Closest points on the boundary curves, or `None` for a closed surface.
    fn closest_on_boundary(&self, points: &[Vec3]) -> Option<Vec<BoundaryPoint>>;
}

/// How the run from one start went.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunSummary {
    /// The start.
    pub start: StartKind,
    /// The path taken.
    pub path: PathKind,
    /// Panels of the start that were not simple or not on their side.
    pub start_faults: usize,
    /// How it ended.
    pub status: Status,
    /// Iterations, projection included.
    pub iterations: usize,
    /// Factorisations of the whole mesh's matrices.
    pub factorisations: usize,
    /// Factorisations for parts of the mesh alone: large meshes are optimised part by part, tight
    /// panels with what is around them.
    pub part_factorisations: usize,
    /// Number of offenders.
    pub offenders: usize,
    /// Figures of the result.
    pub quality: OptimisedFigures,
}

/// What the optimiser made.
#[derive(Clone, Debug)]
pub struct Optimised {
    /// The mesh; panels that are not as they should be are listed in
    /// [`offenders`](Self::offenders).
    pub mesh: HexMesh,
    /// How the run ended. `Converged` means planar to the tolerance; offenders may remain.
    pub outcome: Outcome,
    /// The start.
    pub start: StartKind,
    /// How the run went that made it.
    pub run: RunSummary,
    /// Panels that are not as they should be, in the order of the faces; a panel may stand here
    /// more than once.
    pub offenders: Vec<Offender>,
    /// Figures of the mesh.
    pub quality: OptimisedFigures,
}

impl Optimised {
    /// Whether the mesh is planar and nothing is wrong with any panel.
    pub fn is_sound(&self) -> bool {
        self.offenders.is_empty()
    }
}

/// Makes the panels of a layout planar, simple and close to `target`.
///
/// # Errors
/// If the layout or an option can't be used; what can't be *reached* is told by [`Optimised`].
pub fn optimise(
    layout: &Layout,
    target: &dyn Target,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    optimise_quotient(layout, &Quotient::default(), target, options, progress)
}

/// As [`optimise`], for the part of a symmetric panelling that generates it.
///
/// # Errors
/// As [`optimise`].
pub(crate) fn optimise_quotient(
    layout: &Layout,
    quotient: &Quotient,
    target: &dyn Target,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    options.check()?;
    check_mesh(&layout.mesh)?;
    check_layout(layout)?;
    let reference = Reference::Surface(target);
    let side = Some(layout.face_normal.as_slice().to_vec());
    let mut stage = Stage::new(&layout.mesh, reference, side, &layout.vertex_kind, options);
    stage.divide(quotient);
    let cancelled = || progress.is_cancelled();
    let mut cells = stage.smoothing(layout, target, options).of_cells(cancelled);
    if !quotient.images.is_empty() {
        stage.holds.retract(&mut cells.x);
        cells = stage.start_at(&cells.x);
    }
    stage.areas = areas::of_layout(layout, &stage.panels, &cells.x, options.evenness);
    stage.limits = FaceLimits::of(&stage.panels, &cells.x, options).with_shapes(layout);
    let mut solvers = Solvers::new(&stage.panels)?;
    let kind = StartKind::SmoothedCells;
    let run = stage.run(&mut solvers, kind, &cells, options, progress)?;
    Ok(finished(&layout.mesh, run))
}

/// Makes the faces of any polygon mesh planar and simple, close to `target` or, without one, to
/// where they are.
///
/// A mesh that is planar and sound is returned unchanged; one that is nearly planar is only
/// projected.
///
/// ```
/// # use phex_mesh::Vec3;
/// # let corner = |k: u32| Vec3::new((k % 3) as f64, (k / 3) as f64, 0.0);
/// # let faces = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];
/// use phex::Silent;
/// use phex::optimise::{OptimiseOptions, planarize};
/// use phex_mesh::{HexMesh, VertexId, measure};
///
/// // Four quads in a plane, with one corner off it.
/// let mut quads = HexMesh::new((0..9).map(corner).collect(), &faces)?;
/// quads.positions[VertexId::new(8)].z = 0.1;
/// let made = planarize(&quads, None, &OptimiseOptions::default(), &Silent)?;
/// assert!(made.is_sound() && measure(&made.mesh).planarity.max < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the mesh or an option can't be used.
pub fn planarize(
    mesh: &HexMesh,
    target: Option<&dyn Target>,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    steer(mesh, target, &Steering::default(), options, progress)
}

/// Brings an earlier result to a target again, along the whole path even if it is planar: a warm
/// start, as after a change of weights, of what is held, or of the surface.
///
/// # Errors
/// As [`steer`].
pub fn refit(
    mesh: &HexMesh,
    target: Option<&dyn Target>,
    steering: &Steering,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    let what = (steering, None, &Default::default());
    let made = from_mesh(mesh, target, what, options, progress, false)?;
    tell_loose((mesh, &made.mesh), steering, options, progress)?;
    Ok(made)
}

/// As [`planarize`], with vertices held where the user wants them: fixed ones to the last bit,
/// those in a plane or on a curve to rounding.
///
/// # Errors
/// If the mesh or an option can't be used, or the mesh can't be held like that; the message names
/// vertex or face.
pub fn steer(
    mesh: &HexMesh,
    target: Option<&dyn Target>,
    steering: &Steering,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    let what = (steering, None, &BTreeSet::new());
    let made = steer_with(mesh, target, what, options, progress)?;
    tell_loose((mesh, &made.mesh), steering, options, progress)?;
    Ok(made)
}

/// Vertices that stay on the boundary, unless the user holds them, and the curves that it is; and
/// whether panels far from what the user holds are to rest.
type HeldRim<'a> = Option<(&'a BTreeMap<u32, Hold>, &'a BoundaryCurve, bool)>;

fn steer_with(
    mesh: &HexMesh,
    target: Option<&dyn Target>,
    (steering, rim, loose): (&Steering, HeldRim<'_>, &BTreeSet<u32>),
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    let only_project = steering.anchors.is_empty();
    let mut loose = [loose.clone(), BTreeSet::new()];
    let mut rounds = 0;
    loop {
        let what = (steering, rim, &loose);
        let result = from_mesh(mesh, target, what, options, progress, only_project);
        let faces: Vec<FaceId> = match &result {
            Ok(made) => made.offenders.iter().map(|o| o.face).collect(),
            Err(OptimiseError::Steering(SteeringError::Crossed { face })) => vec![*face],
            Err(_) => return result,
        };
        let leads = !(steering.curves.is_empty() && steering.grounds.is_empty());
        let idle = faces.is_empty() || !leads;
        if idle || rounds == LETTING_GO || progress.is_cancelled() {
            return result;
        }
        let holds = wishes::resolve(steering, mesh, options.max_deviation)?;
        if !wishes::let_go(&holds, mesh, &faces, &mut loose[1]) {
            return result;
        }
        rounds += 1;
    }
}

/// Says which vertices the user's curves and planes do not hold.
///
/// # Errors
/// If the mesh can't be held like that.
pub(crate) fn tell_loose(
    (before, after): (&HexMesh, &HexMesh),
    steering: &Steering,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<(), OptimiseError> {
    let holds = wishes::resolve(steering, before, options.max_deviation)?;
    let notes = [
        wishes::told_loose(&holds, after),
        wishes::told_beyond(steering, before, options.max_deviation),
    ];
    for message in notes.into_iter().flatten() {
        progress.report(&Event::Note { message });
    }
    Ok(())
}

/// Rounds in which vertices are let go of curves and planes at the most.
const LETTING_GO: usize = 4;

/// Vertices that are let go are `off` the user's curves and planes alone, or `loose` of the
/// boundary as well; `only_project`: a mesh that is nearly planar is not optimised otherwise.
fn from_mesh(
    mesh: &HexMesh,
    target: Option<&dyn Target>,
    (steering, rim, [off, loose]): (&Steering, HeldRim<'_>, &[BTreeSet<u32>; 2]),
    options: &OptimiseOptions,
    progress: &dyn Progress,
    only_project: bool,
) -> Result<Optimised, OptimiseError> {
    options.check()?;
    check_mesh(mesh)?;
    let mut options = options.clone();
    if target.is_none() {
        options.anchor = options.anchor.max(options::START_CLOSENESS);
    }
    let options = &options;
    let x = unknowns(mesh);
    let mut stage = Stage::of_mesh(mesh, target, options);
    if target.is_some() {
        stage.keep_areas(&x, options);
    }
    stage.limits = FaceLimits::of(&stage.panels, &x, options);
    stage.holds = wishes::resolve(steering, mesh, options.max_deviation)?;
    stage.holds.release(off);
    if let Some((held, curves, _)) = rim {
        grounded::keep_rim(&mut stage.holds, mesh, held, curves);
    }
    stage.holds.release(loose);
    let x = wishes::put_in_place(&stage.holds, &stage.panels, mesh)?;
    let resting = rim.filter(|(.., rests)| *rests && only_project);
    if let Some((_, curves, _)) = resting
        && let Some(run) = on_boundary::nearby(&stage, mesh, &x, curves, options, progress)?
    {
        return Ok(finished(mesh, run));
    }
    let mut solvers = Solvers::new(&stage.panels)?;
    let run = match only_project {
        true => stage.run_as_given(&mut solvers, &x, options, progress)?,
        false => stage.run_from(&mut solvers, &x, options, progress)?,
    };
    if let Some(message) = wishes::blame(&stage.holds, &stage.panels, &run.offenders) {
        progress.report(&Event::Note { message });
    }
    Ok(finished(mesh, run))
}

/// What all runs on one mesh share.
struct Stage<'a> {
    topology: &'a Topology,
    panels: Panels,
    guard: Guard,
    reference: Reference<'a>,
    rim: Vec<u32>,
    corner: Vec<bool>,
    holds: Holds,
    /// Areas that faces are to have; any at first.
    areas: Vec<AreaWish>,
    /// What faces are to have; anything at first.
    limits: FaceLimits,
    diagonal: f64,
}

impl<'a> Stage<'a> {
    /// That of a mesh without a layout: faces are on their side of the surface, and it is kept
    /// close to itself if there is no surface.
    fn of_mesh(
        mesh: &'a HexMesh,
        target: Option<&'a dyn Target>,
        options: &OptimiseOptions,
    ) -> Self {
        let (x, panels) = (unknowns(mesh), Panels::new(mesh.topology()));
        let shape = FaceShapes::at(&panels, &x);
        let side = (0..panels.n_faces()).map(|f| shape.normal(f)).collect();
        let reference = target.map_or_else(|| Reference::start(&panels, &x), Reference::Surface);
        Self::new(
            mesh,
            reference,
            Some(side),
            &VertexKind::of_mesh(mesh),
            options,
        )
    }

    fn new(
        mesh: &'a HexMesh,
        reference: Reference<'a>,
        side: Option<Vec<Vec3>>,
        kinds: &PerVertex<VertexKind>,
        options: &OptimiseOptions,
    ) -> Self {
        let rim = kinds
            .enumerate()
            .filter(|(_, k)| **k == VertexKind::Boundary);
        Self {
            topology: mesh.topology(),
            panels: Panels::new(mesh.topology()),
            guard: Guard::new(mesh.topology(), side, options.least_side),
            reference,
            rim: rim.map(|(v, _)| v.index() as u32).collect(),
            corner: kinds
                .iter()
                .map(|k| *k == VertexKind::BoundaryCorner)
                .collect(),
            holds: Holds::default(),
            areas: areas::any(mesh.topology().n_faces()),
            limits: FaceLimits::none(mesh.topology().n_faces()),
            diagonal: mesh.diagonal(),
        }
    }
}

impl Stage<'_> {
    /// From now on symmetry holds what it holds.
    fn divide(&mut self, quotient: &Quotient) {
        self.holds = quotient.holds();
        self.panels = self.panels.clone().with_images(&quotient.images);
    }

    /// From now on faces keep the areas that they have at `x`.
    fn keep_areas(&mut self, x: &[f64], options: &OptimiseOptions) {
        self.areas = areas::as_they_are(self.topology, &self.panels, x, options.evenness);
    }

    fn smoothing<'b>(
        &'b self,
        layout: &'b Layout,
        target: &'b dyn Target,
        options: &OptimiseOptions,
    ) -> Smoothing<'b> {
        Smoothing {
            layout,
            target,
            panels: &self.panels,
            guard: &self.guard,
            steps: options.smoothing,
        }
    }
}

/// A mesh at other positions.
fn mesh_at(mesh: &HexMesh, x: &[f64]) -> HexMesh {
    mesh.with_positions(PerVertex::from_vec(points(x)))
}

/// What a run has reached, as a mesh.
fn finished(mesh: &HexMesh, run: Run) -> Optimised {
    Optimised {
        mesh: mesh_at(mesh, &run.x),
        outcome: run.outcome,
        start: run.summary.start,
        quality: run.summary.quality,
        run: run.summary,
        offenders: run.offenders,
    }
}

fn check_mesh(mesh: &HexMesh) -> Result<(), OptimiseError> {
    let broken = |p: &&Vec3| !p.iter().all(|c| c.is_finite());
    if let Some((vertex, _)) = mesh.positions.enumerate().find(|(_, p)| broken(p)) {
        return Err(OptimiseError::NotFinite { vertex });
    }
    if mesh.diagonal() > 0.0 {
        Ok(())
    } else {
        Err(OptimiseError::NoExtent)
    }
}

fn check_layout(layout: &Layout) -> Result<(), OptimiseError> {
    let topology = layout.mesh.topology();
    let (v, f) = (topology.n_vertices(), topology.n_faces());
    let counts = [
        ("vertex kinds", layout.vertex_kind.len(), v),
        ("face points", layout.face_point.len(), f),
        ("face normals", layout.face_normal.len(), f),
        ("face lengths", layout.face_length.len(), f),
    ];
    for (what, found, expected) in counts {
        if found != expected {
            return Err(OptimiseError::WrongCount {
                what,
                found,
                expected,
            });
        }
    }
    let unit = |n: &Vec3| (n.norm() - 1.0).abs() < 1e-6;
    let normals: &PerFace<Vec3> = &layout.face_normal;
    match normals.enumerate().find(|(_, n)| !unit(n)) {
        Some((face, _)) => Err(OptimiseError::BadNormal { face }),
        None => Ok(()),
    }
}
