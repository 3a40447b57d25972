//! Vertices of the boundary exactly on the boundary curve.
//!
//! The optimiser draws the rim towards the boundary curve; here the ends of interior edges are put
//! on it, corners of the curve on the vertices nearest to them, and all panels are made planar
//! again with these vertices sliding on the curve ([`crate::optimise::holds`]). A panel of the rim
//! has three degrees of freedom and one condition for each of its ends on the curve that a
//! neighbour shares, so that is possible where panels meet the curve at an angle; along an
//! asymptotic curve two neighbours that both held it would lie in one plane. Where panels do not
//! become planar, or would have to move far, their vertices are let go, and the rest is tried
//! again.

use super::wishes;
use crate::optimise::holds::{Hold, Holds};
use crate::optimise::panels::{point, unknowns};
use crate::optimise::quotient::Quotient;
use crate::optimise::solver::parts::PartRegion;
use crate::optimise::solver::reached::Run;
use crate::optimise::{
    Fault, Offender, OptimiseError, OptimiseOptions, Optimised, OptimisedFigures, Stage, Steering,
    Target, check_mesh, finished as finished_mesh, mesh_at, steer_with,
};
use crate::progress::Progress;
use phex_mesh::{
    BoundaryCurve, FaceId, FacePlane, FlatFace, HexMesh, Vec3, VertexId, small_rim_faces,
};
use std::collections::{BTreeMap, BTreeSet};

/// Rings of panels from the boundary on that give way: the cost follows the boundary.
const BAND: usize = 8;
/// Rounds of letting go at the most.
const ROUNDS: usize = 8;
/// Mean edges that a vertex may move.
const MOST_MOVE: f64 = 0.35;
/// Mean edges by which a vertex of the boundary may get farther from the curve.
const MOST_DRIFT: f64 = 0.04;
/// Mean edges within which a vertex of the boundary is put on a corner of the curve.
const CORNER_REACH: f64 = 0.3;
/// Mean edges within which a vertex of the boundary lies over a corner of the curve.
const OVER_CORNER: f64 = 0.05;
/// Panels are let go that are farther from planar than this share of the worst one.
const WORST: f64 = 0.3;
/// Share of the clearance that must be left.
const CLEARANCE_LEFT: f64 = 0.6;

/// Diagonals within which a vertex lies on a curve.
pub(super) const ON_IT: f64 = 1e-7;

/// The curves, and the points of them that vertices are put on.
pub struct BoundaryHold {
    /// The curves on which the ends of interior edges slide.
    pub curves: BoundaryCurve,
    /// Corners of the curves.
    pub corners: Vec<Vec3>,
}

/// Puts vertices of the boundary of a planar mesh on curves; `None` if that can be done for no
/// vertex without harm.
///
/// # Errors
/// If the mesh or an option can't be used.
pub fn onto_boundary(
    mesh: &HexMesh,
    target: &dyn Target,
    hold: &BoundaryHold,
    quotient: &Quotient,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Option<Optimised>, OptimiseError> {
    options.check()?;
    check_mesh(mesh)?;
    let x = unknowns(mesh);
    let mut stage = Stage::of_mesh(mesh, Some(target), options);
    stage.divide(quotient);
    let panels = stage.panels.clone();
    stage.keep_areas(&x, options);
    let (before, _) = stage.inspected(&x, options);
    let mut held = holds(mesh, hold);
    held.retain(|v, _| quotient.is_free(*v));
    if held.is_empty() {
        return Ok(None);
    }
    // Orbits may lie across the inner edge of a band.
    let rings = if quotient.images.is_empty() {
        BAND
    } else {
        usize::MAX
    };
    let band = PartRegion::near(&panels, held.keys().copied(), rings);
    let mut solvers = band.solvers(&panels)?;
    for _ in 0..ROUNDS {
        if held.is_empty() || progress.is_cancelled() {
            break;
        }
        stage.holds = Holds {
            curves: Some(hold.curves.clone()),
            ..quotient.holds()
        };
        stage.holds.held.extend(held.clone());
        let Ok(start) = wishes::put_in_place(&stage.holds, &panels, mesh) else {
            break;
        };
        let start = stage.start_at(&band.moved(&start, &x));
        let run = stage.run_projection_of(&band, &mut solvers, &start, options, progress);
        let harmed = harmed((mesh, &stage.holds), &run, &before, &hold.curves);
        if harmed.is_empty() {
            return Ok((!run.is_cancelled()).then(|| finished_mesh(mesh, run)));
        }
        let around = beside(mesh, &harmed);
        let farther = beside(mesh, &around);
        if ![harmed, around, farther]
            .iter()
            .any(|corners| let_go(&mut held, corners))
        {
            break;
        }
    }
    Ok(None)
}

/// The mesh with held vertices at `start` and the panels near them made planar, while the others
/// rest; `None` if that can't be done without harm.
pub(in crate::optimise) fn nearby(
    stage: &Stage<'_>,
    mesh: &HexMesh,
    start: &[f64],
    curves: &BoundaryCurve,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Option<Run>, OptimiseError> {
    let x = unknowns(mesh);
    let moves = |v: &u32| point(start, *v as usize) != point(&x, *v as usize);
    let moved: Vec<u32> = stage.holds.held.keys().copied().filter(moves).collect();
    if moved.is_empty() {
        return Ok(None);
    }
    let (before, _) = stage.inspected(&x, options);
    let band = PartRegion::near(&stage.panels, moved.into_iter(), BAND);
    let mut solvers = band.solvers(&stage.panels)?;
    let start = stage.start_at(&band.moved(start, &x));
    let run = stage.run_projection_of(&band, &mut solvers, &start, options, progress);
    let is_usable =
        !run.is_cancelled() && harmed((mesh, &stage.holds), &run, &before, curves).is_empty();
    Ok(is_usable.then_some(run))
}

/// As [`steer`](crate::optimise::steer), without those of the held vertices that are `loose`, and
/// vertices that lie on the boundary's curves or corners stay there where panels allow it: what the
/// user holds comes first. With `rests`, panels far from that stay as they are, where they can.
///
/// # Errors
/// As [`steer`](crate::optimise::steer).
pub fn steer_on_boundary(
    mesh: &HexMesh,
    target: &dyn Target,
    (steering, loose, rests): (&Steering, &BTreeSet<u32>, bool),
    hold: Option<&BoundaryHold>,
    options: &OptimiseOptions,
    progress: &dyn Progress,
) -> Result<Optimised, OptimiseError> {
    let Some(hold) = hold else {
        return steer_with(
            mesh,
            Some(target),
            (steering, None, loose),
            options,
            progress,
        );
    };
    let mut held = already_there(mesh, hold);
    for _ in 0..ROUNDS {
        if held.is_empty() || progress.is_cancelled() {
            break;
        }
        let what = (steering, Some((&held, &hold.curves, rests)), loose);
        let Ok(result) = steer_with(mesh, Some(target), what, options, progress) else {
            break;
        };
        if result.is_sound() {
            return Ok(result);
        }
        let faces: BTreeSet<FaceId> = result.offenders.iter().map(|o| o.face).collect();
        let harmed = corners_of(mesh, &faces);
        let around = beside(mesh, &harmed);
        if ![harmed, around].iter().any(|c| let_go(&mut held, c)) {
            break;
        }
    }
    steer_with(
        mesh,
        Some(target),
        (steering, None, loose),
        options,
        progress,
    )
}

/// Vertices of the boundary that lie on the curves, and those at corners or over them: a panel that
/// was given a corner has it in its own plane.
pub(in crate::optimise) fn already_there(
    mesh: &HexMesh,
    hold: &BoundaryHold,
) -> BTreeMap<u32, Hold> {
    let topology = mesh.topology();
    let near = ON_IT * mesh.diagonal();
    let over = OVER_CORNER * mesh.mean_edge();
    let hold_of = |v: VertexId| {
        let p = mesh.position(v);
        let corner = hold.corners.iter().map(|c| (c - p).norm());
        let off = [
            corner.fold(f64::INFINITY, f64::min),
            (hold.curves.closest_point(p).position - p).norm(),
        ];
        match off {
            [corner, _] if corner < near => Some(Hold::At(p)),
            [_, curve] if curve < near => Some(Hold::OnRim),
            [corner, _] if corner < over => Some(across_panels(mesh, v)),
            _ => None,
        }
    };
    let rim = topology.boundary_vertices();
    rim.filter_map(|v| Some((v.index() as u32, hold_of(v)?)))
        .collect()
}

/// The line through a vertex across the panels there.
fn across_panels(mesh: &HexMesh, v: VertexId) -> Hold {
    let point = mesh.position(v);
    let faces = mesh.topology().faces_at(v);
    let up: Vec3 = faces.map(|f| FacePlane::of(mesh, f).normal).sum();
    match up.try_normalize(f64::MIN_POSITIVE) {
        Some(direction) => Hold::OnLine { point, direction },
        None => Hold::At(point),
    }
}

/// Lets go of vertices that slide, or if there are none of them, of corners; whether there was one.
fn let_go(held: &mut BTreeMap<u32, Hold>, harmed: &BTreeSet<u32>) -> bool {
    let count = held.len();
    held.retain(|v, hold| !harmed.contains(v) || matches!(hold, Hold::At(_)));
    if held.len() == count {
        held.retain(|v, _| !harmed.contains(v));
    }
    held.len() < count
}

/// The corners of all panels that have some of these corners.
fn beside(mesh: &HexMesh, corners: &BTreeSet<u32>) -> BTreeSet<u32> {
    let topology = mesh.topology();
    let faces: BTreeSet<FaceId> = (corners.iter())
        .flat_map(|v| topology.faces_at(VertexId::new(*v)))
        .collect();
    corners_of(mesh, &faces)
}

/// The corners of some panels.
fn corners_of(mesh: &HexMesh, faces: &BTreeSet<FaceId>) -> BTreeSet<u32> {
    let corners = faces.iter().flat_map(|f| mesh.topology().face_vertices(*f));
    corners.map(|v| v.index() as u32).collect()
}

/// Ends of interior edges slide, vertices at corners stay there.
fn holds(mesh: &HexMesh, hold: &BoundaryHold) -> BTreeMap<u32, Hold> {
    let topology = mesh.topology();
    let number = |v: VertexId| v.index() as u32;
    let between = (topology.boundary_vertices()).filter(|v| topology.face_degree(*v) == 2);
    let mut held: BTreeMap<u32, Hold> = between.map(|v| (number(v), Hold::OnCurve)).collect();
    let at_corners = near_corners(mesh, &hold.corners).into_iter();
    held.extend(at_corners.map(|(v, corner)| (number(v), Hold::At(corner))));
    held
}

/// The vertex of the boundary next to each corner of the curves, where there is one within reach.
pub(super) fn near_corners(mesh: &HexMesh, corners: &[Vec3]) -> Vec<(VertexId, Vec3)> {
    let topology = mesh.topology();
    let rim: Vec<VertexId> = topology.boundary_vertices().collect();
    let reach = CORNER_REACH * mesh.mean_edge();
    let nearest = |corner: &Vec3| {
        let distance = |v: &VertexId| (mesh.position(*v) - corner).norm();
        let nearest = rim
            .iter()
            .min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest
            .filter(|v| distance(v) < reach)
            .map(|v| (*v, *corner))
    };
    corners.iter().filter_map(nearest).collect()
}

/// Vertices of panels that holding has harmed; none if the result can be used.
fn harmed(
    (mesh, holds): (&HexMesh, &Holds),
    run: &Run,
    before: &OptimisedFigures,
    curves: &BoundaryCurve,
) -> BTreeSet<u32> {
    let topology = mesh.topology();
    let mut faces: BTreeSet<FaceId> = BTreeSet::new();
    let off = |o: &Offender| match o.fault {
        Fault::NotPlanar { distance } => distance,
        _ => f64::INFINITY,
    };
    let finite = run.offenders.iter().map(off).filter(|d| d.is_finite());
    let worst = finite.fold(0.0, f64::max);
    faces.extend((run.offenders.iter().filter(|o| off(o) > WORST * worst)).map(|o| o.face));
    let moved = |v: &VertexId| {
        let now = point(&run.x, v.index());
        (now - mesh.position(*v)).norm() > MOST_MOVE * before.mean_edge
    };
    faces.extend((topology.vertices().filter(moved)).flat_map(|v| topology.faces_at(v)));
    if faces.is_empty() {
        let after = mesh_at(mesh, &run.x);
        faces.extend(squeezed(&after, run, before));
        faces.extend(grown_small(mesh, &after));
        let drifted = drifted((mesh, holds), &after, curves).into_iter();
        faces.extend(drifted.flat_map(|v| topology.faces_at(v)));
    }
    corners_of(mesh, &faces)
}

/// Vertices of the boundary that nothing holds, and that have moved off the curve.
fn drifted(
    (before, holds): (&HexMesh, &Holds),
    after: &HexMesh,
    curves: &BoundaryCurve,
) -> Vec<VertexId> {
    let topology = before.topology();
    let distance = |p: Vec3| (curves.closest_point(p).position - p).norm();
    let off = |v: &VertexId| {
        distance(after.position(*v))
            > distance(before.position(*v)) + MOST_DRIFT * before.mean_edge()
    };
    let rim = topology.boundary_vertices();
    let is_free = |v: &VertexId| !holds.held.contains_key(&(v.index() as u32));
    rim.filter(is_free).filter(off).collect()
}

/// Panels at the boundary that have become too small, where none was.
fn grown_small(before: &HexMesh, after: &HexMesh) -> Vec<FaceId> {
    let small = small_rim_faces(before);
    let mut now = small_rim_faces(after);
    now.retain(|f| !small.contains(f));
    now
}

/// Panels that have lost much of their clearance.
fn squeezed(after: &HexMesh, run: &Run, before: &OptimisedFigures) -> Vec<FaceId> {
    let least = CLEARANCE_LEFT * before.clearance;
    if run.summary.quality.clearance >= least {
        return Vec::new();
    }
    let limit = least * after.mean_edge();
    let flat = FlatFace::all(after);
    let tight = flat
        .enumerate()
        .filter(|(_, f)| f.clearance().distance < limit);
    tight.map(|(f, _)| f).collect()
}
