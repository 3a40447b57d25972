//! As few dislocations as a bound on the lattice's strain allows.
//!
//! All of them vanish first. Where that strains the lattice too much, the ways come back along which strain pulls the hardest: moving a Burgers vector changed jumps, and
//! the energy `sum w |r|^2` of the residuals falls by twice the product of residuals and changes when it moves back (the force of Peach and Koehler, summed
//! along the way).

use super::boundary::Pin;
use super::dislocations::{self, Annihilation, annihilate};
use super::lattice::{Charts, Eisenstein, Plane, dot};
use super::seamless::{Offsets, factorised, solve_offsets};
use super::{LayoutError, LayoutOptions};
use crate::directions::intrinsic::IntrinsicMesh;
use phex_mesh::{EdgeId, PerVertex, Topology};
use phex_numeric::{Cholesky, NumericError};

/// Share of the ways that come back at once: the pulls on the others change.
const BACK: f64 = 0.05;

/// The lattice with as few dislocations as the bound on distortion allows, and the 95 % quantile of its distortion.
pub(super) fn seamless_offsets(
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    pins: &PerVertex<Option<Pin>>,
    rounded: Offsets,
    options: &LayoutOptions,
) -> Result<(Offsets, Annihilation, f64), LayoutError> {
    let longest = options.annihilation_length.unwrap_or(f64::INFINITY);
    let (mut annihilation, slips) =
        annihilate(topology, mesh, charts, &mut rounded.jump.clone(), longest);
    let mut taken = vec![true; slips.len()];
    let mut solver = PinnedSolver::new(topology, mesh, charts, pins);
    loop {
        let mut offsets = rounded.clone();
        let changes = dislocations::slip(topology, charts, &mut offsets.jump, &slips, &taken);
        annihilation.moved = taken.iter().filter(|t| **t).count();
        if annihilation.moved > 0 {
            offsets.position = solver.solve(&offsets)?;
        }
        let p95 = distortion(&offsets, topology, mesh, charts);
        if p95 <= options.max_distortion || annihilation.moved == 0 {
            annihilation.kept = dislocations::count(topology, charts, &offsets.jump);
            return Ok((offsets, annihilation, p95));
        }
        let pull = changes
            .iter()
            .map(|c| pull(&offsets, topology, mesh, charts, c));
        let pull: Vec<f64> = pull.collect();
        let mut hardest: Vec<usize> = (0..slips.len()).filter(|k| taken[*k]).collect();
        hardest.sort_by(|a, b| pull[*b].total_cmp(&pull[*a]));
        let back = (BACK * annihilation.moved as f64).ceil() as usize;
        hardest[..back].iter().for_each(|k| taken[*k] = false);
    }
}

/// The 95 % quantile over the edges.
fn distortion(
    offsets: &Offsets,
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
) -> f64 {
    let mut all = offsets.distortion(topology, mesh, charts).into_vec();
    all.sort_by(f64::total_cmp);
    all[all.len() * 95 / 100]
}

/// How hard strain pulls a Burgers vector back along the way on which it changed jumps.
fn pull(
    offsets: &Offsets,
    topology: &Topology,
    mesh: &IntrinsicMesh,
    charts: &Charts,
    changes: &[(EdgeId, Eisenstein)],
) -> f64 {
    let at = |(e, change): &(EdgeId, Eisenstein)| {
        let residual = offsets.residual(topology, charts, *e);
        -mesh.weight[*e] * dot(residual, change.to_plane())
    };
    changes.iter().map(at).sum()
}

/// Offsets solved first without pins, to see where the boundary's rows come to lie, and then with those. The factorisations do not depend
/// on the jumps and are made once.
struct PinnedSolver<'a> {
    topology: &'a Topology,
    mesh: &'a IntrinsicMesh,
    charts: &'a Charts,
    pins: &'a PerVertex<Option<Pin>>,
    free: PerVertex<Option<Pin>>,
    /// Without pins, and with them if there are any.
    factors: Option<(Cholesky, Option<Cholesky>)>,
}

impl<'a> PinnedSolver<'a> {
    fn new(
        topology: &'a Topology,
        mesh: &'a IntrinsicMesh,
        charts: &'a Charts,
        pins: &'a PerVertex<Option<Pin>>,
    ) -> Self {
        Self {
            topology,
            mesh,
            charts,
            pins,
            free: PerVertex::filled(topology.n_vertices(), None),
            factors: None,
        }
    }

    fn factorise(&self) -> Result<(Cholesky, Option<Cholesky>), NumericError> {
        let factor =
            |pins, earlier| factorised(self.topology, self.mesh, self.charts, pins, earlier);
        let free = factor(&self.free, None)?;
        let pinned = match self.pins.iter().any(Option::is_some) {
            true => Some(factor(self.pins, Some(free.analysis()?))?),
            false => None,
        };
        Ok((free, pinned))
    }

    fn solve(&mut self, offsets: &Offsets) -> Result<PerVertex<Plane>, NumericError> {
        let (free, pinned) = match self.factors.take() {
            Some(factors) => factors,
            None => self.factorise()?,
        };
        let solve = |pins, near: &_, factor: &_| {
            let Self {
                topology,
                mesh,
                charts,
                ..
            } = &*self;
            solve_offsets(topology, mesh, charts, &offsets.jump, pins, near, factor)
        };
        let mut position = solve(&self.free, &offsets.position, &free);
        if let Some(pinned) = &pinned {
            for _ in 0..2 {
                position = solve(self.pins, &position, pinned);
            }
        }
        self.factors = Some((free, pinned));
        Ok(position)
    }
}
