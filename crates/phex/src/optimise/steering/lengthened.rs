//! A planar mesh drawn to other edge lengths, with everything else as it was asked for.
//!
//! The last phases of the feasible path are gone through again with the lengths as a term of the
//! energy, whose weight the caller raises; the weights of all limits rise with it, so that lengths
//! never buy what a limit forbids.

use super::grounded;
use super::on_boundary::{ON_IT, already_there};
use super::wishes;
use crate::optimise::holds::Anchored;
use crate::optimise::panels::{FaceShapes, point, unknowns};
use crate::optimise::solver::parts::LARGE;
use crate::optimise::solver::path::Path;
use crate::optimise::solver::solvers::Solvers;
use crate::optimise::terms::barrier::clearance;
use crate::optimise::terms::edge_lengths::EdgeLengths;
use crate::optimise::{
    BoundaryHold, FaceLimits, OptimiseError, OptimiseOptions, Quotient, Stage, Steering, Target,
    check_mesh, mesh_at,
};
use crate::progress::Progress;
use phex_mesh::{HexMesh, PerEdge, Vec3, measure};

/// Last phases that are gone through again.
const PHASES: usize = 2;
/// Relative decrease of the energy that ends a phase, and iterations of one at the most: shared
/// lengths move every vertex, and by little.
const ENERGY_TOLERANCE: f64 = 1e-4;
const ITERATIONS: usize = 25;
/// Factor of limits over the weight of lengths: enough that a limit costs more than a length that
/// is off by a hundredth, and so little that what lies within its limits hardly feels them.
const LIMITS: f64 = 0.1;
/// Share of their room and of their sharpest corner that panels keep where they have less than is
/// wished for: a wish that can't be met would weigh more than all lengths.
const KEPT: f64 = 0.9;

/// What keeps the vertices of a mesh while its edges are drawn to other lengths.
pub(crate) struct KeptVertices<'a> {
    /// The boundary on which vertices that lie there slide.
    pub hold: Option<&'a BoundaryHold>,
    /// Images that are no unknowns.
    pub quotient: &'a Quotient,
    /// What the user holds.
    pub steering: &'a Steering,
    /// Largest distance to the surface, in the unit of the mesh.
    pub distance: f64,
}

/// A mesh whose edges are drawn to other lengths.
pub(crate) struct LengthStage<'a> {
    mesh: &'a HexMesh,
    stage: Stage<'a>,
    solvers: Solvers,
    options: OptimiseOptions,
}

impl<'a> LengthStage<'a> {
    /// Panels at the most: larger meshes are minimised part by part.
    pub const MOST_PANELS: usize = LARGE;

    /// Prepares a planar mesh of at most [`Self::MOST_PANELS`].
    ///
    /// # Errors
    /// If the mesh or an option can't be used, or the mesh can't be held as it is to be.
    pub fn new(
        mesh: &'a HexMesh,
        target: &'a dyn Target,
        kept: &KeptVertices<'_>,
        options: &OptimiseOptions,
    ) -> Result<Self, OptimiseError> {
        options.check()?;
        check_mesh(mesh)?;
        let sharpest = measure(mesh).angle.min;
        let options = &OptimiseOptions {
            wished_angle: options.wished_angle.min(KEPT * sharpest),
            max_iterations: ITERATIONS,
            energy_tolerance: ENERGY_TOLERANCE,
            ..options.clone()
        };
        let x = unknowns(mesh);
        let mut stage = Stage::of_mesh(mesh, Some(target), options);
        // The boundary is held or free: nothing is drawn to it.
        stage.rim.clear();
        stage.divide(kept.quotient);
        stage.keep_areas(&x, options);
        stage.limits = FaceLimits {
            distance: kept.distance,
            ..FaceLimits::of(&stage.panels, &x, options)
        };
        let shape = FaceShapes::at(&stage.panels, &x);
        for (f, wished) in stage.limits.clearance.iter_mut().enumerate() {
            *wished = wished.min(KEPT * clearance(shape.face(&stage.panels, f)));
        }
        let mut held = wishes::resolve(kept.steering, mesh, options.max_deviation)?;
        // What was let go of curves and planes, since panels could not be planar there, is near
        // them, and would be put back.
        let near = ON_IT * mesh.diagonal();
        let away = |(v, place): &(u32, Vec3)| (place - point(&x, *v as usize)).norm() > near;
        let loose = held.places(&x).filter(away).map(|(v, _)| v).collect();
        held.release(&loose);
        stage.holds.anchors = held.anchors;
        stage.holds.curves = held.curves;
        stage.holds.held.extend(held.held);
        if let Some(hold) = kept.hold {
            let mut rim = already_there(mesh, hold);
            rim.retain(|v, _| kept.quotient.is_free(*v));
            grounded::keep_rim(&mut stage.holds, mesh, &rim, &hold.curves);
        }
        // What nothing draws to the boundary, and fairness draws away from it, stays near.
        for v in mesh.topology().vertices() {
            let (number, point) = (v.index() as u32, mesh.position(v));
            let is_free = kept.quotient.is_free(number) && !stage.holds.held.contains_key(&number);
            if is_free && mesh.topology().is_boundary_vertex(v) {
                let anchor = Anchored { point, weight: 1.0 };
                stage.holds.anchors.entry(number).or_insert(anchor);
            }
        }
        Ok(Self {
            mesh,
            solvers: Solvers::new(&stage.panels)?,
            stage,
            options: options.clone(),
        })
    }

    /// The mesh, from where `from` has its vertices, with its edges drawn to `lengths` by a weight
    /// over that of closeness.
    ///
    /// # Errors
    /// If a factorisation fails for want of memory.
    pub fn drawn(
        &mut self,
        from: &HexMesh,
        lengths: &PerEdge<f64>,
        weight: f64,
        progress: &dyn Progress,
    ) -> Result<HexMesh, OptimiseError> {
        let x = unknowns(from);
        let setting = self.stage.setting(&x);
        let mut path = Path::new(&setting, &mut self.solvers, &x, &self.options, progress)?;
        let weight = weight * path.weights.closeness.vertex;
        let term = EdgeLengths::new(self.mesh.topology(), lengths, weight);
        if let Some(energy) = path.energy() {
            energy.lengths = Some(term);
        }
        let heavier = (LIMITS * weight / path.weights.closeness.vertex).max(1.0);
        path.weights.limits *= heavier;
        path.weights.closeness.limit.elastic.weight *= heavier;
        let x = path.again(&x, PHASES)?;
        Ok(mesh_at(self.mesh, &x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::steer;
    use crate::optimise::tests::fixtures::{Shape, brick_wall};
    use crate::progress::Silent;

    /// Three corners of panels on a curve bend them, so that some are let go.
    #[test]
    fn what_was_let_go_of_a_curve_is_not_put_back_on_it() {
        let wall = brick_wall(Shape::Wave, 15, 8);
        let at = |k: i32| {
            let x = 0.05 * f64::from(k);
            [x, -2.0, Shape::Wave.height(x, -2.0)]
        };
        let steering = Steering {
            curves: vec![(-50..=50).map(at).collect()],
            ..Default::default()
        };
        let options = OptimiseOptions::default();
        let planar = steer(&wall, Some(&Shape::Wave), &steering, &options, &Silent).unwrap();
        let kept = KeptVertices {
            hold: None,
            quotient: &Quotient::default(),
            steering: &steering,
            distance: 1.0,
        };
        let stage = LengthStage::new(&planar.mesh, &Shape::Wave, &kept, &options).unwrap();
        let (x, holds) = (unknowns(&planar.mesh), &stage.stage.holds);
        assert!(!holds.held.is_empty());
        for (v, place) in holds.places(&x) {
            let moved = (place - point(&x, v as usize)).norm();
            assert!(moved < 1e-6, "{v} is moved by {moved}");
        }
    }
}
