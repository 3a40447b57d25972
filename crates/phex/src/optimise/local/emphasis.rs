//! Emphasis: what panels lack weighs more, and the more the oftener it has been tried.
//!
//! The phases end when the energy of the whole hardly falls, and one panel counts little in it: it
//! may come out tight, folded, small, too far off or needlessly concave where its neighbours would
//! have given way. Of a few panels with everything around them at rest, the same energy is
//! minimised again with more weight on just that: barriers of tight panels reach farther and are
//! stronger, closeness is stronger where panels stand off, folds pay, and re-entrant corners where
//! the surface is convex, and areas below the least. Whether the result is better is for others to
//! say.

use crate::optimise::OptimiseError;
use crate::optimise::areas::AreaWish;
use crate::optimise::barrier::clearance;
use crate::optimise::concavity::{ConcavityTerm, is_concave, to_be_convex};
use crate::optimise::folds::FoldTerm;
use crate::optimise::guard::Breach;
use crate::optimise::panels::{FaceShapes, Panels};
use crate::optimise::path::Path;
use crate::optimise::setting::{Setting, distances};
use crate::optimise::shape_limits::ShapeLimits;
use crate::optimise::simple::area;
use crate::optimise::solvers::Solvers;

/// Factor of barriers or closeness from one round for a group of panels to the next.
const STRONGER: f64 = 4.0;
/// Reach of the barriers of tight panels, over the reach that is usual, and least reach of all,
/// over the clearance that is wanted: what lies beside gives way without becoming tight.
const FARTHER: f64 = 1.4;
const BEYOND: f64 = 1.25;
/// Area that small faces pay for, over what is wanted: a penalty leaves a rest.
const AMPLE: f64 = 1.1;
/// Weight of a fold, a re-entrant corner or a small face in the first round, over that of
/// closeness, and the factor from each round to the next.
const FIRST_WEIGHT: f64 = 1.0;
const HEAVIER: f64 = 10.0;
/// Last phases that are gone through again, by rounds: Newton's method on the constraints, which
/// follows, often finds the room alone.
const PHASES: [usize; EMPHASES] = [0, 1, 3];

/// Rounds of rising emphasis.
pub(crate) const EMPHASES: usize = 3;

/// What faces are to have; lengths in the unit of the mesh.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    /// Least clearance of each face.
    pub clearance: Vec<f64>,
    /// Least area of each face; 0 for any.
    pub area: Vec<f64>,
    /// Largest distance to the surface.
    pub distance: f64,
}

/// What faces lack.
#[derive(Default)]
pub(super) struct Lack {
    /// Share of the clearance that each face lacks, and of the area.
    pub clearance: Vec<f64>,
    area: Vec<f64>,
    /// Faces of which a corner or the centre stands off too far.
    far: Vec<bool>,
    folded: Vec<bool>,
    /// Faces that no workshop can make as they are.
    unfit: Vec<bool>,
    /// Re-entrant corners where the surface is convex, and all faces that are to be convex.
    concave: Vec<bool>,
    convex: Vec<bool>,
    /// Largest distance to the surface.
    pub farthest: f64,
    /// Whatever is wrong with panels.
    breaches: usize,
}

impl Lack {
    pub fn at(setting: &Setting<'_>, x: &[f64], wanted: &Wanted) -> Self {
        let (panels, shape) = (setting.panels, FaceShapes::at(setting.panels, x));
        let faces = 0..panels.n_faces();
        let lacks = |has: f64, wants: f64| match wants > 0.0 {
            true => (1.0 - has / wants).max(0.0),
            false => 0.0,
        };
        let corners = |f: usize| shape.face(panels, f);
        let distances = distances(setting, x);
        let is_far = |k: usize| distances[k] > wanted.distance;
        let stands_off = |f: usize| {
            let mut vertices = panels.vertices(f).iter();
            is_far(panels.n_vertices() + f) || vertices.any(|&v| is_far(v as usize))
        };
        let breaches = setting.guard.breaches(panels, &shape, x);
        let mut folded = vec![false; panels.n_faces()];
        for breach in &breaches {
            if let Breach::Fold(faces) = breach {
                faces.iter().for_each(|f| folded[*f] = true);
            }
        }
        if let Some(angle) = setting.limits.min_dihedral {
            for &[f, g] in setting.guard.hinges() {
                let [f, g] = [f, g].map(|f| f as usize);
                let turn = shape.normal(f).angle(&shape.normal(g)).to_degrees();
                let sharp = turn > 180.0 - angle;
                folded[f] |= sharp;
                folded[g] |= sharp;
            }
        }
        let limits = ShapeLimits::new(setting.limits, panels, &shape);
        let margins = limits.map(|l| l.margins(panels, &shape));
        let margins = margins.unwrap_or_else(|| vec![1.0; panels.n_faces()]);
        let convex = to_be_convex(setting, &shape);
        let concave = |f: usize| convex[f] && is_concave(corners(f), setting.mean_edge);
        Self {
            clearance: (faces.clone())
                .map(|f| lacks(clearance(corners(f)), wanted.clearance[f]))
                .collect(),
            area: (faces.clone())
                .map(|f| lacks(area(corners(f)).abs(), wanted.area[f]))
                .collect(),
            far: faces.clone().map(stands_off).collect(),
            concave: faces.map(concave).collect(),
            folded,
            unfit: margins.into_iter().map(|c| c < 0.0).collect(),
            convex,
            farthest: distances.into_iter().fold(0.0, f64::max),
            breaches: breaches.len(),
        }
    }

    pub fn has_folds(&self) -> bool {
        self.folded.contains(&true)
    }

    /// Whether a face lacks something, of the clearance more than a share.
    pub fn of(&self, f: usize, share: f64) -> bool {
        let lacks = self.far[f] || self.folded[f] || self.concave[f] || self.unfit[f];
        let lacks = lacks || self.area[f] > 0.0;
        lacks || self.clearance[f] > share
    }

    /// What is wrong in all: breaches and faces that stand off or are concave, then room.
    pub fn total(&self) -> (usize, f64) {
        let count = |which: &[bool]| which.iter().filter(|w| **w).count();
        let room = self.clearance.iter().chain(&self.area);
        let wrong = self.breaches + count(&self.far) + count(&self.concave) + count(&self.unfit);
        (wrong, room.map(|l| l * l).sum())
    }

    /// Gives more weight to what is missing, in a round.
    pub fn emphasise(&self, path: &mut Path<'_>, wanted: &Wanted, round: usize) {
        let heavy = path.weights.closeness.vertex * FIRST_WEIGHT * HEAVIER.powi(round as i32);
        let strong = STRONGER.powi(round as i32);
        for (f, barrier) in path.barriers.iter_mut().enumerate() {
            barrier.reach = barrier.reach.max(BEYOND * wanted.clearance[f]);
            if self.clearance[f] > 0.0 {
                barrier.reach *= FARTHER;
                barrier.weight *= strong;
            }
        }
        if self.far.contains(&true) {
            let closeness = &mut path.weights.closeness;
            for weight in [
                &mut closeness.vertex,
                &mut closeness.centre,
                &mut closeness.rim,
            ] {
                *weight *= STRONGER * strong;
            }
        }
        if self.unfit.contains(&true) {
            path.weights.limits *= HEAVIER.powi(round as i32 + 1);
        }
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
        if self.area.iter().all(|lack| *lack == 0.0) {
            return;
        }
        let wishes = path.areas().into_iter().flatten().zip(&wanted.area);
        for (wish, area) in wishes.filter(|(_, area)| **area > 0.0) {
            *wish = AreaWish {
                area: AMPLE * area,
                weight: heavy,
                at_least: true,
            };
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
        let folds = FoldTerm::new(panels, setting.guard, x, setting.limits.min_dihedral);
        Ok((Solvers::with_folds(panels, &folds)?, Some(folds)))
    }
}

impl Path<'_> {
    /// One round of emphasis on what faces lack at planar positions.
    pub(super) fn emphasised(
        &mut self,
        x: &[f64],
        (lack, folds): (&Lack, Option<FoldTerm>),
        wanted: &Wanted,
        round: usize,
    ) -> Result<Vec<f64>, OptimiseError> {
        if let Some(place) = self.folds() {
            *place = folds;
        }
        lack.emphasise(self, wanted, round);
        self.again(x, PHASES[round])
    }
}
