//! Emphasis: what panels lack weighs more, and the more the oftener it has been tried.
//!
//! The phases end when the energy of the whole hardly falls, and one panel counts little in it: it
//! may come out tight, folded, small, too far off or needlessly concave where its neighbours would
//! have given way. Of a few panels with everything around them at rest, the same energy is
//! minimised again on the planarity constraints, with more weight on limits, and on folds, and on
//! re-entrant corners where the surface is convex. Whether the result is better is for others to
//! say.

use super::path::Path;
use super::reached::Run;
use super::solvers::Solvers;
use crate::optimise::options::{NEWTON_ITERATIONS, OptimiseOptions, StartKind};
use crate::optimise::panels::{FaceShapes, Panels};
use crate::optimise::terms::concavity::{ConcavityTerm, is_concave, to_be_convex};
use crate::optimise::terms::folds::FoldTerm;
use crate::optimise::terms::guard::Breach;
use crate::optimise::terms::setting::Setting;
use crate::optimise::{OptimiseError, Stage};
use crate::progress::Progress;

/// Weight of a fold or a re-entrant corner in the first round, over that of closeness.
const FIRST_WEIGHT: f64 = 1.0;
/// Factor of the weight of limits in the first round: with 2 to 5 meshes come out alike.
const FIRST_FACTOR: f64 = 3.0;
/// Factor of all weights from each round to the next.
const HEAVIER: f64 = 10.0;
/// Last phases that are gone through again where panels fold or are re-entrant, by rounds: limits
/// are met by Newton's method on the constraints, which follows, alone.
const PHASES: [usize; EMPHASES] = [0, 1, 3];

/// Turn of panels against each other, radians, that is free: 85 degrees, since more than 90 is a
/// fold, and a penalty leaves a rest.
pub(crate) const FREE_TURN: f64 = 1.483_529_864_195_180_1;
/// The same where edges can be cut off if they still fold, 88.5 degrees: with 85 panels at the
/// edges of a box leave it by more than the limit, with 89.5 folds are left there.
pub(crate) const FREE_TURN_IN_SEARCH: f64 = 1.5446;
/// Share of the turn that a joint may have which is free: a penalty leaves a rest.
const SPARE: f64 = 0.97;

/// Rounds of rising emphasis.
pub(crate) const EMPHASES: usize = 3;

/// What faces lack besides limits.
pub(in crate::optimise) struct Lack {
    /// Whether faces fold against a neighbour.
    has_folds: bool,
    /// All faces that are to be convex, if one of them is not.
    to_be_convex: Option<Vec<bool>>,
}

impl Lack {
    pub fn at(setting: &Setting<'_>, x: &[f64]) -> Self {
        let (panels, shape) = (setting.panels, FaceShapes::at(setting.panels, x));
        let convex = to_be_convex(setting, &shape);
        let edge = setting.mean_edge;
        let mut faces = 0..panels.n_faces();
        let is_missed = faces.any(|f| convex[f] && is_concave(shape.face(panels, f), edge));
        Self {
            has_folds: has_folds(setting, &shape, x),
            to_be_convex: is_missed.then_some(convex),
        }
    }

    /// Last phases that are gone through again in a round.
    fn phases(&self, round: usize) -> usize {
        match self.has_folds || self.to_be_convex.is_some() {
            true => PHASES[round],
            false => 0,
        }
    }

    /// Gives more weight to what is missing, in a round.
    fn emphasise(&self, path: &mut Path<'_>, round: usize) {
        let rising = HEAVIER.powi(round as i32);
        let heavy = path.weights.closeness.vertex * FIRST_WEIGHT * rising;
        path.weights.limits *= FIRST_FACTOR * rising;
        path.weights.closeness.limit.elastic.weight *= FIRST_FACTOR * rising;
        let edge = path.setting.mean_edge;
        let Some(energy) = path.energy() else { return };
        if let Some(folds) = &mut energy.folds {
            folds.weight = heavy;
        }
        if let Some(faces) = &self.to_be_convex {
            energy.concavity = Some(ConcavityTerm {
                weight: heavy,
                faces: faces.clone(),
                edge,
            });
        }
    }

    /// Solvers for a path that is to be emphasised, and what folds beyond a free turn pay, if there
    /// are any.
    pub fn solvers(
        &self,
        setting: &Setting<'_>,
        x: &[f64],
        free_turn: f64,
    ) -> Result<(Solvers, Option<FoldTerm>), OptimiseError> {
        let panels: &Panels = setting.panels;
        if !self.has_folds {
            return Ok((Solvers::new(panels)?, None));
        }
        let joint = setting.limits.min_dihedral();
        let joint = joint.map(|angle| SPARE * (180.0 - angle).to_radians());
        let free = joint.map_or(free_turn, |turn| turn.min(free_turn));
        let folds = FoldTerm::new(panels, setting.guard, x, free);
        Ok((Solvers::with_folds(panels, &folds)?, Some(folds)))
    }
}

/// Whether faces fold against a neighbour, or meet one in a joint that is too sharp.
fn has_folds(setting: &Setting<'_>, shape: &FaceShapes, x: &[f64]) -> bool {
    let breaches = setting.guard.breaches(setting.panels, shape, x);
    let is_sharp = |angle: f64, faces: &[u32; 2]| {
        let [f, g] = faces.map(|f| shape.normal(f as usize));
        f.angle(&g).to_degrees() > 180.0 - angle
    };
    let mut hinges = setting.guard.hinges().iter();
    let least = setting.limits.min_dihedral();
    breaches.iter().any(|b| matches!(b, Breach::Fold(_)))
        || least.is_some_and(|angle| hinges.any(|faces| is_sharp(angle, faces)))
}

impl Stage<'_> {
    /// One round of emphasis from planar positions, with turns of panels that are free.
    pub(in crate::optimise) fn emphasised(
        &self,
        x: &[f64],
        (round, free_turn): (usize, f64),
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Run, OptimiseError> {
        let options = &OptimiseOptions {
            newton_iterations: options.newton_iterations.or(Some(NEWTON_ITERATIONS)),
            ..options.clone()
        };
        let setting = self.setting(x);
        let lack = Lack::at(&setting, x);
        let (mut solvers, folds) = lack.solvers(&setting, x, free_turn)?;
        let mut path = Path::new(&setting, &mut solvers, x, options, progress)?;
        let now = path.emphasised(x, (&lack, folds), round)?;
        Ok(self.conclude(0, now, path.way(StartKind::Local), options))
    }
}

impl Path<'_> {
    /// One round of emphasis on what faces lack at planar positions.
    pub(in crate::optimise) fn emphasised(
        &mut self,
        x: &[f64],
        (lack, folds): (&Lack, Option<FoldTerm>),
        round: usize,
    ) -> Result<Vec<f64>, OptimiseError> {
        if let Some(energy) = self.energy() {
            energy.folds = folds;
        }
        lack.emphasise(self, round);
        self.again(x, lack.phases(round))
    }
}
