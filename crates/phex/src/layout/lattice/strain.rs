//! As few dislocations as a bound on the lattice's strain allows.
//!
//! All of them vanish first. Where that strains the lattice too much, here or anywhere, the ways
//! come back along which strain pulls the hardest: moving a Burgers vector changed jumps, and the
//! energy `sum w |r|^2` of the residuals falls by twice the product of residuals and changes when
//! it moves back (the force of Peach and Koehler, summed along the way).

use super::chart_graph::{ChartGraph, Combing};
use super::charted::ChartedSurface;
use super::dislocations::{self, Annihilation, annihilate};
use super::eisenstein::{Eisenstein, Plane, dot};
use super::seamless::{OffsetSystem, Offsets, translate};
use crate::layout::{LayoutError, LayoutOptions, unless_cancelled};
use crate::progress::Progress;
use phex_mesh::{EdgeId, PerVertex};
use phex_numeric::NumericError;

/// Shares of the ways that come back at once, at least and at the most: the pulls on the others
/// change.
const BACK: [f64; 2] = [0.05, 0.2];
/// Share that comes back of what would be enough if distortion went on falling as it last did.
const CAUTION: f64 = 0.5;

/// The lattice with as few dislocations as the bound on distortion allows, and the 95 % quantile of
/// its distortion.
pub(in crate::layout) fn seamless_offsets(
    charted: &ChartedSurface<'_>,
    rounded: Offsets,
    options: &LayoutOptions,
    progress: &dyn Progress,
) -> Result<(Offsets, Annihilation, f64), LayoutError> {
    let longest = options.annihilation_length.unwrap_or(f64::INFINITY);
    let (mut annihilation, slips) = annihilate(charted, &mut rounded.jump.clone(), longest);
    let mut taken = vec![true; slips.len()];
    let mut solver = PinnedSolver {
        charted: *charted,
        system: None,
    };
    let mut last: Option<(usize, f64)> = None;
    loop {
        unless_cancelled(progress)?;
        let mut offsets = rounded.clone();
        let changes = dislocations::slip(charted, &mut offsets.jump, &slips, &taken);
        annihilation.moved = taken.iter().filter(|t| **t).count();
        if annihilation.moved > 0 {
            offsets.position = solver.solve(&offsets)?;
        }
        let p95 = distortion(&offsets, charted);
        let pull = changes.iter().map(|c| pull(&offsets, charted, c));
        let pull: Vec<f64> = pull.collect();
        let mut hardest: Vec<usize> = (0..slips.len()).filter(|k| taken[*k]).collect();
        hardest.sort_by(|a, b| pull[*b].total_cmp(&pull[*a]));
        let hard = |most: f64| hardest.first().is_some_and(|k| pull[*k] > most);
        let is_calm = !options.max_pull.is_some_and(hard);
        if (p95 <= options.max_distortion && is_calm) || annihilation.moved == 0 {
            annihilation.kept = dislocations::count(charted, &offsets.jump);
            return Ok((offsets, annihilation, p95));
        }
        let now = (annihilation.moved, p95);
        let enough = last.map_or(0.0, |last| missing(last, now, options.max_distortion));
        let [least, most] = BACK.map(|share| share * annihilation.moved as f64);
        let back = (CAUTION * enough).clamp(least, most).ceil() as usize;
        hardest[..back].iter().for_each(|k| taken[*k] = false);
        last = Some(now);
    }
}

/// How many ways more would have to come back for a distortion of `goal` if it went on falling as
/// it did from one number of ways and distortion to another; 0 if it did not.
fn missing(before: (usize, f64), now: (usize, f64), goal: f64) -> f64 {
    let of_each = (before.1 - now.1) / (before.0 - now.0).max(1) as f64;
    match of_each > 0.0 && now.1 > goal {
        true => (now.1 - goal) / of_each,
        false => 0.0,
    }
}

/// The 95 % quantile over the edges.
fn distortion(offsets: &Offsets, charted: &ChartedSurface<'_>) -> f64 {
    let mut all = offsets.distortion(charted).into_vec();
    let rank = all.len() * 95 / 100;
    *all.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// How hard strain pulls a Burgers vector back along the way on which it changed jumps.
fn pull(offsets: &Offsets, charted: &ChartedSurface<'_>, changes: &[(EdgeId, Eisenstein)]) -> f64 {
    let at = |(e, change): &(EdgeId, Eisenstein)| {
        let residual = offsets.residual(charted, *e);
        -charted.mesh.weight[*e] * dot(residual, change.to_plane())
    };
    changes.iter().map(at).sum()
}

/// Offsets that fit jumps best. Those that are pinned to the boundary's rows are solved for roughly
/// first, without pins, to see where rows come to lie. The factorisation does not depend on the
/// jumps and is made once.
struct PinnedSolver<'a> {
    charted: ChartedSurface<'a>,
    system: Option<OffsetSystem<'a>>,
}

impl PinnedSolver<'_> {
    fn solve(&mut self, offsets: &Offsets) -> Result<PerVertex<Plane>, NumericError> {
        let system = match self.system.take() {
            Some(system) => system,
            None => OffsetSystem::new(self.charted)?,
        };
        let solve = |near: &_| system.solve(&offsets.jump, near);
        let position = match self.charted.pins.iter().any(Option::is_some) {
            true => solve(&solve(&self.rough_positions(offsets)?)),
            false => solve(&offsets.position),
        };
        self.system = Some(system);
        Ok(position)
    }

    /// Positions without pins, solved for on groups of vertices.
    fn rough_positions(&self, offsets: &Offsets) -> Result<PerVertex<Plane>, NumericError> {
        let topology = self.charted.topology;
        let free = ChartedSurface {
            charts: &self.charted.charts.with_jumps(&offsets.jump),
            pins: &PerVertex::filled(topology.n_vertices(), None),
            ..self.charted
        };
        let combing = Combing::new(topology, free.charts);
        let (groups, members) = ChartGraph::new(&free, &combing).coarse();
        let of_group = groups.best_positions()?;
        let position = members.iter().map(|m| m.of(&of_group));
        let mut position = combing.restored(position);
        translate(&self.charted, &offsets.position, &mut position);
        Ok(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_missing_follows_the_last_fall() {
        assert!((missing((10, 0.8), (8, 0.6), 0.4) - 2.0).abs() < 1e-12);
        assert_eq!(missing((10, 0.6), (8, 0.8), 0.4), 0.0, "it has risen");
        assert_eq!(missing((10, 0.8), (8, 0.3), 0.4), 0.0, "it is enough");
    }
}
