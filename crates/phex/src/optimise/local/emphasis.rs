//! Emphasis: what panels lack weighs more, and the more the oftener it has been tried.
//!
//! The phases end when the energy of the whole hardly falls, and one panel counts little in it: it
//! may come out tight, folded, small, too far off or needlessly concave where its neighbours would
//! have given way. Of a few panels with everything around them at rest, the same energy is
//! minimised again with more weight on limits, and on folds, and on re-entrant corners where the
//! surface is convex. Whether the result is better is for others to say.

use crate::optimise::OptimiseError;
use crate::optimise::concavity::{ConcavityTerm, is_concave, to_be_convex};
use crate::optimise::folds::FoldTerm;
use crate::optimise::guard::Breach;
use crate::optimise::panels::{FaceShapes, Panels};
use crate::optimise::path::Path;
use crate::optimise::setting::{Setting, distances};
use crate::optimise::shape_limits::ShapeLimits;
use crate::optimise::solvers::Solvers;

/// Weight of a fold or a re-entrant corner in the first round, over that of closeness.
const FIRST_WEIGHT: f64 = 1.0;
/// Factor of all weights from each round to the next, and of limits in the first.
const HEAVIER: f64 = 10.0;
/// Last phases that are gone through again, by rounds: Newton's method on the constraints, which
/// follows, often finds the room alone.
const PHASES: [usize; EMPHASES] = [0, 1, 3];

/// Rounds of rising emphasis.
pub(crate) const EMPHASES: usize = 3;

/// What faces lack.
pub(super) struct Lack {
    /// By how much each face is beyond its limits, over the limit.
    beyond: Vec<f64>,
    /// Faces of which a corner or the centre stands off too far.
    far: Vec<bool>,
    folded: Vec<bool>,
    /// Re-entrant corners where the surface is convex, and all faces that are to be convex.
    concave: Vec<bool>,
    convex: Vec<bool>,
    /// Largest distance to the surface.
    pub farthest: f64,
    /// Whatever is wrong with panels.
    breaches: usize,
}

impl Lack {
    pub fn at(setting: &Setting<'_>, x: &[f64]) -> Self {
        let (panels, shape) = (setting.panels, FaceShapes::at(setting.panels, x));
        let faces = 0..panels.n_faces();
        let distances = distances(setting, x);
        let is_far = |k: usize| distances[k] > setting.limits.distance;
        let stands_off = |f: usize| {
            let mut vertices = panels.vertices(f).iter();
            is_far(panels.n_vertices() + f) || vertices.any(|&v| is_far(v as usize))
        };
        let breaches = setting.guard.breaches(panels, &shape, x);
        let convex = to_be_convex(setting, &shape);
        let edge = setting.mean_edge;
        let concave = |f: usize| convex[f] && is_concave(shape.face(panels, f), edge);
        let margins = ShapeLimits::new(setting.limits, panels, &shape).margins(panels, &shape);
        Self {
            beyond: margins.iter().map(|c| (-c).max(0.0)).collect(),
            far: faces.clone().map(stands_off).collect(),
            concave: faces.map(concave).collect(),
            folded: folded(setting, &shape, &breaches),
            convex,
            farthest: distances.into_iter().fold(0.0, f64::max),
            breaches: breaches.len(),
        }
    }

    pub fn has_folds(&self) -> bool {
        self.folded.contains(&true)
    }

    /// Whether a face lacks something, of its limits more than a share.
    pub fn of(&self, f: usize, share: f64) -> bool {
        self.far[f] || self.folded[f] || self.concave[f] || self.beyond[f] > share
    }

    /// What is wrong in all: breaches and faces that stand off or are concave, then limits.
    pub fn total(&self) -> (usize, f64) {
        let count = |which: &[bool]| which.iter().filter(|w| **w).count();
        let wrong = self.breaches + count(&self.far) + count(&self.concave);
        (wrong, self.beyond.iter().map(|l| l * l).sum())
    }

    /// Gives more weight to what is missing, in a round.
    pub fn emphasise(&self, path: &mut Path<'_>, round: usize) {
        let rising = HEAVIER.powi(round as i32);
        let heavy = path.weights.closeness.vertex * FIRST_WEIGHT * rising;
        path.weights.limits *= HEAVIER * rising;
        path.weights.closeness.limit.elastic.weight *= HEAVIER * rising;
        if let Some(Some(folds)) = path.folds() {
            folds.weight = heavy;
        }
        let edge = path.setting.mean_edge;
        if let Some(concavity) = path.concavity().filter(|_| self.concave.contains(&true)) {
            *concavity = Some(ConcavityTerm {
                weight: heavy,
                faces: self.convex.clone(),
                edge,
            });
        }
    }

    /// Solvers for a path that is to be emphasised, and what folds pay, if there are any.
    pub fn solvers(
        &self,
        setting: &Setting<'_>,
        x: &[f64],
    ) -> Result<(Solvers, Option<FoldTerm>), OptimiseError> {
        let panels: &Panels = setting.panels;
        if !self.has_folds() {
            return Ok((Solvers::new(panels)?, None));
        }
        let joint = setting.limits.panels.min_dihedral;
        let folds = FoldTerm::new(panels, setting.guard, x, joint);
        Ok((Solvers::with_folds(panels, &folds)?, Some(folds)))
    }
}

/// Faces that fold against a neighbour, or meet one in a joint that is too sharp.
fn folded(setting: &Setting<'_>, shape: &FaceShapes, breaches: &[Breach]) -> Vec<bool> {
    let mut folded = vec![false; setting.panels.n_faces()];
    for breach in breaches {
        if let Breach::Fold(faces) = breach {
            faces.iter().for_each(|f| folded[*f] = true);
        }
    }
    if let Some(angle) = setting.limits.panels.min_dihedral {
        for faces in setting.guard.hinges() {
            let [f, g] = faces.map(|f| f as usize);
            let turn = shape.normal(f).angle(&shape.normal(g)).to_degrees();
            if turn > 180.0 - angle {
                (folded[f], folded[g]) = (true, true);
            }
        }
    }
    folded
}

impl Path<'_> {
    /// One round of emphasis on what faces lack at planar positions.
    pub(super) fn emphasised(
        &mut self,
        x: &[f64],
        (lack, folds): (&Lack, Option<FoldTerm>),
        round: usize,
    ) -> Result<Vec<f64>, OptimiseError> {
        if let Some(place) = self.folds() {
            *place = folds;
        }
        lack.emphasise(self, round);
        self.again(x, PHASES[round])
    }
}
