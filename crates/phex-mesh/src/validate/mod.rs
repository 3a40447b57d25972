//! Is a mesh valid? What is wrong with it, and where?
//!
//! A valid mesh has planar, simple faces, three faces at each interior vertex, and lies like a
//! surface: no face is flipped, no vertex is covered twice, no edge passes through another face.
//! That it is an oriented manifold is already implied by [`HexMesh`]. Short edges, narrow necks and
//! sharp folds are violations of tolerances, which do not make it invalid.
//! Self-intersection is decided by exact predicates on the given coordinates.
//!
//! A [`ValidHexMesh`] is made by [`validate`] and nowhere else.

mod crossings;
mod violation;

pub use violation::{FlipReference, Violation};

use crate::polygon::{interior_angles, is_simple, sides};
use crate::{
    EdgeId, FaceId, FlatFace, HexMesh, PerFace, SurfacePoint, TriangleSurface, Vec3, VertexId,
};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::fmt;
use std::ops::Deref;

/// Limits for [`violations`] and [`validate`]. Lengths are relative to the mesh's mean edge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ValidateOptions {
    /// Largest distance of a vertex to the least-squares plane of its face, in mean edges; at least
    /// 0, and held as it is given. Default `None`: 1e-12 (a nanometre on a panel of a kilometre, so
    /// "exactly planar"), or [`planarity_floor`] where rounding of the coordinates allows no less
    /// than that.
    pub planarity: Option<f64>,
    /// Smallest edge length, in mean edges; at least 0. Default 0.05: shorter edges can't be built,
    /// and dihedral angles and offsets there are badly determined.
    pub edge_length_rel: f64,
    /// Smallest distance, in the plane of a face, of a vertex to an edge of the face that does not
    /// hold it, in mean edges; at least 0. Default 0.05, as for edges: a narrower neck breaks.
    pub clearance: f64,
    /// Smallest distance of an interior angle to 0 and to 2 pi, in radians; at least 0. Default
    /// 1e-9: only corners that fold back on themselves up to rounding; sharp ones are caught by the
    /// clearance.
    pub corner_angle: f64,
}

impl ValidateOptions {
    /// The default of [`clearance`](Self::clearance).
    pub const CLEARANCE: f64 = 0.05;
}

impl Default for ValidateOptions {
    fn default() -> Self {
        Self {
            planarity: None,
            edge_length_rel: 0.05,
            clearance: Self::CLEARANCE,
            corner_angle: 1e-9,
        }
    }
}

/// The limit of planarity, in mean edges, where none is given and coordinates are fine enough for
/// it.
const PLANAR: f64 = 1e-12;

impl ValidateOptions {
    /// The limit of planarity for a mesh, in mean edges: what is asked for, or else 1e-12 or
    /// rounding, whichever is larger.
    pub fn planarity_limit(&self, mesh: &HexMesh) -> f64 {
        let exact = || PLANAR.max(planarity_floor(mesh));
        self.planarity.unwrap_or_else(exact)
    }
}

/// Cosines this close to 0 belong to a right angle: rounding must not make a cube fold.
const RIGHT_ANGLE: f64 = 1e-9;

/// The planarity, in mean edges, that rounding of the coordinates allows at best: 4 machine
/// epsilons times the diagonal of the bounding box (or the largest coordinate, for a mesh far from
/// the origin) over the mean edge.
pub fn planarity_floor(mesh: &HexMesh) -> f64 {
    let largest = mesh.positions.iter().map(|p| p.amax()).fold(0.0, f64::max);
    4.0 * f64::EPSILON * mesh.diagonal().max(largest) / mesh.mean_edge()
}

/// A mesh in which [`validate`] found nothing that makes it invalid. It cannot be changed.
#[derive(Clone, Debug, PartialEq)]
pub struct ValidHexMesh {
    mesh: HexMesh,
}

impl ValidHexMesh {
    /// Gives up the guarantee.
    pub fn into_inner(self) -> HexMesh {
        self.mesh
    }
}

impl Deref for ValidHexMesh {
    type Target = HexMesh;
    fn deref(&self) -> &HexMesh {
        &self.mesh
    }
}

/// A mesh that is not valid, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Invalid {
    /// The mesh, as it was given.
    pub mesh: Box<HexMesh>,
    /// What is wrong with it; at least one, those that make it invalid first.
    pub violations: Vec<Violation>,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(first) = self.violations.first() {
            let word = if first.is_decisive() {
                "valid"
            } else {
                "planar"
            };
            write!(f, "the mesh is not {word}: {first}")?;
        }
        match self.violations.len().saturating_sub(1) {
            0 => Ok(()),
            more => write!(f, " (and {more} more)"),
        }
    }
}

impl std::error::Error for Invalid {}

/// Wraps a mesh that is planar and has no violation that is decisive
/// ([`Violation::is_decisive`]).
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex_mesh::{ValidateOptions, VertexId, validate};
///
/// let options = ValidateOptions::default();
/// assert!(validate(cube.clone(), None, &options).is_ok());
///
/// let mut bent = cube.clone();
/// bent.positions[VertexId::new(7)].z += 0.1;
/// let refused = validate(bent, None, &options).unwrap_err();
/// assert!(refused.violations.iter().any(|v| v.kind() == "not_planar"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If it is not planar, or a violation is decisive; the mesh is given back with all violations.
pub fn validate(
    mesh: HexMesh,
    surface: Option<&TriangleSurface>,
    options: &ValidateOptions,
) -> Result<ValidHexMesh, Invalid> {
    let mut violations = violations(&mesh, surface, options);
    let refuses = |v: &Violation| v.is_decisive() || matches!(v, Violation::NotPlanar { .. });
    if !violations.iter().any(refuses) {
        return Ok(ValidHexMesh { mesh });
    }
    violations.sort_by_key(|v| (!v.is_decisive(), !refuses(v)));
    Err(Invalid {
        mesh: Box::new(mesh),
        violations,
    })
}

/// All violations of a mesh, by kind and then by element. With a surface, faces are also checked
/// against its normals. The same for any number of threads.
pub fn violations(
    mesh: &HexMesh,
    surface: Option<&TriangleSurface>,
    options: &ValidateOptions,
) -> Vec<Violation> {
    let finite = |v: &VertexId| mesh.position(*v).iter().all(|x| x.is_finite());
    let broken = mesh.topology().vertices().filter(|v| !finite(v));
    let mut found: Vec<Violation> = broken
        .map(|vertex| Violation::NotFinite { vertex })
        .collect();
    if !found.is_empty() {
        return found;
    }
    let inspection = Inspection::new(mesh, options);
    let topology = mesh.topology();
    found.extend(topology.faces().filter_map(|f| inspection.not_simple(f)));
    found.extend(topology.faces().filter_map(|f| inspection.not_planar(f)));
    found.extend(
        topology
            .edges()
            .filter_map(|e| inspection.collapsed_edge(e)),
    );
    found.extend(
        topology
            .faces()
            .filter_map(|f| inspection.small_clearance(f)),
    );
    found.extend(topology.faces().flat_map(|f| inspection.folded_corners(f)));
    found.extend(
        topology
            .vertices()
            .filter_map(|v| inspection.wrong_degree(v)),
    );
    found.extend(topology.vertices().filter_map(|v| inspection.wrong_fan(v)));
    found.extend(inspection.flipped_faces(surface));
    found.extend(topology.edges().filter_map(|e| inspection.fold(e)));
    found.extend(crossings::crossings(mesh, &inspection.faces));
    found
}

/// Adds the faces whose normals point against those of another surface than [`violations`] was
/// given: a smooth surface and the facets that it goes through may differ where two sheets are
/// nearer to each other than a face is long.
pub fn add_flips(found: &mut Vec<Violation>, mesh: &HexMesh, surface: &TriangleSurface) {
    let options = ValidateOptions::default();
    let inspection = Inspection::new(mesh, &options);
    let mut against = inspection.against_surface(surface, Below::Triangle);
    for violation in &*found {
        if let Violation::FlippedFace { face, .. } = violation {
            against[*face] = false;
        }
    }
    let faces = mesh.topology().faces().filter(|f| against[*f]);
    found.extend(faces.map(|face| Violation::FlippedFace {
        face,
        against: FlipReference::Surface,
    }));
}

/// A mesh with everything that the checks share. Comparisons are written so that a NaN is a
/// violation.
struct Inspection<'a> {
    mesh: &'a HexMesh,
    options: &'a ValidateOptions,
    faces: PerFace<FlatFace>,
    mean_edge: f64,
    planarity_limit: f64,
}

impl<'a> Inspection<'a> {
    fn new(mesh: &'a HexMesh, options: &'a ValidateOptions) -> Self {
        Self {
            mesh,
            options,
            faces: FlatFace::all(mesh),
            mean_edge: mesh.mean_edge(),
            planarity_limit: options.planarity_limit(mesh),
        }
    }

    fn not_simple(&self, face: FaceId) -> Option<Violation> {
        (!is_simple(&self.faces[face].polygon)).then_some(Violation::NotSimple { face })
    }

    fn not_planar(&self, face: FaceId) -> Option<Violation> {
        let (planarity, limit) = (
            self.faces[face].planarity_length / self.mean_edge,
            self.planarity_limit,
        );
        let planar = planarity <= limit;
        (!planar).then_some(Violation::NotPlanar {
            face,
            planarity,
            limit,
        })
    }

    fn collapsed_edge(&self, edge: EdgeId) -> Option<Violation> {
        let vertices = self.mesh.topology().edge_vertices(edge);
        let (length_rel, limit) = (
            self.mesh.edge_length(edge) / self.mean_edge,
            self.options.edge_length_rel,
        );
        let long_enough = length_rel >= limit;
        (!long_enough).then_some(Violation::CollapsedEdge {
            edge,
            vertices,
            length_rel,
            limit,
        })
    }

    fn small_clearance(&self, face: FaceId) -> Option<Violation> {
        let topology = self.mesh.topology();
        let closest = self.faces[face].clearance();
        let (clearance, limit) = (closest.distance / self.mean_edge, self.options.clearance);
        let vertex = topology.face_vertices(face)[closest.corner];
        let edge = topology
            .face_half_edges(face)
            .nth(closest.edge)
            .map(|h| topology.edge(h))?;
        let clear = clearance >= limit;
        (!clear).then_some(Violation::SmallClearance {
            face,
            vertex,
            edge,
            clearance,
            limit,
        })
    }

    fn folded_corners(&self, face: FaceId) -> impl Iterator<Item = Violation> {
        let limit = self.options.corner_angle;
        let vertices = self.mesh.topology().face_vertices(face);
        let corners = vertices
            .iter()
            .zip(interior_angles(&self.faces[face].polygon));
        let open = move |angle: f64| angle >= limit && TAU - angle >= limit;
        corners
            .filter(move |&(_, angle)| !open(angle))
            .map(move |(&vertex, angle)| Violation::FoldedCorner {
                face,
                vertex,
                angle,
                limit,
            })
    }

    fn wrong_degree(&self, vertex: VertexId) -> Option<Violation> {
        let topology = self.mesh.topology();
        let degree = topology.face_degree(vertex);
        let wrong = !topology.is_boundary_vertex(vertex) && degree != 3;
        wrong.then_some(Violation::WrongDegree { vertex, degree })
    }

    /// At the boundary what is beyond the panels takes the place of the third one.
    fn wrong_fan(&self, vertex: VertexId) -> Option<Violation> {
        let topology = self.mesh.topology();
        let faces: Vec<FaceId> = topology.faces_at(vertex).collect();
        let beyond = usize::from(topology.is_boundary_vertex(vertex));
        if faces.len() + beyond != 3 {
            return None;
        }
        let turns = self.turns(vertex, &faces);
        let once = (turns - 1.0).abs() <= 1e-6;
        (!once).then_some(Violation::WrongFan {
            vertex,
            faces,
            turns,
        })
    }

    /// How often the edges at a vertex go round it, seen along the mean normal of its faces.
    fn turns(&self, vertex: VertexId, faces: &[FaceId]) -> f64 {
        let mean: Vec3 = faces.iter().map(|&f| self.faces[f].normal()).sum();
        let [x, y] = axes_across(mean.try_normalize(0.0).unwrap_or_else(Vec3::z));
        let centre = self.mesh.position(vertex);
        let direction = |v: VertexId| {
            let d = self.mesh.position(v) - centre;
            d.dot(&y).atan2(d.dot(&x))
        };
        let neighbours = self.mesh.topology().neighbours(vertex);
        let directions: Vec<f64> = neighbours.into_iter().map(direction).collect();
        let angles = sides(&directions).map(|[a, b]| (b - a).rem_euclid(TAU));
        angles.sum::<f64>() / TAU
    }

    fn flipped_faces(&self, surface: Option<&TriangleSurface>) -> Vec<Violation> {
        let against_surface = surface.map(|s| self.against_surface(s, Below::Surface));
        let violation = |face| {
            let against = if self.is_against_neighbours(face) {
                FlipReference::Neighbours
            } else if against_surface.as_ref().is_some_and(|a| a[face]) {
                FlipReference::Surface
            } else {
                return None;
            };
            Some(Violation::FlippedFace { face, against })
        };
        self.mesh.topology().faces().filter_map(violation).collect()
    }

    fn is_against_neighbours(&self, face: FaceId) -> bool {
        let topology = self.mesh.topology();
        let beside = topology.adjacent_faces(face);
        let sum: Vec3 = beside.map(|f| self.faces[f].normal()).sum();
        self.faces[face].normal().dot(&sum) < -RIGHT_ANGLE
    }

    /// Whether each normal points against what is below the face's centre. A mesh that is wound the
    /// other way as a whole (in more than half of its faces) is taken as such.
    fn against_surface(&self, surface: &TriangleSurface, below: Below) -> PerFace<bool> {
        let centres: Vec<Vec3> = self.faces.iter().map(|f| f.plane.centre).collect();
        let feet = surface.closest_points(&centres);
        let pairs = || self.faces.iter().zip(&feet);
        let is_turned = |(f, p): (&FlatFace, &SurfacePoint)| {
            f.normal().dot(&surface.area_vector(p.triangle)) < 0.0
        };
        let turned = pairs().filter(|pair| is_turned(*pair)).count();
        let sign = match 2 * turned > self.faces.len() {
            true => -1.0,
            false => 1.0,
        };
        let is_against = |(f, p): (&FlatFace, &SurfacePoint)| {
            let normal = f.normal() * sign;
            let of_triangle = || {
                let mut nearest = surface.triangles_at(p).into_iter();
                nearest.any(|t| normal.dot(&surface.area_vector(t)) < 0.0)
            };
            let of_surface = || match below {
                Below::Triangle => true,
                Below::Surface => normal.dot(&p.normal) < 0.0,
            };
            of_surface() && of_triangle()
        };
        PerFace::from_vec(pairs().map(is_against).collect())
    }

    fn fold(&self, edge: EdgeId) -> Option<Violation> {
        let faces = self.mesh.topology().faces_beside(edge)?;
        let [a, b] = faces.map(|f| self.faces[f].normal());
        let angle = a.cross(&b).norm().atan2(a.dot(&b));
        (a.dot(&b) < -RIGHT_ANGLE).then_some(Violation::Fold { edge, faces, angle })
    }
}

/// What the normal of a face is compared with.
#[derive(Clone, Copy)]
enum Below {
    /// The triangle below its centre: each of them where that is over an edge or a vertex, so that
    /// rounding does not decide over a face above the ridge of a pleat.
    Triangle,
    /// That, and the normal that is interpolated from its vertices: needles of a smooth surface may
    /// have any normal by themselves.
    Surface,
}

/// Two unit vectors that form a right-handed frame with the unit vector `normal`.
fn axes_across(normal: Vec3) -> [Vec3; 2] {
    let helper = if normal.x.abs() < 0.8 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let first = normal.cross(&helper).normalize();
    [first, normal.cross(&first)]
}
