//! What a run has made.

use super::attempt::AttemptSummary;
use super::classical_statistics::ClassicalStatistics;
use super::clock::StageSeconds;
use super::domain::Beyond;
use crate::directions::guides::Cone;
use crate::layout::LayoutStatistics;
use crate::layout::brick_wall::BrickWallStatistics;
use crate::optimise::{RunSummary, Steering};
use crate::search::SearchSummary;
use crate::smooth_surface::{Normalised, SmoothTarget};
use crate::symmetry::{Orbits, SymmetrySummary};
use phex_mesh::validate::ValidateOptions;
use phex_mesh::{HexMesh, PerFace, PolygonSoup, TriangleSurface, Vec3, Violation};
use phex_numeric::Outcome;
use serde::Serialize;

/// What the stages did, for the report.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Statistics {
    /// Panels asked for.
    pub panels_asked: usize,
    /// Vertices of each level of the smooth target.
    pub target_vertices: Vec<usize>,
    /// Distance of the input's vertices to the target, over the diagonal.
    pub interpolation_error: f64,
    /// The lattice.
    pub layout: LayoutStatistics,
    /// The cones of the lattice's direction field, model units.
    pub cones: Vec<Cone>,
    /// The brick wall, if that was the method.
    pub brick_wall: Option<BrickWallStatistics>,
    /// The method by planes and poles, if that was one.
    pub classical: Option<ClassicalStatistics>,
    /// The optimiser's runs.
    pub runs: Vec<RunSummary>,
    /// Factorisations of these.
    pub factorisations: usize,
    /// The search for local changes, if there was one.
    pub search: Option<SearchSummary>,
    /// The symmetries that panels have by construction.
    pub symmetry: Option<SymmetrySummary>,
    /// The ways of the portfolio that were tried, the first first; the best was kept.
    pub tried: Vec<AttemptSummary>,
}

impl Statistics {
    /// Those of a target alone.
    pub(super) fn of(smooth: &SmoothTarget, panels: usize) -> Self {
        Self {
            panels_asked: panels,
            target_vertices: smooth.levels.iter().map(|l| l.positions().len()).collect(),
            interpolation_error: smooth.interpolation_error,
            ..Self::default()
        }
    }

    /// Adds a run of the optimiser.
    pub(super) fn add(&mut self, run: RunSummary) {
        self.factorisations += run.factorisations;
        self.runs.push(run);
    }
}

/// What [`mesh_surface`](super::mesh_surface) made.
#[derive(Clone)]
pub struct MeshRun {
    /// The panelling in model coordinates.
    pub mesh: HexMesh,
    /// Area that each panel is to have, squares of the model's unit; only the proportions count,
    /// and 0 stands for any.
    pub wished: PerFace<f64>,
    /// The panels as they were laid out, before the optimiser, in model coordinates; those that
    /// trimming removed are left out.
    pub start: Option<PolygonSoup>,
    /// The surface that the panels were kept close to, in model coordinates.
    pub target: TriangleSurface,
    /// The panelling before its edges were made equal, where that was asked for.
    pub unrepeated: Option<HexMesh>,
    /// That surface continued beyond its boundary, in model coordinates, if panels were kept whole
    /// and may stick out.
    pub beyond: Option<Beyond>,
    /// How the mesh comes from a part of it, in model coordinates, where it is symmetric by
    /// construction.
    pub orbits: Option<Orbits>,
    /// How the optimiser ended.
    pub outcome: Outcome,
    /// What the stages did.
    pub statistics: Statistics,
    /// Where the time went.
    pub stages: Vec<StageSeconds>,
}

impl MeshRun {
    /// Panels that may have any area, with nothing else to tell of.
    pub(super) fn new(
        mesh: HexMesh,
        target: TriangleSurface,
        outcome: Outcome,
        statistics: Statistics,
    ) -> Self {
        Self {
            wished: PerFace::filled(mesh.topology().n_faces(), 0.0),
            mesh,
            start: None,
            target,
            unrepeated: None,
            beyond: None,
            orbits: None,
            outcome,
            statistics,
            stages: Vec::new(),
        }
    }

    /// The same in model coordinates, with vertices where they are held there.
    pub(super) fn restored(mut self, model: &Normalised, held: &Steering) -> Self {
        let affinity = &model.affinity;
        let restore = |p: Vec3| affinity.restore(p);
        let mut positions = self.mesh.positions.map(|p| restore(*p));
        held.put_exactly(&mut positions, affinity.scale);
        self.orbits = self.orbits.map(|o| o.restored(affinity));
        if let Some(orbits) = &self.orbits {
            orbits.put_exactly(&mut positions);
            if let Some(summary) = &mut self.statistics.symmetry {
                summary.operations.clone_from(&orbits.operations);
            }
        }
        self.mesh = self.mesh.with_positions(positions);
        self.wished = self.wished.map(|area| area * affinity.scale.powi(2));
        self.unrepeated = (self.unrepeated).map(|mesh| mesh.mapped(|p| restore(*p)));
        for p in self.start.iter_mut().flat_map(|s| &mut s.positions) {
            *p = restore(*p);
        }
        self.target = model.restored(&self.target);
        self.beyond = self.beyond.map(|b| b.restored(model));
        let tried = std::mem::take(&mut self.statistics.tried).into_iter();
        self.statistics.tried = tried.map(|t| t.restored(restore)).collect();
        for cone in &mut self.statistics.cones {
            *cone = cone.moved(restore);
        }
        if let Some(centre) = (self.statistics.classical.as_mut()).and_then(|c| c.centre.as_mut()) {
            *centre = restore((*centre).into()).into();
        }
        self
    }

    /// Everything that is wrong with the mesh in itself, and with the sides that its panels show.
    pub fn violations(&self) -> Vec<Violation> {
        phex_mesh::violations(&self.mesh, Some(&self.target), &ValidateOptions::default())
    }

    /// Whether every panel is planar and simple, and no two of them meet where they should not.
    pub fn is_sound(&self) -> bool {
        self.violations().is_empty()
    }
}
