//! Options of the optimiser.

use crate::ranges::{self, BadOption};
use phex_mesh::PanelLimits;
use phex_mesh::measure::WANTED_ANGLE;
use phex_numeric::DampedOptions;
use serde::{Deserialize, Serialize};

/// How panels are made planar.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Solver {
    /// Distances to the faces' planes, with a barrier that keeps panels simple, and an exact
    /// projection at the end.
    #[default]
    Barrier,
    /// The paper's: volumes of all four corners of a face, penalised. Nothing keeps panels simple;
    /// for comparison.
    Tetrahedra,
}

/// A start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartKind {
    /// The cells of the layout, smoothed on the surface until every one is simple.
    SmoothedCells,
    /// Those, moved towards the points where the tangent planes of three faces meet.
    Circumcentres,
    /// The mesh as it was given.
    AsGiven,
    /// A part of a mesh with its panels joined anew, smoothed on the surface.
    Local,
}

/// The way from a start to planar panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PathKind {
    /// Projection alone: the mesh was nearly planar.
    Projection,
    /// Sequential quadratic programming on the dual from the circumcentres.
    Fast,
    /// Rising penalties with the barrier, then the projection.
    Feasible,
    /// The paper's solver.
    Tetrahedra,
}

/// Options of [`optimise`](super::optimise) and [`planarize`](super::planarize).
///
/// All weights are relative to that of the closeness of vertices; energies are squares of lengths.
/// The defaults were measured on real surfaces at 250 to 2500 panels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct OptimiseOptions {
    /// How panels are made planar.
    pub solver: Solver,
    /// `w_c`: closeness of vertices to the surface, > 0.
    pub vertex_closeness: f64,
    /// `w_cf`: closeness of face centres, >= 0. Without it the middle of large convex panels stands
    /// off by 0.5 % of the model; from 10 on planarity suffers.
    pub centre_closeness: f64,
    /// `w_bd`: closeness of boundary vertices to the boundary curve, >= 0.
    pub boundary_closeness: f64,
    /// `w_k`: closeness of boundary corners to where they start, >= 0. Corners that can't move at
    /// all would bend their panels.
    pub corner_closeness: f64,
    /// `w_s`: likeness of neighbouring hexagons, and central symmetry of panels with an even number
    /// of corners, >= 0. From 2e-3 on areas differ more, 0 costs a sixth of the sharpest angles.
    pub fairness: f64,
    /// `w_a`: areas of panels as they are wished for, >= 0. From 5e-2 on clearances suffer, 0
    /// lets areas differ by a factor of three.
    pub evenness: f64,
    /// `w_t`: hold on the start, > 0; it decides where nothing else does, as along the surface.
    pub anchor: f64,
    /// `w_b`: barrier, over the square of the edge of a regular hexagon of the panel's area; 3e-2
    /// to 1e-1. Below 1e-3 panels may come to touch themselves.
    pub barrier: f64,
    /// `tau`: distance at which the barrier begins, over the square root of the panel's area, in
    /// (0, 0.5].
    pub barrier_reach: f64,
    /// Iterations of a phase at the most.
    pub max_iterations: usize,
    /// Relative decrease of the energy that ends a phase.
    pub energy_tolerance: f64,
    /// Step, in mean edges, that ends a phase.
    pub step_tolerance: f64,
    /// Iterations of Newton's method on the constraints at the most, once panels are planar. The
    /// first few bring what can be seen; a minimum to the last digits (steps of 1e-9 mean edges)
    /// takes 50 to 100. By default 6 for a mesh that is kept close to itself, and none with a
    /// surface or part by part, where they were not seen to help.
    pub newton_iterations: Option<usize>,
    /// Largest distance of a corner to its face's plane, in mean edges, that counts as planar. The
    /// projection goes to the floor of rounding where it can, whatever this is; where it can't,
    /// nothing else is tried once this is met.
    pub planarity_tolerance: f64,
    /// Distance to the surface, over the diagonal of the mesh, that vertices and panel centres are
    /// not to exceed, > 0: panels that do are optimised again with stronger closeness. `None`: no
    /// bound.
    pub max_deviation: Option<f64>,
    /// What a workshop can make: inequalities, lengths in the unit of the mesh.
    pub panels: PanelLimits,
    /// `w_l`: inequalities, over the areas of their panels, >= 0: what an excess as large as the
    /// limit itself costs. From 0.1 on distances to the surface grow by more than a tenth.
    pub limits: f64,
    /// Least clearance of panels, over what is wanted of them, >= 0; an inequality, too.
    pub wished_clearance: f64,
    /// Least angle at corners, degrees, in [0, 180]: an inequality, too, which sharp corners of the
    /// boundary and asymptotic rows can't meet.
    pub wished_angle: f64,
    /// Cosine between the normals of a panel and of the surface at its cell below which it counts
    /// as flipped.
    pub least_side: f64,
    /// Smoothing steps of the start: at least the first, at most the second number.
    pub smoothing: [usize; 2],
}

impl Default for OptimiseOptions {
    fn default() -> Self {
        Self {
            solver: Solver::Barrier,
            vertex_closeness: 1.0,
            centre_closeness: 3.0,
            boundary_closeness: 3.0,
            corner_closeness: 3.0,
            fairness: 1e-3,
            evenness: 2e-2,
            anchor: 1e-4,
            barrier: 5e-2,
            barrier_reach: 0.3,
            max_iterations: 15,
            energy_tolerance: 3e-2,
            step_tolerance: 1e-3,
            newton_iterations: None,
            planarity_tolerance: 1e-12,
            max_deviation: None,
            panels: PanelLimits::default(),
            limits: 2e-2,
            wished_clearance: 1.15,
            wished_angle: WANTED_ANGLE,
            least_side: 0.1,
            smoothing: [3, 40],
        }
    }
}

/// Factor to which a dial goes at the most, and one over it at the least.
const FARTHEST_DIAL: f64 = 1e6;
/// Reach of the barrier to which the dial goes at the most.
const FARTHEST: f64 = 0.45;

/// What designers turn: factors of the weights, 1 each by default.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dials {
    /// Panels like their neighbours, > 0: `w_s`.
    pub fairness: f64,
    /// Nearness to surface and boundary, > 0: `w_c`, `w_cf`, `w_bd`, `w_k`.
    pub closeness: f64,
    /// Room within panels, > 0: the barrier `w_b`, and by its eighth root the reach `tau`.
    pub clearance: f64,
    /// Nearness of panel centres against that of corners, >= 0: `w_cf`. At 0 the corners come to
    /// lie on the surface, and the middle of convex panels stands off by all of its sagitta.
    pub centres: f64,
}

impl Default for Dials {
    fn default() -> Self {
        Self {
            fairness: 1.0,
            closeness: 1.0,
            clearance: 1.0,
            centres: 1.0,
        }
    }
}

impl Dials {
    /// Refuses dials that are turned so far that one weight drowns the others.
    ///
    /// # Errors
    /// The first of them that is not finite or out of its range.
    pub fn check(&self) -> Result<(), BadOption> {
        let turned = [
            ("fairness", self.fairness),
            ("closeness", self.closeness),
            ("clearance", self.clearance),
        ];
        ranges::within(1.0 / FARTHEST_DIAL..=FARTHEST_DIAL, &turned)?;
        ranges::within(0.0..=FARTHEST_DIAL, &[("centres", self.centres)])
    }

    /// Multiplies the weights of the options.
    pub fn turn(&self, options: &mut OptimiseOptions) {
        options.fairness *= self.fairness;
        options.vertex_closeness *= self.closeness;
        options.centre_closeness *= self.closeness * self.centres;
        options.boundary_closeness *= self.closeness;
        options.corner_closeness *= self.closeness;
        // The barrier is relative to the closeness of vertices.
        options.barrier *= self.clearance / self.closeness;
        options.limits *= self.clearance / self.closeness;
        // Weight alone hardly moves panels apart.
        let reach = options.barrier_reach * self.clearance.powf(0.125);
        options.barrier_reach = reach.min(options.barrier_reach.max(FARTHEST));
    }
}

/// `w_p`: weights of planarity, rising; each is a phase.
pub(super) const PENALTIES: [f64; 4] = [1.0, 30.0, 1e3, 1e4];
/// Clearance, in mean edges, that the final projection keeps (or half of what a panel has, if that
/// is less); a result below it is tried again with a stronger barrier.
pub(super) const KEPT_CLEARANCE: f64 = 0.1;
/// Iterations of the final projection at the most.
pub(super) const PROJECTION_ITERATIONS: usize = 20;
/// Weight of the anchor, at least, where there is no surface and the mesh stands for itself: at
/// 1e-4 vertices slide by an edge and more, at 0.1 by half an edge at the most; from 1 on panels
/// keep off their old planes.
pub const START_CLOSENESS: f64 = 0.1;
/// Iterations of Newton's method on the constraints for a mesh that is kept close to itself and
/// minimised as a whole, and for tight panels of a finished mesh.
pub(super) const NEWTON_ITERATIONS: usize = 6;
/// Iterations of Newton's method in a sequence of refined meshes: what phases of penalties leave
/// falls slower than the size.
const REFINED_NEWTON: usize = 15;

impl OptimiseOptions {
    /// Weights for a mesh in a sequence whose panels become smaller, here by `factor`, so that
    /// Theorem 1 of Wang and Liu holds in the limit.
    ///
    /// The theorem takes faces that converge to tangent planes. Distances to the surface fall with
    /// the square of the size `L`, lengths within panels with `L`: with fixed weights fairness and
    /// barrier win, and tilt planes by a share of `L` that stays. So closeness grows as `L^-2`.
    /// Where a row of panels runs along an asymptotic direction, panels that are inscribed in the
    /// indicatrix have an edge without length, which a barrier of fixed reach never allows: its
    /// reach shrinks as `L^(1/2)`. Panels of the whole sequence stay simple, but have ever less
    /// clearance there: for studies of the limit, not for building. Areas, room and corners are
    /// left free, since what holds them tilts planes as fairness does.
    pub fn refined(mut self, factor: f64) -> Self {
        let dials = Dials {
            closeness: factor * factor,
            ..Dials::default()
        };
        dials.turn(&mut self);
        self.barrier_reach /= factor.sqrt();
        self.evenness = 0.0;
        (self.wished_clearance, self.wished_angle) = (0.0, 0.0);
        self.newton_iterations = Some(REFINED_NEWTON);
        self
    }

    /// When a phase with a penalty ends.
    pub(crate) fn phase(&self, penalty: f64) -> DampedOptions {
        DampedOptions {
            max_iterations: self.max_iterations,
            energy_tolerance: self.energy_tolerance,
            step_tolerance: self.step_tolerance,
            phase: penalty,
        }
    }

    /// What a workshop can make, as far as panels of a mean area can keep it, and corners as blunt
    /// as is wished for.
    pub(crate) fn panel_limits(&self, mean_area: f64) -> PanelLimits {
        let wished = Some(self.wished_angle).filter(|angle| *angle > 0.0);
        let least = [self.panels.min_angle, wished].into_iter().flatten();
        PanelLimits {
            min_angle: least.max_by(f64::total_cmp),
            ..self.panels.within_reach(mean_area)
        }
    }

    /// Refuses values that have no meaning.
    pub(crate) fn check(&self) -> Result<(), BadOption> {
        ranges::positive(&[("max_deviation", self.max_deviation.unwrap_or(1.0))])?;
        limits_fit(&self.panels).map_err(|e| e.in_table("panels"))?;
        ranges::positive(&[
            ("vertex_closeness", self.vertex_closeness),
            ("anchor", self.anchor),
            ("barrier", self.barrier),
            ("planarity_tolerance", self.planarity_tolerance),
        ])?;
        ranges::not_negative(&[
            ("centre_closeness", self.centre_closeness),
            ("boundary_closeness", self.boundary_closeness),
            ("corner_closeness", self.corner_closeness),
            ("fairness", self.fairness),
            ("evenness", self.evenness),
            ("energy_tolerance", self.energy_tolerance),
            ("step_tolerance", self.step_tolerance),
            ("limits", self.limits),
            ("wished_clearance", self.wished_clearance),
        ])?;
        ranges::within(-1.0..=1.0, &[("least_side", self.least_side)])?;
        ranges::within(
            f64::MIN_POSITIVE..=0.5,
            &[("barrier_reach", self.barrier_reach)],
        )?;
        ranges::within(0.0..=180.0, &[("wished_angle", self.wished_angle)])?;
        ranges::counts(&[
            ("max_iterations", self.max_iterations),
            ("newton_iterations", self.newton_iterations.unwrap_or(0)),
            ("smoothing", self.smoothing[0]),
            ("smoothing", self.smoothing[1]),
        ])
    }
}

/// Refuses limits that nothing can meet.
fn limits_fit(limits: &PanelLimits) -> Result<(), BadOption> {
    let lengths = [
        ("min_edge", limits.min_edge),
        ("max_edge", limits.max_edge),
        ("max_area", limits.max_area),
    ];
    let set = lengths.map(|(name, length)| (name, length.unwrap_or(1.0)));
    ranges::positive(&set)?;
    let sheet = limits
        .max_panel
        .unwrap_or([1.0; 2])
        .map(|s| ("max_panel", s));
    ranges::positive(&sheet)?;
    let aspect = ("max_aspect", limits.max_aspect.unwrap_or(1.0));
    ranges::within(1.0..=ranges::LARGEST_WEIGHT, &[aspect])?;
    ranges::below(180.0, &[("min_angle", limits.min_angle.unwrap_or(1.0))])?;
    let joints = [
        ("min_dihedral", limits.min_dihedral),
        ("max_dihedral", limits.max_dihedral),
    ];
    let set = joints.map(|(name, angle)| (name, angle.unwrap_or(1.0)));
    ranges::positive(&set)?;
    ranges::within(0.0..=180.0, &set)?;
    let largest = |limit: Option<f64>| limit.unwrap_or(f64::INFINITY);
    let least = |limit: Option<f64>| limit.unwrap_or(0.0);
    let pairs = [
        ("min_edge", least(limits.min_edge), largest(limits.max_edge)),
        (
            "min_dihedral",
            least(limits.min_dihedral),
            largest(limits.max_dihedral),
        ),
    ];
    match pairs.into_iter().find(|(_, least, most)| least > most) {
        None => Ok(()),
        Some((option, value, most)) => Err(BadOption {
            option: option.to_owned(),
            value,
            range: format!("at most {most}, the largest that is allowed"),
        }),
    }
}
