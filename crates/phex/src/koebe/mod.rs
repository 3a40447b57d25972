//! Koebe meshes: all edges touch the unit sphere.
//!
//! Every 3-connected planar graph is that of a convex polyhedron whose edges touch the unit sphere,
//! unique up to Moebius transformations (Koebe, Andreev, Thurston). Each vertex sees the sphere in
//! a circle, each face cuts it in a circle; circles of a vertex and a face that holds it cross at
//! right angles in the touching points of two edges. After a stereographic projection the
//! logarithms `rho` of their radii are the minimum of a convex energy with
//!
//! ```text
//! dS/drho_j       = Phi_j - sum_k 2 atan(exp(rho_k - rho_j))      gradient
//! d2S/drho_j drho_k = -1 / cosh(rho_j - rho_k)                    Hessian, a graph Laplacian
//! ```
//!
//! over the circles `k` orthogonal to `j`. The steps: graph test, Newton's method with a line
//! search (`radii`), circles laid out in the plane (`layout`), lifted to the sphere and balanced
//! (`sphere`), Newton's method in space (`polish`), rotation towards the input.
//!
//! Source: Bobenko and Springborn, "Variational principles for circle patterns and Koebe's theorem"
//! (2004); Springborn, "A unique representation of polyhedral types" (2005) for the balance.
//!
//! | symbol | here |
//! |---|---|
//! | `rho_j`, `Phi_j` | `Radii::rho`, `Radii::target_angle` (2 pi but for boundary vertices) |
//! | circles | `Circles`: node `v` of a vertex, node `n_vertices + f` of a face |
//! | kite of a vertex and a face | the half-edge that leaves the vertex in the face |
//! | vertex `x_v`, pole `y_f` of a face plane | `Poles`: `x_v . y_f = 1` if the face holds the vertex |
//!
//! A *closed* mesh: one touching point goes to infinity, its four circles become the sides of a
//! rectangle. The result is the one whose touching points have their mean in the centre of the
//! sphere; it depends on the graph alone, up to rotation. A *patch* (a mesh with one boundary
//! loop): faces and inner vertices have full angles, circles of boundary vertices are as
//! [`BoundaryCondition`] says; for every such choice with given radii there is one pattern. It
//! covers a cap about the north pole.
//!
//! *Guaranteed*: a refused graph is refused with the element that is wrong. If the outcome is
//! `Converged`, edges touch the sphere and faces are planar to 1e-13 of its radius, and the mesh
//! has the orientation of the input. *Fails*: for angles prescribed at a boundary that no pattern
//! has ([`KoebeError::NoPattern`], or an outcome that is not `Converged`). Graphs whose circles
//! differ in size by more than 1e7 keep the guarantee, but the smallest faces are then as small as
//! its error.

mod circles;
mod graph;
mod layout;
mod patch;
mod polish;
mod radii;
mod sphere;

use crate::progress::{Event, Progress};
use circles::{Circles, NodeId};
use layout::{PlaneLayout, lay_out};
use nalgebra::Matrix3;
use phex_mesh::{EdgeId, FaceId, HexMesh, PerEdge, PerFace, PerVertex, Vec2, Vec3, VertexId};
use phex_numeric::{NumericError, Outcome, Record, Status};
use polish::Poles;
use radii::{Radii, RadiiOptions};
use serde::{Deserialize, Serialize};
use sphere::SphereCircles;
use thiserror::Error;

/// Why a mesh has no Koebe mesh.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum KoebeError {
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
    /// The mesh is not connected.
    #[error("the mesh has {components} components, a Koebe mesh has one")]
    Components {
        /// Their number.
        components: usize,
    },
    /// The mesh is neither closed nor a disc.
    #[error("the mesh has {boundary_loops} boundary loops, a Koebe mesh has none or one")]
    BoundaryLoops {
        /// Their number.
        boundary_loops: usize,
    },
    /// The mesh is not drawn on a sphere.
    #[error("the mesh has genus {genus}, its graph is not drawn on a sphere")]
    Genus {
        /// Number of handles.
        genus: i64,
    },
    /// An inner vertex has too few edges.
    #[error(
        "the graph is not 3-connected: vertex {vertex} has {degree} edges, at least 3 are needed"
    )]
    LowDegree {
        /// The vertex.
        vertex: VertexId,
        /// Number of its edges.
        degree: usize,
    },
    /// Two vertices cut the graph.
    #[error(
        "the graph is not 3-connected: without vertices {} and {} it falls apart (faces {} and {} share both, but no edge between them)",
        vertices[0], vertices[1], faces[0], faces[1]
    )]
    SeparatingPair {
        /// The vertices.
        vertices: [VertexId; 2],
        /// Two faces that hold both.
        faces: [FaceId; 2],
    },
    /// The mesh is flat: its normals give no Gauss image.
    #[error("the mesh is flat at vertex {vertex}: its normals give its boundary no radii")]
    NoGaussImage {
        /// A boundary vertex where the Gauss image collapses or folds.
        vertex: VertexId,
    },
    /// The radii grow without bound.
    #[error(
        "no circles have the angles that are asked for at the boundary (error {residual:.1e} radians)"
    )]
    NoPattern {
        /// Largest error of an angle sum, radians.
        residual: f64,
    },
    /// The equations could not be solved.
    #[error("the equations of the circles could not be solved: {0}")]
    Numeric(#[from] NumericError),
}

/// What the circles of the boundary vertices of a patch are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryCondition {
    /// All of one radius in the plane: the boundary's angles follow, sizes vary least over the
    /// patch.
    #[default]
    EqualRadii,
    /// As large as in the Gauss image of the input, which must be curved: the best start for a
    /// parallel mesh like the input.
    GaussImage,
    /// As large as in the input, whose vertices lie on the unit sphere: the pattern is laid over
    /// it.
    Sphere,
    /// At the angles of the input: straight boundaries stay straight, before they are projected to
    /// the sphere.
    Angles,
}

/// Newton steps in space at the most; 1 or 2 are usual.
const MOST_POLISH_STEPS: usize = 5;

/// Options of [`koebe`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct KoebeOptions {
    /// What the circles of the boundary vertices of a patch are; closed meshes do not ask.
    pub boundary: BoundaryCondition,
    /// Mean angle in degrees between the middle of a patch and its boundary, seen from the centre
    /// of the sphere; in (0, 180). Not used with [`BoundaryCondition::GaussImage`].
    pub opening: f64,
    /// Newton steps for the radii at the most; 6 to 10 are usual.
    pub max_iterations: usize,
    /// Error of the angle sums, radians, at which the radii are good enough to be laid out.
    pub angle_tolerance: f64,
}

impl Default for KoebeOptions {
    fn default() -> Self {
        Self {
            boundary: BoundaryCondition::EqualRadii,
            opening: 60.0,
            max_iterations: 40,
            angle_tolerance: 1e-10,
        }
    }
}

/// A Koebe mesh.
#[derive(Clone, Debug)]
pub struct Koebe {
    /// The mesh, with the connectivity of the input.
    pub mesh: HexMesh,
    /// Pole `y` of the plane of each face: `y . x = 1` on it.
    pub face_poles: PerFace<Vec3>,
    /// How it ended; records of phase 0 belong to the radii (residual: angle), those of phase 1 to
    /// the steps in space.
    pub outcome: Outcome,
    /// How far it is from what it should be.
    pub defects: KoebeDefects,
}

impl Koebe {
    /// Whether the mesh is what it should be, to rounding.
    pub fn is_converged(&self) -> bool {
        self.outcome.status == Status::Converged
    }
}

/// How far a mesh is from a Koebe mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct KoebeDefects {
    /// Largest distance of the line of an edge from the unit sphere.
    pub tangency: f64,
    /// Largest distance of a vertex from the plane (that of the pole) of a face that holds it.
    pub planarity: f64,
    /// Distance of the mean of the touching points from the centre: 0 for a balanced closed mesh.
    pub imbalance: f64,
    /// Edges that miss the point where their line comes closest to the centre, by more than the
    /// size (3e-8) of a circle whose cap is as high as rounding.
    pub untouched_edges: usize,
}

impl KoebeDefects {
    /// Measures a mesh whose face planes have the given poles.
    ///
    /// # Panics
    /// If there is not one pole per face.
    pub fn of(mesh: &HexMesh, face_poles: &PerFace<Vec3>) -> Self {
        let t = mesh.topology();
        let touching = touching_points(mesh);
        let height = |h| {
            let y = face_poles[t.face(h)];
            (y.dot(&mesh.position(t.origin(h))) - 1.0).abs() / y.norm()
        };
        let untouched = |e: &EdgeId| {
            let [a, b] = t.edge_vertices(*e).map(|v| mesh.position(v) - touching[*e]);
            a.dot(&b) > 0.0 && a.norm().min(b.norm()) > 3e-8
        };
        Self {
            tangency: touching
                .iter()
                .map(|p| (p.norm() - 1.0).abs())
                .fold(0.0, f64::max),
            planarity: t.half_edges().map(height).fold(0.0, f64::max),
            imbalance: touching.iter().sum::<Vec3>().norm() / touching.len() as f64,
            untouched_edges: t.edges().filter(untouched).count(),
        }
    }
}

/// The point of the line of each edge that is closest to the origin.
pub fn touching_points(mesh: &HexMesh) -> PerEdge<Vec3> {
    PerEdge::from_fn(mesh.topology().n_edges(), |e| {
        let [a, b] = mesh.topology().edge_vertices(e).map(|v| mesh.position(v));
        let along = b - a;
        // From the end that is closer, so that rounding stays small beside the edge.
        let (from, along) = if a.norm() <= b.norm() {
            (a, along)
        } else {
            (b, -along)
        };
        from - along * (from.dot(&along) / along.norm_squared())
    })
}

/// The Koebe mesh with the connectivity of `mesh`, closed or with one boundary loop. Positions
/// matter only for its rotation and where [`BoundaryCondition`] says so.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::Silent;
/// use phex::koebe::{KoebeOptions, koebe, touching_points};
///
/// let found = koebe(&cube, &KoebeOptions::default(), &Silent)?;
/// assert!(found.is_converged());
/// let touching = touching_points(&found.mesh);
/// assert!(touching.iter().all(|p| (p.norm() - 1.0).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If an option is out of its range, the mesh is not drawn on a sphere, or its graph is not
/// 3-connected (for a patch: with a vertex outside joined to all of its boundary).
pub fn koebe(
    mesh: &HexMesh,
    options: &KoebeOptions,
    progress: &dyn Progress,
) -> Result<Koebe, KoebeError> {
    check(options)?;
    graph::check(mesh.topology())?;
    let circles = Circles::new(mesh.topology());
    let closed = mesh.topology().is_closed();
    let mut radii = if closed {
        closed_radii(&circles)
    } else {
        patch::radii(&circles, mesh, options)?
    };
    let solve = RadiiOptions {
        max_iterations: options.max_iterations,
        tolerance: options.angle_tolerance,
    };
    let mut outcome = radii.solve(
        &circles,
        &solve,
        &reporter(options.max_iterations, progress),
    )?;
    let residual = outcome.history.last().map_or(0.0, |record| record.residual);
    let layout = lay_out(&circles, &radii).ok_or(KoebeError::NoPattern { residual })?;
    let mut sphere = if closed {
        project_closed(&layout)
    } else {
        patch::project(&circles, &layout, mesh, options)
    };
    if closed {
        sphere.normalise();
    }
    let mut poles = poles(&circles, &sphere);
    if outcome.status == Status::Converged {
        let report = reporter(MOST_POLISH_STEPS, progress);
        outcome.append(polish::polish(
            mesh.topology(),
            &mut poles,
            MOST_POLISH_STEPS,
            &report,
        )?);
    }
    if closed {
        sphere::balance(&mut poles, mesh);
    }
    let aims = aims(mesh, options.boundary);
    Ok(finished(mesh, &aims, poles, outcome))
}

fn check(options: &KoebeOptions) -> Result<(), KoebeError> {
    let fail = |option, value, range| {
        Err(KoebeError::Option {
            option,
            value,
            range,
        })
    };
    if !(options.opening > 0.0 && options.opening < 180.0) {
        return fail("opening", options.opening, "between 0 and 180 degrees");
    }
    if !(options.angle_tolerance > 0.0 && options.angle_tolerance < 1.0) {
        return fail(
            "angle_tolerance",
            options.angle_tolerance,
            "between 0 and 1",
        );
    }
    Ok(())
}

/// Passes records on; says whether to go on.
fn reporter(limit: usize, progress: &dyn Progress) -> impl Fn(usize, &Record) -> bool + '_ {
    move |iteration, record| {
        let residual = record.residual;
        progress.report(&Event::Iteration {
            stage: "koebe",
            iteration,
            limit,
            residual,
        });
        !progress.is_cancelled()
    }
}

/// One touching point at infinity: the circles through it are lines, and the size of the rectangle
/// is free.
fn closed_radii(circles: &Circles) -> Radii {
    let infinite = circles_through(circles, EdgeId::new(0));
    let mut radii = Radii::new(circles, |node| {
        infinite.contains(&node).then_some(f64::INFINITY)
    });
    radii.fix_scale();
    radii
}

/// The circles of the ends and sides of an edge.
fn circles_through(circles: &Circles, e: EdgeId) -> Vec<NodeId> {
    let t = circles.topology;
    let sides = t.edge_faces(e).map(|f| circles.of_face(f));
    sides
        .chain(t.edge_vertices(e).map(|v| circles.of_vertex(v)))
        .collect()
}

/// Half of the touching points into each hemisphere, so that the Moebius transformation that is
/// left is small.
fn project_closed(layout: &PlaneLayout) -> SphereCircles {
    let points: Vec<Vec2> = layout.touching.iter().flatten().copied().collect();
    let origin = Vec2::new(
        median(points.iter().map(|p| p.x)),
        median(points.iter().map(|p| p.y)),
    );
    let size = median(points.iter().map(|p| (p - origin).norm()));
    SphereCircles::project(
        layout,
        origin,
        Vec2::new(1.0 / size.max(f64::MIN_POSITIVE), 0.0),
    )
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn poles(circles: &Circles, sphere: &SphereCircles) -> Poles {
    let t = circles.topology;
    Poles {
        vertices: PerVertex::from_fn(t.n_vertices(), |v| sphere.pole(circles.of_vertex(v))),
        faces: PerFace::from_fn(t.n_faces(), |f| sphere.pole(circles.of_face(f))),
    }
}

fn finished(input: &HexMesh, aims: &PerVertex<Vec3>, poles: Poles, outcome: Outcome) -> Koebe {
    let rotation = rotation_towards(aims, &poles.vertices);
    let mesh = input.with_positions(poles.vertices.map(|x| rotation * x));
    let face_poles = poles.faces.map(|y| rotation * y);
    Koebe {
        defects: KoebeDefects::of(&mesh, &face_poles),
        mesh,
        face_poles,
        outcome,
    }
}

/// Where vertices are to be: at their normals and (for flat meshes) their places.
fn aims(input: &HexMesh, boundary: BoundaryCondition) -> PerVertex<Vec3> {
    if boundary == BoundaryCondition::Sphere {
        return input.positions.clone();
    }
    let n = input.positions.len();
    let centre = input.positions.iter().sum::<Vec3>() / n as f64;
    let radius = input
        .positions
        .iter()
        .map(|p| (p - centre).norm())
        .fold(0.0, f64::max);
    let scale = if radius > 0.0 { 1.0 / radius } else { 0.0 };
    PerVertex::from_fn(n, |v| {
        input.mean_normal(v) + (input.position(v) - centre) * scale
    })
}

/// The rotation that brings vertices closest to where they are to be; the identity if that does not
/// say.
fn rotation_towards(aims: &PerVertex<Vec3>, vertices: &PerVertex<Vec3>) -> Matrix3<f64> {
    let pairs = aims.iter().zip(vertices);
    let terms = pairs.map(|(aim, x)| aim * x.normalize().transpose());
    let correlation = terms.sum::<Matrix3<f64>>() / vertices.len() as f64;
    nearest_rotation(&correlation).unwrap_or_else(Matrix3::identity)
}

/// The rotation `R` with the largest trace of `R^T C`; `None` if it is not unique.
fn nearest_rotation(correlation: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = correlation.try_svd(true, true, f64::EPSILON, 1000)?;
    let (u, v_t) = (svd.u?, svd.v_t?);
    if svd.singular_values[1].is_nan() || svd.singular_values[1] < 1e-9 {
        return None;
    }
    let mut sign = Matrix3::identity();
    sign[(2, 2)] = (u * v_t).determinant().signum();
    Some(u * sign * v_t)
}

#[cfg(test)]
mod tests;
