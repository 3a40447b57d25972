//! Patches: what is given at the boundary, and where on the sphere the pattern is put.

use super::circles::Circles;
use super::layout::{PlaneCircle, PlaneLayout};
use super::radii::Radii;
use super::sphere::SphereCircles;
use super::{BoundaryCondition, KoebeError, KoebeOptions};
use crate::curvature::turn_to_pole;
use phex_mesh::polygon::interior_angles;
use phex_mesh::{EdgeId, FacePlane, HexMesh, PerVertex, Topology, Vec2, Vec3, VertexId};
use std::f64::consts::{PI, TAU};

/// Unknown radii with what is given at the boundary.
pub(super) fn radii(
    circles: &Circles,
    mesh: &HexMesh,
    options: &KoebeOptions,
) -> Result<Radii, KoebeError> {
    let on_boundary = |node| {
        circles
            .vertex(node)
            .filter(|&v| circles.topology.is_boundary_vertex(v))
    };
    match options.boundary {
        BoundaryCondition::EqualRadii => {
            Ok(Radii::new(circles, |node| on_boundary(node).map(|_| 0.0)))
        }
        BoundaryCondition::GaussImage | BoundaryCondition::Sphere => {
            let given = boundary_radii(mesh, options.boundary)?;
            Ok(Radii::new(circles, |node| {
                on_boundary(node).map(|v| given[v].ln())
            }))
        }
        BoundaryCondition::Angles => {
            let mut radii = Radii::new(circles, |_| None);
            for (v, angle) in boundary_angles(mesh) {
                radii.target_angle[circles.of_vertex(v)] = angle;
            }
            radii.fix_scale();
            Ok(radii)
        }
    }
}

/// The pattern on the sphere, about the north pole.
pub(super) fn project(
    circles: &Circles,
    layout: &PlaneLayout,
    mesh: &HexMesh,
    options: &KoebeOptions,
) -> SphereCircles {
    let (origin, factor) = match options.boundary {
        BoundaryCondition::GaussImage | BoundaryCondition::Sphere => {
            similarity_to_gauss_image(circles, layout, &gauss_image(mesh, options.boundary))
        }
        _ => centred(circles.topology, layout, options.opening.to_radians()),
    };
    SphereCircles::project(layout, origin, factor)
}

/// The mean of the boundary to the pole, its mean distance to the opening.
fn centred(t: &Topology, layout: &PlaneLayout, opening: f64) -> (Vec2, Vec2) {
    let edges = t.edges().filter(|&e: &EdgeId| t.is_boundary_edge(e));
    let points: Vec<Vec2> = edges.filter_map(|e| layout.touching[e]).collect();
    let count = points.len() as f64;
    let origin = points.iter().sum::<Vec2>() / count;
    let distance = points.iter().map(|p| (p - origin).norm()).sum::<f64>() / count;
    (origin, Vec2::new((0.5 * opening).tan() / distance, 0.0))
}

/// Normals of the vertices in the plane: projected from the pole opposite to their mean.
fn gauss_image(mesh: &HexMesh, boundary: BoundaryCondition) -> PerVertex<Vec2> {
    let normal = |v| match boundary {
        BoundaryCondition::Sphere => mesh.position(v),
        _ => mesh.mean_normal(v),
    };
    let normals: Vec<Vec3> = mesh.topology().vertices().map(normal).collect();
    let mean: Vec3 = normals.iter().sum();
    let turn = turn_to_pole(&mean);
    let project = |n: &Vec3| {
        let n = turn * n;
        Vec2::new(n.x, n.y) / (1.0 + n.z).max(f64::EPSILON)
    };
    PerVertex::from_vec(normals.iter().map(project).collect())
}

/// Half the mean length of the boundary edges at each boundary vertex of the Gauss image.
fn boundary_radii(
    mesh: &HexMesh,
    boundary: BoundaryCondition,
) -> Result<PerVertex<f64>, KoebeError> {
    let image = gauss_image(mesh, boundary);
    let mut radii = PerVertex::filled(image.len(), 1.0);
    for boundary in mesh.topology().boundary_loops() {
        let n = boundary.len();
        let length = |i: usize| (image[boundary[(i + 1) % n]] - image[boundary[i % n]]).norm();
        let mean = (0..n).map(length).sum::<f64>() / n as f64;
        for i in 0..n {
            let radius = 0.25 * (length(i) + length(i + n - 1));
            if radius.is_nan() || radius <= 1e-6 * mean || mean < 1e-9 {
                return Err(KoebeError::NoGaussImage {
                    vertex: boundary[i],
                });
            }
            radii[boundary[i]] = radius;
        }
    }
    Ok(radii)
}

/// The similarity, orientation kept, that brings the circles of the vertices closest to the Gauss
/// image: origin, and factor as a complex number.
fn similarity_to_gauss_image(
    circles: &Circles,
    layout: &PlaneLayout,
    image: &PerVertex<Vec2>,
) -> (Vec2, Vec2) {
    let pairs: Vec<(Vec2, Vec2)> = image
        .enumerate()
        .filter_map(|(v, &aim)| match layout.circles[circles.of_vertex(v)] {
            PlaneCircle::Circle { centre, .. } => Some((centre, aim)),
            PlaneCircle::HalfPlane { .. } => None,
        })
        .collect();
    let n = pairs.len() as f64;
    let mean: Vec2 = pairs.iter().map(|p| p.0).sum::<Vec2>() / n;
    let aim: Vec2 = pairs.iter().map(|p| p.1).sum::<Vec2>() / n;
    let (mut factor, mut size) = (Vec2::zeros(), 0.0);
    for (z, w) in &pairs {
        let (z, w) = (z - mean, w - aim);
        factor += Vec2::new(z.dot(&w), z.perp(&w));
        size += z.norm_squared();
    }
    let factor = factor / size;
    // The point that goes to 0: mean - aim / factor.
    let back = Vec2::new(factor.dot(&aim), factor.perp(&aim)) / factor.norm_squared();
    (mean - back, factor)
}

/// Angles of the input at its boundary vertices, with their sum made that of a flat disc.
fn boundary_angles(mesh: &HexMesh) -> Vec<(VertexId, f64)> {
    let t = mesh.topology();
    let mut angle = PerVertex::filled(t.n_vertices(), 0.0);
    for f in t.faces() {
        let corners: Vec<Vec3> = mesh.corners(f).collect();
        let plane = FacePlane::fit(&corners);
        let polygon: Vec<Vec2> = corners.iter().map(|&p| plane.project(p)).collect();
        for (&v, a) in t.face_vertices(f).iter().zip(interior_angles(&polygon)) {
            angle[v] += a;
        }
    }
    let boundary: Vec<VertexId> = t.boundary_vertices().collect();
    let full = (t.n_vertices() - boundary.len() + t.n_faces()) as f64;
    let due = PI * t.n_half_edges() as f64 - TAU * full;
    let sum: f64 = boundary.iter().map(|&v| angle[v]).sum();
    let share = (due - sum) / boundary.len() as f64;
    boundary
        .into_iter()
        .map(|v| (v, angle[v] + share))
        .collect()
}
