//! Cones where they do no harm: opposites that lie close together cancelled, or all of them where
//! they are prescribed.
//!
//! The smoothest field has pairs of cones of index `+1/6` and `-1/6` wherever the metric's own
//! curvature changes quickly; each costs irregular panels and gives nothing back.

use super::guides::Cone;
use super::intrinsic::IntrinsicMesh;
use super::rosy::SixFoldField;
use super::turns::{Route, Turns, cones, routes, settle};
use super::{DirectionOptions, Directions};
use crate::progress::Progress;
use phex_mesh::{FaceId, PerEdge, PerFace, PerVertex, Topology, TriangleSurface, Vec3};
use phex_numeric::NumericError;
use thiserror::Error;

/// Angles of a field and its turns along edges.
pub(crate) struct TurnedField {
    /// Angle at each vertex, radians.
    pub angle: PerVertex<f64>,
    /// Turns along each edge from its origin to its target, sixths.
    pub turn: PerEdge<i32>,
    /// Index in each triangle, sixths.
    pub cone: PerFace<i32>,
    /// Pairs that were cancelled.
    pub cancelled: usize,
}

/// Why prescribed cones can't be.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum ConeError {
    /// The indices do not add up.
    #[error(
        "the prescribed cones have indices that add up to {found} sixths; on a closed surface of this topology they must add up to {needed}"
    )]
    Sum {
        /// Sum of the indices, sixths.
        found: i64,
        /// Six times the Euler characteristic.
        needed: i64,
    },
    /// Two cones lie in one triangle of the refined surface.
    #[error("the prescribed cones {first} and {second} lie in the same place (counted from 0)")]
    SamePlace {
        /// The first of them.
        first: usize,
        /// The second.
        second: usize,
    },
}

/// Distance, in panels, up to which opposite cones are cancelled by default.
const NEAR_REACH: f64 = 4.0;
/// Opposite cones next to a cone with which it may cancel: on a surface of slivers there are
/// thousands within reach.
const NEAREST: usize = 16;

/// The field with its cones where they should be.
///
/// # Errors
/// If a linear system can't be solved.
pub(crate) fn settle_cones(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    field: SixFoldField,
    options: &DirectionOptions,
    progress: &dyn Progress,
) -> Result<TurnedField, NumericError> {
    let topology = surface.topology();
    let mut turns = Turns::smallest(topology, mesh, &field.angle);
    let (mut cancelled, mut moved) = (0, 0);
    match prescribed_faces(surface, &options.guides.cones) {
        Ok(wanted) if !wanted.is_empty() => moved = prescribe(surface, mesh, &mut turns, &wanted),
        _ => {
            let reach = options.cancel_reach.unwrap_or(NEAR_REACH);
            cancelled = cancel(surface, mesh, &mut turns, reach, progress);
        }
    }
    let angle = if cancelled + moved == 0 {
        field.angle
    } else {
        settle(topology, mesh, &field, &turns.turn)?
    };
    Ok(TurnedField {
        cone: cones(topology, mesh, &angle, &turns.turn),
        angle,
        turn: turns.turn,
        cancelled,
    })
}

/// Cancels opposite cones at most `reach` lattice spacings apart, the closest first; how many
/// pairs. A surface of slivers has thousands, so it ends early when it is asked to.
fn cancel(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    turns: &mut Turns,
    reach: f64,
    progress: &dyn Progress,
) -> usize {
    let topology = surface.topology();
    let cone = turns.cone.clone();
    let positive = topology.faces().filter(|f| cone[*f] > 0);
    let mut pairs: Vec<Route> = positive
        .take_while(|_| !progress.is_cancelled())
        .flat_map(|f| routes(topology, mesh, f, (reach, NEAREST), false, |g| cone[g] < 0))
        .collect();
    pairs.sort_by(|a, b| a.length.total_cmp(&b.length));
    let mut cancelled = 0;
    for pair in pairs {
        let Some(to) = pair.to else { continue };
        if turns.cone[pair.from] > 0 && turns.cone[to] < 0 {
            turns.carry(topology, &pair, 1);
            cancelled += 1;
        }
    }
    cancelled
}

/// Whether some opposite cones lie at most `reach` lattice spacings apart.
pub(crate) fn has_opposites(topology: &Topology, directions: &Directions, reach: f64) -> bool {
    let (mesh, cone) = (&directions.intrinsic, &directions.cone);
    let has_opposite = |f| {
        let opposite = |g: FaceId| cone[g] < 0;
        !routes(topology, mesh, f, (reach, 1), false, opposite).is_empty()
    };
    let mut positive = topology.faces().filter(|f| cone[*f] > 0);
    cone.iter().any(|index| *index < 0) && positive.any(has_opposite)
}

/// The triangles of prescribed cones with their indices.
///
/// # Errors
/// If they can't be.
pub(crate) fn prescribed_faces(
    surface: &TriangleSurface,
    cones: &[Cone],
) -> Result<Vec<(FaceId, i32)>, ConeError> {
    let topology = surface.topology();
    let points: Vec<Vec3> = cones.iter().map(|c| Vec3::from(c.position)).collect();
    let faces = surface.closest_points(&points).into_iter();
    let placed: Vec<(FaceId, i32)> = faces
        .zip(cones)
        .map(|(p, c)| (p.triangle, c.index))
        .collect();
    for (second, (f, _)) in placed.iter().enumerate() {
        if let Some(first) = placed[..second].iter().position(|(g, _)| f == g) {
            return Err(ConeError::SamePlace { first, second });
        }
    }
    let found = cones.iter().map(|c| i64::from(c.index)).sum();
    let needed = 6 * topology.euler_characteristic();
    let closed = topology.is_closed();
    if closed && found != needed && !cones.is_empty() {
        return Err(ConeError::Sum { found, needed });
    }
    Ok(placed)
}

/// Carries indices, one sixth at a time and the shortest way, until the cones are those that are
/// wanted; how many.
fn prescribe(
    surface: &TriangleSurface,
    mesh: &IntrinsicMesh,
    turns: &mut Turns,
    wanted: &[(FaceId, i32)],
) -> usize {
    let topology = surface.topology();
    let mut excess = turns.cone.clone();
    for (f, index) in wanted {
        excess[*f] -= index;
    }
    let open = !topology.is_closed();
    let mut moved = 0;
    for f in topology.faces() {
        while excess[f] != 0 {
            let sign = excess[f].signum();
            let opposite = |g: FaceId| excess[g].signum() == -sign;
            let ways = routes(topology, mesh, f, (f64::INFINITY, 1), open, opposite);
            let Some(way) = ways.first() else {
                return moved;
            };
            turns.carry(topology, way, sign);
            excess[f] -= sign;
            if let Some(to) = way.to {
                excess[to] += sign;
            }
            moved += 1;
        }
    }
    moved
}
