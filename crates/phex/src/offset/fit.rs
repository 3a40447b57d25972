//! The parallel mesh with positive edge lengths that is closest to a surface.
//!
//! Foot points `p_v` with normals `n_v` of the surface are held while the convex quadratic program
//!
//! ```text
//! minimise    sum_v (n_v . (x_v - p_v))^2 + w_t |x_v - p_v|^2  +  w_f sum_e (l_e - s l0_e)^2  +  w_h sum_f (A(x, K) + H A(x))^2
//! subject to  x_b - x_a parallel to d_e,   s_e l_e = s_e d_e . (x_b - x_a) >= l_min
//!             open waists where edges are reversed, A(x, K) = 0 for minimal meshes
//! ```
//!
//! is solved by interior points; then new foot points are found, until the mesh rests. The mesh
//! itself, scaled, is always admissible, so that the program always has a solution. The last term,
//! off by default, asks for one mean curvature `H` (that of the last round) with the input as Gauss
//! image `K`; areas are linearised at the last round. The result is projected onto the space of
//! parallel meshes, which takes parallelism to rounding.
//!
//! | symbol | here |
//! |---|---|
//! | `d_e`, `l0_e` | direction and length of the edges of the given mesh |
//! | `s` | mean distance of neighbouring foot points over the mean `l0_e` |
//! | `w_t`, `w_f`, `w_h` | 1e-2, [`FitOptions::fairness`], [`FitOptions::constant_mean_curvature`] |
//! | `A(., .)`, `K`, `H` | mixed area, the input, mean curvature: see [`edge_offset`](super::edge_offset) |
//! | `l_min` | [`FitOptions::least_edge`] times the mean distance of neighbouring foot points |
//!
//! Source: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer freeform structures for
//! architecture" (2007), section 3. With a Koebe mesh as input the result has offsets at constant
//! edge distance ([`edge_offset`](super::edge_offset)).
//!
//! *Guaranteed*: edges parallel to those of the input to rounding and of the same sense. *Fails* to
//! come close where the surface curves in another way than the input: a mesh parallel to a convex
//! one is convex wherever its faces are, and where the ratio of the principal curvatures differs
//! much (by 3, for regular hexagons) edges run into `l_min`. The report says how far off it is.

use super::edge_offset::{face_areas, mean_curvature, mixed_area_gradient};
use super::null_space::Rows;
use super::signs::{EdgeSigns, SignError, SignedLengths, Waist, closest_normal, crossed};
use super::space::{ParallelError, ParallelSpace};
use crate::progress::{Event, Progress};
use phex_mesh::{
    EdgeId, FaceId, HexMesh, PerEdge, PerVertex, Topology, TriangleSurface, Vec3, VertexId,
};
use phex_numeric::{LinearConstraints, Status, Triplet, minimise};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Where the first foot points come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FitStart {
    /// The points of the surface whose normals are closest to those of the mesh: for a Gauss image,
    /// wherever it lies.
    #[default]
    Normals,
    /// The points of the surface that are closest to the mesh, which lies near it.
    Positions,
}

/// `w_t`: weight of the distance along the surface. It keeps the mesh from sliding off and hardly
/// costs closeness.
const TANGENTIAL: f64 = 1e-2;

/// Options of [`fit_parallel`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FitOptions {
    /// Where the first foot points come from.
    pub start: FitStart,
    /// Which edges run against those of the input.
    pub signs: EdgeSigns,
    /// Whether every face is to have the mean curvature 0, with the input as Gauss image: a linear
    /// condition.
    pub minimal: bool,
    /// `w_f`: weight of edge lengths in proportion to the input's, >= 0. It decides where the
    /// surface does not, as at the rim.
    pub fairness: f64,
    /// `w_h`: weight of one mean curvature for all faces, >= 0; lengths in mean edges. From 1 to
    /// 100 for surfaces that nearly have one.
    pub constant_mean_curvature: f64,
    /// `l_min` over the mean distance of neighbouring foot points, in (0, 1).
    pub least_edge: f64,
    /// Rounds of foot points at the most.
    pub max_rounds: usize,
    /// Root mean square of the vertices' movement along the surface's normals, in mean edges, at
    /// which the mesh rests.
    pub tolerance: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            start: FitStart::Normals,
            signs: EdgeSigns::Positive,
            minimal: false,
            fairness: 1e-3,
            constant_mean_curvature: 0.0,
            least_edge: 0.05,
            max_rounds: 20,
            tolerance: 1e-3,
        }
    }
}

/// Why nothing was fitted.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FitError {
    /// An option is out of its range.
    #[error("option {option} is {value}, it must be {range}")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// The mesh has no parallel meshes.
    #[error(transparent)]
    Parallel(#[from] ParallelError),
    /// There are no signs for the edges, or no simple panels with them.
    #[error(transparent)]
    Signs(#[from] SignError),
    /// No parallel mesh has the signs and least lengths that are asked for.
    #[error(
        "no parallel mesh has edges with these signs, each at least {least_edge} of its wished length{}: the least of them, over that of its image, is that of edge {edge} (vertices {} and {})", minimal_too(.minimal), vertices[0], vertices[1]
    )]
    NoneWithSigns {
        /// [`FitOptions::least_edge`].
        least_edge: f64,
        /// Whether mean curvature 0 was asked for.
        minimal: bool,
        /// The edge.
        edge: EdgeId,
        /// Its ends.
        vertices: [VertexId; 2],
    },
    /// The foot points coincide: the surface is nowhere like the mesh.
    #[error("all vertices have the same foot point on the surface (near vertex {vertex} of it)")]
    OneFootPoint {
        /// A vertex of the surface close to that point.
        vertex: VertexId,
    },
}

fn minimal_too(minimal: &bool) -> &'static str {
    if *minimal {
        " and panels of mean curvature 0"
    } else {
        ""
    }
}

/// A mesh parallel to the input, close to the surface.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The mesh, with the connectivity of the input. Where `K < 0` its faces look to the other side
    /// of the surface than those of the input.
    pub mesh: HexMesh,
    /// Edges that run against those of the input.
    pub reversed_edges: Vec<EdgeId>,
    /// Faces that cross themselves, by exact predicates.
    pub crossed_faces: Vec<FaceId>,
    /// How the rounds ended.
    pub status: Status,
    /// Number of rounds, each one quadratic program.
    pub rounds: usize,
    /// Largest distance of a vertex to the surface, model units.
    pub max_distance: f64,
    /// Root mean square of those distances.
    pub rms_distance: f64,
    /// Edges as short as is allowed: there the surface would rather have another mesh.
    pub edges_at_bound: usize,
    /// Mean curvature with the input as Gauss image, over model units.
    pub mean_curvature: f64,
    /// Root mean square deviation of the faces from it, over its size.
    pub mean_curvature_spread: f64,
}

/// Fits a mesh parallel to `mesh` to `surface`.
///
/// # Errors
/// If an option is out of range, or a face of the mesh is not planar, or an edge has length zero.
pub fn fit_parallel(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<Fitted, FitError> {
    fit_beyond(mesh, surface, surface, options, progress)
}

/// The same where the surface goes on beyond the part that is `given` and whose normals and
/// curvatures alone are known.
pub(crate) fn fit_beyond(
    mesh: &HexMesh,
    surface: &TriangleSurface,
    given: &TriangleSurface,
    options: &FitOptions,
    progress: &dyn Progress,
) -> Result<Fitted, FitError> {
    check(options)?;
    let space = ParallelSpace::new(mesh)?;
    let signed = SignedLengths::new(&space, given, &options.signs)?;
    let feet = match options.start {
        FitStart::Normals => feet_by_normals(mesh, given),
        FitStart::Positions => feet_by_positions(mesh, surface),
    };
    let program =
        Program::new(&space, &feet, signed, options).ok_or_else(|| FitError::OneFootPoint {
            vertex: surface
                .topology()
                .face_vertices(surface.closest_point(feet.position[0]).triangle)[0],
        })?;
    let fitted = rounds(surface, &program, feet, progress);
    // The input itself is a parallel mesh, but not one with these signs.
    let none = fitted.rounds == 0 && fitted.status == Status::NumericalBreakdown;
    match program.least_wished() {
        Some(edge) if none => Err(FitError::NoneWithSigns {
            least_edge: options.least_edge,
            minimal: options.minimal,
            edge,
            vertices: mesh.topology().edge_vertices(edge),
        }),
        _ => Ok(fitted),
    }
}

fn check(options: &FitOptions) -> Result<(), FitError> {
    let fail = |option, value, range| {
        Err(FitError::Option {
            option,
            value,
            range,
        })
    };
    for (option, value) in [
        ("fairness", options.fairness),
        ("constant_mean_curvature", options.constant_mean_curvature),
        ("tolerance", options.tolerance),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return fail(option, value, "0 or positive");
        }
    }
    if !(options.least_edge > 0.0 && options.least_edge < 1.0) {
        return fail("least_edge", options.least_edge, "between 0 and 1");
    }
    Ok(())
}

/// Foot points and normals, one per vertex.
struct SurfaceFeet {
    position: Vec<Vec3>,
    normal: Vec<Vec3>,
}

fn feet_by_positions(mesh: &HexMesh, surface: &TriangleSurface) -> SurfaceFeet {
    let feet = surface.closest_points(mesh.positions.as_slice());
    SurfaceFeet {
        position: feet.iter().map(|f| f.position).collect(),
        normal: feet.iter().map(|f| f.normal).collect(),
    }
}

fn feet_by_normals(mesh: &HexMesh, surface: &TriangleSurface) -> SurfaceFeet {
    let all: Vec<VertexId> = surface.topology().vertices().collect();
    let foot = |v| closest_normal(surface, &all, &mesh.mean_normal(v));
    let feet: Vec<VertexId> = mesh.topology().vertices().map(foot).collect();
    SurfaceFeet {
        position: feet.iter().map(|&w| surface.positions()[w]).collect(),
        normal: feet.iter().map(|&w| surface.normals()[w]).collect(),
    }
}

fn rounds(
    surface: &TriangleSurface,
    program: &Program<'_>,
    mut feet: SurfaceFeet,
    progress: &dyn Progress,
) -> Fitted {
    let (space, options) = (program.space, program.options);
    let mut mesh = program.start(&feet);
    let (mut status, mut done) = (Status::IterationLimit, 0);
    while done < options.max_rounds {
        if progress.is_cancelled() {
            status = Status::Cancelled;
            break;
        }
        let Some(next) = program.solve(&feet, &mesh).map(|x| space.closest(&x)) else {
            status = Status::NumericalBreakdown;
            break;
        };
        let movement = normal_movement(&mesh, &next, &feet) / program.unit;
        mesh = next;
        feet = feet_by_positions(&mesh, surface);
        done += 1;
        progress.report(&Event::Iteration {
            stage: "parallel",
            iteration: done,
            limit: options.max_rounds,
            residual: movement,
        });
        if movement <= options.tolerance {
            status = Status::Converged;
            break;
        }
    }
    assess(program, surface, mesh, status, done)
}

/// Root mean square of the vertices' movement along the normals of their foot points.
fn normal_movement(before: &HexMesh, after: &HexMesh, feet: &SurfaceFeet) -> f64 {
    let pairs = before.positions.iter().zip(&after.positions);
    let squares = pairs
        .zip(&feet.normal)
        .map(|((a, b), n)| (b - a).dot(n).powi(2));
    (squares.sum::<f64>() / feet.normal.len() as f64).sqrt()
}

fn assess(
    program: &Program<'_>,
    surface: &TriangleSurface,
    mesh: HexMesh,
    status: Status,
    rounds: usize,
) -> Fitted {
    let feet = surface.closest_points(mesh.positions.as_slice());
    let distances: Vec<f64> = mesh
        .positions
        .iter()
        .zip(&feet)
        .map(|(x, f)| (x - f.position).norm())
        .collect();
    let mean_square = distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64;
    let lengths = program.space.lengths(&mesh);
    let (mean_curvature, mean_curvature_spread) = mean_curvature(&mesh, program.space.mesh());
    Fitted {
        mean_curvature,
        mean_curvature_spread,
        status,
        rounds,
        max_distance: distances.iter().copied().fold(0.0, f64::max),
        rms_distance: mean_square.sqrt(),
        edges_at_bound: lengths
            .enumerate()
            .filter(|&(e, l)| l.abs() < 1.01 * program.unit * program.least[e].abs())
            .count(),
        reversed_edges: lengths
            .enumerate()
            .filter(|(_, l)| **l < 0.0)
            .map(|(e, _)| e)
            .collect(),
        crossed_faces: crossed(&mesh),
        mesh,
    }
}

/// The quadratic program, in units of the mean distance of neighbouring foot points, about the mean
/// foot point.
struct Program<'a> {
    space: &'a ParallelSpace,
    options: &'a FitOptions,
    /// Mean distance of neighbouring foot points.
    unit: f64,
    /// Least lengths of the edges, with the signs that they are to have.
    least: PerEdge<f64>,
    centre: Vec3,
    /// Lengths that edges are wished to have; by default those of the input's, with mean 1.
    natural: PerEdge<f64>,
    signed: bool,
    constraints: LinearConstraints,
}

impl<'a> Program<'a> {
    /// `None` if all foot points coincide.
    fn new(
        space: &'a ParallelSpace,
        feet: &SurfaceFeet,
        signed: Option<SignedLengths>,
        options: &'a FitOptions,
    ) -> Option<Self> {
        let t = space.mesh().topology();
        let span = |e| {
            let [a, b] = t.edge_vertices(e);
            (feet.position[a.index()] - feet.position[b.index()]).norm()
        };
        let unit = t.edges().map(span).sum::<f64>() / t.n_edges() as f64;
        if unit.is_nan() || unit <= 0.0 {
            return None;
        }
        let mean_edge = space.mesh().mean_edge();
        let (natural, waists) = match &signed {
            Some(signed) => (signed.wished.map(|l| l / unit), &signed.waists[..]),
            None => (space.lengths(space.mesh()).map(|l| l / mean_edge), &[][..]),
        };
        let least = natural.map(|l| options.least_edge * l.signum());
        let parallel = space.parallelism_rows();
        let mut rows = Rows::new(3 * t.n_vertices());
        (0..parallel.n_rows()).for_each(|i| rows.push(entries_of(parallel, i)));
        if options.minimal {
            minimal_rows(space, &mut rows);
        }
        let n_equalities = rows.n_rows();
        let mut bounds = vec![0.0; n_equalities];
        length_rows(space, &least, &mut rows, &mut bounds);
        waist_rows(t, waists, &least, &mut rows, &mut bounds);
        let of_row = |i| entries_of(&rows, i).map(move |(j, a)| (i, j, a));
        let entries = (0..rows.n_rows()).flat_map(of_row).collect();
        Some(Self {
            space,
            options,
            unit,
            least,
            centre: feet.position.iter().sum::<Vec3>() / feet.position.len() as f64,
            natural,
            signed: signed.is_some(),
            constraints: LinearConstraints::new(rows.n_columns(), entries, bounds, n_equalities),
        })
    }

    /// The edge whose wished length is the least over that of its image; `None` if all are to be
    /// positive.
    fn least_wished(&self) -> Option<EdgeId> {
        let own = self.space.lengths(self.space.mesh());
        let ratio = |e: &EdgeId| (self.natural[*e] / own[*e]).abs();
        let edges = self.space.mesh().topology().edges();
        let least = edges.min_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        least.filter(|_| self.signed || self.options.minimal)
    }

    /// The input itself, scaled and moved to the foot points.
    fn start(&self, feet: &SurfaceFeet) -> HexMesh {
        let mesh = self.space.mesh();
        let scale = self.unit / mesh.mean_edge();
        let mean = mesh.positions.iter().sum::<Vec3>() / feet.position.len() as f64;
        let shift = self.centre - mean * scale;
        mesh.mapped(|p| p * scale + shift)
    }

    /// Positions of the vertices for given foot points; `None` if the solver gives up.
    fn solve(&self, feet: &SurfaceFeet, current: &HexMesh) -> Option<PerVertex<Vec3>> {
        let (hessian, gradient) = self.objective(feet, current);
        let x = minimise(hessian, &gradient, &self.constraints)?;
        let places = x.chunks_exact(3).map(Vec3::from_column_slice);
        let places = places.map(|p| p * self.unit + self.centre);
        Some(PerVertex::from_vec(places.collect()))
    }

    /// Upper triangle of the Hessian, and the gradient at the origin.
    fn objective(&self, feet: &SurfaceFeet, current: &HexMesh) -> (Vec<Triplet>, Vec<f64>) {
        let n = 3 * feet.position.len();
        let (mut triplets, mut gradient) = (Vec::new(), vec![0.0; n]);
        for (v, (p, normal)) in feet.position.iter().zip(&feet.normal).enumerate() {
            let p = (p - self.centre) / self.unit;
            let block =
                nalgebra::Matrix3::from_diagonal_element(TANGENTIAL) + normal * normal.transpose();
            let pull = block * p;
            for j in 0..3 {
                gradient[3 * v + j] -= pull[j];
                triplets.extend((0..=j).map(|i| (3 * v + i, 3 * v + j, block[(i, j)])));
            }
        }
        if self.options.fairness > 0.0 {
            self.add_fairness(&mut triplets, &mut gradient);
        }
        if self.options.constant_mean_curvature > 0.0 {
            self.add_curvature(current, &mut triplets, &mut gradient);
        }
        (triplets, gradient)
    }

    fn add_fairness(&self, triplets: &mut Vec<Triplet>, gradient: &mut [f64]) {
        let t = self.space.mesh().topology();
        for e in t.edges() {
            let row = length_row(t.edge_vertices(e), self.space.direction(e));
            add_square(
                &row,
                -self.natural[e],
                self.options.fairness,
                triplets,
                gradient,
            );
        }
    }

    /// Squares of `A(x, K) - c A(x)`, linearised at the current mesh; `c` is its mean.
    fn add_curvature(&self, current: &HexMesh, triplets: &mut Vec<Triplet>, gradient: &mut [f64]) {
        let image = self.space.mesh();
        let image = image.mapped(|k| k / image.mean_edge());
        let current = current.mapped(|x| (x - self.centre) / self.unit);
        let c = -mean_curvature(&current, &image).0;
        for f in image.topology().faces() {
            // A(x) = A(x0, 2 x - x0) + ..., so the row is the gradient of A(x, K - 2 c x0).
            let at = |v| image.position(v) - 2.0 * c * current.position(v);
            let vertices = image.topology().face_vertices(f);
            let q: Vec<Vec3> = vertices.iter().map(|&v| at(v)).collect();
            let row: Vec<(usize, f64)> =
                mixed_area_row(vertices, &q, self.space.normal(f)).collect();
            let constant = c * face_areas(&current, &image, f)[0];
            let weight = self.options.constant_mean_curvature;
            add_square(&row, constant, weight, triplets, gradient);
        }
    }
}

/// Adds `weight (row . x + constant)^2 / 2` to an objective.
fn add_square(
    row: &[(usize, f64)],
    constant: f64,
    weight: f64,
    triplets: &mut Vec<Triplet>,
    gradient: &mut [f64],
) {
    for &(j, b) in row {
        gradient[j] += weight * b * constant;
        let upper = row.iter().filter(|&&(i, _)| i <= j);
        triplets.extend(upper.map(|&(i, a)| (i, j, weight * a * b)));
    }
}

/// Coefficients of the length of an edge in the coordinates of its ends.
fn length_row([a, b]: [VertexId; 2], d: Vec3) -> [(usize, f64); 6] {
    std::array::from_fn(|i| {
        let (v, sign) = if i < 3 { (a, -1.0) } else { (b, 1.0) };
        (3 * v.index() + i % 3, sign * d[i % 3])
    })
}

/// `-s_e l_e <= -l_min` for every edge.
fn length_rows(
    space: &ParallelSpace,
    least: &PerEdge<f64>,
    rows: &mut Rows,
    bounds: &mut Vec<f64>,
) {
    let t = space.mesh().topology();
    for (e, l) in least.enumerate() {
        rows.push(length_row(
            t.edge_vertices(e),
            -space.direction(e) * l.signum(),
        ));
        bounds.push(-l.abs());
    }
}

/// `-inward . (x_to - x_from)`, at most minus the mean least length of the face's edges.
fn waist_rows(
    t: &Topology,
    waists: &[Waist],
    least: &PerEdge<f64>,
    rows: &mut Rows,
    bounds: &mut Vec<f64>,
) {
    for waist in waists {
        rows.push(length_row([waist.from, waist.to], -waist.inward));
        let edges = t
            .face_half_edges(waist.face)
            .map(|h| least[t.edge(h)].abs());
        bounds.push(-edges.sum::<f64>() / t.valence(waist.face) as f64);
    }
}

/// `A(x, K) = 0` for every face.
fn minimal_rows(space: &ParallelSpace, rows: &mut Rows) {
    let image = space.mesh();
    let mean_edge = image.mean_edge();
    for f in image.topology().faces() {
        let corners: Vec<Vec3> = image.corners(f).map(|k| k / mean_edge).collect();
        let vertices = image.topology().face_vertices(f);
        rows.push(mixed_area_row(vertices, &corners, space.normal(f)));
    }
}

/// Coefficients of `A(x, Q)` in the coordinates of the vertices of a face with a normal.
fn mixed_area_row(
    vertices: &[VertexId],
    q: &[Vec3],
    normal: Vec3,
) -> impl Iterator<Item = (usize, f64)> {
    let by_corner = vertices.iter().zip(mixed_area_gradient(q, normal));
    by_corner.flat_map(|(v, g)| (0..3).map(move |k| (3 * v.index() + k, g[k])))
}

fn entries_of(rows: &Rows, i: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
    rows.row(i).iter().map(|&(j, a)| (j as usize, a))
}

#[cfg(test)]
mod tests;
