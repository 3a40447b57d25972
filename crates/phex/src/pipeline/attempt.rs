//! What is told and decided of one member of the portfolio.

use super::options::{Candidate, MeshOptions, Method};
use crate::quality::{Merit, USUAL_DEVIATION};
use phex_mesh::{HexMesh, Vec3};
use serde::Serialize;

/// Excess over limits, in limits and summed over panels, that is left to the search.
const CURABLE: f64 = 2.0;
/// Standard deviations between the 5 % and the 95 % quantile of what is normally distributed.
const BETWEEN_QUANTILES: f64 = 3.29;

/// One member of the portfolio, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttemptSummary {
    /// How its panels were laid out.
    #[serde(flatten)]
    pub candidate: Candidate,
    /// Panels.
    pub panels: usize,
    /// What it is compared by.
    pub merit: Merit,
    /// Share of hexagons among the panels inside.
    pub hex: f64,
    /// Panels inside that are no hexagons, beyond those that the topology of a closed surface asks
    /// for.
    pub irregular: usize,
    /// Dislocations that the lattice kept.
    pub dislocations: usize,
    /// Whether a lattice could do without any irregular panel but those that topology asks for: on
    /// closed surfaces of Euler characteristic 0, and where the Gauss curvature is positive
    /// everywhere.
    pub regular_possible: bool,
    /// Least clearance, mean edges.
    pub clearance: f64,
    /// Least angle at a corner, degrees.
    pub least_angle: f64,
    /// Largest distance between panels and surface, over the diagonal.
    pub distance_rel: f64,
    /// 95 % over 5 % quantile of the areas of the panels inside; `None` where there are none.
    pub area_spread: Option<f64>,
    /// Whether it was made for the usual largest deviation, since a tighter one was missed.
    pub usual_deviation: bool,
    /// Whether it is the one that was kept.
    pub kept: bool,
    /// The panels as they were compared, before any search; model units.
    #[serde(skip)]
    pub mesh: HexMesh,
}

impl AttemptSummary {
    pub(super) fn new(
        candidate: Candidate,
        mesh: &HexMesh,
        merit: Merit,
        regular_possible: bool,
        options: &MeshOptions,
    ) -> Self {
        let measures = phex_mesh::measure(mesh);
        Self {
            candidate,
            panels: mesh.topology().n_faces(),
            merit,
            hex: measures.hex.unwrap_or(1.0),
            irregular: measures.irregular,
            dislocations: 0,
            regular_possible,
            clearance: measures.clearance.min,
            least_angle: measures.angle.min,
            distance_rel: merit.off * options.limits().deviation_rel.unwrap_or(USUAL_DEVIATION),
            area_spread: measures.evenness.map(|e| e.area_spread),
            usual_deviation: false,
            kept: false,
            mesh: mesh.clone(),
        }
    }

    /// The same, made for the usual largest deviation.
    pub(super) fn for_usual_deviation(self) -> Self {
        Self {
            usual_deviation: true,
            ..self
        }
    }

    /// The merit before a search, which cures what is broken like what is outside limits, but
    /// evens no sizes out: those of a lattice that nobody asked to have large and small panels
    /// count as if they were outside limits. Bricks have no areas wished for and are judged by
    /// their spread, or they would count as even whatever their sizes.
    pub(super) fn before_search(&self) -> Merit {
        let merit = match self.candidate.method {
            Method::BrickWall => {
                let deviation = self.spread() / BETWEEN_QUANTILES;
                self.merit.counting_uneven(deviation.powi(2))
            }
            _ => self.merit,
        };
        merit.before_search(self.spread().powi(2))
    }

    /// What is outside limits, with sizes that nobody asked for counted as if they were.
    pub(super) fn outside_or_uneven(&self) -> f64 {
        self.merit.invalid + self.merit.outside + self.spread().powi(2)
    }

    /// Logarithm of the spread of areas.
    fn spread(&self) -> f64 {
        self.area_spread.unwrap_or(1.0).ln()
    }

    /// The same with the panels in model coordinates.
    pub(super) fn restored(mut self, restore: impl Fn(Vec3) -> Vec3) -> Self {
        self.mesh = self.mesh.mapped(|p| restore(*p));
        self
    }

    /// What else is worth a try: a lattice without dislocations where one can be, or one with sizes
    /// that resolve the surface where the options leave sizes free. `None` if this one is within
    /// limits, and as regular as can be.
    pub(super) fn alternative(&self, options: &MeshOptions) -> Option<Candidate> {
        let seamless = self.regular_possible && self.irregular > 0 && !self.candidate.seamless;
        let much = self.merit.invalid > 0.0 || self.merit.outside > CURABLE;
        let resolving = self.candidate.resolving(options).is_some() && much;
        (seamless || resolving).then_some(Candidate {
            seamless: self.candidate.seamless || (seamless && !resolving),
            resolving,
            ..self.candidate
        })
    }
}

impl Candidate {
    /// The same with sizes that resolve the surface, where the options leave sizes free.
    pub(super) fn resolving(self, options: &MeshOptions) -> Option<Self> {
        let is_lattice = self.method == Method::Lattice;
        (is_lattice && !options.varies_sizes()).then_some(Self {
            resolving: true,
            ..self
        })
    }
}

/// Whether a largest deviation is asked for that is tighter than usual; in single precision the
/// usual one itself is a little less.
pub(super) fn is_tight(options: &MeshOptions) -> bool {
    let limit = options.optimise.max_deviation;
    limit.is_some_and(|limit| limit < (1.0 - 1e-6) * USUAL_DEVIATION)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The summary of a member of some method, spread and merit.
    fn summary(method: Method, spread: f64, merit: Merit) -> AttemptSummary {
        let candidate = Candidate {
            method,
            ..Candidate::first(&MeshOptions::default())
        };
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let mesh = HexMesh::new(corners.to_vec(), &[[0, 1, 2]]).unwrap();
        AttemptSummary {
            area_spread: Some(spread),
            ..AttemptSummary::new(candidate, &mesh, merit, false, &MeshOptions::default())
        }
    }

    /// A cone had areas of 1 : 29 that were within limits, where the others were outside of them
    /// before their search.
    #[test]
    fn sizes_that_jump_count_as_much_as_limits() {
        let jumps = |spread, outside| {
            let merit = Merit {
                outside,
                ..Merit::default()
            };
            summary(Method::Lattice, spread, merit).outside_or_uneven()
        };
        assert!(jumps(2.1, 3.0) < jumps(29.0, 0.0));
        assert!(jumps(1.5, 3.0) > jumps(2.1, 0.0));
    }

    /// A catenoid had bricks with areas of 1 : 2.4 for a tenth less of cost, in which their areas
    /// did not count.
    #[test]
    fn uneven_bricks_are_not_better_than_an_even_lattice() {
        let made = |method, spread, cost| {
            let merit = Merit {
                cost,
                ..Merit::default()
            };
            summary(method, spread, merit).before_search()
        };
        let lattice = made(Method::Lattice, 1.1, 0.46);
        assert!(!made(Method::BrickWall, 2.4, 0.41).is_better(&lattice));
        assert!(made(Method::BrickWall, 1.1, 0.41).is_better(&lattice));
    }
}
