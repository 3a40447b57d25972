//! Conjugate curve networks: two families of curves whose tangents `r, s` satisfy `II(r, s) = 0`
//! everywhere.
//!
//! 1. [`cross`]: a cross field that follows the principal directions (or the projection of a given
//!    axis) where the two curvatures differ, smooth elsewhere, without singularities, combed into
//!    one direction per vertex ([`flat`]).
//! 2. [`conjugate`]: the nearest conjugate pair `r, s`, or `r` conjugate to a given `s`.
//! 3. [`function`]: functions `u, v` with `s . grad u = 0`, `r . grad v = 0` as well as possible;
//!    along curves of one family the other function counts. Round holes and handles they have
//!    [`periods`]. Sides of the boundary that follow a family become curves of it.
//! 4. [`curves`]: level lines, the network itself.
//!
//! Source: W. Wang and Y. Liu, "A note on planar hexagonal meshes" (2010), section 3, begin with a
//! conjugate network and leave open how it is made. Fields in place of tracing: curves that are
//! level lines can neither run together nor stop, and close exactly. Curves follow the field in the
//! sense of least squares, not exactly.
//!
//! | symbol | here |
//! |---|---|
//! | `r`, `s` | [`RowField::row`], [`RowField::column`] |
//! | `u`, `v` | [`ConjugateNetwork::along`], [`ConjugateNetwork::across`]: arc lengths, about |
//! | `q(t) = II(t, t)` | normal curvature along a unit tangent |
//!
//! Guaranteed: the network has no singularities; rows are the family with the smaller normal
//! curvature on most of the area. Fails, with an error that says where: on closed surfaces that are
//! no torus, where the directions turn round a hole, and where the functions fold over.

pub(crate) mod conjugacy;
pub(crate) mod conjugate;
pub(crate) mod cross;
pub(crate) mod curves;
pub(crate) mod flat;
pub(crate) mod function;
pub(crate) mod periods;
mod sides;

pub use conjugacy::Conjugacy;
pub(crate) use conjugacy::conjugacy;
pub use curves::Curve;
pub(crate) use curves::level_lines;
pub(crate) use function::{Function, FunctionFamily};

use super::intrinsic::IntrinsicMesh;
use crate::curvature::{Curvature, Principal};
use crate::smooth_surface::subdivide::Refinement;
use cross::DirectionWish;
use function::Guide;
use nalgebra::Matrix3;
use phex_mesh::{FaceId, PerEdge, PerFace, PerVertex, TriangleSurface, Vec3};
use phex_numeric::NumericError;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Difference of the principal curvatures, over the surface's large ones, at which their directions
/// count half.
const UMBILIC: f64 = 0.25;

/// Which conjugate network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum NetworkFamily {
    /// Lines of curvature.
    #[default]
    Principal,
    /// Columns run along the projection of an axis to the surface, rows conjugate to them.
    ConjugateTo(
        /// The axis, of any length but 0.
        [f64; 3],
    ),
}

/// How a network is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkOptions {
    /// Which network.
    pub family: NetworkFamily,
    /// Weight of the directions against smoothness, per square of the panel length. Large values
    /// follow noise.
    pub alignment: f64,
    /// `W`: how much more the direction of the curves counts than their even spacing.
    pub strictness: f64,
}

impl Default for NetworkOptions {
    fn default() -> Self {
        Self {
            family: NetworkFamily::Principal,
            alignment: 10.0,
            strictness: 100.0,
        }
    }
}

/// Why a surface has no network.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// A closed surface that is no torus.
    #[error(
        "the surface has no global conjugate network: a closed surface of Euler characteristic {euler} has singular points \
         in every direction field, here {count}, one near ({:.3}, {:.3}, {:.3})", near.x, near.y, near.z
    )]
    Closed {
        /// Euler characteristic.
        euler: i64,
        /// Number of singular triangles.
        count: usize,
        /// The first of them.
        near: Vec3,
    },
    /// Singular points that smoothing does not remove.
    #[error(
        "the surface has no global conjugate network: {count} singular points of its directions remain, one near \
         ({:.3}, {:.3}, {:.3})", near.x, near.y, near.z
    )]
    Singular {
        /// Number of singular triangles.
        count: usize,
        /// The first of them.
        near: Vec3,
    },
    /// The field does not return to itself round a hole or a handle.
    #[error(
        "the surface has no global conjugate network: round a hole or a handle rows turn by {quarter_turns} quarter turns"
    )]
    Turning {
        /// By how much.
        quarter_turns: i32,
    },
    /// The functions are not one to one.
    #[error(
        "no regular conjugate network was found: {count} triangles fold over, one near ({:.3}, {:.3}, {:.3})",
        near.x, near.y, near.z
    )]
    Folded {
        /// Number of folded triangles.
        count: usize,
        /// The first of them.
        near: Vec3,
    },
    /// The axis of a family has no direction.
    #[error("the axis of the network must be finite and not zero")]
    BadAxis,
    /// A linear system could not be solved.
    #[error("the network's equations could not be solved: {0}")]
    Numeric(#[from] NumericError),
}

impl NetworkError {
    /// The same error with its place mapped, to model coordinates say.
    pub fn mapped(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        match &mut self {
            Self::Closed { near, .. } | Self::Singular { near, .. } | Self::Folded { near, .. } => {
                *near = map(*near);
            }
            Self::Turning { .. } | Self::BadAxis | Self::Numeric(_) => {}
        }
        self
    }
}

/// The two directions of a network at every vertex.
#[derive(Clone, Debug)]
pub(crate) struct RowField {
    /// Unit tangent `r` along the rows.
    pub row: PerVertex<Vec3>,
    /// Unit tangent `s` conjugate to it, on its left.
    pub column: PerVertex<Vec3>,
    /// How much of the wished alignment was left when no singularity remained, at most 1.
    pub alignment_kept: f64,
}

/// Directions of rows and columns at the scale of panels of length `panel_length`.
///
/// # Errors
/// If there is no field without singularities.
pub(crate) fn row_field(
    surface: &TriangleSurface,
    curvature: &Curvature,
    panel_length: f64,
    options: &NetworkOptions,
) -> Result<RowField, NetworkError> {
    let topology = surface.topology();
    let unit = Matrix3::identity() / (panel_length * panel_length);
    let mesh = IntrinsicMesh::new(surface, &PerVertex::filled(topology.n_vertices(), unit));
    let principal = curvature.principal();
    let wishes = wishes(curvature, &principal, options)?;
    let euler = topology.euler_characteristic();
    if topology.is_closed() && euler != 0 {
        let (count, near) = cross::singular_triangles(surface, &mesh, &wishes)?;
        return Err(NetworkError::Closed { euler, count, near });
    }
    let combed = cross::combed_cross_field(surface, &mesh, &wishes)?;
    let flat = UMBILIC * large_curvature(&principal);
    let quarter = follows_across(curvature, &combed.direction, &wishes);
    let pair = |v| {
        let (n, form) = (curvature.normal[v], &curvature.tensor[v]);
        let d = if quarter {
            n.cross(&combed.direction[v])
        } else {
            combed.direction[v]
        };
        match options.family {
            NetworkFamily::Principal => conjugate::nearest_pair(n, form, d, flat),
            NetworkFamily::ConjugateTo(_) => [conjugate::conjugate_row(n, form, d, flat), d],
        }
    };
    let pairs = PerVertex::from_fn(topology.n_vertices(), pair);
    let field = RowField {
        row: pairs.map(|p| p[0]),
        column: pairs.map(|p| p[1]),
        alignment_kept: combed.kept,
    };
    let turn = options.family == NetworkFamily::Principal && field.is_steep(curvature, &mesh);
    Ok(if turn { field.turned() } else { field })
}

/// Whether the other arms of the crosses are those that follow the wishes.
fn follows_across(
    curvature: &Curvature,
    direction: &PerVertex<Vec3>,
    wishes: &PerVertex<DirectionWish>,
) -> bool {
    let across = |(v, d): (phex_mesh::VertexId, &Vec3)| {
        let wish = &wishes[v];
        let along = d.dot(&wish.direction).powi(2);
        let left = curvature.normal[v].cross(d).dot(&wish.direction).powi(2);
        wish.weight * (left - along)
    };
    direction.enumerate().map(across).sum::<f64>() > 0.0
}

/// The 90 % quantile of the larger principal curvature, at least a thousandth of the reciprocal
/// diagonal.
fn large_curvature(principal: &PerVertex<Principal>) -> f64 {
    super::metric::large_curvature(principal).max(1e-3)
}

fn wishes(
    curvature: &Curvature,
    principal: &PerVertex<Principal>,
    options: &NetworkOptions,
) -> Result<PerVertex<DirectionWish>, NetworkError> {
    let axis = match options.family {
        NetworkFamily::Principal => None,
        NetworkFamily::ConjugateTo(axis) => {
            let axis = Vec3::from(axis).try_normalize(0.0);
            let finite = axis.filter(|a| a.iter().all(|c| c.is_finite()));
            Some(finite.ok_or(NetworkError::BadAxis)?)
        }
    };
    let half = UMBILIC * large_curvature(principal);
    Ok(PerVertex::from_fn(principal.len(), |v| match axis {
        Some(axis) => {
            let (direction, length) = conjugate::projected(curvature.normal[v], axis);
            DirectionWish {
                direction,
                weight: options.alignment * length * length,
            }
        }
        None => {
            let p = &principal[v];
            let square = (p.large - p.small).powi(2);
            let share = square / (square + half * half);
            DirectionWish {
                direction: p.small_direction,
                weight: options.alignment * share * curvature.confidence[v],
            }
        }
    }))
}

impl RowField {
    /// Whether rows are curved more than columns on most of the area.
    fn is_steep(&self, curvature: &Curvature, mesh: &IntrinsicMesh) -> bool {
        let form = |d: Vec3, v| d.dot(&(curvature.tensor[v] * d)).abs();
        let steeper: f64 = self
            .row
            .enumerate()
            .map(|(v, r)| {
                let (along, across) = (form(*r, v), form(self.column[v], v));
                mesh.mass[v] * (along - across) / (along + across).max(f64::MIN_POSITIVE)
            })
            .sum();
        steeper > 0.0
    }

    /// Rows along the columns.
    fn turned(self) -> Self {
        Self {
            row: self.column,
            column: self.row.map(|r| -r),
            ..self
        }
    }

    /// The directions of the next finer level.
    pub fn refined(&self, step: &Refinement) -> Self {
        let unit = |d: &PerVertex<Vec3>| {
            step.apply(d)
                .map(|d| d.try_normalize(0.0).unwrap_or_else(Vec3::x))
        };
        Self {
            row: unit(&self.row),
            column: unit(&self.column),
            ..*self
        }
    }
}

/// Two families of curves as level lines.
#[derive(Clone, Debug)]
pub(crate) struct ConjugateNetwork {
    /// Basis of the closed cochains, to which the periods belong.
    pub basis: Vec<PerEdge<i32>>,
    /// `u`: counts along rows; its level lines are the columns.
    pub along: FunctionFamily,
    /// `v`: counts across rows; its level lines are the rows.
    pub across: FunctionFamily,
}

/// Share of the area that may fold over, at corners of the boundary say.
const MAX_FOLDED: f64 = 0.01;
/// Share from which less strictness is tried.
const SOME_FOLDED: f64 = 5e-4;

/// The network whose curves follow the directions of `field`.
///
/// # Errors
/// If the curves fold over.
pub(crate) fn conjugate_network(
    surface: &TriangleSurface,
    field: &RowField,
    options: &NetworkOptions,
) -> Result<ConjugateNetwork, NetworkError> {
    let basis = periods::cochain_basis(surface.topology());
    let guide = |f: FaceId| guide(surface, field, f);
    let along = PerFace::from_fn(surface.topology().n_faces(), |f| guide(f)[0]);
    let across = PerFace::from_fn(surface.topology().n_faces(), |f| guide(f)[1]);
    let held = [&along, &across].map(|guides| sides::followed(surface, |f| guides[f].level));
    let mut best: Option<(Folded, ConjugateNetwork)> = None;
    let mut strictness = options.strictness.max(1.0);
    loop {
        let network = ConjugateNetwork {
            along: function::following(surface, &basis, &along, &held[0], strictness)?,
            across: function::following(surface, &basis, &across, &held[1], strictness)?,
            basis: basis.clone(),
        };
        let folded = network.folded(surface);
        if best.as_ref().is_none_or(|b| folded.share < b.0.share) {
            best = Some((folded, network));
        }
        let (least, _) = best.as_ref().expect("a network has been tried");
        if least.share <= SOME_FOLDED || strictness <= 1.0 {
            break;
        }
        strictness = (0.1 * strictness).max(1.0);
    }
    let (Folded { share, count, near }, network) = best.expect("a network has been tried");
    if share > MAX_FOLDED {
        return Err(NetworkError::Folded { count, near });
    }
    Ok(network)
}

/// Triangles that fold over.
struct Folded {
    share: f64,
    count: usize,
    near: Vec3,
}

/// Guides of `u` and of `v` in a triangle.
fn guide(surface: &TriangleSurface, field: &RowField, f: FaceId) -> [Guide; 2] {
    let normal = surface.area_vector(f).normalize();
    let mean = |d: &PerVertex<Vec3>| {
        let sum: Vec3 = surface
            .topology()
            .face_vertices(f)
            .iter()
            .map(|&v| d[v])
            .sum();
        conjugate::projected(normal, sum).0
    };
    let (row, column) = (mean(&field.row), mean(&field.column));
    let follow = |level, across| Guide { level, across };
    [follow(column, row), follow(row, column)]
}

impl ConjugateNetwork {
    /// The functions at the given scales with the periods that come of them.
    pub fn functions(&self, surface: &TriangleSurface, scale: [f64; 2]) -> [Function; 2] {
        let of = |family: &FunctionFamily, scale: f64| {
            let periods: Vec<f64> = family.periods.iter().map(|p| p * scale).collect();
            family.function(surface.topology(), &self.basis, scale, &periods)
        };
        [of(&self.along, scale[0]), of(&self.across, scale[1])]
    }

    fn folded(&self, surface: &TriangleSurface) -> Folded {
        let [u, v] = self.functions(surface, [1.0, 1.0]);
        let is_folded = |f: &FaceId| {
            let turn = u.gradient(surface, *f).cross(&v.gradient(surface, *f));
            turn.dot(&surface.area_vector(*f)) <= 0.0
        };
        let folded: Vec<FaceId> = surface.topology().faces().filter(is_folded).collect();
        let area = |f: &FaceId| surface.face_area(*f);
        let centre = |f: &FaceId| surface.centroid(*f);
        Folded {
            share: folded.iter().map(area).sum::<f64>() / surface.area(),
            count: folded.len(),
            near: folded.first().map_or(Vec3::zeros(), centre),
        }
    }
}
