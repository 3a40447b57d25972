//! Retries at the end of a run on a mesh that no search follows: emphasis on what panels lack,
//! group by group, kept if less is wrong, or the same with more room, and nothing stands off
//! farther.

use super::emphasis::{EMPHASES, Lack};
use crate::optimise::error::OptimiseError;
use crate::optimise::options::NEWTON_ITERATIONS;
use crate::optimise::panels::{FaceShapes, Panels};
use crate::optimise::parts::{Part, with_neighbours};
use crate::optimise::path::Path;
use crate::optimise::reached::Reached;

/// Share of a limit which a panel may lack without being tried again: retries end half-way to a
/// minimum, which is not worth while for less.
const LITTLE: f64 = 0.35;
/// Rings of faces around a panel that count as its surroundings; two more move along.
const RINGS: usize = 2;
/// Deviation, in mean edges, that more room may always cost.
const NEAR: f64 = 0.018;
/// Relative difference that is rounding.
const ROUNDING: f64 = 1e-9;

/// Groups of faces that hang together.
fn groups(panels: &Panels, mut faces: Vec<u32>) -> Vec<Vec<u32>> {
    let mut groups = Vec::new();
    while let Some(first) = faces.pop() {
        let mut group = vec![first];
        loop {
            let around = with_neighbours(panels, &group);
            let (near, far) = faces.iter().partition(|f| around.binary_search(f).is_ok());
            faces = far;
            let near: Vec<u32> = near;
            if near.is_empty() {
                break;
            }
            group.extend(near);
        }
        group.sort_unstable();
        groups.push(group);
    }
    groups
}

impl Path<'_> {
    /// Goes on from planar positions where panels lack something.
    pub fn retry(&mut self, reached: Reached) -> Result<Reached, OptimiseError> {
        let mut x = reached.x;
        let lack = Lack::at(self.setting, &x);
        let faces = 0..self.setting.panels.n_faces();
        let lacking = faces.filter(|f| lack.of(*f, LITTLE)).map(|f| f as u32);
        for group in groups(self.setting.panels, lacking.collect()) {
            if !self.is_over() {
                self.retry_group(&group, &mut x)?;
            }
        }
        Ok(Reached::at(self.setting, x))
    }

    fn retry_group(&mut self, group: &[u32], x: &mut [f64]) -> Result<(), OptimiseError> {
        let wider = |core: Vec<u32>, _| with_neighbours(self.setting.panels, &core);
        let surroundings = (0..RINGS).fold(group.to_vec(), wider);
        let part = Part::around(self.setting, &surroundings, x);
        let setting = part.setting(self.setting.mean_edge);
        let anchor = part.of_vertices(self.start);
        let options = crate::optimise::OptimiseOptions {
            newton_iterations: self.options.newton_iterations.or(Some(NEWTON_ITERATIONS)),
            ..self.options.clone()
        };
        let mut best = part.of_vertices(x);
        for round in 0..EMPHASES {
            let lack = Lack::at(&setting, &best);
            let (mut solvers, folds) = lack.solvers(&setting, &best)?;
            let mut path = Path::new(&setting, &mut solvers, &anchor, &options, &self.reporter)?;
            path.weights = self.weights;
            path.barriers = part.of_faces(&self.barriers);
            let now = path.emphasised(&best, (&lack, folds), round)?;
            let status = path.outcome.status;
            let over = path.is_over();
            let made = path.in_parts + path.outcome.factorisations;
            self.in_parts += made;
            if over {
                self.outcome.status = status;
                break;
            }
            let after = Lack::at(&setting, &now);
            let near = lack.farthest.max(NEAR * setting.mean_edge) * (1.0 + ROUNDING);
            let height = FaceShapes::at(setting.panels, &now).max_height();
            let planar = height <= options.planarity_tolerance * setting.mean_edge;
            let ((wrong, room), (before, less)) = (after.total(), lack.total());
            let roomier = wrong == before && room * (1.0 + ROUNDING) < less;
            if planar && (wrong < before || (roomier && after.farthest <= near)) {
                best = now;
            }
            if after.total() == (0, 0.0) {
                break;
            }
        }
        part.write_back(&best, x);
        Ok(())
    }
}
