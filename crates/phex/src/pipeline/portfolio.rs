//! The portfolio: ways of laying panels out, tried until one is good, or all of them side by side.
//!
//! No single layout is best on every surface. A strongly anisotropic lattice follows the curvature closely, a less anisotropic one
//! has calmer panels, a seamless one changes its size smoothly instead of by dislocations, and a brick wall has straight rows where
//! the surface has a network for them. Each is judged after it has been made planar: valid, close, clear, regular.

use super::field::Way;
use super::judge::inner_deviation;
use super::repair::attempt;
use super::{Clock, MeshOptions, MeshRun, Method, PipelineError, Statistics, brick_wall, rim};
use crate::ground::Ground;
use crate::optimise::Fault;
use crate::progress::{Event, Progress};
use phex_mesh::{HexMesh, TriangleSurface};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;

/// One way of laying panels out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Candidate {
    /// [`Method::Lattice`] or [`Method::BrickWall`].
    pub method: Method,
    /// Largest ratio of a lattice's panel lengths along the principal directions.
    pub anisotropy: f64,
    /// Whether the size of a lattice's panels may change so far that it needs no dislocations.
    pub seamless: bool,
}

impl Default for Candidate {
    fn default() -> Self {
        Self {
            method: Method::Lattice,
            anisotropy: 2.0,
            seamless: false,
        }
    }
}

impl Candidate {
    /// What is tried beside the lattice that the options describe.
    pub(super) fn others() -> Vec<Self> {
        let lattice = |seamless, anisotropy| Self {
            seamless,
            anisotropy,
            ..Self::default()
        };
        let wall = Self {
            method: Method::BrickWall,
            ..Self::default()
        };
        let lattices = [(true, 2.0), (true, 1.5), (false, 1.5), (false, 1.0)];
        let lattices = lattices.map(|(seamless, anisotropy)| lattice(seamless, anisotropy));
        lattices.into_iter().chain([wall]).collect()
    }

    /// The lattice that the options describe.
    fn first(options: &MeshOptions) -> Self {
        Self {
            anisotropy: options.directions.anisotropy,
            ..Self::default()
        }
    }

    fn way(&self) -> Way {
        Way {
            anisotropy: self.anisotropy,
            seamless: self.seamless,
        }
    }
}

/// One member of the portfolio, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AttemptSummary {
    /// How its panels were laid out.
    #[serde(flatten)]
    pub candidate: Candidate,
    /// Panels.
    pub panels: usize,
    /// Panels that are not as they should be.
    pub invalid: usize,
    /// Whether the optimiser made all panels planar.
    pub planar: bool,
    /// Share of hexagons among the panels inside.
    pub hex: f64,
    /// Panels inside that are no hexagons, beyond those that the topology of a closed surface asks for.
    pub irregular: usize,
    /// Dislocations that the lattice kept.
    pub dislocations: usize,
    /// Whether a lattice could do without any irregular panel but those that topology asks for: on closed surfaces of Euler
    /// characteristic 0, and where the Gauss curvature is positive everywhere.
    pub regular_possible: bool,
    /// Largest distance between panels and surface either way, away from the boundary, over the diagonal.
    pub deviation: f64,
    /// Least clearance, mean edges.
    pub clearance: f64,
    /// Least angle at a corner, degrees.
    pub least_angle: f64,
    /// Whether it is the one that was kept.
    pub kept: bool,
}

/// Share of panels that are irregular without need, up to which nothing else is tried.
const GOOD_IRREGULAR: f64 = 0.025;
/// The same where sizes vary: every change of size costs a pair.
const GOOD_IRREGULAR_SIZED: f64 = 0.08;

impl AttemptSummary {
    /// What the mesh itself tells; the rest is for the caller to fill in.
    pub(super) fn of_mesh(candidate: Candidate, mesh: &HexMesh) -> Self {
        let measures = phex_mesh::measure(mesh);
        Self {
            candidate,
            panels: mesh.topology().n_faces(),
            invalid: 0,
            planar: true,
            hex: measures.hex.unwrap_or(1.0),
            irregular: measures.irregular,
            dislocations: 0,
            regular_possible: false,
            deviation: 0.0,
            clearance: measures.clearance.min,
            least_angle: measures.angle.min,
            kept: false,
        }
    }

    /// Whether nothing else needs to be tried.
    fn is_good(&self, options: &MeshOptions) -> bool {
        let close =
            self.deviation <= options.good_deviation() && self.clearance >= options.good_clearance;
        let sized = options.sizes.adaptive.is_some() || options.size_field.is_some();
        let regular = match self.regular_possible {
            true => self.irregular == 0,
            false if sized => self.irregular_share() <= GOOD_IRREGULAR_SIZED,
            false => self.irregular_share() <= GOOD_IRREGULAR && self.dislocations == 0,
        };
        self.invalid == 0 && close && regular
    }

    fn irregular_share(&self) -> f64 {
        self.irregular as f64 / self.panels.max(1) as f64
    }

    /// What members are compared by, smaller is better: valid first, then close, clear and regular.
    fn cost(&self, options: &MeshOptions) -> f64 {
        let off = self.deviation / options.good_deviation();
        let invalid = if self.planar { 0.0 } else { 1e6 } + 100.0 * self.invalid as f64;
        let far = 10.0 * (off - 1.0).max(0.0);
        let tight = (0.15 / self.clearance.max(1e-3) - 1.0).max(0.0);
        let weight = if self.regular_possible { 100.0 } else { 10.0 };
        let irregular = weight * self.irregular_share();
        invalid + far + tight + irregular + off * 0.1
    }
}

/// A mesh and what it is judged by.
struct Judged {
    summary: AttemptSummary,
    run: MeshRun,
}

/// What is made, of what, and how large, all normalised.
struct Task<'a> {
    surface: &'a TriangleSurface,
    panels: usize,
    options: &'a MeshOptions,
    ground: Ground,
}

/// The best mesh of the portfolio.
///
/// # Errors
/// If no member gives a mesh: what the first says.
pub(super) fn mesh_with_panels(
    surface: &TriangleSurface,
    panels: usize,
    options: &MeshOptions,
    progress: &dyn Progress,
) -> Result<MeshRun, PipelineError> {
    let mut clock = Clock::new(progress);
    let ground = clock.stage("target", || Ground::new(surface, panels, options))?;
    let task = Task {
        surface,
        panels,
        options,
        ground,
    };
    let (mut runs, best) = match options.with_usual_deviation() {
        None => task.members(&mut clock)?,
        Some(usual) => task.with_usual(&usual, &mut clock)?,
    };
    let mut tried: Vec<AttemptSummary> = runs.iter().map(|r| r.summary.clone()).collect();
    tried[best].kept = true;
    runs.iter().for_each(|r| clock.add(&r.run.stages));
    let mut run = runs.swap_remove(best).run;
    run.statistics.tried = tried;
    clock.timed("optimise", || give_room(&mut run, &task, progress))?;
    run.stages = clock.stages;
    Ok(run)
}

/// Gives tight panels of a valid mesh more room.
fn give_room(
    run: &mut MeshRun,
    task: &Task<'_>,
    progress: &dyn Progress,
) -> Result<(), PipelineError> {
    if !run.offenders.is_empty() || !run.violations.is_empty() {
        return Ok(());
    }
    let beyond = run.beyond.as_ref().map_or(&run.target, |b| &b.smooth);
    let surfaces = [&run.target, beyond];
    let roomy = rim::roomier(&run.mesh, surfaces, &task.ground.options, progress)?;
    if let Some(roomy) = roomy {
        run.mesh = roomy.mesh;
        run.statistics.runs.extend(roomy.runs);
    }
    Ok(())
}

/// The member of the least cost, of those that are admitted.
fn cheapest(
    runs: &[Judged],
    options: &MeshOptions,
    admitted: impl Fn(&AttemptSummary) -> bool,
) -> Option<usize> {
    let cost = |k: &usize| runs[*k].summary.cost(options);
    let all = (0..runs.len()).filter(|k| admitted(&runs[*k].summary));
    all.min_by(|a, b| cost(a).total_cmp(&cost(b)))
}

impl Task<'_> {
    /// The members that gave a mesh, and which is the best.
    fn members(&self, clock: &mut Clock<'_>) -> Result<(Vec<Judged>, usize), PipelineError> {
        let results = match self.options.method {
            Method::Best => self.all(clock.progress),
            _ => self.until_good(clock),
        };
        let (mut runs, mut errors) = (Vec::new(), Vec::new());
        for result in results {
            match result {
                Ok(judged) => runs.push(judged),
                Err(error) => errors.push(error),
            }
        }
        match cheapest(&runs, self.options, |_| true) {
            Some(best) => Ok((runs, best)),
            None => Err((errors.into_iter().next()).unwrap_or(PipelineError::Cancelled)),
        }
    }

    /// The same for a limit that is tighter than usual. What the usual limit gives comes first, and is enough if it keeps to the tight one; else
    /// nothing is taken that stands off farther: panels that can't be as near as is asked for are drawn hither and thither, and may end
    /// farther away than if less had been asked of them.
    fn with_usual(
        &self,
        usual: &MeshOptions,
        clock: &mut Clock<'_>,
    ) -> Result<(Vec<Judged>, usize), PipelineError> {
        let mut ground = self.ground.clone();
        ground.options.optimise.max_deviation = usual.optimise.max_deviation;
        let task = Task {
            options: usual,
            ground,
            ..*self
        };
        let (mut runs, best) = task.members(clock)?;
        let least = runs[best].summary.clone();
        if least.deviation <= self.options.good_deviation() || clock.progress.is_cancelled() {
            return Ok((runs, best));
        }
        if let Ok((tight, _)) = self.members(clock) {
            runs.extend(tight);
        }
        let no_worse = |s: &AttemptSummary| {
            s.deviation <= least.deviation && s.invalid <= least.invalid && s.planar >= least.planar
        };
        let kept = cheapest(&runs, self.options, no_worse).unwrap_or(best);
        Ok((runs, kept))
    }

    /// One after the other until one is good. A seamless lattice is tried only where it can be regular: elsewhere sizes must change,
    /// and dislocations are where they do. So is a brick wall, which few surfaces have a network for.
    fn until_good(&self, clock: &mut Clock<'_>) -> Vec<Result<Judged, PipelineError>> {
        let options = &self.ground.options;
        let first = Candidate::first(options);
        let mut results = vec![self.judged(first, clock.progress)];
        let Ok(judged) = &results[0] else {
            return results;
        };
        let regular_possible = judged.summary.regular_possible;
        let mut good = judged.summary.is_good(options);
        for &candidate in self.others() {
            if good || clock.progress.is_cancelled() {
                break;
            }
            let plain = candidate.method == Method::Lattice && !candidate.seamless;
            let fits = regular_possible || plain;
            if fits && candidate != first {
                let result = self.judged(candidate, clock.progress);
                good = matches!(&result, Ok(judged) if judged.summary.is_good(options));
                results.push(result);
            }
        }
        results
    }

    /// All of them side by side.
    fn all(&self, progress: &dyn Progress) -> Vec<Result<Judged, PipelineError>> {
        let one_at_a_time = OneAtATime(Mutex::new(()), progress);
        let first = Candidate::first(&self.ground.options);
        let others = self.others().iter().copied().filter(|c| *c != first);
        let all: Vec<Candidate> = std::iter::once(first).chain(others).collect();
        let one = |c: &Candidate| self.judged(*c, &one_at_a_time);
        all.par_iter().with_max_len(1).map(one).collect()
    }

    fn others(&self) -> &[Candidate] {
        &self.options.portfolio
    }

    fn judged(
        &self,
        candidate: Candidate,
        progress: &dyn Progress,
    ) -> Result<Judged, PipelineError> {
        match candidate.method {
            Method::BrickWall => self.wall(candidate, progress),
            _ => self.lattice(candidate, progress),
        }
    }

    fn lattice(
        &self,
        candidate: Candidate,
        progress: &dyn Progress,
    ) -> Result<Judged, PipelineError> {
        let ground = &self.ground;
        let mut clock = Clock::new(progress);
        let made = attempt(ground, candidate.way(), &mut clock)?;
        let mesh = made.left.trimmed.mesh;
        let summary = AttemptSummary {
            invalid: made.invalid,
            planar: made.planar,
            dislocations: made.layout.annihilation.kept,
            regular_possible: made.regular_possible,
            deviation: made.left.deviation,
            ..AttemptSummary::of_mesh(candidate, &mesh)
        };
        let levels = ground.smooth.levels.iter();
        let statistics = Statistics {
            panels_asked: self.panels,
            target_vertices: levels.map(|l| l.positions().len()).collect(),
            interpolation_error: ground.smooth.interpolation_error,
            layout: made.layout,
            cones: made.cones,
            brick_wall: None,
            classical: None,
            runs: made.result.runs.clone(),
            factorisations: made.factorisations,
            repairs: made.repairs,
            tried: Vec::new(),
        };
        let run = MeshRun {
            start: Some(made.left.start),
            mesh,
            target: made.reported,
            beyond: made.beyond,
            outcome: made.result.outcome,
            offenders: made.left.offenders,
            violations: made.left.violations,
            statistics,
            stages: clock.stages,
        };
        Ok(Judged { summary, run })
    }

    fn wall(&self, candidate: Candidate, progress: &dyn Progress) -> Result<Judged, PipelineError> {
        let run = brick_wall::mesh_with_panels(self.surface, self.panels, self.options, progress)?;
        let crooked = |fault: &Fault| !matches!(fault, Fault::NotPlanar { .. });
        let invalid = run.offenders.iter().filter(|o| crooked(&o.fault)).count();
        let reach = run.beyond.as_ref().map_or(&run.target, |b| &b.smooth);
        let deviation = phex_mesh::deviation_beyond(&run.mesh, &run.target, reach);
        let summary = AttemptSummary {
            invalid: invalid + run.violations.len(),
            planar: run.offenders.len() == invalid,
            deviation: inner_deviation(&deviation),
            ..AttemptSummary::of_mesh(candidate, &run.mesh)
        };
        Ok(Judged { summary, run })
    }
}

/// Lets several runs speak to one listener.
struct OneAtATime<'a>(Mutex<()>, &'a dyn Progress);

impl OneAtATime<'_> {
    fn alone<T>(&self, talk: impl FnOnce(&dyn Progress) -> T) -> T {
        // A listener that panicked left nothing behind that could be half-done here.
        let _turn = self
            .0
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        talk(self.1)
    }
}

impl Progress for OneAtATime<'_> {
    fn report(&self, event: &Event) {
        self.alone(|p| p.report(event));
    }

    fn is_cancelled(&self) -> bool {
        self.alone(|p| p.is_cancelled())
    }
}
