//! The energy that is minimised, over the vertices alone.
//!
//! `E = w_p sum h^2 / 2 + closeness + fairness + barrier + limits + w_t |x - x_0|^2 / 2`, infinite
//! where the guard is broken.

use crate::optimise::constraints::planarity;
use crate::optimise::holds::Holds;
use crate::optimise::options::OptimiseOptions;
use crate::optimise::panels::{FaceShapes, Panels, add_block, point, put};
use crate::optimise::terms::angle_term::AngleTerm;
use crate::optimise::terms::areas::AreaWish;
use crate::optimise::terms::barrier::{self, Barrier, barriers};
use crate::optimise::terms::closeness::{ClosenessWeights, DistanceLimit, Feet};
use crate::optimise::terms::concavity::ConcavityTerm;
use crate::optimise::terms::edge_lengths::EdgeLengths;
use crate::optimise::terms::fairness::Fairness;
use crate::optimise::terms::folds::FoldTerm;
use crate::optimise::terms::guard::Armed;
use crate::optimise::terms::inequality::Elastic;
use crate::optimise::terms::setting::{Setting, collision_bound, longest};
use crate::optimise::terms::shape_limits::ShapeLimits;
use crate::optimise::terms::spatial_barrier;
use nalgebra::Matrix3;
use phex_mesh::polygon::HEXAGON;
use phex_mesh::{Vec2, Vec3};
use phex_numeric::{Assembly, DampedProblem, SymmetricMatrix};

/// Trials in a row that demands other than simplicity may block.
const PATIENCE: usize = 3;

/// Weights of the energy.
#[derive(Clone, Copy, Debug)]
pub(in crate::optimise) struct Weights {
    pub planarity: f64,
    pub closeness: ClosenessWeights,
    pub fairness: f64,
    pub anchor: f64,
    /// Anchor of the corners of the boundary.
    pub corner: f64,
    /// Limits of panels.
    pub limits: f64,
}

impl Weights {
    /// Weights of the energy, that of planarity 0.
    pub fn of(options: &OptimiseOptions, setting: &Setting<'_>) -> Self {
        let limits = options.limits * options.vertex_closeness;
        Self {
            planarity: 0.0,
            closeness: ClosenessWeights {
                vertex: options.vertex_closeness,
                centre: options.centre_closeness,
                rim: options.boundary_closeness,
                limit: DistanceLimit {
                    elastic: Elastic {
                        weight: limits * HEXAGON * setting.mean_edge.powi(2),
                    },
                    most: setting.limits.distance,
                },
            },
            fairness: options.fairness,
            anchor: options.anchor,
            corner: options.corner_closeness,
            limits,
        }
    }
}

/// The energy with the weights of the options; `start` is the anchor.
pub(in crate::optimise) fn panel_energy<'a>(
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    start: &[f64],
    options: &OptimiseOptions,
) -> PanelEnergy<'a> {
    let barriers = barriers(setting.panels, start, options);
    PanelEnergy::new(
        setting,
        assembly,
        Weights::of(options, setting),
        barriers,
        start,
    )
}

/// The energy at the positions that were asked for last, and what was computed there.
pub(in crate::optimise) struct PanelEnergy<'a> {
    pub weights: Weights,
    pub barriers: Vec<Barrier>,
    /// The angle condition of a vertex offset, where it is wanted.
    pub angles: Option<AngleTerm<'a>>,
    /// What folds pay, where they are to go; not together with the angle condition.
    pub folds: Option<FoldTerm>,
    /// What re-entrant corners pay, where they are to go.
    pub concavity: Option<ConcavityTerm>,
    /// Lengths that edges are to have, where some are to be equal.
    pub lengths: Option<EdgeLengths>,
    /// Areas that faces are to have.
    pub areas: Vec<AreaWish>,
    fairness: Fairness,
    /// Limits of panels.
    limits: ShapeLimits<'a>,
    /// Multipliers `l` of the heights of all corners, if planarity is a constraint and not a
    /// penalty alone; second derivatives are exact then.
    pub multipliers: Option<Vec<f64>>,
    setting: &'a Setting<'a>,
    assembly: &'a Assembly,
    armed: Armed,
    anchor: Vec<f64>,
    at: Vec<f64>,
    shape: FaceShapes,
    /// The shape that was linearised last.
    linearised: FaceShapes,
    feet: Feet,
    admissible: bool,
    /// Trials in a row that were not admissible.
    blocked: usize,
    face_energy: Vec<f64>,
    corner_gradient: Vec<Vec3>,
    corner_motion: Vec<Vec2>,
    blocks: Vec<f64>,
}

impl<'a> PanelEnergy<'a> {
    /// `assembly` has a block for every face and then one for every vertex.
    pub fn new(
        setting: &'a Setting<'a>,
        assembly: &'a Assembly,
        weights: Weights,
        barriers: Vec<Barrier>,
        start: &[f64],
    ) -> Self {
        let panels = setting.panels;
        let shape = FaceShapes::at(panels, start);
        Self {
            weights,
            barriers,
            angles: None,
            folds: None,
            concavity: None,
            lengths: None,
            areas: setting.areas.to_vec(),
            fairness: Fairness::new(panels, &shape, setting.areas),
            limits: ShapeLimits::new(setting.limits, panels, &shape),
            multipliers: None,
            armed: setting
                .guard
                .arm(panels, &shape, start)
                .without_neighbours(),
            setting,
            assembly,
            anchor: start.to_vec(),
            at: Vec::new(),
            linearised: shape.clone(),
            shape,
            feet: Feet::default(),
            admissible: false,
            blocked: 0,
            face_energy: vec![0.0; panels.n_faces()],
            corner_gradient: vec![Vec3::zeros(); panels.n_corners()],
            corner_motion: vec![Vec2::zeros(); panels.n_corners()],
            blocks: vec![0.0; assembly.n_block_entries()],
        }
    }

    /// Demands from now on what the shape at `x` meets; panels that are not simple have no barrier
    /// until they are.
    pub fn arm(&mut self, x: &[f64]) {
        if self.multipliers.take().is_some() {
            self.feet = Feet::default();
        }
        let panels = self.setting.panels;
        let shape = FaceShapes::at(panels, x);
        self.armed = self
            .setting
            .guard
            .arm(panels, &shape, x)
            .without_neighbours();
        self.limits.turn(panels, &shape);
        self.at.clear();
    }

    pub fn panels(&self) -> &'a Panels {
        self.setting.panels
    }

    pub fn holds(&self) -> &'a Holds {
        self.setting.holds
    }

    /// Where the panels lie at the point that was visited last.
    pub fn shape(&self) -> &FaceShapes {
        &self.shape
    }

    /// Takes planarity as a constraint from `x` on, with multipliers that are 0 at first.
    /// Everything that is demanded of a result is demanded now if `x` meets it, and nothing is
    /// given up.
    pub(crate) fn constrain(&mut self, x: &[f64]) {
        let setting = self.setting;
        self.arm(x);
        self.armed = setting
            .guard
            .arm(setting.panels, &FaceShapes::at(setting.panels, x), x);
        self.multipliers = Some(vec![0.0; setting.panels.n_corners()]);
    }

    /// From now on a smooth stand-in that touches the surface around `x` takes its place, and
    /// edges are drawn to what lies between them and like ones at `x`.
    pub(crate) fn freeze(&mut self, x: &[f64]) {
        let setting = self.setting;
        self.feet.thaw();
        self.at.clear();
        self.visit(x);
        self.feet.freeze(setting.reference, setting.mean_edge);
        self.fairness.freeze(setting.panels, x);
        self.at.clear();
    }

    /// Moves to `x`, unless already there.
    fn visit(&mut self, x: &[f64]) {
        if self.at == x {
            return;
        }
        let setting = self.setting;
        self.at.clear();
        self.at.extend_from_slice(x);
        self.shape.update(setting.panels, x);
        self.admissible = setting
            .guard
            .holds(&self.armed, setting.panels, &self.shape, x);
        self.blocked = if self.admissible { 0 } else { self.blocked + 1 };
        if self.blocked >= PATIENCE && self.multipliers.is_none() {
            setting.guard.give_up_sides(&mut self.armed, &self.shape);
            self.blocked = 0;
        }
        if self.admissible {
            self.feet
                .update(setting.reference, &self.shape, x, setting.rim);
        }
    }

    fn panel_energy(&mut self) -> f64 {
        let (panels, shape) = (self.setting.panels, &self.shape);
        let (weights, barriers, armed) = (self.weights, &self.barriers, &self.armed);
        let (angles, concavity) = (&self.angles, &self.concavity);
        let (areas, lengths, limits) = (&self.areas, &self.lengths, &self.limits);
        let (fairness, at) = (&self.fairness, &self.at[..]);
        let multipliers = self.multipliers.as_deref();
        let work = |f: usize, energy: &mut f64, _: &mut [()], _: &mut [f64]| {
            if panels.rests(f) {
                return;
            }
            let corners = shape.face(panels, f);
            *energy = planarity::energy(&shape.frames[f], weights.planarity)
                + fairness.energy(panels, at, f, corners, weights.fairness);
            match multipliers {
                Some(l) => {
                    let pairs = l[panels.corners(f)].iter().zip(corners);
                    *energy += pairs.map(|(l, c)| l * c.height).sum::<f64>();
                    if armed.is_simple(f) {
                        *energy += spatial_barrier::energy(corners, &barriers[f]);
                    }
                }
                None if armed.is_simple(f) => *energy += barrier::energy(corners, &barriers[f]),
                None => {}
            }
            if let Some(angles) = angles {
                *energy += angles.energy(f, corners);
            }
            if let Some(concavity) = concavity {
                *energy += concavity.energy(f, corners);
            }
            if let Some(lengths) = lengths {
                *energy += lengths.energy(panels, f, corners);
            }
            *energy += areas[f].energy(corners);
            *energy += limits.energy(f, corners, &shape.frames[f], weights.limits);
        };
        let mut none = vec![(); panels.n_corners()];
        panels.for_each_face(&mut self.face_energy, &mut none, &mut [], &|_| 0, &work);
        self.face_energy.iter().sum()
    }

    /// Weight of the anchor of a vertex.
    fn hold(&self, v: usize) -> f64 {
        if let Some(anchor) = self.setting.holds.anchors.get(&(v as u32)) {
            anchor.weight * self.weights.closeness.vertex
        } else if self.setting.corner[v] {
            self.weights.corner
        } else {
            self.weights.anchor
        }
    }

    fn pull(&self, v: usize) -> Vec3 {
        let anchor = self.setting.holds.anchors.get(&(v as u32));
        let anchor = anchor.map_or_else(|| point(&self.anchor, v), |a| a.point);
        point(&self.at, v) - anchor
    }

    fn anchor_energy(&self) -> f64 {
        let energy = |v| 0.5 * self.hold(v) * self.pull(v).norm_squared();
        (0..self.setting.panels.n_vertices()).map(energy).sum()
    }

    /// Gradient at the corners and Hessian blocks of all faces.
    fn linearise_faces(&mut self) {
        let (panels, shape, feet) = (self.setting.panels, &self.shape, &self.feet);
        let (weights, barriers, armed) = (self.weights, &self.barriers, &self.armed);
        let (angles, concavity) = (&self.angles, &self.concavity);
        let (areas, lengths, limits) = (&self.areas, &self.lengths, &self.limits);
        let (fairness, at) = (&self.fairness, &self.at[..]);
        let multipliers = self.multipliers.as_deref();
        let work = |f: usize, _: &mut f64, gradient: &mut [Vec3], block: &mut [f64]| {
            if panels.rests(f) {
                return;
            }
            let corners = shape.face(panels, f);
            let (frame, k) = (&shape.frames[f], corners.len() as f64);
            block.fill(0.0);
            let centre = feet.centre(panels.n_vertices(), f, &weights.closeness);
            gradient.fill(centre.gradient / k);
            let share = centre.hessian / (k * k);
            for i in 0..corners.len() {
                (0..=i).for_each(|j| add_block(block, i, j, &share));
            }
            planarity::add(frame, corners, weights.planarity, gradient, block);
            fairness.add((panels, at), f, corners, weights.fairness, gradient, block);
            match multipliers {
                Some(l) => {
                    let l = &l[panels.corners(f)];
                    planarity::add_multiplied(frame, corners, l, gradient, block);
                    if armed.is_simple(f) {
                        spatial_barrier::add(corners, &barriers[f], gradient, block);
                    }
                }
                None if armed.is_simple(f) => {
                    barrier::add(frame, corners, &barriers[f], gradient, block);
                }
                None => {}
            }
            if let Some(angles) = angles {
                angles.add(f, frame, corners, gradient, block);
            }
            if let Some(concavity) = concavity {
                concavity.add(f, frame, corners, gradient, block);
            }
            if let Some(lengths) = lengths {
                lengths.add(panels, f, corners, gradient, block);
            }
            areas[f].add(frame, corners, gradient, block);
            limits.add(f, (corners, frame), weights.limits, gradient, block);
        };
        let assembly = self.assembly;
        let face_entries = assembly.block(panels.n_faces()).start;
        panels.for_each_face(
            &mut self.face_energy,
            &mut self.corner_gradient,
            &mut self.blocks[..face_entries],
            &|f| assembly.block(f).end,
            &work,
        );
    }

    /// Gradient and Hessian of what depends on one vertex alone.
    fn linearise_vertices(&mut self, gradient: &mut [f64]) {
        let setting = self.setting;
        let panels = setting.panels;
        let mut rim = setting.rim.iter().enumerate().peekable();
        for v in 0..panels.n_vertices() {
            let closeness = &self.weights.closeness;
            let term = match rim.next_if(|(_, r)| **r as usize == v) {
                Some((k, _)) => self.feet.rim_vertex(k, v, closeness),
                None => self.feet.limited(v, closeness.vertex, &closeness.limit),
            };
            let corners = panels.corners_at(v).iter();
            let faces: Vec3 = corners.map(|&c| self.corner_gradient[c as usize]).sum();
            let hold = self.hold(v);
            let g = term.gradient + self.pull(v) * hold + faces;
            let hessian = term.hessian + Matrix3::from_diagonal_element(hold);
            put(gradient, v, &g);
            let block = &mut self.blocks[self.assembly.block(panels.n_faces() + v)];
            block.fill(0.0);
            add_block(block, 0, 0, &hessian);
        }
    }
}

impl DampedProblem for PanelEnergy<'_> {
    fn energy(&mut self, x: &[f64]) -> f64 {
        self.visit(x);
        if !self.admissible {
            return f64::INFINITY;
        }
        let closeness = &self.weights.closeness;
        let near = self
            .feet
            .energy(self.setting.panels.n_vertices(), closeness);
        let closing = self.angles.as_ref().map_or(0.0, |a| a.closing_energy(x));
        let panels = self.setting.panels;
        let folds = self.folds.as_ref().map_or(0.0, |h| h.energy(panels, x));
        self.panel_energy() + near + self.anchor_energy() + closing + folds
    }

    fn linearise(&mut self, x: &[f64], gradient: &mut [f64], hessian: &mut SymmetricMatrix) {
        self.visit(x);
        self.linearised.clone_from(&self.shape);
        self.linearise_faces();
        self.linearise_vertices(gradient);
        let (panels, assembly) = (self.setting.panels, self.assembly);
        let first = panels.n_faces() + panels.n_vertices();
        if let Some(angles) = &mut self.angles {
            angles.add_closing(x, gradient, assembly, first, &mut self.blocks);
        }
        if let Some(folds) = &self.folds {
            folds.add(panels, x, gradient, assembly, first, &mut self.blocks);
        }
        let weight = self.weights.closeness.vertex;
        self.setting
            .holds
            .restrict(panels, assembly, weight, x, gradient, &mut self.blocks);
        self.assembly.assemble(&self.blocks, hessian);
    }

    fn step_bound(&mut self, _x: &[f64], step: &[f64]) -> f64 {
        let motion = &mut self.corner_motion;
        let step = self.setting.holds.whole_step(step);
        collision_bound(self.setting, &self.armed, &self.linearised, &step, motion)
    }

    fn step_length(&self, step: &[f64]) -> f64 {
        longest(step) / self.setting.mean_edge
    }

    fn residual(&self) -> f64 {
        self.shape.max_height() / self.setting.mean_edge
    }

    fn retract(&self, x: &mut [f64]) {
        self.setting.holds.retract(x);
    }
}
