//! Room at the very end: panels of a finished mesh that are tight move with what is around them,
//! the boundary on its curve.
//!
//! What trims a mesh and slides it to the boundary looks at validity, not at room. Here the retries
//! of [`super::retry`] go over the tight panels of what came of it: Newton's method on the
//! constraints first, then the last phases. Vertices on the boundary curve stay on it, other ones
//! of the boundary stay where they are. A place is only taken where it costs neither nearness nor
//! the sharpest angle.

use crate::optimise::on_boundary::{already_there, near_corners};
use crate::optimise::options::NEWTON_ITERATIONS;
use crate::optimise::panels::{Panels, Shape, unknowns};
use crate::optimise::path::Path;
use crate::optimise::reached::{Reached, Way};
use crate::optimise::solvers::Solvers;
use crate::optimise::{
    BoundaryHold, Hold, Holds, OptimiseError, OptimiseOptions, Optimised, PathKind, Reference,
    Stage, StartKind, Target, check_mesh, finished as finished_mesh, kinds_of,
};
use crate::progress::Progress;
use phex_mesh::{BoundaryCurve, HexMesh, Vec3, VertexId};

/// Gives tight panels of a planar mesh more room; `None` if there is none to be had without harm.
///
/// # Errors
/// If the mesh or an option can't be used.
pub fn give_room(
    mesh: &HexMesh,
    target: &dyn Target,
    hold: Option<&BoundaryHold<'_>>,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, OptimiseError> {
    let work = |path: &mut Path<'_>, x: &[f64]| path.give_room(x);
    finished(mesh, target, hold, &[], options, progress, work)
}

/// Makes small panels at the boundary of a planar mesh larger, vertices next to its corners at
/// rest; `None` if that can be done for none without harm.
///
/// # Errors
/// If the mesh or an option can't be used.
pub fn enlarge_small(
    mesh: &HexMesh,
    target: &dyn Target,
    hold: &BoundaryHold<'_>,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, OptimiseError> {
    let faces = mesh.topology().faces();
    let rim = faces.map(|f| mesh.topology().is_boundary_face(f));
    let rim: Vec<bool> = rim.collect();
    let work = |path: &mut Path<'_>, x: &[f64]| path.enlarge(&rim, x);
    let at_corners = near_corners(mesh, hold.corners).into_iter();
    let rest: Vec<VertexId> = at_corners.map(|(v, _)| v).collect();
    finished(mesh, target, Some(hold), &rest, options, progress, work)
}

/// A finished mesh gone over with its boundary kept and some vertices at rest; `None` if it stays
/// as it is.
fn finished(
    mesh: &HexMesh,
    target: &dyn Target,
    hold: Option<&BoundaryHold<'_>>,
    rest: &[VertexId],
    options: &OptimiseOptions,
    progress: &dyn Progress,
    work: impl FnOnce(&mut Path<'_>, &[f64]) -> Result<Vec<f64>, OptimiseError>,
) -> Result<Option<Optimised>, OptimiseError> {
    options.check()?;
    check_mesh(mesh)?;
    let x = unknowns(mesh);
    let panels = Panels::new(mesh.topology());
    let shape = Shape::at(&panels, &x);
    let side = (0..panels.n_faces()).map(|f| shape.normal(f)).collect();
    let (reference, kinds) = (Reference::Surface(target), kinds_of(mesh));
    let mut stage = Stage::new(mesh, reference, Some(side), &kinds, options);
    stage.keep_areas(&x, options);
    stage.holds = rim_holds(mesh, &shape, hold);
    let rest = rest
        .iter()
        .map(|v| (v.index() as u32, Hold::At(mesh.position(*v))));
    stage.holds.held.extend(rest);
    let options = &OptimiseOptions {
        newton_iterations: options.newton_iterations.or(Some(NEWTON_ITERATIONS)),
        ..options.clone()
    };
    let setting = stage.setting(&x);
    let mut solvers = Solvers::new(&panels)?;
    let mut path = Path::new(&setting, &mut solvers, &x, options, progress)?;
    let now = work(&mut path, &x)?;
    if path.is_over() || now == x {
        return Ok(None);
    }
    let way = Way {
        kind: StartKind::AsGiven,
        path: PathKind::Feasible,
        in_parts: path.in_parts,
        outcome: path.outcome,
    };
    let as_it_was = stage.judged(&x, options).offenders;
    let run = stage.conclude(0, Reached::at(&setting, now), way, options);
    let sound = run.offenders.len() <= as_it_was.len();
    Ok(sound.then(|| finished_mesh(mesh, run)))
}

/// What keeps the boundary: on its curve where it lies there, along the curve where it does not, at
/// rest where no curve is known.
pub(super) fn rim_holds(mesh: &HexMesh, shape: &Shape, hold: Option<&BoundaryHold<'_>>) -> Holds {
    let topology = mesh.topology();
    let rim = topology
        .vertices()
        .filter(|v| topology.is_boundary_vertex(*v));
    let place = |v: VertexId| match hold {
        Some(hold) => along(mesh, shape, v, hold.curves),
        None => Hold::At(mesh.position(v)),
    };
    let mut holds = Holds {
        held: rim.map(|v| (v.index() as u32, place(v))).collect(),
        ..Holds::default()
    };
    if let Some(hold) = hold {
        holds.held.extend(already_there(mesh, hold));
        holds.rim = Some(hold.curves.clone());
    }
    holds
}

/// The plane through a vertex of the boundary, along the curve and across the panels there.
fn along(mesh: &HexMesh, shape: &Shape, v: VertexId, curves: &BoundaryCurve) -> Hold {
    let topology = mesh.topology();
    let point = mesh.position(v);
    let faces = topology.outgoing(v).map(|h| topology.face(h).index());
    let up: Vec3 = faces.map(|f| shape.normal(f)).sum();
    let across = curves.closest_point(point).tangent.cross(&up);
    match across.try_normalize(f64::MIN_POSITIVE) {
        Some(normal) => Hold::InPlane { point, normal },
        None => Hold::At(point),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optimise::tests::fixtures::{Shape as Surface, brick_wall, layout};
    use crate::optimise::{Quality, optimise};
    use crate::progress::Silent;
    use phex_mesh::small_rim_faces;

    /// Planar panels that were made with hardly a barrier.
    fn tight() -> Optimised {
        let shape = Surface::Wave;
        let options = OptimiseOptions {
            barrier: 2e-2,
            barrier_reach: 0.2,
            ..OptimiseOptions::default()
        };
        let layout = layout(brick_wall(shape, 25, 12), &shape);
        optimise(&layout, &shape, &options, &Silent).unwrap()
    }

    fn boundary(mesh: &HexMesh) -> BoundaryCurve {
        let place = |v: &VertexId| mesh.position(*v);
        let loops = mesh.topology().boundary_loops();
        let closed = |l: &Vec<VertexId>| l.iter().chain(l.first()).map(place).collect();
        BoundaryCurve::of_polylines(&loops.iter().map(closed).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn tight_panels_get_room_and_the_boundary_stays() {
        let before = tight();
        let options = OptimiseOptions::default();
        let after = give_room(&before.mesh, &Surface::Wave, None, &options, &Silent);
        let after = after.unwrap().expect("there is room");
        let (then, now) = (&before.quality, &after.quality);
        assert_eq!(after.offenders, []);
        assert!(now.planarity <= options.planarity_tolerance, "{now:?}");
        let least = |q: &Quality| q.clearance * q.mean_edge;
        assert!(
            least(now) >= least(then) * (1.0 - 1e-9),
            "{then:?}, {now:?}"
        );
        assert!(
            now.clearance_p05 > then.clearance_p05 + 0.05,
            "{then:?}, {now:?}"
        );
        let near = then.deviation_max.max(0.02 * then.mean_edge);
        assert!(now.deviation_max <= near, "{then:?}, {now:?}");
        let topology = before.mesh.topology();
        for v in topology
            .vertices()
            .filter(|v| topology.is_boundary_vertex(*v))
        {
            assert_eq!(after.mesh.position(v), before.mesh.position(v));
        }
    }

    #[test]
    fn the_boundary_slides_on_its_curve_or_beside_it() {
        let mesh = tight().mesh;
        let panels = Panels::new(mesh.topology());
        let shape = Shape::at(&panels, &unknowns(&mesh));
        let beside = mesh.with_positions(mesh.positions.map(|p| p * 1.001));
        for (mesh, on_it) in [(&mesh, true), (&beside, false)] {
            let curves = boundary(&tight().mesh);
            let hold = BoundaryHold {
                curves: &curves,
                corners: &[],
            };
            let held = rim_holds(mesh, &shape, Some(&hold)).held;
            let rim = mesh
                .topology()
                .boundary_loops()
                .iter()
                .map(Vec::len)
                .sum::<usize>();
            assert_eq!(held.len(), rim);
            // Where the curve meets the origin's rays at a tangent a few are on both.
            let on_curve = held.values().filter(|h| **h == Hold::OnRim).count();
            assert_eq!(on_curve > rim / 2, on_it, "{on_curve} of {rim}");
            for hold in held.values() {
                if let Hold::InPlane { point, normal } = hold {
                    let tangent = curves.closest_point(*point).tangent;
                    assert!(tangent.dot(normal).abs() < 1e-12);
                }
            }
        }
    }

    /// Panels in a plane, a few at the boundary much shallower than the others.
    fn shallow() -> HexMesh {
        let wall = brick_wall(Surface::Square, 25, 12);
        let (row, bottom) = (1.8 / 12.0, -0.9);
        let lowered = |p: &Vec3| {
            let moves = p.x.abs() < 0.3 && (p.y - bottom - row).abs() < 0.1 * row;
            let by = if moves { 0.8 * row } else { 0.0 };
            p - Vec3::y() * by
        };
        wall.with_positions(wall.positions.map(lowered))
    }

    #[test]
    fn small_panels_at_the_boundary_grow() {
        let before = shallow();
        assert!(small_rim_faces(&before).len() > 1);
        let curves = boundary(&before);
        let hold = BoundaryHold {
            curves: &curves,
            corners: &[],
        };
        let options = OptimiseOptions::default();
        let after = enlarge_small(&before, &Surface::Square, &hold, &options, &Silent);
        let after = after.unwrap().expect("they can grow");
        assert_eq!(small_rim_faces(&after.mesh), []);
        assert_eq!(after.offenders, []);
        let quality = &after.quality;
        assert!(quality.planarity <= options.planarity_tolerance);
        assert!(quality.clearance >= 0.1, "{quality:?}");
        let topology = after.mesh.topology();
        let rim = topology.vertices();
        let off = rim
            .filter(|v| topology.is_boundary_vertex(*v))
            .map(|v| after.mesh.position(v))
            .map(|p| (curves.closest_point(p).position - p).norm());
        assert!(off.fold(0.0, f64::max) < 1e-9 * after.mesh.diagonal());
        // A vertex next to a corner rests.
        let at_small = before.topology().face_vertices(small_rim_faces(&before)[0]);
        let v = *(at_small.iter())
            .find(|v| before.topology().is_boundary_vertex(**v))
            .unwrap();
        let corner = before.position(v) + Vec3::z() * (0.1 * before.mean_edge());
        let moved = |corners: &[Vec3]| {
            let curves = &curves;
            let hold = BoundaryHold { curves, corners };
            let after = enlarge_small(&before, &Surface::Square, &hold, &options, &Silent);
            let after = after.unwrap().expect("they can grow");
            (after.mesh.position(v) - before.position(v)).norm()
        };
        assert!(moved(&[]) > 0.0 && moved(&[corner]) == 0.0);
        let once_more = enlarge_small(&after.mesh, &Surface::Square, &hold, &options, &Silent);
        assert!(once_more.unwrap().is_none());
    }

    #[test]
    fn a_mesh_with_room_is_left_alone() {
        let shape = Surface::Torus(1.0);
        let layout = layout(brick_wall(shape, 40, 14), &shape);
        let options = OptimiseOptions::default();
        let mesh = optimise(&layout, &shape, &options, &Silent).unwrap().mesh;
        let after = give_room(&mesh, &shape, None, &options, &Silent).unwrap();
        assert!(after.is_none());
    }
}
