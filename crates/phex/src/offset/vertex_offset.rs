//! Vertex-distance offset: a mesh parallel to `M` with its vertices on the unit sphere.
//!
//! The line through a vertex `x'_i` of the sphere along an edge `e` meets the sphere again at the
//! reflected point `x'_j = x'_i - 2 (x'_i . e) e`. So one start determines all vertices along a
//! spanning tree; the other edges must close: `(H_e R_i - R_j) x'_0 = 0` with the reflections `H_e`
//! and their products `R`. On a simply connected mesh whose faces are even and satisfy the angle
//! condition they all do, for every start, and the start is free: it is chosen so that the
//! spherical mesh faces the way of the normals. Elsewhere the start minimises the sum of squares of
//! what fails to close; what remains is the *holonomy*, measured and reported.
//!
//! | loops that are no faces | starts that close |
//! |---|---|
//! | none (a disc or a sphere) | all |
//! | one (an annulus) | the axis of its rotation, since an even number of reflections is one; so this is always possible, but it may not face the normals |
//! | two of a torus | the common axis, since its two rotations commute; it may not face the normals |
//! | more | none, except where the positions were made for it |
//!
//! Round an odd face an odd number of reflections must bring a vertex back: their product is one
//! reflection, so the vertex lies in its mirror plane, and each odd face leaves a circle of starts.
//! Two circles meet in a pair of antipodes; three or more do not meet, except where the positions
//! were made for it: `optimise::satisfy_angle_condition` does that, for odd faces and for loops,
//! with a start that faces the normals. An odd face on the boundary leaves one of its boundary
//! edges free to turn in the plane of the face, and that edge of an offset is not parallel.

use super::angle_condition::{AngleCondition, angle_conditions};
use super::face_offset::{MOST_AT_BOUNDARY, check_planar_mesh, face_normals};
use super::gauss_image::{GaussImage, OffsetKind};
use super::{OffsetError, OffsetOptions};
use crate::optimise::{free_edges, middle_vertex};
use nalgebra::{Matrix3, SymmetricEigen};
use phex_mesh::{
    EdgeId, FaceId, ForestStep, HexMesh, PerEdge, PerVertex, Topology, Vec3, spanning_forest,
};
use serde::Serialize;

/// What fails to close, and why it may.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Holonomy {
    /// Largest distance, on the unit sphere, by which an edge fails to close.
    pub defect: f64,
    /// The edge where that is.
    pub edge: EdgeId,
    /// Independent loops of the mesh that are not boundaries of faces: 0 for a disc, 1 for an
    /// annulus, 2 for a torus.
    pub loops: usize,
    /// Faces with an odd number of corners that have no boundary edge.
    pub odd_faces: usize,
    /// Dimension of the space of starts that close: 3 is free.
    pub starts: usize,
}

/// A mesh inscribed in the unit sphere, as parallel as it can be.
#[derive(Clone, Debug)]
pub struct SphericalMesh {
    /// The Gauss image; its vertices lie on the unit sphere.
    pub image: GaussImage,
    /// What fails to close.
    pub holonomy: Holonomy,
    /// Least cosine between a vertex of the Gauss image and the mean normal of the faces there.
    /// Where it is not positive vertices move along the surface or to the other side of it.
    pub facing: f64,
    /// Boundary edges that were left free to turn in the plane of their odd face.
    pub free_edges: Vec<EdgeId>,
}

/// The Gauss image whose vertices lie on the unit sphere.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::offset::{OffsetOptions, vertex_gauss_image};
///
/// let found = vertex_gauss_image(&cube, &OffsetOptions::default())?;
/// assert!(found.image.positions.iter().all(|p| (p.norm() - 1.0).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the mesh is not planar with vertices of degree 3, if a face does not satisfy the angle
/// condition, or if the reflections do not close up.
pub fn vertex_gauss_image(
    mesh: &HexMesh,
    options: &OffsetOptions,
) -> Result<SphericalMesh, OffsetError> {
    check_planar_mesh(mesh, &options.validity, MOST_AT_BOUNDARY)?;
    check_angles(mesh, options.angle)?;
    let spherical = spherical_mesh(mesh)?;
    let holonomy = spherical.holonomy;
    if holonomy.defect > options.closing {
        return Err(OffsetError::Holonomy {
            edge: holonomy.edge,
            defect: holonomy.defect,
            loops: holonomy.loops,
            odd_faces: holonomy.odd_faces,
        });
    }
    Ok(spherical)
}

/// Checks the angle condition of every even face.
///
/// # Errors
/// Names the face that is farthest from satisfying it, if that is more than `tolerance` (radians).
pub fn check_angles(mesh: &HexMesh, tolerance: f64) -> Result<(), OffsetError> {
    let holds = |c: &AngleCondition| c.defect.abs() <= tolerance;
    let failing: Vec<AngleCondition> = angle_conditions(mesh)
        .into_iter()
        .filter(|c| !holds(c))
        .collect();
    let farther = |a: &AngleCondition, b: &AngleCondition| {
        a.defect
            .abs()
            .total_cmp(&b.defect.abs())
            .then(b.face.cmp(&a.face))
    };
    match failing.iter().copied().max_by(farther) {
        Some(worst) => Err(OffsetError::AngleCondition {
            face: worst.face,
            defect: worst.defect,
            count: failing.len(),
        }),
        None => Ok(()),
    }
}

/// Reflects along the edges, whether or not they close; the holonomy tells.
///
/// # Errors
/// If the mesh has several components or a face without area.
pub fn spherical_mesh(mesh: &HexMesh) -> Result<SphericalMesh, OffsetError> {
    check_connected(mesh)?;
    let topology = mesh.topology();
    let normals = vertex_directions(mesh)?;
    let free_edges: Vec<EdgeId> = free_edges(mesh).into_iter().map(|(_, e)| e).collect();
    let tree = SpanningTree::new(mesh, &free_edges);
    let products = tree.products(mesh);
    let (start, starts) = tree.best_start(mesh, &products, &normals);
    let positions = tree.reflected(mesh, start);
    let (edge, defect) = tree.largest_defect(mesh, &positions);
    let cosines = positions
        .iter()
        .zip(&normals)
        .map(|(x, n)| x.dot(n) / n.norm());
    let facing = cosines.fold(f64::INFINITY, f64::min);
    let inside = |f: &FaceId| !topology.is_boundary_face(*f);
    Ok(SphericalMesh {
        holonomy: Holonomy {
            defect,
            edge,
            loops: n_loops(topology),
            odd_faces: odd_faces(topology).filter(inside).count(),
            starts,
        },
        image: GaussImage {
            kind: OffsetKind::Vertex,
            positions,
        },
        facing,
        free_edges,
    })
}

/// Checks that the mesh is one piece.
pub(super) fn check_connected(mesh: &HexMesh) -> Result<(), OffsetError> {
    match mesh.topology().components().1 {
        1 => Ok(()),
        components => Err(OffsetError::Components { components }),
    }
}

/// First Betti number of a connected mesh.
fn n_loops(topology: &Topology) -> usize {
    let closed = i64::from(topology.is_closed());
    usize::try_from(1 + closed - topology.euler_characteristic()).unwrap_or(0)
}

fn odd_faces(topology: &Topology) -> impl Iterator<Item = FaceId> + '_ {
    topology.faces().filter(|&f| topology.valence(f) % 2 == 1)
}

/// Sums of the unit normals of the faces at each vertex.
pub(super) fn vertex_directions(mesh: &HexMesh) -> Result<PerVertex<Vec3>, OffsetError> {
    let topology = mesh.topology();
    let normals = face_normals(mesh)?;
    let sum = |v| topology.faces_at(v).map(|f| normals[f]).sum();
    Ok(PerVertex::from_fn(topology.n_vertices(), sum))
}

/// Edges along which the start is reflected to every vertex, breadth first, and the edges that must
/// then close.
struct SpanningTree {
    branches: Vec<ForestStep>,
    closing: Vec<EdgeId>,
}

impl SpanningTree {
    fn new(mesh: &HexMesh, free_edges: &[EdgeId]) -> Self {
        let topology = mesh.topology();
        let mut usable = PerEdge::filled(topology.n_edges(), true);
        free_edges.iter().for_each(|&e| usable[e] = false);
        // From the middle, so that the tree is shallow and rounding adds up less.
        let branches = spanning_forest(topology, [middle_vertex(mesh)], |e| usable[e]);
        branches.iter().for_each(|b| usable[b.edge] = false);
        Self {
            branches,
            closing: topology.edges().filter(|&e| usable[e]).collect(),
        }
    }

    /// Products of reflections from the root to every vertex.
    fn products(&self, mesh: &HexMesh) -> PerVertex<Matrix3<f64>> {
        let mut products = PerVertex::filled(mesh.topology().n_vertices(), Matrix3::identity());
        for branch in &self.branches {
            products[branch.to] = reflection(mesh, branch.edge) * products[branch.from];
        }
        products
    }

    /// The unit vector that closes best and, among equals, faces the normals best; and the
    /// dimension of the choice.
    fn best_start(
        &self,
        mesh: &HexMesh,
        products: &PerVertex<Matrix3<f64>>,
        normals: &PerVertex<Vec3>,
    ) -> (Vec3, usize) {
        let wish: Vec3 = products.iter().zip(normals).map(|(r, n)| r.tr_mul(n)).sum();
        let mut squares = Matrix3::zeros();
        for &edge in &self.closing {
            let [i, j] = mesh.topology().edge_vertices(edge);
            let gap = reflection(mesh, edge) * products[i] - products[j];
            squares += gap.tr_mul(&gap);
        }
        closest_in_null_space(squares / self.closing.len().max(1) as f64, wish)
    }

    fn reflected(&self, mesh: &HexMesh, start: Vec3) -> PerVertex<Vec3> {
        let mut positions = PerVertex::filled(mesh.topology().n_vertices(), start);
        for branch in &self.branches {
            let image = reflection(mesh, branch.edge) * positions[branch.from];
            positions[branch.to] = image.normalize();
        }
        positions
    }

    /// The closing edge that fails most, and by how much; the first edge and 0 if there is none.
    fn largest_defect(&self, mesh: &HexMesh, positions: &PerVertex<Vec3>) -> (EdgeId, f64) {
        let mut largest = (EdgeId::new(0), 0.0);
        for &edge in &self.closing {
            let [i, j] = mesh.topology().edge_vertices(edge);
            let defect = (reflection(mesh, edge) * positions[i] - positions[j]).norm();
            if defect > largest.1 {
                largest = (edge, defect);
            }
        }
        largest
    }
}

/// Root mean square of a closing defect below which a direction counts as closing.
const CLOSES: f64 = 1e-9;

/// The unit vector nearest to `wish` in the null space of a positive semidefinite matrix, and its
/// dimension; where that is 0, the eigenvector of the least eigenvalue on the side of `wish`.
fn closest_in_null_space(squares: Matrix3<f64>, wish: Vec3) -> (Vec3, usize) {
    let eigen = SymmetricEigen::new(squares);
    let values = eigen.eigenvalues;
    let closes = |k: &usize| values[*k] <= CLOSES * CLOSES;
    let axis = |k: usize| eigen.eigenvectors.column(k).into_owned();
    let null: Vec<usize> = (0..3).filter(closes).collect();
    let projected: Vec3 = null.iter().map(|&k| axis(k) * axis(k).dot(&wish)).sum();
    let least = axis(values.imin());
    let fallback = if least.dot(&wish) < 0.0 {
        -least
    } else {
        least
    };
    let start = projected.try_normalize(1e-12 * wish.norm());
    (start.unwrap_or(fallback), null.len())
}

/// `I - 2 e e^T` for the unit vector `e` along an edge.
fn reflection(mesh: &HexMesh, edge: EdgeId) -> Matrix3<f64> {
    let e = mesh.edge_vector(edge).normalize();
    Matrix3::identity() - e * e.transpose() * 2.0
}
