//! Parts of a mesh by themselves: panels that are joined anew, and panels that are tried again,
//! with what is around them at rest.

mod rim;

use super::holds::Hold;
use super::panels::{FaceShapes, unknowns};
use super::solver::emphasis::FREE_TURN_IN_SEARCH;
use super::solver::solvers::Solvers;
use super::terms::areas;
use super::{
    BoundaryHold, FaceLimits, OptimiseError, OptimiseOptions, Optimised, Reference, Stage,
    StartKind, Target, check_layout, check_mesh, finished,
};
use crate::layout::Layout;
use crate::progress::Progress;
use phex_mesh::VertexId;
use rim::rim_holds;

/// A part of a mesh.
pub(crate) struct LocalPart<'a> {
    /// Its panels.
    pub layout: &'a Layout,
    /// Whether each vertex may move; those on the boundary of the surface slide along it.
    pub free: &'a [bool],
    /// The boundary of the surface; `None` where vertices on the boundary of the part rest.
    pub hold: Option<&'a BoundaryHold>,
    /// What its panels are to have.
    pub limits: &'a FaceLimits,
}

impl LocalPart<'_> {
    /// Makes the panels planar, simple and close to `target`: free vertices are smoothed on the
    /// surface and go the feasible path, the others rest.
    ///
    /// # Errors
    /// If the part or an option can't be used; what can't be *reached* is told by [`Optimised`].
    pub(crate) fn settled(
        &self,
        target: &dyn Target,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Optimised, OptimiseError> {
        let mesh = &self.layout.mesh;
        let mut stage = self.stage(target, options)?;
        let inside = |v: usize| !mesh.topology().is_boundary_vertex(VertexId::new(v as u32));
        let smoothing = stage.smoothing(self.layout, target, options);
        let places = mesh.positions.as_slice().to_vec();
        let moves = |v: usize| self.free[v] && inside(v);
        let start = smoothing.from(places, moves, || progress.is_cancelled());
        stage.areas = areas::of_layout(self.layout, &stage.panels, &start.x, options.evenness);
        let mut solvers = Solvers::new(&stage.panels)?;
        let run = stage.run(&mut solvers, StartKind::Local, &start, options, progress)?;
        Ok(finished(mesh, run))
    }

    /// Goes on from planar panels with more weight on what they lack, the more the later the
    /// `round` of the [`EMPHASES`]. Whether that is better is for the caller to say.
    ///
    /// # Errors
    /// As [`LocalPart::settled`].
    pub fn emphasised(
        &self,
        round: usize,
        target: &dyn Target,
        options: &OptimiseOptions,
        progress: &dyn Progress,
    ) -> Result<Optimised, OptimiseError> {
        let mesh = &self.layout.mesh;
        let mut stage = self.stage(target, options)?;
        let x = unknowns(mesh);
        stage.areas = areas::of_layout(self.layout, &stage.panels, &x, options.evenness);
        let run = stage.emphasised(&x, (round, FREE_TURN_IN_SEARCH), options, progress)?;
        Ok(finished(mesh, run))
    }

    fn stage<'b>(
        &'b self,
        target: &'b dyn Target,
        options: &OptimiseOptions,
    ) -> Result<Stage<'b>, OptimiseError> {
        let layout = self.layout;
        let mesh = &layout.mesh;
        check_mesh(mesh)?;
        check_layout(layout)?;
        let side = Some(layout.face_normal.as_slice().to_vec());
        let reference = Reference::Surface(target);
        let mut stage = Stage::new(mesh, reference, side, &layout.vertex_kind, options);
        let shape = FaceShapes::at(&stage.panels, &unknowns(mesh));
        stage.holds = rim_holds(mesh, &shape, self.hold);
        stage.limits = self.limits.clone();
        let rests = |v: &VertexId| !self.free[v.index()];
        for v in mesh.topology().vertices().filter(rests) {
            let hold = Hold::At(mesh.position(v));
            stage.holds.held.insert(v.index() as u32, hold);
        }
        stage.panels = stage.panels.with_rest(|v| stage.holds.fixes(v));
        Ok(stage)
    }
}
