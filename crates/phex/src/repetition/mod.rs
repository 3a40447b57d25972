//! Repetition: edges of a valid mesh made equal within a tolerance, so that fewer different ones
//! have to be made.
//!
//! Lengths are put into as few clusters as can be hoped for, each edge is drawn to the mean of its
//! cluster, vertices move along the surface (and off it as far as the largest deviation allows),
//! and clusters are formed anew:
//!
//! ```text
//! minimise E + w_e/2 sum (l_e - L_c(e))^2,   w_e = 1, 10, 100, 1000
//! ```
//!
//! | symbol | here | meaning |
//! |---|---|---|
//! | `E` | [`crate::optimise`] | closeness, fairness, room, limits |
//! | `l_e`, `L_c` | `shared::SharedLengths` | length of an edge, and of the cluster that it belongs to |
//! | `w_e` | `WEIGHTS` | weight of lengths over that of closeness |
//!
//! How many clusters are possible is found by bisection. What counts is the figure of
//! [`DistinctParts`]: the least number of intervals, as wide as the tolerance, that hold all
//! lengths.
//!
//! Why edges: hexagons of a mesh with three panels at each vertex have `3 F` edges and, once they
//! are planar, `3 F` degrees of freedom, so every edge can be led to a length near its own. Angles
//! and whole panels would need three times as many: they are counted, and become equal only where
//! symmetry makes them so.
//!
//! *Guaranteed*: no more is invalid or outside a limit than before (the share of the surface that
//! is covered among them), planarity is what it was, and
//! there are no more distinct lengths; where nothing can be had the mesh is the same to the last
//! bit. The same result for any number of threads.
//!
//! *Fails* where few edges are alike to begin with (many irregular panels, panels of many sizes)
//! and the surface may not be left: then little is had, and told. Meshes of more than 8,000 panels
//! are left as they are.
//!
//! Source: shared targets after Fu, Lai, He and Cohen-Or, "K-set tilable surfaces" (2010), for
//! edges instead of panels; the least number of intervals is Gavril's greedy cover (1972).

mod distinct;
mod shared;

pub use distinct::{DistinctParts, Repetition};

use crate::optimise::{KeptVertices, LengthStage, OptimiseError, Quotient, Steering, Target};
use crate::progress::{Event, Progress};
use crate::quality::Merit;
use crate::search::Site;
use phex_mesh::HexMesh;
use shared::{SharedLengths, distinct_lengths, lengths};

/// Weights of lengths, over that of the closeness of vertices, one after the other.
const WEIGHTS: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];
/// Numbers of clusters that are tried at the most.
const TRIALS: usize = 6;
/// Factor by which distinct lengths may be more than the clusters that were asked for.
const NEARLY: f64 = 1.2;

/// A mesh and what it is drawn to.
pub(crate) struct RepetitionTask<'a> {
    /// The judge, the boundary, and the options.
    pub site: &'a Site<'a>,
    /// What meshes are compared by: a symmetric one as a whole, and not the part that generates it.
    pub merit: &'a dyn Fn(&HexMesh) -> Merit,
    /// The surface.
    pub target: &'a dyn Target,
    /// Images that are no unknowns.
    pub quotient: &'a Quotient,
    /// What the user holds.
    pub steering: &'a Steering,
    /// Width of the intervals, in the unit of the mesh.
    pub tolerance: f64,
}

impl RepetitionTask<'_> {
    /// Panels of a mesh at the most.
    pub const MOST_PANELS: usize = LengthStage::MOST_PANELS;

    /// The mesh with as few distinct edge lengths as are found.
    ///
    /// # Errors
    /// If the mesh can't be held as it is to be.
    pub fn repeated(
        &self,
        mesh: HexMesh,
        progress: &dyn Progress,
    ) -> Result<HexMesh, OptimiseError> {
        let kept = KeptVertices {
            hold: self.site.hold.as_ref(),
            quotient: self.quotient,
            steering: self.steering,
            distance: self.site.judge.largest_distance(),
        };
        let mut stage = LengthStage::new(&mesh, self.target, &kept, self.site.options)?;
        let before = (self.merit)(&mesh);
        let mut best = mesh.clone();
        let (mut few, mut many) = (0, distinct_lengths(&mesh, self.tolerance));
        let (mut is_same, mut any_fewer) = (true, false);
        for done in 0..TRIALS {
            let wanted = (few + many) / 2;
            if wanted == few || progress.is_cancelled() {
                break;
            }
            progress.report(&Event::Counted {
                stage: "repetition",
                done,
                total: TRIALS,
            });
            let steps = self.drawn(&mut stage, &best, wanted, progress)?;
            let counted = steps
                .into_iter()
                .map(|m| (distinct_lengths(&m, self.tolerance), m));
            let mut fewer: Vec<(usize, HexMesh)> = counted.filter(|(n, _)| *n < many).collect();
            fewer.sort_by_key(|(n, _)| *n);
            any_fewer |= !fewer.is_empty();
            let found = fewer
                .into_iter()
                .find(|(_, m)| (self.merit)(m).is_no_worse(&before));
            let is_near = |n: usize| n as f64 <= NEARLY * wanted as f64;
            if !found.as_ref().is_some_and(|(n, _)| is_near(*n)) {
                few = wanted;
            }
            if let Some((n, mesh)) = found {
                (best, many, is_same) = (mesh, n, false);
            }
        }
        if is_same && !progress.is_cancelled() {
            let message = match any_fewer {
                true => {
                    "edges are left as they are: with fewer different lengths more would be invalid or outside a limit"
                }
                false => {
                    "edges are left as they are: no fewer different lengths were found within this tolerance"
                }
            };
            progress.report(&Event::Note {
                message: message.to_owned(),
            });
        }
        Ok(best)
    }

    /// The mesh with its edges drawn to so many clusters, with growing weights, the last one with
    /// its edges as near to them as can be.
    fn drawn(
        &self,
        stage: &mut LengthStage<'_>,
        from: &HexMesh,
        clusters: usize,
        progress: &dyn Progress,
    ) -> Result<Vec<HexMesh>, OptimiseError> {
        let mut shared = SharedLengths::new(&lengths(from), clusters);
        let mut now = from.clone();
        let mut steps = Vec::new();
        for weight in WEIGHTS {
            now = stage.drawn(&now, &shared.targets(&now), weight, progress)?;
            steps.push(now.clone());
            shared.settle(&lengths(&now));
            if progress.is_cancelled() || shared.spread(&now) <= 0.5 * self.tolerance {
                break;
            }
        }
        Ok(steps)
    }
}
