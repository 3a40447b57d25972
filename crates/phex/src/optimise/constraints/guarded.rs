//! Steps of a projection that end before the first collision within a face and visit only what the
//! guard admits.

use crate::optimise::panels::FaceShapes;
use crate::optimise::terms::guard::Armed;
use crate::optimise::terms::setting::{Setting, collision_bound, longest};
use phex_mesh::Vec2;
use std::collections::BTreeSet;

/// Longest step, in mean edges.
const LONGEST: f64 = 0.3;

/// The shape that was linearised last, the one that is tried, and the demands armed at the start.
pub(in crate::optimise) struct GuardedSteps<'a> {
    setting: &'a Setting<'a>,
    armed: Armed,
    pub linearised: FaceShapes,
    pub trial: FaceShapes,
    corner_motion: Vec<Vec2>,
}

impl<'a> GuardedSteps<'a> {
    /// Demands what `start` meets, and a clearance of `least`, a length; nothing without it.
    pub fn new(setting: &'a Setting<'a>, start: &[f64], least: Option<f64>) -> Self {
        let panels = setting.panels;
        let shape = FaceShapes::at(panels, start);
        let mut armed = setting.guard.arm(panels, &shape, start);
        match least {
            Some(least) => armed.keep_clear(panels, &shape, least),
            None => armed = armed.of_nothing(),
        }
        Self {
            armed,
            trial: shape.clone(),
            linearised: shape,
            corner_motion: vec![Vec2::zeros(); panels.n_corners()],
            setting,
        }
    }

    /// Largest fraction of a step that may be tried.
    pub fn bound(&mut self, step: &[f64]) -> f64 {
        let motion = &mut self.corner_motion;
        let bound = collision_bound(self.setting, &self.armed, &self.linearised, step, motion);
        bound.min(LONGEST / self.length(step).max(f64::MIN_POSITIVE))
    }

    /// Tries positions; whether they may be visited.
    pub(crate) fn admits(&mut self, x: &[f64]) -> bool {
        let (guard, panels) = (self.setting.guard, self.setting.panels);
        self.trial.update(panels, x);
        guard.holds(&self.armed, panels, &self.trial, x)
    }

    /// Halves a step at the corners of the faces at which positions that were not admitted break a
    /// demand: one place that is in the way stops no other one.
    pub(crate) fn hold_back(&self, x: &[f64], step: &mut [f64]) {
        let panels = self.setting.panels;
        let broken = (self.setting.guard).broken(&self.armed, panels, &self.trial, x);
        let corners = broken.flat_map(|f| panels.vertices(f as usize));
        let corners: BTreeSet<u32> = corners.copied().collect();
        for v in corners {
            let v = 3 * v as usize;
            step[v..v + 3].iter_mut().for_each(|d| *d *= 0.5);
        }
    }

    /// Planarity of what was tried last, in mean edges.
    pub fn planarity(&self) -> f64 {
        self.trial.max_height() / self.setting.mean_edge
    }

    /// The longest move of a vertex in a step, in mean edges.
    pub fn length(&self, step: &[f64]) -> f64 {
        longest(step) / self.setting.mean_edge
    }
}
