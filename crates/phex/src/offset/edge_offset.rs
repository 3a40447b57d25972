//! Offsets at constant edge distance, and the curvature that goes with them.
//!
//! If the edges of `K` touch the unit sphere (a Koebe mesh) and `M` is parallel to `K`, every edge
//! of `M_d = M + d K` has the distance `|d|` from its edge of `M`. Face by face the area of the
//! offset is the polynomial of Steiner,
//!
//! ```text
//! A(M_d) = A(M) + 2 d A(M, K) + d^2 A(K) = A(M) (1 - 2 d H + d^2 G),
//! ```
//!
//! with the mixed area `A(., .)`: it defines the mean curvature `H` and the Gauss curvature `G` of
//! a face. Source: Pottmann, Liu, Wallner, Bobenko, Wang, "Geometry of multi-layer freeform
//! structures for architecture" (2007), section 4.
//!
//! *Guaranteed*: distances to rounding, for `M` and `K` that are parallel to rounding. *Fails*:
//! never; a mesh of other connectivity is a mistake of the program and panics.

use phex_mesh::{FaceId, FacePlane, HexMesh, PerEdge, PerFace, PerVertex, Vec3};

/// `M + d K`.
///
/// ```
/// # use phex_mesh::{HexMesh, Vec3};
/// # let corner = |k: u32| Vec3::new((k & 1) as f64, (k >> 1 & 1) as f64, (k >> 2) as f64);
/// # let faces = [
/// #     [0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
/// # ];
/// # let cube = HexMesh::new((0..8).map(corner).collect(), &faces)?;
/// use phex::Silent;
/// use phex::koebe::{KoebeOptions, koebe};
/// use phex::offset::{edge_distances, edge_offset};
///
/// let koebe = koebe(&cube, &KoebeOptions::default(), &Silent)?.mesh;
/// let layer = edge_offset(&koebe, &koebe, 0.2);
/// let distances = edge_distances(&koebe, &layer);
/// assert!(distances.iter().all(|d| (d - 0.2).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If the numbers of vertices differ.
pub fn edge_offset(mesh: &HexMesh, gauss_image: &HexMesh, distance: f64) -> HexMesh {
    assert_eq!(
        mesh.positions.len(),
        gauss_image.positions.len(),
        "one connectivity"
    );
    let moved = |v| mesh.position(v) + gauss_image.position(v) * distance;
    mesh.with_positions(PerVertex::from_fn(mesh.positions.len(), moved))
}

/// Distance of each edge of `other` from its edge of `mesh`, to which it is parallel.
///
/// # Panics
/// If `other` has fewer edges.
pub fn edge_distances(mesh: &HexMesh, other: &HexMesh) -> PerEdge<f64> {
    let t = mesh.topology();
    PerEdge::from_fn(t.n_edges(), |e| {
        let [a, _] = t.edge_vertices(e);
        let along = mesh.edge_vector(e).normalize();
        (other.position(a) - mesh.position(a)).cross(&along).norm()
    })
}

/// Mean and Gauss curvature of a face with respect to a Gauss image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceCurvature {
    /// `H = -A(M, K) / A(M)`; negative for a convex face whose normal points outwards.
    pub mean: f64,
    /// `G = A(K) / A(M)`.
    pub gauss: f64,
}

/// Curvatures of each face of `mesh`, which is parallel to `gauss_image`.
///
/// # Panics
/// If the connectivity differs.
pub fn face_curvatures(mesh: &HexMesh, gauss_image: &HexMesh) -> PerFace<FaceCurvature> {
    PerFace::from_fn(mesh.topology().n_faces(), |f| {
        face_curvature(mesh, gauss_image, f)
    })
}

fn face_curvature(mesh: &HexMesh, gauss_image: &HexMesh, f: FaceId) -> FaceCurvature {
    let [own, mixed, image] = face_areas(mesh, gauss_image, f);
    FaceCurvature {
        mean: -mixed / own,
        gauss: image / own,
    }
}

/// Mean curvature of the whole mesh, `-sum A(M, K) / sum A(M)`, and the root mean square (by area)
/// of the faces' deviation from it, over its size.
pub(crate) fn mean_curvature(mesh: &HexMesh, gauss_image: &HexMesh) -> (f64, f64) {
    let faces = || {
        mesh.topology()
            .faces()
            .map(|f| face_areas(mesh, gauss_image, f))
    };
    let (area, mixed) = faces().fold((0.0, 0.0), |sum, [own, mixed, _]| {
        (sum.0 + own, sum.1 + mixed)
    });
    let mean = -mixed / area;
    let square: f64 = faces()
        .map(|[own, mixed, _]| own * (-mixed / own - mean).powi(2))
        .sum();
    (mean, (square / area).sqrt() / mean.abs())
}

/// `A(M)`, `A(M, K)` and `A(K)` of a face.
pub(super) fn face_areas(mesh: &HexMesh, gauss_image: &HexMesh, f: FaceId) -> [f64; 3] {
    let (p, q): (Vec<Vec3>, Vec<Vec3>) =
        (mesh.corners(f).collect(), gauss_image.corners(f).collect());
    let normal = FacePlane::fit(&q).normal;
    [
        mixed_area(&p, &p, normal),
        mixed_area(&p, &q, normal),
        mixed_area(&q, &q, normal),
    ]
}

/// Derivative of `A(x, Q)` by the corners `x` of a face of a plane with the given normal.
pub(super) fn mixed_area_gradient(q: &[Vec3], normal: Vec3) -> impl Iterator<Item = Vec3> + '_ {
    let n = q.len();
    (0..n).map(move |i| 0.25 * (q[(i + 1) % n] - q[(i + n - 1) % n]).cross(&normal))
}

/// Mixed area of two parallel polygons of a plane; that of a polygon with itself is its area.
fn mixed_area(p: &[Vec3], q: &[Vec3], normal: Vec3) -> f64 {
    let n = p.len();
    let [p0, q0] = [p[0], q[0]];
    let term = |i: usize| {
        let j = (i + 1) % n;
        (p[i] - p0).cross(&(q[j] - q0)) + (q[i] - q0).cross(&(p[j] - p0))
    };
    0.25 * (0..n).map(term).sum::<Vec3>().dot(&normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(size: Vec3) -> HexMesh {
        let corner =
            |i: u32| Vec3::from_fn(|k, _| if i >> k & 1 == 1 { size[k] } else { -size[k] });
        let faces: [[u32; 4]; 6] = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        HexMesh::new((0..8).map(corner).collect(), &faces).unwrap()
    }

    #[test]
    fn brick_follows_steiner() {
        // The Koebe cube: edges at distance 1 from the centre.
        let koebe = cube(Vec3::repeat(std::f64::consts::FRAC_1_SQRT_2));
        let brick = cube(Vec3::new(1.0, 2.0, 3.0));
        let offset = edge_offset(&brick, &koebe, -0.25);
        assert!(
            edge_distances(&brick, &offset)
                .iter()
                .all(|d| (d - 0.25).abs() < 1e-15)
        );
        let area = |m: &HexMesh, f| {
            mixed_area(
                &m.corners(f).collect::<Vec<_>>(),
                &m.corners(f).collect::<Vec<_>>(),
                FacePlane::of(m, f).normal,
            )
        };
        for (f, c) in face_curvatures(&brick, &koebe).enumerate() {
            let expected = area(&brick, f) * (1.0 - 2.0 * -0.25 * c.mean + 0.0625 * c.gauss);
            assert!((area(&offset, f) - expected).abs() < 1e-13 && c.mean < 0.0);
        }
    }
}
