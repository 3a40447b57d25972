//! Planar panels that also satisfy the angle condition (4.1) and what odd panels and loops need to
//! close, so that the mesh has a vertex-distance offset.
//!
//! Two steps: a projection of minimum norm onto planarity, angles *and* closing equations, about `4
//! F` in all (where tight panels stop it, in the metric `W` below until it is near); then a descent
//! of closeness, fairness and barrier within them,
//!
//! ```text
//! d = -W (g + J^T y),   J W J^T y = -J W g,   W = (H + mu I)^-1, block by block,
//! ```
//!
//! each step projected back and taken only if the energy falls. Pulling towards the surface while
//! projecting would leave no freedom: closeness alone determines `2 F` of the `6 F` unknowns and
//! the constraints the other `4 F`.
//!
//! | symbol | here |
//! |---|---|
//! | `r = (t_0 - t_1 + t_2 - ...) - branch` | `AngleConstraints::angle_residual`; the branch is the nearest multiple of `2 pi` from the main one |
//! | `J` | `AngleConstraints::rows`, a vector for each corner and constraint |
//! | `g`, `H` | gradient and diagonal blocks of `PanelEnergy` |
//!
//! | `R x = x` | `Closing`: one equation for each odd panel inside, two for each loop that is no panel (`Walks`) |
//!
//! Where the first step does not get there from the mesh as it is, it begins from a start that is
//! eased towards the constraints (`continuation`), with several weights of symmetry and room.
//!
//! *Guaranteed*: as in the whole stage, simple panels stay simple. *Fails* on closed surfaces where
//! rows run along a parabolic curve whose points share their tangent plane: the Gauss image of the
//! curve is a point then, and the circles through the vertices of rows of equal panels shrink
//! towards it in a geometric sequence without passing it (a torus); and where panels can't be sound
//! besides. [`AngleOptimised::is_converged`] tells.

mod constraints;
mod continuation;
mod path;
mod tangent;

use self::constraints::angle_assembly;
use self::continuation::by_continuation;
use self::path::AnglePath;
use super::error::OptimiseError;
use super::inspect::{Offender, OptimisedFigures, inspect};
use super::options::OptimiseOptions;
use super::panels::unknowns;
use super::solver::solvers::energy_assembly;
use super::terms::angle_term::walks::Walks;
use super::terms::setting::{Setting, deviation};
use super::{Stage, Target, check_mesh, mesh_at};
use crate::progress::Progress;
use phex_mesh::validate::planarity_floor;
use phex_mesh::{HexMesh, ValidateOptions, violations};
use phex_numeric::{Outcome, Status};
use serde::{Deserialize, Serialize};

/// A way to the constraints.
struct AngleWay {
    /// From a start that is found [`by_continuation`] with these factors of fairness and barrier,
    /// or from the one that is given.
    continuation: Option<[f64; 2]>,
    /// Clearances that are then kept, over the least one of a result, one after the other: near
    /// parabolic curves some panels come through only where others may come close, and the descent
    /// opens them again.
    clearances: &'static [f64],
}

impl AngleWay {
    const fn by_continuation(fairness: f64, barrier: f64) -> Self {
        Self {
            continuation: Some([fairness, barrier]),
            // More than the least one, since it is judged by the mean edge, which grows on the way.
            clearances: &[1.2, 0.1],
        }
    }
}

/// The ways that are tried, one after the other.
const WAYS: [AngleWay; 8] = [
    AngleWay {
        continuation: None,
        clearances: &[1.0],
    },
    AngleWay::by_continuation(3.0, 1.0),
    AngleWay::by_continuation(30.0, 1.0),
    AngleWay::by_continuation(10.0, 5.0),
    AngleWay::by_continuation(10.0, 15.0),
    AngleWay::by_continuation(100.0, 5.0),
    AngleWay::by_continuation(30.0, 30.0),
    AngleWay {
        continuation: None,
        clearances: &[0.3, 0.1],
    },
];

/// The stage whose iterations are told.
const STAGE: &str = "angles";
/// Steps of the descent at the most.
const DESCENT_STEPS: usize = 30;

/// Options of [`satisfy_angle_condition`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AngleOptions {
    /// Weights of the descent, guards and limits. The penalties are not used.
    pub optimise: OptimiseOptions,
    /// Newton iterations of the projection at the most.
    pub newton_iterations: usize,
    /// Defect, in radians, that counts as none. Rounding allows about 1e-15 times the model's size
    /// over an edge.
    pub tolerance: f64,
}

impl Default for AngleOptions {
    fn default() -> Self {
        Self {
            optimise: OptimiseOptions::default(),
            newton_iterations: 60,
            tolerance: 1e-12,
        }
    }
}

/// A mesh that satisfies the angle condition, if it converged.
#[derive(Clone, Debug)]
pub struct AngleOptimised {
    /// The mesh.
    pub mesh: HexMesh,
    /// How it ended. `Converged` means planar, and angles right, to the tolerances.
    pub outcome: Outcome,
    /// Largest defect of the condition before and after, in radians.
    pub angle_defect: [f64; 2],
    /// Largest failure of reflections to close round odd faces inside and round loops, before and
    /// after, over the number of reflections.
    pub closing_defect: [f64; 2],
    /// Largest distance to the surface (or to the start) before and after, in the unit of the
    /// model.
    pub deviation: [f64; 2],
    /// Figures of the mesh.
    pub quality: OptimisedFigures,
    /// Panels that are not as they should be.
    pub offenders: Vec<Offender>,
}

impl AngleOptimised {
    /// Whether the angle condition holds and panels are planar.
    pub fn is_converged(&self) -> bool {
        self.outcome.status == Status::Converged
    }
}

/// Moves the vertices of a mesh until its faces are planar and its even ones satisfy the angle
/// condition, close to `target` or, without one, to where they are, and reflections along the edges
/// close round odd faces inside and round loops (if the mesh is in one piece). Odd faces on the
/// boundary are only made planar. A mesh that meets this is returned unchanged.
///
/// # Errors
/// If the mesh or an option can't be used; what can't be *reached* is told by the result.
pub fn satisfy_angle_condition(
    mesh: &HexMesh,
    target: Option<&dyn Target>,
    options: &AngleOptions,
    progress: &dyn Progress,
) -> Result<AngleOptimised, OptimiseError> {
    options.optimise.check()?;
    check_mesh(mesh)?;
    let start = unknowns(mesh);
    let stage = Stage::of_mesh(mesh, target, &options.optimise);
    let setting = stage.setting(&start);
    let walks = Walks::of(mesh);
    let panels = &stage.panels;
    let assemblies = [energy_assembly(panels), angle_assembly(panels, &walks)];
    let allowed = n_violations(mesh, options);
    let mut best: Option<(AngleRank, AngleOptimised)> = None;
    for way in WAYS {
        let (from, spent) = match way.continuation {
            None => (start.clone(), Outcome::empty(Status::Converged)),
            Some(factors) => by_continuation(&setting, &walks, &start, options, factors, progress)?,
        };
        for &clearance in way.clearances {
            let mut path = AnglePath::new(
                &setting,
                &assemblies,
                &walks,
                &from,
                options,
                clearance,
                progress,
            )?;
            path.outcome = spent.clone();
            let made = attempt(mesh, [&start, &from], &mut path, &setting, options);
            let wrong = n_violations(&made.mesh, options).saturating_sub(allowed);
            let rank = AngleRank::of(&made, wrong);
            let over = rank.is_sound() || progress.is_cancelled();
            if best.as_ref().is_none_or(|(old, _)| rank < *old) {
                best = Some((rank, made));
            }
            if over {
                return Ok(best.expect("there is a way").1);
            }
        }
    }
    Ok(best.expect("there is a way").1)
}

/// How far a result is from what is wanted: constraints first, then panels.
#[derive(PartialEq, PartialOrd)]
struct AngleRank {
    missed: f64,
    wrong: usize,
}

impl AngleRank {
    fn of(made: &AngleOptimised, wrong: usize) -> Self {
        let defects = [made.angle_defect[1], made.closing_defect[1]];
        // A defect that is no number is the worst: no comparison would hold for it.
        let defect = |worst: f64, d: &f64| {
            if d.is_nan() {
                f64::INFINITY
            } else {
                worst.max(*d)
            }
        };
        let missed = defects.iter().fold(0.0, defect);
        Self {
            missed: if made.is_converged() { 0.0 } else { missed },
            wrong: wrong + made.offenders.len(),
        }
    }

    fn is_sound(&self) -> bool {
        self.missed == 0.0 && self.wrong == 0
    }
}

/// What is wrong with a mesh in itself.
fn n_violations(mesh: &HexMesh, options: &AngleOptions) -> usize {
    let planarity = options.optimise.planarity_tolerance;
    let validity = ValidateOptions {
        planarity: Some(planarity.max(planarity_floor(mesh))),
        ..ValidateOptions::default()
    };
    violations(mesh, None, &validity).len()
}

/// One way: the positions that were given, and those to start from.
fn attempt(
    mesh: &HexMesh,
    [given, from]: [&[f64]; 2],
    path: &mut AnglePath<'_>,
    setting: &Setting<'_>,
    options: &AngleOptions,
) -> AngleOptimised {
    let (before, moved) = (
        path.constraints.nearest_defects(given),
        deviation(setting, given).0,
    );
    let mut x = from.to_vec();
    if !path.is_met(&x) {
        path.project(&mut x);
        if path.outcome.status == Status::Converged {
            path.descend(&mut x);
        }
    }
    let after = path.constraints.defects(&x);
    let reached = deviation(setting, &x);
    let (quality, offenders) = inspect(
        setting.panels,
        setting.guard,
        &x,
        reached,
        &options.optimise,
    );
    AngleOptimised {
        mesh: mesh_at(mesh, &x),
        outcome: path.outcome.clone(),
        angle_defect: [before[0], after[0]],
        closing_defect: [before[1], after[1]],
        deviation: [moved, reached.0],
        quality,
        offenders,
    }
}
