//! Planar panels that also satisfy the angle condition (4.1), so that the mesh has a vertex-distance offset.
//!
//! Two steps: a projection of minimum norm onto planarity *and* angles, `4 F` equations in all (where tight panels stop it, in
//! the metric `W` below until it is near); then a descent of closeness, fairness and barrier within them,
//!
//! ```text
//! d = -W (g + J^T y),   J W J^T y = -J W g,   W = (H + mu I)^-1, block by block,
//! ```
//!
//! each step projected back and taken only if the energy falls. Pulling towards the surface while projecting would leave
//! no freedom: closeness alone determines `2 F` of the `6 F` unknowns and the constraints the other `4 F`.
//!
//! | symbol | here |
//! |---|---|
//! | `r = (t_0 - t_1 + t_2 - ...) - branch` | `AngleConstraints::angle_residual`; the branch is the nearest multiple of `2 pi` from the main one |
//! | `J` | `AngleConstraints::rows`, a vector for each corner and constraint |
//! | `g`, `H` | gradient and diagonal blocks of `PanelEnergy` |
//!
//! *Guaranteed*: as in the whole stage, simple panels stay simple. *Fails* on closed surfaces and on meshes with many odd
//! panels, where there may be no such mesh near; [`AngleOptimised::is_converged`] tells.

use super::energy::{PanelEnergy, Setting, collision_bound};
use super::guard::Armed;
use super::inspect::{Offender, Quality, inspect};
use super::options::{OptimiseError, OptimiseOptions};
use super::panels::{Corner, FaceFrame, Panels, Shape, point, points, unknowns};
use super::planarity::ConstraintBases;
use super::run::{energy_assembly, panel_energy, system};
use super::{Reference, Stage, Target, check_mesh, kinds_of};
use crate::progress::{Event, Progress};
use nalgebra::Matrix3;
use phex_mesh::polygon::interior_angles;
use phex_mesh::{HexMesh, PerVertex, Vec2, Vec3};
use phex_numeric::{
    Assembly, Cholesky, Constraints, DampedProblem, MinimumNorm, Outcome, ProjectionOptions,
    Record, Status, SymmetricMatrix,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::ops::ControlFlow;

/// Options of [`satisfy_angle_condition`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AngleOptions {
    /// Weights of the descent, guards and limits. The penalties are not used.
    pub optimise: OptimiseOptions,
    /// Newton iterations of the projection at the most.
    pub newton_iterations: usize,
    /// Steps of the descent at the most; 0 leaves the mesh where the projection has put it.
    pub descent_steps: usize,
    /// Defect, in radians, that counts as none. Rounding allows about 1e-15 times the model's size over an edge.
    pub tolerance: f64,
}

impl Default for AngleOptions {
    fn default() -> Self {
        Self {
            optimise: OptimiseOptions::default(),
            newton_iterations: 30,
            descent_steps: 30,
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
    /// Largest distance to the surface (or to the start) before and after, in the unit of the model.
    pub deviation: [f64; 2],
    /// Figures of the mesh.
    pub quality: Quality,
    /// Panels that are not as they should be.
    pub offenders: Vec<Offender>,
}

impl AngleOptimised {
    /// Whether the angle condition holds and panels are planar.
    pub fn is_converged(&self) -> bool {
        self.outcome.status == Status::Converged
    }
}

/// Moves the vertices of a mesh until its faces are planar and its even ones satisfy the angle condition, close to
/// `target` or, without one, to where they are. Odd faces are only made planar. A mesh that meets this is returned
/// unchanged.
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
    let mut x = unknowns(mesh);
    let panels = Panels::new(mesh.topology());
    let shape = Shape::at(&panels, &x);
    let reference = target.map_or_else(|| Reference::start(&panels, &x), Reference::Surface);
    let side = Some((0..panels.n_faces()).map(|f| shape.normal(f)).collect());
    let stage = Stage::new(mesh, reference, side, &kinds_of(mesh), &options.optimise);
    let setting = stage.setting(&x);
    let assemblies = [energy_assembly(&panels), angle_assembly(&panels)];
    let mut path = AnglePath::new(&setting, &assemblies, &x, options, progress)?;
    let before = (path.constraints.defect(&x), path.energy.deviation(&x).0);
    if !path.is_met(&x) {
        path.project(&mut x);
        if path.outcome.status == Status::Converged {
            path.descend(&mut x);
        }
    }
    let after = path.constraints.defect(&x);
    let deviation = path.energy.deviation(&x);
    let (quality, offenders) = inspect(
        setting.panels,
        setting.guard,
        &x,
        deviation,
        &options.optimise,
    );
    Ok(AngleOptimised {
        mesh: mesh.with_positions(PerVertex::from_vec(points(&x))),
        outcome: path.outcome,
        angle_defect: [before.0, after],
        deviation: [before.1, deviation.0],
        quality,
        offenders,
    })
}

/// Planarity of all faces and the angle condition of the even ones.
struct AngleConstraints<'a> {
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    bases: ConstraintBases,
    /// First constraint of each face, and one past the last.
    start: Vec<usize>,
    /// First row vector of each face.
    row_start: Vec<usize>,
    /// Derivatives of the constraints of a face, corner after corner, constraint after constraint.
    rows: Vec<Vec3>,
    /// Alternating sum of angles that an even face is to have.
    branch: Vec<Option<f64>>,
    armed: Armed,
    linearised: Shape,
    trial: Shape,
    corner_motion: Vec<Vec2>,
    blocks: Vec<f64>,
}

/// Numbers of the constraints of all faces: `k - 3` for planarity, one more for the angles of even faces.
fn constraint_starts(panels: &Panels) -> Vec<usize> {
    let mut start = vec![0];
    for f in 0..panels.n_faces() {
        start.push(start[f] + n_constraints(panels.valence(f)));
    }
    start
}

fn n_constraints(valence: usize) -> usize {
    valence - 3 + usize::from(has_angle(valence))
}

fn has_angle(valence: usize) -> bool {
    valence.is_multiple_of(2)
}

/// The assembly of `J J^T`: an element for each vertex.
fn angle_assembly(panels: &Panels) -> Assembly {
    let start = constraint_starts(panels);
    let of_corner = |&c: &u32| {
        let f = panels.face_of(c);
        (start[f]..start[f + 1]).map(|i| i as u32)
    };
    let of_vertex = |v| panels.corners_at(v).iter().flat_map(of_corner).collect();
    let elements: Vec<Vec<u32>> = (0..panels.n_vertices()).map(of_vertex).collect();
    Assembly::new(start[panels.n_faces()], &elements)
}

/// `t_0 - t_1 + t_2 - ...` of a face in its plane.
fn alternating_sum(corners: &[Corner]) -> f64 {
    let flat: Vec<Vec2> = corners.iter().map(|c| c.flat).collect();
    let signed = |(i, t): (usize, f64)| if i % 2 == 0 { t } else { -t };
    interior_angles(&flat).enumerate().map(signed).sum()
}

/// Derivative of [`alternating_sum`] by each corner: `+-2 (n x e / |e|^2)` of both its edges.
fn angle_gradient(frame: &FaceFrame, corners: &[Corner], i: usize) -> Vec3 {
    let k = corners.len();
    let turn = |from: usize, to: usize| {
        let e = corners[to].flat - corners[from].flat;
        Vec2::new(-e.y, e.x) / e.norm_squared()
    };
    let sum = (turn(i, (i + 1) % k) + turn((i + k - 1) % k, i)) * 2.0;
    let [a, b] = frame.plane.axes;
    let gradient = a * sum.x + b * sum.y;
    if i.is_multiple_of(2) {
        gradient
    } else {
        -gradient
    }
}

/// Unit of the angle constraint, over the mean edge: its gradient is then about as long as those of planarity.
const ANGLE_UNIT: f64 = 0.125;

impl<'a> AngleConstraints<'a> {
    fn new(setting: &'a Setting<'a>, assembly: &'a Assembly, x: &[f64], least: f64) -> Self {
        let panels = setting.panels;
        let shape = Shape::at(panels, x);
        let mut armed = setting.guard.arm(panels, &shape, x);
        armed.keep_clear(panels, &shape, least);
        let start = constraint_starts(panels);
        let mut row_start = vec![0];
        for f in 0..panels.n_faces() {
            row_start.push(row_start[f] + panels.valence(f) * (start[f + 1] - start[f]));
        }
        let branch = |f: usize| {
            let nearest = |sum: f64| (sum / TAU).round() * TAU;
            has_angle(panels.valence(f)).then(|| nearest(alternating_sum(shape.face(panels, f))))
        };
        Self {
            bases: ConstraintBases::new(panels),
            rows: vec![Vec3::zeros(); row_start[panels.n_faces()]],
            start,
            row_start,
            branch: (0..panels.n_faces()).map(branch).collect(),
            armed,
            trial: shape.clone(),
            linearised: shape,
            corner_motion: vec![Vec2::zeros(); panels.n_corners()],
            blocks: vec![0.0; assembly.n_block_entries()],
            setting,
            assembly,
        }
    }

    /// How far an even face is from its branch, in radians: twice the defect of the sum of every other angle.
    fn angle_residual(&self, shape: &Shape, f: usize) -> f64 {
        let sum = || alternating_sum(shape.face(self.setting.panels, f));
        self.branch[f].map_or(0.0, |branch| sum() - branch)
    }

    fn largest_angle(&self, shape: &Shape) -> f64 {
        let faces = 0..self.setting.panels.n_faces();
        let sizes = faces.map(|f| self.angle_residual(shape, f).abs());
        sizes.fold(0.0, |m, r| if r > m || r.is_nan() { r } else { m })
    }

    /// Largest defect of the condition at `x`, in radians.
    fn defect(&mut self, x: &[f64]) -> f64 {
        self.trial.update(self.setting.panels, x);
        0.5 * self.largest_angle(&self.trial)
    }

    fn unit(&self) -> f64 {
        ANGLE_UNIT * self.setting.mean_edge
    }

    fn update_rows(&mut self, x: &[f64]) {
        let (panels, unit) = (self.setting.panels, self.unit());
        self.linearised.update(panels, x);
        self.bases.update(panels, &self.linearised);
        for f in 0..panels.n_faces() {
            let (frame, corners) = (&self.linearised.frames[f], self.linearised.face(panels, f));
            let (k, m) = (corners.len(), self.start[f + 1] - self.start[f]);
            for i in 0..k {
                let rows = &mut self.rows[self.row_start[f] + i * m..][..m];
                for (a, row) in rows.iter_mut().enumerate() {
                    *row = if a < k - 3 {
                        frame.plane.normal * self.bases.row(f, a, k)[i]
                    } else {
                        angle_gradient(frame, corners, i) * unit
                    };
                }
            }
        }
    }

    /// First constraint of a corner's face, and the derivatives of its constraints by that corner.
    fn corner_rows(&self, corner: u32) -> (usize, &[Vec3]) {
        let f = self.setting.panels.face_of(corner);
        let local = corner as usize - self.setting.panels.corners(f).start;
        let m = self.start[f + 1] - self.start[f];
        (
            self.start[f],
            &self.rows[self.row_start[f] + local * m..][..m],
        )
    }

    /// `J W J^T` for the last linearisation.
    fn assemble(&mut self, metric: impl Fn(usize) -> Matrix3<f64>, normal: &mut SymmetricMatrix) {
        let panels = self.setting.panels;
        let mut blocks = std::mem::take(&mut self.blocks);
        for v in 0..panels.n_vertices() {
            let corners = panels.corners_at(v).iter();
            let rows: Vec<Vec3> = corners
                .flat_map(|&c| self.corner_rows(c).1)
                .copied()
                .collect();
            let w = metric(v);
            let mut entries = blocks[self.assembly.block(v)].iter_mut();
            for (a, row) in rows.iter().enumerate() {
                let weighted = w * row;
                for (other, entry) in rows[..=a].iter().zip(&mut entries) {
                    *entry = weighted.dot(other);
                }
            }
        }
        self.blocks = blocks;
        self.assembly.assemble(&self.blocks, normal);
    }

    /// `J d`.
    fn applied(&self, d: &[f64], values: &mut [f64]) {
        values.fill(0.0);
        let panels = self.setting.panels;
        for v in 0..panels.n_vertices() {
            for &c in panels.corners_at(v) {
                let (first, rows) = self.corner_rows(c);
                for (value, row) in values[first..].iter_mut().zip(rows) {
                    *value += row.dot(&point(d, v));
                }
            }
        }
    }
}

impl Constraints for AngleConstraints<'_> {
    fn linearise(&mut self, x: &[f64], values: &mut [f64], normal: &mut SymmetricMatrix) {
        self.update_rows(x);
        let panels = self.setting.panels;
        for f in 0..panels.n_faces() {
            let corners = self.linearised.face(panels, f);
            for (a, value) in values[self.start[f]..self.start[f + 1]]
                .iter_mut()
                .enumerate()
            {
                *value = if a < corners.len() - 3 {
                    let row = self.bases.row(f, a, corners.len()).iter();
                    row.zip(corners).map(|(q, c)| q * c.height).sum()
                } else {
                    self.unit() * self.angle_residual(&self.linearised, f)
                };
            }
        }
        self.assemble(|_| Matrix3::identity(), normal);
    }

    fn transposed(&self, y: &[f64], d: &mut [f64]) {
        let panels = self.setting.panels;
        for v in 0..panels.n_vertices() {
            let mut sum = Vec3::zeros();
            for &c in panels.corners_at(v) {
                let (first, rows) = self.corner_rows(c);
                sum += rows
                    .iter()
                    .zip(&y[first..])
                    .map(|(r, y)| r * *y)
                    .sum::<Vec3>();
            }
            d[3 * v..3 * v + 3].copy_from_slice(sum.as_slice());
        }
    }

    fn step_bound(&mut self, _x: &[f64], step: &[f64]) -> f64 {
        const LONGEST: f64 = 0.3;
        let motion = &mut self.corner_motion;
        let bound = collision_bound(self.setting, &self.armed, &self.linearised, step, motion);
        bound.min(LONGEST / self.step_length(step).max(f64::MIN_POSITIVE))
    }

    fn admissible(&mut self, x: &[f64]) -> Option<f64> {
        let (setting, panels) = (self.setting, self.setting.panels);
        self.trial.update(panels, x);
        let held = setting.guard.holds(&self.armed, panels, &self.trial, x);
        let planarity = self.trial.max_height() / setting.mean_edge;
        held.then(|| planarity.max(0.5 * self.largest_angle(&self.trial)))
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        let squares = step.chunks_exact(3).map(|d| d.iter().map(|c| c * c).sum());
        squares.fold(0.0, f64::max).sqrt() / self.setting.mean_edge
    }
}

/// Damping of the descent at the start, over the weight of closeness, and its limits.
const DAMPING: [f64; 3] = [1e-1, 1e-4, 1e3];
/// Residual (radians, mean edges) below which steps of minimum norm converge fast.
const NEAR: f64 = 1e-2;
/// Straight projections at the most, with the parting of panels between them.
const PROJECTIONS: usize = 4;
/// Halvings of a step of the descent.
const HALVINGS: usize = 5;
/// Relative decrease of the energy that ends the descent.
const LITTLE: f64 = 1e-3;
/// Projection iterations after a step of the descent.
const RETRACTIONS: usize = 6;

/// The way from the start: constraints, energy and factorisations.
struct AnglePath<'a> {
    constraints: AngleConstraints<'a>,
    projector: MinimumNorm,
    tangent: Tangent,
    energy: PanelEnergy<'a>,
    options: &'a AngleOptions,
    progress: &'a dyn Progress,
    outcome: Outcome,
}

impl<'a> AnglePath<'a> {
    fn new(
        setting: &'a Setting<'a>,
        [energy, angles]: &'a [Assembly; 2],
        x: &[f64],
        options: &'a AngleOptions,
        progress: &'a dyn Progress,
    ) -> Result<Self, OptimiseError> {
        let least = options.optimise.least_clearance * setting.mean_edge;
        let (cholesky, normal) = system(angles, 1)?;
        Ok(Self {
            constraints: AngleConstraints::new(setting, angles, x, least),
            projector: MinimumNorm::new(cholesky, normal),
            tangent: Tangent::new(energy, angles, x.len())?,
            energy: panel_energy(setting, energy, x, &options.optimise),
            options,
            progress,
            outcome: Outcome::empty(Status::Converged),
        })
    }

    /// Whether `x` is sound, planar and has the right angles as it is.
    fn is_met(&mut self, x: &[f64]) -> bool {
        let residual = self.constraints.admissible(x);
        residual.is_some_and(|r| r <= self.options.tolerance)
    }

    /// Projects `x` onto the constraints. Where panels that must not come closer stop that, they are parted first.
    fn project(&mut self, x: &mut [f64]) {
        for _ in 0..PROJECTIONS {
            self.project_straight(x);
            if self.outcome.status != Status::Stalled || !self.project_apart(x) {
                return;
            }
        }
    }

    /// Newton steps of minimum norm.
    fn project_straight(&mut self, x: &mut [f64]) {
        let options = self.projection(self.options.newton_iterations);
        let progress = self.progress;
        let mut iteration = 0;
        let outcome = self
            .projector
            .project(&mut self.constraints, x, &options, |record| {
                iteration += 1;
                observe(progress, iteration, options.max_iterations, record)
            });
        self.outcome.append(outcome);
    }

    /// Newton steps in the metric of the energy, whose barrier makes tight corners stiff, along its gradient, which opens
    /// them; ends near the constraints, where straight steps do better. False if it does not get there.
    fn project_apart(&mut self, x: &mut [f64]) -> bool {
        let mut values = vec![0.0; self.tangent.multiplier.len()];
        let mut residual = self.constraints.admissible(x).unwrap_or(f64::INFINITY);
        for _ in 0..self.options.newton_iterations {
            if residual <= NEAR || self.progress.is_cancelled() {
                break;
            }
            self.energy.arm(x);
            let tangent = &mut self.tangent;
            self.energy
                .linearise(x, &mut tangent.gradient, &mut tangent.hessian);
            self.constraints
                .linearise(x, &mut values, &mut tangent.normal);
            if !tangent.solve(&mut self.constraints, Some(&values)) {
                break;
            }
            self.outcome.iterations += 1;
            self.outcome.factorisations += 1;
            match self.lower_residual(x, residual) {
                Some(reached) => residual = reached,
                None => break,
            }
        }
        residual <= NEAR
    }

    /// Moves `x` by the first fraction of the step that lowers the residual, which it returns.
    fn lower_residual(&mut self, x: &mut [f64], residual: f64) -> Option<f64> {
        let mut fraction = self.constraints.step_bound(x, &self.tangent.step);
        for _ in 0..HALVINGS {
            let step = self.tangent.step.iter();
            let trial: Vec<f64> = x.iter().zip(step).map(|(x, d)| x + fraction * d).collect();
            let reached = self.constraints.admissible(&trial);
            if let Some(reached) = reached.filter(|&r| r < residual) {
                x.copy_from_slice(&trial);
                return Some(reached);
            }
            fraction *= 0.5;
        }
        None
    }

    fn projection(&self, max_iterations: usize) -> ProjectionOptions {
        ProjectionOptions {
            max_iterations,
            goal: 0.0,
            tolerance: self.options.tolerance,
            phase: f64::INFINITY,
        }
    }

    /// Lowers the energy within the constraints, which `x` must meet.
    fn descend(&mut self, x: &mut Vec<f64>) {
        self.energy.arm(x);
        let mut energy = self.energy.energy(x);
        for iteration in 1..=self.options.descent_steps {
            if !energy.is_finite() {
                break;
            }
            let Some((trial, lower)) = self.descent_step(x, energy) else {
                break;
            };
            let decrease = (energy - lower) / energy;
            (*x, energy) = (trial, lower);
            let record = self.outcome.history.last().copied();
            let over = record.is_some_and(|r| {
                observe(self.progress, iteration, self.options.descent_steps, &r).is_break()
            });
            if over {
                self.outcome.status = Status::Cancelled;
            }
            if over || decrease < LITTLE {
                break;
            }
        }
    }

    /// The first fraction of a step that, projected back, lowers the energy.
    fn descent_step(&mut self, x: &[f64], energy: f64) -> Option<(Vec<f64>, f64)> {
        let tangent = &mut self.tangent;
        self.energy
            .linearise(x, &mut tangent.gradient, &mut tangent.hessian);
        self.constraints.update_rows(x);
        if !tangent.solve(&mut self.constraints, None) {
            return None;
        }
        let mut fraction = self.constraints.step_bound(x, &self.tangent.step);
        for _ in 0..HALVINGS {
            let step = self.tangent.step.iter();
            let moved = x.iter().zip(step).map(|(x, d)| x + fraction * d);
            let mut trial: Vec<f64> = moved.collect();
            if self.retract(&mut trial) {
                let lower = self.energy.energy(&trial);
                if lower < energy {
                    self.tangent.adapt(fraction);
                    return Some((trial, lower));
                }
            }
            fraction *= 0.5;
        }
        None
    }

    /// Projects a trial back; false if it does not get there.
    fn retract(&mut self, trial: &mut [f64]) -> bool {
        let options = self.projection(RETRACTIONS);
        let go_on = |_: &Record| ControlFlow::Continue(());
        let outcome = self
            .projector
            .project(&mut self.constraints, trial, &options, go_on);
        let arrived = outcome.status == Status::Converged;
        self.outcome.iterations += outcome.iterations;
        self.outcome.factorisations += outcome.factorisations;
        self.outcome.history.extend(outcome.history);
        arrived
    }
}

/// Tells of an iteration and hears of cancelling.
fn observe(
    progress: &dyn Progress,
    iteration: usize,
    limit: usize,
    record: &Record,
) -> ControlFlow<()> {
    progress.report(&Event::Iteration {
        stage: "angles",
        iteration,
        limit,
        residual: record.residual,
    });
    if progress.is_cancelled() {
        ControlFlow::Break(())
    } else {
        ControlFlow::Continue(())
    }
}

/// Factorisation and memory of the descent's equations.
struct Tangent {
    cholesky: Cholesky,
    normal: SymmetricMatrix,
    hessian: SymmetricMatrix,
    gradient: Vec<f64>,
    step: Vec<f64>,
    multiplier: Vec<f64>,
    damping: f64,
}

impl Tangent {
    fn new(energy: &Assembly, angles: &Assembly, n: usize) -> Result<Self, OptimiseError> {
        let (cholesky, normal) = system(angles, 1)?;
        Ok(Self {
            multiplier: vec![0.0; normal.dimension()],
            cholesky,
            normal,
            hessian: SymmetricMatrix::zeros(energy.pattern().clone()),
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            damping: DAMPING[0],
        })
    }

    /// Inverse diagonal blocks `W` of the damped Hessian.
    fn metric(&self) -> Vec<Matrix3<f64>> {
        let entry = |row: usize, column: usize| {
            let at = self.hessian.pattern().position(row as u32, column as u32);
            at.map_or(0.0, |k| self.hessian.values()[k])
        };
        let block = |v: usize| {
            let lower = Matrix3::from_fn(|a, b| entry(3 * v + a.max(b), 3 * v + a.min(b)));
            let damped = lower + Matrix3::identity() * self.damping;
            damped.try_inverse().unwrap_or_else(Matrix3::identity)
        };
        (0..self.gradient.len() / 3).map(block).collect()
    }

    /// The step of steepest descent in the metric `W` that keeps the linearised constraints or, with their values, meets them;
    /// false if there is none.
    fn solve(&mut self, constraints: &mut AngleConstraints<'_>, values: Option<&[f64]>) -> bool {
        let metric = self.metric();
        let weighted = |d: &mut [f64]| {
            for (v, w) in metric.iter().enumerate() {
                let turned = w * point(d, v);
                d[3 * v..3 * v + 3].copy_from_slice(turned.as_slice());
            }
        };
        let mut free = self.gradient.clone();
        weighted(&mut free);
        constraints.applied(&free, &mut self.multiplier);
        // J step = -values.
        for (b, value) in self.multiplier.iter_mut().zip(values.unwrap_or_default()) {
            *b -= value;
        }
        constraints.assemble(|v| metric[v], &mut self.normal);
        let shift = 1e-12 * self.normal.diagonal().fold(0.0, f64::max);
        if self.cholesky.refactor_shifted(&self.normal, shift).is_err() {
            return false;
        }
        self.cholesky.solve(&mut self.multiplier);
        constraints.transposed(&self.multiplier, &mut self.step);
        for (d, g) in self.step.iter_mut().zip(&self.gradient) {
            *d -= g;
        }
        weighted(&mut self.step);
        self.step.iter().all(|d| d.is_finite())
    }

    fn adapt(&mut self, fraction: f64) {
        let factor = if fraction > 0.5 { 0.3 } else { 4.0 };
        self.damping = (self.damping * factor).clamp(DAMPING[1], DAMPING[2]);
    }
}
